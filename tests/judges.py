"""Independent judges of a result: python-fcl at the end, ipctk on the path."""

import numpy as np


def fcl_crossings(positions, faces):
    """Pairs of faces that intersect at rest, by python-fcl.

    Traps of that library: a mesh against itself lists each face with itself and with its
    neighbours, the number of contacts is capped at one by default, NaN gives no contact.
    Faces that share a vertex touch there, so for them the edge opposite to it is tested
    against the other face, without the library.
    """
    import fcl

    assert np.isfinite(positions).all()
    model = fcl.BVHModel()
    model.beginModel(len(positions), len(faces))
    model.addSubModel(positions, faces)
    model.endModel()
    cap = 200 * len(faces) + 1000
    request = fcl.CollisionRequest(num_max_contacts=cap, enable_contact=True)
    result = fcl.CollisionResult()
    fcl.collide(fcl.CollisionObject(model), fcl.CollisionObject(model), request, result)
    pairs = np.array([(c.b1, c.b2) for c in result.contacts]).reshape(-1, 2)
    assert len(pairs) < cap, "contacts were cut off"
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    common = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None, :]).sum(axis=(1, 2))
    crossing = {tuple(p) for p in pairs[common == 0].tolist()}
    for i, j in pairs[common == 1].tolist():
        for a, b in ((i, j), (j, i)):
            edge = [v for v in faces[a] if v not in faces[b]]
            if edge_crosses(positions[edge], positions[faces[b]]):
                crossing.add((min(i, j), max(i, j)))
    return crossing


def edge_crosses(edge, face):
    """Whether an edge passes through a face, by signed volumes."""

    def volume(a, b, c, d):
        return np.linalg.det(np.array([b - a, c - a, d - a]))

    (p, q), (a, b, c) = edge, face
    if volume(a, b, c, p) * volume(a, b, c, q) >= 0.0:
        return False
    turns = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)]
    return all(t > 0.0 for t in turns) or all(t < 0.0 for t in turns)


def ipctk_path_is_free(scene, positions):
    """Tight Inclusion on the whole path, with settings that raise no false alarm."""
    import ipctk

    mesh = ipctk.CollisionMesh(scene.positions_t0, scene.edges, scene.faces)
    ccd = ipctk.TightInclusionCCD(tolerance=1e-9, max_iterations=10**7, conservative_rescaling=1.0)
    return ipctk.is_step_collision_free(mesh, scene.positions_t0, positions, 0.0, ipctk.LBVH(), ccd)
