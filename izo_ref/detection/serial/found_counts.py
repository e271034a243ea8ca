"""Places of the counts of a detection on a GPU, in an array of N_COUNTS i8.

The launches of a detection add to these counts, and the host reads them once, after the last one.
"""

N_COUNTS = 16

# Candidate pairs, also those for which there was no room, and how many are vertex-face pairs.
PAIRS, VERTEX_FACE_PAIRS = 0, 1
# Steps of all proofs, and of the longest one.
STEPS, MOST_STEPS = 2, 3
# Pairs that are not proved apart and not excluded, also those for which there was no room.
CONTACTS = 4
# Impacts that were written. It is 0 if there was no room for all pairs or contacts.
FOUND = 5
# Impacts that were left out because they are between pinned points.
BLOCKED = 6
# Contacts at t = 0, also those that were left out; exact arithmetic has to decide them.
AT_START = 7
# Vertices that end elsewhere than in the last detection that the host took (`Detector.remember`).
MOVED = 8
# Pairs that float32 does not prove apart, among those for which there was room.
OPEN = 10
# The least time of the impacts that were written, 1 if there is none: the bits of an f8.
LEAST_TOI = 9
