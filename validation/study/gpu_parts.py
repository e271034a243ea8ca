"""Parts of the study of CUDA: each has a budget of time, and says so when it is cut off."""

import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from izo_ref.base.devices import require_gpu
from izo_ref.base.errors import DeviceUnavailableError
from izo_ref.scene import Scene
from validation.rows import Rows
from validation.scenes.sheets import meeting_sheets
from validation.study import steps
from validation.study.parts import Say

Case = TypeVar("Case")
SEED = 20261128
SIMULATOR = "simulator"
SHEETS = (100_000, 1_000_000, 10_000)  # triangles of the sheets that are made here as steps
REPEATS = 5  # the median of these is taken, after a first call that does not count
CPU_BUDGET_S, GPU_BUDGET_S = 4.0, 4.0  # for all calls of a step


class Clock:
    """Measures the time of a part, and cuts it off when its budget is used up.

    Args:
        folder: Folder of the rows.
        part: Name of the part.
        budget_s: Seconds; no case begins later than this.
    """

    def __init__(self, folder: Path, part: str, budget_s: float) -> None:
        """Begin now."""
        self._begin, self._budget_s = time.perf_counter(), budget_s
        self._rows, self._part = Rows(folder, "cut", ("part",)), part

    def cases(self, cases: Iterable[Case], name: Callable[[Case], str], say: Say) -> Iterator[Case]:
        """Yield the cases that begin within the budget; note in a row where they are cut off."""
        for case in cases:
            spent = time.perf_counter() - self._begin
            if spent > self._budget_s:
                self.cut(name(case), spent, say)
                return
            yield case

    def cut(self, case: str, spent: float, say: Say) -> None:
        """Note that this case, and all behind it, were not measured."""
        self._rows.add(part=self._part, first_left_out=case, spent_s=round(spent, 1))
        say(f"{self._part}: cut off after {spent:.0f} s, before {case}")


# measures the rows that are missing, and returns the first difference if there is one
GpuPart: TypeAlias = Callable[[Path, Say, Clock], str | None]


class Step(NamedTuple):
    """A step that is measured."""

    name: str
    load: Callable[[], Scene]


def gpu_name(part: str, say: Say) -> str | None:
    """Return the name of the GPU; if there is none, say so and return None."""
    try:
        require_gpu()
    except DeviceUnavailableError as error:
        say(f"{part}: {error}")
        return None
    from numba import cuda

    name = getattr(cuda.get_current_device(), "name", SIMULATOR)
    return name.decode() if isinstance(name, bytes) else name


def all_steps() -> Iterator[Step]:
    """Yield the sheets that are made here, and then the step files that exist."""
    for size in SHEETS:
        yield Step(f"meeting-sheets-{size}", lambda n=size: meeting_sheets(seeded(n), n))
    for name in steps.step_names():
        yield Step(name, lambda name=name: steps.load_step(name))


def name_of(step: Step) -> str:
    """Return the name of a step."""
    return step.name


def seeded(size: int) -> np.random.Generator:
    """Return the generator of the sheets with this number of triangles."""
    return np.random.default_rng([SEED, size])
