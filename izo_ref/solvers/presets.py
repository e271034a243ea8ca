"""Parameters of the augmented-Lagrangian methods and of the presets, and where they are from.

Measured: on `random_problem` of the tests with 4, 16 and 64 impacts and mass ratios 1, 1e3
and 1e6, to a gap of 1e-9; "steps" are medians there.
"""

from typing import NamedTuple

import numpy as np

from izo_ref.base.options import Options
from izo_ref.solvers.serial import descent as codes
from izo_ref.solvers.serial.descent import Settings
from izo_ref.solvers.serial.line_search import BACKTRACKING, EXACT, WOLFE

LINE_SEARCHES = {"exact": EXACT, "backtracking": BACKTRACKING, "wolfe": WOLFE}


class MethodParameters(NamedTuple):
    """A direction and what suits it.

    The page gives mu no value that fits all scalings. Rows have unit length here, so one
    impact alone has C C^T = 1 and L the Hessian 1 + mu along its row.

    With updates after every step, a step of 1 along the gradient and one impact are a linear
    map that is stable for mu < 2/3 only; a search that begins at the minimum of the local
    quadratic model is stable far beyond. Steps of `gradient` at 64 impacts: 1,143 with 0.5
    over |C C^T|, 293 with 2, 96 with 5, 74 with 10. Zones began to fail with `newton` at 30;
    `gradient` had not at 10 nor `cg` at 20, but took more steps on the smallest zones.

    After inner solves any mu is stable: a small one makes them short, a large one makes few.
    """

    direction: int
    preconditioned: bool
    begin: int  # where line searches begin
    wolfe: float  # c_2: 0.1 and 0.9 as in Nocedal and Wright, p. 34
    mu_every_step: float  # over a bound of |C C^T|; a penalty that grows begins at a tenth
    mu_inner_solve: float
    mu_cap: float  # of one that grows, after inner solves

    def penalties(self, options: Options, coupling):
        """(mu, largest mu) of each zone."""
        grown = options.penalty == "grown"
        if options.multiplier_update == "every-step":
            cap = self.mu_every_step / coupling
            return (0.1 * cap if grown else cap), cap
        mu = np.full(len(coupling), self.mu_inner_solve)
        return mu, (np.full(len(coupling), self.mu_cap) if grown else mu)


METHOD_PARAMETERS = {
    "gradient": MethodParameters(codes.GRADIENT, False, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    # the diagonal is no better than none in scaled variables, and worse with a large mu
    "jacobi": MethodParameters(codes.JACOBI, True, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    "chebyshev": MethodParameters(codes.CHEBYSHEV, True, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    "cg": MethodParameters(codes.CG, False, codes.MODEL, 0.1, 5.0, 30.0, 1e4),
    "lbfgs": MethodParameters(codes.LBFGS, False, codes.UNIT, 0.9, 10.0, 30.0, 1e4),
    # 4 to 15 steps with 1e3 on 4 to 4096 impacts; a larger mu is felt by the linear systems
    "newton": MethodParameters(codes.NEWTON, False, codes.UNIT, 0.9, 10.0, 1e3, 1e8),
}


# For zones that one thread is too slow for: of the methods here the one that comes to 1e-9 on all
# families but one (reports/inner.html), in 4 to 88 steps.
GPU_METHOD = {
    "method": "newton",
    "line_search": "exact",
    "multiplier_update": "inner-solve",
    "penalty": "grown",
    "max_steps": 200,
}


class Preset(NamedTuple):
    """The parameters of another system (SPEC 4)."""

    method: str
    by_total_mass: bool  # objective sum m dx^2 / sum m, not 1/2 mean(1/m) sum m dx^2
    mu: float
    step: float  # first step, and
    step_per_vertex: float  # times the unpinned vertices, more
    settings: dict


# Where the table of SPEC 4 is silent, chosen here:
# arcsim: beta of Dai-Yuan and Hestenes-Stiefel, c_1 = 1e-4 and c_2 = 0.1 (Nocedal and Wright,
#     p. 34), searches that begin at the minimum of the local quadratic model, the norms of
#     eps_x and eps_g Euclidean, eps_f relative to the largest of |L| before, |L| after and 1,
#     and an end where an inner solve takes no step.
# icloth: c_1, shrink and growth as in xrtailor, first step 1, the preconditioner the diagonal
#     of the generalised Hessian, acceleration after the move and before the multipliers. It
#     begins anew (omega 1 for ten steps) where the last step points uphill: without a guard,
#     which [4] wants too, rho = 0.9992 ends 1e7 m and more off on zones of 4 to 16 impacts.
# xrtailor: nodes are the unpinned vertices of the zone.
# All: zones begin at the candidate positions with multipliers 0; a search that comes to
# 1e-12 without the decrease it wants is the last.
FAITHFUL = {
    "line_search": BACKTRACKING,
    "every_step": True,
    "faithful": True,
    "penalty_growth": 1.0,
    "smallest_step": 1e-12,
}
_ARCSIM = {
    "line_search": WOLFE,
    "every_step": False,
    "begin": codes.MODEL,
    "armijo": 1e-4,
    "wolfe": 0.1,
    "inner_steps": 10,
    "eps_x": 1e-6,
    "eps_f": 1e-12,
    "eps_g": 1e-6,
}
_XRTAILOR = {"begin": codes.LAST, "armijo": 0.5, "shrink": 0.7, "grow": 1.0}
_ICLOTH = {**_XRTAILOR, "delay": 10, "rho": 0.9992}
PRESETS = {
    "arcsim": Preset("cg", False, 1e3, 1.0, 0.0, _ARCSIM),
    "icloth": Preset("chebyshev", True, 1e3, 1.0, 0.0, _ICLOTH),
    "xrtailor": Preset("gradient", False, 1e3, 0.0, 1e-3, _XRTAILOR),
}
PRESET_STEPS = 100


def choose_settings(options: Options, thickness: float) -> Settings:
    """Settings of the loop: those of the method, or of the preset where there is one."""
    preset = PRESETS.get(options.preset)
    method = METHOD_PARAMETERS[preset.method if preset else options.method]
    every_step = options.multiplier_update == "every-step"
    # looked at every ten steps or after inner solves, hence the two rates
    growth = (2.0 if every_step else 10.0) if options.penalty == "grown" else 1.0
    settings = Settings(
        direction=method.direction,
        line_search=LINE_SEARCHES[options.line_search],
        every_step=every_step,
        preconditioned=method.preconditioned,
        begin=method.begin,
        armijo=1e-4,
        wolfe=method.wolfe,
        shrink=0.5,
        grow=2.0,
        smallest_step=1e-12,
        faithful=False,
        max_steps=int(options.max_steps),
        # half: rounding on the way back to positions has its part
        gap_tolerance=0.5 * options.gap_tolerance,
        violation_m=0.5 * options.violation_tolerance * thickness,
        rounding=float(np.finfo(options.precision).eps) / 2.0,
        inner_steps=int(options.max_steps),
        inner_accuracy=0.5,  # from 0.1 to 2 the steps differ by less than a fifth
        eps_x=-1.0,
        eps_f=-1.0,
        eps_g=0.0,
        penalty_growth=growth,
        # L has condition numbers of 10 to 30 with the mu of `chebyshev`: (k - 1) / (k + 1)
        delay=1,
        rho=0.9,
        # of 1e-6, 1e-4, 1e-3 and 1e-2 the fastest on random zones of 64 to 4096 impacts, by a
        # quarter; 1e-2 takes twice as many steps
        linear_tolerance=1e-4,
        linear_steps=2,
    )
    if preset is None:
        return settings
    steps = min(PRESET_STEPS, settings.max_steps)
    return settings._replace(
        **{**FAITHFUL, "max_steps": steps, "inner_steps": steps, **preset.settings}
    )
