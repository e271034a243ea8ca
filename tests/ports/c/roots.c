/* Roots of polynomials of degree 1 to 3 in [0, 1]. */

#include "roots.h"

#include <stdbool.h>
#include <string.h>

/* Room for the extrema of a cubic. */
enum { EXTREMA = 8 };

/* De Casteljau's scheme on Bernstein coefficients only averages: it is as accurate as they are. */
static real bernstein(const real *coefficients, int degree, real t) {
    real b[4];
    memcpy(b, coefficients, sizeof *b * (size_t)(degree + 1));
    for (int level = degree; level > 0; --level)
        for (int i = 0; i < level; ++i) b[i] = (1 - t) * b[i] + t * b[i + 1];
    return b[0];
}

/* The result may overwrite the coefficients. */
static void differentiate(const real *coefficients, int degree, real *derivative_out) {
    for (int i = 0; i < degree; ++i)
        derivative_out[i] = (real)degree * (coefficients[i + 1] - coefficients[i]);
}

/* How far a root may be from where it was found, if the polynomial is known to within `error`:
   near a simple root it grows as its slope, near a double root as the square of the distance. */
static real doubt_of(const real *coefficients, int degree, real error, real t) {
    real derivative[4];
    double doubt = 1, factorial = 1;
    memcpy(derivative, coefficients, sizeof *coefficients * (size_t)(degree + 1));
    for (int order = 1; order <= degree; ++order) {
        differentiate(derivative, degree - order + 1, derivative);
        factorial *= order;
        double size = magnitude(bernstein(derivative, degree - order, t)) / factorial;
        if (size > error) doubt = fmin(doubt, pow(error / size, 1.0 / order));
    }
    return (real)doubt;
}

/* Halves an interval with a change of sign until no number is left in it, and returns its lower
   end: a time that is early by one bit is safe, one that is late is not. A tolerance in t would be
   late for whatever moves fast. */
static real bisect(const real *coefficients, int degree, real low, real high) {
    bool rises = bernstein(coefficients, degree, low) < 0;
    for (;;) {
        real middle = low + (high - low) / 2;
        if (!(low < middle && middle < high)) return low;
        if ((bernstein(coefficients, degree, middle) < 0) == rises)
            low = middle;
        else
            high = middle;
    }
}

/* A polynomial is monotone between the roots of its derivative, so each interval between these
   holds one root at most. At their ends it may touch zero without a change of sign. */
int find_roots(const real *coefficients, int degree, real error, struct root *roots_out) {
    real largest_coefficient = 0, derivative[3], cuts[EXTREMA + 2];
    int n_roots = 0, n_cuts = 0;
    for (int i = 0; i <= degree; ++i)
        largest_coefficient = larger(largest_coefficient, magnitude(coefficients[i]));
    if (!(largest_coefficient > error)) return 0; /* zero at all times, which says nothing */
    cuts[n_cuts++] = 0;
    if (degree > 1) {
        struct root extrema[EXTREMA];
        differentiate(coefficients, degree, derivative);
        int n_extrema = find_roots(derivative, degree - 1, 0, extrema);
        for (int i = 0; i < n_extrema; ++i)
            if (extrema[i].time > cuts[n_cuts - 1]) cuts[n_cuts++] = extrema[i].time;
    }
    if (cuts[n_cuts - 1] < 1) cuts[n_cuts++] = 1;
    for (int i = 0; i < n_cuts; ++i) {
        real value = bernstein(coefficients, degree, cuts[i]);
        if (!(magnitude(value) > error)) roots_out[n_roots++].time = cuts[i];
        if (i + 1 == n_cuts || value == 0) continue;
        real next = bernstein(coefficients, degree, cuts[i + 1]);
        if (next != 0 && (value < 0) != (next < 0))
            roots_out[n_roots++].time = bisect(coefficients, degree, cuts[i], cuts[i + 1]);
    }
    for (int i = 0; i < n_roots; ++i)
        roots_out[i].doubt = doubt_of(coefficients, degree, error, roots_out[i].time);
    return n_roots;
}
