"""The loops of three systems with their parameters, written literally in numpy.

Positions x and proposed positions y are flat, (3 n,). The constraints are dense rows, (m, 3 n),
and their values are c = thickness - rows x.
"""

import numpy as np


def lagrangian(x, y, w, rows, thickness, multipliers, mu):
    """Return L (page eq. 11) and its gradient for the objective sum w (x - y)^2 / 2."""
    push = np.maximum(multipliers + mu * (thickness - rows @ x), 0.0)
    value = 0.5 * np.sum(w * (x - y) ** 2) + np.sum(push**2 - multipliers**2) / (2.0 * mu)
    return value, w * (x - y) - rows.T @ push


def curvature(p, w, rows, active, mu):
    """Return the second derivative of L along p."""
    return np.sum(w * p**2) + mu * np.sum((rows[active] @ p) ** 2)


def xrtailor(y, masses, rows, thickness, steps):
    """Descend along the plain gradient.

    Armijo factor 0.5, shrink factor 0.7. The first step is 1e-3 times the number of vertices,
    and the step never grows again.
    """
    m = np.repeat(masses, 3)
    w, mu, step = np.mean(1.0 / masses) * m, 1e3, 1e-3 * len(masses)
    x, multipliers = y.copy(), np.zeros(len(rows))
    for _ in range(steps):
        value, gradient = lagrangian(x, y, w, rows, thickness, multipliers, mu)
        while step >= 1e-12:
            trial, _ = lagrangian(x - step * gradient, y, w, rows, thickness, multipliers, mu)
            if trial < value - 0.5 * step * np.sum(gradient**2):
                break
            step *= 0.7
        if step < 1e-12:
            break
        x = x - step * gradient
        multipliers = np.maximum(multipliers + mu * (thickness - rows @ x), 0.0)
    return x


def icloth(y, masses, rows, thickness, steps):
    """Descend along the gradient over the diagonal of the Hessian.

    Armijo factor 0.5, shrink factor 0.7. Chebyshev acceleration follows each step.
    """
    w, mu, rho, omega = 2.0 * np.repeat(masses, 3) / np.sum(masses), 1e3, 0.9992, 1.0
    x, before, multipliers = y.copy(), y.copy(), np.zeros(len(rows))
    step, k = 1.0, -1
    for _ in range(steps):
        value, gradient = lagrangian(x, y, w, rows, thickness, multipliers, mu)
        k = 0 if gradient @ (x - before) > 0.0 else k + 1
        active = multipliers + mu * (thickness - rows @ x) > 0.0
        p = -gradient / (w + mu * np.sum(rows[active] ** 2, axis=0))
        while step >= 1e-12:
            trial, _ = lagrangian(x + step * p, y, w, rows, thickness, multipliers, mu)
            if trial < value + 0.5 * step * (gradient @ p):
                break
            step *= 0.7
        if step < 1e-12:
            break
        if k < 10:
            omega = 1.0
        elif k == 10:
            omega = 2.0 / (2.0 - rho**2)
        else:
            omega = 4.0 / (4.0 - rho**2 * omega)
        x, before = omega * (x + step * p - before) + before, x
        multipliers = np.maximum(multipliers + mu * (thickness - rows @ x), 0.0)
    return x


def wolfe_step(along, slope, first):
    """Find a step with the strong Wolfe conditions, 1e-4 and 0.1.

    Newton's method on the slope proposes steps; where they leave the bracket, it is halved.
    """
    low, high, step = 0.0, np.inf, first
    for _ in range(200):
        change, rise, second = along(step)
        decreased = change < 1e-4 * step * slope
        if decreased and abs(rise) <= 0.1 * abs(slope):
            return step, change
        if rise > 0.1 * abs(slope) or not decreased:
            high = step
        else:
            low = step
        step -= rise / second
        if not low < step < high:
            step = 0.5 * (low + high) if high < np.inf else 2.0 * low
    raise AssertionError("no step")


def arcsim(y, masses, rows, thickness, steps):
    """Descend with conjugate gradients.

    The multipliers change after each inner solve, which ends after 10 steps or when one of
    three stopping conditions holds.
    """
    w, mu = np.mean(1.0 / masses) * np.repeat(masses, 3), 1e3
    x, multipliers, total = y.copy(), np.zeros(len(rows)), 0
    while total < steps:
        inner = 0
        value, gradient = lagrangian(x, y, w, rows, thickness, multipliers, mu)
        p = -gradient
        while total < steps and inner < 10 and np.linalg.norm(gradient) > 1e-6:
            slope = gradient @ p

            def along(a, x=x, p=p, value=value, multipliers=multipliers):
                here, g = lagrangian(x + a * p, y, w, rows, thickness, multipliers, mu)
                active = multipliers + mu * (thickness - rows @ (x + a * p)) > 0.0
                return here - value, g @ p, curvature(p, w, rows, active, mu)

            first = -slope / along(0.0)[2]
            step, change = wolfe_step(along, slope, first)
            x, before = x + step * p, gradient
            old, (value, gradient) = value, lagrangian(x, y, w, rows, thickness, multipliers, mu)
            inner, total = inner + 1, total + 1
            change_y = gradient - before
            small = np.linalg.norm(step * p) <= 1e-6
            if small or -change <= 1e-12 * max(abs(value), abs(old), 1.0):
                break
            beta = min(gradient @ change_y, gradient @ gradient) / (p @ change_y)
            p = -gradient + max(0.0, beta) * p
            if gradient @ p >= 0.0 or inner % len(x) == 0:
                p = -gradient
        if inner == 0:
            break
        if total < steps:
            multipliers = np.maximum(multipliers + mu * (thickness - rows @ x), 0.0)
    return x
