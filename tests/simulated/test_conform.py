"""A handful of the vectors on our own path of the GPU, in the simulator."""

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from tests.helpers.vectors import is_close, same_partition
from tests.ports.own_cuda import ANSWERS, is_tiny

pytestmark = pytest.mark.filterwarnings("ignore:.*(divide by zero|overflow|invalid value)")
CHOSEN = {
    "S5": ("transitive-01", "transitive-04", "transitive-11", "pinned-05", "pinned-08"),
    "S11": ("single-02", "pinned-02", "satisfied-01", "mass-03", "redundant-05", "opposed-03",
            "size-01", "cap-01", "early-02"),
    "S12": ("fall-01", "fall-03", "tunnel-01", "tunnel-02", "motion-01"),
}  # fmt: skip
NAMES = {f"{stage}-{name}" for stage, names in CHOSEN.items() for name in names}
CASES = [case for case in load_cases(stages=CHOSEN) if case.id in NAMES]


def zones_are_right(case, reply):
    return same_partition(reply["zone_of_impact"], case.expected["zone_of_impact"]["values"])


def optimum_is_right(case, reply):
    if [reply["feasible"]] != case.expected["feasible"]["values"] or not reply["feasible"]:
        return [reply["feasible"]] == case.expected["feasible"]["values"]
    return is_close(case.expected["positions"], reply["positions"], "f8")


def step_is_right(case, reply):
    """Check the objective; the answer says itself whether its path is certified free."""
    own = case.inputs
    moves = np.reshape(reply["positions"], (-1, 3)) - np.reshape(own["positions_t1"], (-1, 3))
    free, masses = np.array(own["pinned"]) == 0, np.array(own["masses"])
    objective = (masses * (moves**2).sum(axis=1))[free].sum() / masses[free].sum()
    return reply["free"] and objective <= case.expected["positions"]["objective_at_most"]


RIGHT = {"S5": zones_are_right, "S11": optimum_is_right, "S12": step_is_right}


def test_the_cases_exist():
    assert {case.id for case in CASES} == NAMES


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_our_own_path_of_the_gpu_passes(case):
    assert is_tiny(case.stage, case.inputs)
    assert RIGHT[case.stage](case, ANSWERS[case.stage](dict(case.inputs), "f8"))
