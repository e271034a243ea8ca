"""Every choice and tolerance in one place, with its unit and its reason."""

from __future__ import annotations

import math
import sys
from collections.abc import Set
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from izo_ref.base.errors import OptionError
from izo_ref.base.values import real_number, shown

LAGRANGIAN = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
SWEEPS = ("pgs", "apgs")
PRESET_METHODS = {"arcsim": "cg", "icloth": "chebyshev", "xrtailor": "gradient"}
NUMBERS = (int, float, np.integer, np.floating)
MOST = 2**53  # of a count; up to there every whole number is a float, and kernels can add to it
CHOICES = {
    "selection": ("independent", "first-of-any", "all"),
    "method": ("auto", "active-set", "interior-point", *SWEEPS, *LAGRANGIAN),
    "line_search": ("exact", "backtracking", "wolfe"),
    "multiplier_update": ("every-step", "inner-solve"),
    "penalty": ("fixed", "grown"),
    "preset": (None, *PRESET_METHODS),
    "precision": ("float64", "float32"),
}

# Rules that leave out work which a scene does not need. `izo_ref.plan` says which of them apply to
# a scene, and why. `closed-form` changes the last digits of the answer, and `float-verdicts` those
# of the times of meetings on a path that is not free; the others change no bit.
RULES = {
    "still": "pairs whose two sides are at rest are not checked",
    "one-box": "a component at rest is one box until something that moves reaches the box",
    "float32-boxes": "boxes are compared in float32; rounding to float32 keeps their order",
    "incremental": "a detection rechecks only what moved since the previous detection",
    "changed-zones": "a zone without new impacts keeps its solution",
    "small-launches": "work of a few microseconds runs on one thread",
    "closed-form": "a zone of one impact is solved by one division instead of a solver",
    "float-verdicts": "exact arithmetic decides only the pairs that floats cannot decide",
}


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of `resolve`.

    Attributes:
        selection: Which of the impacts found enter the zones (docs/method section 6).
            `independent` takes impacts in the order of their times, and none that shares an
            unpinned vertex with one taken before. `first-of-any` takes an impact if it is the
            earliest for at least one of its unpinned vertices. `all` takes all. `independent` is
            the default because it ends closest to the proposed positions; it takes the most
            iterations. Where impacts are far deeper than edges are long, `independent` holds whole
            surfaces at once.
        max_iterations: Largest number of detections of the main loop before zones are scaled back.
            ARCSim allows 100; the steps on which this was developed take 2 to 50.
        relinearize: Largest number of rounds in which the tight impacts get new normals and
            weights at the answer (docs/method section 6). 0 switches these rounds off.
        relinearize_gain: Smallest fraction by which a round has to lower the objective to be
            followed by another round.
        relinearize_budget: A round begins only if the rounds before it did no more work than this
            fraction of that of the main loop, or little work in all. Work is counted in vertices
            that moved and impacts that were found. In deep contact, later rounds gain less than the
            first one at the same cost: 4 instead of 17 % of the objective on armadillo-rollers.
        method: How a zone is solved. `auto` uses the closed form for one impact. It uses block
            pivoting for zones of up to `small_zone` impacts, and `active-set` where block pivoting
            gives up. For larger zones it uses `apgs` where that is fast, else `interior-point`,
            whose answer is moved onto its active constraints; once such a zone has a solution,
            block pivoting continues from it (`solvers/pivoting.py`). A GPU uses block pivoting for
            zones of all sizes, and leaves to the CPU what that does not solve.
            Augmented-Lagrangian methods (docs/method sections 3 and 4) are `gradient`, `jacobi`,
            `chebyshev`, `cg`, `lbfgs` and `newton`. Sweeps over the multipliers are `pgs` and the
            accelerated `apgs`.
        line_search: Line search of the augmented-Lagrangian methods: `exact`, `backtracking`
            (until Armijo's condition holds) or `wolfe` (until the strong Wolfe conditions hold).
            The default is `backtracking`, because the page uses it.
        multiplier_update: When the augmented-Lagrangian methods update the multipliers:
            `every-step`, as on the page, or after each `inner-solve`, as in ARCSim.
        penalty: Penalty mu of the augmented-Lagrangian methods: `fixed`, as in the three systems
            of docs/method section 4, or `grown` whenever the violation does not fall enough.
        preset: System whose parameters an augmented-Lagrangian method takes: `arcsim`, `icloth`
            or `xrtailor` (docs/method section 4), or None. A preset fixes method, line search,
            updates and scaling; `method` is then `auto` or the preset's own.
        max_steps: Largest number of steps of an augmented-Lagrangian method, or of sweeps, on one
            zone. Gradient descent takes tens of thousands of steps where constraints are nearly
            parallel. A preset takes no more steps than its system does.
        precision: Precision of the arrays of the augmented-Lagrangian methods and of sweeps,
            `float64` or `float32`. Residuals are computed in float64 in either case. With
            `float32` the solvers end at a relative gap of about 1e-6 and a violation of 1e-5 to
            1e-4 of the thickness, whatever the tolerances are.
        small_zone: Largest number of impacts of a zone that `method` `auto` solves by block
            pivoting. Block pivoting factors dense matrices of the active impacts, and the active
            set takes one step for each constraint that block pivoting did not find. For 256
            impacts they take 0.6 ms (random impacts) and 4 ms (redundant impacts), where the
            interior point takes 5 ms and 6 ms. For a pile of 490 impacts they take 80 ms, where
            the interior point takes 8 ms.
        gap_tolerance: Largest relative duality gap at which a zone counts as solved.
        violation_tolerance: Largest violation, as a fraction of the thickness, at which a zone
            counts as solved.
        thickness_fraction: Thickness as a fraction of the median edge length at the start, used
            if no thickness is given.
        max_seconds: Time after which `resolve` gives up what it is doing and returns a certified
            result [s]; None if it may take as long as it needs, because most callers want the best
            answer. A result that was cut short is `FREE_BY_FALLBACK` and says why in `reason`
            (docs/method section 7). It comes within 1.5 times the limit if the limit is above a
            second. The limit counts the wall time of `resolve`, with the time that compiling takes
            on the first run, which cannot be cut: `izo cache fill` compiles beforehand.
        plan: Which of the rules of `RULES` are applied where they can be: `needed` is all of
            them, `everything` is none of them, and a tuple names some of them. This is for
            comparisons: the answer is the same, except for the last digits with `closed-form`. On a
            path that is not free, `float-verdicts` changes the last digits of `time_free` too.
    """

    selection: str = "independent"
    max_iterations: int = 100
    relinearize: int = 5
    relinearize_gain: float = 1e-3
    relinearize_budget: float = 0.4
    method: str = "auto"
    line_search: str = "backtracking"
    multiplier_update: str = "every-step"
    penalty: str = "fixed"
    preset: str | None = None
    max_steps: int = 100_000
    precision: str = "float64"
    small_zone: int = 256
    gap_tolerance: float = 1e-9
    violation_tolerance: float = 1e-9
    thickness_fraction: float = 1e-3
    max_seconds: float | None = None
    plan: str | tuple[str, ...] = "needed"

    def __post_init__(self) -> None:
        """Check each value, and the combinations.

        Raises:
            OptionError: A value is not offered, or two values exclude each other.
        """
        self._check_choices()
        self._check_numbers()
        self._check_max_seconds()
        self._check_plan()
        self._check_combinations()

    def _check_choices(self) -> None:
        for name, choices in CHOICES.items():
            value = getattr(self, name)
            if not (value is None or isinstance(value, str)) or value not in choices:
                raise OptionError(f"{name}: expected one of {choices}, got {shown(value)}")

    def _check_numbers(self) -> None:
        for field in fields(self):
            if field.name in (*CHOICES, "plan", "max_seconds"):
                continue
            value, whole = getattr(self, field.name), isinstance(field.default, int)
            number = real_number(value) if isinstance(value, NUMBERS) else None
            low, high, words = _range_of(field.name, whole)
            if number is None or not low <= number <= high or (whole and not number.is_integer()):
                raise OptionError(f"{field.name}: expected {words}, got {shown(value)}")
            # as Python's own types, because numba compiles anew for others; the class is frozen
            object.__setattr__(self, field.name, int(number) if whole else number)

    def _check_max_seconds(self) -> None:
        value = self.max_seconds
        if value is None:
            return
        number = real_number(value) if isinstance(value, NUMBERS) else None
        if number is None or not 0.0 < number < float("inf"):
            raise OptionError(
                f"max_seconds: expected None or a finite number > 0, got {shown(value)}"
            )
        object.__setattr__(self, "max_seconds", number)  # the class is frozen

    def _check_plan(self) -> None:
        if isinstance(self.plan, str) and self.plan in ("needed", "everything"):
            return
        unknown = [self.plan]
        if isinstance(self.plan, (tuple, list, Set)):
            unknown = [rule for rule in self.plan if not isinstance(rule, str) or rule not in RULES]
        if unknown:
            raise OptionError(
                f"plan: expected 'needed', 'everything', or a tuple with names of {tuple(RULES)}, "
                f"got {shown(unknown[0])}"
            )
        object.__setattr__(self, "plan", tuple(self.plan))  # the class is frozen

    @property
    def is_default_method(self) -> bool:
        """Whether no method and no preset is named: a GPU then solves zones by block pivoting."""
        return self.method == "auto" and self.preset is None

    def _check_combinations(self) -> None:
        own = None if self.preset is None else PRESET_METHODS[self.preset]
        if own and self.method not in ("auto", own):
            raise OptionError(
                f"preset: {self.preset!r} is the method {own!r}; expected 'auto' or {own!r} as "
                f"method, got {self.method!r}"
            )
        float32_offered = own or self.method in (*LAGRANGIAN, *SWEEPS)
        if self.precision == "float32" and not float32_offered:
            raise OptionError(
                f"precision: the method {self.method!r} offers float64 only; for float32, choose "
                f"one of {(*SWEEPS, *LAGRANGIAN)} as method"
            )

    @cached_property
    def rules(self) -> frozenset[str]:
        """Names of the rules that are applied."""
        named = {"needed": RULES, "everything": ()}
        return frozenset(named[self.plan] if isinstance(self.plan, str) else self.plan)


def _range_of(name: str, whole: bool) -> tuple[float, float, str]:
    """Return the least and the largest value of an option, and what a message says of them."""
    if whole:
        return 0, MOST, f"a whole number from 0 to {MOST}"
    if name == "relinearize_budget":
        return 0.0, math.inf, "a number >= 0, which may be infinite"
    if name == "thickness_fraction":
        return math.ulp(0.0), sys.float_info.max, "a finite number > 0"
    return 0.0, sys.float_info.max, "a finite number >= 0"


DEFAULTS = Options()  # checking them takes 1 % of a step of 400 triangles
