"""Tables about a result that was computed in this process."""

from __future__ import annotations

import numpy as np

from izo_ref.app.view.model import Table
from izo_ref.loop.resolve import Result


def zones_table(result: Result) -> Table:
    """Return a table about the zones of a result."""
    sizes = np.diff(result.zones.impact_offsets)
    gap = max((r.gap for r in result.residuals), default=0.0)
    violation = max((r.violation for r in result.residuals), default=0.0)
    rows = [
        ("Impacts in zones", f"{len(result.impacts.toi):,}"),
        ("Zones", f"{len(result.zones):,}"),
        ("Impacts in the largest zone", f"{sizes.max(initial=0):,}"),
        ("Largest relative duality gap of a zone", f"{gap:.1e}"),
        ("Largest violation, as a fraction of the thickness", f"{violation:.1e}"),
    ]
    return Table("Zones", (), rows)


def history_table(result: Result) -> Table:
    """Return a table of the iterations of a result."""
    heads = ("Iteration", "Impacts found", "Added to zones", "Zones", "Detection", "Solution")
    rows = [
        (
            str(i + 1),
            f"{row.found:,}",
            f"{row.added:,}",
            f"{row.zones:,}",
            f"{1e3 * row.detect_s:.1f} ms",
            f"{1e3 * row.solve_s:.1f} ms",
        )
        for i, row in enumerate(result.history)
    ]
    return Table("Iterations", heads, rows)
