"""The view of an animation, as it was proposed and as it was resolved, with what crosses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from izo_ref.app.view.model import (
    Kind,
    ShownPairs,
    Side,
    Table,
    View,
    no_pairs,
    pairs_at_rest,
)
from izo_ref.base.arrays import Faces, Ints, Positions
from izo_ref.base.errors import FileFormatError
from izo_ref.detection.intersections import find_intersections
from izo_ref.detection.mesh import edges_of
from izo_ref.formats.animation import Animation, Mesh, triangles

# Positions of vertices that a page holds of each side, in all frames: 100 frames of 100,000
# triangles. A page of 108 frames of cloth with 92,000 triangles, one side, has 33 MB; the browser
# holds 12 bytes for each position.
MOST_POSITIONS = 5_000_000
MOST_PAIRS = 200_000  # pairs that a page holds in all frames
NAMES = ("Proposed", "Resolved")


def sequence_view(
    title: str,
    animations: Sequence[Animation],
    tick: Callable[[str], object] = lambda text: None,
    obstacle: Animation | None = None,
) -> View:
    """Return the view of an animation, or of two of the same meshes.

    Args:
        title: Names the animation.
        animations: What was proposed, and what was resolved.
        tick: Is called with a line for each frame that was read.
        obstacle: Meshes that are shown with both, as pinned ones; of one frame, or as many.

    Raises:
        FileFormatError: A frame cannot be read, or the animations do not fit each other.
    """
    first = animations[0]
    for other in animations[1:]:
        _check_same(first, other)
    n_frames = min(animation.n_frames for animation in animations)
    shown = [first]
    if obstacle is not None:
        _check_frames(obstacle, n_frames)
        shown.append(obstacle)
    faces, n_degenerate = _faces_of(shown)
    meshes = [mesh for animation in shown for mesh in animation.meshes]
    sizes = [mesh.n_vertices for mesh in meshes]
    frames = _thinned(n_frames, sum(sizes))
    sides = [
        _side(name, [animation, *shown[1:]], faces, frames, tick)
        for name, animation in zip(NAMES, animations, strict=False)
    ]
    verdict, passed = _verdict(sides)
    return View(
        title=title,
        verdict=verdict,
        passed=passed,
        is_step=False,
        faces=faces,
        parts=[mesh.name for mesh in meshes],
        part_of=np.repeat(np.arange(len(meshes), dtype=np.int32), sizes),
        pinned=np.arange(sum(sizes)) >= _n_vertices(first),
        zone_of=None,
        frames=frames,
        sides=sides,
        up=first.up,
        notes=_notes(animations, frames, sides, n_degenerate),
        tables=[_meshes_table(meshes), _frames_table(frames, sides)],
    )


def _n_vertices(animation: Animation) -> int:
    return sum(mesh.n_vertices for mesh in animation.meshes)


def _check_frames(obstacle: Animation, n_frames: int) -> None:
    """Raise an error if an obstacle has several frames, but fewer than are shown."""
    if 1 < obstacle.n_frames < n_frames:
        raise FileFormatError(
            f"{obstacle.path}: expected one frame or {n_frames}, as many as are shown; found "
            f"{obstacle.n_frames}"
        )


def _faces_of(shown: Sequence[Animation]) -> tuple[Faces, int]:
    """Return the triangles, and how many are left out because they have a vertex twice."""
    offsets = np.cumsum([0, *map(_n_vertices, shown)], dtype=np.int32)
    parts = [triangles(each.meshes) + n for each, n in zip(shown, offsets, strict=False)]
    faces = np.concatenate(parts)
    a, b, c = faces.T
    whole = (a != b) & (b != c) & (c != a)
    return faces[whole], int(np.count_nonzero(~whole))


def _check_same(first: Animation, other: Animation) -> None:
    """Raise an error if two animations have different meshes."""
    n, n_other = _n_vertices(first), _n_vertices(other)
    if n != n_other:
        raise FileFormatError(
            f"{other.path}: expected {n} vertices, as {first.path} has; found {n_other}"
        )
    if not np.array_equal(triangles(other.meshes), triangles(first.meshes)):
        raise FileFormatError(
            f"{other.path}: expected the same polygons as {first.path} has; name an animation that "
            "was resolved from it"
        )


def _thinned(n_frames: int, n_vertices: int) -> list[int]:
    """Return the numbers of the frames that are shown, the first and the last among them."""
    most = max(MOST_POSITIONS // max(n_vertices, 1), 2)
    if n_frames <= most:
        return list(range(n_frames))
    return np.rint(np.linspace(0, n_frames - 1, most)).astype(int).tolist()


def _side(
    name: str,
    shown: Sequence[Animation],
    faces: Faces,
    frames: list[int],
    tick: Callable[[str], object],
) -> Side:
    """Read the frames of an animation and its obstacle, and find what crosses in each."""
    edges, most = edges_of(faces), max(MOST_PAIRS // len(frames), 1)
    side = Side(name=name, positions=[], pairs=[], n_pairs=[])
    for number in frames:
        positions = np.concatenate([each.frame(min(number, each.n_frames - 1)) for each in shown])
        pairs = crossings(positions, edges, faces)
        side.positions.append(positions)
        side.n_pairs.append(len(pairs.kinds))
        side.pairs.append(pairs.first(most))
        tick(f"{name.lower()}, frame {number} of {frames[-1]}: {len(pairs.kinds)} pairs cross")
    return side


def crossings(positions: Positions, edges: Ints, faces: Faces) -> ShownPairs:
    """Return the edges that go through faces at rest.

    Args:
        positions: (n, 3) f8 [m].
        edges: (k, 2) i4.
        faces: (m, 3) i4.
    """
    largest = float(np.abs(positions).max(initial=0.0))
    if largest == 0.0 or not len(faces):
        return no_pairs()
    # powers of two change no digit, and numbers near 1 can be computed with
    near_one = np.ldexp(positions, -int(np.frexp(largest)[1]))
    found = find_intersections(near_one, edges, faces)
    through = found.go_through()
    kind = Kind.EDGE_THROUGH_FACE
    return pairs_at_rest(kind, found.crossing_edges[through], found.crossed_faces[through])


def _verdict(sides: list[Side]) -> tuple[str, bool | None]:
    """Return a sentence about the frames, and whether the last side is free of crossings."""
    parts = []
    for side in sides:
        n_frames = sum(n > 0 for n in side.n_pairs)
        where = f"in {n_frames} of {len(side.n_pairs)} frames" if n_frames else "in no frame"
        parts.append(f"{side.name}: edges go through faces {where}")
    return "; ".join(parts) + ".", not any(sides[-1].n_pairs)


def _notes(
    animations: Sequence[Animation], frames: list[int], sides: list[Side], n_degenerate: int
) -> list[str]:
    """Say what is not shown."""
    notes = []
    if n_degenerate:
        notes.append(f"Triangles that are left out, as a vertex is in them twice: {n_degenerate}.")
    counts = [animation.n_frames for animation in animations]
    if len(set(counts)) > 1:
        notes.append(
            f"The animations have {counts[0]} and {counts[1]} frames; the first {min(counts)} are "
            "shown."
        )
    if len(frames) < min(counts):
        notes.append(
            f"{len(frames)} of {min(counts)} frames are shown, as evenly as possible, because a "
            f"page holds {MOST_POSITIONS:,} positions. Positions between them were not looked at."
        )
    n_cut = sum(
        len(pairs.kinds) < n
        for side in sides
        for pairs, n in zip(side.pairs, side.n_pairs, strict=True)
    )
    if n_cut:
        notes.append(
            f"{n_cut} lists of pairs hold only the first pairs that cross, because a page "
            f"holds {MOST_PAIRS:,} of each side."
        )
    return notes


def _meshes_table(meshes: Sequence[Mesh]) -> Table:
    rows = [
        (mesh.name, f"{mesh.n_vertices:,} vertices, {len(mesh.counts):,} polygons")
        for mesh in meshes
    ]
    return Table("Meshes", (), rows)


def _frames_table(frames: list[int], sides: list[Side]) -> Table:
    """Return a table of the frames in which something crosses."""
    heads = ("Frame", *(f"{side.name}: edges through faces" for side in sides))
    rows = [
        (str(number), *(f"{side.n_pairs[i]:,}" for side in sides))
        for i, number in enumerate(frames)
        if any(side.n_pairs[i] for side in sides)
    ]
    return Table("Frames with crossings", heads, rows)
