"""The vectors of stage S6: objective, gradient and constraints."""

from random import Random

import numpy as np
import pytest

from izo_ref.porting.files import load_cases
from izo_ref.porting.generate.small_zones import random_zone
from izo_ref.porting.reference.zone import constraints, displacements, objective, vectors, zone_of
from tests.helpers.zone_port import Port, answer, dot
from tests.helpers.zone_vectors import (
    check_cases,
    exact_constraints,
    exact_objective,
    failures,
    fractions,
    kept_in_float32,
)
from tests.ports.own import s06 as own

FLAGS = (
    "node-order",
    "mass-weighting",
    "pinned-masses",
    "constraint-sign",
    "lost-sum",
    "float32-coordinates",
)
CASES = load_cases(stages=["S6"])


def test_the_cases_are_complete():
    check_cases(CASES, "S6", FLAGS)


def test_our_own_functions_pass():
    assert failures(CASES, own.answer) == []


def test_a_port_that_is_written_from_the_formulas_passes():
    assert failures(CASES, answer("S6")) == []


@pytest.mark.parametrize("name", ["weights", "normals", "masses", "thickness", "positions"])
def test_inputs_that_are_kept_in_float32_are_caught(name):
    assert failures(CASES, kept_in_float32(answer("S6"), name), "float32-coordinates")


def test_positions_that_are_not_made_relative_matter_far_from_the_origin_alone():
    port = answer("S6", Absolute)
    assert failures([c for c in CASES if "float32-coordinates" not in c.flags], port) == []
    assert len(failures(CASES, port)) >= 6


@pytest.mark.parametrize("seed", range(5))
def test_the_reference_agrees_with_fractions(seed):
    inputs = random_zone(Random(seed), 3, 8, masses=(1.0, 3.0), pinned=(2,))
    zone, x = zone_of(inputs), vectors(inputs["positions"])
    exact = fractions(inputs["positions"])
    found = [float(c) for c in constraints(zone, x)]
    assert found == [float(c) for c in exact_constraints(inputs, exact)]
    g = objective(zone, displacements(zone, x))
    assert float(g) == float(exact_objective(inputs, exact))


class Sorted(Port):
    def start(self):
        self.nodes = np.sort(self.nodes)


class FaceFirst(Port):
    def start(self):
        self.a = np.roll(self.a, -1, axis=1)


class Unweighted(Port):
    def start(self):
        self.m = np.ones_like(self.m)


class NotDivided(Port):
    def total_mass(self):
        return self.real(1)


class AllMasses(Port):
    def total_mass(self):
        return self.m.sum()


class GapLessThickness(Port):
    def constraint(self, gap):
        return gap - self.d


class ViolationsOnly(Port):
    def constraint(self, gap):
        return max(self.d - gap, 0)


class PerImpact(Port):
    """Sums over the nodes of all impacts, so that a shared vertex counts several times."""

    def start(self):
        self.m = self.m * np.bincount(self.nodes.ravel(), minlength=len(self.m))[:, None]


class OneBlock(Port):
    """Sums over the vertices of the first block alone."""

    size = 128

    def objective(self):
        return (self.w() * self.moved() ** 2)[: self.size].sum() / 2


class OneLargeBlock(OneBlock):
    size = 1024


class Absolute(Port):
    def gap(self, j):
        return dot(self.n[j], dot(self.a[j], self.x[self.nodes[j]]))


MISTAKES = {
    "node-order": (Sorted, FaceFirst),
    "mass-weighting": (Unweighted, NotDivided),
    "pinned-masses": (AllMasses,),
    "constraint-sign": (GapLessThickness, ViolationsOnly),
    "lost-sum": (PerImpact, OneBlock, OneLargeBlock),
    "float32-coordinates": (Absolute,),
}


@pytest.mark.parametrize("flag", FLAGS)
def test_cases_of_a_flag_catch_its_mistakes(flag):
    for mistake in MISTAKES[flag]:
        found = failures(CASES, answer("S6", mistake), flag)
        assert {dtype for _, dtype in found} == {"f8", "f4"}, mistake
