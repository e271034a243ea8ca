"""The vectors of stage S7: the augmented Lagrangian and its gradient."""

from fractions import Fraction
from random import Random

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.generate import s07
from izo_ref.porting.generate.small_zones import random_zone
from tests.helpers.zone_port import Port, answer
from tests.helpers.zone_vectors import (
    check_cases,
    exact_lagrangian,
    failures,
    fractions,
    kept_in_float32,
)
from tests.ports.own import s07 as own

FLAGS = (
    "node-order",
    "mass-weighting",
    "constraint-sign",
    "lost-sum",
    "kink",
    "penalty-scaling",
    "multipliers-not-clamped",
    "absolute-tolerance",
)
CASES = load_cases(stages=["S7"])


def test_the_cases_are_complete():
    check_cases(CASES, "S7", FLAGS)


def test_our_own_functions_pass():
    assert failures(CASES, own.answer) == []


def test_a_port_that_is_written_from_the_formulas_passes():
    assert failures(CASES, answer("S7")) == []


@pytest.mark.parametrize("name", ["weights", "normals", "masses", "multipliers", "penalty"])
def test_inputs_that_are_kept_in_float32_are_caught(name):
    assert failures(CASES, kept_in_float32(answer("S7"), name), "float32-coordinates")


@pytest.mark.parametrize("seed", range(4))
def test_the_reference_agrees_with_fractions(seed):
    inputs = random_zone(Random(seed), 4, 6, masses=(1.0, 3.0), pinned=(3,))
    inputs = s07.with_multipliers(inputs, s07.random_multipliers(seed, 4, 2.0), 3.0)
    found, x = s07.evaluate(inputs), fractions(inputs["positions"])
    assert float(found.value) == float(exact_lagrangian(inputs, x))
    step = Fraction(1, 2**100)
    for i in range(len(x)):
        ends = [[a + s * step * (b == i) for b, a in enumerate(x)] for s in (1, -1)]
        slope = (exact_lagrangian(inputs, ends[0]) - exact_lagrangian(inputs, ends[1])) / (2 * step)
        assert float(found.gradient[i // 3][i % 3]) == (0.0 if i // 3 == 3 else float(slope))


class Sorted(Port):
    def start(self):
        self.nodes = np.sort(self.nodes)


class Unweighted(Port):
    def start(self):
        self.m = np.ones_like(self.m)


class ImpactsDivided(Port):
    """Divides the terms of impacts by the sum of masses as well."""

    def forces(self):
        return super().forces() / self.total_mass()


class Pulls(Port):
    def pull(self, gradient, i, vector):
        gradient[i] += vector


class GapLessThickness(Port):
    def constraint(self, gap):
        return gap - self.d


class OneBlock(Port):
    def pushed(self):
        return super().pushed()[:1024]


class OneBlockPulls(Port):
    def forces(self):
        return super().forces()[:1024]


class LastOneWins(Port):
    """Threads write to a vertex at the same time, and one term survives."""

    def pull(self, gradient, i, vector):
        gradient[i] = (self.w() * self.moved())[i] - vector


class ActiveWhereViolated(Port):
    def pushed(self):
        return np.where(self.constraints() > 0, super().pushed(), 0)

    def forces(self):
        return np.where(self.constraints() > 0, super().forces(), 0)


class NoConstant(Port):
    """Leaves out -l^2 / (2 mu) of impacts that are not active."""

    def of_multipliers(self):
        active = self.numbers("multipliers")[self.pushed() > 0]
        return (active**2).sum() / (2 * self.mu())


class ClampedFirst(Port):
    """Takes max(c, 0) + l / mu."""

    def forces(self):
        return self.numbers("multipliers") + self.mu() * np.maximum(self.constraints(), 0)


class WithoutHalf(Port):
    def value(self):
        return super().value() + self.mu() / 2 * (self.pushed() ** 2).sum()


class NoPenalty(Port):
    def forces(self):
        return np.maximum(self.numbers("multipliers") + self.constraints(), 0)


class NotClamped(Port):
    def forces(self):
        return self.numbers("multipliers") + self.mu() * self.constraints()


class Tolerant(Port):
    def forces(self):
        active = self.constraints() + self.numbers("multipliers") / self.mu() > 1e-9
        return np.where(active, super().forces(), 0)


MISTAKES = {
    "node-order": (Sorted,),
    "mass-weighting": (Unweighted, ImpactsDivided),
    "constraint-sign": (Pulls, GapLessThickness),
    "lost-sum": (LastOneWins, OneBlock, OneBlockPulls),
    "kink": (ActiveWhereViolated, NoConstant, ClampedFirst),
    "penalty-scaling": (WithoutHalf, NoPenalty),
    "multipliers-not-clamped": (NotClamped,),
    "absolute-tolerance": (Tolerant,),
}


@pytest.mark.parametrize("flag", FLAGS)
def test_cases_of_a_flag_catch_its_mistakes(flag):
    for mistake in MISTAKES[flag]:
        found = failures(CASES, answer("S7", mistake), flag)
        assert {dtype for _, dtype in found} == {"f8", "f4"}, mistake
