/* Roots of polynomials of degree 1 to 3 in [0, 1]. */

#ifndef ROOTS_H
#define ROOTS_H

#include "real.h"

/* A time at which a polynomial may be zero, and how far from it the zero may be. */
struct root {
    real time, doubt;
};

/* The largest number of roots that are found, extrema and ends that touch zero included. */
enum { MOST_ROOTS = 10 };

/* Finds all times in [0, 1] at which a polynomial may be zero, in no order, and returns how many
   there are. `coefficients` are those of Bernstein, degree + 1 numbers, and `error` bounds their
   rounding. A polynomial that is zero everywhere, to rounding, has none. */
int find_roots(const real *coefficients, int degree, real error, struct root *roots_out);

#endif
