/* Directions of descent for S10: gradient, jacobi, chebyshev, cg, lbfgs and newton. */

#include <string.h>

#include "descent.h"

double sum_of_products(const real *a, const real *b, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) sum += (double)a[i] * b[i];
    return sum;
}

void constraint_products(const struct descent *descent, const real *v, real *products_out) {
    const struct zone *zone = descent->zone;
    for (size_t j = 0; j < descent->m; ++j) {
        vec sum = {0, 0, 0};
        for (size_t k = 0; k < 4; ++k) {
            vec at_node = vec_at(v, (size_t)zone->nodes[4 * j + k]);
            sum = add(sum, scale(descent->coefficients[4 * j + k], at_node));
        }
        products_out[j] = dot(vec_at(zone->normals, j), sum);
    }
}

void add_pulls(const struct descent *descent, real factor, const real *forces, real *out) {
    const struct zone *zone = descent->zone;
    for (size_t j = 0; j < descent->m; ++j)
        for (size_t k = 0; k < 4; ++k)
            for (size_t axis = 0; axis < 3; ++axis)
                out[3 * zone->nodes[4 * j + k] + (long)axis] +=
                    factor * forces[j] * descent->coefficients[4 * j + k] *
                    zone->normals[3 * j + axis];
}

/* D of the generalised Hessian diag(w) + mu sum A_j A_j^T over the active impacts. */
static real *hessian_diagonal(const struct descent *descent) {
    const struct zone *zone = descent->zone;
    real *diagonal = allocate_reals(descent->n);
    memcpy(diagonal, descent->weights, descent->n * sizeof *diagonal);
    for (size_t j = 0; j < descent->m; ++j)
        for (size_t k = 0; k < 4 && descent->pushed[j] > 0; ++k)
            for (size_t axis = 0; axis < 3; ++axis) {
                real entry = descent->coefficients[4 * j + k] * zone->normals[3 * j + axis];
                diagonal[3 * zone->nodes[4 * j + k] + (long)axis] +=
                    (real)descent->penalty * entry * entry;
            }
    return diagonal;
}

static void gradient_direction(struct descent *descent) {
    const real *diagonal = descent->preconditioned ? hessian_diagonal(descent) : NULL;
    for (size_t i = 0; i < descent->n; ++i)
        descent->direction[i] = -descent->gradient[i] / (diagonal != NULL ? diagonal[i] : 1);
}

static void cg_direction(struct descent *descent, bool restart) {
    const real *g = descent->gradient, *q = descent->gradient_change;
    real *p = descent->direction;
    double p_q = sum_of_products(p, q, descent->n), beta = 0;
    if (!restart && p_q > 0) {
        double g_q = sum_of_products(g, q, descent->n), g_g = sum_of_products(g, g, descent->n);
        beta = fmax(0, fmin(g_q, g_g) / p_q);
    }
    for (size_t i = 0; i < descent->n; ++i) p[i] = (real)beta * p[i] - g[i];
}

/* Keeps the last step of lbfgs, if it tells the curvature. */
static void remember_pair(struct descent *descent) {
    const real *y = descent->gradient_change, *p = descent->direction;
    size_t n = descent->n, slot = descent->n_pairs % descent->pairs;
    real *s = allocate_reals(n);
    for (size_t i = 0; i < n; ++i) s[i] = (real)descent->step_length * p[i];
    double s_y = sum_of_products(s, y, n);
    double size = sqrt(sum_of_products(s, s, n) * sum_of_products(y, y, n));
    /* y is a difference of gradients, so a product below this is rounding */
    if (!(s_y > 0.5 * EPSILON * size)) return;
    descent->pair_steps[slot] = s;
    descent->pair_changes[slot] = allocate_reals(n);
    memcpy(descent->pair_changes[slot], y, n * sizeof *y);
    descent->pair_products[slot] = s_y;
    ++descent->n_pairs;
}

void remember_step(struct descent *descent) {
    for (size_t i = 0; i < descent->n; ++i)
        descent->gradient_change[i] = descent->gradient[i] - descent->gradient_before[i];
    if (descent->kind == LBFGS) remember_pair(descent);
}

static void add_multiple(real *out, double factor, const real *v, size_t n) {
    for (size_t i = 0; i < n; ++i) out[i] += (real)factor * v[i];
}

/* The two-loop recursion: Nocedal and Wright, algorithm 7.4. */
static void lbfgs_direction(struct descent *descent) {
    size_t n = descent->n, end = descent->n_pairs;
    size_t first = end > descent->pairs ? end - descent->pairs : 0;
    double alpha[MOST_PAIRS];
    real *p = descent->direction;
    for (size_t i = 0; i < n; ++i) p[i] = -descent->gradient[i];
    for (size_t pair = end; pair-- > first;) {
        size_t slot = pair % descent->pairs;
        double along = sum_of_products(descent->pair_steps[slot], p, n);
        alpha[slot] = along / descent->pair_products[slot];
        add_multiple(p, -alpha[slot], descent->pair_changes[slot], n);
    }
    if (end > 0) {
        size_t slot = (end - 1) % descent->pairs;
        const real *y = descent->pair_changes[slot];
        double gamma = descent->pair_products[slot] / sum_of_products(y, y, n);
        for (size_t i = 0; i < n; ++i) p[i] *= (real)gamma;
    }
    for (size_t pair = first; pair < end; ++pair) {
        size_t slot = pair % descent->pairs;
        double beta =
            sum_of_products(descent->pair_changes[slot], p, n) / descent->pair_products[slot];
        add_multiple(p, alpha[slot] - beta, descent->pair_steps[slot], n);
    }
}

/* Computes H v; impacts that are not active add nothing. */
static void multiply_by_hessian(const struct descent *descent, const real *v, real *out) {
    constraint_products(descent, v, descent->rates);
    for (size_t j = 0; j < descent->m; ++j)
        if (!(descent->pushed[j] > 0)) descent->rates[j] = 0;
    for (size_t i = 0; i < descent->n; ++i) out[i] = descent->weights[i] * v[i];
    add_pulls(descent, (real)descent->penalty, descent->rates, out);
}

/* Conjugate gradients for H p = -g from p = 0, preconditioned by w. They end when the residual, in
   the norm of 1 / w, has fallen by `linear_tolerance`. Every iterate is a direction of descent. */
static void newton_direction(struct descent *descent) {
    size_t n = descent->n;
    const real *w = descent->weights;
    real *p = descent->direction, *residual = allocate_reals(n);
    real *conjugate = allocate_reals(n), *product = allocate_reals(n);
    double size = 0, goal;
    for (size_t i = 0; i < n; ++i) {
        p[i] = 0;
        residual[i] = -descent->gradient[i];
        conjugate[i] = residual[i] / w[i];
        size += (double)residual[i] * conjugate[i];
    }
    goal = descent->linear_tolerance * descent->linear_tolerance * size;
    for (size_t count = 0; count < 2 * n && size > goal; ++count) {
        multiply_by_hessian(descent, conjugate, product);
        double curvature = sum_of_products(conjugate, product, n), before = size;
        if (!(curvature > 0)) break;
        add_multiple(p, size / curvature, conjugate, n);
        add_multiple(residual, -size / curvature, product, n);
        size = 0;
        for (size_t i = 0; i < n; ++i) size += (double)residual[i] * residual[i] / w[i];
        for (size_t i = 0; i < n; ++i)
            conjugate[i] = residual[i] / w[i] + (real)(size / before) * conjugate[i];
    }
}

/* Whether L rises along the last step, momentum included: then the acceleration begins anew. */
static bool goes_uphill(const struct descent *descent) {
    double slope = 0;
    for (size_t i = 0; i < descent->n; ++i)
        slope += (double)descent->gradient[i] * (descent->x[i] - descent->x_before[i]);
    return slope > 0;
}

static void compute_direction(struct descent *descent, bool restart) {
    switch (descent->kind) {
    case CG: cg_direction(descent, restart); break;
    case LBFGS: lbfgs_direction(descent); break;
    case NEWTON: newton_direction(descent); break;
    default: gradient_direction(descent); break;
    }
}

static struct line line_of(struct descent *descent) {
    const real *p = descent->direction;
    struct line line = {0, 0, descent->penalty, descent->m, descent->pushed, descent->rates};
    constraint_products(descent, p, descent->rates);
    line.slope = sum_of_products(descent->gradient, p, descent->n);
    for (size_t i = 0; i < descent->n; ++i)
        line.curvature += (double)descent->weights[i] * p[i] * p[i];
    return line;
}

struct line choose_direction(struct descent *descent, bool restart) {
    if (descent->kind == CG && descent->age >= descent->n_unknown) restart = true;
    if (descent->kind == CHEBYSHEV && goes_uphill(descent)) restart = true;
    descent->age = restart ? 0 : descent->age + 1;
    compute_direction(descent, restart);
    struct line line = line_of(descent);
    if (!(line.slope < 0)) { /* no descent: take the gradient, and forget what led here */
        descent->age = descent->n_pairs = 0;
        gradient_direction(descent);
        line = line_of(descent);
    }
    return line;
}

void accelerate(struct descent *descent) {
    double square = descent->rho * descent->rho;
    if (descent->age < descent->delay)
        descent->omega = 1;
    else if (descent->age == descent->delay)
        descent->omega = 2 / (2 - square);
    else
        descent->omega = 4 / (4 - square * descent->omega);
    for (size_t i = 0; i < descent->n; ++i) {
        real here = descent->x[i], before = descent->x_before[i];
        descent->x_before[i] = here - (real)descent->step_length * descent->direction[i];
        if (descent->omega != 1) descent->x[i] = (real)descent->omega * (here - before) + before;
    }
}
