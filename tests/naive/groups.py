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


def first_of_main_vertices(toi, nodes, weights, is_edge_edge, pinned, soon):
    """Take impacts as in a deep zone.

    An impact counts for the unpinned vertex of the largest weight on each side. It waits if one of
    these meets something earlier, by more than a factor. Of the others, an impact is taken if it is
    the first for one of its vertices: vertex-face impacts first, then by time.
    """
    mains = []
    for j in range(len(toi)):
        own = [(float(w), int(v)) for w, v in zip(weights[j], nodes[j], strict=True)]
        own = [(w, v) for w, v in own if not pinned[v]]
        sides = [p for p in own if p[0] > 0], [p for p in own if p[0] < 0]
        mains.append({max(side, key=lambda p: abs(p[0]))[1] for side in sides if side})
    first = {}
    for j, vertices in enumerate(mains):
        for v in vertices:
            first[v] = min(first.get(v, 1.0), toi[j])
    ready = [j for j in range(len(toi)) if toi[j] <= soon * min(first[v] for v in mains[j])]
    chosen, held = [], set()
    for j in sorted(ready, key=lambda j: (is_edge_edge[j], toi[j], j)):
        if mains[j] - held:
            chosen.append(j)
        held |= mains[j]
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
