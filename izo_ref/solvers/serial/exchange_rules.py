"""Numbers of block pivoting with rho, for one thread and for a thread group."""

# Rows of C have unit length. In fifteen zones of cloth-ball-clean and armadillo-rollers, the
# squared singular values of the active rows are below 1e-14 (redundant) or above 1e-3, and rho
# belongs in between. With this rho, the multipliers u gain five digits each time v, the earlier u,
# is set to them. If redundant constraints disagree, one of them gets u < 0 and leaves F in the next
# step. With 1e-6 some zones took more than 30 solves until such a constraint left.
RHO = 1e-8
# Fraction of the tolerances to reach: a digit more takes one more solve.
TOLERATED_SLOP = 1e-2
# Rounding can keep the residuals above TOLERATED_SLOP. Below this fraction of the tolerances, a
# zone counts as solved if the last solve did not at least halve them.
STALLED_SLOP = 0.5
# Measured on 71 zones of cloth-ball-clean, armadillo-rollers, stack-6k and sheets-50k, 33 of them
# with the impacts of two rounds: these took 26.7 solves on average while all constraints on the
# wrong side changed sides up to a new minimum, and 14.9 with these numbers. With FALLS = 0.4 to 0.8
# they took 14.9 to 18.4, with PATIENCE = 3 to 10 they took 14.9 to 15.4.
FALLS, PATIENCE = 0.6, 6
# All but one of the 71 zones took at most 40 solves.
MAX_STEPS = 40
