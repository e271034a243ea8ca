"""Rows of `study.zones` and `study.nonlinear` to `reports/zones.md`."""

import math

import numpy as np

from validation.report.tables import header, table, text, write
from validation.study.zones import LARGE, MASS_RATIOS, ORACLES

NAMES = ("ours", *ORACLES, *LARGE)


def zones_report(path, command, rows):
    """Write the report.

    Args:
        path: of the Markdown file; JSON is written beside it.
        command: that made it.
        rows: {"random", "scaling", "sizes", "steps", "nonlinear"}: lists of rows; steps may
            be empty when there are no step files.
    """
    parts = [
        header("Zones: solvers against oracles", command),
        _random(rows["random"]),
        _scaling(rows["scaling"]),
        _sizes(rows["sizes"]),
        _steps(rows["steps"]),
        _nonlinear(rows["nonlinear"]),
    ]
    write(path, "\n".join(parts), rows)


def _largest(values):
    return max(values, default=0.0)


def _random(rows):
    by_ratio = [[row for row in rows if row["mass_ratio"] == ratio] for ratio in MASS_RATIOS]
    lines = []
    for name in NAMES:
        line = {"solver": name}
        for ratio, group in zip(MASS_RATIOS, by_ratio, strict=True):
            errors = [row["error"][name] for row in group]
            line[ratio] = _largest([e for e in errors if math.isfinite(e)])
        claimed = [row for row in rows if row["claims"].get(name, True)]
        line["median"] = float(np.median([row["error"][name] for row in rows]))
        line["wrong"] = sum(row["error"][name] > 1e-6 for row in claimed)
        line["gave up"] = len(rows) - len(claimed)
        lines.append(line)
    columns = {"solver": "solver"}
    columns |= {
        f"ratio {ratio:.0e}": (lambda row, ratio=ratio: row[ratio]) for ratio in MASS_RATIOS
    }
    columns |= {
        "median": "median",
        "says solved, off by more than 1e-6": "wrong",
        "does not say solved": "gave up",
    }
    positions = [
        {
            "ratio": ratio,
            "ours": _largest(row["error_of_positions"] for row in group),
            "least": _largest(row["least_of_positions"] for row in group),
        }
        for ratio, group in zip(MASS_RATIOS, by_ratio, strict=True)
    ]
    ours = _largest(row["error"]["ours"] for row in rows)
    slowest = _largest(row["exact_s"] for row in rows)
    return f"""## {len(rows)} random zones against the exact optimum

1 to 64 impacts on shared vertices, among them duplicated, redundant, nearly parallel (1e-12 to
1e-1) and opposed rows; masses over all decades up to the ratio. All are feasible. The error is
|x - x*| over |x* - y| in the norm of the masses, with x* from rational arithmetic, at most
{text(slowest)} s a zone. The largest of each solver, by mass ratio; no answer counts as the
largest finite one of its column. Largest of ours: **{text(ours)}**.

{table(columns, lines)}
Errors are of displacements, in floats. Positions in floats can say less: a vertex of a mass of
1e12 moves by less than its coordinates' last digit. Ours, and the least that any positions in
floats could have:

{table({"mass ratio": "ratio", "our positions": "ours", "nearest floats": "least"}, positions)}"""


def _scaling(rows):
    columns = {
        "depth [m]": "depth",
        "form": "form",
        "ftol": "ftol",
        "says": "says",
        "largest error of a position, over the largest displacement": "largest_position_error",
        "relative error, by mass": "error",
    }
    return f"""## SLSQP as it is called, and scaled

One vertex behind a face, masses 1e-3, 1, 1 and 1e3 kg, thickness 1e-4 m. In metres and
kilograms, SLSQP says that it succeeded where it stopped early; in numbers near 1, the same
routine is right.

{table(columns, rows)}"""


def _sizes(rows):
    columns = {
        "oracle": "oracle",
        "impacts": "impacts",
        "median seconds of 5": "seconds",
        "largest relative distance to ours": "against_ours",
    }
    return f"""## How large a zone the dense oracles take

Random zones at a mass ratio of 1e3; an oracle is left out after the size that took it more than
2 s.

{table(columns, rows)}"""


def _steps(rows):
    if not rows:
        return "## Zones of real steps\n\nNot measured: no step files were found.\n"
    groups = {}
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
    columns = {
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

The largest zones in which each step ends, at most 20, and the zone problems of the first and
last iteration of armadillo-rollers. Each answer is judged by the same residuals, outside of the
solver; the distance to the optimum is proved, "none" where no bound was found.

{table(columns, lines)}"""


def _nonlinear(rows):
    fixed = [row for row in rows if row["fixed_point"]]
    lines = []
    for kind in dict.fromkeys(row["scene"] for row in rows):
        own = [row for row in rows if row["scene"] == kind]
        still = [row for row in own if row["fixed_point"]]
        line = {"scene": kind, "zones": len(own), "fixed": len(still)}
        for name in ("violation", "stationarity", "complementarity", "slsqp_moved"):
            line[name] = _largest(row[name] for row in still)
        lines.append(line)
    columns = {
        "scene": "scene",
        "zones": "zones",
        "with a fixed point": "fixed",
        "violation": "violation",
        "stationarity": "stationarity",
        "complementarity": "complementarity",
        "SLSQP moved it by": "slsqp_moved",
    }
    return f"""## The fixed point of re-linearisation

Small scenes, resolved and then re-linearised with their own pairs until they stand still:
{len(fixed)} of {len(rows)} zones do. The others slide off into pairs they do not have, which the
outer loop then takes in. At the fixed point: largest residuals of the nonlinear problem, whose
constraints are the signed distances of the pairs as functions of x, and how far SLSQP goes when
it is started there, over the displacement.

{table(columns, lines)}"""
