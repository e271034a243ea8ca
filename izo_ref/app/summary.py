"""Results as plain data: everything but the arrays."""

import dataclasses
import math

import numpy as np

from izo_ref.base.records import Impacts, Pairs
from izo_ref.certificate.certify import PathCertificate
from izo_ref.loop.resolve import Result

NAMED = 20  # pairs written out, the count is always given


def pairs_summary(pairs: Pairs | None, toi=None) -> dict:
    """How many pairs of each kind, and the first by name."""
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


def impacts_summary(impacts: Impacts) -> dict:
    return pairs_summary(Pairs(impacts.nodes, impacts.is_edge_edge), impacts.toi)


def certificate_summary(certificate: PathCertificate) -> dict:
    content = certificate._asdict()
    content["meeting"] = pairs_summary(certificate.meeting, certificate.meeting_toi)
    content["excluded"] = pairs_summary(certificate.excluded)
    del content["meeting_toi"]
    return content


def result_summary(result: Result) -> dict:
    """Everything of a result except arrays, ready for JSON."""
    sizes = np.diff(result.zones.impact_offsets)
    worst = {
        name: max((getattr(r, name) for r in result.residuals), default=0.0)
        for name in ("violation_m", "violation", "dual_violation", "stationarity", "gap")
    }
    return {
        "status": result.status.name,
        "meaning": result.status.value,
        "converged": result.converged,
        "feasible": result.feasible,
        "free": result.certificate.free,
        "time_free": result.time_free,
        "objective_m2": result.objective,
        "thickness_m": result.thickness,
        "impacts": impacts_summary(result.impacts),
        "zones": {"count": len(result.zones), "largest": int(sizes.max(initial=0))},
        "worst_residuals": {k: v if math.isfinite(v) else str(v) for k, v in worst.items()},
        "certificate": certificate_summary(result.certificate),
        "scaled_back": [
            {"vertices": len(s.vertices), "scale": s.scale} for s in result.scaled_back
        ],
        "iterations": len(result.history),
        "history": [row._asdict() for row in result.history],
        "timings_s": result.timings,
        "plan": [line._asdict() for line in result.plan.lines],
        "options": dataclasses.asdict(result.options),
    }
