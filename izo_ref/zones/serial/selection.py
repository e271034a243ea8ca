"""Which of the impacts found enter the zones: one pass in the order of their times."""

from izo_ref.base.compile import compiled


@compiled
def select_in_order(
    order,  # (n_impacts,) i8, by time of impact
    nodes,  # (n_impacts, 4) i4
    pinned,  # (n_vertices,) b1
    all_new,  # b1: every free vertex has to be new (`independent`), or one (`first-of-any`)
    seen,  # (n_vertices,) b1, work space, all false
    selected_out,  # (n_impacts,) b1
):
    """Take an impact if its free vertices were not seen before, then mark them as seen.

    With `all_new`, vertices of an impact that was not taken stay unseen: an impact then
    waits only for those that are really there.
    """
    for i in range(len(order)):
        j = order[i]
        n_free = 0
        n_new = 0
        for k in range(4):
            if not pinned[nodes[j, k]]:
                n_free += 1
                if not seen[nodes[j, k]]:
                    n_new += 1
        if all_new:
            selected_out[j] = n_new == n_free
        else:
            selected_out[j] = n_new > 0
        if selected_out[j] or not all_new:
            for k in range(4):
                seen[nodes[j, k]] = True


# An impact whose free vertices have less weight than this in all is between pinned points:
# a free vertex would have to move a billion times as far as the gap is to open.
NO_WEIGHT = 1e-9


@compiled
def is_prescribed(j, nodes, weights, pinned):
    """Whether impact j, of nodes and weights (n_impacts, 4), is between pinned points."""
    weight = 0.0
    for k in range(4):
        if not pinned[nodes[j, k]]:
            weight += abs(weights[j, k])
    return weight < NO_WEIGHT


@compiled
def prescribed_impacts(nodes, weights, pinned, prescribed_out):
    """Which impacts are between pinned points: (n_impacts,) b1."""
    for j in range(nodes.shape[0]):
        prescribed_out[j] = is_prescribed(j, nodes, weights, pinned)
