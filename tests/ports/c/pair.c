/* S2 and S3: when a vertex and a face, or two edges, first meet; their normal and weights.

   Every pair is three vectors: u and v along the face or the two edges, and w from one side to the
   other. The four nodes are in one plane where the volume w . (u x v) is zero, and u x v is the
   normal. Vectors between nodes are computed first, from the positions as they were given: far
   from the origin their differences are exact, and no digits are lost later. */

#include <string.h>

#include "request.h"
#include "roots.h"
#include "stages.h"

struct pair {
    bool is_edge_edge;
    vec start[4], end[4]; /* relative to node 0 */
    vec w[2], u[2], v[2]; /* at t = 0 and t = 1 */
};

/* Where a pair is not met in the inside of both its sides, a vertex of one meets an edge of the
   other: the vertex and the ends of the edge, for a vertex and a face, and for two edges. */
static const int vertex_edge[2][4][3] = {
    {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {-1, -1, -1}},
    {{0, 2, 3}, {1, 2, 3}, {2, 0, 1}, {3, 0, 1}},
};
static const int n_vertex_edge[2] = {3, 4};

/* ------------------------------------------------------------------------- closest points */

struct contact {
    real weights[4];
    real distance;
};

/* The pair at one time. */
struct nodes {
    bool is_edge_edge;
    vec x[4]; /* relative to node 0 */
    vec w, u, v, normal;
    real normal_length;
    bool is_flat; /* whether the normal is nothing but rounding */
};

static struct nodes nodes_at(const struct pair *pair, real t) {
    struct nodes nodes = {.is_edge_edge = pair->is_edge_edge};
    for (int k = 0; k < 4; ++k) nodes.x[k] = between(pair->start[k], pair->end[k], t);
    nodes.w = between(pair->w[0], pair->w[1], t);
    nodes.u = between(pair->u[0], pair->u[1], t);
    nodes.v = between(pair->v[0], pair->v[1], t);
    nodes.normal = cross(nodes.u, nodes.v);
    nodes.normal_length = length(nodes.normal);
    /* u and v are differences that rounded once at each end, relative to their size there */
    real u_size = larger(length(pair->u[0]), length(pair->u[1]));
    real v_size = larger(length(pair->v[0]), length(pair->v[1]));
    real rounding = 4 * EPSILON * (u_size * length(nodes.v) + v_size * length(nodes.u));
    nodes.is_flat = !(nodes.normal_length > rounding);
    return nodes;
}

/* The closest points of the plane of the face and the vertex, or of the lines of the two edges.
   Returns whether they are inside the face, or inside both edges. */
static bool find_inside(const struct nodes *nodes, struct contact *contact) {
    if (nodes->is_flat) return false;
    vec n = scale(1 / nodes->normal_length, nodes->normal);
    real first = dot(cross(nodes->w, nodes->v), n) / nodes->normal_length;
    real second = dot(cross(nodes->w, nodes->u), n) / nodes->normal_length;
    const real face[4] = {1, -(1 + first - second), first, -second};
    const real edges[4] = {1 - first, first, second - 1, -second};
    memcpy(contact->weights, nodes->is_edge_edge ? edges : face, sizeof face);
    contact->distance = magnitude(dot(nodes->w, n));
    for (int k = 0; k < 4; ++k) {
        bool is_first_side = k == 0 || (k == 1 && nodes->is_edge_edge);
        if (is_first_side ? contact->weights[k] < 0 : contact->weights[k] > 0) return false;
    }
    return true;
}

/* The closest points of a vertex and an edge, one from each side of the pair. */
static struct contact closest_on_edge(const struct nodes *nodes, const int *which) {
    vec edge = subtract(nodes->x[which[2]], nodes->x[which[1]]);
    vec arm = subtract(nodes->x[which[0]], nodes->x[which[1]]);
    real edge_sq = dot(edge, edge), at = edge_sq > 0 ? dot(arm, edge) / edge_sq : 0;
    at = smaller(larger(at, 0), 1);
    /* from the nearer end, so that an edge much longer than the distance does not blur it */
    vec rest = at < (real)0.5
                   ? subtract(arm, scale(at, edge))
                   : add(subtract(nodes->x[which[0]], nodes->x[which[2]]), scale(1 - at, edge));
    bool is_first_side = which[0] == 0 || (which[0] == 1 && nodes->is_edge_edge);
    real sign = is_first_side ? 1 : -1;
    struct contact contact = {.distance = length(rest)};
    contact.weights[which[0]] = sign;
    contact.weights[which[1]] = -sign * (1 - at);
    contact.weights[which[2]] = -sign * at;
    return contact;
}

/* The closest points of the pair; this is defined however degenerate the face or the edges are. */
static struct contact closest_points(const struct nodes *nodes) {
    struct contact best;
    if (find_inside(nodes, &best)) return best;
    for (int i = 0; i < n_vertex_edge[nodes->is_edge_edge]; ++i) {
        struct contact contact = closest_on_edge(nodes, vertex_edge[nodes->is_edge_edge][i]);
        if (i == 0 || contact.distance < best.distance) best = contact;
    }
    return best;
}

/* ------------------------------------------------------------------------- time of impact */

/* Times at which the pair may meet. A pair has at most three roots of its cubic, and six of each
   of four vertices and edges; the rest is room for extrema, which count too. */
struct candidates {
    struct root roots[256];
    int count;
};

static void add_roots(const real *coefficients, int degree, real error, struct candidates *all) {
    all->count += find_roots(coefficients, degree, error, all->roots + all->count);
}

static real volume(vec w, vec u, vec v) { return dot(w, cross(u, v)); }

/* The largest size of the volume of vectors with components of these sizes. */
static real volume_size(vec w, vec u, vec v) {
    return w.x * (u.y * v.z + u.z * v.y) + w.y * (u.z * v.x + u.x * v.z) +
           w.z * (u.x * v.y + u.y * v.x);
}

static vec larger_sizes(const vec *ends) {
    vec a = sizes(ends[0]), b = sizes(ends[1]);
    return (vec){larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)};
}

/* The sides meet inside both of them: the nodes are in one plane. A linear motion makes this
   volume a cubic, and a cubic has up to three roots, of which any may be the one that meets. */
static void add_coplanar_times(const struct pair *pair, struct candidates *all) {
    const vec *w = pair->w, *u = pair->u, *v = pair->v;
    real cubic[4] = {
        volume(w[0], u[0], v[0]),
        (volume(w[1], u[0], v[0]) + volume(w[0], u[1], v[0]) + volume(w[0], u[0], v[1])) / 3,
        (volume(w[0], u[1], v[1]) + volume(w[1], u[0], v[1]) + volume(w[1], u[1], v[0])) / 3,
        volume(w[1], u[1], v[1]),
    };
    /* some 16 roundings of half a unit each: of w, u and v, in the volume, in the scheme */
    real error = 8 * EPSILON * volume_size(larger_sizes(w), larger_sizes(u), larger_sizes(v));
    add_roots(cubic, 3, error, all);
}

/* If all four nodes stay in one plane, the cubic is zero at all times. Then the pair meets first
   where a vertex comes onto the line of an edge: arm x edge = 0, three quadratics. If these are
   zero at all times too, it meets where a vertex comes to a vertex: arm = 0, three linear
   functions. Times of one coordinate alone mean nothing, but the distance at them sorts them out;
   so the pair needs no test of whether it moves in a plane, which rounding could decide wrongly. */
static void add_edge_times(const struct pair *pair, const int *which, struct candidates *all) {
    vec arm[2], edge[2], far_arm[2];
    for (int end = 0; end < 2; ++end) {
        const vec *x = end == 0 ? pair->start : pair->end;
        arm[end] = subtract(x[which[0]], x[which[1]]);
        far_arm[end] = subtract(x[which[0]], x[which[2]]);
        edge[end] = subtract(x[which[2]], x[which[1]]);
    }
    vec b0 = cross(arm[0], edge[0]), b2 = cross(arm[1], edge[1]);
    vec b1 = scale((real)0.5, add(cross(arm[0], edge[1]), cross(arm[1], edge[0])));
    vec arm_size = larger_sizes(arm), edge_size = larger_sizes(edge);
    const real quadratics[3][3] = {{b0.x, b1.x, b2.x}, {b0.y, b1.y, b2.y}, {b0.z, b1.z, b2.z}};
    const real quadratic_errors[3] = {
        4 * EPSILON * (arm_size.y * edge_size.z + arm_size.z * edge_size.y),
        4 * EPSILON * (arm_size.z * edge_size.x + arm_size.x * edge_size.z),
        4 * EPSILON * (arm_size.x * edge_size.y + arm_size.y * edge_size.x),
    };
    const vec *const arms[2] = {arm, far_arm};
    for (int axis = 0; axis < 3; ++axis)
        add_roots(quadratics[axis], 2, quadratic_errors[axis], all);
    for (int end = 0; end < 2; ++end) {
        const vec *a = arms[end];
        const real linear[3][2] = {{a[0].x, a[1].x}, {a[0].y, a[1].y}, {a[0].z, a[1].z}};
        vec size = larger_sizes(a);
        const real errors[3] = {2 * EPSILON * size.x, 2 * EPSILON * size.y, 2 * EPSILON * size.z};
        for (int axis = 0; axis < 3; ++axis) add_roots(linear[axis], 1, errors[axis], all);
    }
}

/* Whether the pair is no farther apart than rounding, and what it moves within the doubt about the
   time, can explain. */
static bool meets_at(const struct pair *pair, struct root root) {
    struct nodes nodes = nodes_at(pair, root.time);
    real size = 0, speed = 0;
    for (int k = 1; k < 4; ++k) {
        size = larger(size, larger(largest(pair->start[k]), largest(pair->end[k])));
        speed = larger(speed, largest(subtract(pair->end[k], pair->start[k])));
    }
    return closest_points(&nodes).distance <= 4 * EPSILON * size + root.doubt * speed;
}

/* Finds the first time at which the pair meets, if there is one. */
static bool find_first_time(const struct pair *pair, real *time_out) {
    struct candidates all = {.count = 2};
    bool meets = false;
    all.roots[0] = (struct root){0, 0}; /* it may touch at the start, and at the very end */
    all.roots[1] = (struct root){1, 0};
    add_coplanar_times(pair, &all);
    for (int i = 0; i < n_vertex_edge[pair->is_edge_edge]; ++i)
        add_edge_times(pair, vertex_edge[pair->is_edge_edge][i], &all);
    for (int i = 0; i < all.count; ++i) {
        struct root root = all.roots[i];
        if (meets && root.time >= *time_out) continue;
        if (!meets_at(pair, root)) continue;
        meets = true;
        *time_out = root.time;
    }
    return meets;
}

/* ---------------------------------------------------------------------------------- stages */

static struct pair read_pair(const struct json *input) {
    struct pair pair = {.is_edge_edge = read_integer(input, "is_edge_edge", 0, 1)};
    for (int end = 0; end < 2; ++end) {
        const real *x = read_reals(input, end == 0 ? "start" : "end", 12);
        vec *relative = end == 0 ? pair.start : pair.end;
        for (size_t k = 0; k < 4; ++k) relative[k] = subtract(vec_at(x, k), vec_at(x, 0));
        pair.w[end] = subtract(vec_at(x, pair.is_edge_edge ? 2 : 1), vec_at(x, 0));
        pair.u[end] = subtract(vec_at(x, pair.is_edge_edge ? 1 : 2),
                               vec_at(x, pair.is_edge_edge ? 0 : 1));
        pair.v[end] = subtract(vec_at(x, 3), vec_at(x, pair.is_edge_edge ? 2 : 1));
    }
    return pair;
}

void time_of_impact(const struct json *input) {
    struct pair pair = read_pair(input);
    real time;
    bool meets = find_first_time(&pair, &time);
    write_integer("meets", meets);
    if (meets) write_real("toi", time);
}

static vec weighted_sum(const real *weights, const vec *x) {
    vec sum = {0, 0, 0};
    for (int k = 1; k < 4; ++k) sum = add(sum, scale(weights[k], x[k]));
    return sum;
}

static vec unit(vec a) { return scale(1 / length(a), a); }

/* The normal of the plane points so that the gap was positive at t = 0. Where the gap was zero all
   along, because the pair moves in one plane, or where there is no plane, the normal is where one
   of the closest points was, seen from the other; without a gap at the start, it is where it came
   from. */
static vec separating_normal(const struct pair *pair, const struct nodes *nodes,
                             const real *weights) {
    vec gap = weighted_sum(weights, pair->start);
    if (!nodes->is_flat) {
        vec normal = scale(1 / nodes->normal_length, nodes->normal);
        real size = 0, along = dot(normal, gap);
        for (int k = 1; k < 4; ++k) size = larger(size, length(pair->start[k]));
        /* the normal of a thin face, or of nearly parallel edges, has a larger rounding */
        real thinness = length(nodes->u) * length(nodes->v) / nodes->normal_length;
        if (magnitude(along) > 8 * EPSILON * size * thinness)
            return along > 0 ? normal : scale(-1, normal);
    }
    if (largest(gap) > 0) return unit(gap);
    vec past = subtract(gap, weighted_sum(weights, pair->end));
    if (largest(past) > 0) return unit(past);
    return nodes->is_flat ? (vec){0, 0, 1} : unit(nodes->normal);
}

void normal_and_weights(const struct json *input) {
    struct pair pair = read_pair(input);
    real toi = read_real(input, "toi");
    if (!(toi >= 0 && toi <= 1)) refuse("the time is not from 0 to 1");
    struct nodes nodes = nodes_at(&pair, toi);
    struct contact contact = closest_points(&nodes);
    vec normal = separating_normal(&pair, &nodes, contact.weights);
    const real components[3] = {normal.x, normal.y, normal.z};
    write_reals("weights", contact.weights, 4);
    write_reals("normal", components, 3);
}
