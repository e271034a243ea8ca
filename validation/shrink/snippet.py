"""Python that builds an input again, bit for bit, for a regression test."""

from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray
from izo_ref.zones.problem import ZoneProblem
from validation.stability_steps.case import Case


def step_snippet(case: Case) -> str:
    """Return a program that builds the step and resolves it, and the steps that follow."""
    n = len(case.positions_t0)
    scene = [_array(case.positions_t0), _array(case.ends[0]), _array(case.faces)]
    if case.masses is not None:
        scene.append(f"masses={_array(case.masses)}")
    if case.pinned is not None:
        scene.append(f"pinned={np.asarray(case.pinned).astype(int).tolist()}")
    scene += [f"{name}={value!r}" for name, value in case.modes.items()]
    call = ["scene", *([] if case.thickness is None else [_number(case.thickness)])]
    if case.settings:
        options = ", ".join(f"{name}={value!r}" for name, value in case.settings.items())
        call.append(f"options=izo_ref.Options({options})")
    lines = (
        ["import numpy as np", "", "import izo_ref", ""] if _odd(case) else ["import izo_ref", ""]
    )
    lines += [f"scene = izo_ref.Scene(  # {len(case.faces)} faces, {n} vertices"]
    lines += [f"    {argument}," for argument in scene] + [")"]
    lines += [f"result = izo_ref.resolve({', '.join(call)})"]
    for end in case.ends[1:]:
        lines += [f"scene = scene.after(result, {_array(end)})"]
        lines += [f"result = izo_ref.resolve({', '.join(call)})"]
    lines += ["print(result.status, result.positions.tolist())"]
    return "\n".join(lines)


def zone_snippet(problem: ZoneProblem) -> str:
    """Return a program that builds the zone and solves it."""
    names = ("nodes", "weights", "normals", "proposed", "masses")
    arrays = [f"    {name}={_array(getattr(problem, name))}," for name in names]
    text = "\n".join(
        ["import izo_ref", "", "problem = izo_ref.ZoneProblem("]
        + [*arrays, f"    thickness={_number(problem.thickness)},", ")"]
        + ["solution = izo_ref.solve_zone(problem)", "print(solution.residuals)"]
    )
    return f"import numpy as np\n\n{text}" if "np." in text else text


def _odd(case: Case) -> bool:
    arrays = [case.positions_t0, *case.ends, *([] if case.masses is None else [case.masses])]
    empty = len(case.faces) == 0
    return empty or not all(np.isfinite(array).all() for array in arrays)


def _array(array: AnyArray) -> str:
    array = np.asarray(array)
    if array.size == 0:
        return f"np.empty({array.shape}{', int' if array.dtype.kind in 'iu' else ''})"
    return _nested(array.tolist())


def _nested(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_nested, value))}]"
    return _number(value)


def _number(value: float) -> str:
    """Return the shortest text of a number that is read back as the same float."""
    if isinstance(value, int):
        return repr(value)
    if not np.isfinite(value):
        return {"inf": "np.inf", "-inf": "-np.inf"}.get(repr(value), "np.nan")
    text = repr(value)
    return text[:-2] if text.endswith(".0") and text != "-0.0" else text
