"""A still picture of a mesh: depth buffer and flat shading; no display is needed."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from izo_ref.base.arrays import AnyArray, AnyFloats, AnyInts, Floats

SUPERSAMPLE = 2  # the picture is drawn larger and scaled down, which smooths the edges
LIGHT = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


def draw(
    positions: AnyFloats,
    faces: AnyInts,
    colors: AnyInts,
    path: Any,
    *,
    eye: Sequence[float] = (1.0, -2.2, 1.3),
    size: tuple[int, int] = (960, 640),
    frame: AnyFloats | None = None,
    segments: Sequence[tuple[Any, Any, Any]] = (),
) -> None:
    """Write a PNG of a mesh seen from far away.

    Args:
        positions: (n, 3) [m].
        faces: (m, 3) integers.
        colors: (m, 3), red, green and blue of each face, from 0 to 255.
        path: Path of the file, or an open file, to write to.
        eye: Direction in which the viewer stands; z is up.
        size: Width and height [pixels].
        frame: (k, 3) [m], positions that have to fit into the picture; `positions` if None.
        segments: Start, end and color of each line that is drawn over everything else.
    """
    from PIL import Image, ImageDraw

    forward = -np.asarray(eye, float) / np.linalg.norm(eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    view = np.column_stack((right, up, forward))
    fitted = (positions if frame is None else frame) @ view
    low, high = fitted.min(axis=0), fitted.max(axis=0)
    pixels = np.array(size) * SUPERSAMPLE
    scale = 0.94 * np.min(pixels / (high - low)[:2])

    def projected(points: AnyFloats) -> Floats:
        seen = points @ view
        middle = 0.5 * (low + high)[:2]
        seen[..., :2] = (seen[..., :2] - middle) * scale * (1.0, -1.0) + 0.5 * pixels
        return seen

    seen = projected(positions)

    corners = positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    shade = 0.4 + 0.6 * np.abs(normals @ LIGHT)
    shaded = np.clip(colors * shade[:, None], 0, 255).astype(np.uint8)

    canvas = np.full((pixels[1], pixels[0], 3), 255, np.uint8)
    depth = np.full((pixels[1], pixels[0]), np.inf)
    for triangle, color in zip(seen[faces], shaded, strict=True):
        _fill(triangle, color, canvas, depth)
    image = Image.fromarray(canvas)
    pen = ImageDraw.Draw(image)
    for start, end, color in segments:
        ends = projected(np.array([start, end]))[:, :2]
        pen.line([tuple(p) for p in ends.tolist()], fill=tuple(color), width=3 * SUPERSAMPLE)
    image = image.resize(size, Image.Resampling.LANCZOS)
    image.save(path, format="PNG", optimize=True)


def _fill(triangle: Floats, color: AnyArray, canvas: AnyArray, depth: Floats) -> None:
    """Color the pixels of one triangle that are nearer than what was drawn before.

    Args:
        triangle: (3, 3) f8, column, row and depth of each corner.
        color: (3,) u1.
        canvas: (height, width, 3) u1, changed.
        depth: (height, width) f8, depth of each pixel, changed.
    """
    low = np.maximum(np.floor(triangle[:, :2].min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(triangle[:, :2].max(axis=0)).astype(int) + 1, depth.shape[::-1])
    (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = triangle.tolist()
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0.0 or (high <= low).any():
        return
    x = np.arange(low[0], high[0])[None, :]
    y = np.arange(low[1], high[1])[:, None]
    b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
    c = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
    z = z0 + b * (z1 - z0) + c * (z2 - z0)
    window = slice(low[1], high[1]), slice(low[0], high[0])
    covered = (b >= 0.0) & (c >= 0.0) & (b + c <= 1.0) & (z < depth[window])
    depth[window][covered] = z[covered]
    canvas[window][covered] = color
