"""Judge a dump: arrays that a port wrote of its own scene, by the names of a trace.

The reference makes the same arrays and they are compared stage by stage. Each stage starts from
what the port itself made before, so one early difference does not hide that later stages are right.

A dump is a folder of .npy files, or one .npz archive. It has the scene, and any of the arrays of
`trace_files.py`; `dumped/arrays.py` lists those that are judged. A trace is a dump too.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Iterator
from typing import Any

import numpy as np

from izo_ref.base.arrays import Positions
from izo_ref.base.errors import IzoError
from izo_ref.base.options import CHOICES, Options
from izo_ref.base.records import Impacts, join_impacts, no_impacts
from izo_ref.certificate.certify import certify_path
from izo_ref.detection.find import find_impacts
from izo_ref.loop.resolve import resolve
from izo_ref.porting.dumped import frames, pairs, zones
from izo_ref.porting.dumped.arrays import Dump, Rows
from izo_ref.porting.dumped.paths import ROOM, Key, Path, keys_of, name_of, prescribed
from izo_ref.porting.dumped.report import DumpReport, Finding, Problem
from izo_ref.scene import Scene
from izo_ref.zones.objective import objective

# The objective of a port's end may be this many times that of `resolve`. Both are ends of loops
# that select impacts in some order, so neither is the least one; this is a choice, not a bound.
WORST = 2.0
OWN_PATH = "the scene and the port's path"


def judge_dump(folder: str | os.PathLike[str]) -> DumpReport:
    """Compare the arrays that a port wrote of its own scene with those of the reference.

    Args:
        folder: A folder of .npy files, or one .npz archive, by the names of a trace.

    Returns:
        One finding for each array that was judged, in the order of the run.

    Raises:
        FileFormatError: A file cannot be read, an array of the scene is missing, or an array has
            another shape or type.
        IzoError: `Scene` does not accept the arrays of the scene.
    """
    dump = Dump(folder)
    judge = _Judge(dump)
    findings = []
    for name in dump.iterations:
        findings += judge.iteration(name)
    findings += judge.result()
    return DumpReport(dump.dtype, tuple(findings), (*dump.notes, *judge.notes))


class _Judge:
    """Goes through a dump, and keeps what the port made so far.

    Args:
        dump: The dump.

    Attributes:
        notes: What could not be judged.
    """

    def __init__(self, dump: Dump) -> None:
        """Begin at the proposed positions."""
        self._dump, self._scene = dump, dump.scene
        self._end: Positions | None = dump.scene.positions_t1  # of the path to examine next
        self._given = "the scene"
        self._known: dict[Key, Impacts] = {}  # the last frame of each pair
        self._entered: Impacts | None = no_impacts()  # those selected so far; None if unknown
        self._ignored = _ignored_keys(dump.scene)
        self.notes: list[str] = []

    def iteration(self, name: str) -> Iterator[Finding]:
        """Judge the arrays of an iteration, in the order in which a loop makes them."""
        dump = self._dump
        given_end = dump.floats(f"{name}/positions_t1")
        if given_end is not None:
            self._end, self._given = given_end, OWN_PATH
        rows = dump.rows(f"{name}/found")
        path = self._path(name)
        if path is not None:
            yield from self._candidates(name, path)
        if rows is not None:
            if path is not None:
                yield from self._found(f"{name}/found", path, rows)
            yield from self._selected(name, rows)
        yield from self._zones(name, rows)
        if dump.get(f"{name}/positions") is not None:
            self._end = dump.floats(f"{name}/positions")
            self._given = f"the scene and the port's positions of {name}"

    def _path(self, name: str) -> Path | None:
        """Return the path of an iteration and its impacts, if something is judged by them."""
        names = ("vertex_face", "edge_edge", "found/nodes")
        if all(self._dump.get(f"{name}/{part}") is None for part in names):
            return None
        if self._end is None or not np.isfinite(self._end).all():
            self.notes.append(f"{name}: the path is not known, so its impacts were not judged")
            return None
        scene = copy.copy(self._scene)
        scene.positions_t1, scene.on_gpu = self._end, {}
        found = find_impacts(scene)
        rows = Rows(found.nodes, found.is_edge_edge, None, found.weights, None)
        kept = ~prescribed(rows, scene.pinned)
        return Path(scene, found.take(kept), self._ignored, self._dump.eps)

    def _candidates(self, name: str, path: Path) -> Iterator[Finding]:
        for part, is_edge_edge in (("vertex_face", False), ("edge_edge", True)):
            nodes = self._dump.get(f"{name}/{part}")
            if nodes is not None:
                problem = pairs.judge_candidates(path, np.asarray(nodes, np.int32), is_edge_edge)
                yield Finding("S1", f"{name}/{part}", self._given, len(nodes), problem)

    def _found(self, place: str, path: Path, rows: Rows) -> Iterator[Finding]:
        """Judge the impacts of a path, each column on its own."""
        count = len(rows.nodes)
        problem = pairs.judge_pairs(path, rows)
        yield Finding("S2", f"{place}/nodes", self._given, count, problem)
        if rows.toi is None:
            return
        yield Finding("S2", f"{place}/toi", self._given, count, pairs.judge_times(path, rows))
        given = "the port's times"
        if rows.weights is not None:
            problem = frames.judge_weights(path, rows)
            yield Finding("S3", f"{place}/weights", given, count, problem)
        if rows.normals is not None:
            problem = frames.judge_normals(path, rows)
            yield Finding("S3", f"{place}/normals", given, count, problem)

    def _selected(self, name: str, rows: Rows) -> Iterator[Finding]:
        """Judge the selection, and keep the impacts that enter the zones."""
        dump, found = self._dump, rows.impacts()
        selected = dump.flags(f"{name}/found/selected")
        for key, row in zip(
            keys_of(rows.nodes, rows.is_edge_edge), range(len(found.toi)), strict=True
        ):
            self._known[key] = found.take(np.array([row]))
        if selected is None:
            if len(found.toi) and dump.get(f"{name}/positions") is not None:
                self._entered = None
            return
        if self._entered is not None:
            self._entered = join_impacts((self._entered, found.take(selected)))
        if rows.toi is None or self._end is None:
            self.notes.append(f"{name}: without times, the selection was not judged")
            return
        hopeful = dump.flags(f"{name}/found/hopeful")
        if rows.weights is None or rows.normals is None:
            hopeful = np.ones(len(found.toi), bool)
        rule = dump.get(f"{name}/selection")
        rule = dump.selections.get(name) if rule is None else str(rule)
        if rule is not None and rule not in zones.RULES:
            self.notes.append(f"{name}: the rule of selection {rule!r} is not known")
            rule = None
        problem, nearest = zones.judge_selection(
            self._scene,
            found,
            self._end,
            hopeful,
            dump.flags(f"{name}/found/deep"),
            selected,
            rule,
            dump.thickness,
        )
        note = "" if rule else f"the dump names no rule; the nearest one is {nearest!r}"
        given = "the port's impacts"
        yield Finding("S4", f"{name}/found/selected", given, len(selected), problem, note)

    def _impacts_in_zones(self, name: str) -> tuple[Impacts | None, str]:
        """Return the impacts in the zones of an iteration, and where they come from."""
        dump = self._dump
        rows = dump.rows(f"{name}/zones")
        if rows is None:
            is_solve = dump.get(f"{name}/found/selected") is not None
            return (self._entered if is_solve else None), "the impacts that the port selected"
        own, given = rows.impacts(), "the port's impacts in zones"
        if rows.weights is None or rows.normals is None:
            known = [self._known.get(key) for key in keys_of(rows.nodes, rows.is_edge_edge)]
            if any(one is None for one in known):
                self.notes.append(
                    f"{name}: {name}/zones has no weights and normals, and neither does "
                    "an earlier `found` for all its pairs, so the positions were not judged"
                )
                return own._replace(normals=np.full((len(own.toi), 3), np.nan)), given
            own = join_impacts(one for one in known if one is not None)
        self._entered = own
        return own, given

    def _zones(self, name: str, found: Rows | None) -> Iterator[Finding]:
        """Judge the zones of an iteration, and what their solution is."""
        dump, scene = self._dump, self._scene
        numbers, positions = (
            dump.get(f"{name}/{part}") for part in ("zones/zone_of_impact", "positions")
        )
        if numbers is None and positions is None:
            return
        impacts, given = self._impacts_in_zones(name)
        if impacts is None:
            if found is not None and len(found.nodes):
                self.notes.append(
                    f"{name}: neither {name}/found/selected nor {name}/zones/nodes is there, so "
                    "zones and positions were not judged"
                )
            return
        if numbers is not None:
            if len(numbers) == len(impacts.toi):
                problem = zones.judge_partition(scene, impacts, numbers)
            else:
                text = f"expected one number for each of the {len(impacts.toi)} impacts in zones"
                problem = Problem(text, got=f"{len(numbers)} numbers")
            yield Finding("S5", f"{name}/zones/zone_of_impact", given, len(numbers), problem)
        numbers_only = np.isfinite(impacts.normals).all() and np.isfinite(impacts.weights).all()
        if positions is not None and numbers_only:
            yield from self._solution(name, impacts, positions, given)

    def _solution(
        self, name: str, impacts: Impacts, positions: Any, given: str
    ) -> Iterator[Finding]:
        """Judge positions, multipliers and the objective after a solve."""
        dump, scene, eps = self._dump, self._scene, self._dump.eps
        problem, count, infeasible = zones.judge_positions(
            scene, impacts, positions, dump.thickness, dump.dtype
        )
        note = f"{infeasible} zones have no solution, and were not judged" if infeasible else ""
        yield Finding("S11", f"{name}/positions", given, count, problem, note)
        ends = positions.astype(np.float64)
        if not np.isfinite(ends).all():
            return
        given = "the port's positions"
        multipliers = dump.floats(f"{name}/multipliers")
        if multipliers is not None and len(multipliers) == len(impacts.toi) and not infeasible:
            problem = zones.judge_multipliers(scene, impacts, ends, multipliers, dump.dtype)
            yield Finding("S11", f"{name}/multipliers", given, len(multipliers), problem)
        value = dump.get(f"{name}/objective")
        if value is not None:
            problem = zones.judge_objective(scene, ends, float(value), eps)
            yield Finding("S6", f"{name}/objective", given, 1, problem)

    def result(self) -> Iterator[Finding]:
        """Judge the end of the run: its path by the certificate, and its objective."""
        dump, scene = self._dump, self._scene
        positions = dump.get("result/positions")
        if positions is None:
            return
        place, given = "result/positions", "the scene"
        problem = zones.judge_unmoved(scene, ~scene.pinned, positions, dump.eps)
        if problem is None:
            problem = self._judge_end(positions.astype(np.float64))
        yield Finding("S12", place, given, len(positions), problem)
        value = dump.get("result/objective")
        if value is not None and np.isfinite(positions).all():
            ends = positions.astype(np.float64)
            problem = zones.judge_objective(scene, ends, float(value), dump.eps)
            yield Finding("S6", "result/objective", "the port's positions", 1, problem)

    def _judge_end(self, ends: Positions) -> Problem | None:
        """Return what is wrong with end positions."""
        dump, scene = self._dump, self._scene
        says_free = dump.flags("result/free")
        try:
            certificate = certify_path(scene, ends)
        except IzoError as error:
            return Problem(f"the end positions are refused: {error}")
        if not certificate.free and (says_free is None or says_free):
            nodes, kind = certificate.meeting.nodes[0], bool(certificate.meeting.is_edge_edge[0])
            time = float(certificate.meeting_toi[0])
            sentence = f"the path is not free: {name_of(nodes, kind)} meet at t = {time!r}"
            vertices, count = tuple(nodes.tolist()), len(certificate.meeting_toi)
            return Problem(sentence, None, vertices, "a free path", "a path that meets", count)
        rule = next(iter(dump.selections.values()), "independent")
        chosen = rule if rule in CHOICES["selection"] else "independent"
        expected = resolve(scene, dump.thickness, options=Options(selection=chosen))
        if not expected.certificate.free:
            return None
        if not certificate.free:
            return Problem("the port found no free path, and there is one", None, (), "1", "0")
        own = objective(scene, ends)
        extent = float(np.abs(scene.positions_t1).max(initial=0.0))
        room = (ROOM * dump.eps * extent) ** 2
        if own <= WORST * expected.objective + room:
            return None
        sentence = (
            f"the path is free, but its end is {own / max(expected.objective, 1e-300):.3g} times "
            "as far from the proposed positions, by the objective, as that of the reference"
        )
        return Problem(sentence, None, (), repr(float(expected.objective)), repr(float(own)))


def _ignored_keys(scene: Scene) -> frozenset[Key]:
    """Return the keys of pairs that are left out, or that touch at the start."""
    keys: set[Key] = set()
    for part in (scene.excluded, scene.touching):
        if part is not None:
            keys |= set(keys_of(part.nodes, part.is_edge_edge))
    return frozenset(keys)
