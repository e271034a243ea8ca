"""Make the vectors of one stage, with the functions of `izo vectors make`, in a tenth of its time.

python -m validation.machine.small_vectors FOLDER
"""

import sys
from pathlib import Path

from izo_ref.app.process import run_and_exit
from izo_ref.porting.generate.build import contents, generated_cases, write_folder

STAGE = "S9"


def main() -> int:
    """Make the vectors, and write them into the folder."""
    write_folder(contents(generated_cases([STAGE])), Path(sys.argv[1]))
    return 0


if __name__ == "__main__":
    run_and_exit(main, "small_vectors")
