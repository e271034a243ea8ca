"""Make the scenes again, or check that the stored ones are what the recipes make.

    python data/scenes/make.py                    make all scenes, with their truth
    python data/scenes/make.py --truth            keep the meshes, work out their truth again
    python data/scenes/make.py --check            compare the stored meshes with the recipes
    python data/scenes/make.py --check --truth    and the stored pairs with the exact oracle

Names after the options choose scenes. Making needs izo_ref and its extra [validation];
`--check` alone needs numpy alone. The exit code is 0 if all is well and 1 if a comparison fails.
The table in `data/README.md` is written and compared too.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = Path(__file__).resolve().parent
if __name__ == "__main__":  # run as a file, so the root of the checkout is not on the path
    sys.path.insert(0, str(FOLDER.parent.parent))

from data.scenes.recipes import SCENES  # noqa: E402
from data.scenes.shapes import LATTICE_M  # noqa: E402

INDEX = FOLDER / "index.json"
README = FOLDER.parent / "README.md"
TABLE_BEGIN, TABLE_END = "<!-- table of the scenes -->\n", "<!-- end of the table -->"
# Scenes whose largest zone of all impacts is recorded with its optimum.
ZONES = ("cloth-on-sphere", "sheets", "stack", "crumple", "moving-obstacle", "swapped")
BLOCKED = "pinch-blocked"


def main(arguments=None) -> int:
    """Run the command; returns its exit code."""
    parser = argparse.ArgumentParser(
        prog="python data/scenes/make.py",
        description="Make the scenes of this folder again, or check them.",
    )
    parser.add_argument("names", nargs="*", metavar="SCENE", help="all scenes if none is named")
    parser.add_argument("--check", action="store_true", help="compare; write nothing")
    parser.add_argument("--truth", action="store_true", help="the truth; keep the stored meshes")
    args = parser.parse_args(arguments)
    unknown = sorted(set(args.names) - set(SCENES))
    if unknown:
        parser.error(f"no scene is named {', '.join(unknown)}; there are {', '.join(SCENES)}")
    names = args.names or list(SCENES)
    if args.check:
        return _check(names, args.truth)
    _write(names, keep_meshes=args.truth)
    return 0


def made(name) -> dict[str, np.ndarray]:
    """Make the arrays of a scene, without its truth."""
    recipe = SCENES[name]
    arrays = recipe.make(np.random.default_rng(recipe.seed))._asdict()
    for key, array in arrays.items():
        if key.startswith("positions") and (array != np.rint(array / LATTICE_M) * LATTICE_M).any():
            raise ValueError(f"{name}: {key} is not on the lattice")
    return arrays


def stored(name) -> dict[str, np.ndarray]:
    """Read all arrays of a stored scene."""
    with np.load(FOLDER / f"{name}.npz") as archive:
        return {key: archive[key] for key in archive.files}


def differences(expected, found) -> list[str]:
    """Name the arrays of `expected` that `found` lacks or holds with other bits."""
    return [
        key
        for key, array in expected.items()
        if key not in found
        or found[key].dtype != array.dtype
        or found[key].shape != array.shape
        or found[key].tobytes() != array.tobytes()
    ]


def _check(names, truth):
    failed = False
    for name in names:
        have, want = stored(name), made(name)
        if truth:
            from data.scenes.truth import pairs_of

            want |= pairs_of(have)[0]
        wrong = differences(want, have)
        failed |= bool(wrong)
        print(f"{name}: {'differs in ' + ', '.join(wrong) if wrong else 'the same'}", flush=True)
    text = README.read_text()
    if text != _with_table(text, json.loads(INDEX.read_text())):
        print("data/README.md: its table differs from the index")
        failed = True
    return int(failed)


def _write(names, keep_meshes):
    from data.scenes.truth import pairs_of

    index = json.loads(INDEX.read_text()) if INDEX.is_file() else {}
    for name in names:
        mesh = made(name)
        if keep_meshes:
            have = stored(name)
            mesh = {key: have[key] for key in mesh}
        pairs, each = pairs_of(mesh)
        np.savez_compressed(FOLDER / f"{name}.npz", **mesh, **pairs)
        index[name] = _entry(name, mesh, each)
        print(name, json.dumps(index[name]["steps"]), flush=True)
    ordered = {name: index[name] for name in SCENES if name in index}
    from izo_ref.app.files import save_json, save_text  # `--check` needs numpy alone

    save_json(INDEX, ordered)
    save_text(README, _with_table(README.read_text(), ordered))


def _with_table(text, index):
    """The text of the README with the table of the scenes."""
    rows = [
        "| scene | what happens | vertices | pairs that meet | answer |",
        "|---|---|---:|---:|---|",
        *(_row(name, facts) for name, facts in index.items()),
    ]
    before, _, rest = text.partition(TABLE_BEGIN)
    _, _, after = rest.partition(TABLE_END)
    return before + TABLE_BEGIN + "\n".join(rows) + "\n" + TABLE_END + after


def _row(name, facts):
    pairs = sum(s["pairs"]["vertex_face"] + s["pairs"]["edge_edge"] for s in facts["steps"])
    impacts = sum(step["answer"]["impacts"] for step in facts["steps"])
    last = facts["steps"][-1]["answer"]
    says = f"{impacts} impacts"
    if last["status"] == "BLOCKED":
        says = f"free until t = {last['time_free']:.3f}"
    what = facts["what"].rstrip(".")
    return f"| `{name}` | {what} | {facts['vertices']:,} | {pairs:,} | {last['status']}, {says} |"


def _entry(name, mesh, each):
    """What the index says of a scene."""
    from data.scenes.truth import all_impacts_zone, answers_of, pair_facts, pinned_facts
    from izo_ref import __version__

    recipe = SCENES[name]
    answers = answers_of(mesh, recipe.thickness)
    entry: dict[str, Any] = {
        "what": recipe.make.__doc__,
        "kind": "sequence" if "positions" in mesh else "step",
        "vertices": len(mesh["masses"]),
        "triangles": len(mesh["faces"]),
        "pinned": int(mesh["pinned"].sum()),
        "seed": recipe.seed,
        "thickness_m": recipe.thickness,
        "answered_by": f"izo_ref {__version__}",
        "steps": [
            {"pairs": pair_facts(found), "answer": answer}
            for found, answer in zip(each, answers, strict=True)
        ],
    }
    if name == BLOCKED:
        entry["pinned_pairs"] = pinned_facts(each[0], mesh["pinned"])
    if name in ZONES:
        entry["zone_of_all_impacts"] = all_impacts_zone(mesh, recipe.thickness)
    return entry


if __name__ == "__main__":
    sys.exit(main())
