"""What the lines of a plan say about obstacles."""

import numpy as np
import pytest

from izo_ref.loop.plan import _obstacles


@pytest.mark.parametrize(
    ("pinned", "moving", "needed", "said"),
    [
        ([0, 0, 0], [1, 1, 0], "none", "no vertex is pinned"),
        ([1, 1, 0], [0, 0, 1], "none", "2 vertices are pinned, and none of them moves"),
        ([1, 1, 0], [0, 1, 1], "some", "1 pinned vertices move"),
    ],
)
def test_only_obstacles_that_move_are_checked(pinned, moving, needed, said):
    line = _obstacles(np.array(pinned, bool), np.array(moving, bool))
    assert line.needed == needed
    assert line.reason.startswith(said)
