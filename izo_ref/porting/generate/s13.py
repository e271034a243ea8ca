"""Vectors of stage S13: input that a port must refuse, and input that it must take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from izo_ref.porting.cases import DTYPES, INVALID, VALID, Case
from izo_ref.porting.generate import s12_scenes as scenes
from izo_ref.porting.generate.scene_parts import SceneParts, sheet

NAN, INFINITE = float("nan"), float("inf")
GOOD = 24  # the vertices of `_good`
EDGE_TIP = [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (4.0, 0.0, 4.0)]


class Lot(NamedTuple):
    """A case before it has a number."""

    word: str
    flag: str
    grade: str
    what: str
    inputs: dict[str, Any]
    offender: int | None = None
    also: tuple[str, ...] = ()


def _good(**changes: Any) -> dict[str, Any]:
    """Return the inputs of a sheet that falls onto another one, some of them replaced."""
    parts = SceneParts()
    parts.add(*sheet(3, 0.0))
    parts.add(*sheet(3, 0.125, at=(0.0625, 0.03125)), (0.0, 0.0, -0.25))
    parts.add([(4.0, 4.0, 4.0 + k) for k in range(6)], [])  # vertices in no face
    return {**parts.inputs(), **changes}


def _with(name: str, index: int, value: float) -> dict[str, Any]:
    """Return good inputs of which one number is replaced."""
    inputs = _good()
    values = list(inputs[name])
    values[index] = value
    return {**inputs, name: values}


def _pinned_with(place: int, value: float) -> dict[str, Any]:
    """Return good inputs with one pinned vertex, whose mass is replaced."""
    inputs = _with("masses", place, value)
    return {**inputs, "pinned": [int(v == place) for v in range(GOOD)]}


def _faces(index: int, face: Sequence[int]) -> dict[str, Any]:
    """Return good inputs of which one face is replaced."""
    faces = list(_good()["faces"])
    faces[3 * index : 3 * index + 3] = face
    return _good(faces=faces)


def _two_triangles(second: Sequence[Sequence[float]], **changes: Any) -> dict[str, Any]:
    """Return a large triangle in the plane z = 0, and another one; both are at rest."""
    parts = SceneParts()
    parts.add([(-2.0, -2.0, 0.0), (2.0, -2.0, 0.0), (0.0, 2.0, 0.0)], [[0, 1, 2]])
    parts.add(second, [[0, 1, 2]])
    return {**parts.inputs(), **changes}


def _scaled(factor: float) -> dict[str, Any]:
    """Return good inputs in other units of length."""
    inputs = _good()
    for name in ("positions_t0", "positions_t1"):
        inputs[name] = [factor * c for c in inputs[name]]
    return {**inputs, "thickness": factor * inputs["thickness"]}


def _shapes() -> list[Lot]:
    good, flag = _good(), "bad-shape"
    return [
        Lot("shape", flag, "easy", "The proposed positions have one vertex less than the start.",
            _good(positions_t1=good["positions_t1"][:-3])),
        Lot("shape", flag, "medium", "The last mass is missing.",
            _good(masses=good["masses"][:-1])),
        Lot("shape", flag, "medium", "The last flag of `pinned` is missing.",
            _good(pinned=good["pinned"][:-1])),
        Lot("shape", flag, "hard", "There is one mass too many.",
            _good(masses=[*good["masses"], 1.0])),
        Lot("shape", flag, "hard", "The last face has two vertices only.",
            _good(faces=good["faces"][:-1])),
        Lot("shape", flag, "hard", "The last coordinate of the start and of the end is missing.",
            _good(positions_t0=good["positions_t0"][:-1],
                  positions_t1=good["positions_t1"][:-1])),
    ]  # fmt: skip


def _numbers() -> list[Lot]:
    flag = "bad-number"
    return [
        Lot("number", flag, "easy", "A proposed coordinate is NaN.",
            _with("positions_t1", 3 * 10 + 2, NAN), 10),
        Lot("number", flag, "medium", "A coordinate at the start is infinite.",
            _with("positions_t0", 3 * 4, INFINITE), 4),
        Lot("number", flag, "hard", "A coordinate of a vertex in no face is NaN.",
            _with("positions_t1", 3 * 23 + 1, NAN), 23),
        Lot("number", flag, "hard", "A proposed coordinate of a pinned vertex is -infinity.",
            {**_with("positions_t1", 3 * 2, -INFINITE),
             "pinned": [int(v == 2) for v in range(GOOD)]}, 2),
    ]  # fmt: skip


def _indices() -> list[Lot]:
    flag, faces = "bad-index", _good()["faces"]
    return [
        Lot("index", flag, "easy", "A face has an index that is one too large.",
            _faces(5, (0, 1, GOOD)), 5),
        Lot("index", flag, "medium", "A face has the index -1, which some languages read as the "
            "last vertex.", _faces(3, (0, -1, 4)), 3),
        Lot("index", flag, "hard", "A face has the index 2^32, of which 32 bits would leave 0.",
            _faces(15, (2**32, 13, 16)), 15),
        Lot("index", flag, "medium", "The indices count from 1, so the last one is too large.",
            _good(faces=[v + GOOD - max(faces) for v in faces])),
        Lot("repeated", "degenerate-elements", "easy", "A face has the same vertex twice, one "
            "after the other.", _faces(2, (3, 3, 4)), 2),
        Lot("repeated", "degenerate-elements", "medium", "The first and the last vertex of a face "
            "are the same.", _faces(0, (0, 3, 0)), 0),
        Lot("repeated", "degenerate-elements", "hard", "The last face is one vertex three times, "
            "which is in no other face.", _faces(15, (23, 23, 23)), 15),
        Lot("repeated", "degenerate-elements", "medium", "The second and the third vertex of a "
            "face are the same.", _faces(4, (0, 4, 4)), 4),
    ]  # fmt: skip


def _masses() -> list[Lot]:
    flag = "bad-mass"
    return [
        Lot("mass", flag, "easy", "The mass of a vertex is 0.", _with("masses", 7, 0.0), 7),
        Lot("mass", flag, "medium", "The mass of a vertex is negative.",
            _with("masses", 9, -1.0), 9),
        Lot("mass", flag, "hard", "The mass of a vertex is NaN, for which m <= 0 is false.",
            _with("masses", 17, NAN), 17),
        Lot("mass", flag, "hard", "The mass of a vertex that is not pinned is infinite.",
            _with("masses", 0, INFINITE), 0),
    ]  # fmt: skip


def _thicknesses() -> list[Lot]:
    flag = "bad-thickness"
    return [
        Lot("thickness", flag, "easy", "The thickness is 0.", _good(thickness=0.0)),
        Lot("thickness", flag, "medium", "The thickness is negative.", _good(thickness=-0.0078125)),
        Lot("thickness", flag, "hard", "The thickness is NaN, for which d <= 0 is false.",
            _good(thickness=NAN)),
        Lot("thickness", flag, "hard", "The thickness is infinite.", _good(thickness=INFINITE)),
    ]  # fmt: skip


def _starts() -> list[Lot]:
    flag = "bad-start"
    touches = [(0.0, 0.0, 0.0), (0.5, 0.0, 2.0), (-0.5, 0.0, 2.0)]
    edges = [(0.0, -3.0, 0.0), (0.0, -1.5, 0.0), (0.0, -2.5, 3.0)]
    barely = [(0.0, 0.0, -(2.0**-20)), (0.5, 0.0, 2.0), (-0.5, 0.0, 2.0)]
    seam = [(2.0, -2.0, 0.0), (0.0, 2.0, 0.0), (4.0, 3.0, 1.0)]
    folded = SceneParts()
    flat = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.5, 0.5, 0.0)]
    folded.add(flat, [[0, 1, 2], [0, 1, 3]])
    hinged = SceneParts()
    tent = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.5, 0.5, -1.0), (0.5, 0.5, 1.0)]
    hinged.add(tent, [[0, 1, 2], [0, 3, 4]])
    needle = [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 3.0)]
    return [
        Lot("start", flag, "easy", "An edge goes through a face at the start.",
            _two_triangles(EDGE_TIP)),
        Lot("start", flag, "medium", "A vertex touches the inside of a face at the start.",
            _two_triangles(touches)),
        Lot("start", flag, "medium", "An edge lies in the plane of a face and crosses its border "
            "at the start.", _two_triangles(edges)),
        Lot("start", flag, "hard", "An edge goes through a face by a millionth of its length.",
            _two_triangles(barely)),
        Lot("start", flag, "hard", "Two vertices of a triangle lie at two of another one, as "
            "exporters write seams.", _two_triangles(seam)),
        Lot("start", flag, "hard", "A face is folded flat onto its neighbour.", folded.inputs()),
        Lot("start", flag, "medium", "A face goes through another one with which it shares a "
            "vertex.", hinged.inputs()),
        Lot("start", flag, "hard", "A face without area, whose corners are on a line, goes through "
            "another face.", _two_triangles(needle)),
    ]  # fmt: skip


def _fine() -> list[Lot]:
    """Return input that a port must take."""
    flag, masses, faces = "over-strict", ("pinned-masses",), _good()["faces"]
    book = SceneParts()
    pages = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.5), (0.0, 0.0, 1.0), (0.0, -1.0, 0.5)]
    book.add(pages, [[0, 1, 2], [0, 1, 3], [0, 1, 4]], (0.0, 0.0, 0.25))
    line = [(0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (1.0, 0.0, 1.0)]
    point = [(0.0, 0.0, 1.0)] * 3
    near = [(0.0, 0.0, 2.0**-20), (0.5, 0.0, 2.0), (-0.5, 0.0, 2.0)]
    ratio = [2.0 ** (-20 if v % 2 else 20) for v in range(GOOD)]
    return [
        Lot("fine", flag, "easy", "A sheet falls onto another one; some vertices are in no face.",
            _good()),
        Lot("fine", flag, "easy", "The mass of a pinned vertex is 0.", _pinned_with(4, 0.0),
            also=masses),
        Lot("fine", flag, "medium", "The mass of a pinned vertex is NaN.", _pinned_with(4, NAN),
            also=masses),
        Lot("fine", flag, "medium", "The mass of a pinned vertex is negative.",
            _pinned_with(12, -1.0), also=masses),
        Lot("fine", flag, "easy", "The mesh has no faces.", _good(faces=[])),
        Lot("fine", flag, "easy", "Nothing meets on the path.", scenes.apart().inputs()),
        Lot("fine", flag, "medium", "One face is there twice.", _good(faces=[*faces, *faces[:3]])),
        Lot("fine", flag, "medium", "Three faces share an edge.", book.inputs()),
        Lot("fine", flag, "medium", "A face has no area, because its corners are on a line. It "
            "touches nothing.", _two_triangles(line)),
        Lot("fine", flag, "hard", "A face is a point. It touches nothing.",
            _two_triangles(point)),
        Lot("fine", flag, "medium", "The scene is a micrometre large.", _scaled(2.0**-20)),
        Lot("fine", flag, "medium", "The scene is a thousand kilometres large.", _scaled(2.0**20)),
        Lot("fine", flag, "hard", "Masses differ by 1e12.", _good(masses=ratio)),
        Lot("fine", flag, "hard", "A vertex starts a millionth of a metre above a face; that is "
            "less than the thickness.", _two_triangles(near)),
        Lot("fine", flag, "hard", "All vertices are pinned, and nothing meets.",
            {**scenes.apart().inputs(), "pinned": [1] * 50}),
        Lot("fine", flag, "medium", "The mass of a pinned vertex is infinite, as many solvers "
            "write it.", _pinned_with(7, INFINITE), also=masses),
    ]  # fmt: skip


def cases() -> list[Case]:
    """Return the cases of stage S13."""
    bad = [*_shapes(), *_numbers(), *_indices(), *_masses(), *_thicknesses(), *_starts()]
    result, counts = [], dict[str, int]()
    for lot in [*bad, *_fine()]:
        number = counts[lot.word] = counts.get(lot.word, 0) + 1
        verdict, status = (VALID, "ok") if lot.word == "fine" else (INVALID, "refused")
        expected: dict[str, Any] = {"status": {"judge": "equal", "values": [status]}}
        if lot.offender is not None:
            expected["offender"] = {"judge": "equal", "values": [lot.offender]}
        name = f"S13-{lot.word}-{number:02}"
        flags = (lot.flag, *lot.also)
        result.append(
            Case(name, "S13", flags, verdict, lot.grade, DTYPES, lot.what, lot.inputs, expected)
        )
    return result
