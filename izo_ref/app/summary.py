"""Results as plain data: everything but the arrays."""

import dataclasses
import math
from collections import Counter
from enum import IntEnum
from typing import Any

import numpy as np

from izo_ref.base.arrays import Codes, Indices, Times
from izo_ref.base.records import Exclusion, Impacts, Pairs, PairState
from izo_ref.certificate.certify import PathCertificate
from izo_ref.loop.resolve import Result

NAMED = 20  # pairs that are written out; the count is always given


def pairs_summary(pairs: Pairs | None, toi: Times | None = None) -> dict[str, Any]:
    """Count the pairs of each kind, and write out the first ones.

    Args:
        pairs: The pairs; None counts as no pairs.
        toi: (n,) f8, times of impact, from 0 to 1, if they are known.

    Returns:
        `vertex_face` and `edge_edge`, the counts, and `first`, a list with kind, nodes and, if
        known, toi of up to `NAMED` pairs.
    """
    if pairs is None:
        return {"vertex_face": 0, "edge_edge": 0, "first": []}
    rows = []
    for i in range(min(NAMED, len(pairs.nodes))):
        kind = "edge_edge" if pairs.is_edge_edge[i] else "vertex_face"
        row = {"kind": kind, "nodes": pairs.nodes[i].tolist()}
        if toi is not None:
            row["toi"] = float(toi[i])
        rows.append(row)
    return {
        "vertex_face": int((~pairs.is_edge_edge).sum()),
        "edge_edge": int(pairs.is_edge_edge.sum()),
        "first": rows,
    }


def impacts_summary(impacts: Impacts) -> dict[str, Any]:
    """Count impacts of each kind, and write out the first ones; see `pairs_summary`."""
    return pairs_summary(Pairs(impacts.nodes, impacts.is_edge_edge), impacts.toi)


def excluded_summary(certificate: PathCertificate) -> dict[str, Any]:
    """Count the excluded pairs of a certificate by reason and end, and write out the first ones.

    Returns:
        What `pairs_summary` returns, with `reason` and `at_end` of each pair that is written out;
        `reasons` and `at_end`, the counts; and `count`.
    """
    excluded, ends = certificate.excluded, certificate.excluded_ends
    if excluded is None:
        return pairs_summary(None) | {"count": 0}
    content = pairs_summary(Pairs(excluded.nodes, excluded.is_edge_edge))
    reasons, states = (_names(codes) for codes in (Exclusion, PairState))
    for row, reason, end in zip(content["first"], excluded.reasons, ends, strict=False):
        row |= {"reason": reasons[reason], "at_end": states[end]}
    return content | {
        "reasons": _counts(reasons, excluded.reasons),
        "at_end": _counts(states, ends),
        "count": len(ends),
    }


def excluded_line(summary: dict[str, Any]) -> str:
    """Say in a sentence how many pairs were left out, why, and where they end.

    Args:
        summary: What `excluded_summary` returned, for at least one pair.
    """
    n, why, end = summary["count"], summary["reasons"], summary["at_end"]
    unknown = f", not decided in time: {end['unknown']}" if end["unknown"] else ""
    return (
        f"{n} {'pair was' if n == 1 else 'pairs were'} left out (cross at the start: "
        f"{why['crossing']}, touch there and the mesh tells no side: {why['touching']}, between "
        f"pinned points: {why['prescribed']}); at the end (apart: {end['apart']}, touching: "
        f"{end['touching']}, crossing: {end['crossing']}{unknown})"
    )


def _names(codes: type[IntEnum]) -> list[str]:
    return [code.name.lower() for code in codes]


def _counts(names: list[str], codes: Codes) -> dict[str, int]:
    return dict(zip(names, np.bincount(codes, minlength=len(names)).tolist(), strict=True))


def certificate_summary(certificate: PathCertificate) -> dict[str, Any]:
    """Return a certificate as plain data, with summaries of its pairs."""
    content = certificate._asdict()
    content["meeting"] = pairs_summary(certificate.meeting, certificate.meeting_toi)
    for row, prescribed in zip(
        content["meeting"]["first"], certificate.meeting_prescribed.tolist(), strict=False
    ):
        row["prescribed"] = prescribed
    content["excluded"] = excluded_summary(certificate)
    touching = certificate.scene.touching
    content["touching_at_start"] = 0 if touching is None else len(touching.nodes)
    for array in ("meeting_toi", "meeting_prescribed", "excluded_ends", "scene", "positions"):
        del content[array]
    return content


def n_copies(copies: Indices | None) -> int:
    """Count the vertices that are copies of others; `copies` as `Scene` has them."""
    return 0 if copies is None else int(np.count_nonzero(copies != np.arange(len(copies))))


def result_summary(result: Result) -> dict[str, Any]:
    """Return everything of a result except its arrays, ready for JSON."""
    sizes = np.diff(result.zones.impact_offsets)
    worst = {
        name: max((getattr(r, name) for r in result.residuals), default=0.0)
        for name in ("violation_m", "violation", "dual_violation", "stationarity", "gap")
    }
    return {
        "status": result.status.name,
        "meaning": result.status.value,
        "reason": result.reason,
        "converged": result.converged,
        "feasible": result.feasible,
        "free": result.certificate.free,
        "time_free": result.time_free,
        "objective_m2": result.objective,
        "thickness_m": result.thickness,
        "impacts": impacts_summary(result.impacts),
        "zones": {
            "count": len(result.zones),
            "largest": int(sizes.max(initial=0)),
            "statuses": dict(Counter(status.name for status in result.zone_statuses)),
        },
        "worst_residuals": {k: v if math.isfinite(v) else str(v) for k, v in worst.items()},
        "certificate": certificate_summary(result.certificate),
        "copies": n_copies(result.certificate.scene.copies),
        "scaled_back": [
            {"vertices": len(s.vertices), "scale": s.scale} for s in result.scaled_back
        ],
        "iterations": len(result.history),
        "history": [row._asdict() for row in result.history],
        "timings_s": result.timings,
        "plan": [line._asdict() for line in result.plan.lines],
        "options": dataclasses.asdict(result.options),
    }
