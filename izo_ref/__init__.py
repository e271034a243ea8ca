"""izo_ref: reference and verification toolkit for impact zone optimization."""

from izo_ref.certify import PathCertificate, certify_path
from izo_ref.detect import find_impacts
from izo_ref.distance import distance_bound
from izo_ref.errors import IzoError
from izo_ref.options import Options
from izo_ref.plan import Plan, plan
from izo_ref.problem import Residuals, ZoneProblem, ZoneSolution, residuals
from izo_ref.resolve import Result, resolve
from izo_ref.scene import Scene
from izo_ref.solve import solve_zone
from izo_ref.types import Impacts, Pairs, Status
from izo_ref.version import __version__
from izo_ref.zones import Zones, build_zones, zone_problem

__all__ = [
    "Impacts",
    "IzoError",
    "Options",
    "Pairs",
    "PathCertificate",
    "Plan",
    "Residuals",
    "Result",
    "Scene",
    "Status",
    "ZoneProblem",
    "ZoneSolution",
    "Zones",
    "__version__",
    "build_zones",
    "certify_path",
    "distance_bound",
    "find_impacts",
    "plan",
    "residuals",
    "resolve",
    "solve_zone",
    "zone_problem",
]
