"""Label the vertices of impacts by the least vertex of their zone, by a thread group.

Each vertex starts with its own number as its label. The least label at an impact becomes the parent
of the other labels at this impact. Then each vertex takes the last label on the way from parent to
parent. This is repeated until nothing changes. A label that stays has got the label of another
vertex in one of two rounds, so the number of labels of a zone halves at least every second round.

At the end the label of a vertex is the least vertex of its zone, in whatever order the threads ran.
"""

from izo_ref.base.arrays import Flags, Indices, Nodes
from izo_ref.base.compile import compiled
from izo_ref.base.serial.thread_group import ThreadGroup, group_add, group_least, group_maxima
from izo_ref.zones.serial.group_records import VertexLabels


@compiled
def list_vertex(
    group: ThreadGroup, vertex: int, counts: Indices, counter: int, own: VertexLabels
) -> bool:
    """List a vertex if it is not listed yet, and return whether this thread has listed it.

    Args:
        group: The threads.
        vertex: The vertex.
        counts: (n,) i8.
        counter: Place in `counts` of the number of vertices that are listed.
        own: The list; the vertex becomes its own label and its own parent.
    """
    if group_add(group, own.marks, vertex, 1) > 0:
        return False
    own.listed[group_add(group, counts, counter, 1)] = vertex
    own.labels[vertex] = vertex
    own.parents[vertex] = vertex
    return True


@compiled
def forget_marks(group: ThreadGroup, n_listed: int, own: VertexLabels) -> None:
    """Set the marks of all listed vertices back to zero."""
    for i in range(group.rank(), n_listed, group.size()):
        own.marks[own.listed[i]] = 0


@compiled
def label_of(j: int, nodes: Nodes, pinned: Flags, labels: Indices) -> int:
    """Return the least label of the unpinned vertices of impact j; -1 if all are pinned."""
    least = labels.shape[0]
    for k in range(4):
        if not pinned[nodes[j, k]]:
            least = min(least, int(labels[nodes[j, k]]))
    return least if least < labels.shape[0] else -1


@compiled
def label_vertices(
    group: ThreadGroup, n: int, nodes: Nodes, pinned: Flags, n_listed: int, own: VertexLabels
) -> None:
    """Label the listed vertices.

    All threads must have waited since the vertices were listed; they may read the labels at once.

    Args:
        group: The threads.
        n: Number of impacts.
        nodes: (>= n, 4) i4.
        pinned: (n_vertices,) b1.
        n_listed: Number of listed vertices, which are all unpinned vertices of the impacts.
        own: The list, with labels and parents as `list_vertex` leaves them.
    """
    while _join_labels(group, n, nodes, pinned, own):
        for i in range(group.rank(), n_listed, group.size()):
            label = own.labels[own.listed[i]]
            while own.parents[label] < label:
                label = own.parents[label]
            own.labels[own.listed[i]] = label
        group.wait()


@compiled
def _join_labels(
    group: ThreadGroup, n: int, nodes: Nodes, pinned: Flags, own: VertexLabels
) -> bool:
    """Let the least label at each impact be a parent of the others; return whether there were any.

    The group waits for all threads.
    """
    changed = 0.0
    for j in range(group.rank(), n, group.size()):
        least = label_of(j, nodes, pinned, own.labels)
        for k in range(4):
            if not pinned[nodes[j, k]] and own.labels[nodes[j, k]] > least:
                group_least(group, own.parents, int(own.labels[nodes[j, k]]), least)
                changed = 1.0
    return group_maxima(group, changed, 0.0)[0] > 0.0
