"""The loops of three systems with their parameters, in the most literal numpy.

x and y are flat, (3 n,); rows dense, (m, 3 n), with the constraints c = thickness - rows x.
"""

import numpy as np


def lagrangian(x, y, w, rows, thickness, multipliers, mu):
    """L (page eq. 11) and its gradient, for the objective sum w (x - y)^2 / 2."""
    push = np.maximum(multipliers + mu * (thickness - rows @ x), 0.0)
    value = 0.5 * np.sum(w * (x - y) ** 2) + np.sum(push**2 - multipliers**2) / (2.0 * mu)
    return value, w * (x - y) - rows.T @ push


def curvature(p, w, rows, active, mu):
    return np.sum(w * p**2) + mu * np.sum((rows[active] @ p) ** 2)


def xrtailor(y, masses, rows, thickness, steps):
    """Plain gradient, Armijo 0.5, shrink 0.7, first step 1e-3 times the nodes, never grows."""
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
    """Gradient over the diagonal of the Hessian, Armijo 0.5, Chebyshev after the move."""
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
    """Strong Wolfe, 1e-4 and 0.1: Newton on the slope, halving where that leaves the bracket."""
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
    """Conjugate gradient, multipliers after inner solves of 10 steps or by the three stops."""
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
