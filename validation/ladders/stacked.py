"""Run scenes of layers and of gadgets; several families have ladders of them."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from izo_ref.loop.resolve import Result
from validation.ladders.judge_step import Case, Known, judge_step
from validation.ladders.ladder import Outcome
from validation.scenes import gadgets
from validation.scenes import layers as layered

FREE = ("FREE",)


class Kind(NamedTuple):
    """A step whose kind has a name: a defect of a mesh, or a start that touches.

    Attributes:
        scene: Makes the step.
        statuses: Right statuses.
        modes: Further arguments of `Scene`.
    """

    scene: Callable[[], gadgets.Gadget]
    statuses: tuple[str, ...] = FREE
    modes: Mapping[str, Any] = MappingProxyType({})

    def judge(self) -> list[Outcome]:
        """Resolve the step and judge it."""
        return judge_gadget(self.scene(), self.statuses, modes=self.modes)


CERTIFIED = ("FREE", "FREE_BY_FALLBACK")
# The loop is not convex: its answer is certified free, and may be a little farther from the
# proposed positions than the best one.
ABOVE_BEST = 0.01
CENTRE = 1e-9  # rounding of the mean of some thousand positions, over the largest move, and more


def judge_layers(scene: layered.Layers, statuses: tuple[str, ...] = FREE) -> list[Outcome]:
    """Resolve layers, and compare the answer with the best flat one.

    The objective may be at most ABOVE_BEST above that of the best flat layers. It may also be below
    it, because layers that move sideways, too, can end closer to the proposed positions.

    Args:
        scene: The layers.
        statuses: Right statuses.
    """
    case = Case(scene.start, scene.end, scene.faces, layered.THICKNESS_M, None, scene.pinned)
    free = ~scene.pinned
    objective = None
    if scene.best is not None:
        moves = (scene.best - scene.end)[free]
        objective = float((moves**2).sum() / free.sum())
    check = None if scene.pinned.any() else moved_centre
    return judge_step(case, Known(statuses, None, objective, ABOVE_BEST, check=check))


def moved_centre(result: Result) -> str:
    """Return a sentence if the centre of equal masses is not where it was proposed to be.

    The weights of a contact sum to zero, so no impact moves the centre.
    """
    moves = result.positions - result.certificate.scene.positions_t1
    if result.status.name == "FREE" and moves.any():
        off = np.abs(moves.mean(axis=0)).max() / np.abs(moves).max()
        if off > CENTRE:
            return f"The centre of mass is off by {off:.1e} of the largest move."
    return ""


def judge_gadget(
    scene: gadgets.Gadget,
    statuses: tuple[str, ...] = FREE,
    *,
    tolerance: float = 1e-9,
    by_objective: bool = False,
    modes: Mapping[str, Any] | None = None,
) -> list[Outcome]:
    """Resolve a gadget, and compare the answer with that worked out by hand.

    Args:
        scene: The gadget.
        statuses: Right statuses.
        tolerance: Largest relative error that is right.
        by_objective: Compare the objective instead of the positions; the answer may then be better
            than that worked out by hand, and the error negative.
        modes: Further arguments of `Scene`.
    """
    case = Case(
        scene.start,
        scene.end,
        scene.faces,
        gadgets.THICKNESS_M,
        None,
        scene.pinned,
        modes or {},
    )
    if not by_objective:
        return judge_step(case, Known(statuses, scene.best, tolerance=tolerance))
    free = np.ones(len(scene.end), bool) if scene.pinned is None else ~scene.pinned
    objective = float(((scene.best - scene.end)[free] ** 2).sum() / free.sum())
    return judge_step(case, Known(statuses, None, objective, tolerance))
