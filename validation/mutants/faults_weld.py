"""Faults of welding: which vertices are one vertex, and what becomes of their copies."""

from validation.mutants.fault import (
    ON_GPU,
    WELDED,
    Fault,
)

FOUND = "tests/detection/test_weld.py"
SEAMS = "tests/loop/test_weld.py"
FLAT = f"{FOUND}::test_flat_faces_are_left_out_if_another_face_has_their_edge"
PINNED = f"{FOUND}::test_a_group_takes_the_path_of_its_first_pinned_vertex"

WELD = [
    Fault(
        "copies-in-trees",
        "izo_ref/detection/weld.py",
        "    return vertices[copies[vertices] == vertices], edges, faces\n",
        "    return vertices, edges, faces\n",
        "Copies of vertices are in the trees, so they touch the faces at their places.",
        (SEAMS,),
        flag="weld",
        not_by_vectors=WELDED,
    ),
    Fault(
        "copies-in-trees-of-a-gpu",
        "izo_ref/detection/gpu_trees.py",
        "        to_gpu(Elements(vertices, of_vertices).tree),\n",
        "        to_gpu(Elements(vertices, vertices[:, 0]).tree),\n",
        "On a GPU, copies of vertices are in the trees.",
        ("tests/cuda/test_simulator.py",),
        limit_s=1200.0,
        flag="weld",
        not_by_vectors=ON_GPU,
    ),
    Fault(
        "mass-of-the-lowest-copy",
        "izo_ref/detection/weld.py",
        "        sums: Masses = np.bincount(copies, masses, len(masses)).astype(np.float64)\n",
        "        sums: Masses = np.where(copies == np.arange(len(copies)), masses, 0.0)\n",
        "A welded vertex has the mass of its lowest copy alone.",
        (SEAMS,),
        flag="weld",
        not_by_vectors=WELDED,
    ),
    Fault(
        "copies-stay-where-they-are",
        "izo_ref/loop/resolve.py",
        "        positions = positions[scene.copies]\n",
        "        positions = np.where(np.isin(np.arange(len(positions)), order)[:, None], "
        "positions, scene.positions_t1)\n",
        "Copies end at their proposed positions, wherever their vertex ends.",
        (SEAMS,),
        flag="weld",
        not_by_vectors=WELDED,
    ),
    Fault(
        "weld-by-the-start-alone",
        "izo_ref/detection/weld.py",
        "    group = equal_rows(np.hstack((positions_t0, positions_t1)))\n",
        "    group = equal_rows(positions_t0)\n",
        "Vertices that start at one place are one vertex, although they end at different ones.",
        (FOUND, SEAMS),
        flag="weld",
        not_by_vectors=WELDED,
    ),
    Fault(
        "flat-face-dropped-with-its-edge",
        "izo_ref/detection/weld.py",
        "    if alone.any():\n",
        "    if alone.all():\n",
        "A face that welding turns into an edge of its own is dropped without a word.",
        (FLAT,),
        flag="weld",
        not_by_vectors=WELDED,
    ),
    Fault(
        "pinned-vertex-follows-the-lowest",
        "izo_ref/detection/weld.py",
        "    leaders[copies[from_last]] = from_last  # of equal indices, the last one assigns\n",
        "    leaders[copies[from_last]] = copies[from_last]\n",
        "A pinned vertex takes the path of a lower vertex that is not pinned.",
        (PINNED,),
        flag="weld",
        not_by_vectors=WELDED,
    ),
]
