"""Records of what solving zones on a GPU writes, with room to spare.

`zones/serial/listed_zones.py` has the zones, and `zones/serial/group_records.py` the arrays of the
step. The arrays here are at least as long as stated.
"""

from typing import NamedTuple

from izo_ref.base.arrays import Flags, Floats, Ints, Multipliers, Nodes, Normals, Positions

# Places of the numbers in `sizes`, which say how much is to be done: all 0 if something does not
# fit. OF_STEP are the impacts of the step, of which some may be in no zone. TICKET is the next zone
# of the list of middle zones that no block has taken yet.
ZONES, IMPACTS, VERTICES, SMALL, MIDDLE, LARGE, OF_STEP, TICKET = range(8)
N_SIZES = 8

# Places of the numbers in the counts that the CPU reads: zones that were solved, and zones that are
# left to the CPU; active impacts; sum m |x - y|^2 [kg m^2], which is a f8; and how much room all
# zones, their impacts and their vertices need.
SOLVED, LEFT, ACTIVE, SQUARES, ZONES_NEEDED, IMPACTS_NEEDED, VERTICES_NEEDED = range(7)
N_COUNTS = 7


class ZoneRows(NamedTuple):
    """The constraints C z >= s of all zones side by side, in scaled variables (docs/method 5)."""

    unknowns: Nodes  # (n_impacts, 4) i4, places in the vertices of the zones; -1 for pinned ones
    coefficients: Floats  # (n_impacts, 4) f8; together with the normals, rows of unit length
    normals: Normals  # (n_impacts, 3) f8
    rhs: Floats  # (n_impacts,) f8 [m kg^1/2], s
    lengths: Floats  # (n_impacts,) f8 [kg^-1/2], lengths of the rows before scaling
    hopeless: Flags  # (n_impacts,) b1, violated, and no unpinned vertex can change it
    positions: Positions  # (n_unpinned, 3) f8 [m], proposed, of the unpinned vertices


class ZoneAnswers(NamedTuple):
    """Solutions of all zones in scaled variables; the entries of unsolved zones are invalid."""

    multipliers: Multipliers  # (n_impacts,) f8 [m kg^1/2]; before, those of the last solution
    z: Floats  # (3 n_unpinned,) f8 [m kg^1/2]
    solved: Flags  # (n_zones,) b1
    steps: Ints  # (n_zones,) i4, steps of the method; -1 if there was no room for a factor
