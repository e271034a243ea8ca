"""Inputs of the functions: scenes, next steps, options, certificates."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np

import izo_ref
from izo_ref import errors
from izo_ref.base.options import CHOICES, RULES
from validation.fuzz import contract
from validation.fuzz.arrays import Rng, changed, strange_value
from validation.fuzz.start import start_meets
from validation.fuzz.tables import is_ordinary, mixes_flags, number_of, table_of
from validation.fuzz.trial import Trial, Wrong

MakeCall: TypeAlias = Callable[[Rng], Trial]
THICKNESS_M = 0.01
EXACT_SHARE = 0.1  # of the scenes whose start is also decided in exact arithmetic
SIZES = (1.0, 1.0, 1.0, 1e-6, 1e6, 1e-150, 1e150, 1e-305, 1e302)


def step_arrays(rng: Rng) -> dict[str, Any]:
    """Return the arrays of a small step, which is valid but for where its mesh is."""
    n = int(rng.integers(3, 9))
    start = rng.integers(-4, 5, (n, 3)) / 2.0 if rng.random() < 0.3 else rng.normal(size=(n, 3))
    end = start + rng.normal(size=(n, 3)) * rng.choice((0.0, 0.1, 1.0))
    faces = [rng.choice(n, 3, replace=False) for _ in range(rng.integers(0, 4))]
    size = SIZES[rng.integers(len(SIZES))]
    arrays: dict[str, Any] = {
        "positions_t0": start * size,
        "positions_t1": end * size,
        "faces": np.array(faces, int).reshape(-1, 3),
    }
    if rng.random() < 0.3:
        arrays["masses"] = 10.0 ** rng.uniform(-3, 3, n)
    if rng.random() < 0.3:
        arrays["pinned"] = rng.random(n) < 0.3
    if rng.random() < 0.2:
        arrays["weld"] = float(rng.choice((0.0, 1e-9, 0.1)))
    modes = ("raise", "ratchet", "exclude")
    arrays["initial_intersections"] = modes[rng.choice(3, p=(0.5, 0.3, 0.2))]
    return arrays


def disturbed(rng: Rng, arguments: dict[str, Any], share: float = 0.8) -> dict[str, Any]:
    """Return arguments of which one or two are replaced or changed; as they are otherwise."""
    out = dict(arguments)
    if rng.random() > share:
        return out
    for _ in range(1 + (rng.random() < 0.15)):
        name = list(out)[rng.integers(len(out))]
        is_array = isinstance(out[name], np.ndarray) and rng.random() < 0.75
        out[name] = changed(rng, out[name]) if is_array else strange_value(rng)
    return out


def shown(arguments: dict[str, Any]) -> str:
    """Return arguments on one line, to be read by people."""
    texts = []
    for name, value in arguments.items():
        try:
            text = " ".join(repr(value).split())[:120]
        except Exception:
            text = f"a value of type {type(value).__name__}"
        texts.append(f"{name}={text}")
    return ", ".join(texts)


def scene_trial(rng: Rng) -> Trial:
    """Return a call of `Scene`."""
    arguments = disturbed(rng, step_arrays(rng))
    wrongs = contract.scene_wrongs(arguments)
    exact = rng.random() < EXACT_SHARE
    free = wrongs == [] and _is_plain(arguments)

    def call() -> Any:
        try:
            return izo_ref.Scene(**arguments)
        except errors.InitialIntersectionError as error:
            if not (free and exact) or _meets(arguments):
                return error
            raise
        except (errors.WeldError, errors.DegenerateFaceError) as error:
            if wrongs == [] and arguments.get("weld") is not None:
                return error  # welding has conditions of its own
            raise

    def judge(scene: Any) -> str:
        if isinstance(scene, Exception):
            return ""
        if free and exact and _meets(arguments):
            return "the start intersects"
        if arguments.get("weld") is None and not _same(scene.positions_t0, arguments):
            return "the positions are others"
        arrays = (scene.positions_t0, scene.positions_t1, scene.masses)
        return "" if all(map(is_finite, arrays)) else "a number is not finite"

    return Trial(call, wrongs, judge, f"Scene({shown(arguments)})")


def _is_plain(arguments: dict[str, Any]) -> bool:
    """Return whether every pair at the start counts, as in the plain mode without pins."""
    plain = arguments["initial_intersections"] == "raise" and arguments.get("weld") is None
    return plain and "pinned" not in arguments


def _meets(arguments: dict[str, Any]) -> bool:
    faces = np.asarray(arguments["faces"], float).astype(int).reshape(-1, 3).tolist()
    return start_meets(np.asarray(arguments["positions_t0"], float), faces)


def _same(positions: Any, arguments: dict[str, Any]) -> bool:
    table = table_of(arguments["positions_t0"])
    wanted = [number_of(item) for item in table.items] if table else None
    return positions.ravel().tolist() == wanted or (table is not None and mixes_flags(table))


def is_finite(array: Any) -> bool:
    """Return whether all numbers of an array are finite."""
    return bool(np.isfinite(array).all())


def hanging_step(rng: Rng, n_low: int = 1) -> izo_ref.Scene:
    """Return a step with a face, above which vertices fall through it."""
    n = int(rng.integers(n_low, 5))
    low = np.array([[-2.0, -2, 0], [2, -2, 0], [0, 3, 0]])
    high = np.column_stack((rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(0.1, 1.0, n)))
    start = np.concatenate((low, high))
    end = start - [0.0, 0, 1] * np.concatenate((np.zeros(3), rng.uniform(0.0, 2.0, n)))[:, None]
    pinned = np.arange(3 + n) < (3 if rng.random() < 0.5 else 0)
    masses = 10.0 ** rng.uniform(-2, 2, 3 + n)
    return izo_ref.Scene(start, end, [[0, 1, 2]], masses, pinned)


def result_problem(result: Any, scene: izo_ref.Scene) -> str:
    """Return what is wrong with a result, as far as the documentation promises numbers."""
    numbers = [result.positions, result.thickness, result.time_free, result.multipliers]
    numbers += [result.certificate.meeting_toi, result.impacts.weights, result.impacts.normals]
    if not all(map(is_finite, numbers)):
        return "a number of the result is not finite"
    if math.isnan(result.objective) or any(any(map(math.isnan, r)) for r in result.residuals):
        return "the objective or a residual is NaN"
    if (result.status is izo_ref.Status.FREE) > result.certificate.free:
        return "FREE without a free certificate"
    same = result.positions[scene.pinned] == scene.positions_t1[scene.pinned]
    return "" if same.all() else "a pinned vertex is elsewhere"


OPTION_VALUES: dict[str, tuple[Any, ...]] = {
    "max_iterations": (0, 1, 100, 2**53, 1.5),
    "relinearize": (0, 5, 10**30, -1),
    "relinearize_gain": (0.0, 1.0, 1e300),
    "relinearize_budget": (0.0, math.inf, math.nan),
    "max_steps": (0, 1, 100_000, 3.0),
    "small_zone": (0, 1, 256, 2**70),
    "gap_tolerance": (0, 1e-9, 1e300, math.inf, np.float32(1e-5), np.float16(1e-3)),
    "violation_tolerance": (0.0, 1e-9, 1e300, np.longdouble(1e-9)),
    "thickness_fraction": (1e-3, 0, 1.0, -1.0),
    "plan": ("needed", "everything", (), ("still",), ["still"], ("x",), None, 5),
}


def options_of(rng: Rng) -> dict[str, Any]:
    """Return arguments of `Options`, most of which are offered."""
    given = {}
    names = [*CHOICES, *OPTION_VALUES]
    for name in rng.choice(names, rng.integers(0, 4), replace=False).tolist():
        offered = tuple(CHOICES[name]) if name in CHOICES else OPTION_VALUES[name]
        given[name] = offered[rng.integers(len(offered))]
        if rng.random() < 0.15:
            given[name] = strange_value(rng)
    return given


def resolve_trial(rng: Rng) -> Trial:
    """Return a call of `resolve` with options, a thickness and other arguments."""
    scene, given = hanging_step(rng), options_of(rng)
    arguments: dict[str, Any] = {"thickness": THICKNESS_M}
    wrongs = contract.options_wrongs(given)
    if rng.random() < 0.2:
        arguments["thickness"] = strange_value(rng)
        if arguments["thickness"] is not None:
            wrong = contract.positive_wrong("thickness", arguments["thickness"])
            wrongs += [wrong] if wrong else []
    for name, offered in (("device", ("cpu",)), ("on_iteration", (None, print)), ("scene", ())):
        if rng.random() < 0.05:
            value = strange_value(rng)
            arguments[name] = value
            callable_ = name == "on_iteration" and (value is None or callable(value))
            known = name == "device" and isinstance(value, str) and value in (*offered, "auto")
            if not (callable_ or known):
                wrongs.append(Wrong(name))
            elif callable_ and value is not None:
                arguments[name] = None
    thickness: Any = arguments["thickness"]
    is_open = not wrongs and isinstance(thickness, (int, float)) and not 1e-60 < thickness < 1e50

    def call() -> Any:
        return izo_ref.resolve(**{"scene": scene, **arguments, "options": izo_ref.Options(**given)})

    what = f"resolve({shown(arguments)}, {shown(given)})"
    return Trial(call, None if is_open else wrongs, partial(result_problem, scene=scene), what)


def after_trial(rng: Rng) -> Trial:
    """Return a call of `Scene.after`."""
    scene = hanging_step(rng)
    n, others = len(scene.pinned), hanging_step(rng)
    result = izo_ref.resolve(scene, THICKNESS_M)
    end = result.positions + rng.normal(size=(n, 3)) * 0.05
    arguments = {"positions_t1": end, "masses": np.ones(n), "pinned": scene.pinned}
    arguments = disturbed(rng, arguments)
    found = [contract.real_wrong("positions_t1", arguments["positions_t1"], (n, 3))]
    pinned = scene.pinned.tolist()
    if arguments["pinned"] is not None:
        pinned = contract.flags_of(arguments["pinned"], n)
        found.append(Wrong("pinned") if pinned is None else None)
    if arguments["masses"] is not None and pinned is not None:
        found.append(contract.mass_wrong(arguments["masses"], n, pinned))
    if rng.random() < 0.2:
        choices = (strange_value(rng), izo_ref.resolve(others, THICKNESS_M), result.certificate)
        result = choices[rng.integers(3)]
        found.append(Wrong("result"))
    wrongs = [one for one in found if one is not None]
    table = table_of(arguments["positions_t1"])
    is_open = not wrongs and table is not None and not is_ordinary(table)
    is_open |= table is not None and mixes_flags(table)
    if is_open and not wrongs:
        return Trial(lambda: scene.after(result, **arguments), None, lambda _: "", shown(arguments))

    def judge(made: Any) -> str:
        return result_problem(izo_ref.resolve(made, THICKNESS_M), made)

    call: Callable[[], Any] = lambda: scene.after(result, **arguments)  # noqa: E731
    return Trial(call, wrongs, judge, f"after({shown(arguments)})")


def certify_trial(rng: Rng) -> Trial:
    """Return a call of `certify_path`."""
    scene = hanging_step(rng)
    arguments: dict[str, Any] = {"positions": scene.positions_t1, "rules": frozenset(RULES)}
    arguments = disturbed(rng, arguments)
    wrong = contract.real_wrong("positions", arguments["positions"], scene.positions_t0.shape)
    wrongs = [] if wrong is None else [wrong]
    rules = arguments["rules"]
    known = isinstance(rules, (set, frozenset)) and all(r in RULES for r in rules)
    wrongs += [] if known else [Wrong("rules")]
    table = table_of(arguments["positions"])
    is_open = table is not None and not (is_ordinary(table) and not mixes_flags(table))

    def judge(certificate: Any) -> str:
        times = [certificate.time_free, *certificate.meeting_toi]
        return "" if all(0.0 <= t <= 1.0 for t in times) else "a time is not from 0 to 1"

    what = f"certify_path({shown(arguments)})"
    call: Callable[[], Any] = lambda: izo_ref.certify_path(scene, **arguments)  # noqa: E731
    return Trial(call, None if is_open and not wrongs else wrongs, judge, what)
