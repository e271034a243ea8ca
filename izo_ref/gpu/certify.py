"""The filter of the path certificate on the device."""

import numpy as np

from izo_ref.cuda import advance as kernels
from izo_ref.gpu.arrays import empty, on_device, on_host
from izo_ref.gpu.detect import Detector
from izo_ref.gpu.impacts import impacts_on_host


def filtered_pairs(scene, positions):
    """Pairs of a path that are not proved apart, from new trees of boxes and over all pairs.

    Args:
        scene: `Scene`, gives the start.
        positions: (n_vertices, 3) f8 [m], end of the path.

    Returns:
        `Impacts`; (n,) b1, those that certainly meet; `Tally`. All on the processor.
    """
    detector, end = Detector(scene, counts_proofs=True), on_device(positions)
    found = detector.find(end)
    n = found.toi.shape[0]
    meets = empty(n, np.bool_)
    kernels.certain_meetings[n](
        on_device(scene.positions_t0), end, found.nodes, found.is_edge_edge, found.toi, meets
    )
    return impacts_on_host(found), on_host(meets), detector.tally
