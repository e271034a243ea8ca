"""The vectors of stage S11, and mistakes that they catch."""

from fractions import Fraction

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.reference.optimum import check, natural_residuals, optimum, rows_of
from tests.helpers.vectors import EPS, caught, is_close, require_good_cases
from tests.naive.qp import dense_rows, solve_qp
from tests.ports.own.s11 import answer
from validation.ladders.zone_arrays import problem_of
from validation.oracles import slsqp

CASES = load_cases(stages=["S11"])
OWNED = ("rows-redundant", "rows-opposed", "mass-ratio", "cap-100", "early-stop", "infeasible")
ALSO = ("pinned-masses", "mass-weighting", "absolute-tolerance", "constraint-sign")


def is_optimal(case, reply, dtype):
    """Return whether multipliers fit the positions, by the rule of the judge `kkt`."""
    wanted, rows = case.expected["multipliers"], rows_of(case.inputs)
    limit = wanted.get(f"multiple_{dtype}", wanted["multiple"]) * EPS[dtype]
    coordinates = [3 * vertex + axis for vertex, axis in rows.unknowns]
    ends, proposed = reply["positions"], case.inputs["proposed"]
    moves = [Fraction(ends[i]) - Fraction(proposed[i]) for i in coordinates]
    off, natural = natural_residuals(rows, moves, list(map(Fraction, reply["multipliers"])))
    scales = [wanted["scale"][i] for i in coordinates] + wanted["gap_scale"]
    return all(abs(r) <= limit * s for r, s in zip(off + natural, scales, strict=True))


def passes(case, reply, dtype="f8"):
    """Return whether a reply is what a case expects."""
    wanted = case.expected
    if [reply["feasible"]] != wanted["feasible"]["values"]:
        return False
    if not reply["feasible"]:
        return True
    right = is_close(wanted["positions"], reply["positions"], dtype)
    return right and ("multipliers" not in reply or is_optimal(case, reply, dtype))


def in_numpy(case, dtype=np.float64):
    """Return A, s, 1/m of each coordinate, y and the rows of unpinned coordinates."""
    own = case.inputs
    proposed = np.array(own["proposed"], dtype)
    pinned = np.array(own["pinned"], bool)
    nodes = np.reshape(own["nodes"], (-1, 4))
    weights = np.reshape(own["weights"], (-1, 4)).astype(dtype)
    normals = np.reshape(own["normals"], (-1, 3)).astype(dtype)
    rows = dense_rows(nodes, weights, normals, len(pinned)).astype(dtype)
    rhs = dtype(own["thickness"]) - rows @ proposed
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(pinned, 0.0, 1.0 / np.array(own["masses"])).astype(dtype)
    return rows, rhs, np.repeat(inverse, 3), proposed


def reply_of(case, multipliers, dtype=np.float64):
    """Return the reply of a solver that ended with these multipliers."""
    rows, _, inverse, proposed = in_numpy(case, dtype)
    ends = proposed + inverse * (rows.T @ multipliers)
    lists = {"positions": ends.tolist(), "multipliers": multipliers.tolist()}
    return {"feasible": 1, **lists}


def test_the_cases_are_complete():
    require_good_cases(CASES, (*OWNED, *ALSO))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_solver_passes(case):
    assert passes(case, answer(dict(case.inputs), "f8"))


@pytest.mark.parametrize("case", [c for c in CASES if "f4" in c.dtypes], ids=lambda case: case.id)
def test_a_direct_solver_in_float32_passes(case):
    """It knows the active constraints; it rounds its inputs, and computes in float32."""
    found = optimum(rows_of(case.inputs))
    rows, rhs, inverse, _ = in_numpy(case, np.float32)
    if not found.feasible:
        return
    active = [j for j, value in enumerate(found.multipliers) if value > 0]
    gram = (rows[active] * inverse) @ rows[active].T
    multipliers = np.zeros(len(rows), np.float32)
    multipliers[active] = np.linalg.solve(gram, rhs[active])
    assert multipliers.dtype == np.float32
    assert passes(case, reply_of(case, multipliers, np.float32), "f4")


def test_the_reference_agrees_with_the_oracle(rng):
    for _ in range(25):
        n, m = rng.integers(4, 9), rng.integers(1, 6)
        nodes = np.array([rng.choice(n, 4, replace=False) for _ in range(m)])
        b, c = rng.random((2, m, 1))
        weights = np.hstack((1.0 - b, b, c - 1.0, -c))
        normals, proposed = rng.normal(size=(m, 3)), rng.normal(size=(n, 3))
        masses, pinned = 2.0 ** rng.integers(-4, 5, n), rng.random(n) < 0.3
        pinned[nodes[:, 0]] = False
        zone = {
            "nodes": nodes.ravel().tolist(),
            "weights": weights.ravel().tolist(),
            "normals": normals.ravel().tolist(),
            "proposed": proposed.ravel().tolist(),
            "masses": masses.tolist(),
            "pinned": pinned.astype(int).tolist(),
            "thickness": 0.1,
        }
        rows = rows_of(zone)
        found = optimum(rows)
        check(rows, found)
        dense, free = dense_rows(nodes, weights, normals, n), np.repeat(~pinned, 3)
        rhs = 0.1 - dense[:, ~free] @ proposed.ravel()[~free]
        expected = solve_qp(dense[:, free], rhs, masses[~pinned], proposed[~pinned])
        assert (expected is not None) == found.feasible
        ends = proposed.copy()
        for (vertex, axis), move in zip(rows.unknowns, found.moves, strict=False):
            ends[vertex, axis] += float(move)
        if expected is not None:
            np.testing.assert_allclose(ends[~pinned], expected, atol=1e-9)


def dual_steps(case, steps, change=0.0):
    """Take steps of projected gradient descent for the multipliers, or stop at a small change."""
    rows, rhs, inverse, _ = in_numpy(case)
    gram = (rows * inverse) @ rows.T
    multipliers, length = np.zeros(len(rows)), 1.0 / np.trace(gram)
    for _ in range(steps):
        new = np.maximum(multipliers + length * (rhs - gram @ multipliers), 0.0)
        moved = np.abs(new - multipliers).max()
        multipliers = new
        if moved <= change * np.abs(new).max():
            break
    return reply_of(case, multipliers)


def a_hundred_steps(case):
    return dual_steps(case, 100)


def until_steps_are_small(case):
    return dual_steps(case, 3000, 1e-3)


def until_nothing_is_violated(case):
    """Project onto one violated constraint after the other, as position-based dynamics does."""
    rows, rhs, inverse, proposed = in_numpy(case)
    moves = np.zeros(len(proposed))
    for _ in range(300):
        for row, s in zip(rows, rhs, strict=True):
            missing = s - row @ moves
            if missing > 0.0:
                moves += inverse * row * (missing / (row @ (inverse * row)))
    return {"feasible": 1, "positions": (proposed + moves).tolist()}


def all_are_active(case):
    """Take the violated constraints as equations."""
    rows, rhs, inverse, _ = in_numpy(case)
    violated = rhs > 0.0
    gram = ((rows * inverse) @ rows.T)[violated][:, violated]
    multipliers = np.zeros(len(rows))
    try:
        multipliers[violated] = np.linalg.solve(gram, rhs[violated])
    except np.linalg.LinAlgError:
        return {"feasible": 0}
    return reply_of(case, multipliers)


def each_on_its_own(case):
    """Push each constraint as if it were alone, and add up."""
    rows, rhs, inverse, _ = in_numpy(case)
    return reply_of(case, np.maximum(rhs / np.maximum((rows**2 * inverse).sum(axis=1), 1e-300), 0))


def changed(case, **changes):
    """Solve the zone of a case with other inputs."""
    return answer({**case.inputs, **changes}, "f8")


def equal_masses(case):
    return changed(case, masses=[1.0] * len(case.inputs["masses"]))


def nothing_is_pinned(case):
    masses = [m if m > 0.0 else 2.0**-40 for m in case.inputs["masses"]]
    return changed(case, pinned=[0] * len(masses), masses=masses)


def other_sign(case):
    return changed(case, normals=[-c for c in case.inputs["normals"]])


def a_micrometre_is_nothing(case):
    rows, rhs, _, _ = in_numpy(case)
    return reply_of(case, np.zeros(len(rows))) if rhs.max() <= 1e-6 else answer(case.inputs, "f8")


def always_feasible(case):
    return {**dual_steps(case, 300), "feasible": 1}


def forgets_others(case):
    """Return zeros for the vertices that are in no impact."""
    found = answer(case.inputs, "f8")
    if found["feasible"]:
        for i in set(range(len(case.inputs["masses"]))) - set(case.inputs["nodes"]):
            found["positions"][3 * i : 3 * i + 3] = [0.0] * 3
    return found


def first_of_parallel_rows(case):
    """Keep the first one of constraints whose rows point the same way."""
    rows, _, inverse, _ = in_numpy(case)
    scaled = rows * np.sqrt(inverse)
    sizes, kept = np.linalg.norm(scaled, axis=1), []
    for j, row in enumerate(scaled):
        if all(row @ scaled[k] < 0.999 * sizes[j] * sizes[k] for k in kept):
            kept.append(j)
    own = case.inputs
    parts = {
        name: np.reshape(own[name], (len(rows), -1))[kept].ravel().tolist()
        for name in ("nodes", "weights", "normals")
    }
    found = changed(case, **parts)
    found.pop("multipliers", None)
    return found


def pinned_impacts_are_ignored(case):
    """Leave out impacts that push nothing, violated or not."""
    return {"feasible": 1, "positions": []} if hopeless(case) else answer(case.inputs, "f8")


def pinned_impacts_are_hopeless(case):
    """Call a zone infeasible that has an impact which pushes nothing."""
    return {"feasible": 0} if stiff(case).any() else answer(case.inputs, "f8")


def stiff(case):
    """Return which impacts have pinned vertices alone."""
    rows, _, inverse, _ = in_numpy(case)
    return ~(rows * inverse).any(axis=1)


def hopeless(case):
    _, rhs, *_ = in_numpy(case)
    return (stiff(case) & (rhs > 0.0)).any()


def one_after_another(case, accuracy=1e-10):
    """Update one multiplier after the other, as projected Gauss-Seidel does, and move at once."""
    rows, rhs, inverse, proposed = in_numpy(case)
    multipliers, moves = np.zeros(len(rows)), np.zeros(len(proposed))
    stiffness = (rows**2 * inverse).sum(axis=1)
    for _ in range(5000):
        for j, row in enumerate(rows):
            new = max(multipliers[j] + (rhs[j] - row @ moves) / stiffness[j], 0.0)
            moves += inverse * row * (new - multipliers[j])
            multipliers[j] = new
        off = np.minimum(multipliers * stiffness, rows @ moves - rhs)
        if np.abs(off).max() <= accuracy * np.abs(moves).max():
            break
    ends = {"positions": (proposed + moves).tolist(), "multipliers": multipliers.tolist()}
    return {"feasible": 1, **ends}


@pytest.mark.parametrize("name", ["S11-early-03", "S11-early-04", "S11-random-01", "S11-cap-01"])
def test_an_iteration_that_ends_at_a_small_residual_passes(name):
    """It leaves roundings at vertices that it moved and moved back."""
    (case,) = (case for case in CASES if case.id == name)
    assert passes(case, one_after_another(case))


def slsqp_in_metres(case):
    """Solve the zone by SLSQP in metres and kilograms, as most users would."""
    found = slsqp.solve_raw(problem_of(case.inputs))
    ends = np.array(case.inputs["proposed"]) + found.displacements.ravel()
    return {"feasible": 1, "positions": ends.tolist()}


@pytest.mark.parametrize(
    ("flag", "wrong", "least"),
    [
        ("cap-100", a_hundred_steps, 6),
        ("early-stop", until_steps_are_small, 6),
        ("early-stop", until_nothing_is_violated, 5),
        ("rows-redundant", all_are_active, 4),
        ("rows-redundant", each_on_its_own, 5),
        ("rows-opposed", a_hundred_steps, 6),
        ("mass-ratio", a_hundred_steps, 3),
        ("mass-ratio", equal_masses, 5),
        ("mass-ratio", slsqp_in_metres, 1),
        ("mass-weighting", equal_masses, 5),
        ("pinned-masses", nothing_is_pinned, 3),
        ("constraint-sign", other_sign, 2),
        ("absolute-tolerance", a_micrometre_is_nothing, 1),
        ("infeasible", always_feasible, 4),
        ("infeasible", pinned_impacts_are_ignored, 1),
        ("pinned-masses", pinned_impacts_are_hopeless, 1),
        ("node-order", forgets_others, 1),
        ("rows-redundant", first_of_parallel_rows, 1),
    ],
    ids=lambda part: getattr(part, "__name__", str(part)),
)
def test_mistakes_are_caught(flag, wrong, least):
    found = caught(flag, CASES, lambda case: passes(case, wrong(case)))
    assert len(found) >= least
