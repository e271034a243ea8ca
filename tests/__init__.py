"""Tests of izo_ref; the folders are those of the package."""

import os

# The threads of OpenMP look for work without a pause after each kernel. Where several processes
# share the cores, they take the time of the other tests, and a launch waits for them for a
# millisecond. OpenMP reads this once, when the first parallel kernel runs.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
