"""The filter of the path certificate on a GPU."""

from collections.abc import Set

import numpy as np

from izo_ref.base.arrays import Flags, GpuArray, Positions
from izo_ref.base.deadline import Deadline
from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.base.records import Impacts, PairCounts, SceneArrays
from izo_ref.certificate.cuda import meetings as kernels
from izo_ref.detection.gpu_detector import Detector


def filter_path(
    scene: SceneArrays, positions: Positions, rules: Set[str], deadline: Deadline
) -> tuple[Impacts, Flags, PairCounts]:
    """Find the pairs of a path that are not proved apart.

    The detection is a new one, with new trees, over all pairs.

    Args:
        scene: The scene, which gives the start, the mesh and the pairs to ignore.
        positions: (n_vertices, 3) f8 [m], end of the path, on the CPU.
        rules: Not used; a GPU looks at every pair.
        deadline: When the filter has to end; checked between the detection and the verdicts.

    Returns:
        The pairs as `Impacts`; which of them certainly meet, (n,) b1; and the counts of the
        detection. All are on the CPU.
    """
    detector, end = Detector(scene), to_gpu(positions)
    found = detector.find(end)
    deadline.check()
    return to_cpu(found), which_meet(detector.start, end, found), detector.counts


def which_meet(positions_t0: GpuArray, positions_t1: GpuArray, pairs: Impacts) -> Flags:
    """Return which pairs certainly meet on a path, (n,) b1, on the CPU; False says nothing.

    Args:
        positions_t0: (n_vertices, 3) f8 [m], start of the path, on the GPU.
        positions_t1: (n_vertices, 3) f8 [m], its end, on the GPU.
        pairs: Impacts of the path, on the GPU.
    """
    n = pairs.toi.shape[0]
    meets = empty(n, np.bool_)
    own = pairs.nodes, pairs.is_edge_edge, pairs.toi, meets
    kernels.decide_meetings[n](positions_t0, positions_t1, *own)
    return to_cpu(meets)
