"""Draw the case of a family, a kind, a seed and a number."""

import numpy as np

from izo_ref.base.arrays import Flags
from izo_ref.base.errors import InitialIntersectionError, IzoError
from validation.stability_steps.case import Case
from validation.stability_steps.families import FAMILIES
from validation.stability_steps.kinds import KINDS

KEPT_AS_IT_IS = 0.1  # share of cases whose start is not made free
ROUNDS = 20
LARGEST = 200  # faces
# Where everything touches at the start, or ends in one point, each face has many pairs that exact
# arithmetic decides in each detection. Such meshes are smaller.
FEWER = {"start": 24, "mixed": 60, "collapse": 24, "turning": 60, "balls": 100}


def draw(family: str, kind: str, seed: int, number: int) -> Case:
    """Draw a case: the same one for the same arguments.

    The size is from 1 to 200 faces; most cases are small. In nine of ten cases, faces are left out
    that intersect others at the start, unless the modes say that the start may intersect.

    Args:
        family: One of `FAMILIES`.
        kind: One of `KINDS`.
        seed: Seed of the run.
        number: Number of the case in its batch.
    """
    words = [list(word.encode()) for word in (family, kind)]
    rng = np.random.default_rng([seed, number, len(words[0]), *words[0], *words[1]])
    largest = min(FEWER.get(word, LARGEST) for word in (family, kind))
    n = int(largest ** rng.random() ** 2)
    with np.errstate(over="ignore", under="ignore"):
        case = KINDS[kind](rng, FAMILIES[family](rng, n))
    starts_free = case.modes.get("initial_intersections", "raise") == "raise"
    if starts_free and rng.random() >= KEPT_AS_IT_IS:
        case = _made_free(case)
    return case


def _made_free(case: Case) -> Case:
    """Leave out faces, and vertices in no face, until the start is free.

    The package itself says which pairs intersect. If it is wrong, the oracle that judges the result
    finds out.
    """
    for _ in range(ROUNDS):
        try:
            case.scene()
        except InitialIntersectionError as error:
            hit = np.zeros(len(case.positions_t0), bool)
            first = error.pairs.nodes[:: max(1, len(error.pairs.nodes) // 8)]
            hit[first[:, 0]] = True
            kept = np.asarray(~hit[case.faces].any(axis=1))
            alone = ~np.isin(np.arange(len(hit)), case.faces) & ~hit
            case = _with_alone(case, kept, alone)
        except IzoError:
            break
        else:
            break
    return case


def _with_alone(case: Case, kept_faces: Flags, alone: Flags) -> Case:
    """Return the case with some faces, their vertices, and some vertices in no face."""
    used = alone.copy()
    used[case.faces[kept_faces].ravel()] = True
    place = np.cumsum(used) - 1
    faces = place[case.faces[kept_faces]].astype(np.int32)
    return case.take_vertices(np.flatnonzero(used)).change(faces=faces)
