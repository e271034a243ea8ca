"""The recorder of a trace: a step of the loop that writes what it does."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from izo_ref.base.arrays import Indices, Positions
from izo_ref.base.devices import implementation, is_on_gpu
from izo_ref.base.records import DetectionCounts, Impacts
from izo_ref.base.sizes import scene_in_range
from izo_ref.base.units import times_power
from izo_ref.loop.numbering import restore_sides
from izo_ref.loop.step import Step
from izo_ref.porting.trace_files import TraceFolder
from izo_ref.scene import Scene
from izo_ref.zones.grouping import Zones, build_zones
from izo_ref.zones.serial.deep_selection import DEEP
from izo_ref.zones.serial.selection import hopeful_impacts


class Recorder:
    """Writes what the stages of a run make.

    Args:
        scene: The scene of the caller.
        files: The folder.
        selection: The rule by which impacts enter the zones.

    Attributes:
        iterations: One record for each iteration, for `index.json`.
    """

    def __init__(self, scene: Scene, files: TraceFolder, selection: str) -> None:
        """Keep the scene and the folder."""
        self._scene, self._files = scene, files
        self._twin, self._units = scene_in_range(scene)
        self._order: Indices = np.empty(0, np.int64)
        self.thickness = 0.0  # in the units of the loop
        self.selection = selection
        self.iterations: list[dict[str, Any]] = []

    def wrap(self, step: Step, order: Indices, thickness: float) -> Step:
        """Return a step that records itself: the `wrap_step` of `resolve`."""
        self._order, self.thickness = order, thickness
        return cast("Step", _RecordedStep(step, self))

    def begin(self, kind: str, round_number: int, **facts: Any) -> None:
        """Begin another iteration."""
        name = f"iteration-{len(self.iterations) + 1:04d}"
        self.iterations.append({"folder": name, "kind": kind, "round": round_number, **facts})

    def write(self, place: str = "", **arrays: Any) -> None:
        """Write arrays of the iteration that began last."""
        name = self.iterations[-1]["folder"]
        self._files.write(f"{name}/{place}" if place else name, **arrays)

    def note(self, **facts: Any) -> None:
        """Add facts to the iteration that began last."""
        self.iterations[-1].update(facts)

    def write_impacts(self, place: str, impacts: Impacts) -> None:
        """Write impacts of the loop."""
        self.write(place, **columns(restore_sides(impacts, self._order, self._scene.faces)))

    def write_state(self, step: Step) -> None:
        """Write the positions, the multipliers and the objective of a step."""
        force = -self._units.length - self._units.mass
        self.write(
            positions=self.positions_back(step.positions),
            multipliers=times_power(_on_cpu(step.multipliers), force),
            objective=times_power(step.objective(), -2 * self._units.length),
        )

    def positions_back(self, positions: Any) -> Positions:
        """Return positions of the loop in the numbering and in the units of the caller."""
        scene, twin = self._scene, self._twin
        ends = np.empty_like(scene.positions_t1)
        ends[self._order] = _on_cpu(positions)
        if scene.copies is not None:
            ends = ends[scene.copies]
        if twin is scene:
            return ends
        # a vertex that ends at its proposed position ends there bit for bit
        unmoved = (ends == twin.positions_t1).all(axis=1)
        back = times_power(ends, -self._units.length)
        return np.where(unmoved[:, None], scene.positions_t1, back)


class _RecordedStep:
    """A step of the loop that records what it does; everything else is that of the step in it.

    Args:
        step: The step that runs.
        recorder: What writes the arrays.
        round_number: `round` of the iterations, as for `Iteration`.
    """

    def __init__(self, step: Step, recorder: Recorder, round_number: int = 0) -> None:
        """Keep the step."""
        self._step: Step
        self.__dict__.update(_step=step, _recorder=recorder, _round=round_number)

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the step."""
        return getattr(self._step, name)

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute of the step; the fail-safe alone does so, with positions."""
        setattr(self._step, name, value)
        if name == "positions":
            self.__dict__["_round"] = -1
            self._recorder.begin("scale-back", -1)
            self._recorder.write_state(self._step)

    def detect(self) -> DetectionCounts:
        """Detect, and record the impacts of the path."""
        step, recorder = self._step, self._recorder
        counts = step.detect()
        recorder.begin("detect", self._round, **counts._asdict())
        recorder.write(positions_t1=recorder.positions_back(step.positions))
        recorder.write_impacts("found", _impacts_on_cpu(step.found))
        return counts

    def select(self) -> int:
        """Select, and record which impacts could be mended, are deep, and were selected."""
        step, recorder = self._step, self._recorder
        found, positions = _impacts_on_cpu(step.found), _on_cpu(step.positions)
        hopeful = np.empty(len(found.toi), bool)
        own = found.nodes, found.weights, found.normals
        stuck = _on_cpu(step.stuck)
        hopeful_impacts(positions, *own, stuck, recorder.thickness, hopeful)
        n_before = step.n_impacts
        count = step.select()
        added = _impacts_on_cpu(step.impacts).take(np.arange(n_before, n_before + count))
        names = set(_names(added))
        recorder.write("found", hopeful=hopeful, selected=[name in names for name in _names(found)])
        if recorder.selection == "independent":
            is_deep = _on_cpu(step.known_depths) == DEEP
            recorder.write("found", deep=is_deep[found.nodes].any(axis=1))
        recorder.note(selection=recorder.selection, selected=count)
        return count

    def solve(self, first_new: int) -> tuple[int, int]:
        """Solve, and record the zones, the positions and the multipliers."""
        step, recorder = self._step, self._recorder
        counts = step.solve(first_new)
        impacts = _impacts_on_cpu(step.impacts)
        recorder.write_impacts("zones", impacts)
        zones = build_zones(step.scene, impacts)
        recorder.write("zones", zone_of_impact=zone_of_impact(zones, len(impacts.toi)))
        recorder.note(zones=counts[0], solved=counts[1])
        recorder.write_state(step)
        return counts

    def relinearize(self) -> None:
        """Linearize anew; the new weights and normals are recorded when the zones are solved."""
        self.__dict__["_round"] = self._round + 1
        self._step.relinearize()
        self._recorder.begin("relinearize", self._round)

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Restore, and record the positions to which the step returns."""
        self._step.restore(saved)
        self._recorder.begin("restore", self._round)
        self._recorder.write_state(self._step)

    def to_cpu(self) -> Step:
        """Return the same step on the CPU, which records itself too."""
        same = _RecordedStep(self._step.to_cpu(), self._recorder, self._round)
        return cast("Step", same)


def zone_of_impact(zones: Zones, n_impacts: int) -> Indices:
    """Return the zone of each impact; -1 for impacts in no zone, (n_impacts,) i8."""
    numbers = np.full(n_impacts, -1)
    numbers[zones.impacts] = np.repeat(np.arange(len(zones)), np.diff(zones.impact_offsets))
    return numbers


def columns(impacts: Impacts) -> dict[str, Any]:
    """Return the arrays of impacts by the names of `stages.py`."""
    columns = impacts._asdict()
    columns["edge_edge_impacts"] = columns.pop("is_edge_edge")
    return columns


def _names(impacts: Impacts) -> list[tuple[int, ...]]:
    """Return a name for each impact, in one numbering and order of nodes."""
    return list(map(tuple, np.column_stack((impacts.is_edge_edge, impacts.nodes)).tolist()))


def _on_cpu(array: Any) -> Any:
    """Return an array, copied to the CPU if it is on a GPU."""
    device = "cuda" if is_on_gpu(array) else "cpu"
    return implementation(device, np.asarray, "izo_ref.base.gpu_arrays:to_cpu")(array)


def _impacts_on_cpu(impacts: Impacts) -> Impacts:
    return Impacts._make(_on_cpu(column) for column in impacts)
