"""The families of inputs, each with its share, and the seed of the run that is reported."""

from pathlib import Path

from validation.fuzz import (
    archives,
    calls,
    calls_check,
    calls_detection,
    calls_zones,
    readers,
)
from validation.fuzz.arrays import Rng
from validation.fuzz.run import Family, MakeTrial
from validation.fuzz.trial import Trial

SEED = 21
COUNT = 100_000
WHOLE = 1000  # of so many inputs, each family has its share; the shares are a little more in all
SMALL = 192 << 20  # bytes that a batch of readers may take: a hostile file may not ask for more


def _without_files(make: "calls.MakeCall") -> MakeTrial:
    def make_trial(rng: Rng, folder: Path) -> Trial:
        return make(rng)

    return make_trial


FAMILIES: dict[str, Family] = {
    "Scene": Family(_without_files(calls.scene_trial), 330),
    "Scene.after": Family(_without_files(calls.after_trial), 30),
    "resolve": Family(_without_files(calls.resolve_trial), 50),
    "certify_path": Family(_without_files(calls.certify_trial), 50),
    "solve_zone": Family(_without_files(calls_zones.zone_trial), 120),
    "step archive": Family(archives.step_trial, 140, SMALL),
    "result archive": Family(archives.result_trial, 80, SMALL),
    "dump archive": Family(archives.dump_trial, 40, SMALL),
    "dump folder": Family(archives.npy_trial, 30, SMALL),
    "path": Family(readers.path_trial, 20, SMALL),
    "pipe in a dump": Family(readers.pipe_in_dump_trial, 5, SMALL),
    "vectors": Family(readers.vectors_trial, 30, SMALL),
    "sums of vectors": Family(readers.sums_trial, 10, SMALL),
    "replies": Family(readers.replies_trial, 25, SMALL),
    "known failures": Family(readers.known_trial, 10, SMALL),
    "index of a trace": Family(readers.index_trial, 10, SMALL),
    "rows": Family(readers.rows_trial, 10, SMALL),
    "rows in JSON": Family(readers.json_rows_trial, 10, SMALL),
    "find_impacts": Family(_without_files(calls_detection.find_trial), 50),
    "plan": Family(_without_files(calls_detection.plan_trial), 50),
    "check": Family(calls_check.check_trial, 50, 4 << 30, batch=50),
}


def count_of(family: Family, total: int) -> int:
    """Return how many of `total` inputs are of a family; at least one."""
    return max(1, round(total * family.share / WHOLE))
