/* The state of the augmented-Lagrangian loop of S10, which its directions share. */

#ifndef DESCENT_H
#define DESCENT_H

#include "search.h"

enum direction_kind { GRADIENT, JACOBI, CHEBYSHEV, CG, LBFGS, NEWTON };
enum { MOST_PAIRS = 64 }; /* that lbfgs may remember */

/* The unknowns are x, displacements from the proposed positions, so that nothing cancels in them.
   The objective is sum w x^2 / 2, and the constraints are c = s - A x. Pinned vertices have zeros
   in x, in A and in every vector. */
struct descent {
    const struct zone *zone;
    size_t n, m;        /* coordinates of all vertices, and impacts */
    size_t n_unknown;   /* coordinates of unpinned vertices */
    real *weights;      /* (n), w; 1 at pinned vertices, so that one may divide by it */
    real *coefficients; /* (m, 4); times the normal, the entries of A */
    real *starts;       /* (m), s */
    real *metres;       /* (m), violation [m] of a constraint of 1 */
    real *lengths;      /* (n_vertices), displacement [m] of an unknown of 1 */
    double penalty;

    real *x, *multipliers, *constraints, *pushed, *rates, *gradient, *direction;
    enum direction_kind kind;
    bool preconditioned;
    size_t age;         /* steps since the direction last forgot the steps before */

    real *gradient_before, *gradient_change; /* cg, lbfgs: of the last step */
    double step_length;                      /* of the last step */
    real *x_before;                          /* chebyshev: x before the last step */
    double omega, rho;                       /* chebyshev */
    size_t delay;                            /* chebyshev */
    size_t pairs;       /* lbfgs: how many of the last steps count */
    size_t n_pairs;     /* stored so far; number i is at i % pairs */
    real *pair_steps[MOST_PAIRS], *pair_changes[MOST_PAIRS];
    double pair_products[MOST_PAIRS];
    double linear_tolerance;
};

double sum_of_products(const real *a, const real *b, size_t n);

/* Computes A v. */
void constraint_products(const struct descent *descent, const real *v, real *products_out);

/* Computes out += factor A^T forces. */
void add_pulls(const struct descent *descent, real factor, const real *forces, real *out);

/* Chooses `direction`, and computes `rates` and the slope and curvature of L along it. With
   `restart`, the direction forgets the steps before. */
struct line choose_direction(struct descent *descent, bool restart);

/* Keeps what cg and lbfgs learn from the last step, whose end has just been evaluated. */
void remember_step(struct descent *descent);

/* Extrapolates the step that has just been made. */
void accelerate(struct descent *descent);

#endif
