"""What was tried for speed, and what came of it: the last section of the page of speed."""

NOTES = """## What was tried

These changes helped and are in use:

* A block of queries goes down the tree as one box, and then each query is compared with the leaves
  of a block. That is 1.6 times as fast as one query at a time. Writing the comparison of eight
  boxes where it is used made it 1.5 times faster again, because a call took longer than the
  comparison.
* Large zones start from their last solution (`solvers/pivoting.py`). Solving then takes 0.55 of the
  time on armadillo-rollers, 0.59 on stack-6k, 0.63 on sheets-50k and 0.85 on sheets-10k (once each,
  one thread).
* In a fifth of the zones of cloth-ball-clean, one constraint of ten is redundant, and block
  pivoting repeated itself for ever, at several places at the same time. While all constraints on
  the wrong side changed sides and, without progress, the last one of each group that shares
  vertices, pivoting gave up on 2 of 191 zones, and 33 zones with the impacts of two rounds took
  26.7 solves. Now only the worst constraint at its vertices changes sides where the number falls by
  less than 0.4 of itself. The 33 zones take 14.9 solves.
* Constraints outside the active set are left out of the fronts of a factorisation
  (`solvers/serial/restriction.py`), where they were rows of the identity. A factorisation of the
  large zones of cloth-ball-clean takes 5.9 million operations instead of 20.9; with an order of
  elimination of its own it would take 4.2. One pattern for all constraints now does for every set,
  so no pattern is made again. Solving takes 0.6 of the time on cloth-ball-clean (once, one thread).

* A margin for each near pair (`detection/near_pairs.py`), in place of a second proof with a reach.
  All detections of stack-6k took 0.24 s instead of 0.35, those of sheets-50k 0.33 instead of 0.62,
  but those of armadillo-rollers 4.5 instead of 5.0: there, half of the pairs are found anew because
  a vertex left its reach, and most others move by as much as their margin.
* A contact ends where its cubic changes its sign while the closest points are well inside. It takes
  one to three steps instead of 6 or 7. All impacts of stack-6k then take 20 ms instead of 27, those
  of sheets-10k 15 instead of 19 (one thread). Most of them need no direction at all, which makes
  the proofs of both 0.87 of what they were.
* A root of the cubic is found by Newton's method before its hull is clipped: 0.13 us instead of
  0.19.
* A round keeps all impacts, and begins only within a budget. On armadillo-rollers it takes 20
  iterations instead of 32, the objective falls by 17 % instead of 10 %, and the second round, which
  would lower it by 4 % at the same cost, is left out: 3.6 s instead of 5.0. On cloth-ball-clean two
  rounds lower it by 10 % where three lowered it by 8 %. It became affordable when pivoting left
  inactive constraints out of its factors: the zones have twice as many impacts.
* Threads of Python share the items of a kernel, and a function that compiled code calls is compiled
  as part of its callers alone. The first demo takes 30 CPU s instead of 67, and a new process 0.6 s
  instead of 1.1. Work of less than twelve chunks stays on one thread.
* Loops in place of chains of numpy calls on short arrays (grouping, numbering, residuals, edges,
  orders of the trees, reach), four arrays in place of two records per launch, and one list of
  impacts for both kinds of pairs. A step of 404 triangles takes 2.4 ms inside a process instead of
  5.0, and `Scene` 0.85 ms instead of 1.3; steps of 10,000 to 20,000 triangles take 0.75 to 0.85 of
  the time. Twelve more functions are compiled in a first step, which costs 5 CPU s.
* A selection of its own for deep zones, where impacts are more than eight edges deep on average
  (`zones/serial/deep_selection.py`), and an aim beyond the thickness where rounding is as large as
  the tolerance. A sheet that falls by 100 m through nine others, 5 cm apart, ends free after 10
  iterations and 0.3 s. It took 18 s and ended in the fail-safe, at an objective that is 3 % higher.

These changes did not help:

* Against minimum degree, a third of the time that pivoting takes on 469 pressed balls: a quotient
  graph that begins with one element for each vertex of the mesh, in place of the list of all pairs
  of constraints that share one. It took 1.0 to 1.3 times as long, and the factors had 4 to 12 %
  more entries.
* Against a deep step: a path in five to eleven doublings (19 to 100 s on the sheet that falls by
  100 m), normals that are turned toward the motion (often faster, but the objective is 7 %
  higher where the sheet also goes sideways), `first-of-any` (57 s).
* Proofs that stop at the time at which a vertex of the pair is taken by an earlier impact. Half to
  nine tenths of the pairs have such a vertex in the first iterations, but the times are not known
  before the proofs are made. See above for the impacts that were found before.
* Both kinds of pairs, and the three trees, side by side on threads: sheets-10k and stack-6k took
  1.1 times as long, sheets-50k as long as before, because numpy's calls between kernels wait for
  Python's lock.
* Near pairs that are dropped once their margin exceeds every reach: the list is half as long on
  armadillo-rollers, and its passes take as long as they save.
* New normals for the active impacts in each iteration of the main loop, where the sides are apart
  and the normal turns little. Zones are solved two to ten times as often from far off, and
  armadillo-rollers and stack-6k end in the fail-safe.
* Against pivoting that repeats itself on cloth-ball-clean, before groups of constraints: values of
  rho from 1e-4 to 1e-10 (49, 30 and 48 of 191 zones given up, least at 1e-9); first all constraints
  with a negative multiplier leave, then all that are missing enter (46 given up); only the worse
  half of them changes (32 given up, but each step takes longer); a projected Newton method with a
  line search for descent, from the start or from the point where the wrong constraints stop getting
  fewer (more than 100 given up).
* Against the time of pivoting on large zones: 4 to 32 sweeps before it save up to 15 % of it on
  cloth-ball-clean and armadillo-rollers, and cost 10 % or more on stack-6k and the sheets. A
  pattern with fewer inactive constraints (a quarter or a tenth of the active ones instead of
  half), or only with those within 0 to 5 impacts of what is new, fills up less, but has to be
  made again more often. Fewer solves at the end with rho at 1e-9 or 1e-10 gain less than 5 %.
* The four diagonals of the cube as further directions save at most 5 % of the proofs' time, and
  only on cloth-ball-clean.
* A test without branches for shared vertices gains nothing; neither does `forceinline` for the
  small vectors.
* A reach of 0.3 of an edge, or without a bound (see `FAR_REACH` in `detection/detector.py`): more
  pairs are near, and a vertex without a bound is near everything.
* New normals for all impacts that a round keeps, and not only for the tight ones: the objective of
  armadillo-rollers is 1 % lower than without the others, where old normals make it 12 % lower.
* Rounds that keep, besides the tight impacts, those with a gap of up to 0.02, 0.1, 0.3 or 1 edge:
  after the first round armadillo-rollers is at 3.69, 3.61, 3.33 and 3.35e-5, with all impacts at
  3.28e-5. Rounds that keep the impacts that were active in one of the last two: 8 % lower than with
  the tight ones alone, instead of 12 %.
* A main loop and first rounds that end early, when an iteration adds less than 2 % of the impacts:
  stack-6k ends 0.4 to 1.8 % higher, and armadillo-rollers 2 to 4 % higher than with as many whole
  rounds, in about the same time.
* `first-of-any` in the rounds, always or once few impacts are found, saves iterations, but the
  rounds of armadillo-rollers then end above the main loop.
* Impacts that were found before come first in the selection, so that other pairs at the same
  vertices need no proof: armadillo-rollers ends 18 % higher, in more iterations.
* Further directions for pairs whose proof takes two steps (a quarter of a detection's time): the
  directions between the middles of the sides, or between the closest points at half time, settle
  10 to 25 % of those pairs.
* Compiling the helpers of a kernel at -O0 or -O1 takes 73 and 65 s instead of 63 s, because more
  work is left to the kernel.
"""
