"""Zones, selections and box pairs by the most obvious means."""


def components(nodes, pinned):
    """Sets of impact indices that hang together over unpinned vertices."""
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
    """By time, no free vertex twice."""
    used, chosen = set(), []
    for j in sorted(range(len(toi)), key=lambda j: (toi[j], j)):
        free = {int(v) for v in nodes[j] if not pinned[v]}
        if not free & used:
            chosen.append(j)
            used |= free
    return sorted(chosen)


def first_of_any(toi, nodes, pinned):
    """The earliest for at least one of their free vertices."""
    chosen = set()
    for vertex in {int(v) for row in nodes for v in row if not pinned[v]}:
        own = [j for j in range(len(toi)) if vertex in nodes[j]]
        chosen.add(min(own, key=lambda j: (toi[j], j)))
    return sorted(chosen)


def box_pairs(boxes_a, nodes_a, boxes_b, nodes_b, same):
    """Pairs of elements without common vertex whose closed boxes meet."""
    result = set()
    for i in range(len(boxes_a)):
        for j in range(i + 1 if same else 0, len(boxes_b)):
            a, b = boxes_a[i], boxes_b[j]
            meet = all(a[x] <= b[x + 3] and b[x] <= a[x + 3] for x in range(3))
            if meet and not set(nodes_a[i].tolist()) & set(nodes_b[j].tolist()):
                result.add((i, j))
    return result
