"""The page of a verdict: one table, and pictures of whatever is wrong. One file, no network."""

import base64
import html
import io

import numpy as np

from izo_ref.app.picture import draw

GREY, RED = (170, 174, 180), (210, 30, 45)
SIDES = ((235, 150, 40), (60, 120, 210))  # first and second side of a pair
PAIRS_DRAWN = 4
# Half the width of a pair's picture, in sizes of the pair.
AROUND = 3.0


def verdict_page(title, scene, verdict) -> str:
    """HTML of a `Verdict`."""
    pictures = [_whole_mesh(scene, verdict)]
    pictures += [_pair(scene, verdict, i) for i in _drawn(verdict)]
    apart = _first_disjoint(verdict.crossing)
    pictures += [_crossing(scene, verdict, verdict.crossing[i]) for i in apart]
    rows = "\n".join(_row(fact) for fact in verdict.facts)
    word = "passed" if verdict.passed else "failed"
    figures = "\n".join(
        f'<figure><img src="data:image/png;base64,{data}" alt="{html.escape(text)}">'
        f"<figcaption>{html.escape(text)}</figcaption></figure>"
        for data, text in pictures
    )
    return PAGE.format(title=html.escape(title), word=word, rows=rows, figures=figures)


def _row(fact):
    mark = {True: "passed", False: "failed", None: "told"}[fact.passed]
    cells = (fact.question, fact.by, fact.answer, f"{fact.seconds:.2f} s")
    inner = "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
    return f'<tr class="{mark}"><td>{mark}</td>{inner}</tr>'


def _drawn(verdict):
    """The first pairs to meet, no two with a common node: different places of the mesh."""
    order = np.argsort(verdict.meeting_toi, kind="stable")
    return order[_first_disjoint(verdict.meeting.nodes[order])]


def _first_disjoint(rows):
    chosen, seen = [], set()
    for i, row in enumerate(rows.tolist()):
        if not seen.intersection(row):
            chosen.append(i)
            seen.update(row)
        if len(chosen) == PAIRS_DRAWN:
            break
    return chosen


def _png(*args, **kwargs):
    file = io.BytesIO()
    draw(*args, file, **kwargs)
    return base64.b64encode(file.getvalue()).decode()


def _whole_mesh(scene, verdict):
    wrong = np.zeros(len(scene.faces), bool)
    wrong[verdict.crossing.ravel()] = True
    hit = np.zeros(len(scene.pinned), bool)
    hit[verdict.meeting.nodes] = True
    wrong |= hit[scene.faces].all(axis=1)
    colors = np.where(wrong[:, None], RED, GREY)
    text = "The end of the path"
    if wrong.any():
        text += f"; red: {int(wrong.sum())} faces in pairs that meet or intersect"
    return _png(verdict.positions, scene.faces, colors), text


def _pair(scene, verdict, i):
    """A pair that meets, at the time it does, with the mesh around it."""
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
    if not is_edge_edge:  # a vertex can be hidden: a cross of a fifth of the pair's size
        arm = 0.2 * float(np.abs(positions[nodes] - positions[nodes[0]]).max())
        at = positions[nodes[0]]
        segments += [(at - arm * axis, at + arm * axis, SIDES[0]) for axis in np.eye(3)]
    text = f"{kind} {_ids(nodes[:split])}, {_ids(nodes[split:])} meet at t = {toi:.6g}"
    return _close_up(scene, positions, nodes, (first, second), segments), text


def _crossing(scene, verdict, pair):
    nodes = np.unique(scene.faces[pair])
    sides = tuple(np.arange(len(scene.faces)) == face for face in pair)
    segments = []
    for side, face in enumerate(pair):
        corners = verdict.positions[scene.faces[face]]
        segments += [(corners[k], corners[k - 1], SIDES[side]) for k in range(3)]
    text = f"Faces {int(pair[0])} and {int(pair[1])} intersect at the end"
    return _close_up(scene, verdict.positions, nodes, sides, segments), text


def _close_up(scene, positions, nodes, sides, segments):
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


def _faces_with(scene, side):
    """The faces that have all of these vertices."""
    return np.isin(scene.faces, side).sum(axis=1) == len(side)


def _ids(nodes):
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
tr.told td:first-child {{ color: #777; }}
.pictures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(22rem, 1fr));
  gap: 1rem; margin-top: 1.5rem; }}
figure {{ margin: 0; }}
figure img {{ width: 100%; border: 1px solid #ddd; box-sizing: border-box; }}
figcaption {{ font-size: .9em; color: #555; }}
</style>
</head>
<body>
<h1>{title}: {word}</h1>
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
