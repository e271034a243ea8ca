"""Kinds of trouble that are added to a step of a family; each takes a case and returns another."""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.options import LAGRANGIAN, PRESET_METHODS, RULES, SWEEPS
from validation.stability_steps.case import Case
from validation.stability_steps.meshes import power

Kind: TypeAlias = Callable[[np.random.Generator, Case], Case]

FEW_STEPS = 300  # of a first-order method on one zone: most do not converge in so many


def _plain(rng: np.random.Generator, case: Case) -> Case:
    """Add nothing, or a thickness that fits."""
    return case if case.thickness else case.change(thickness=power(rng, -5, -2))


def _scaled(rng: np.random.Generator, case: Case) -> Case:
    """Multiply all lengths by 2^-900 to 2^900, or by 1e-9 to 1e9, which rounds."""
    factor = 2.0 ** int(rng.integers(-900, 901)) if rng.random() < 0.5 else power(rng, -9, 9)
    thickness = case.thickness and case.thickness * factor
    return _mapped(case, lambda p: p * factor).change(thickness=thickness)


def _far(rng: np.random.Generator, case: Case) -> Case:
    """Move the step 1e3 to 1e12 of its size away from the origin."""
    shift = power(rng, 3, 12) * rng.normal(size=3) * (rng.random(3) < 0.7)
    return _mapped(case, lambda p: p + shift)


def _masses(rng: np.random.Generator, case: Case) -> Case:
    """Draw masses of ratios of up to 1e30, and no masses for pinned vertices."""
    n = len(case.positions_t0)
    ratio = power(rng, 0, 30)
    masses = power(rng, -20, 20) * ratio ** rng.random(n)
    if rng.random() < 0.3:
        masses = np.where(rng.random(n) < 0.5, 1.0, ratio)
    pinned = case.pinned if case.pinned is not None else rng.random(n) < 0.1
    masses = np.where(pinned & (rng.random(n) < 0.5), rng.choice([0.0, np.nan, np.inf]), masses)
    return case.change(masses=masses, pinned=pinned)


def _obstacles(rng: np.random.Generator, case: Case) -> Case:
    """Pin vertices at random, or whole faces, and give them any motion."""
    n, share = len(case.positions_t0), rng.choice([0.05, 0.3, 0.8, 1.0])
    pinned = rng.random(n) < share
    if rng.random() < 0.5 and len(case.faces):
        pinned = np.zeros(n, bool)
        pinned[case.faces[rng.random(len(case.faces)) < share]] = True
    end = case.ends[0].copy()
    end[pinned] += rng.choice([0.0, 0.1, 10.0]) * rng.normal(size=(int(pinned.sum()), 3))
    prescribed = str(rng.choice(["exclude", "block"]))
    return case.change(pinned=pinned, ends=(end,), modes=case.modes | {"prescribed": prescribed})


def _thickness(rng: np.random.Generator, case: Case) -> Case:
    """Draw a thickness from far below rounding to far above an edge."""
    return case.change(thickness=power(rng, -25, 3))


def _start(rng: np.random.Generator, case: Case) -> Case:
    """Let parts touch, coincide or cross at the start, and say what is to be done about it."""
    grid = float(2 ** int(rng.integers(0, 4)))
    case = _mapped(case, lambda p: np.round(p * grid) / grid) if rng.random() < 0.7 else case
    modes: dict[str, Any] = {"initial_intersections": str(rng.choice(["exclude", "ratchet"]))}
    if rng.random() < 0.3:
        modes["weld"] = 0.0 if rng.random() < 0.5 else power(rng, -9, -1)
        n = len(case.positions_t0)
        twins = rng.permutation(n)[: n // 3]
        near = modes["weld"] * 0.5 * rng.uniform(-1, 1, (len(twins), 3))
        parts = [case.positions_t0, *case.ends]
        parts = [np.concatenate((p, p[twins] + near)) for p in parts]
        other = np.arange(n)
        other[twins] = n + np.arange(len(twins))
        faces = np.where(rng.random((len(case.faces), 1)) < 0.5, other[case.faces], case.faces)
        case = case.take_vertices(np.concatenate((np.arange(n), twins)))
        case = case.change(positions_t0=parts[0], ends=tuple(parts[1:]), faces=faces)
    return case.change(modes=case.modes | modes)


def _single(rng: np.random.Generator, case: Case) -> Case:
    """Round coordinates to float32 or to a few decimals, as files have them."""
    if rng.random() < 0.6:
        return _mapped(case, lambda p: p.astype(np.float32).astype(np.float64))
    digits = int(rng.integers(1, 6))
    return _mapped(case, lambda p: np.round(p, digits))


def _options(rng: np.random.Generator, case: Case) -> Case:
    """Draw the choices and tolerances of the loop."""
    settings: dict[str, Any] = {
        "selection": str(rng.choice(["independent", "first-of-any", "all"])),
        "max_iterations": int(rng.choice([0, 1, 2, 5, 100])),
        "relinearize": int(rng.choice([0, 1, 5])),
        "relinearize_budget": float(rng.choice([0.0, 0.4, 10.0])),
        "small_zone": int(rng.choice([0, 1, 4, 256])),
    }
    if rng.random() < 0.3:
        settings |= {"gap_tolerance": power(rng, -16, 0), "violation_tolerance": power(rng, -16, 0)}
    if rng.random() < 0.3:
        settings["plan"] = tuple(rule for rule in RULES if rng.random() < 0.5)
    return case.change(settings=case.settings | settings)


def _methods(rng: np.random.Generator, case: Case) -> Case:
    """Draw a method; first-order methods get a few steps only."""
    methods = ("active-set", "interior-point", *SWEEPS, *LAGRANGIAN)
    method = methods[rng.integers(len(methods))]
    settings: dict[str, Any] = {
        "method": method,
        "max_steps": int(rng.choice([0, 1, 30, FEW_STEPS])),
        "line_search": str(rng.choice(["exact", "backtracking", "wolfe"])),
        "multiplier_update": str(rng.choice(["every-step", "inner-solve"])),
        "penalty": str(rng.choice(["fixed", "grown"])),
        "max_iterations": 20,
    }
    if rng.random() < 0.3 and method in (*SWEEPS, *LAGRANGIAN):
        settings["precision"] = "float32"
    return case.change(settings=case.settings | settings)


def _presets(rng: np.random.Generator, case: Case) -> Case:
    """Draw a preset, with a few steps."""
    settings = {
        "preset": str(rng.choice(list(PRESET_METHODS))),
        "max_steps": int(rng.choice([10, FEW_STEPS])),
        "max_iterations": 20,
    }
    return case.change(settings=case.settings | settings)


def _sequence(rng: np.random.Generator, case: Case) -> Case:
    """Let 1 to 3 more steps follow: the same motion again, back to the start, or any other."""
    ends, start = list(case.ends), case.positions_t0
    for _ in range(rng.integers(1, 4)):
        way = rng.integers(4)
        if way == 0:
            ends.append(ends[-1] + (case.ends[0] - start))
        elif way == 1:
            ends.append(start)
        elif way == 2:
            ends.append(ends[-1])
        else:
            ends.append(start + rng.normal(size=3) + 0.5 * rng.normal(size=start.shape))
    mode = str(rng.choice(["raise", "ratchet", "exclude"]))
    return case.change(ends=tuple(ends), modes=case.modes | {"initial_intersections": mode})


def _whole_numbers(rng: np.random.Generator, case: Case) -> Case:
    """Move vertices to a coarse grid: exact contacts on the way, at t = 0+ and at t = 1."""
    grid = float(2 ** int(rng.integers(0, 5)))
    return _mapped(case, lambda p: np.round(p * grid) / grid)


def _mixed(rng: np.random.Generator, case: Case) -> Case:
    """Add several kinds at once; the one that changes the number of vertices comes first."""
    chosen = [kind for kind in MIXED if rng.random() < 0.3]
    for kind in chosen:
        case = kind(rng, case)
    return case


MIXED = (
    _start,
    _obstacles,
    _masses,
    _thickness,
    _options,
    _methods,
    _whole_numbers,
    _far,
    _sequence,
    _scaled,
    _single,
)


def _mapped(case: Case, change: Callable[[Positions], Positions]) -> Case:
    """Return the case with other positions, at all times."""
    return case.change(
        positions_t0=change(case.positions_t0), ends=tuple(change(end) for end in case.ends)
    )


KINDS: dict[str, Kind] = {
    "plain": _plain,
    "scaled": _scaled,
    "far": _far,
    "masses": _masses,
    "obstacles": _obstacles,
    "thickness": _thickness,
    "start": _start,
    "single": _single,
    "options": _options,
    "methods": _methods,
    "presets": _presets,
    "sequence": _sequence,
    "whole-numbers": _whole_numbers,
    "mixed": _mixed,
}
