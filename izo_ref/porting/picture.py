"""A picture of the pair, the zone or the mesh of a case, as SVG that needs nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from izo_ref.base.errors import VectorsError
from izo_ref.porting.cases import Case
from izo_ref.porting.views import SIZE, View, best_view

Points = list[tuple[float, float, float]]

START, END, MET, PINNED = "#3b6fb6", "#c05020", "#207040", "#707070"
LINE = 16.0  # height of a line of text [pixels]
LARGEST = 1e100  # coordinates beyond it cannot be drawn


def case_picture(case: Case) -> str:
    """Return a picture of a case: a pair, a zone, or a mesh at its start and its end.

    Args:
        case: The case.

    Raises:
        VectorsError: The case has nothing to draw.
    """
    inputs = case.inputs
    if "start" in inputs:
        drawn = _pair(case)
    elif "proposed" in inputs:
        drawn = _zone(case)
    elif "positions_t0" in inputs:
        drawn = _mesh(case)
    else:
        raise VectorsError(
            f"{case.id}: expected a case with positions, which those of {case.stage} have not"
        )
    return _document(case, *drawn)


def _points(case_id: str, flat: Any) -> Points:
    """Return points from a flat list of coordinates."""
    if len(flat) % 3 or not flat or not all(abs(number) < LARGEST for number in flat):
        raise VectorsError(f"{case_id}: expected coordinates that can be drawn")
    return [(flat[i], flat[i + 1], flat[i + 2]) for i in range(0, len(flat), 3)]


def _pair(case: Case) -> tuple[list[str], dict[str, str]]:
    """Return what is drawn of a pair, and the legend: start, end, and the time of impact."""
    start = _points(case.id, case.inputs["start"])
    end = _points(case.id, case.inputs["end"])
    ee = bool(case.inputs["is_edge_edge"])
    toi = _time(case)
    met = [] if toi is None else [_between(a, b, toi) for a, b in zip(start, end, strict=True)]
    view = best_view(start + end)
    parts = [_line(view, a, b, PINNED, "2 4") for a, b in zip(start, end, strict=True)]
    for points, colour in ((start, START), (end, END), (met, MET)):
        if points:
            parts += _elements(view, points, ee, colour)
    parts += [_label(view, point, str(k)) for k, point in enumerate(start)]
    legend = {START: "t = 0", END: "t = 1"}
    if toi is not None:
        legend[MET] = f"t = {toi:.6g}, with the closest points"
        ends = _closest(met, ee)
        parts += [
            _line(view, ends[0], ends[1], MET),
            *(_dot(view, point, MET, 4.0) for point in ends),
        ]
    return parts, legend


def _time(case: Case) -> float | None:
    """Return the time of impact of a pair, if the case has one."""
    if "toi" in case.inputs:
        return float(case.inputs["toi"])  # type: ignore[arg-type]
    expected = case.expected.get("toi", {})
    for name in ("time", "values", "low"):
        if name in expected:
            value = expected[name]
            return float(value[0] if isinstance(value, list) else value)
    return None


def _between(a: Sequence[float], b: Sequence[float], t: float) -> tuple[float, float, float]:
    x, y, z = ((1.0 - t) * p + t * q for p, q in zip(a, b, strict=True))
    return x, y, z


def _closest(points: Points, ee: bool) -> Points:
    """Return the two closest points of a pair, sampled: good enough for a drawing.

    The face or the second edge is searched on a grid that is refined around the best point.
    """
    first = points[:2] if ee else points[:1] * 2
    second = [points[2], points[3], points[3]] if ee else points[1:]
    best, at, width = math.inf, (0.5, 1.0 / 3.0, 1.0 / 3.0), 1.0
    ends: Points = []
    for _ in range(12):
        centre = at
        for offset in _offsets(width):
            s, u, v = (min(max(c + d, 0.0), 1.0) for c, d in zip(centre, offset, strict=True))
            if u + v > 1.0:
                continue
            p = _between(first[0], first[1], s)
            rows = zip(second[0], second[1], second[2], strict=True)
            x, y, z = ((1.0 - u - v) * a + u * b + v * c for a, b, c in rows)
            distance = math.dist(p, (x, y, z))
            if distance < best:
                best, at, ends = distance, (s, u, v), [p, (x, y, z)]
        width *= 0.4
    return ends


def _offsets(width: float) -> list[tuple[float, float, float]]:
    steps = [width * k / 4.0 for k in range(-4, 5)]
    return [(a, b, c) for a in steps for b in steps for c in steps]


def _elements(view: View, points: Points, ee: bool, colour: str) -> list[str]:
    """Return the drawing of a vertex and a face, or of two edges."""
    if ee:
        sides = [
            _line(view, points[0], points[1], colour),
            _line(view, points[2], points[3], colour),
        ]
    else:
        sides = [_face(view, points[1:], colour), _dot(view, points[0], colour, 4.0)]
    return sides


def _zone(case: Case) -> tuple[list[str], dict[str, str]]:
    """Return what is drawn of a zone: proposed positions, impacts, normals, and the answer."""
    inputs = case.inputs
    proposed = _points(case.id, inputs["proposed"])
    answer = case.expected.get("positions", {}).get("values") or inputs.get("positions")
    other = [] if answer is None else _points(case.id, answer)
    view = best_view(proposed + other)
    pinned: Any = inputs["pinned"]
    parts = _impacts(view, proposed, inputs)
    for k, point in enumerate(proposed):
        colour = PINNED if pinned[k] else END
        parts += [_dot(view, point, colour, 5.0), _label(view, point, str(k))]
    legend = {END: "proposed positions", PINNED: "pinned vertices", MET: "normals of impacts"}
    if other:
        parts += [_line(view, a, b, START, "2 4") for a, b in zip(proposed, other, strict=True)]
        parts += [_dot(view, point, START, 2.5) for point in other]
        legend[START] = "the answer" if "positions" in case.expected else "where to evaluate"
    return parts, legend


def _impacts(view: View, points: Points, inputs: Mapping[str, Any]) -> list[str]:
    """Return the drawing of the impacts of a zone: their sides, closest points and normals."""
    parts = []
    length = 40.0 / view.scale
    for j in range(len(inputs["nodes"]) // 4):
        nodes = [points[node] for node in inputs["nodes"][4 * j : 4 * j + 4]]
        weights = inputs["weights"][4 * j : 4 * j + 4]
        normal = inputs["normals"][3 * j : 3 * j + 3]
        parts += _elements(view, nodes, weights[1] > 0.0, "#b0b0b0")
        at = _side(nodes, [max(-weight, 0.0) for weight in weights])
        tip = (at[0] + length * normal[0], at[1] + length * normal[1], at[2] + length * normal[2])
        parts += [_line(view, at, tip, MET), _dot(view, at, MET, 3.0)]
        parts += [_dot(view, _side(nodes, [max(w, 0.0) for w in weights]), MET, 2.0)]
    return parts


def _side(nodes: Points, weights: list[float]) -> tuple[float, float, float]:
    x, y, z = (
        math.fsum(weight * node[axis] for weight, node in zip(weights, nodes, strict=True))
        for axis in range(3)
    )
    return x, y, z


def _mesh(case: Case) -> tuple[list[str], dict[str, str]]:
    """Return what is drawn of a mesh: its faces at the start and at the end."""
    start = _points(case.id, case.inputs["positions_t0"])
    end = _points(case.id, case.inputs["positions_t1"])
    faces: Any = case.inputs["faces"]
    pinned: Any = case.inputs.get("pinned", [])
    fits = len(start) == len(end) >= len(pinned) and len(faces) % 3 == 0
    if not fits or not all(0 <= vertex < len(start) for vertex in faces):
        raise VectorsError(f"{case.id}: expected a mesh that can be drawn, found a bad one")
    view = best_view(start + end)
    parts = []
    for points, colour in ((start, START), (end, END)):
        for i in range(0, len(faces), 3):
            parts.append(_face(view, [points[k] for k in faces[i : i + 3]], colour))
    parts += [_dot(view, end[k], PINNED, 2.5) for k in range(len(pinned)) if pinned[k]]
    return parts, {START: "t = 0", END: "proposed, t = 1", PINNED: "pinned vertices"}


def _line(view: View, a: Sequence[float], b: Sequence[float], colour: str, dashes: str = "") -> str:
    (x1, y1), (x2, y2) = view(a), view(b)
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
        f'stroke-width="1.5"{dashed}/>'
    )


def _face(view: View, corners: Points, colour: str) -> str:
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(view, corners))
    return (
        f'<polygon points="{points}" fill="{colour}" fill-opacity="0.12" stroke="{colour}" '
        'stroke-width="1.5" stroke-linejoin="round"/>'
    )


def _dot(view: View, point: Sequence[float], colour: str, radius: float) -> str:
    x, y = view(point)
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{colour}"/>'


def _label(view: View, point: Sequence[float], text: str) -> str:
    x, y = view(point)
    return f'<text x="{x + 6.0:.1f}" y="{y - 6.0:.1f}">{text}</text>'


def _document(case: Case, parts: list[str], legend: dict[str, str]) -> str:
    """Return the whole file: title, drawing, legend."""
    height = SIZE + LINE * (len(legend) + 2.0)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIZE:g}" height="{height:g}" '
        f'viewBox="0 0 {SIZE:g} {height:g}" font-family="sans-serif" font-size="12">',
        f"<title>{escape(case.id)}: {escape(case.what)}</title>",
        f'<rect width="{SIZE:g}" height="{height:g}" fill="white"/>',
        *parts,
    ]
    for k, (colour, text) in enumerate(legend.items()):
        y = SIZE + LINE * (k + 1.0)
        lines.append(f'<circle cx="20" cy="{y - 4.0:g}" r="4" fill="{colour}"/>')
        lines.append(f'<text x="32" y="{y:g}">{escape(text)}</text>')
    y = SIZE + LINE * (len(legend) + 1.0)
    lines.append(f'<text x="20" y="{y:g}" fill="#404040">{escape(case.id)}</text>')
    return "\n".join([*lines, "</svg>"]) + "\n"
