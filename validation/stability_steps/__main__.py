"""Draw a case into a step file, or judge the claims about a step file.

    python -m validation.stability_steps draw FAMILY KIND SEED NUMBER OUT.npz
    python -m validation.stability_steps judge STEP.npz

`judge` ends with the exit code 1 if a claim of a result is not true.
"""

import sys
from collections.abc import Sequence

from izo_ref.app.process import run_and_exit
from validation.stability_steps.case import load_case
from validation.stability_steps.draw import draw
from validation.stability_steps.run import run_case


def main(words: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code.

    Args:
        words: Words of the command line; None takes those of this process.
    """
    words = sys.argv[1:] if words is None else words
    if len(words) == 6 and words[0] == "draw":
        draw(words[1], words[2], int(words[3]), int(words[4])).save(words[5])
        return 0
    if len(words) != 2 or words[0] != "judge":
        print(__doc__, file=sys.stderr)
        return 2
    outcome = run_case(load_case(words[1]))
    print(*outcome.statuses, *outcome.violations, sep="\n")
    return 1 if outcome.violations else 0


if __name__ == "__main__":
    run_and_exit(main)
