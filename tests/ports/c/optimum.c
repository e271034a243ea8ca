/* S11: the optimum of a zone, by the dual active-set method of Goldfarb and Idnani (1983).

   In the unknowns z_i = sqrt(m_i) (x_i - y_i), with rows of unit length, a zone is

       minimise |z|^2 / 2   subject to   C z >= s.

   The method begins at z = 0, the optimum without constraints, and adds one violated constraint
   after the other. In between, z is the optimum for the active ones, so it never moves back to
   where it has been, and a constraint that cannot be met proves that no positions exist.

   Everything here is double and dense, in the float build as well: it is what the other methods of
   a port are compared with, and zones of tests are small. */

#include <string.h>

#include "stages.h"
#include "zone.h"

struct problem {
    size_t m, n;      /* constraints and unknowns */
    double *rows;     /* (m, n), C */
    double *rhs;      /* (m), s */
    double *rounding; /* (m), of s: a violation below this is none */
    double *scales;   /* (m), lengths of the rows before scaling; 0 without unknowns */
};

/* The active constraints W, with C_W = L Q and orthonormal rows in Q. */
struct active_set {
    size_t count, capacity;
    size_t *members;     /* which constraints */
    double *multipliers; /* u of each */
    double *q;           /* (capacity, n) */
    double *l;           /* (capacity, capacity) */
};

static double dot_n(const double *a, const double *b, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

static void add_n(double *a, double factor, const double *b, size_t n) {
    for (size_t i = 0; i < n; ++i) a[i] += factor * b[i];
}

/* The unknowns are the coordinates of unpinned vertices; the columns of pinned ones stay zero. */
static struct problem scale_problem(const struct zone *zone) {
    size_t m = zone->n_impacts, n = 3 * zone->n_vertices;
    if (m > 0 && n > (size_t)-1 / sizeof(double) / m) refuse("out of memory");
    struct problem problem = {m, n, allocate(m * n, sizeof(double)), allocate(m, sizeof(double)),
                              allocate(m, sizeof(double)), allocate(m, sizeof(double))};
    for (size_t j = 0; j < m; ++j) {
        double *row = problem.rows + j * n, gap = 0, size = magnitude(zone->thickness);
        for (size_t k = 0; k < 4; ++k) {
            size_t vertex = (size_t)zone->nodes[4 * j + k], first = (size_t)zone->nodes[4 * j];
            for (size_t axis = 0; axis < 3; ++axis) {
                double entry = (double)zone->weights[4 * j + k] * zone->normals[3 * j + axis];
                double arm = (double)zone->proposed[3 * vertex + axis] -
                             (double)zone->proposed[3 * first + axis];
                gap += entry * arm;
                size += fabs(entry * arm);
                if (!zone->pinned[vertex])
                    row[3 * vertex + axis] += entry / sqrt((double)zone->masses[vertex]);
            }
        }
        double scale = problem.scales[j] = sqrt(dot_n(row, row, n));
        double inverse = scale > 0 ? 1 / scale : 1;
        for (size_t i = 0; i < n; ++i) row[i] *= inverse;
        problem.rhs[j] = ((double)zone->thickness - gap) * inverse;
        problem.rounding[j] = 4 * DBL_EPSILON * size * inverse;
    }
    return problem;
}

/* Splits a row of C into its part along the rows of Q, whose coordinates are added to `along`, and
   the rest. Doing it twice leaves a rest that is orthogonal to Q to the last digits. */
static double split_row(const struct problem *problem, const struct active_set *set, size_t j,
                        double *along_out, double *rest_out) {
    size_t n = problem->n;
    memcpy(rest_out, problem->rows + j * n, n * sizeof *rest_out);
    for (size_t k = 0; k < set->count; ++k) along_out[k] = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t k = 0; k < set->count; ++k) {
            double part = dot_n(set->q + k * n, rest_out, n);
            along_out[k] += part;
            add_n(rest_out, -part, set->q + k * n, n);
        }
    return sqrt(dot_n(rest_out, rest_out, n));
}

/* Appends constraint j, split as above, to L and Q. */
static void append(struct active_set *set, size_t n, size_t j, double multiplier,
                   const double *along, const double *rest, double rest_length) {
    size_t k = set->count++;
    memcpy(set->l + k * set->capacity, along, k * sizeof *along);
    set->l[k * set->capacity + k] = rest_length;
    for (size_t i = 0; i < n; ++i) set->q[k * n + i] = rest[i] / rest_length;
    set->members[k] = j;
    set->multipliers[k] = multiplier;
}

/* Removes one member. The rows of L and Q behind it are computed anew, which costs more than
   rotations but adds no rounding to that of the factorisation. */
static void drop(const struct problem *problem, struct active_set *set, size_t at, double *along,
                 double *rest) {
    size_t count = set->count;
    set->count = at;
    for (size_t k = at + 1; k < count; ++k) {
        size_t j = set->members[k];
        double rest_length = split_row(problem, set, j, along, rest);
        append(set, problem->n, j, set->multipliers[k], along, rest, rest_length);
    }
}

/* Solves L^T r = along. */
static void solve_transposed(const struct active_set *set, const double *along, double *r_out) {
    for (size_t k = set->count; k-- > 0;) {
        double sum = along[k];
        for (size_t i = k + 1; i < set->count; ++i) sum -= set->l[i * set->capacity + k] * r_out[i];
        r_out[k] = sum / set->l[k * set->capacity + k];
    }
}

/* Computes z = Q^T L^-1 s_W and u = L^-T L^-1 s_W, without what the steps have added up. */
static void solve_active(const struct problem *problem, struct active_set *set, double *z) {
    double *y = allocate(set->count, sizeof *y);
    memset(z, 0, problem->n * sizeof *z);
    for (size_t k = 0; k < set->count; ++k) {
        const double *l = set->l + k * set->capacity;
        y[k] = (problem->rhs[set->members[k]] - dot_n(l, y, k)) / l[k];
        add_n(z, y[k], set->q + k * problem->n, problem->n);
    }
    solve_transposed(set, y, set->multipliers);
}

/* Returns the constraint that is violated most, beyond rounding, or m if there is none. */
static size_t most_violated(const struct problem *problem, const double *z) {
    double z_length = sqrt(dot_n(z, z, problem->n)), worst = 0;
    size_t found = problem->m;
    for (size_t j = 0; j < problem->m; ++j) {
        double violation = problem->rhs[j] - dot_n(problem->rows + j * problem->n, z, problem->n);
        double rounding = problem->rounding[j] + 8 * DBL_EPSILON * z_length;
        if (violation > rounding && violation > worst) {
            worst = violation;
            found = j;
        }
    }
    return found;
}

/* Makes constraint j hold: moves z along what is independent of the active constraints, while
   their multipliers change so that z stays their optimum. A multiplier that reaches zero leaves.
   Returns false if the constraint depends on the active ones and none of them can leave. */
static bool satisfy(const struct problem *problem, struct active_set *set, size_t j, double *z) {
    size_t n = problem->n;
    double *along = allocate(set->count + 1, sizeof *along);
    double *r = allocate(set->count + 1, sizeof *r), *rest = allocate(n, sizeof *rest);
    double *along_of_drop = allocate(set->count + 1, sizeof *along_of_drop);
    double *rest_of_drop = allocate(n, sizeof *rest_of_drop), multiplier = 0;
    for (;;) {
        double rest_length = split_row(problem, set, j, along, rest);
        /* rows have length 1, so a rest this short is the rounding of the split */
        bool is_dependent = rest_length < 32 * DBL_EPSILON * (double)(set->count + 1);
        double step = INFINITY, missing = problem->rhs[j] - dot_n(problem->rows + j * n, z, n);
        size_t leaving = set->count;
        solve_transposed(set, along, r);
        for (size_t k = 0; k < set->count; ++k) {
            if (r[k] > 0 && set->multipliers[k] / r[k] < step) {
                step = set->multipliers[k] / r[k];
                leaving = k;
            }
        }
        bool is_full = !is_dependent && missing / (rest_length * rest_length) <= step;
        if (is_full) step = missing / (rest_length * rest_length);
        if (isinf(step)) return false;
        for (size_t k = 0; k < set->count; ++k)
            set->multipliers[k] = fmax(0, set->multipliers[k] - step * r[k]);
        multiplier += step;
        if (!is_dependent) add_n(z, step, rest, n);
        if (is_full) {
            append(set, n, j, multiplier, along, rest, rest_length);
            return true;
        }
        drop(problem, set, leaving, along_of_drop, rest_of_drop);
    }
}

/* Returns whether positions exist that satisfy all constraints; z and the set are the optimum. */
static bool solve(const struct problem *problem, struct active_set *set, double *z) {
    for (size_t steps = 0;; ++steps) {
        size_t worst = most_violated(problem, z);
        if (worst == problem->m) return true;
        /* the objective grows with each step, so only rounding can make the method go round */
        if (steps > 100 * (problem->m + 1)) refuse("the active set does not settle");
        if (problem->scales[worst] == 0 || !satisfy(problem, set, worst, z)) return false;
        solve_active(problem, set, z);
    }
}

void optimum_of_zone(const struct json *input) {
    struct zone zone = read_zone(input);
    struct problem problem = scale_problem(&zone);
    size_t n = problem.n, m = problem.m, most = m < n ? m : n;
    struct active_set set = {.capacity = most, .members = allocate(most, sizeof(size_t))};
    double *z = allocate(n, sizeof *z);
    real *positions = allocate_reals(n), *multipliers = allocate_reals(m);
    set.multipliers = allocate(most, sizeof(double));
    set.q = allocate(most * n, sizeof(double));
    set.l = allocate(most * most, sizeof(double));
    bool is_feasible = solve(&problem, &set, z);
    write_integer("feasible", is_feasible);
    if (!is_feasible) return;
    memcpy(positions, zone.proposed, n * sizeof *positions);
    for (size_t i = 0; i < n; ++i)
        if (!zone.pinned[i / 3])
            positions[i] = (real)(zone.proposed[i] + z[i] / sqrt((double)zone.masses[i / 3]));
    for (size_t k = 0; k < set.count; ++k)
        multipliers[set.members[k]] =
            (real)(fmax(0, set.multipliers[k]) / problem.scales[set.members[k]]);
    write_reals("positions", positions, n);
    write_reals("multipliers", multipliers, m);
}
