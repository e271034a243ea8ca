"""Parameters of the augmented-Lagrangian methods and of the presets, and where they come from.

Figures that are called measured come from `random_problem` of the tests (`tests/helpers/shapes.py`)
with 4, 16 and 64 impacts and mass ratios 1, 1e3 and 1e6, solved to a gap of 1e-9. Numbers of steps
are medians over these problems.
"""

from typing import Any, NamedTuple

import numpy as np

from izo_ref.base.arrays import Floats
from izo_ref.base.options import Options
from izo_ref.solvers.serial import descent as codes
from izo_ref.solvers.serial.line_search import BACKTRACKING, EXACT, WOLFE
from izo_ref.solvers.serial.settings import Settings

LINE_SEARCHES = {"exact": EXACT, "backtracking": BACKTRACKING, "wolfe": WOLFE}


class MethodParameters(NamedTuple):
    """A descent direction and the parameters that suit it.

    The XRTailor page gives no mu that fits all scalings. Here constraints have rows of unit length.
    So for one impact alone C C^T is 1, and the Hessian of L along its row is 1 + mu.

    Multipliers updated after every step: for one impact, steps of length 1 along the gradient are a
    linear map, which is stable only for mu < 2/3. A line search that begins at the minimum of the
    local quadratic model is stable far beyond that. Measured at 64 impacts, `gradient` takes 1,143
    steps with mu = 0.5 / |C C^T|, 293 with 2, 96 with 5 and 74 with 10. `newton` began to fail on
    some zones at 30. `gradient` at 10 and `cg` at 20 did not fail, but they took more steps on the
    smallest zones.

    Multipliers updated after inner solves: any mu is stable. A small mu makes the inner solves
    short, a large mu makes them few.
    """

    direction: int  # a code of `solvers/serial/descent.py`
    preconditioned: bool  # by the diagonal of the generalised Hessian
    begin: int  # where line searches begin, a code of `solvers/serial/descent.py`
    wolfe: float  # c_2: 0.1 and 0.9 as in Nocedal and Wright, p. 34
    mu_every_step: float  # times 1 / (bound of |C C^T|); a penalty that grows begins at a tenth
    mu_inner_solve: float
    mu_cap: float  # largest mu of a penalty that grows, after inner solves

    def penalties(self, options: Options, coupling: Floats) -> tuple[Floats, Floats]:
        """Return mu at the start and the largest mu of each zone.

        Args:
            options: The method's options.
            coupling: (n_zones,) f8, a bound of the largest eigenvalue of C C^T.

        Returns:
            Two arrays, (n_zones,) f8.
        """
        grown = options.penalty == "grown"
        if options.multiplier_update == "every-step":
            cap = self.mu_every_step / coupling
            return (0.1 * cap if grown else cap), cap
        mu = np.full(len(coupling), self.mu_inner_solve)
        return mu, (np.full(len(coupling), self.mu_cap) if grown else mu)


METHOD_PARAMETERS = {
    "gradient": MethodParameters(codes.GRADIENT, False, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    # In scaled variables the diagonal is no better than no preconditioner, and with a large mu it
    # is worse.
    "jacobi": MethodParameters(codes.JACOBI, True, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    "chebyshev": MethodParameters(codes.CHEBYSHEV, True, codes.MODEL, 0.1, 3.0, 3.0, 10.0),
    "cg": MethodParameters(codes.CG, False, codes.MODEL, 0.1, 5.0, 30.0, 1e4),
    "lbfgs": MethodParameters(codes.LBFGS, False, codes.UNIT, 0.9, 10.0, 30.0, 1e4),
    # 4 to 15 steps with mu = 1e3 on 4 to 4096 impacts. A larger mu makes the condition of the
    # linear systems noticeably worse.
    "newton": MethodParameters(codes.NEWTON, False, codes.UNIT, 0.9, 10.0, 1e3, 1e8),
}


class Preset(NamedTuple):
    """The parameters of another system (docs/method section 4)."""

    method: str
    by_total_mass: bool  # objective sum m dx^2 / sum m, instead of 1/2 mean(1/m) sum m dx^2
    mu: float
    step: float  # the first step of a line search is this ...
    step_per_vertex: float  # ... plus this for each unpinned vertex of the zone
    settings: dict[str, Any]  # fields of Settings that differ from FAITHFUL


# The table of docs/method section 4 does not say everything. These choices are ours:
# arcsim: beta is that of Dai-Yuan and Hestenes-Stiefel; c_1 = 1e-4 and c_2 = 0.1 (Nocedal and
#     Wright, p. 34); line searches begin at the minimum of the local quadratic model; eps_x and
#     eps_g are compared with Euclidean norms; eps_f is relative to the largest of |L| before the
#     step, |L| after it, and 1; the method ends if an inner solve takes no step.
# icloth: c_1, shrink and growth as in xrtailor; the first step is 1; the preconditioner is the
#     diagonal of the generalised Hessian; the acceleration comes after the move and before the
#     update of the multipliers. The acceleration begins anew (omega 1 for ten steps) if the last
#     step points uphill. Wang and Yang (2016) ask for a guard too: without one, rho = 0.9992
#     ends 1e7 m and more off on zones of 4 to 16 impacts.
# xrtailor: the nodes that the first step is multiplied by are the unpinned vertices of the zone.
# All three: a zone begins at the proposed positions with multipliers 0. The method ends if a line
# search shrinks its step to 1e-12 without the decrease that it wants.
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
PRESET_STEPS = 100  # largest number of steps of a preset


def preset_of(options: Options) -> Preset | None:
    """Return the preset that the options name, or None."""
    return None if options.preset is None else PRESETS[options.preset]


def choose_settings(options: Options, thickness: float) -> Settings:
    """Return the settings of the loop for a method, or for a preset if the options name one.

    Args:
        options: The method or the preset, and the tolerances.
        thickness: [m].
    """
    preset = preset_of(options)
    settings = _settings_of_method(preset.method if preset else options.method, options, thickness)
    if preset is None:
        return settings
    steps = min(PRESET_STEPS, settings.max_steps)
    return settings._replace(
        **{**FAITHFUL, "max_steps": steps, "inner_steps": steps, **preset.settings}
    )


def _settings_of_method(name: str, options: Options, thickness: float) -> Settings:
    """Return the settings of a method that is not a preset."""
    method = METHOD_PARAMETERS[name]
    every_step = options.multiplier_update == "every-step"
    # A penalty is looked at every ten steps, or after each inner solve: hence the two rates.
    growth = (2.0 if every_step else 10.0) if options.penalty == "grown" else 1.0
    return Settings(
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
        # Half of each tolerance. The rest is for the rounding on the way back to positions.
        gap_tolerance=0.5 * options.gap_tolerance,
        violation_m=0.5 * options.violation_tolerance * thickness,
        rounding=float(np.finfo(options.precision).eps) / 2.0,
        inner_steps=int(options.max_steps),
        inner_accuracy=0.5,  # between 0.1 and 2 the number of steps differs by less than a fifth
        eps_x=-1.0,
        eps_f=-1.0,
        eps_g=0.0,
        penalty_growth=growth,
        # With the mu of `chebyshev`, L has condition numbers k of 10 to 30, and rho is
        # (k - 1) / (k + 1).
        delay=1,
        rho=0.9,
        # Of 1e-6, 1e-4, 1e-3 and 1e-2 this was the fastest, by a quarter, on random zones of 64 to
        # 4096 impacts. 1e-2 takes twice as many steps.
        linear_tolerance=1e-4,
        linear_steps=2,
    )
