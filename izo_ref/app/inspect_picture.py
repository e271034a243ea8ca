"""The picture of `izo inspect`: what crosses over the frames, and the worst frame of them."""

from __future__ import annotations

import io
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from izo_ref.app.files import replacing
from izo_ref.app.inspect_report import Worst
from izo_ref.app.inspect_text import WORDS
from izo_ref.app.picture import draw
from izo_ref.base.arrays import AnyArray, Faces, Indices, Positions
from izo_ref.sequence.inspection import Verdict

MOST_SEGMENTS = 2000  # crossing edges that are drawn over everything; more of them hide the mesh
MOST_ROWS = 12  # pairs of parts that have a row
# Dark against light, so that they can be told apart in grey.
OLD, NEW, CROSSED, EDGE = "#1f3a5f", "#e08a3c", (214, 69, 48), (110, 10, 20)
PARTS = ((226, 226, 230), (176, 196, 216), (212, 202, 172), (192, 212, 186))
SIZE = (900, 620)  # pixels of a picture of the mesh
CLOSE = 1.2  # times the box about the longest contour, which the close picture shows
BOX = np.array(list(product((-1.0, 1.0), repeat=3)))


def draw_report(
    path: str,
    report: dict[str, Any],
    faces: Faces,
    part_of: Indices,
    positions: Positions,
    worst: Worst | None,
) -> None:
    """Write a picture of a report.

    Args:
        path: The .png or .svg file to write or to replace.
        report: What `inspect_report` returns.
        faces: (m, 3) i4.
        part_of: (n,) i8, the part of each vertex.
        positions: (n, 3) f8 [m], the worst frame; anything if nothing crosses.
        worst: The frame with the most crossings, or None.

    Raises:
        FileFormatError: The file cannot be written.
    """
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context({"svg.hashsalt": "izo inspect", "font.size": 9}):
        figure = Figure((13.0 if worst else 8.0, 7.5), layout="constrained")
        charts: Any = figure
        if worst is not None:
            halves: Any = figure.subfigures(1, 2, width_ratios=(1.0, 1.1))
            charts = halves[1]
            _draw_mesh(halves[0], faces, part_of, positions, worst)
        _draw_charts(charts, report)
        figure.suptitle(_title(report))
        suffix = Path(path).suffix.lower().removeprefix(".")
        metadata = {"Date": None} if suffix == "svg" else {}
        with replacing(path) as file:
            figure.savefig(file, format=suffix, dpi=130, metadata=metadata)


def _title(report: dict[str, Any]) -> str:
    """Return the name of the input, how many frames are not clean, and the worst verdict."""
    frames = report["frames"]
    wrong = sum(frame["verdict"] != Verdict.CLEAN.name for frame in frames)
    name = Path(report["input"]).name
    if wrong == 0:
        return f"{name}: nothing is wrong in {len(frames)} frames"
    worst = WORDS[report["verdict"]]
    return f"{name}: {wrong} of {len(frames)} frames are not clean; the worst: {worst}"


def _draw_mesh(
    figure: Any, faces: Faces, part_of: Indices, positions: Positions, worst: Worst
) -> None:
    """Draw the whole of the worst frame, and what crosses in it from near."""
    seen = _upright(positions)
    crossed = np.zeros(len(positions), bool)
    crossed[worst.faces] = True
    colors = np.array(PARTS)[part_of[faces[:, 0]] % len(PARTS)]
    colors[crossed[faces].all(axis=1)] = CROSSED
    segments = [(seen[a], seen[b], EDGE) for a, b in worst.edges[:MOST_SEGMENTS].tolist()]
    own = worst.contour_of == np.bincount(worst.contour_of).argmax()
    ends = seen[np.unique(np.hstack((worst.edges, worst.faces))[own])]
    low, high = ends.min(axis=0), ends.max(axis=0)
    corners = 0.5 * (low + high) + 0.5 * CLOSE * (high - low) * BOX
    for axes, frame, title in zip(
        figure.subplots(2, 1),
        (seen[np.unique(faces)], corners),
        (f"frame {worst.number}, which has the most crossings", "its longest contour"),
        strict=True,
    ):
        axes.imshow(_picture(seen, faces, colors, segments, frame))
        axes.set_title(title)
        axes.set_axis_off()


def _picture(
    positions: Positions, faces: Faces, colors: AnyArray, segments: list[Any], frame: Positions
) -> AnyArray:
    """Return a picture of a mesh, (height, width, 3) u1."""
    from PIL import Image

    content = io.BytesIO()
    draw(positions, faces, colors, content, size=SIZE, frame=frame, segments=segments)
    content.seek(0)
    with Image.open(content) as image:
        return np.asarray(image.convert("RGB"))


def _upright(positions: Positions) -> Positions:
    """Return positions with z up: the longer of y and z, because most files do not say which is up.

    Args:
        positions: (n, 3) f8 [m].
    """
    extent = np.ptp(positions, axis=0)
    if extent[1] <= extent[2]:
        return positions
    x, y, z = positions.T
    return np.column_stack((x, -z, y))


def _draw_charts(figure: Any, report: dict[str, Any]) -> None:
    """Draw the counts, the lengths and the pairs of parts over the frames."""
    frames = report["frames"]
    number = np.array([frame["frame"] for frame in frames])
    names = _rows(frames)
    crosses = any(frame["crossings"] for frame in frames)
    heights = [2.0, *[1.4] * crosses, max(0.6, 0.35 * len(names))]
    axes = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    _draw_counts(axes[0], number, frames)
    if crosses:
        for name, style, label in (
            ("width", {"ls": "--", "marker": "s", "color": NEW}, "widest contour"),
            ("reach", {"ls": "-", "marker": "^", "color": "black"}, "reach of what is through"),
            ("depth", {"ls": "-", "marker": "o", "color": OLD}, "depth of the edges"),
        ):
            values = np.array([frame[name] for frame in frames], float)
            values[values == 0.0] = np.nan  # not on a logarithmic axis
            axes[1].plot(number, values, ms=3, label=label, **style)
        axes[1].set(ylabel="m", yscale="log")
        axes[1].legend(loc="best", fontsize=8)
    _draw_rows(figure, axes[-1], frames, names)
    axes[-1].set(xlabel="frame", xlim=(number[0] - 0.6, number[-1] + 0.6))
    axes[-1].xaxis.get_major_locator().set_params(integer=True)


def _draw_counts(axes: Any, number: Indices, frames: list[dict[str, Any]]) -> None:
    """Draw how many crossings each frame has, and how many pairs touch or pass through."""
    new, touching, passing = (
        np.array([frame[name] for frame in frames]) for name in ("new", "touching", "passing")
    )
    old = np.array([frame["crossings"] for frame in frames]) - new
    if old.any():
        axes.bar(number, old, 0.9, color=OLD, label="crossings, also in the frame before")
    if new.any():
        axes.bar(number, new, 0.9, old, color=NEW, label="new crossings")
    for values, marker, label in (
        (touching, "s", "pairs that touch"),
        (passing, "^", "pairs that passed through before"),
    ):
        own = values > 0
        if own.any():
            axes.plot(number[own], values[own], marker, ms=4, color="black", label=label)
    most = max(int((old + new).max()), int(touching.max()), int(passing.max()), 1)
    axes.set(ylabel="pairs", ylim=(0.0, 1.3 * most))  # with room for the legend
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="best", fontsize=8)


def _rows(frames: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Return the pairs of parts that have a row: those with most crossings, in their order."""
    most: dict[tuple[str, str], int] = {}
    for frame in frames:
        for pair in frame["pairs"]:
            name = tuple(pair["parts"])
            most[name] = max(most.get(name, 0), pair["crossings"] + pair["passing"])
    kept = sorted(most, key=lambda name: -most[name])[:MOST_ROWS]
    return [name for name in most if name in kept]


def _draw_rows(
    figure: Any, axes: Any, frames: list[dict[str, Any]], names: list[tuple[str, str]]
) -> None:
    """Draw how many crossings each pair of parts has in each frame, darker for more."""
    from matplotlib.colors import LogNorm

    shade = np.full((max(1, len(names)), len(frames)), np.nan)
    for column, frame in enumerate(frames):
        for pair in frame["pairs"]:
            if tuple(pair["parts"]) in names:
                count = pair["crossings"] + pair["touching"] + pair["passing"]
                shade[names.index(tuple(pair["parts"])), column] = count
    first = frames[0]["frame"]
    extent = (first - 0.5, first + len(frames) - 0.5, len(shade) - 0.5, -0.5)
    norm = LogNorm(1.0, max(10.0, float(np.nanmax(shade, initial=1.0))))
    image = axes.imshow(
        shade, cmap="YlOrBr", norm=norm, extent=extent, aspect="auto", interpolation="nearest"
    )
    labels = [f"{a} with itself" if a == b else f"{a} x {b}" for a, b in names] or [
        "nothing crosses"
    ]
    axes.set_yticks(range(len(labels)), labels)
    if names:
        figure.colorbar(image, ax=axes, label="crossings, touching and\npassing pairs")
