"""The HTML page of a verdict: a table of facts, and pictures of everything that is wrong."""

import base64
import html
import io
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np

from izo_ref.app.picture import draw
from izo_ref.app.summary import excluded_line
from izo_ref.base.arrays import AnyInts, Flags, Floats, Indices, Ints, Positions
from izo_ref.scene import Scene
from validation.check import Verdict
from validation.judge import Fact

Picture: TypeAlias = tuple[str, str]  # PNG in base64, caption
Color: TypeAlias = tuple[int, int, int]
Segment: TypeAlias = tuple[Floats, Floats, Color]  # two points [m], color

GREY, RED = (170, 174, 180), (210, 30, 45)
SIDES = ((235, 150, 40), (60, 120, 210))  # first and second side of a pair
PAIRS_DRAWN = 4
# Half the width of a picture of a pair, over the size of the pair.
AROUND = 3.0


def verdict_page(title: str, scene: Scene, verdict: Verdict) -> str:
    """Return the HTML page of a verdict on a result of this scene; it needs no other file."""
    pictures = [_whole_mesh(scene, verdict)]
    pictures += [_pair(scene, verdict, i) for i in _drawn(verdict)]
    apart = _first_disjoint(verdict.crossing)
    pictures += [_crossing(scene, verdict, verdict.crossing[i]) for i in apart]
    rows = "\n".join(_row(fact) for fact in verdict.facts)
    word = "passed" if verdict.passed else "failed"
    if verdict.excluded["count"]:
        word += ", except for pairs that were left out"
    figures = "\n".join(
        f'<figure><img src="data:image/png;base64,{data}" alt="{html.escape(caption)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        for data, caption in pictures
    )
    left_out = _left_out(verdict)
    return PAGE.format(
        title=html.escape(title), word=word, left_out=left_out, rows=rows, figures=figures
    )


def _left_out(verdict: Verdict) -> str:
    """Return a paragraph about the pairs that were left out, and a list of the first ones."""
    summary = verdict.excluded
    if not summary["count"]:
        return ""
    items = "\n".join(
        f"<li>{row['kind']} {row['nodes']}: {row['reason']}, {row['at_end']} at the end</li>"
        for row in summary["first"]
    )
    return (
        f"<p><strong>Nothing is said about some pairs.</strong> {excluded_line(summary)}. "
        f"The first of them:</p>\n<ul>\n{items}\n</ul>"
    )


def _row(fact: Fact) -> str:
    mark = {True: "passed", False: "failed", None: "info"}[fact.passed]
    cells = (fact.question, fact.by, fact.answer, f"{fact.seconds:.2f} s")
    inner = "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
    return f'<tr class="{mark}"><td>{mark}</td>{inner}</tr>'


def _drawn(verdict: Verdict) -> Indices:
    """Return the first pairs to meet that share no vertex, so that they show different places."""
    order = np.argsort(verdict.meeting_toi, kind="stable")
    return order[_first_disjoint(verdict.meeting.nodes[order])]


def _first_disjoint(pairs: AnyInts) -> list[int]:
    """Return the first pairs, at most PAIRS_DRAWN, that share no element."""
    chosen: list[int] = []
    seen: set[int] = set()
    for i, elements in enumerate(pairs.tolist()):
        if not seen.intersection(elements):
            chosen.append(i)
            seen.update(elements)
        if len(chosen) == PAIRS_DRAWN:
            break
    return chosen


def _png(positions: Positions, faces: Ints, colors: Ints, **kwargs: Any) -> str:
    """Return a picture as a PNG in base64."""
    file = io.BytesIO()
    draw(positions, faces, colors, file, **kwargs)
    return base64.b64encode(file.getvalue()).decode()


def _whole_mesh(scene: Scene, verdict: Verdict) -> Picture:
    wrong = np.zeros(len(scene.faces), bool)
    wrong[verdict.crossing.ravel()] = True
    hit = np.zeros(len(scene.pinned), bool)
    hit[verdict.meeting.nodes] = True
    wrong |= hit[scene.faces].all(axis=1)
    colors = np.where(wrong[:, None], RED, GREY)
    caption = "The end of the path"
    if wrong.any():
        caption += f"; red: {int(wrong.sum())} faces in pairs that meet or intersect"
    return _png(verdict.positions, scene.faces, colors), caption


def _pair(scene: Scene, verdict: Verdict, i: int) -> Picture:
    """Draw a pair at the time when it meets, with the mesh around it."""
    nodes, toi = verdict.meeting.nodes[i], float(verdict.meeting_toi[i])
    is_edge_edge = bool(verdict.meeting.is_edge_edge[i])
    split = 2 if is_edge_edge else 1
    positions = (1.0 - toi) * scene.positions_t0 + toi * verdict.positions
    first, second = (_faces_with(scene, side) for side in (nodes[:split], nodes[split:]))
    if is_edge_edge:
        kind, lines = "Edge and edge", [(0, 1, 0), (2, 3, 1)]
    else:
        kind, lines = "Vertex and face", [(1, 2, 1), (2, 3, 1), (3, 1, 1)]
    segments = [(positions[nodes[a]], positions[nodes[b]], SIDES[side]) for a, b, side in lines]
    if (
        not is_edge_edge
    ):  # the vertex may be hidden, so a cross marks it: a fifth of the pair's size
        arm = 0.2 * float(np.abs(positions[nodes] - positions[nodes[0]]).max())
        at = positions[nodes[0]]
        segments += [(at - arm * axis, at + arm * axis, SIDES[0]) for axis in np.eye(3)]
    caption = f"{kind} {_ids(nodes[:split])}, {_ids(nodes[split:])} meet at t = {toi:.6g}"
    return _close_up(scene, positions, nodes, (first, second), segments), caption


def _crossing(scene: Scene, verdict: Verdict, pair: Ints) -> Picture:
    """Draw two faces that intersect at the end, with the mesh around them."""
    nodes = np.unique(scene.faces[pair])
    sides = tuple(np.arange(len(scene.faces)) == face for face in pair)
    segments = []
    for side, face in enumerate(pair):
        corners = verdict.positions[scene.faces[face]]
        segments += [(corners[k], corners[k - 1], SIDES[side]) for k in range(3)]
    caption = f"Faces {int(pair[0])} and {int(pair[1])} intersect at the end"
    return _close_up(scene, verdict.positions, nodes, sides, segments), caption


def _close_up(
    scene: Scene,
    positions: Positions,
    nodes: Ints,
    sides: tuple[Flags, ...],
    segments: list[Segment],
) -> str:
    """Draw the mesh around some vertices, with the faces of both sides in color."""
    centre = positions[nodes].mean(axis=0)
    radius = AROUND * float(np.abs(positions[nodes] - centre).max())
    near = (np.abs(positions - centre) <= 2.0 * radius).all(axis=1)
    shown = near[scene.faces].any(axis=1)
    colors = np.broadcast_to(GREY, (len(scene.faces), 3)).copy()
    for side, color in zip(sides, SIDES, strict=True):
        colors[side] = color
    box = centre + radius * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    kwargs = {"frame": box, "segments": segments, "size": (640, 480)}
    return _png(positions, scene.faces[shown], colors[shown], **kwargs)


def _faces_with(scene: Scene, side: Ints) -> Flags:
    """Return which faces have all of these vertices."""
    return np.isin(scene.faces, side).sum(axis=1) == len(side)


def _ids(nodes: Iterable[int]) -> str:
    return "(" + " ".join(str(int(v)) for v in nodes) + ")"


PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}: {word}</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 1100px;
  margin: 0 auto; padding: 1rem; }}
table {{ border-collapse: collapse; width: 100%; }}
th, td {{ border-bottom: 1px solid #e4e4e4; padding: .3rem .5rem; text-align: left;
  vertical-align: top; }}
td:last-child {{ text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }}
tr.passed td:first-child {{ color: #17703a; }}
tr.failed td:first-child {{ color: #b3202f; font-weight: 600; }}
tr.info td:first-child {{ color: #777; }}
.pictures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(22rem, 1fr));
  gap: 1rem; margin-top: 1.5rem; }}
figure {{ margin: 0; }}
figure img {{ width: 100%; border: 1px solid #ddd; box-sizing: border-box; }}
figcaption {{ font-size: .9em; color: #555; }}
</style>
</head>
<body>
<h1>{title}: {word}</h1>
{left_out}
<table>
<tr><th></th><th>Question</th><th>Asked</th><th>Answer</th><th>Time</th></tr>
{rows}
</table>
<div class="pictures">
{figures}
</div>
</body>
</html>
"""
