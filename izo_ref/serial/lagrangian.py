"""Augmented Lagrangian of one zone, minimised by gradient descent, as the page has it.

    L(x) = sum_i kappa_i |x_i - y_i|^2 + mu/2 sum_j max(c_j + l_j / mu, 0)^2
           - sum_j l_j^2 / (2 mu),    c_j = b_j - N_j . sum_k a_jk x_jk

One loop: gradient; step size by backtracking until the Armijo condition holds; move;
multipliers l_j <- max(l_j + mu c_j, 0). The caller chooses the variables: positions in
metres, or those of SPEC 5.

Source: XRTailor documentation, "Impact Zone Optimization", eqs. 1 to 11 and 18, figure
`algorithm_cpu`; eq. 9 with the slack eliminated (clamped), as it is meant.
"""

from typing import NamedTuple

import numpy as np

from izo_ref._jit import compiled

# A gradient of the length of this times the largest |b - A y| is rounding: 2^-53 for each
# of some ten operations on numbers of that size.
ROUNDING = 1e-15


class Descent(NamedTuple):
    """Parameters of the loop."""

    armijo: float  # c_1: fraction of the predicted decrease that has to be reached
    shrink: float  # a step too long is multiplied by this
    grow: float  # each search begins at the last step times this
    smallest_step: float  # the loop ends when the step falls below
    max_iterations: int
    tolerance: float  # ends when the largest entry of the gradient and of min(-c, l / mu)
    # falls below, relative to the largest |b - A y|; 0: never


@compiled
def constraint(j, nodes, coefficients, normals, rhs, unknowns):
    """c_j = b_j - N_j . sum_k a_jk x_jk, positive where violated."""
    value = rhs[j]
    for k in range(4):
        if nodes[j, k] >= 0:
            for axis in range(3):
                value -= coefficients[j, k] * normals[j, axis] * unknowns[nodes[j, k], axis]
    return value


@compiled
def lagrangian_change(
    first_impact,
    last_impact,
    first_vertex,
    last_vertex,
    nodes,
    coefficients,
    normals,
    rhs,
    curvatures,
    centres,
    mu,
    unknowns,
    multipliers,
    gradient,
    step,
):
    """L(x - step * gradient) - L(x) (page eq. 11), term by term.

    The difference of two values of L loses a gradient below the square root of rounding;
    the sum of the terms' differences does not.
    """
    change = 0.0
    for i in range(first_vertex, last_vertex):
        for axis in range(3):
            move = -step * gradient[i - first_vertex, axis]
            offset = unknowns[i, axis] - centres[i, axis]
            change += curvatures[i] * move * (2.0 * offset + move)
    for j in range(first_impact, last_impact):
        c = constraint(j, nodes, coefficients, normals, rhs, unknowns)
        rise = 0.0
        for k in range(4):
            if nodes[j, k] >= 0:
                for axis in range(3):
                    slope = coefficients[j, k] * normals[j, axis]
                    rise += step * slope * gradient[nodes[j, k] - first_vertex, axis]
        before = max(c + multipliers[j] / mu, 0.0)
        after = max(c + rise + multipliers[j] / mu, 0.0)
        # while both are positive their difference is `rise`, with nothing cancelled
        difference = rise if before > 0.0 and after > 0.0 else after - before
        change += 0.5 * mu * difference * (after + before)
    return change


@compiled
def lagrangian_gradient(
    first_impact,
    last_impact,
    first_vertex,
    last_vertex,
    nodes,
    coefficients,
    normals,
    rhs,
    curvatures,
    centres,
    mu,
    unknowns,
    multipliers,
    gradient_out,
):
    """dL/dx of the zone's unknowns; returns its largest entry."""
    for i in range(first_vertex, last_vertex):
        for axis in range(3):
            offset = unknowns[i, axis] - centres[i, axis]
            gradient_out[i - first_vertex, axis] = 2.0 * curvatures[i] * offset
    for j in range(first_impact, last_impact):
        c = constraint(j, nodes, coefficients, normals, rhs, unknowns)
        push = max(multipliers[j] + mu * c, 0.0)
        for k in range(4):
            if nodes[j, k] >= 0:
                for axis in range(3):
                    pull = push * coefficients[j, k] * normals[j, axis]
                    gradient_out[nodes[j, k] - first_vertex, axis] -= pull
    largest = 0.0
    for i in range(last_vertex - first_vertex):
        for axis in range(3):
            largest = max(largest, abs(gradient_out[i, axis]))
    return largest


@compiled
def lagrangian_descent(
    first_impact,
    last_impact,
    first_vertex,
    last_vertex,
    nodes,
    coefficients,
    normals,
    rhs,
    curvatures,
    centres,
    mu,
    first_step,
    parameters,
    unknowns_out,
    multipliers_out,
):
    """Run the loop on one zone from its centres; returns the number of iterations."""
    gradient = np.zeros((last_vertex - first_vertex, 3))
    scale = 0.0
    for i in range(first_vertex, last_vertex):
        for axis in range(3):
            unknowns_out[i, axis] = centres[i, axis]
    for j in range(first_impact, last_impact):
        multipliers_out[j] = 0.0
        scale = max(scale, abs(constraint(j, nodes, coefficients, normals, rhs, centres)))
    step = first_step
    for iteration in range(parameters.max_iterations):
        zone = (first_impact, last_impact, first_vertex, last_vertex)
        data = (nodes, coefficients, normals, rhs, curvatures, centres, mu)
        largest = lagrangian_gradient(*zone, *data, unknowns_out, multipliers_out, gradient)
        if largest <= parameters.tolerance * scale:
            worst = 0.0
            for j in range(first_impact, last_impact):
                c = constraint(j, nodes, coefficients, normals, rhs, unknowns_out)
                worst = max(worst, abs(min(-c, multipliers_out[j] / mu)))
            if worst <= parameters.tolerance * scale:
                return iteration
        norm_sq = 0.0
        for i in range(last_vertex - first_vertex):
            for axis in range(3):
                norm_sq += gradient[i, axis] ** 2
        step *= parameters.grow
        # At the minimiser of L, to rounding, no step satisfies the strict inequality of
        # eq. 18: the multipliers still have their turn.
        at_minimum = norm_sq <= (ROUNDING * scale) ** 2
        while not at_minimum and step >= parameters.smallest_step:
            change = lagrangian_change(*zone, *data, unknowns_out, multipliers_out, gradient, step)
            if change < -parameters.armijo * step * norm_sq:
                break
            step *= parameters.shrink
        if step < parameters.smallest_step:
            return iteration
        if not at_minimum:
            for i in range(first_vertex, last_vertex):
                for axis in range(3):
                    unknowns_out[i, axis] -= step * gradient[i - first_vertex, axis]
        for j in range(first_impact, last_impact):
            c = constraint(j, nodes, coefficients, normals, rhs, unknowns_out)
            multipliers_out[j] = max(multipliers_out[j] + mu * c, 0.0)
    return parameters.max_iterations
