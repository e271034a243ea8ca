"""Meshes with vertices that coincide, as exporters write them."""

import numpy as np

from tests.helpers.shapes import grid


def cut(mesh, labels, only=None):
    """Return a mesh in which faces of different labels share no vertex.

    Args:
        mesh: Arguments of a scene by name; `masses` and `pinned` may be missing.
        labels: (m,) int, the label of each face.
        only: (n,) bool, vertices that are doubled; all if None.

    Returns:
        The arguments of the mesh with copies of vertices. The copies come last; each has a part of
        the mass of its vertex, and is pinned as it is.
    """
    faces = np.array(mesh["faces"])
    numbers, of = {}, list(range(len(mesh["positions_t0"])))
    for row, label in zip(faces, np.asarray(labels).tolist(), strict=True):
        for k, vertex in enumerate(row.tolist()):
            own = numbers.setdefault(vertex, {})
            if own and label not in own and (only is None or only[vertex]):
                of.append(vertex)
                own[label] = len(of) - 1
            row[k] = own.setdefault(label, vertex)
    return doubled(mesh, faces, np.array(of))


def doubled(mesh, faces, of):
    """Return a mesh with other faces, whose vertex i is a copy of vertex `of[i]` of a mesh."""
    result = {name: mesh[name][of] for name in mesh if name != "faces"}
    result["faces"] = faces
    if "masses" in result:
        result["masses"] = result["masses"] / (1.0 + np.arange(len(of)) % 3)
    return result


def shuffled(rng, mesh):
    """Return a mesh with its vertices in another order, so that copies come first too."""
    order = rng.permutation(len(mesh["positions_t0"]))
    place = np.argsort(order)
    result = {name: mesh[name][order] for name in mesh if name != "faces"}
    return result | {"faces": place[mesh["faces"]]}


def folding_cloth(rng, n=8):
    """Return a sheet of which one half is folded through the other."""
    start, faces = grid(n, jitter=0.004 * rng.normal(size=(n * n, 3)))
    end = start.copy()
    right = start[:, 0] > 0.5
    end[right, 0] = 1.0 - start[right, 0]
    end[right, 2] -= 0.02
    return {"positions_t0": start, "positions_t1": end, "faces": faces}


def crossing_cloths(rng, n=7):
    """Return a sheet that falls through another one."""
    low, faces = grid(n, jitter=0.002 * rng.normal(size=(n * n, 3)))
    high, _ = grid(n, 0.05, jitter=0.002 * rng.normal(size=(n * n, 3)))
    start = np.concatenate((low, high + (0.013, 0.021, 0.0)))
    end = start.copy()
    end[n * n :, 2] -= 0.1
    return {
        "positions_t0": start,
        "positions_t1": end,
        "faces": np.concatenate((faces, faces + n * n)),
    }


def tube(rng, around=10, along=6, squeeze=0.4):
    """Return a closed tube of which two rings are pressed through each other."""
    angle, z = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(along) * 0.3)
    start = np.column_stack((np.cos(angle).ravel(), np.sin(angle).ravel(), z.ravel()))
    start += 0.003 * rng.normal(size=start.shape)
    i, j = np.divmod(np.arange(around * (along - 1)), around)
    a, b = i * around + j, i * around + (j + 1) % around
    faces = np.concatenate(
        (np.column_stack((a, b, b + around)), np.column_stack((a, b + around, a + around)))
    )
    end = start.copy()
    end[around : 2 * around, 2] += squeeze
    labels = np.concatenate((j, j)) >= around // 2
    seam = np.arange(len(start)) % around == 0
    return {"positions_t0": start, "positions_t1": end, "faces": faces}, labels, seam


def centres(mesh):
    """Return the mean of the corners of each face at the start, (m, 3)."""
    return mesh["positions_t0"][mesh["faces"]].mean(axis=1)


def seams(rng):
    """Return meshes with seams by name, each made of a mesh whose step has impacts."""
    fold, cross = folding_cloth(rng), crossing_cloths(rng)
    n = len(cross["positions_t0"])
    x, y = centres(cross).T[:2]
    upper = np.arange(len(x)) >= len(x) // 2
    masses = {"masses": 10.0 ** rng.uniform(-3, 3, n)}
    pins = {"pinned": np.arange(n) < n // 2}
    x_fold = centres(fold)[:, 0]
    closed, labels, seam = tube(rng)
    found = {
        "one seam": cut(fold, x_fold > 0.4),
        "seam on the fold": cut(fold, x_fold > 0.5),
        "crossing seams": cut(cross, 2 * (x > 0.5) + (y > 0.5)),
        "seams in a T": cut(cross, np.where(x > 0.5, 1 + (y > 0.5), 0)),
        "closed tube": cut(closed, labels, seam),
        "soup": cut(cross, np.arange(len(x))),
        "soup of masses": cut(cross | masses, np.arange(len(x))),
        "pinned soup": cut(cross | masses | pins, np.arange(len(x))),
        "seam of the pinned part": cut(cross | pins, np.where(upper, 0, x > 0.5)),
        "doubled layer": doubled_layer(cross, upper),
        "negative zeros": cut(flat_zero(cross), x > 0.5),
    }
    negative = found["negative zeros"]["positions_t0"]
    negative[n:][negative[n:] == 0.0] = -0.0
    return {name: shuffled(rng, mesh) for name, mesh in found.items()}


def doubled_layer(mesh, chosen):
    """Return a mesh with exact copies of some faces, turned over."""
    n, faces = len(mesh["positions_t0"]), mesh["faces"]
    used = np.unique(faces[chosen])
    place = np.zeros(n, int)
    place[used] = n + np.arange(len(used))
    both = np.concatenate((faces, place[faces[chosen]][:, [0, 2, 1]]))
    return doubled(mesh, both, np.concatenate((np.arange(n), used)))


def flat_zero(mesh):
    """Return a mesh whose lower half starts exactly at z = 0."""
    start = mesh["positions_t0"].copy()
    start[: len(start) // 2, 2] = 0.0
    end = mesh["positions_t1"].copy()
    return mesh | {"positions_t0": start, "positions_t1": end}
