"""Records of arrays that the launches of a detection on a GPU share."""

from typing import NamedTuple

from izo_ref.base.arrays import Floats, Indices, Nodes, Normals, Positions, Times, Weights


class PathArrays(NamedTuple):
    """The path whose impacts are wanted, and the end of the path before."""

    start: Positions  # (n_vertices, 3) f8 [m]
    end: Positions  # (n_vertices, 3) f8 [m]
    seen: Positions  # (n_vertices, 3) f8 [m], ends that MOVED is counted from, or NaN
    frame: Floats  # (4,) f8, origin [m] and scale [1/m] of the coordinates of boxes


class ContactList(NamedTuple):
    """Contacts in the order in which threads found them, and the frames of their impacts."""

    keys: Indices  # (n,) i8, kind and elements, as `pair_key` returns them
    nodes: Nodes  # (n, 4) i4
    toi: Times  # (n,) f8
    directions: Normals  # (n, 3) f8, the last ones that separated the sides
    weights: Weights  # (n, 4) f8
    normals: Normals  # (n, 3) f8


class SortSpace(NamedTuple):
    """Work space of a sort of contacts; `base/serial/group_sort.py` says what each array holds."""

    keys: Indices  # (n,) i8
    places: Indices  # (n,) i8
    other_keys: Indices  # (n,) i8
    other_places: Indices  # (n,) i8
