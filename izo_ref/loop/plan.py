"""What a scene needs of the pipeline, what is left out, and why."""

from typing import NamedTuple

from izo_ref.base import devices
from izo_ref.base.options import Options
from izo_ref.detection.components import MeshComponents


class PlanLine(NamedTuple):
    """One part of the pipeline."""

    part: str
    needed: str  # `all`, `some` or `none` of it
    reason: str
    rule: str  # of `options.RULES` that leaves it out; empty where there is nothing to switch


class Plan(NamedTuple):
    """What a scene needs; printed, it is a table."""

    lines: tuple[PlanLine, ...]

    def __str__(self):
        rows = [("part", "needed", "rule", "why")]
        rows += [(line.part, line.needed, line.rule or "-", line.reason) for line in self.lines]
        widths = [max(len(row[k]) for row in rows) for k in range(3)]
        text = [
            "  ".join([*(cell.ljust(w) for cell, w in zip(row[:3], widths, strict=True)), row[3]])
            for row in rows
        ]
        return "\n".join(text)


def plan(scene, options: Options | None = None) -> Plan:
    """Look at a scene once, and say what resolving it needs.

    What is left out changes nothing: `Options(plan="everything")` gives the same positions, bit
    for bit but for the last digits of zones of one impact, which then take a solver.

    Args:
        scene: `Scene`.
        options: `Options`; rules that are switched off there leave nothing out.

    Returns:
        `Plan`.
    """
    options = options or Options()
    moving = (scene.positions_t0 != scene.positions_t1).any(axis=1)
    lines = [
        _gpu(scene),
        _detection(scene, moving),
        _pairs_at_rest(moving),
        _parts(scene, moving),
        *_kinds(scene),
        PlanLine("box coordinates", "some", "32 bits keep the order of 64", "float32-boxes"),
        _obstacles(scene, moving),
        *_later(moving),
        *_zones(),
        PlanLine(
            "exact arithmetic",
            "some",
            "what floats cannot decide, at the end",
            "float-verdicts",
        ),
    ]
    return Plan(tuple(_switched(line, options.rules) for line in lines))


def _switched(line, rules):
    """The line as it is if its rule is not applied."""
    if not line.rule or line.rule in rules or line.needed == "all":
        return line
    return line._replace(needed="all", reason=f"its rule is switched off; else: {line.reason}")


def _gpu(scene):
    n, enough = len(scene.faces), len(scene.faces) >= devices.GPU_FACES
    reason = f"{n} triangles; device 'auto' takes one, if there is one, from {devices.GPU_FACES} on"
    return PlanLine("a GPU", "all" if enough else "none", reason, "")


def _detection(scene, moving):
    if not moving.any():
        return PlanLine("detection", "none", "nothing moves, and the start is free", "still")
    return PlanLine("detection", "all", f"{moving.sum()} of {len(moving)} vertices move", "")


def _pairs_at_rest(moving):
    rest = len(moving) - int(moving.sum())
    if rest == 0:
        return PlanLine("pairs at rest", "all", "there are none: every vertex moves", "")
    return PlanLine(
        "pairs at rest", "none", f"{rest} vertices rest, and the start is free", "still"
    )


def _parts(scene, moving):
    name = "parts in trees"
    if moving.all():
        return PlanLine(name, "all", "every vertex moves", "")
    parts = MeshComponents(len(moving), scene.faces)
    far = parts.out_of_reach(scene.positions_t0, scene.positions_t1)
    n_faces = int(far[parts.component][scene.faces[:, 0]].sum())
    reason = (
        f"{far.sum()} of {parts.count} parts, {n_faces} of {len(scene.faces)} triangles, rest out "
        "of reach of all that moves"
    )
    needed = "all" if not far.any() else "none" if far.all() else "some"
    return PlanLine(name, needed, reason, "one-box" if far.any() else "")


def _kinds(scene):
    faces, edges = len(scene.faces), len(scene.edges)
    if faces == 0:
        return [
            PlanLine(f"{kind} pairs", "none", "there are no triangles", "")
            for kind in ("vertex-face", "edge-edge")
        ]
    return [
        PlanLine("vertex-face pairs", "all", f"{len(scene.pinned)} vertices, {faces} faces", ""),
        PlanLine("edge-edge pairs", "all", f"{edges} edges", ""),
    ]


def _obstacles(scene, moving):
    name = "obstacle paths"
    pinned = int(scene.pinned.sum())
    if pinned == 0:
        return PlanLine(name, "none", "no vertex is pinned", "")
    prescribed = int((scene.pinned & moving).sum())
    if prescribed == 0:
        return PlanLine(name, "none", f"{pinned} vertices are pinned, and none of them moves", "")
    return PlanLine(
        name,
        "some",
        f"{prescribed} pinned vertices move: pairs among them, which could block the step, are "
        "looked at once, and by the certificate",
        "incremental",
    )


def _later(moving):
    if not moving.any():
        reason = "one detection finds nothing"
        return [PlanLine("later detections", "none", reason, "")]
    return [
        PlanLine("later detections", "some", "only pairs near what moved since", "incremental"),
        PlanLine("later solves", "some", "only zones with a new impact", "changed-zones"),
    ]


def _zones():
    return [
        PlanLine("solvers", "some", "none for a zone of one impact", "closed-form"),
        PlanLine(
            "threads for zones",
            "some",
            "one if all small zones take microseconds",
            "small-launches",
        ),
        PlanLine("compiled code", "some", "what is called, when it is", ""),
    ]
