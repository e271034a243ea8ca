"""Cases of stage S10: the first iterations of the presets; `s10_methods.py` has the directions.

Each case ends before its error bound or a near tie makes it useless. Sources of the parameters:
docs/method section 4 and the comment above `PRESETS` of izo_ref/solvers/presets.py.
"""

from __future__ import annotations

from izo_ref.porting.cases import Case
from izo_ref.porting.generate.expected import CaseList
from izo_ref.porting.generate.iterations import ARCSIM, ICLOTH, add, plain_zone, xrtailor, zone
from izo_ref.porting.generate.s10_methods import (
    ARMIJO,
    BETA,
    INNER,
    KINK,
    MASS,
    OMEGA,
    ORDER,
    PENALTY,
    ROWS,
    SCALING,
    add_methods,
)

MASSES = (1.0, 3.0, 0.5, 2.0)  # [kg]
WIDE = (1.0, 64.0, 8.0)  # [kg]


def cases() -> list[Case]:
    """Return the cases of stage S10."""
    found = CaseList("S10")
    _add_xrtailor(found)
    _add_icloth(found)
    _add_icloth_endings(found)
    _add_arcsim(found)
    _add_arcsim_endings(found)
    add_methods(found)
    return found


def _add_xrtailor(found: CaseList) -> None:
    """Append cases of the preset `xrtailor`."""
    plain = plain_zone()
    heavy = plain_zone(masses=(8.0, 1.0, 1.0, 1.0))
    word = "xrtailor"
    what = "One vertex below one face, all of 1 kg: the second step overshoots."
    flags = f"{ORDER} {SCALING} {ARMIJO}"
    add(found, word, flags, "easy", what, 4, plain, xrtailor(plain))
    what = "The vertex has 8 kg, so its share of the motion is small."
    flags = f"{MASS} {SCALING} {PENALTY}"
    add(found, word, flags, "easy", what, 4, heavy, xrtailor(heavy))
    shared = zone(0, 3, 7, masses=MASSES, apart=(1,))
    what = "Three impacts share vertices; one is inactive; two searches shrink the step for good."
    flags = f"{ARMIJO} {MASS} {SCALING} {KINK}"
    add(found, word, flags, "medium", what, 8, shared, xrtailor(shared))
    pinned = zone(1, 3, 7, masses=MASSES, apart=(1,), pinned=(2,))
    what = "A pinned vertex: the first step is 1e-3 times the number of unpinned vertices."
    flags = f"{SCALING} {ARMIJO}"
    add(found, word, flags, "medium", what, 12, pinned, xrtailor(pinned))
    many = zone(1, 6, 10, masses=WIDE)
    what = "Six impacts with masses from 1 to 64 kg: the vertices drift back while l decays."
    flags = f"{SCALING} {MASS} {ORDER}"
    add(found, word, flags, "hard", what, 16, many, xrtailor(many))


def _add_icloth(found: CaseList) -> None:
    """Append cases of the preset `icloth`."""
    word, two = "icloth", zone(0, 2, 6, masses=MASSES)
    what = "One vertex below one face: searches begin at the last step, and it goes uphill once."
    flags = f"{ORDER} {SCALING} {PENALTY}"
    add(found, word, flags, "easy", what, 4, plain_zone(), ICLOTH)
    what = "Two impacts and four different masses; the acceleration has not begun yet."
    flags = f"{SCALING} {MASS} {ARMIJO} {OMEGA}"
    add(found, word, flags, "medium", what, 8, two, ICLOTH)
    what = "A pinned vertex and an inactive impact, which does not count in the diagonal."
    flags = f"{ROWS} {KINK} {SCALING}"
    pinned = zone(2, 3, 7, masses=MASSES, apart=(1,), pinned=(2,))
    add(found, word, flags, "medium", what, 8, pinned, ICLOTH)
    what = "It goes uphill at step 7, so omega differs from 1 from step 17 on, not from step 10 on."
    late = zone(6, 2, 6, masses=MASSES)
    add(found, word, f"{OMEGA} {ORDER}", "hard", what, 19, late, ICLOTH)
    what = "One impact: the acceleration begins at step 14, ten steps after the last restart."
    add(found, word, OMEGA, "hard", what, 18, zone(5, 1, 4, masses=MASSES), ICLOTH)


def _add_icloth_endings(found: CaseList) -> None:
    """Append cases in which a line search of `icloth` fails, which ends the method."""
    shorter = {**ICLOTH, "smallest_step": 2.0**-6}
    what = "A search reaches the smallest step after nine steps: the method ends there."
    three = zone(3, 3, 7, masses=MASSES)
    add(found, "icloth", f"{ARMIJO} {SCALING}", "hard", what, 16, three, shorter)


def _add_arcsim(found: CaseList) -> None:
    """Append cases of the preset `arcsim`."""
    word = "arcsim"
    what = "Equal masses: one step minimises L, so each inner solve has one step."
    flags = f"{INNER} {ORDER} {SCALING}"
    add(found, word, flags, "easy", what, 2, plain_zone(), ARCSIM)
    what = "Different masses: the second direction is conjugate to the first one."
    flags = f"{BETA} {MASS} {SCALING}"
    add(found, word, flags, "easy", what, 2, plain_zone(masses=(1.0, 2.0, 4.0, 1.0)), ARCSIM)
    what = "Three impacts share vertices; the active set changes along the first lines."
    flags = f"{BETA} {SCALING} {KINK}"
    three = zone(1, 3, 7, masses=MASSES)
    add(found, word, flags, "medium", what, 6, three, ARCSIM)
    what = "A pinned vertex and an inactive impact."
    flags = f"{BETA} {MASS} {KINK}"
    pinned = zone(3, 3, 7, masses=MASSES, apart=(1,), pinned=(2,))
    add(found, word, flags, "medium", what, 6, pinned, ARCSIM)
    what = "The same loop with a penalty of 16, which float32 can follow."
    gentle = {**ARCSIM, "penalty": 16.0}
    other = zone(3, 3, 7, masses=MASSES, apart=(1,))
    add(found, word, f"{BETA} {PENALTY} {KINK}", "medium", what, 6, other, gentle)
    what = "The first inner solve ends after ten steps; then the multipliers and p begin anew."
    flags = f"{INNER} {BETA} {PENALTY}"
    add(found, word, flags, "hard", what, 13, zone(2, 3, 7, masses=MASSES), ARCSIM)


def _add_arcsim_endings(found: CaseList) -> None:
    """Append cases in which inner solves of `arcsim` end before ten steps."""
    what = "Inner solves of five, two and one steps: they end at a short step or a small gradient."
    add(found, "arcsim", INNER, "hard", what, 9, zone(3, 2, 8), ARCSIM)
    what = "The fourth inner solve finds a gradient below eps_g and takes no step: the method ends."
    add(found, "arcsim", f"{INNER} {ORDER}", "hard", what, 20, plain_zone(), ARCSIM)
    short = {**ARCSIM, "penalty": 16.0, "eps_f": 2.0**-4}
    what = "Inner solves end because L, which is below 1, decreases by at most eps_f."
    add(found, "arcsim", INNER, "hard", what, 8, zone(1, 3, 7, masses=MASSES), short)
    what = "The lengths of steps and of gradients decide, and not their largest entries."
    rough = {**ARCSIM, "penalty": 64.0, "eps_f": 2.0**-40, "eps_x": 2.0**-6, "eps_g": 2.0**-3}
    add(found, "arcsim", INNER, "hard", what, 8, zone(3, 3, 7, masses=MASSES), rough)
