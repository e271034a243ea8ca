"""Cases of the porting kit made by hand, one or two for each judge, and right replies to them."""

from izo_ref.porting.cases import ACCEPTABLE, INVALID, VALID, Case

SHEET = {
    "positions_t0": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.25, 0.25, 1.0],
    "positions_t1": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.25, 0.25, -1.0],
    "faces": [0, 1, 2],
}
PAIR = {
    "is_edge_edge": 0,
    "start": [0.25, 0.25, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    "end": [0.25, 0.25, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
}
# One impact of a vertex with a pinned face: the vertex must end at z = 0.1.
ZONE = {
    "nodes": [0, 1, 2, 3],
    "weights": [1.0, -0.5, -0.25, -0.25],
    "normals": [0.0, 0.0, 1.0],
    "proposed": [0.25, 0.25, -0.4, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    "masses": [2.0, 1.0, 1.0, 1.0],
    "pinned": [0, 1, 1, 1],
    "thickness": 0.1,
}
SOLVED = [0.25, 0.25, 0.1, *ZONE["proposed"][3:]]
BOTH = ("f8", "f4")


def values(numbers, scale=1.0, multiple=4):
    """Return what the judge `values` needs."""
    return {"judge": "values", "values": numbers, "scale": [scale], "multiple": multiple}


def equal(*items):
    """Return what the judge `equal` needs."""
    return {"judge": "equal", "values": list(items)}


def case(name, inputs, expected, flag="kink", verdict=VALID, dtypes=BOTH):
    """Return a case; its stage is the beginning of its name."""
    stage = name.partition("-")[0]
    what = "A case that was made by hand."
    return Case(name, stage, (flag,), verdict, "easy", dtypes, what, inputs, expected)


def clamp(name="S9-clamp-01", multipliers=(1.0, 0.5), constraints=(-2.0, 0.25), penalty=2.0):
    """Return a case of S9."""
    moved = zip(multipliers, constraints, strict=True)
    new = [max(multiplier + penalty * c, 0.0) for multiplier, c in moved]
    inputs = {
        "multipliers": list(multipliers),
        "constraints": list(constraints),
        "penalty": penalty,
    }
    return case(name, inputs, {"multipliers": values(new)}, "multipliers-not-clamped")


def pairs():
    """Return a case of S1."""
    found = {"judge": "superset", "kind": "vertex-face", "pairs": [3, 0, 1, 2]}
    none = {"judge": "superset", "kind": "edge-edge", "pairs": []}
    return case("S1-pairs-01", SHEET, {"vertex_face": found, "edge_edge": none}, "missed-pairs")


def time_of_impact():
    """Return a case of S2."""
    toi = {"judge": "time", "time": 0.5, "scale": [1.0], "multiple": 4, "early": 2.0**-10}
    return case("S2-time-01", PAIR, {"meets": equal(1), "toi": toi}, "late-time")


def apart():
    """Return a case of S2 in which nothing meets."""
    end = [0.25, 0.25, 0.5, *PAIR["end"][3:]]
    return case("S2-apart-01", {**PAIR, "end": end}, {"meets": equal(0)}, "ends-of-step")


def frame():
    """Return a case of S3 in which the normal and the weights count as not unique."""
    weights = {"judge": "weights", "distance": 0.0, "scale": [1.0], "multiple": 8}
    normal = {"judge": "side", "scale": [1.0], "multiple": 8, "least_gap": 0.5}
    inputs = {**PAIR, "toi": 0.5}
    return case("S3-frame-01", inputs, {"weights": weights, "normal": normal}, "normal-sign")


def groups():
    """Return a case of S5."""
    inputs = {"nodes": [0, 1, 2, 3, 3, 4, 5, 6, 7, 8, 9, 10, 11, 11, 11, 11]}
    inputs["pinned"] = [0] * 11 + [1]
    expected = {"zone_of_impact": {"judge": "partition", "values": [0, 0, 1, -1]}}
    return case("S5-groups-01", inputs, expected, "zone-transitive")


def optimum():
    """Return a case of S11 whose multipliers are judged by the conditions of the optimum."""
    expected = {"feasible": equal(1), "positions": values(SOLVED)}
    expected["multipliers"] = {"judge": "kkt", "scale": [1.0], "multiple": 16}
    return case("S11-one-01", ZONE, expected, "early-stop")


def bad_input():
    """Return a case of S13 that must be refused."""
    inputs = {**SHEET, "faces": [0, 1, 9], "masses": [1.0] * 4, "pinned": [0] * 4, "thickness": 0.1}
    expected = {"status": equal("refused"), "offender": equal(0)}
    return case("S13-index-01", inputs, expected, "bad-index", INVALID)


def fine_input():
    """Return a case of S13 that must be accepted."""
    inputs = {**SHEET, "masses": [1.0] * 4, "pinned": [0] * 4, "thickness": 0.1}
    return case("S13-fine-01", inputs, {"status": equal("ok")}, "over-strict")


def near_tie():
    """Return a case of S2 that a port may refuse."""
    expected = {"meets": equal(1)}
    return case("S2-tie-01", PAIR, expected, "stays-coplanar", ACCEPTABLE)


def step():
    """Return a case of S12 with one vertex that falls through a pinned face."""
    inputs = {**SHEET, "masses": [1.0] * 4, "pinned": [1, 1, 1, 0], "thickness": 0.125}
    path = {"judge": "free-path", "objective_at_most": 1.5}
    return case("S12-step-01", inputs, {"free": equal(1), "positions": path}, "unhonest-status")


def right(case):
    """Return a reply that passes where it cannot be made from what the case expects, or None."""
    if case.stage != "S12":
        return None
    positions = [*SHEET["positions_t1"][:11], 0.125]
    return {"id": case.id, "status": "ok", "output": {"free": 1, "positions": positions}}


def small_cases():
    """Return one case of each kind, in the order of the stages."""
    return [
        pairs(),
        time_of_impact(),
        apart(),
        near_tie(),
        frame(),
        groups(),
        clamp(),
        clamp("S9-clamp-02", (0.0,), (0.5,), 4.0),
        optimum(),
        bad_input(),
        fine_input(),
    ]
