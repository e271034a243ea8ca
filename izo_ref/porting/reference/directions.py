"""The descent directions of stage S10 in numbers that carry their rounding.

With g the gradient of L, H its generalised Hessian diag(w) + mu sum_active A_j A_j^T, s the last
step and q the change of g over that step, before the multipliers changed:

    gradient          p = -g
    jacobi            p = -g / diag(H)
    chebyshev         as jacobi; after the move x <- omega (x - x_before) + x_before
    cg                p = -g + beta s,  beta = max(0, min(g . q, g . g) / (s . q))
    lbfgs             p = -B g, with B from the last pairs s, q by the two-loop recursion
    newton            H p = -g, by conjugate gradients with w as preconditioner

Source: docs/method section 4; J. Nocedal, S. Wright, Numerical Optimization (2006), algorithms
5.3 and 7.4, eq. 7.20.
"""

from __future__ import annotations

from collections.abc import Sequence

from izo_ref.porting.reference.rounded import ZERO, Plain, Rounded
from izo_ref.porting.reference.tracked import norm, smaller
from izo_ref.porting.reference.variables import Flat, Variables, products, pull
from izo_ref.porting.reference.zone import dot


def scaled_sum(factor: Plain, a: Flat, b: Flat) -> Flat:
    """Return factor a + b."""
    return [factor * u + v for u, v in zip(a, b, strict=True)]


def negative(vector: Flat) -> Flat:
    """Return -v."""
    return [-v for v in vector]


def hessian_diagonal(zone: Variables, active: Sequence[bool], mu: Plain) -> Flat:
    """Return w + mu sum of the squared entries of the active constraints."""
    diagonal = list(zone.curvatures)
    for row, counts in zip(zone.rows, active, strict=True):
        if counts:
            for i, a in row.items():
                diagonal[i] = diagonal[i] + mu * (a * a)
    return diagonal


def times_hessian(zone: Variables, active: Sequence[bool], mu: Plain, vector: Flat) -> Flat:
    """Return H v."""
    along = products(zone, vector)
    forces = [mu * q if counts else Rounded(ZERO) for q, counts in zip(along, active, strict=True)]
    pulled = pull(zone, forces)
    return [w * v + f for w, v, f in zip(zone.curvatures, vector, pulled, strict=True)]


def next_omega(omega: Rounded, k: int, delay: int, rho: Plain) -> Rounded:
    """Return omega of step k since the last restart, where `omega` is that of the step before."""
    if k < delay:
        return Rounded.of(1.0)
    rho_sq = Rounded.of(rho) * rho
    return 2.0 / (2.0 - rho_sq) if k == delay else 4.0 / (4.0 - rho_sq * omega)


def accelerate(x: Flat, before: Flat, omega: Rounded) -> Flat:
    """Return omega (x - x_before) + x_before, where `before` is two moves back."""
    return [omega * (here - old) + old for here, old in zip(x, before, strict=True)]


def conjugate(gradient: Flat, moved: Flat, change: Flat) -> Flat:
    """Return -g + beta s, with the beta of Dai and Yuan bounded by that of Hestenes and Stiefel."""
    curvature = dot(moved, change)
    if not curvature > 0.0:
        return negative(gradient)
    kept = smaller(dot(gradient, change), dot(gradient, gradient))
    beta = kept / curvature if kept > 0.0 else Rounded(ZERO)
    return scaled_sum(beta, moved, negative(gradient))


def quasi_newton(gradient: Flat, pairs: Sequence[tuple[Flat, Flat]]) -> Flat:
    """Return -B g by the two-loop recursion; `pairs` has the pairs s, q, the newest one last."""
    p = negative(gradient)
    alphas = []
    for s, q in reversed(pairs):
        alphas.append(dot(s, p) / dot(s, q))
        p = scaled_sum(-alphas[-1], q, p)
    if pairs:
        s, q = pairs[-1]
        gamma = dot(s, q) / dot(q, q)
        p = [gamma * v for v in p]
    for (s, q), alpha in zip(pairs, reversed(alphas), strict=True):
        p = scaled_sum(alpha - dot(q, p) / dot(s, q), s, p)
    return p


def newton(
    zone: Variables, gradient: Flat, active: Sequence[bool], mu: Plain, tolerance: float
) -> Flat:
    """Return p with H p = -g, until the residual has fallen by the factor `tolerance`.

    The residual r is measured in the norm of 1 / w.
    """
    w = zone.curvatures
    p, r = [Rounded(ZERO)] * len(w), negative(gradient)
    d = [v / a for v, a in zip(r, w, strict=True)]
    goal, product = tolerance * _residual(r, w), dot(r, d)
    while _residual(r, w) > goal:
        h = times_hessian(zone, active, mu, d)
        step = product / dot(d, h)
        p, r = scaled_sum(step, d, p), scaled_sum(-step, h, r)
        z = [v / a for v, a in zip(r, w, strict=True)]
        before, product = product, dot(r, z)
        d = scaled_sum(product / before, d, z)
    return p


def _residual(r: Flat, w: Flat) -> Rounded:
    """Return the norm of r in 1 / w."""
    return norm([v / a.sqrt() for v, a in zip(r, w, strict=True)])
