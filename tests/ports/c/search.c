/* S8: line searches.

   Along a line L is convex and piecewise quadratic: an impact is active on one side of the step
   pushed / rate. So phi' rises, and is linear between these steps. */

#include "search.h"

#include <stdlib.h>

#include "stages.h"

const char *const search_names[] = {"backtracking", "exact", "wolfe", NULL};

/* The change of L at a step, and the first two derivatives there. */
struct point {
    double change, slope, curvature;
};

/* Near the minimum, phi(step) - phi(0) as a difference of two values of L is nothing but rounding.
   So the change is the slope's share plus terms that are not negative and in which nothing cancels:
   what (t - move)^2, for an impact with t > 0 or t > move, has beyond its tangent at the start. */
static struct point at_step(const struct line *line, double step) {
    double value = 0, slope = 0, curvature = 0;
    for (size_t j = 0; j < line->n_impacts; ++j) {
        double t = line->pushed[j], rate = line->rates[j], move = step * rate;
        bool starts_active = t > 0, ends_active = t > move;
        if (starts_active && ends_active) {
            value += move * move;
            slope += move * rate;
        } else if (starts_active) {
            value += t * (2 * move - t);
            slope += t * rate;
        } else if (ends_active) {
            value += (t - move) * (t - move);
            slope += (move - t) * rate;
        }
        if (ends_active) curvature += rate * rate;
    }
    return (struct point){
        step * line->slope + 0.5 * (line->curvature * step * step + line->penalty * value),
        line->slope + line->curvature * step + line->penalty * slope,
        line->curvature + line->penalty * curvature,
    };
}

double second_derivative(const struct line *line) { return at_step(line, 0).curvature; }

/* The inequality is strict, so a step without any decrease is not accepted at the minimum. */
static bool decreases_enough(const struct line *line, double step, double change, double armijo) {
    return change < armijo * step * line->slope;
}

static struct step backtrack(const struct line *line, double first, struct search *search) {
    search->n_tried = 0;
    for (double step = first; step >= search->smallest_step; step *= search->shrink) {
        if (search->n_tried < search->room) search->tried[search->n_tried++] = (real)step;
        double change = at_step(line, step).change;
        if (decreases_enough(line, step, change, search->armijo))
            return (struct step){step, change};
    }
    return (struct step){0, 0};
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Finds the linear piece of phi' that has the root, by bisection over the sorted kinks, and takes
   the root of this piece. The curvature of a piece is that of its middle: at a kink itself, the
   impact that becomes active there does not count yet. */
static struct step minimise_line(const struct line *line) {
    double *kinks = allocate(line->n_impacts, sizeof *kinks);
    size_t n_kinks = 0, below = 0;
    double low = 0;
    for (size_t j = 0; j < line->n_impacts; ++j) {
        double kink = line->rates[j] != 0 ? (double)line->pushed[j] / line->rates[j] : -1;
        if (kink > 0 && isfinite(kink)) kinks[n_kinks++] = kink;
    }
    qsort(kinks, n_kinks, sizeof *kinks, compare);
    for (size_t above = n_kinks; below < above;) {
        size_t i = below + (above - below) / 2;
        if (at_step(line, kinks[i]).slope < 0) {
            low = kinks[i];
            below = i + 1;
        } else {
            above = i;
        }
    }
    double middle = below < n_kinks ? low + (kinks[below] - low) / 2 : 2 * low + 1;
    double length = low - at_step(line, low).slope / at_step(line, middle).curvature;
    return (struct step){length, at_step(line, length).change};
}

/* Keeps an interval that holds steps with the strong Wolfe conditions. The next step is that of
   Newton's method on phi', which reaches the root if no kink is in between; else it is the middle
   of the interval, or twice its lower end as long as it has no upper end. */
static struct step search_wolfe(const struct line *line, double first,
                                const struct search *search) {
    double low = 0, high = INFINITY, step = first, change_low = 0;
    double flat = search->wolfe * fabs(line->slope);
    for (int tries = 0; tries < 200 && step >= search->smallest_step; ++tries) {
        struct point here = at_step(line, step);
        bool enough = decreases_enough(line, step, here.change, search->armijo);
        if (enough && fabs(here.slope) <= flat) return (struct step){step, here.change};
        if (enough && here.slope < 0) {
            low = step;
            change_low = here.change;
        } else {
            high = step;
        }
        step -= here.slope / here.curvature;
        if (!(low < step && step < high)) step = isfinite(high) ? 0.5 * (low + high) : 2 * low;
        if (!(low < step && step < high)) break; /* no number is left between the two */
    }
    return (struct step){low, change_low};
}

struct step search_line(const struct line *line, double first, struct search *search) {
    if (search->kind == BACKTRACKING) return backtrack(line, first, search);
    if (!(line->slope < 0)) return (struct step){0, 0}; /* the line does not lead downhill */
    if (search->kind == EXACT) return minimise_line(line);
    return search_wolfe(line, first, search);
}

struct search read_search(const struct json *input) {
    struct search search = {.kind = (enum search_kind)read_choice(input, "search", search_names)};
    search.armijo = read_real(input, "armijo");
    search.wolfe = read_real(input, "wolfe");
    search.shrink = read_positive(input, "shrink");
    search.smallest_step = read_positive(input, "smallest_step");
    if (!(search.shrink < 1)) refuse("shrink is not below 1");
    return search;
}

void line_search(const struct json *input) {
    struct zone zone = read_zone(input);
    size_t n = 3 * zone.n_vertices, m = zone.n_impacts;
    const real *positions = read_reals(input, "positions", n);
    const real *direction = read_reals(input, "direction", n);
    const real *multipliers = read_reals(input, "multipliers", m);
    real penalty = read_positive(input, "penalty"), first = read_positive(input, "first");
    struct search search = read_search(input);
    real *pushed = allocate_reals(m), *forces = allocate_reals(m), *rates = allocate_reals(m);
    real *gradient = allocate_reals(n);
    struct line line = {0, 0, penalty, m, pushed, rates};
    search.room = search.kind == BACKTRACKING ? 2000 : 0; /* factors of 0.99 reach 1e-12 in these */
    search.tried = allocate_reals(search.room);
    for (size_t j = 0; j < m; ++j) {
        real constraint = zone.thickness - gap_of_impact(&zone, j, positions);
        pushed[j] = constraint + multipliers[j] / penalty;
        forces[j] = larger(multipliers[j] + penalty * constraint, 0);
        rates[j] = gap_of_impact(&zone, j, direction);
    }
    gradient_of_lagrangian(&zone, positions, forces, gradient);
    for (size_t i = 0; i < n; ++i) {
        line.slope += (double)gradient[i] * direction[i];
        line.curvature += (double)weight_in_objective(&zone, i / 3) * direction[i] * direction[i];
    }
    struct step step = search_line(&line, first, &search);
    write_real("step", (real)step.length);
    write_real("change", (real)step.change);
    if (search.kind == BACKTRACKING) write_reals("tried", search.tried, search.n_tried);
}
