"""izo_ref: reference and verification toolkit for impact zone optimization.

The public names. Each is imported when it is first used, so that `import izo_ref` takes
milliseconds. The folders are the stages of the method; each says in its `__init__.py` what lives
there. Start reading with `loop/resolve.py`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from izo_ref.version import __version__

if TYPE_CHECKING:
    from izo_ref.base import errors
    from izo_ref.base.errors import IzoError
    from izo_ref.base.options import Options
    from izo_ref.base.records import (
        ExcludedPairs,
        Exclusion,
        Impacts,
        Pairs,
        PairState,
        Status,
        TouchingPairs,
    )
    from izo_ref.certificate.certify import PathCertificate, certify_path
    from izo_ref.detection.find import find_impacts
    from izo_ref.loop.keep_on_gpu import keep_on_gpu
    from izo_ref.loop.plan import Plan, plan
    from izo_ref.loop.resolve import Result, resolve
    from izo_ref.loop.simulation import GpuResult, GpuScene
    from izo_ref.scene import Scene
    from izo_ref.sequence.inspect import inspect_sequence
    from izo_ref.sequence.inspection import Inspection
    from izo_ref.sequence.resolve import Frame, resolve_sequence
    from izo_ref.solvers.solve import solve_zone
    from izo_ref.zones.distance import distance_bound
    from izo_ref.zones.grouping import Zones, build_zones
    from izo_ref.zones.problem import Residuals, ZoneProblem, ZoneSolution
    from izo_ref.zones.residuals import residuals
    from izo_ref.zones.system import zone_problem

__all__ = [
    "ExcludedPairs",
    "Exclusion",
    "Frame",
    "GpuResult",
    "GpuScene",
    "Impacts",
    "Inspection",
    "IzoError",
    "Options",
    "PairState",
    "Pairs",
    "PathCertificate",
    "Plan",
    "Residuals",
    "Result",
    "Scene",
    "Status",
    "TouchingPairs",
    "ZoneProblem",
    "ZoneSolution",
    "Zones",
    "__version__",
    "build_zones",
    "certify_path",
    "distance_bound",
    "errors",
    "find_impacts",
    "inspect_sequence",
    "keep_on_gpu",
    "plan",
    "residuals",
    "resolve",
    "resolve_sequence",
    "solve_zone",
    "zone_problem",
]

# The module of each name above; a test compares it with the imports that the type checker sees.
_MODULES = {
    "base": ("errors",),
    "base.errors": ("IzoError",),
    "base.options": ("Options",),
    "base.records": (
        "ExcludedPairs",
        "Exclusion",
        "Impacts",
        "PairState",
        "Pairs",
        "Status",
        "TouchingPairs",
    ),
    "certificate.certify": ("PathCertificate", "certify_path"),
    "detection.find": ("find_impacts",),
    "loop.keep_on_gpu": ("keep_on_gpu",),
    "loop.plan": ("Plan", "plan"),
    "loop.resolve": ("Result", "resolve"),
    "loop.simulation": ("GpuResult", "GpuScene"),
    "scene": ("Scene",),
    "sequence.inspect": ("inspect_sequence",),
    "sequence.inspection": ("Inspection",),
    "sequence.resolve": ("Frame", "resolve_sequence"),
    "solvers.solve": ("solve_zone",),
    "zones.distance": ("distance_bound",),
    "zones.grouping": ("Zones", "build_zones"),
    "zones.problem": ("Residuals", "ZoneProblem", "ZoneSolution"),
    "zones.residuals": ("residuals",),
    "zones.system": ("zone_problem",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'izo_ref' has no attribute {name!r}")
    module = import_module(f"izo_ref.{_MODULE_OF[name]}")
    value = import_module("izo_ref.base.errors") if name == "errors" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
