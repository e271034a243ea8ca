"""izo_ref: reference and verification toolkit for impact zone optimization.

The public names. Each is imported when it is first used, so that `import izo_ref` takes
milliseconds, and what needs the compiler its second only then.
"""

from importlib import import_module

from izo_ref.version import __version__

_NAMES = {
    "certify": ("PathCertificate", "certify_path"),
    "detect": ("find_impacts",),
    "distance": ("distance_bound",),
    "errors": ("IzoError",),
    "options": ("Options",),
    "planning": ("Plan", "plan"),
    "problem": ("Residuals", "ZoneProblem", "ZoneSolution", "residuals"),
    "resolving": ("Result", "resolve"),
    "scene": ("Scene",),
    "solve": ("solve_zone",),
    "types": ("Impacts", "Pairs", "Status"),
    "zones": ("Zones", "build_zones", "zone_problem"),
}
# No module has the name of a function: importing it would put the module in its place.
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names}

__all__ = ["__version__", "errors", *_MODULE_OF]


def __getattr__(name):
    if name == "errors":
        return import_module("izo_ref.errors")
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'izo_ref' has no attribute {name!r}")
    value = getattr(import_module(f"izo_ref.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})
