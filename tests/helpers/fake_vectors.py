"""A few cases of some stages, in the place of those that the generators make."""

from izo_ref.porting.cases import Case

PAIR = {
    "is_edge_edge": 0,
    "start": [0.25, 0.25, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    "end": [0.25, 0.25, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
}
EDGES = {
    "is_edge_edge": 1,
    "start": [-1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0],
    "end": [-1.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0],
}
ZONE = {
    "nodes": [0, 1, 2, 3],
    "weights": [1.0, -0.5, -0.25, -0.25],
    "normals": [0.0, 0.0, 1.0],
    "proposed": [0.25, 0.25, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    "masses": [1.0, 1.0, 1.0, 1.0],
    "pinned": [0, 0, 0, 1],
    "thickness": 0.5,
}
MESH = {
    "positions_t0": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    "positions_t1": [0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0],
    "faces": [0, 1, 2],
}
STEP = {**MESH, "masses": [1.0, 1.0, 1.0], "pinned": [0, 0, 0], "thickness": 0.125}
BOTH = ("f8", "f4")
REFUSED = {"status": {"judge": "equal", "values": ["refused"]}}


def exactly(*numbers):
    """Return what the judge of values expects, with half a unit of each number as its scale."""
    scale = [max(abs(number), 2.0**-40) / 2.0 for number in numbers]
    return {"judge": "values", "values": list(numbers), "scale": scale, "multiple": 4}


def case(case_id, flag, inputs, expected, **other):
    """Return a valid and easy case of the stage that its id begins with."""
    stage = case_id.partition("-")[0]
    made = Case(case_id, stage, (flag,), "valid", "easy", BOTH, "It is made up.", inputs, expected)
    return made._replace(**other)


def time_of_impact(case_id, pair):
    """Return a case of S2 whose pair meets at t = 1/2."""
    judge = {"judge": "time", "time": 0.5, "scale": 1.0, "multiple": 4, "early": 0.125}
    meets = {"judge": "equal", "values": [1]}
    return case(case_id, "linear-cubic", pair, {"meets": meets, "toi": judge})


def frame(case_id, pair, weights):
    """Return a case of S3 with known weights and a normal that is not unique."""
    side = {"judge": "side", "multiple": 8, "scale": 1.0, "least_gap": 0.5}
    expected = {"weights": exactly(*weights), "normal": side}
    return case(case_id, "normal-sign", {**pair, "toi": 0.5}, expected, grade="hard")


def still_mesh(n):
    """Return a case of S12 with so many vertices that some arrays are files of their own."""
    positions = [0.5 * k for k in range(3 * n)]
    step = {
        "positions_t0": positions,
        "positions_t1": [*positions],
        "faces": [0, 1, 2],
        "masses": [1.0] * n,
        "pinned": [0] * n,
        "thickness": 0.125,
    }
    free = {"judge": "equal", "values": [1]}
    near = {"judge": "free-path", "objective_at_most": 0.0}
    return case("S12-still-01", "over-strict", step, {"free": free, "positions": near})


def fake_cases():
    """Return the cases, by stage."""
    vertices = {"judge": "superset", "kind": "vertex-face", "pairs": []}
    lagrangian = {**ZONE, "positions": ZONE["proposed"], "multipliers": [0.0], "penalty": 2.0}
    gradient = exactly(*([0.0] * 12))
    grown = {"multipliers": [1.0, 0.25], "constraints": [0.5, -1.0], "penalty": 0.5}
    bad = {**STEP, "faces": [0, 1]}
    return {
        "S1": [case("S1-none-01", "missed-pairs", MESH, {"vertex_face": vertices})],
        "S2": [time_of_impact("S2-face-01", PAIR), time_of_impact("S2-edges-01", EDGES)],
        "S3": [
            frame("S3-face-01", PAIR, [1.0, -0.5, -0.25, -0.25]),
            frame("S3-edges-01", EDGES, [0.5, 0.5, -0.5, -0.5]),
        ],
        "S7": [
            case("S7-kink-01", "kink", lagrangian, {"value": exactly(2.25), "gradient": gradient})
        ],
        "S9": [
            case(
                "S9-clamp-01", "multipliers-not-clamped", grown, {"multipliers": exactly(1.25, 0.0)}
            )
        ],
        "S12": [still_mesh(700)],
        "S13": [
            case("S13-short-01", "bad-shape", bad, REFUSED, verdict="invalid", grade="medium"),
            case(
                "S13-fine-01", "over-strict", STEP, {"status": {"judge": "equal", "values": ["ok"]}}
            ),
        ],
    }
