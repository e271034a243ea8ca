"""Inputs of `python -m validation check`: a step, and results that any program may write."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import izo_ref
from izo_ref.app.files import SavedResult, save_result, save_scene
from validation.check import Verdict, check_files
from validation.fuzz import contract
from validation.fuzz.arrays import Rng, changed, strange_value
from validation.fuzz.calls import THICKNESS_M, hanging_step, shown
from validation.fuzz.tables import is_ordinary, table_of
from validation.fuzz.trial import Trial, Wrong
from validation.limits import Limits
from validation.oracles.pairs import meeting_pairs

# Far out, ipctk takes 20 s; a judge that is ended does not decide, which is no problem.
LIMITS = Limits(seconds=2.0)
# The arrays that describe the zones: a file has all of them, or none.
ZONES = {
    "multipliers": (None,),
    "impact_toi": (None,),
    "impact_weights": (None, 4),
    "impact_normals": (None, 3),
    "impact_nodes": (None, 4),
    "impact_is_edge_edge": (None,),
}


def check_trial(rng: Rng, folder: Path) -> Trial:
    """Return a call of `check_files`, with files and a thickness."""
    scene = hanging_step(rng)
    save_scene(folder / "step.npz", scene)
    good = _result_arrays(rng, scene, folder)
    arrays, names = _disturbed(rng, good)
    np.savez(folder / "result.npz", **arrays)
    wrongs = result_wrongs(arrays, len(scene.pinned))
    arguments: dict[str, Any] = {}
    if rng.random() < 0.2:
        arguments["thickness"] = strange_value(rng)
        if arguments["thickness"] is not None:
            wrong = contract.positive_wrong("thickness", arguments["thickness"])
            wrongs += [wrong] if wrong else []
    if rng.random() < 0.2:
        known, _ = _disturbed(rng, {"positions": scene.positions_t0})
        np.savez(folder / "known.npz", **known)
        arguments["known"] = [folder / "known.npz"]
        found = result_wrongs(known, len(scene.pinned))
        wrongs += [Wrong("known", wrong.place) for wrong in found]
        is_open = _is_open(known, [])
    else:
        is_open = False
    is_open |= _is_open(arrays, names)
    if not _is_usual(arguments.get("thickness")):
        is_open = True
        wrongs += [Wrong("thickness")] if wrongs else []

    def judge(found: tuple[izo_ref.Scene, Verdict]) -> str:
        return verdict_problem(found[1], scene, arrays["positions"], not names)

    what = f"check({shown(arrays)}, {shown(arguments)}) of {shown(vars(scene))}"
    return Trial(
        lambda: check_files(folder / "step.npz", folder / "result.npz", **arguments, limits=LIMITS),
        None if is_open and not wrongs else wrongs,
        judge,
        what,
    )


def _result_arrays(rng: Rng, scene: izo_ref.Scene, folder: Path) -> dict[str, Any]:
    """Return the arrays of our own result, or of one that has positions alone."""
    result = izo_ref.resolve(scene, THICKNESS_M)
    if rng.random() < 0.3:
        share = rng.random()
        ends = (1 - share) * scene.positions_t0 + share * scene.positions_t1
        ends[scene.pinned] = scene.positions_t1[scene.pinned]
        return {"positions": ends.astype(np.float32) if rng.random() < 0.3 else ends}
    saved = SavedResult(result.positions, result.thickness, result.impacts, result.multipliers)
    save_result(folder / "own.npz", saved)
    with np.load(folder / "own.npz") as archive:
        return dict(archive)


def _disturbed(rng: Rng, good: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return arrays of which one is left out or changed, and the names of those that were."""
    arrays, names = dict(good), []
    if rng.random() < 0.2:
        return arrays, names
    name = "positions" if rng.random() < 0.4 else list(good)[rng.integers(len(good))]
    names.append(name)
    if rng.random() < 0.1:
        del arrays[name]
        return arrays, names
    value = changed(rng, good[name]) if rng.random() < 0.8 else strange_value(rng)
    try:
        array = np.asarray(value)
    except Exception:
        return arrays, names
    # objects need pickle, and numbers of more than 64 bits are refused; `archives.py` has both
    if array.dtype.kind not in "OV" and array.dtype.char not in "gG":
        arrays[name] = array
    return arrays, names


def result_wrongs(arrays: Mapping[str, Any], n: int) -> list[Wrong]:
    """Return what is wrong with the arrays of a result, apart from the values of its zones."""
    missing = [name for name in ("positions", *ZONES) if name not in arrays]
    if "positions" in missing:
        return [Wrong("positions")]
    wrong = contract.real_wrong("positions", arrays["positions"], (n, 3))
    wrongs = [wrong] if wrong else []
    if "thickness" in arrays:
        wrong = contract.positive_wrong("thickness", arrays["thickness"])
        wrongs += [wrong] if wrong else []
    if len(missing) == len(ZONES):
        return wrongs
    if missing or "thickness" not in arrays:
        return wrongs + [Wrong(name) for name in missing or ["thickness"]]
    found = [contract.real_wrong(name, arrays[name], ZONES[name]) for name in list(ZONES)[:4]]
    found.append(_nodes_wrong(arrays["impact_nodes"], n))
    wrongs += [one for one in found if one is not None]
    if wrongs:
        return wrongs
    lengths = {len(arrays[name]) for name in list(ZONES)[:5]}
    if contract.flags_of(arrays["impact_is_edge_edge"], max(lengths)) is None:
        wrongs.append(Wrong("impact_is_edge_edge"))
    return [*wrongs, *map(Wrong, ZONES)] if len(lengths) > 1 else wrongs


def _nodes_wrong(value: Any, n: int) -> Wrong | None:
    """Return what is wrong with the nodes of impacts: four vertices, each another one."""
    wrong = contract.index_wrong("impact_nodes", value, 4, n)
    if wrong is not None:
        return wrong
    rows = np.asarray(value, float).reshape(-1, 4).tolist()
    off = [i for i, row in enumerate(rows) if len(set(row)) < 4]
    return Wrong("impact_nodes", f"row {off[0]}") if off else None


def _is_open(arrays: Mapping[str, Any], names: list[str]) -> bool:
    """Return whether pages say only that a result may be refused: by sizes, or by its zones."""
    table = table_of(arrays["positions"]) if "positions" in arrays else None
    ordinary = table is None or is_ordinary(table)
    return not ordinary or any(name in ("thickness", *ZONES) for name in names)


def _is_usual(thickness: Any) -> bool:
    """Return whether a thickness is one that fits steps of some metres."""
    return thickness is None or (isinstance(thickness, float) and 1e-20 < thickness < 1e20)


def verdict_problem(verdict: Verdict, scene: izo_ref.Scene, saved: Any, is_own: bool) -> str:
    """Return what is wrong with a verdict, by all pairs in exact arithmetic and a comparison."""
    positions = np.asarray(saved, float)
    if not np.array_equal(verdict.positions, positions):
        return "other positions were judged"
    is_single = np.asarray(saved).dtype == np.float32
    wanted = scene.positions_t1.astype(np.float32) if is_single else scene.positions_t1
    held = (positions == wanted)[scene.pinned].all()
    meeting = meeting_pairs(scene.positions_t0, positions, scene.faces)
    pairs = [*meeting.vertex_face.tolist(), *meeting.edge_edge.tolist()]
    if sorted(verdict.meeting.nodes.tolist()) != sorted(pairs):
        return f"the pairs {pairs} meet, not {verdict.meeting.nodes.tolist()}"
    if verdict.passed and (pairs or not held):
        return "passed, but " + ("pairs meet" if pairs else "a pinned vertex is elsewhere")
    if is_own and held and not pairs and not verdict.passed:
        return f"failed: {[fact for fact in verdict.facts if fact.passed is False]}"
    values = [*verdict.objectives.values(), verdict.thickness or 0.0]
    return "" if all(value >= 0.0 for value in values) else "an objective or thickness is negative"
