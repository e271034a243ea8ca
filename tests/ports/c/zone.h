/* One zone in metres: the inputs that the stages S6, S7, S8, S10 and S11 have in common. */

#ifndef ZONE_H
#define ZONE_H

#include "request.h"

struct zone {
    size_t n_vertices, n_impacts;
    const long *nodes;   /* (n_impacts, 4) */
    const real *weights; /* (n_impacts, 4) */
    const real *normals; /* (n_impacts, 3) */
    const real *proposed; /* (n_vertices, 3) [m], y */
    const real *masses;  /* (n_vertices) [kg]; 0 for pinned vertices, whatever was given */
    const long *pinned;  /* (n_vertices) */
    real thickness;      /* [m], d */
    double total_mass;   /* [kg], of the unpinned vertices */
};

struct zone read_zone(const struct json *input);

/* Returns N . sum_k a_k x_k of an impact, without the thickness. */
real gap_of_impact(const struct zone *zone, size_t impact, const real *positions);

/* Returns the second derivative of g by a coordinate of a vertex; 0 if the vertex is pinned. */
static inline real weight_in_objective(const struct zone *zone, size_t vertex) {
    return zone->pinned[vertex] ? 0 : (real)(2 * zone->masses[vertex] / zone->total_mass);
}

/* Computes the gradient of the augmented Lagrangian, given max(l + mu c, 0) of each impact. */
void gradient_of_lagrangian(const struct zone *zone, const real *positions, const real *forces,
                            real *gradient_out);

#endif
