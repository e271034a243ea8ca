"""Check on a GPU that a mesh has no intersections at rest, where floats can tell.

The launches of a detection list the vertex-face and edge-edge pairs that may touch, on a path from
the positions to themselves. Two more launches list the edges and faces whose boxes meet, and count
those that may meet. These are the filters of `intersections.py`. The CPU reads the counts once. It
has to look, in exact arithmetic, only if a pair is left.
"""

from __future__ import annotations

import numpy as np

from izo_ref.base.cuda.program import Program
from izo_ref.base.gpu_arrays import empty, to_cpu
from izo_ref.detection.gpu_detector import Detector
from izo_ref.detection.serial.found_counts import CONTACTS, N_COUNTS, OPEN, PAIRS


class StartCheck:
    """Checks starts of a mesh by the trees and lists of its detector, between two detections.

    Args:
        detector: The detector, whose coordinates of boxes have to hold the starts.

    Attributes:
        start: (n_vertices, 3) f8 [m], on the GPU, the start to check; its numbers may be changed.
    """

    def __init__(self, detector: Detector) -> None:
        """Make the array of the start; the launches are prepared when they are first needed."""
        self.start = empty(detector.start.shape, np.float64)
        self._detector, self._counts = detector, empty(2 * N_COUNTS, np.int64)
        self._program: Program | None = None
        self._n_arrays_prepared = 0

    def is_free(self) -> bool:
        """Return whether the start is certainly free of intersections; False says nothing.

        Lists that are too short are made longer, which the detector counts in `n_arrays_made`.
        """
        own = self._detector
        while True:
            if self._program is None or self._n_arrays_prepared != own.n_arrays_made:
                self._program = Program(own.launches_at_rest(self.start, self._counts))
                self._n_arrays_prepared = own.n_arrays_made
            self._program.run()
            counts = to_cpu(self._counts)
            if counts[CONTACTS] or counts[N_COUNTS + OPEN]:
                return False
            # both lists take the same room, one after the other
            counts[PAIRS] = max(counts[PAIRS], counts[N_COUNTS + PAIRS])
            if not own.grow(counts):
                return True
