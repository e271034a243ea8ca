"""The filter of the path certificate on the device."""

import numpy as np

from izo_ref.base.gpu_arrays import empty, to_cpu, to_gpu
from izo_ref.base.gpu_impacts import impacts_to_cpu
from izo_ref.certificate.cuda import meetings as kernels
from izo_ref.detection.gpu_detector import Detector


def filter_path(scene, positions, rules):
    """Pairs of a path that are not proved apart, from new trees of boxes and over all pairs.

    Args:
        scene: `Scene`, gives the start.
        positions: (n_vertices, 3) f8 [m], end of the path.
        rules: not used; the device looks at every pair.

    Returns:
        `Impacts`; (n,) b1, those that certainly meet; `PairCounts`. All on the processor.
    """
    detector, end = Detector(scene, counts_proofs=True), to_gpu(positions)
    found = detector.find(end)
    n = found.toi.shape[0]
    meets = empty(n, np.bool_)
    kernels.decide_meetings[n](
        to_gpu(scene.positions_t0), end, found.nodes, found.is_edge_edge, found.toi, meets
    )
    return impacts_to_cpu(found), to_cpu(meets), detector.counts
