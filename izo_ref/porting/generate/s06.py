"""Cases of stage S6: the objective, its gradient and the constraints of a zone at a point."""

from __future__ import annotations

from random import Random

from izo_ref.porting.cases import DTYPES, Case
from izo_ref.porting.generate.expected import CaseList, exact_inputs, values
from izo_ref.porting.generate.small_zones import (
    Inputs,
    dyadic,
    pair_weights,
    random_zone,
    with_all_digits,
    zone_above_face,
)
from izo_ref.porting.reference.zone import (
    constraints,
    curvatures,
    displacements,
    objective,
    objective_gradient,
    vectors,
    zone_of,
)

NODES = "node-order"
MASSES = "mass-weighting"
PINNED = "pinned-masses"
SIGN = "constraint-sign"
SUMS = "lost-sum"
FAR = "float32-coordinates"


def cases() -> list[Case]:
    """Return the cases of stage S6."""
    result = CaseList("S6")
    for part in (_nodes, _masses, _pinned, _signs, _sums, _far):
        part(result)
    return result


def _add(
    result: CaseList,
    flags: str,
    grade: str,
    what: str,
    inputs: Inputs,
    dtypes: tuple[str, ...] = DTYPES,
) -> None:
    """Add a case with what the reference computes; without float32, all inputs are exact."""
    known = inputs if "f4" in dtypes else exact_inputs(inputs)
    zone, x = zone_of(known), vectors(known["positions"])
    moved = displacements(zone, x)
    gradient = objective_gradient(curvatures(zone), moved)
    expected = {
        "objective": values([objective(zone, moved)]),
        "gradient": values([a for vector in gradient for a in vector]),
        "constraints": values(constraints(zone, x)),
    }
    result.add(flags.split()[0], flags, grade, what, inputs, expected, dtypes)


def _nodes(result: CaseList) -> None:
    inputs = zone_above_face([0.125])
    what = (
        "A vertex above a face: the weight of the vertex is 1, those of the corners are negative."
    )
    _add(result, NODES, "easy", what, inputs)
    inputs = random_zone(Random(601), 1, 4) | {"nodes": [0, 1, 2, 3]}
    inputs["weights"] = [0.875, 0.125, -0.25, -0.75]
    _add(result, NODES, "easy", "Two edges, with a contact near one end of each.", inputs)
    inputs = random_zone(Random(602), 1, 4) | {"nodes": [3, 1, 0, 2]}
    what = "The corners of a face are not in ascending order, and each has a weight of its own."
    _add(result, NODES, "medium", what, inputs)
    inputs = random_zone(Random(603), 1, 6) | {"nodes": [5, 2, 4, 0]}
    inputs["weights"] = pair_weights(Random(604), True)
    _add(result, NODES, "medium", "Two edges whose ends are not in ascending order.", inputs)
    inputs = random_zone(Random(605), 2, 6)
    inputs["weights"] = [1.0, 0.0, -1.0, 0.0, 0.0, 1.0, -1.0, 0.0]
    what = "Contacts at a corner and at the ends of edges: some weights are 0."
    _add(result, NODES, "medium", what, inputs)
    what = "Six pairs of both kinds share seven vertices in different places."
    _add(result, NODES, "hard", what, random_zone(Random(606), 6, 7))


def _masses(result: CaseList) -> None:
    def zone(seed: int, masses: tuple[float, ...], vertices: int = 4) -> Inputs:
        return random_zone(Random(seed), 1, vertices, masses=masses)

    what = "All masses are 2 kg: they cancel, because g is divided by their sum."
    _add(result, MASSES, "easy", what, zone(611, (2.0,)))
    what = "Masses of 1, 2, 4 and 8 kg: a mean without weights is another number."
    _add(result, MASSES, "easy", what, zone(612, (1.0, 2.0, 4.0, 8.0)))
    what = "Masses of a fine cloth, 2^-17 kg and 2^-18 kg: g does not depend on their unit."
    _add(result, MASSES, "medium", what, zone(613, (2.0**-17, 2.0**-18)))
    what = "The masses differ by a factor of 2^20."
    _add(result, MASSES, "medium", what, zone(614, (1.0, 2.0**-20)))
    what = "Vertices without an impact belong to g and to the sum of masses too."
    _add(result, MASSES, "hard", what, zone(615, (0.5, 3.0, 1.25), 9))
    what = "The masses differ by a factor of 2^40; the gradient at the light vertices is not lost."
    _add(result, MASSES, "hard", what, zone(616, (2.0**20, 2.0**-20)))


def _pinned(result: CaseList) -> None:
    def zone(seed: int, mass: float, pinned: tuple[int, ...], impacts: int = 1) -> Inputs:
        inputs = random_zone(Random(seed), impacts, 5, masses=(1.0, 0.5, 0.25), pinned=pinned)
        inputs["masses"] = [mass if i in pinned else m for i, m in enumerate(inputs["masses"])]
        return inputs

    what = "A pinned vertex of 1 kg: its mass is not part of the sum."
    _add(result, PINNED, "easy", what, zone(621, 1.0, (2,)))
    what = "The mass of a pinned vertex is written as 0."
    _add(result, PINNED, "medium", what, zone(622, 0.0, (0,)))
    what = "The mass of a pinned vertex is written as 2^40 kg."
    _add(result, PINNED, "medium", what, zone(623, 2.0**40, (1, 3)))
    what = "The mass of a pinned vertex is infinite: 0 times it is not a number."
    _add(result, PINNED, "hard", what, zone(624, float("inf"), (4,), 3))
    what = "All vertices but one are pinned, with masses of -1 kg that mean nothing."
    _add(result, PINNED, "hard", what, zone(625, -1.0, (0, 1, 2, 4), 2))


def _signs(result: CaseList) -> None:
    _add(
        result,
        SIGN,
        "easy",
        "The gap is larger than the thickness: c < 0.",
        zone_above_face([-0.5]),
    )
    what = "The vertex is behind the face: c is the thickness plus the depth."
    _add(result, SIGN, "easy", what, zone_above_face([0.5]))
    what = "The gap is exactly the thickness: c = 0."
    _add(result, SIGN, "medium", what, zone_above_face([0.0, 0.0]))
    what = "The vertex is in the plane of the face, and d is 2^-20 m: c = d."
    _add(result, SIGN, "medium", what, zone_above_face([2.0**-20], 2.0**-20))
    what = "A constraint that is satisfied by a metre is reported as it is, and not as 0."
    _add(result, SIGN, "hard", what, zone_above_face([-1.0, 2.0**-12, -(2.0**-12)]))
    what = "Eight pairs of both kinds with normals in all directions and both signs of c."
    _add(result, SIGN, "hard", what, random_zone(Random(631), 8, 10))


def _sums(result: CaseList) -> None:
    what = "Two impacts share a vertex, which counts once in g and in the sum of masses."
    _add(result, SUMS, "easy", what, random_zone(Random(641), 2, 7, hub=True))
    what = "One vertex is in all of twelve impacts, and counts once."
    inputs = random_zone(Random(642), 12, 12, masses=(1.0, 2.0), hub=True)
    _add(result, SUMS, "medium", what, inputs)
    what = "One vertex is in all of 200 impacts on 16 vertices."
    inputs = random_zone(Random(643), 200, 16, masses=(1.0, 0.25), hub=True)
    _add(result, SUMS, "hard", what, inputs)
    what = "A sum over 256 vertices, most of which have no impact: more than threads of a warp."
    _add(result, SUMS, "hard", what, random_zone(Random(644), 2, 256, masses=(1.0, 0.5, 2.0)))
    what = "A sum over 1100 vertices: more than threads of the largest block."
    _add(result, SUMS, "hard", what, random_zone(Random(645), 2, 1100, masses=(1.0, 0.5, 2.0)))


def _far(result: CaseList) -> None:
    def zone(seed: int, origin: tuple[float, ...], size: float, impacts: int) -> Inputs:
        return random_zone(Random(seed), impacts, 4 * impacts, origin=origin, size=size)

    random = Random(650)
    what = "A zone of 1 m, 700 m away from the origin: subtract positions before anything else."
    _add(result, FAR, "easy", what, zone(651, (512.0, 512.0, -512.0), 1.0, 1))
    what = "A zone of 1 m, 1 km away from the origin."
    _add(result, FAR, "medium", what, zone(652, (1024.0, -512.0, 768.0), 1.0, 2))
    what = "A zone of 6 cm, 1 km away from the origin along one axis."
    _add(result, FAR, "medium", what, zone(653, (0.0, 1000.0, 0.0), 2.0**-4, 2))
    what = "Float64 coordinates with a unit of 2^-32 m, 1 km away: too many digits for float32."
    inputs = zone(656, (1024.0, -512.0, 768.0), 1.0, 2)
    for name in ("proposed", "positions"):
        inputs[name] = [a + dyadic(random, 0.0, 2.0**-10, 32) for a in inputs[name]]
    inputs["weights"] = [*pair_weights(random, False, 22), *pair_weights(random, True, 22)]
    _add(result, FAR, "medium", what, inputs, ("f8",))
    what = (
        "A zone of 64 m, 786 km away: float32 has a unit of 6 cm there, and all inputs are exact."
    )
    _add(result, FAR, "hard", what, zone(654, (1.5 * 2.0**19, 0.0, -(2.0**19)), 64.0, 2))
    what = "Three pairs of 1 m, 8 km away on a diagonal, where products with normals nearly cancel."
    _add(result, FAR, "hard", what, zone(655, (8192.0, 8192.0, 8192.0), 1.0, 3))
    what = "All inputs have the digits of a float64; none of them may be kept in float32."
    inputs = with_all_digits(Random(657), random_zone(Random(658), 3, 8, masses=(1.0, 0.5)))
    _add(result, FAR, "medium", what, inputs, ("f8",))
