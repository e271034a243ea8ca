/* S6, S7 and S9: objective, constraints, augmented Lagrangian and its multipliers. */

#include "zone.h"

#include "stages.h"

/* The mass of a pinned vertex is not used: it may be anything, even 0, infinity or NaN. */
static real *read_masses(const struct json *input, size_t n, const long *pinned) {
    real *masses = read_any_reals(input, "masses", n);
    for (size_t i = 0; i < n; ++i) {
        if (pinned[i]) masses[i] = 0;
        if (!pinned[i] && !(masses[i] > 0 && isfinite(masses[i]))) refuse("a mass is not positive");
    }
    return masses;
}

struct zone read_zone(const struct json *input) {
    size_t n = count_of(input, "pinned"), m = count_of(input, "nodes") / 4;
    struct zone zone = {.n_vertices = n, .n_impacts = m};
    zone.nodes = read_integers(input, "nodes", 4 * m, 0, (long)n - 1);
    zone.weights = read_reals(input, "weights", 4 * m);
    zone.normals = read_reals(input, "normals", 3 * m);
    zone.proposed = read_reals(input, "proposed", 3 * n);
    zone.pinned = read_integers(input, "pinned", n, 0, 1);
    zone.masses = read_masses(input, n, zone.pinned);
    zone.thickness = read_real(input, "thickness");
    for (size_t i = 0; i < n; ++i) zone.total_mass += zone.masses[i];
    return zone;
}

/* The weights sum to zero, so the gap is the same for positions relative to the first node. Far
   from the origin it is then computed from small numbers, whose differences are exact. */
real gap_of_impact(const struct zone *zone, size_t impact, const real *positions) {
    const long *nodes = zone->nodes + 4 * impact;
    vec origin = vec_at(positions, (size_t)nodes[0]), between_points = {0, 0, 0};
    for (size_t k = 0; k < 4; ++k) {
        vec arm = subtract(vec_at(positions, (size_t)nodes[k]), origin);
        between_points = add(between_points, scale(zone->weights[4 * impact + k], arm));
    }
    return dot(vec_at(zone->normals, impact), between_points);
}

static real *constraints_at(const struct zone *zone, const real *positions) {
    real *constraints = allocate_reals(zone->n_impacts);
    for (size_t j = 0; j < zone->n_impacts; ++j)
        constraints[j] = zone->thickness - gap_of_impact(zone, j, positions);
    return constraints;
}

static double objective_at(const struct zone *zone, const real *positions) {
    double sum = 0;
    for (size_t i = 0; i < zone->n_vertices; ++i) {
        vec move = subtract(vec_at(positions, i), vec_at(zone->proposed, i));
        if (!zone->pinned[i]) sum += (double)zone->masses[i] * dot(move, move);
    }
    return zone->total_mass > 0 ? sum / zone->total_mass : 0;
}

/* On a GPU the impacts of a vertex are gathered, or added atomically: a vertex is in many of them,
   and a sum that two threads write without care loses terms. */
void gradient_of_lagrangian(const struct zone *zone, const real *positions, const real *forces,
                            real *gradient_out) {
    for (size_t i = 0; i < zone->n_vertices; ++i) {
        real weight = weight_in_objective(zone, i);
        for (size_t c = 3 * i; c < 3 * i + 3; ++c)
            gradient_out[c] = weight * (positions[c] - zone->proposed[c]);
    }
    for (size_t j = 0; j < zone->n_impacts; ++j) {
        for (size_t k = 0; k < 4; ++k) {
            size_t vertex = (size_t)zone->nodes[4 * j + k];
            real factor = zone->weights[4 * j + k] * forces[j];
            if (zone->pinned[vertex]) continue;
            for (size_t axis = 0; axis < 3; ++axis)
                gradient_out[3 * vertex + axis] -= factor * zone->normals[3 * j + axis];
        }
    }
}

void zone_at_point(const struct json *input) {
    struct zone zone = read_zone(input);
    const real *positions = read_reals(input, "positions", 3 * zone.n_vertices);
    real *gradient = allocate_reals(3 * zone.n_vertices);
    real *no_forces = allocate_reals(zone.n_impacts);
    const real *constraints = constraints_at(&zone, positions);
    gradient_of_lagrangian(&zone, positions, no_forces, gradient);
    write_real("objective", (real)objective_at(&zone, positions));
    write_reals("gradient", gradient, 3 * zone.n_vertices);
    write_reals("constraints", constraints, zone.n_impacts);
}

void lagrangian_at_point(const struct json *input) {
    struct zone zone = read_zone(input);
    const real *positions = read_reals(input, "positions", 3 * zone.n_vertices);
    const real *multipliers = read_reals(input, "multipliers", zone.n_impacts);
    real penalty = read_positive(input, "penalty");
    const real *constraints = constraints_at(&zone, positions);
    real *forces = allocate_reals(zone.n_impacts);
    real *gradient = allocate_reals(3 * zone.n_vertices);
    double value = objective_at(&zone, positions);
    for (size_t j = 0; j < zone.n_impacts; ++j) {
        real rest = multipliers[j] / penalty, pushed = constraints[j] + rest;
        /* At the kink, where pushed is 0, both branches agree: the impact adds no force. */
        forces[j] = larger(multipliers[j] + penalty * constraints[j], 0);
        value -= 0.5 * penalty * rest * rest;
        if (pushed > 0) value += 0.5 * penalty * pushed * pushed;
    }
    gradient_of_lagrangian(&zone, positions, forces, gradient);
    write_real("value", (real)value);
    write_reals("gradient", gradient, 3 * zone.n_vertices);
}

void update_multipliers(const struct json *input) {
    size_t n = count_of(input, "multipliers");
    real *multipliers = read_reals(input, "multipliers", n);
    const real *constraints = read_reals(input, "constraints", n);
    real penalty = read_positive(input, "penalty");
    for (size_t j = 0; j < n; ++j)
        multipliers[j] = larger(multipliers[j] + penalty * constraints[j], 0);
    write_reals("multipliers", multipliers, n);
}
