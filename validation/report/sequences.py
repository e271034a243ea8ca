"""The page of animations, from the rows of `study/sequences.py`."""

from pathlib import Path

from validation.report.catalogue import Headline
from validation.report.tables import run_table, section, write_page
from validation.rows import Columns, Row, read, runs_of

PARTS = ("formats", "tangles", "speed", "memory")
STATUSES = ("FREE", "FREE_BY_FALLBACK", "FREE_EXCEPT_EXCLUDED", "BLOCKED")
INTRO = (
    "Measured by `python -m validation study sequences`; `--only` measures one part. Rows that "
    "are there are not measured again."
)
FORMATS_INTRO = (
    "Each animation is written in each format with names, texture coordinates, materials or other "
    "attributes, resolved by `izo sequence`, and read again by a second reader that shares no line "
    "with izo_ref. The garment has two layers on a body that moves and turns, and is inside it "
    "from frame 10 on. The body is pinned by its name, or is an obstacle where a format has no "
    "names. Free paths: from each frame to the next one, of the positions that the file holds, by "
    "the certificate of izo_ref and by ipctk, whose hits exact arithmetic decides; free frames: by "
    "python-fcl. A second run is killed by SIGKILL after a frame and started again. All else is "
    "everything but positions and what follows from them, which are bounds."
)
TANGLES_INTRO = (
    "Animations that stand still at a tangled start, and one in which the upright sheet is "
    "proposed to sway. Crossings are edges that go through faces, all counted exactly in each "
    "frame. The pull of a frame is in median edge lengths. Pairs that are left out may meet, all "
    "others are protected. Most new: the largest number of edge-face crossings of a frame that the "
    "frame before had not; a contour that moves along a surface leaves some and takes others. "
    "Grown: by how much the number of crossings rose at most in a frame. A pull keeps it from "
    "rising; without one, a contour that is moved may get longer, though no pair is left out that "
    "was not before. Judged: paths without substeps or parts of a pull whose protected pairs "
    "ipctk and exact arithmetic look at, and at whose ends python-fcl looks for faces that cross "
    "without a pair that is left out. Of meshes of more than 5,000 triangles, the frames of this "
    "table alone are judged."
)
SPEED_INTRO = (
    "A garment on a moving body, by `resolve_sequence`: medians of the frames behind the one in "
    "which contact begins. Light contact: one layer, a tenth of which goes into the body. Heavy "
    "contact: three layers, all of which go into the body and each other. The time to compile is "
    "not in them."
)
MEMORY_INTRO = (
    "Memory of the process that is in use, at an early frame and at the last one, of a garment "
    "that is in contact; the study fails if it grows."
)
TANGLES: Columns = {
    "scene": "scene",
    "triangles": "triangles",
    "pull [edges]": "pull_edges",
    "frame": "frame",
    "crossings": "crossings",
    "pairs left out": "left_out",
    "most new": "most_new",
    "grown": "grown",
    "pairs left out, grown": "left_out_grown",
    "judged": "judged",
    "protected pairs that meet (ipctk)": "met_by_ipctk",
    "faces that cross (python-fcl)": "crossing_by_fcl",
}
SPEED: Columns = {
    "triangles": "own_triangles",
    "contact": "contact",
    "threads": "threads",
    "impacts a frame": "impacts",
    "frames a second": "frames_per_s",
    "median [s]": "median_s",
    "least": "least_s",
    "most": "most_s",
    "frames": "repeats",
    "status": "statuses",
}
MEMORY: Columns = {
    "what": "what",
    "frames": "frames",
    "triangles": "triangles",
    "positions of a frame [KiB]": "frame_kib",
    "early frame": "early",
    "at it [MiB]": "early_mib",
    "at the last [MiB]": "last_mib",
    "impacts": "impacts",
}


def page(rows_folder: Path, output: Path) -> Path:
    """Write `README.md`.

    Args:
        rows_folder: Folder of the CSV files, one for each of PARTS.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    rows = {name: _sorted(read(rows_folder, name)) for name in PARTS}
    made = runs_of(rows_folder, (row for part in rows.values() for row in part))
    sections = (
        "# Animations",
        INTRO,
        run_table(made),
        section("Every format", FORMATS_INTRO, _format_columns(), rows["formats"]),
        section("Starts that are tangled", TANGLES_INTRO, TANGLES, rows["tangles"]),
        section("Frames a second", SPEED_INTRO, SPEED, rows["speed"]),
        _first(rows["speed"]),
        section("Memory", MEMORY_INTRO, MEMORY, rows["memory"]),
    )
    return write_page(output / "README.md", [text for text in sections if text])


def _sorted(rows: list[Row]) -> list[Row]:
    """Return rows by animation and format, or by scene, pull and frame; others as they are."""
    names = ("animation", "format", "scene", "pull_edges", "frame")
    return sorted(rows, key=lambda row: [row[name] for name in names if name in row])


def _format_columns() -> Columns:
    return {
        "animation": "animation",
        "format": "format",
        "frames": "frames",
        "statuses": lambda row: ", ".join(f"{row[s]} {s}" for s in STATUSES if row[s]),
        "impacts": "impacts",
        "moved or held by rounding": lambda row: row["nudged"] + row["held"],
        "free paths": lambda row: _of(row, "free_paths"),
        "by ipctk": lambda row: _of(row, "free_by_ipctk"),
        "free frames by python-fcl": lambda row: _of(row, "free_by_fcl"),
        "all else kept": "rest_kept",
        "frames without impacts, same bits": lambda row: f"{row['still_same']} of {row['still']}",
        "frames kept when killed": "killed_after",
        "resumed to the same bytes": "same_bytes",
    }


def _of(row: Row, name: str) -> str:
    return "not asked" if row[name] is None else f"{row[name]} of {row['paths']}"


def _first(rows: list[Row]) -> str:
    """Return the sentence about compiling, if it was measured."""
    if not rows:
        return ""
    most = max(row["first_s"] for row in rows)
    return (
        f"A small garment that was resolved before in each run, which compiles what is not on the "
        f"disk, took {most:.3g} s at most."
    )


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    rows = {name: read(rows_folder, name) for name in PARTS}
    return [
        *_format_headline(rows["formats"]),
        *_tangle_headlines(rows["tangles"]),
        *_speed_headline(rows["speed"]),
        *_memory_headline(rows["memory"]),
    ]


def _format_headline(rows: list[Row]) -> list[Headline]:
    if not rows:
        return []
    good = [row for row in rows if _is_good(row)]
    paths = sum(row["paths"] for row in rows)
    free = sum(row["free_paths"] for row in rows)
    return [
        Headline(
            "Animations in all formats that are as they should be",
            f"{len(good)} of {len(rows)}",
            f"The certificate proves {free:,} of {paths:,} paths of the written files free after "
            "rounding, ipctk and python-fcl agree, all else in the file is kept, and a run that is "
            "killed and resumed ends with the same bytes.",
        )
    ]


def _is_good(row: Row) -> bool:
    judges = [row[name] for name in ("free_paths", "free_by_ipctk", "free_by_fcl")]
    return (
        all(found in (None, row["paths"]) for found in judges)
        and bool(row["rest_kept"] and row["same_bytes"])
        and row["still"] == row["still_same"]
    )


def _tangle_headlines(rows: list[Row]) -> list[Headline]:
    if not rows:
        return []
    last = max(row["frame"] for row in rows)
    by_key = {(row["scene"], row["pull_edges"], row["frame"]): row for row in rows}
    parts = []
    for (scene, pull, frame), row in by_key.items():
        first = by_key.get((scene, pull, 0))
        if frame == last and first is not None:
            how = f"with a pull of {pull:g} edges" if pull else "without a pull"
            parts.append(
                f"{scene} {how}: {first['crossings']:,} at the start, {row['crossings']:,} left"
            )
    broken = sum(
        (row["met_by_ipctk"] or 0) + row["crossing_by_fcl"] for row in rows if row["frame"] == last
    )
    judged = sum(row["judged"] for row in rows if row["frame"] == last)
    pulled, others = (
        max((row["grown"] for row in rows if bool(row["pull_edges"]) is has_pull), default=0)
        for has_pull in (True, False)
    )
    return [
        Headline(
            f"Protected pairs of tangled starts that meet within {last} frames",
            f"{broken} in {judged} paths",
            "Judged by ipctk and python-fcl. The number of crossings rose by at most "
            f"{pulled} in a frame with a pull, and by {others} without. Crossings: "
            f"{'; '.join(parts)}.",
        )
    ]


def _speed_headline(rows: list[Row]) -> list[Headline]:
    if not rows:
        return []
    figures = [
        f"{row['own_triangles']:,} {row['contact']} {row['frames_per_s']:.2g}" for row in rows
    ]
    rates = [row["frames_per_s"] for row in rows]
    return [
        Headline(
            "Frames a second",
            f"{min(rates):.2g} to {max(rates):.2g}",
            f"Triangles, contact and frames a second: {'; '.join(figures)}.",
        )
    ]


def _memory_headline(rows: list[Row]) -> list[Headline]:
    if not rows:
        return []
    grown = max(row["last_mib"] - row["early_mib"] for row in rows)
    longest = max(row["frames"] for row in rows)
    return [
        Headline(
            f"Growth of memory over {longest:,} frames",
            f"{grown:.1f} MiB",
            f"From frame {rows[0]['early']} on, at most, of `resolve_sequence` and of the command.",
        )
    ]
