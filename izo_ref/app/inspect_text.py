"""The report of `izo inspect` as a person reads it on a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any

from izo_ref.sequence.inspection import Verdict

MOST_PARTS = 12  # parts that the head lists
MOST_PAIRS = 3  # pairs of parts that a row names
MOST_LINES = 20  # pairs of parts that are summed up
WIDTH = 100  # characters of a line of sentences
MOST_RANGES = 6  # ranges of frames that a sentence names
WORDS = {
    Verdict.CLEAN.name: "clean",
    Verdict.TOUCHES.name: "touches",
    Verdict.RESOLVABLE.name: "can be resolved",
    Verdict.SINCE_START.name: "crosses since the start",
    Verdict.PINNED.name: "cannot be resolved",
}
COLUMNS = ("crosses", "new", "gone", "touches", "passes", "contours", "depth", "reach")
LENGTHS = ("depth", "reach")
FIELDS = ("crossings", "new", "gone", "touching", "passing", "contours", "depth", "reach")


def report_text(report: dict[str, Any]) -> str:
    """Return the report as text, with a table of the frames.

    Args:
        report: What `inspect_report` returns.
    """
    lines = [*_head(report), "", *_table(report["frames"]), ""]
    wrong = _wrong_pairs(report["frames"])
    if wrong:
        lines += [*wrong, ""]
    lines += map(_wrapped, [*_verdicts(report), *_fault_lines(report)])
    if report["next"] is not None:
        lines += ["", f"next: {report['next']}"]
    return "\n".join(lines) + "\n"


def _wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def ranges(numbers: Iterable[int]) -> str:
    """Return ascending numbers as ranges, such as `3-7, 9`; those behind the first few are counted.

    Args:
        numbers: The numbers.
    """
    found: list[list[int]] = []
    for number in numbers:
        if found and number == found[-1][1] + 1:
            found[-1][1] = number
        else:
            found.append([number, number])
    words = [f"{a}" if a == b else f"{a}-{b}" for a, b in found]
    more = len(words) - MOST_RANGES
    return ", ".join(words[:MOST_RANGES]) + (f", and {more} more ranges" if more > 0 else "")


def _head(report: dict[str, Any]) -> list[str]:
    parts = report["parts"]
    frames = _frames_of(range(report["first"], report["last"] + 1))
    count = "1 part" if len(parts) == 1 else f"{len(parts)} parts"
    if report["is_step"]:
        frames = "a step, whose start is frame 0 and whose proposed end is frame 1"
    lines = [f"{report['input']}: {frames}, {count}"]
    for part in parts[:MOST_PARTS]:
        text = f"  {part['name']}: {part['n_vertices']:,} vertices"
        if part["n_pinned"]:
            is_all = part["n_pinned"] == part["n_vertices"]
            text += ", pinned" if is_all else f", {part['n_pinned']:,} of them pinned"
        lines.append(text)
    if len(parts) > MOST_PARTS:
        lines.append(f"  and {len(parts) - MOST_PARTS} more")
    return lines


def _frames_of(numbers: Iterable[int]) -> str:
    numbers = list(numbers)
    return f"frame {numbers[0]}" if len(numbers) == 1 else f"frames {ranges(numbers)}"


def _table(frames: list[dict[str, Any]]) -> list[str]:
    """Return a row for each frame; one row stands for neighbours that are clean."""
    rows, clean = [["frame", *COLUMNS, "verdict", "parts"]], list[int]()
    for frame in frames:
        if frame["verdict"] == Verdict.CLEAN.name and not frame["gone"]:
            clean.append(frame["frame"])
            continue
        rows += _clean_row(clean)
        clean = []
        numbers = [_number(frame[name]) for name in FIELDS]
        rows.append([str(frame["frame"]), *numbers, WORDS[frame["verdict"]], _pairs_of(frame)])
    rows += _clean_row(clean)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    left = (0, len(widths) - 2, len(widths) - 1)  # columns of words
    return [
        "  ".join(
            cell.ljust(width) if i in left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _clean_row(numbers: list[int]) -> list[list[str]]:
    if not numbers:
        return []
    return [[ranges(numbers), *["-"] * len(FIELDS), WORDS[Verdict.CLEAN.name], ""]]


def _number(value: float) -> str:
    if value == 0:
        return "-"
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}"


def _pairs_of(frame: dict[str, Any]) -> str:
    """Return which parts cross in a frame, and since when."""
    texts = []
    for pair in frame["pairs"][:MOST_PAIRS]:
        since = pair["since"]
        text = _name_of(pair["parts"])
        if since is not None and since != frame["frame"]:
            text += f" (since {since})"
        texts.append(text)
    more = len(frame["pairs"]) - MOST_PAIRS
    return "; ".join(texts) + (f"; {more} more" if more > 0 else "")


def _name_of(parts: list[str]) -> str:
    return f"{parts[0]} with itself" if parts[0] == parts[1] else f"{parts[0]} x {parts[1]}"


def _wrong_pairs(frames: list[dict[str, Any]]) -> list[str]:
    """Return a line for each two parts: in which frames they cross, and where they do so most."""
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for frame in frames:
        for pair in frame["pairs"]:
            found.setdefault(_name_of(pair["parts"]), []).append((frame["frame"], pair))
    lines = []
    for name, rows in found.items():
        texts = []
        crossing = [row for row in rows if row[1]["crossings"]]
        if crossing:
            number, most = max(crossing, key=lambda row: row[1]["crossings"])
            depth, reach = (max(pair[name] for _, pair in crossing) for name in LENGTHS)
            texts.append(
                f"cross in {_frames_of(row[0] for row in crossing)}, most in frame {number} "
                f"({_count(most['crossings'], 'crossing')}), depth up to {depth:.3g} m"
                + (f", reach up to {reach:.3g} m" if reach else "")
            )
        for field, verb in (("touching", "touch in"), ("passing", "pass through before")):
            own = [row[0] for row in rows if row[1][field]]
            if own:
                texts.append(f"{verb} {_frames_of(own)}")
        lines.append(f"{name}: {'; '.join(texts)}")
    more = len(lines) - MOST_LINES
    return lines[:MOST_LINES] + ([f"and {more} more pairs of parts"] if more > 0 else [])


def _count(n: int, thing: str) -> str:
    return f"1 {thing}" if n == 1 else f"{n:,} {thing}s"


def _verdicts(report: dict[str, Any]) -> list[str]:
    """Return a sentence for each verdict that a frame has, with these frames."""
    frames = report["frames"]
    lines = []
    for verdict in Verdict:
        own = [frame["frame"] for frame in frames if frame["verdict"] == verdict.name]
        if len(own) == len(frames):
            lines.append(f"{WORDS[verdict.name]}: {verdict.value}")
        elif own and verdict is not Verdict.CLEAN:
            lines.append(f"{WORDS[verdict.name]} ({_frames_of(own)}): {verdict.value}")
    start = frames[0]["crossings"]
    clean = [frame["frame"] for frame in frames if not frame["crossings"]]
    if start and clean:
        lines.append(f"The first frame without crossings is {clean[0]}.")
    if len(frames) == 1 and report["verdict"] != Verdict.CLEAN.name:
        lines.append(
            "A single frame has no free one before it to be resolved from. Begin the animation "
            "with a frame in which the parts are apart."
        )
    return lines


def _fault_lines(report: dict[str, Any]) -> list[str]:
    """Return sentences about the mesh, about its floats, and about moves that are too far."""
    faults, lines = report["faults"], []
    repeated, flat, coincident = (faults[name] for name in ("repeated", "flat", "coincident"))
    if repeated["count"]:
        lines.append(
            f"cannot be resolved: {_count(repeated['count'], 'face')} with a vertex twice, the "
            f"first of the vertices {repeated['first']}. Remove such faces; here they are left out."
        )
    if flat["count"]:
        lines.append(
            f"{_count(flat['count'], 'face')} without area in the first frame, the first of the "
            f"vertices {flat['first']}. They take part as the edges that they look like."
        )
    if coincident["count"] and not report["welded"] and report["verdict"] != Verdict.CLEAN.name:
        lines.append(
            f"{coincident['count']:,} vertices are exactly at the place of others in the first "
            f"frame, the first is vertex {coincident['first']}. If they are one vertex, as along "
            "seams, add --weld; otherwise they touch."
        )
    return lines + _float_lines(report["floats"]) + _move_lines(report)


def _float_lines(floats: dict[str, Any]) -> list[str]:
    """Return a sentence if the floats of the file are too coarse for the thickness."""
    thickness, spacing = floats["thickness"], floats["spacing"]
    if spacing is None or spacing < thickness or thickness == 0.0:
        return []
    return [
        f"At {floats['largest']:.3g} m from the origin, numbers of {floats['precision']} are "
        f"{spacing:.3g} m apart, more than the thickness of {thickness:.3g} m. Rounding alone "
        "makes contact. Move the scene to the origin, or take a larger --thickness."
    ]


def _move_lines(report: dict[str, Any]) -> list[str]:
    """Return a sentence about frames in which something moves farther than the scene is wide."""
    own = [frame for frame in report["frames"] if frame["move"] > report["size"]]
    if not own:
        return []
    most = max(frame["move"] for frame in own)
    return [
        f"Moves too far in {_frames_of(frame['frame'] for frame in own)}: a vertex goes up to "
        f"{most:.3g} m between two frames, and the first frame is {report['size']:.3g} m wide. "
        "Check that the frames are in order and in one unit."
    ]
