"""Scenes of ordinary size: the door of every stage (`base/units.py` says what is ordinary).

**Vertices in no face.** Exporters mark unused vertices by huge coordinates. Such a vertex does not
decide the size. It is far out if its path stays more than 2^100 times farther out than the mesh,
on one side of an axis. Nothing in a face comes there, so such a vertex is computed as if it were on
the border of that range, and ends exactly where it is proposed to end.
"""

from __future__ import annotations

import copy
import math
from typing import Any, TypeVar

import numpy as np

from izo_ref.base.arrays import Flags, Positions
from izo_ref.base.errors import SizeError, ThicknessError
from izo_ref.base.records import SceneArrays
from izo_ref.base.units import (
    LENGTHS,
    Units,
    into_range,
    largest,
    mass_exponent,
    require_ratio,
    times_power,
)

FAR = 100  # a vertex in no face is far out beyond 2^FAR times the size of the mesh
# Exponents of the largest coordinate that is accepted, less that of the smallest size. They leave
# room for answers that go beyond the proposed positions, and for coordinates that are smaller than
# the largest one.
LARGEST_LENGTH = 1000
FEW = 64  # faces that are looked at first
# Exponents of the largest and of the smallest thickness, over the size of the mesh.
THICKEST, THINNEST = 200, -300

AnyScene = TypeVar("AnyScene", bound=SceneArrays)


def scene_in_range(scene: AnyScene) -> tuple[AnyScene, Units]:
    """Return a scene of ordinary size, and the powers of two by which it was multiplied.

    Args:
        scene: The scene, in the units of the caller.

    Returns:
        The scene itself if its size is ordinary, else a copy with other positions and masses.

    Raises:
        SizeError: A coordinate is too large or too small to compute with; names the first vertex.
        MassError: A mass is too small; names the first vertex.
    """
    used = ~scene.pinned & (scene.masses > 0.0)  # the masses of copies are 0
    require_ratio(scene.masses, used)
    mass = mass_exponent(scene.masses, used)
    twin, length = _lengths_in_range(scene)
    if mass != 0:
        twin = _copy(twin, masses=times_power(scene.masses, mass))
    return twin, Units(length, mass)


def path_in_range(scene: AnyScene, positions: Positions) -> tuple[AnyScene, Positions]:
    """Return a scene of ordinary size, and an end of a path of it in the same units.

    Args:
        scene: The scene, in the units of the caller; its masses stay.
        positions: (n, 3) f8 [m], end of the path, which need not be the proposed one.

    Raises:
        SizeError: A coordinate is too large or too small to compute with; names the first vertex.
    """
    path = _copy(scene, positions_t1=positions)
    twin, _ = _lengths_in_range(path)
    return (scene, positions) if twin is path else (twin, twin.positions_t1)


def _lengths_in_range(scene: AnyScene) -> tuple[AnyScene, int]:
    """Return a scene whose lengths are ordinary, and the exponent of their factor."""
    ends, n = (scene.positions_t0, scene.positions_t1), len(scene.positions_t0)
    if len(scene.faces) == 0 or _are_ordinary(ends, scene.faces):
        return scene, 0
    in_face = np.zeros(n, bool)
    in_face[scene.faces.ravel()] = True
    size = max(largest(end[in_face]) for end in ends)
    if size == 0.0:  # every face is in one point, at rest
        return scene, 0
    _require_size(size, ends, in_face)
    exponent = math.frexp(size)[1]
    length = into_range(size, LENGTHS)
    far_out = _far_out(ends, in_face, math.ldexp(1.0, min(exponent + FAR, 1023)))
    if length == 0 and not far_out.any():
        return scene, 0
    _require_exact(ends, ~far_out, length)
    border = math.ldexp(1.0, exponent + length + FAR)
    start, end = (np.clip(times_power(part, length), -border, border) for part in ends)
    return _copy(scene, positions_t0=start, positions_t1=end, on_gpu={}), length


def _are_ordinary(ends: tuple[Positions, Positions], faces: Any) -> bool:
    """Return whether a few faces show that the lengths of a mesh are ordinary.

    This takes 20 us for a small mesh, and is true for nearly all.
    """
    most, known = _bounds_of_size(ends, faces)
    least = max(most * 2.0**-FAR, 2.0**-LENGTHS)
    return most < 2.0**LENGTHS and known >= least


def _bounds_of_size(ends: tuple[Positions, Positions], faces: Any) -> tuple[float, float]:
    """Return an upper and a lower bound of the largest coordinate of the vertices of faces."""
    corners = faces[:FEW].ravel()
    most = max(largest(end) for end in ends)
    return most, max(largest(end.take(corners, axis=0)) for end in ends)


def _far_out(ends: tuple[Positions, Positions], in_face: Flags, border: float) -> Flags:
    """Return which vertices are far out, (n,) b1, or raise if the path of one comes near."""
    beyond = [(end > border) | (end < -border) for end in ends]
    outside = np.asarray((beyond[0] | beyond[1]).any(axis=1))
    if not outside.any():
        return outside
    start, end = ends
    stays = (np.minimum(start, end) > border) | (np.maximum(start, end) < -border)
    off = np.flatnonzero(outside & ~stays.any(axis=1) & ~in_face)
    if len(off):
        raise SizeError(
            f"positions_t1: expected paths within {border:.3g} m, which is 2^{FAR} times the size "
            f"of the mesh, found {len(off)} vertices in no face that go farther, the first is "
            f"vertex {off[0]}: from {start[off[0]].tolist()} to {end[off[0]].tolist()}. Leave such "
            "vertices at rest, or leave them out"
        )
    outside[in_face] = False
    return outside


def _require_size(size: float, ends: tuple[Positions, Positions], in_face: Flags) -> None:
    """Raise an error if no power of two brings a mesh of this size into range."""
    low, high = math.ldexp(1.0, -LARGEST_LENGTH), math.ldexp(1.0, LARGEST_LENGTH)
    if size > high:
        for name, end in zip(("positions_t0", "positions_t1"), ends, strict=True):
            off = np.flatnonzero((np.abs(end) > high).any(axis=1) & in_face)
            if len(off):
                raise SizeError(
                    f"{name}: expected coordinates of at most {high:.3g} [m] for vertices of "
                    f"faces, found {len(off)} vertices with larger ones, the first is vertex "
                    f"{off[0]}: {end[off[0]].tolist()}"
                )
    if size < low:
        raise SizeError(
            f"positions_t0: expected a mesh whose largest coordinate is at least {low:.3g} [m], "
            f"got one with {size:.3g}, where floats have too few digits left. Multiply all "
            "coordinates and the thickness by a power of two"
        )


def _require_exact(ends: tuple[Positions, Positions], used: Flags, length: int) -> None:
    """Raise an error if a coordinate loses digits when it is multiplied by 2^length."""
    if length >= 0:
        return
    for name, end in zip(("positions_t0", "positions_t1"), ends, strict=True):
        changed = (times_power(times_power(end, length), -length) != end) & used[:, None]
        off = np.argwhere(changed)
        if len(off):
            vertex, axis = off[0].tolist()
            least = math.ldexp(1.0, -1022 - length)
            raise SizeError(
                f"{name}: expected coordinates that are 0 or at least {least:.3g} [m] in a mesh "
                f"of this size, found {len(off)} smaller ones, the first is "
                f"{end[vertex, axis]:.3g} at vertex {vertex}; set them to 0"
            )


def _copy(scene: AnyScene, **changed: Any) -> AnyScene:
    """Return a scene with other arrays."""
    twin = copy.copy(scene)
    for name, value in changed.items():
        setattr(twin, name, value)
    return twin


def positions_back(scene: SceneArrays, twin: SceneArrays, ends: Positions, units: Units) -> Any:
    """Return end positions of a twin in the units of the scene.

    A vertex that ends at its proposed position ends there bit for bit.

    Args:
        scene: The scene.
        twin: The scene of ordinary size that `scene_in_range` returned for it.
        ends: (n, 3) f8, end positions of the twin.
        units: The powers of two of the twin.

    Returns:
        (n, 3) f8 [m].

    Raises:
        SizeError: A vertex ends where no float is; names the first one.
    """
    unmoved = (ends == twin.positions_t1).all(axis=1)
    back = np.where(unmoved[:, None], scene.positions_t1, times_power(ends, -units.length))
    off = np.flatnonzero(~np.isfinite(back).all(axis=1))
    if len(off):
        raise SizeError(
            f"positions_t1: expected a step whose answer floats can hold, but vertex {off[0]} has "
            "to end beyond the largest float. Divide all coordinates and the thickness by a power "
            "of two"
        )
    return back


def thickness_in_range(thickness: float, scene: SceneArrays, units: Units) -> float:
    """Return a thickness in the units of a twin.

    Args:
        thickness: Distance that impacts keep at the end [m].
        scene: The scene of ordinary size, as `scene_in_range` returned it.
        units: Its powers of two.

    Raises:
        ThicknessError: The thickness is too large or too small beside the coordinates.
    """
    if len(scene.faces) == 0:
        return thickness
    ends, scaled = (
        (scene.positions_t0, scene.positions_t1),
        float(times_power(thickness, units.length)),
    )
    exact = times_power(scaled, -units.length) == thickness
    # All vertices bound the size of the mesh from above, and a few faces bound it from below. That
    # settles nearly every thickness; the corners of all faces of a million take 0.2 s.
    most, known = _bounds_of_size(ends, scene.faces)
    if exact and math.ldexp(most, THINNEST + 1) <= scaled <= math.ldexp(known, THICKEST - 1):
        return scaled
    vertices = scene.faces.ravel()
    size = max(largest(end[vertices]) for end in ends)
    exponent = math.frexp(size)[1] if size > 0.0 else 0
    low, high = (math.ldexp(1.0, exponent + k) for k in (THINNEST, THICKEST))
    if low <= scaled <= high and exact:
        return scaled
    least, most = (float(times_power(limit, -units.length)) for limit in (low, high))
    raise ThicknessError(
        f"thickness: expected a number from {least:.3g} to {most:.3g} [m] beside coordinates of up "
        f"to {float(times_power(size, -units.length)):.3g} m, got {thickness:.3g}"
    )


def near_mesh(scene: SceneArrays) -> Positions:
    """Return the start of a scene, with vertices that are far out on the border of the mesh.

    They are for orders in space alone: with vertices far out, all others would be in one cell.

    Args:
        scene: The scene of ordinary size.
    """
    start = scene.positions_t0
    most = math.ldexp(largest(start), 1 - FAR)
    if len(scene.faces) == 0 or largest(start[scene.faces[:FEW].ravel()]) > most:
        return start
    corners = start[scene.faces.ravel()]
    if largest(corners) > most:
        return start
    return np.clip(start, corners.min(axis=0), corners.max(axis=0))
