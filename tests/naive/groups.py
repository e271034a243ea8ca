"""Zones, selections and box pairs, computed in the most obvious way."""


def components(nodes, pinned):
    """Return the sets of impacts that are connected through unpinned vertices."""
    left = {j for j in range(len(nodes)) if any(not pinned[v] for v in nodes[j])}
    result = []
    while left:
        group, vertices = set(), set()
        todo = [left.pop()]
        while todo:
            j = todo.pop()
            group.add(j)
            vertices |= {int(v) for v in nodes[j] if not pinned[v]}
            linked = {i for i in left if any(int(v) in vertices for v in nodes[i])}
            left -= linked
            todo += linked
        result.append(group)
    return result


def independent(toi, nodes, pinned):
    """Take impacts in the order of their times, unless an unpinned vertex is already taken."""
    used, chosen = set(), []
    for j in sorted(range(len(toi)), key=lambda j: (toi[j], j)):
        free = {int(v) for v in nodes[j] if not pinned[v]}
        if not free & used:
            chosen.append(j)
            used |= free
    return sorted(chosen)


def first_of_any(toi, nodes, pinned):
    """Take each impact that is the earliest of at least one of its unpinned vertices."""
    chosen = set()
    for vertex in {int(v) for row in nodes for v in row if not pinned[v]}:
        own = [j for j in range(len(toi)) if vertex in nodes[j]]
        chosen.add(min(own, key=lambda j: (toi[j], j)))
    return sorted(chosen)


def moving_box_pairs(nodes_a, nodes_b, start, end, same):
    """Return the pairs of elements without a common vertex whose moving boxes meet.

    Two boxes are apart if, along one axis, all vertices of one are below all vertices of the
    other, both at the start and at the end.
    """
    boxes_a, boxes_b = ([_boxes(own, start, end) for own in n] for n in (nodes_a, nodes_b))
    vertices_a, vertices_b = ([set(own.tolist()) for own in n] for n in (nodes_a, nodes_b))
    return {
        (i, j)
        for i in range(len(nodes_a))
        for j in range(i + 1 if same else 0, len(nodes_b))
        if not vertices_a[i] & vertices_b[j] and not _apart(boxes_a[i], boxes_b[j])
    }


def _boxes(own, start, end):
    """Along each axis: least and largest coordinate at the start, least and largest at the end."""
    return [
        (min(x0), max(x0), min(x1), max(x1))
        for x0, x1 in zip(start[own].T.tolist(), end[own].T.tolist(), strict=True)
    ]


def _apart(a, b):
    return any(
        (high_a0 < low_b0 and high_a1 < low_b1) or (high_b0 < low_a0 and high_b1 < low_a1)
        for (low_a0, high_a0, low_a1, high_a1), (low_b0, high_b0, low_b1, high_b1) in zip(
            a, b, strict=True
        )
    )
