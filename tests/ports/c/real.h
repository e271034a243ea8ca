/* Numbers and vectors of three numbers.

   The whole port computes in `real`: double, or float with -DREAL=float. Sums over many terms are
   double in both builds, as most ports to a GPU have them, because they cost little and because a
   float sum over thousands of terms would be the largest error of all. */

#ifndef REAL_H
#define REAL_H

#include <float.h>
#include <math.h>
#include <stddef.h>

#ifndef REAL
#define REAL double
#endif

typedef REAL real;

/* One unit in the last place of 1, and the name of the type in the protocol. */
#define EPSILON (sizeof(real) == sizeof(float) ? (real)FLT_EPSILON : (real)DBL_EPSILON)
#define DTYPE (sizeof(real) == sizeof(float) ? "f4" : "f8")

typedef struct {
    real x, y, z;
} vec;

static inline real magnitude(real a) { return a < 0 ? -a : a; }
static inline real larger(real a, real b) { return a > b ? a : b; }
static inline real smaller(real a, real b) { return a < b ? a : b; }

/* The root of a double, rounded to float, is the correctly rounded root of a float. */
static inline real root_of(real a) { return (real)sqrt((double)a); }

static inline vec vec_at(const real *array, size_t i) {
    return (vec){array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}

static inline vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec subtract(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec scale(real s, vec a) { return (vec){s * a.x, s * a.y, s * a.z}; }
static inline real dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline real length(vec a) { return root_of(dot(a, a)); }

static inline vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline vec sizes(vec a) { return (vec){magnitude(a.x), magnitude(a.y), magnitude(a.z)}; }
static inline real largest(vec a) {
    return larger(magnitude(a.x), larger(magnitude(a.y), magnitude(a.z)));
}

/* (1 - t) a + t b is a at t = 0 and b at t = 1, both to the last bit; a + t (b - a) is not. */
static inline vec between(vec a, vec b, real t) { return add(scale(1 - t, a), scale(t, b)); }

#endif
