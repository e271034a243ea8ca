"""The view of a step: the proposed path, the resolved path if there is one, and their pairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from izo_ref.app.files import SavedResult
from izo_ref.app.summary import excluded_line, excluded_summary
from izo_ref.app.view.model import ShownPairs, Side, Table, View, no_pairs, pairs_on_path
from izo_ref.base import checks
from izo_ref.base.arrays import Ints, Positions
from izo_ref.base.records import Impacts, Pairs
from izo_ref.certificate.certify import PathCertificate, certify_path
from izo_ref.detection.find import find_impacts
from izo_ref.scene import Scene
from izo_ref.zones.grouping import build_zones
from izo_ref.zones.objective import objective

MOST_PAIRS = 100_000  # pairs of a step that the page holds; it always says how many there are
FRAMES = [0, 1]  # the start and the end


def step_view(title: str, scene: Scene, result: SavedResult | None) -> View:
    """Return the view of a step.

    Args:
        title: Names the step.
        scene: The step.
        result: Its result, whose path is certified again; None shows the proposed path alone.

    Raises:
        ShapeError: The positions of the result do not fit the step.
        NonFiniteError: A position of the result is not finite.
        IndexRangeError: An impact of the result names no vertex of the step.
    """
    impacts = find_impacts(scene)
    before = proposed_side(scene, impacts)
    if result is None:
        n = len(impacts.toi)
        verdict = f"{_count(n)} on the proposed path." if n else "The proposed path is free."
        table = Table("The step", (), scene_rows(scene, impacts))
        return view_of_sides(title, scene, [before], impacts, verdict, n == 0, [table])
    positions = checks.floats("positions", result.positions, scene.positions_t0.shape)
    in_zones = impacts if result.impacts is None else _checked(result.impacts, scene)
    certificate = certify_path(scene, positions)
    after = path_side("Resolved", scene, positions, certificate)
    rows = [*scene_rows(scene, impacts), *result_rows(scene, positions, result.thickness)]
    tables = [Table("The step", (), rows), certificate_table(certificate)]
    verdict, passed = certificate_verdict(certificate)
    return view_of_sides(title, scene, [before, after], in_zones, verdict, passed, tables)


def _count(n: int) -> str:
    return f"{n:,} {'pair meets' if n == 1 else 'pairs meet'}"


def _checked(impacts: Impacts, scene: Scene) -> Impacts:
    nodes = checks.indices("impact_nodes", impacts.nodes, 4, len(scene.pinned))
    return impacts._replace(nodes=nodes)


def view_of_sides(
    title: str,
    scene: Scene,
    sides: list[Side],
    in_zones: Impacts,
    verdict: str,
    passed: bool | None,
    tables: list[Table],
    parts: Sequence[str] = (),
) -> View:
    """Return the view of a step whose sides are known.

    Args:
        title: Names the step.
        scene: The step.
        sides: Before, and after.
        in_zones: The impacts whose zones are shown.
        verdict: A sentence that says how it ended.
        passed: Whether that is good, bad, or neither (None).
        tables: Tables below the view.
        parts: Names of the connected components that have faces, in their order; numbers if empty.
    """
    part_of, count = _parts(scene)
    notes = [
        f"{side.name}: the list has the first {MOST_PAIRS:,} of {side.n_pairs[1]:,} pairs."
        for side in sides
        if side.n_pairs[1] > MOST_PAIRS
    ]
    if scene.excluded is not None:
        notes.append(
            f"{len(scene.excluded.reasons):,} pairs are not in the list, because they cross or "
            "touch at the start already."
        )
    return View(
        title=title,
        verdict=verdict,
        passed=passed,
        is_step=True,
        faces=scene.faces,
        parts=list(parts) or [f"part {i + 1}" for i in range(count)],
        part_of=part_of,
        pinned=scene.pinned,
        zone_of=_zone_of(scene, in_zones),
        frames=FRAMES,
        sides=sides,
        notes=notes,
        tables=tables,
    )


def _parts(scene: Scene) -> tuple[Ints, int]:
    """Return the component of each vertex, (n,) i4, and the number of components with faces.

    Vertices in no face count to the first one; they are not drawn.
    """
    component = scene.components.component
    number = np.full(int(component.max(initial=-1)) + 1, -1, np.int32)
    with_faces = np.unique(component[scene.faces])
    number[with_faces] = np.arange(len(with_faces), dtype=np.int32)
    return np.maximum(number[component], 0), len(with_faces)


def _zone_of(scene: Scene, impacts: Impacts) -> Ints:
    """Return the zone of each vertex, (n,) i4; -1 for pinned vertices and those in no impact."""
    zones = build_zones(scene, impacts)
    zone_of = np.full(len(scene.pinned), -1, np.int32)
    sizes = np.diff(zones.vertex_offsets)
    zone_of[zones.vertices] = np.arange(len(zones), dtype=np.int32).repeat(sizes)
    return zone_of


def proposed_side(scene: Scene, impacts: Impacts) -> Side:
    """Return the path to the proposed positions, and what meets on it."""
    pairs = pairs_on_path(Pairs(impacts.nodes, impacts.is_edge_edge), impacts.toi)
    return step_side("Proposed", scene, scene.positions_t1, pairs)


def path_side(name: str, scene: Scene, positions: Positions, certificate: PathCertificate) -> Side:
    """Return the path to other positions, and what meets on it.

    Args:
        name: What the page calls it.
        scene: The step.
        positions: (n, 3) f8 [m], the end of the path.
        certificate: Its certificate.
    """
    pairs = pairs_on_path(certificate.meeting, certificate.meeting_toi)
    return step_side(name, scene, positions, pairs)


def step_side(name: str, scene: Scene, positions: Positions, pairs: ShownPairs) -> Side:
    """Return the path of a step to some positions.

    Args:
        name: What the page calls it.
        scene: The step.
        positions: (n, 3) f8 [m], the end of the path.
        pairs: What meets on it, or crosses at its end.
    """
    return Side(
        name=name,
        positions=[scene.positions_t0, positions],
        pairs=[no_pairs(), pairs.first(MOST_PAIRS)],
        n_pairs=[0, len(pairs.kinds)],
    )


def scene_rows(scene: Scene, impacts: Impacts) -> list[tuple[str, str]]:
    """Return rows about a step and its proposed path."""
    edge_edge = int(impacts.is_edge_edge.sum())
    rows = [
        ("Triangles", f"{len(scene.faces):,}"),
        ("Vertices, pinned", f"{len(scene.pinned):,}, {int(scene.pinned.sum()):,}"),
        (
            "Impacts of the proposed path: vertex-face, edge-edge",
            f"{len(impacts.toi) - edge_edge:,}, {edge_edge:,}",
        ),
    ]
    if scene.excluded is not None:
        rows.append(("Pairs left out from the start on", f"{len(scene.excluded.reasons):,}"))
    return rows


def result_rows(
    scene: Scene, positions: Positions, thickness: float | None
) -> list[tuple[str, str]]:
    """Return rows about the end of a path.

    Args:
        scene: The step.
        positions: (n, 3) f8 [m], the end.
        thickness: [m], or None if it is not known.
    """
    value = objective(scene, positions)
    rows = [("Objective, sum m |x - y|² / sum m", f"{value:.4e} m²")]
    return rows if thickness is None else [("Thickness", f"{thickness:.4g} m"), *rows]


def certificate_verdict(certificate: PathCertificate) -> tuple[str, bool | None]:
    """Return a sentence about a path, and whether it is free; None if pairs were left out."""
    if not certificate.free:
        count, time = _count(len(certificate.meeting_toi)), certificate.time_free
        return f"{count} on the resolved path, the first at t = {time:.6g}.", False
    if certificate.excluded is not None:
        n = len(certificate.excluded_ends)
        said = f"The resolved path is certified free, except for {n:,} pairs that were left out."
        return said, None
    return "The resolved path is certified free.", True


def certificate_table(certificate: PathCertificate) -> Table:
    """Return a table about the certificate of a path."""
    n_meeting = len(certificate.meeting_toi)
    rows = [
        ("Candidate pairs of the path", f"{certificate.candidates:,}"),
        ("Proved apart", f"{certificate.candidates - n_meeting:,}"),
        ("Meeting", f"{n_meeting:,}"),
        ("Decided in exact arithmetic", f"{certificate.exact:,}"),
    ]
    if certificate.excluded is not None:
        rows.append(("Left out", excluded_line(excluded_summary(certificate))))
    return Table("What is certified", (), rows)
