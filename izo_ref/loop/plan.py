"""What a scene needs of the pipeline, what is left out, and why."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from izo_ref.base import checks, devices
from izo_ref.base.arrays import Flags
from izo_ref.base.options import Options
from izo_ref.base.records import SceneArrays


class PlanLine(NamedTuple):
    """What a scene needs of one stage of the pipeline.

    Attributes:
        stage: The stage, or a part of it.
        needed: How much of the stage is needed: `all`, `some` or `none`.
        reason: Why, as a phrase for the user.
        rule: The rule of `options.RULES` that leaves the rest out, or would do so if it were not
            switched off; empty if there is none.
    """

    stage: str
    needed: str
    reason: str
    rule: str


class Plan(NamedTuple):
    """What a scene needs of the pipeline; printed, it is a table.

    Attributes:
        lines: One line for each stage.
    """

    lines: tuple[PlanLine, ...]

    def __str__(self) -> str:
        """Return the plan as a table, one stage a line."""
        rows = [("stage", "needed", "rule", "why")]
        rows += [(line.stage, line.needed, line.rule or "-", line.reason) for line in self.lines]
        widths = [max(len(row[k]) for row in rows) for k in range(3)]
        text = [
            "  ".join([*(cell.ljust(w) for cell, w in zip(row[:3], widths, strict=True)), row[3]])
            for row in rows
        ]
        return "\n".join(text)


def plan(scene: SceneArrays, options: Options | None = None) -> Plan:
    """Look at a scene once, and say what resolving it needs.

    Leaving work out does not change the answer: `Options(plan="everything")` gives the same
    positions, bit for bit. Only zones of one impact differ in their last digits, because a solver
    then solves them.

    Args:
        scene: The step to resolve.
        options: Choices and tolerances; rules that are switched off there leave nothing out.

    Returns:
        One line for each stage of the pipeline.

    Raises:
        OptionError: `scene` is no scene, or `options` are no `Options`.
    """
    checks.scene(scene)
    options = checks.options(options)
    own = np.sort(scene.tree_orders[0])  # vertices without copies
    moving = (scene.positions_t0[own] != scene.positions_t1[own]).any(axis=1)
    lines = [
        _gpu(scene),
        *_copies(scene),
        _detection(scene, moving),
        _pairs_at_rest(scene, moving),
        _components(scene, moving),
        *_kinds(scene, len(own)),
        PlanLine(
            "box coordinates",
            "some",
            "32 of 64 bits are enough, because rounding to 32 bits keeps the order of the boxes",
            "float32-boxes",
        ),
        _obstacles(scene.pinned[own], moving),
        *_later(scene, moving),
        *_zones(),
        PlanLine(
            "exact arithmetic",
            "some",
            "the certificate uses it only for pairs that floats cannot decide",
            "float-verdicts",
        ),
    ]
    return Plan(tuple(_switched(line, options.rules) for line in lines))


def _switched(line: PlanLine, rules: frozenset[str]) -> PlanLine:
    """Return the line, or that all is needed if its rule is switched off."""
    if not line.rule or line.rule in rules or line.needed == "all":
        return line
    reason = f"the rule {line.rule!r} is switched off; with it: {line.reason}"
    return line._replace(needed="all", reason=reason)


def _gpu(scene: SceneArrays) -> PlanLine:
    n, enough = len(scene.faces), len(scene.faces) >= devices.GPU_FACES
    reason = (
        f"the scene has {n} triangles; device 'auto' uses a GPU, if there is one, from "
        f"{devices.GPU_FACES} triangles on"
    )
    return PlanLine("a GPU", "all" if enough else "none", reason, "")


def _copies(scene: SceneArrays) -> list[PlanLine]:
    if scene.copies is None:
        return []
    n, own = len(scene.copies), len(scene.tree_orders[0])
    reason = f"{n - own} of {n} vertices are copies, which end where their vertices end"
    return [PlanLine("vertices", "some", reason, "")]


def _detection(scene: SceneArrays, moving: Flags) -> PlanLine:
    if moving.any():
        return PlanLine("detection", "all", f"{moving.sum()} of {len(moving)} vertices move", "")
    if scene.touching is not None:
        reason = "no vertex moves, so only the pairs that touch at the start are checked"
        return PlanLine("detection", "some", reason, "still")
    return PlanLine("detection", "none", f"no vertex moves, and {_start(scene)}", "still")


def _start(scene: SceneArrays) -> str:
    """Return why pairs at rest are no impacts, if none of them touches and has to come apart."""
    if scene.excluded is None:
        return "the start is free of contact"
    return "the pairs that meet at the start are left out"


def _pairs_at_rest(scene: SceneArrays, moving: Flags) -> PlanLine:
    stage, at_rest = "pairs at rest", len(moving) - int(moving.sum())
    if at_rest == 0:
        return PlanLine(stage, "all", "there are none, because every vertex moves", "")
    if scene.touching is not None:
        reason = f"{at_rest} vertices are at rest; only pairs that touch at the start are checked"
        return PlanLine(stage, "some", reason, "still")
    reason = f"{at_rest} vertices are at rest, and {_start(scene)}"
    return PlanLine(stage, "none", reason, "still")


def _components(scene: SceneArrays, moving: Flags) -> PlanLine:
    stage = "components in trees"
    if moving.all():
        return PlanLine(stage, "all", "every vertex moves", "")
    components = scene.components
    far = components.out_of_reach(scene.positions_t0, scene.positions_t1)
    n_faces = int(far[components.component][scene.faces[:, 0]].sum())
    reason = (
        f"{far.sum()} of {components.count} components, with {n_faces} of {len(scene.faces)} "
        "triangles, are at rest and out of reach of everything that moves"
    )
    needed = "all" if not far.any() else "none" if far.all() else "some"
    return PlanLine(stage, needed, reason, "one-box" if far.any() else "")


def _kinds(scene: SceneArrays, n: int) -> list[PlanLine]:
    n_faces, n_edges = len(scene.faces), len(scene.edges)
    if n_faces == 0:
        return [
            PlanLine(f"{kind} pairs", "none", "there are no triangles", "")
            for kind in ("vertex-face", "edge-edge")
        ]
    vertices_and_faces = f"there are {n} vertices and {n_faces} triangles"
    return [
        PlanLine("vertex-face pairs", "all", vertices_and_faces, ""),
        PlanLine("edge-edge pairs", "all", f"there are {n_edges} edges", ""),
    ]


def _obstacles(pinned: Flags, moving: Flags) -> PlanLine:
    stage, n_pinned = "obstacle paths", int(np.count_nonzero(pinned))
    if n_pinned == 0:
        return PlanLine(stage, "none", "no vertex is pinned", "")
    prescribed = int(np.count_nonzero(pinned & moving))
    if prescribed == 0:
        reason = f"{n_pinned} vertices are pinned, and none of them moves"
        return PlanLine(stage, "none", reason, "")
    return PlanLine(
        stage,
        "some",
        f"{prescribed} pinned vertices move; pairs among them could block the step, so they are "
        "checked once at the beginning, and again by the certificate",
        "incremental",
    )


def _later(scene: SceneArrays, moving: Flags) -> list[PlanLine]:
    if not moving.any() and scene.touching is None:
        reason = "no vertex moves, so the first detection finds nothing"
        return [PlanLine("later detections", "none", reason, "")]
    rechecked = "they recheck only pairs near vertices that moved since the previous detection"
    solved = "they solve only zones with a new impact"
    return [
        PlanLine("later detections", "some", rechecked, "incremental"),
        PlanLine("later solves", "some", solved, "changed-zones"),
    ]


def _zones() -> list[PlanLine]:
    return [
        PlanLine("solvers", "some", "a zone of one impact needs one division only", "closed-form"),
        PlanLine(
            "threads for zones",
            "some",
            "one thread solves the small zones if they take microseconds in all",
            "small-launches",
        ),
        PlanLine("compiled code", "some", "each function is compiled when it is first called", ""),
    ]
