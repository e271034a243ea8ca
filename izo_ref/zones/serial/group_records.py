"""Arrays and choices of the launches of a step, by thread groups."""

from typing import NamedTuple

from izo_ref.base.arrays import (
    Codes,
    Flags,
    Floats,
    Indices,
    Ints,
    Masses,
    Multipliers,
    Nodes,
    Normals,
    Positions,
    Times,
    Weights,
)

SELECTIONS = ("independent", "first-of-any", "all")  # values of `Options.selection`
INDEPENDENT, FIRST_OF_ANY, ALL = range(3)  # their places


class StepArrays(NamedTuple):
    """The arrays of a step: the columns of `ZoneImpacts`, those of its vertices, the thickness."""

    nodes: Nodes  # (room, 4) i4
    is_edge_edge: Flags  # (room,) b1
    toi: Times  # (room,) f8
    weights: Weights  # (room, 4) f8
    normals: Normals  # (room, 3) f8
    multipliers: Multipliers  # (room,) f8 [kg]
    active: Flags  # (room,) b1
    start: Positions  # (n_vertices, 3) f8 [m], start of the path
    proposed: Positions  # (n_vertices, 3) f8 [m], proposed end of the path
    positions: Positions  # (n_vertices, 3) f8 [m], end of the path
    pinned: Flags  # (n_vertices,) b1
    stuck: Flags  # (n_vertices,) b1, vertices of zones that no positions satisfy
    known_depths: Ints  # (n_vertices,) i4, of `deep_selection.py`
    masses: Masses  # (n_vertices,) f8 [kg], 0 for pinned vertices
    inverse_sqrt_masses: Floats  # (n_vertices,) f8 [kg^-1/2], 0 for pinned vertices
    thickness: float  # [m], distance that impacts keep at the end


class ZoneRule(NamedTuple):
    """Which zones are solved, and what a small and a middle zone is."""

    every_zone: bool  # whether zones without a new impact are solved, too
    small: int  # most impacts of a small zone
    middle: int  # most impacts of a middle zone


class ZoneImpacts(NamedTuple):
    """The impacts in zones: the columns of `Impacts`, and two more; with room for more impacts."""

    nodes: Nodes  # (room, 4) i4
    is_edge_edge: Flags  # (room,) b1
    toi: Times  # (room,) f8
    weights: Weights  # (room, 4) f8
    normals: Normals  # (room, 3) f8
    multipliers: Multipliers  # (room,) f8 [kg]
    active: Flags  # (room,) b1


class VertexLabels(NamedTuple):
    """The unpinned vertices of some impacts, and their labels.

    `marks` has only zeros before and after each launch. The entries of vertices that are not listed
    are invalid in all other arrays.
    """

    marks: Indices  # (n_vertices,) i8, how many times a vertex came while vertices were listed
    listed: Indices  # (room,) i8, each unpinned vertex of the impacts once
    labels: Indices  # (n_vertices,) i8, the least vertex of the zone of each vertex
    parents: Indices  # (n_vertices,) i8, of each label, a lower label of the same zone


class GroupWork(NamedTuple):
    """Work space of the grouping."""

    stuck_marks: Indices  # (n_vertices,) i8, how many stuck vertices came, at the label of a zone
    keys: Indices  # (room for impacts and vertices,) i8, sorted to bring zones together
    starts: Indices  # (2 * room for zones,) i8, places in `keys` where zones begin
    chosen: Indices  # (room for zones,) i8, keys of the zones to solve
    places: Indices  # (room for impacts and vertices,) i8, of `group_sort`
    other_keys: Indices  # (room for impacts and vertices,) i8, of `group_sort`
    other_places: Indices  # (room for impacts and vertices,) i8, of `group_sort`


class SelectionWork(NamedTuple):
    """Work space of the selection; entries of vertices are valid where a vertex is listed."""

    time_bits: Indices  # (room,) i8, the times of the impacts found, their bits read as integers
    states: Codes  # (room,) i1, OPEN, TAKEN or DROPPED
    deep: Flags  # (room,) b1, whether the zone of each impact is deep
    depths: Floats  # (room,) f8, in longest edges
    claims: Nodes  # (room, 4) i4, the vertices that each impact claims
    keys: Indices  # (room,) i8, by which impacts come one after the other
    taken: Indices  # (room,) i8, impacts that are taken
    places: Indices  # (room,) i8, of `group_sort`
    other_keys: Indices  # (room,) i8, of `group_sort`
    other_places: Indices  # (room,) i8, of `group_sort`
    known: Indices  # (n_vertices,) i8, 0 less the most that is known, at the label of a zone
    units: Indices  # (n_vertices,) i8, sum of the depths of a zone [UNIT], at its label
    sizes: Indices  # (n_vertices,) i8, number of impacts of a zone, at its label
    odd: Indices  # (n_vertices,) i8, how many of them are in no sum, at the label
    zone_depths: Indices  # (n_vertices,) i8, SHALLOW or DEEP, at the label of a zone
    first_times: Floats  # (n_vertices,) f8, first time at which a vertex is a main vertex
    first_bits: Indices  # (n_vertices,) i8, the same memory, read as integers
    owner_keys: Indices  # (n_vertices,) i8, least key of the impacts that claim a vertex
    owners: Indices  # (n_vertices,) i8, claim of the first impact with this key
    seen: Flags  # (n_vertices,) b1, whether the vertex is one of an impact that is taken
