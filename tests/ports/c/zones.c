/* S5: which impacts belong together. */

#include "request.h"
#include "stages.h"

/* Union-find: each vertex points to another one of its zone, and a root to itself. */
static long root(long *parent, long i) {
    while (parent[i] != i) {
        parent[i] = parent[parent[i]]; /* halve the path, so that chains stay short */
        i = parent[i];
    }
    return i;
}

/* Joining unpinned vertices of each impact joins impacts through chains of any length, in any
   order. Merging zones impact by impact in one pass does not: an impact may join two zones that
   exist already. Pinned vertices join nothing, or everything on one floor would be one zone. */
static void join_vertices(const long *nodes, size_t n_impacts, const long *pinned, long *parent) {
    for (size_t j = 0; j < n_impacts; ++j) {
        long first = -1;
        for (size_t k = 0; k < 4; ++k) {
            long node = nodes[4 * j + k];
            if (pinned[node]) continue;
            if (first < 0) first = node;
            parent[root(parent, node)] = root(parent, first);
        }
    }
}

void group_into_zones(const struct json *input) {
    size_t n = count_of(input, "pinned"), n_impacts = count_of(input, "nodes") / 4;
    const long *pinned = read_integers(input, "pinned", n, 0, 1);
    const long *nodes = read_integers(input, "nodes", 4 * n_impacts, 0, (long)n - 1);
    long *parent = allocate(n, sizeof *parent);
    long *zones = allocate(n_impacts, sizeof *zones);
    for (size_t i = 0; i < n; ++i) parent[i] = (long)i;
    join_vertices(nodes, n_impacts, pinned, parent);
    for (size_t j = 0; j < n_impacts; ++j) {
        zones[j] = -1; /* all its vertices are pinned */
        for (size_t k = 0; k < 4 && zones[j] < 0; ++k)
            if (!pinned[nodes[4 * j + k]]) zones[j] = root(parent, nodes[4 * j + k]);
    }
    write_integers("zone_of_impact", zones, n_impacts);
}
