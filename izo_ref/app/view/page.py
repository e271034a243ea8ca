"""The page of a view: one file of HTML that works from the disk, without a network."""

from __future__ import annotations

import base64
import html
import json
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from izo_ref.app.view.model import STEPS, Kind, ShownPairs, Side, Table, View, grid_of
from izo_ref.app.view.pack import pack
from izo_ref.base.arrays import AnyArray, Ints

# The modules of the page by the names under which they import each other.
MODULES = {
    "three": "three/three.module.min.js",
    "three-core": "three/three.core.min.js",
    "three-orbit": "three/OrbitControls.js",
    "izo/unpack": "js/unpack.js",
    "izo/model": "js/model.js",
    "izo/colors": "js/colors.js",
    "izo/paint": "js/paint.js",
    "izo/stage": "js/stage.js",
    "izo/marks": "js/marks.js",
    "izo/list": "js/list.js",
    "izo/keys": "js/keys.js",
    "izo/controls": "js/controls.js",
    "izo/main": "js/main.js",
}
TICKS = 2**20  # times from 0 to 1 are whole numbers up to this one; -1 is no time
NAMED = 20  # pairs that the text of the page names, for readers without 3D
KINDS = {
    Kind.VERTEX_FACE: ("vertex", 1, "face"),
    Kind.EDGE_EDGE: ("edge", 2, "edge"),
    Kind.EDGE_THROUGH_FACE: ("edge", 2, "face"),
    Kind.FACE_FACE: ("face", 3, "face"),
}


def view_page(view: View) -> str:
    """Return the page.

    Args:
        view: What it shows.
    """
    check_arrays(view)
    tones = {True: "good", False: "bad", None: "plain"}
    named = _named_pairs(view)
    tables = [*view.tables, *([named] if named.rows else [])]
    parts = {
        "title": html.escape(view.title),
        "verdict": html.escape(view.verdict),
        "tone": tones[view.passed],
        "notes": "".join(f"<p>{html.escape(note)}</p>" for note in view.notes),
        "tables": "\n".join(map(_table, tables)),
        "style": _text("page.css"),
        "licence": html.escape(_text("three/LICENSE").strip()),
        "imports": _import_map(),
        "data": _json(_content(view)),
    }
    begin, *rest = _text("page.html").split("{{")
    out = [begin]
    for piece in rest:
        name, _, after = piece.partition("}}")
        out += parts[name], after
    return "".join(out)


@cache
def _text(name: str) -> str:
    return (files("izo_ref.app.view") / name).read_text(encoding="utf-8")


@cache
def _import_map() -> str:
    """Return the import map: each module is in its address, so that nothing is loaded."""
    imports = {}
    for name, path in MODULES.items():
        source = _text(path)
        if name.startswith("three"):  # an address that is relative to a file leads nowhere here
            source = source.replace('"./three.core.min.js"', '"three-core"')
            source = source.replace("from 'three'", 'from "three"')
        encoded = base64.b64encode(source.encode()).decode("ascii")
        imports[name] = f"data:text/javascript;base64,{encoded}"
    return json.dumps({"imports": imports})


def _json(content: Any) -> str:
    """Return JSON that may stand in a script: no name can end the script or begin a comment."""
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")


def _content(view: View) -> dict[str, Any]:
    """Return what the scripts of the page read (`js/model.js`)."""
    grid = grid_of(view)
    zones = view.zone_of
    sides, last = [], None
    for side in view.sides:
        whole = [grid.whole(positions) for positions in side.positions]
        sides.append(_side(side, whole, last))
        last = whole
    return {
        "title": view.title,
        "isStep": view.is_step,
        "up": view.up,
        "radius": grid.radius_m if np.isfinite(grid.radius_m) else 0.0,
        "steps": STEPS,
        "ticks": TICKS,
        "frames": view.frames,
        "parts": view.parts,
        "faces": pack(view.faces),
        "partOf": pack(view.part_of),
        "pinned": pack(view.pinned.astype(np.int32)),
        "zoneOf": None if zones is None else pack(zones),
        "nZones": 0 if zones is None else int(zones.max(initial=-1)) + 1,
        "sides": sides,
    }


def _side(side: Side, whole: list[Ints], other: list[Ints] | None) -> dict[str, Any]:
    """Return a side; frames are packed from the frame before, or from the other side's frame."""
    frames = []
    for i, numbers in enumerate(whole):
        base = whole[i - 1] if i else None
        frames.append(pack(numbers, base if other is None else other[i]))
    return {
        "name": side.name,
        "positions": frames,
        "pairs": [_pairs(pairs) for pairs in side.pairs],
        "nPairs": side.n_pairs,
    }


def _pairs(pairs: ShownPairs) -> dict[str, Any] | None:
    if not len(pairs.kinds):
        return None
    times = np.where(np.isnan(pairs.times), -1.0, np.rint(pairs.times * TICKS))
    return {
        "nodes": pack(pairs.nodes),
        "kinds": pack(pairs.kinds),
        "times": pack(times.astype(np.int32)),
    }


def _named_pairs(view: View) -> Table:
    """Return a table of the first pairs of each side, in words."""
    rows = []
    for side in reversed(view.sides):  # what is wrong after resolving comes first
        for frame, pairs in zip(view.frames, side.pairs, strict=True):
            for i in range(min(len(pairs.kinds), NAMED - len(rows))):
                place = "" if view.is_step else f"frame {frame}"
                rows.append((side.name, place, pair_sentence(pairs, i)))
    return Table("The first pairs", ("Where", "When", "What"), rows)


def pair_sentence(pairs: ShownPairs, i: int) -> str:
    """Say which pair it is, and when it meets.

    Args:
        pairs: The pairs.
        i: Number of the pair among them.
    """
    first, split, second = KINDS[Kind(pairs.kinds[i])]
    nodes = pairs.nodes[i][pairs.nodes[i] >= 0]
    sides = f"{first} {_ids(nodes[:split])} and {second} {_ids(nodes[split:])}"
    time = pairs.times[i]
    return f"{sides} cross" if np.isnan(time) else f"{sides} meet at t = {time:.6g}"


def _ids(nodes: Ints) -> str:
    return "(" + " ".join(map(str, nodes.tolist())) + ")"


def _table(table: Table) -> str:
    """Return a table in HTML."""
    heads = "".join(f'<th scope="col">{html.escape(head)}</th>' for head in table.heads)
    rows = [f"<thead><tr>{heads}</tr></thead>"] if heads else []
    for row in table.rows:
        cells = [html.escape(cell) for cell in row]
        if heads:
            mark = f' class="{cells[0]}"' if cells[0] in ("passed", "failed") else ""
            inner = "".join(f"<td>{cell}</td>" for cell in cells)
            rows.append(f"<tr{mark}>{inner}</tr>")
        else:
            inner = "".join(f"<td>{cell}</td>" for cell in cells[1:])
            rows.append(f'<tr><th scope="row">{cells[0]}</th>{inner}</tr>')
    body = "\n".join(rows)
    title = html.escape(table.title)
    return f'<section><h2>{title}</h2><div class="wide"><table>\n{body}\n</table></div></section>'


def check_arrays(view: View) -> None:
    """Raise an error if the arrays of a view do not fit each other, which is a mistake of ours."""
    n = len(view.part_of)
    shapes: list[tuple[AnyArray, tuple[int, ...]]] = [(view.pinned, (n,))]
    shapes += [(p, (n, 3)) for side in view.sides for p in side.positions]
    if view.zone_of is not None:
        shapes.append((view.zone_of, (n,)))
    wrong = [array.shape for array, shape in shapes if array.shape != shape]
    counts = {len(x) for s in view.sides for x in (s.positions, s.pairs, s.n_pairs)}
    if wrong or counts != {len(view.frames)}:
        raise ValueError(f"a view of {n} vertices and {len(view.frames)} frames: {wrong}, {counts}")
