"""Every choice and tolerance, in one place, with its unit and its reason."""

from dataclasses import dataclass, fields

from izo_ref.base.errors import OptionError

LAGRANGIAN = ("gradient", "jacobi", "chebyshev", "cg", "lbfgs", "newton")
SWEEPS = ("pgs", "apgs")
PRESET_METHODS = {"arcsim": "cg", "icloth": "chebyshev", "xrtailor": "gradient"}
CHOICES = {
    "selection": ("independent", "first-of-any", "all"),
    "method": ("auto", "active-set", "interior-point", *SWEEPS, *LAGRANGIAN),
    "line_search": ("exact", "backtracking", "wolfe"),
    "multiplier_update": ("every-step", "inner-solve"),
    "penalty": ("fixed", "grown"),
    "preset": (None, *PRESET_METHODS),
    "precision": ("float64", "float32"),
}

# What a scene may not need, and so is left out; `izo_ref.plan` says which apply, and why. None
# of them changes a bit of the answer, but `closed-form`, which changes its last ones.
RULES = {
    "still": "pairs of two sides that are at rest are not looked at",
    "one-box": "a part at rest is one box until something that moves gets there",
    "float32-boxes": "boxes are compared in float32; rounding keeps their order",
    "incremental": "a detection looks again only at what moved since the one before",
    "changed-zones": "a zone without new impacts keeps its solution",
    "small-launches": "what takes microseconds is not spread over threads",
    "closed-form": "a zone of one impact takes one division, not a solver",
    "float-verdicts": "exact arithmetic decides what floats cannot, and nothing else",
}


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of `resolve`.

    Attributes:
        selection: which of the impacts found enter the zones (SPEC 6): `independent`, by
            time and no free vertex twice, ends closest to the candidate positions and
            takes the most iterations; `first-of-any`, those that are the earliest for one
            of their free vertices; `all`.
        max_iterations: detections of the main loop before zones are scaled back. ARCSim
            allows 100; the steps this was developed on take 2 to 50.
        relinearize: rounds at most in which the active impacts get new normals and
            weights at the answer (SPEC 6). 0 switches it off.
        relinearize_gain: a round pays if it lowers the objective by this fraction at
            least; else it is the last.
        method: how a zone is solved; `auto` takes the closed form for one impact; block
            pivoting up to `small_zone` impacts and, where that gives up, `active-set`; for
            all others `apgs` where it is fast, else `interior-point`, and from their last
            solution on block pivoting again (`pivoting`). A GPU takes the same up to 32
            impacts, `newton` for the others, and leaves to the processor what that does not solve.
            Of the augmented Lagrangian (SPEC 3 and 4): `gradient`, `jacobi`, `chebyshev`,
            `cg`, `lbfgs`, `newton`. Sweeps over the multipliers: `pgs`, and
            accelerated, `apgs`.
        line_search: of the augmented-Lagrangian methods: `exact`, `backtracking` until
            Armijo's condition holds, `wolfe` (the strong conditions). The page's own is
            `backtracking`, so that is the default.
        multiplier_update: of the augmented-Lagrangian methods: `every-step`, as on the
            page, or after an `inner-solve`, as in ARCSim.
        penalty: mu of the augmented-Lagrangian methods: `fixed`, as in the three systems
            of SPEC 4, or `grown` when the violation does not fall enough.
        preset: a system whose parameters an augmented-Lagrangian method takes: `arcsim`,
            `icloth`, `xrtailor` (SPEC 4). It fixes method, line search, updates and
            scaling, so `method` is then `auto` or the preset's own.
        max_steps: [steps] of an augmented-Lagrangian method, or sweeps, on one zone.
            Gradient descent takes tens of thousands where rows are nearly parallel; a preset
            takes no more than its system does.
        precision: of the arrays of an augmented-Lagrangian method and of sweeps; residuals
            are float64 in either case. `float32` ends at a relative gap of about 1e-6 and a
            violation of 1e-5 to 1e-4 of the thickness, whatever the tolerances.
        small_zone: [impacts], see `method`. Block pivoting factors dense matrices of the
            active impacts, an active set takes a step for each row that block pivoting did
            not find: 0.6 and 4 ms for 256 impacts, random and redundant, where the interior
            point takes 5 and 6; 80 ms for a pile of 490, against 8.
        gap_tolerance: relative duality gap at which a zone counts as solved.
        violation_tolerance: largest violation, as a fraction of the thickness, at which a
            zone counts as solved.
        thickness_fraction: thickness if none is given, as a fraction of the median length
            of the edges at the start.
        plan: `needed`: every rule of `RULES` is applied where it can be; `everything`: none
            is; or the names of those that are. For comparing: the answer is the same.
    """

    selection: str = "independent"
    max_iterations: int = 100
    relinearize: int = 3
    relinearize_gain: float = 1e-3
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
    plan: str | tuple[str, ...] = "needed"

    def __post_init__(self):
        for name, choices in CHOICES.items():
            if getattr(self, name) not in choices:
                raise OptionError(f"{name}: expected one of {choices}, got {getattr(self, name)!r}")
        for field in fields(self):
            value = getattr(self, field.name)
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if field.name in (*CHOICES, "plan"):
                continue
            if not (is_number and value >= 0):
                raise OptionError(f"{field.name}: expected a number >= 0, got {value!r}")
        named = () if self.plan in ("needed", "everything") else self.plan
        unknown = (
            [named] if isinstance(named, str) else [rule for rule in named if rule not in RULES]
        )
        if unknown:
            raise OptionError(
                f"plan: expected 'needed', 'everything' or names of {tuple(RULES)}, "
                f"got {unknown[0]!r}"
            )
        own = PRESET_METHODS.get(self.preset)
        if own and self.method not in ("auto", own):
            raise OptionError(
                f"preset: {self.preset!r} is the method {own!r}, expected that or 'auto' as "
                f"method, got {self.method!r}"
            )
        float32_offered = own or self.method in (*LAGRANGIAN, *SWEEPS)
        if self.precision == "float32" and not float32_offered:
            raise OptionError(f"precision: the method {self.method!r} offers float64 only")

    @property
    def rules(self) -> frozenset[str]:
        """Names of the rules that are applied."""
        named = {"needed": RULES, "everything": ()}
        return frozenset(named[self.plan] if isinstance(self.plan, str) else self.plan)
