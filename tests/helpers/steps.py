"""The larger step files, and the seed of all random tests."""

import os

from validation.study import steps

DATA = steps.FOLDER
load, load_step, load_zone, peers = steps.load, steps.load_step, steps.load_zone, steps.peers
SEED = int(os.environ.get("IZO_SEED", "20240607"))
