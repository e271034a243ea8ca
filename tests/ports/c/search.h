/* The augmented Lagrangian along a line x + step p, and the searches for a step. */

#ifndef SEARCH_H
#define SEARCH_H

#include "zone.h"

/* phi(step) = L(x + step p), as far as it depends on the step. */
struct line {
    double slope;       /* phi'(0) */
    double curvature;   /* sum w p^2, the second derivative of the objective along p */
    double penalty;     /* mu */
    size_t n_impacts;
    const real *pushed; /* c + l / mu at x; an impact is active where this is positive */
    const real *rates;  /* by how much c falls for a step of 1: N . sum_k a_k p_k */
};

enum search_kind { BACKTRACKING, EXACT, WOLFE };
extern const char *const search_names[]; /* in the order of the kinds */

struct search {
    enum search_kind kind;
    double armijo, wolfe, shrink, smallest_step;
    real *tried; /* the steps that backtracking has tried; room for `room` of them, or NULL */
    size_t room, n_tried;
};

struct step {
    double length; /* 0 if no step was accepted */
    double change; /* of L */
};

struct search read_search(const struct json *input);
double second_derivative(const struct line *line);
struct step search_line(const struct line *line, double first, struct search *search);

#endif
