"""The page of the zone solvers against oracles, from the rows of `study/zones.py`."""

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from validation import json_rows
from validation.report.catalogue import Headline
from validation.report.tables import NOT_MEASURED, cell_text, header, scientific, table, write_page
from validation.rows import Columns, Row
from validation.study.zones import LARGE, MASS_RATIOS, ORACLES

TITLE = "Zones: solvers against oracles"
FILE = "zones.json"
NAMES = ("ours", *ORACLES, *LARGE)
WRONG = 1e-6  # relative error above which an answer that is said to be solved counts as wrong


def page(rows_folder: Path, output: Path) -> Path:
    """Write `zones.md`.

    Args:
        rows_folder: Folder of `zones.json`, whose rows are lists by name: "random", "scaling",
            "sizes", "steps" and "nonlinear"; "steps" is empty if there were no step files.
        output: Folder of the page.

    Returns:
        Path of the page.
    """
    path, loaded = output / "zones.md", json_rows.load(rows_folder / FILE)
    if loaded is None:
        return write_page(path, (f"# {TITLE}", NOT_MEASURED))
    rows = loaded.rows
    sections = (
        header(TITLE, [loaded.made]),
        _random(rows["random"]),
        _scaling(rows["scaling"]),
        _sizes(rows["sizes"]),
        _steps(rows["steps"]),
        _nonlinear(rows["nonlinear"]),
    )
    return write_page(path, sections)


def headlines(rows_folder: Path) -> list[Headline]:
    """Return the figures that stand for this report; an empty list if it was not measured."""
    loaded = json_rows.load(rows_folder / FILE)
    if loaded is None:
        return []
    random, steps = loaded.rows["random"], loaded.rows["steps"]
    found = [
        Headline(
            "Largest error of our solver on random zones",
            cell_text(_largest(row["error"]["ours"] for row in random)),
            f"{len(random)} zones with mass ratios of up to {scientific(max(MASS_RATIOS))}; the "
            "error is relative to the exact optimum, which rational arithmetic finds.",
        )
    ]
    own = [row for row in steps if row["solver"] == "ours"]
    if own:
        impacts = max(row["impacts"] for row in own)
        found.append(
            Headline(
                "Largest relative duality gap of our solver on zones of real steps",
                cell_text(_largest(row["gap"] for row in own)),
                f"{len(own)} zones of up to {impacts:,} impacts; the largest violation is "
                f"{cell_text(_largest(row['violation'] for row in own))} of the thickness.",
            )
        )
    return found


def _largest(values: Iterable[float]) -> float:
    return max(values, default=0.0)


def _random(rows: list[Row]) -> str:
    ours = _largest(row["error"]["ours"] for row in rows)
    slowest = _largest(row["exact_s"] for row in rows)
    return f"""## {len(rows)} random zones against the exact optimum

The zones have 1 to 64 impacts on shared vertices. Some of their constraints are duplicated,
redundant, nearly parallel (1e-12 to 1e-1) or opposed, and the masses cover all decades up to the
ratio. All zones are feasible. The error is |x - x*| over |x* - y| in the norm of the masses, where
rational arithmetic finds x*, in at most {cell_text(slowest)} s for a zone. The table shows the
largest error of each solver by mass ratio; a solver without an answer counts as the largest finite
error of its column. Our largest error is **{cell_text(ours)}**.

{_errors_table(rows)}
These are errors of displacements in floating point. Positions in floating point are less
accurate, because a vertex with a mass of 1e12 moves by less than the last digit of its
coordinates. The next table shows the error of our positions, and the least error that any
positions in floating point could have:

{_positions_table(rows)}"""


def _by_ratio(rows: list[Row]) -> list[tuple[float, list[Row]]]:
    return [(ratio, [row for row in rows if row["mass_ratio"] == ratio]) for ratio in MASS_RATIOS]


def _errors_table(rows: list[Row]) -> str:
    groups = _by_ratio(rows)
    lines = []
    for name in NAMES:
        line: Row = {"solver": name}
        for ratio, group in groups:
            errors = [row["error"][name] for row in group]
            line[_ratio_heading(ratio)] = _largest(e for e in errors if math.isfinite(e))
        claimed = [row for row in rows if row["claims"].get(name, True)]
        line["median"] = float(np.median([row["error"][name] for row in rows]))
        line["wrong"] = sum(row["error"][name] > WRONG for row in claimed)
        line["gave up"] = len(rows) - len(claimed)
        lines.append(line)
    columns: Columns = {
        "solver": "solver",
        **{_ratio_heading(ratio): _ratio_heading(ratio) for ratio in MASS_RATIOS},
        "median": "median",
        f"says solved, but the error exceeds {scientific(WRONG)}": "wrong",
        "does not say solved": "gave up",
    }
    return table(columns, lines)


def _ratio_heading(ratio: float) -> str:
    return f"ratio {ratio:.0e}"


def _positions_table(rows: list[Row]) -> str:
    lines = [
        {
            "ratio": ratio,
            "ours": _largest(row["error_of_positions"] for row in group),
            "least": _largest(row["least_of_positions"] for row in group),
        }
        for ratio, group in _by_ratio(rows)
    ]
    return table({"mass ratio": "ratio", "our positions": "ours", "nearest floats": "least"}, lines)


def _scaling(rows: list[Row]) -> str:
    columns: Columns = {
        "depth [m]": "depth",
        "form": "form",
        "ftol": "ftol",
        "says": "says",
        "largest error of a position, over the largest displacement": "largest_position_error",
        "relative error, by mass": "error",
    }
    return f"""## SLSQP in metres and kilograms, and in scaled numbers

The problem is one vertex behind a face, with masses of 1e-3, 1, 1 and 1e3 kg and a thickness of
1e-4 m. In metres and kilograms, SLSQP reports success although it stopped early. The same routine
is right if its numbers are scaled to be near 1.

{table(columns, rows)}"""


def _sizes(rows: list[Row]) -> str:
    columns: Columns = {
        "oracle": "oracle",
        "impacts": "impacts",
        "median seconds of 5": "seconds",
        "largest relative distance to ours": "against_ours",
    }
    return f"""## How long the dense oracles take, by the size of the zone

The zones are random, with a mass ratio of 1e3. An oracle that takes more than 2 s at one size is
not asked at the larger sizes.

{table(columns, rows)}"""


def _steps(rows: list[Row]) -> str:
    if not rows:
        return "## Zones of real steps\n\nNot measured: no step files were found."
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["zone"].split(",")[0], row["solver"]), []).append(row)
    lines = [
        {
            "step": step,
            "solver": solver,
            "zones": len(group),
            "largest": max(row["impacts"] for row in group),
            "solved": sum(solver == "ours" or row["says"] == "solved" for row in group),
            "gap": _largest(row["gap"] for row in group),
            "violation": _largest(row["violation"] for row in group),
            "distance": _largest(row["distance"] for row in group),
            "against": _largest(row.get("against_ours", 0.0) for row in group),
            "seconds": sum(row["seconds"] for row in group),
        }
        for (step, solver), group in groups.items()
    ]
    columns: Columns = {
        "step": "step",
        "solver": "solver",
        "zones": "zones",
        "impacts of the largest": "largest",
        "says solved": "solved",
        "largest relative gap": "gap",
        "violation over thickness": "violation",
        "proved relative distance": "distance",
        "distance to ours": "against",
        "seconds, all": "seconds",
    }
    return f"""## Zones of real steps

These are the zones at the end of each step, at most the 20 largest, and the zone problems of the
first and the last iteration of armadillo-rollers. The same residuals judge every answer; they are
computed outside of the solvers. The distance to the optimum is proved; it is "none" where no bound
was found.

{table(columns, lines)}"""


def _nonlinear(rows: list[Row]) -> str:
    fixed = sum(row["fixed_point"] for row in rows)
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        own = [row for row in rows if row["scene"] == scene]
        still = [row for row in own if row["fixed_point"]]
        line: Row = {"scene": scene, "zones": len(own), "fixed": len(still)}
        for name in ("violation", "stationarity", "complementarity", "slsqp_moved"):
            line[name] = _largest(row[name] for row in still)
        lines.append(line)
    columns: Columns = {
        "scene": "scene",
        "zones": "zones",
        "with a fixed point": "fixed",
        "violation": "violation",
        "stationarity": "stationarity",
        "complementarity": "complementarity",
        "SLSQP moved it by": "slsqp_moved",
    }
    return f"""## The fixed point of re-linearisation

Small scenes are resolved, and then re-linearised with their own pairs until they stand still:
{fixed} of {len(rows)} zones do. The others slide off into pairs that they do not have; the outer
loop then adds those pairs. The table shows the largest residuals of the nonlinear problem at the
fixed point. The constraints of that problem are the signed distances of the pairs as functions of
x. The last column shows how far SLSQP moves if it starts at the fixed point, relative to the
displacement.

{table(columns, lines)}"""
