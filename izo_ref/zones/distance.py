"""How far a zone's answer is from the optimum, at most: a bound that holds with rounding.

In scaled variables the zone is: minimise 1/2 |z|^2 subject to C z >= s, rows of unit
length. The objective is strongly convex with modulus 1, so for a z that satisfies all rows
and any l >= 0

    |z - z*|^2 <= 2 gap = |z - C^T l|^2 + 2 l . (C z - s).                            (1)

Two things stand between this and a bound for what a solver returns. It satisfies its rows
to rounding only; and where a row that pushes is off by e, (1) is sqrt(2 l e), far more than
the true distance, which is about e. So z is first moved onto the rows J that are active:

* If the rows of J are independent, with sigma their smallest singular value, there is a
  point w away with C_J (z - w) = s_J exactly; what is left of the residual after computing
  w in floats, and its rounding, is covered by (residual + rounding) / sigma more. If that
  point satisfies the other rows, (1) there has no second term for an l on J alone:
      |z - z*| <= |w| + |z - w - C^T l|.
  Near the optimum the two parts are the distances across and along the active rows, which
  are orthogonal, so the bound is at most sqrt 2 of the true distance, plus rounding.
* Otherwise z is moved by a step along which all rows of J open, so far that every row holds
  in spite of rounding, and (1) is taken there. That costs the square root of the rounding:
  some 2e-7 of |z*| is the least it can say, and more where rows of J are nearly opposed.

The smaller of both holds; infinity if neither can be had. Equal impacts count as one row.

Source: SPEC section 8; S. Boyd, L. Vandenberghe, Convex Optimization (2004), 9.1.2.
"""

import math

import numpy as np

U = 2.0**-53
# Rows up to which singular values are computed: 0.2 s for this many, on 2 cores.
DENSE_ROWS = 1024
# How often rows that turn out to be active are added.
ROUNDS = 8


def distance_bound(problem, positions, multipliers, displacements=None) -> float:
    """At least the mass-weighted distance of positions to the optimum of a zone.

    Args:
        problem: `ZoneProblem`.
        positions: (n, 3) [m], whoever computed them.
        multipliers: (n_impacts,) [kg], of 1/2 sum m |x - y|^2; they need not be good, nor
            come from a solver: they say which rows to take for active.
        displacements: (n, 3) [m], from the proposed positions, if they are known more exactly than
            positions can say; the bound is then for them, whatever the positions are.

    Returns:
        [m kg^1/2], sqrt(sum m |x - x*|^2) at most; infinity if there is no bound. There is
        none where a pinned vertex is off its target, where an impact names a vertex twice,
        and where numbers overflow.
    """
    if displacements is None:
        displacements = positions - problem.proposed
    if not (np.isfinite(displacements).all() and np.isfinite(multipliers).all()):
        return math.inf
    if displacements[np.isinf(problem.masses)].any() or _names_one_twice(problem.nodes):
        return math.inf
    with np.errstate(over="ignore", invalid="ignore"):  # what comes of it is tested for
        zone = _Zone(problem, displacements)
        if not zone.is_sound():
            return math.inf
        return _bound(zone, multipliers)


def _names_one_twice(nodes):
    in_order = np.sort(nodes, axis=1)
    return (in_order[:, 1:] == in_order[:, :-1]).any()


def _bound(zone, multipliers):
    if len(zone.slack) == 0:
        return _rounded_up(_norm(zone.z))
    pushes = np.bincount(zone.row_of.ravel(), np.maximum(multipliers, 0.0), len(zone.slack))
    pushes *= zone.lengths
    active = (pushes > 0.0) & (pushes > zone.slack)
    across = zone.correction(active)
    for _ in range(ROUNDS):
        slack, error = zone.moved(across)
        wanting = (slack < -error) & ~active
        if not wanting.any():
            break
        active |= wanting
        across = zone.correction(active)
    pushes = np.where(active, pushes, 0.0)
    bounds = (
        _bound_on_rows(zone, active, across, pushes),
        _bound_inside(zone, active, across, pushes),
    )
    return min(bound if bound >= 0.0 else math.inf for bound in bounds)  # NaN is none


def _norm(values):
    """Euclidean, without under- or overflow of the squares."""
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    return largest * float(np.linalg.norm(values / largest))


class _Zone:
    """C, s as slacks at z, and the rounding of both.

    Attributes:
        matrix: (k, 3 n_free) csr, rows of unit length; only rows with free vertices.
        z: (3 n_free,) f8.
        lengths: (k,) f8 [kg^-1/2], of the rows before scaling.
        row_of: (n_impacts,) the row of each impact; equal impacts have one row.
        slack, slack_error: (k,) f8, C z - s and a bound of its rounding.
        hopeless: an impact without free vertices is violated.
    """

    def __init__(self, problem, displacements):
        from scipy.sparse import coo_array

        scale = problem.inverse_sqrt_masses
        free = np.flatnonzero(scale > 0.0)
        column = np.full(len(scale), -1)
        column[free] = np.arange(len(free))
        same = np.column_stack((problem.nodes, problem.weights, problem.normals))
        _, first, self.row_of = np.unique(same, axis=0, return_index=True, return_inverse=True)
        nodes, weights, normals = (
            a[first] for a in (problem.nodes, problem.weights, problem.normals)
        )
        entries = (weights * scale[nodes])[:, :, None] * normals[:, None, :]
        largest = np.abs(entries).max(axis=(1, 2), initial=0.0)
        empty = largest == 0.0
        largest[empty] = 1.0
        # scaled, or the squares of small entries would vanish
        self.lengths = largest * np.sqrt(((entries / largest[:, None, None]) ** 2).sum(axis=(1, 2)))
        slack, error = _slack(problem, displacements, first)
        self.hopeless = bool((slack[empty] < 0.0).any())
        slack[empty] = problem.thickness  # in nobody's way
        self.lengths[empty] = 1.0
        self.slack, self.slack_error = slack / self.lengths, error / self.lengths
        entries /= self.lengths[:, None, None]
        rows = np.broadcast_to(np.arange(len(nodes))[:, None, None], entries.shape)
        columns = 3 * column[nodes][:, :, None] + np.arange(3)
        used = np.broadcast_to((column[nodes] >= 0)[:, :, None], entries.shape)
        shape = (len(nodes), 3 * len(free))
        self.matrix = coo_array((entries[used], (rows[used], columns[used])), shape).tocsr()
        self.size = abs(self.matrix)
        self.z = (displacements[free] / scale[free, None]).ravel()

    def is_sound(self):
        """Whether all is finite, and no impact without free vertices is violated."""
        parts = (self.matrix.data, self.z, self.slack, self.slack_error, self.lengths)
        return not self.hopeless and all(np.isfinite(part).all() for part in parts)

    def moved(self, step):
        """Slacks of z - step, and a bound of their rounding.

        An entry of C is off by 8 u of itself (root, quotient, two products, the length),
        a product of a row with 12 terms by 12 u of its terms' sizes.
        """
        slack = self.slack - self.matrix @ step
        return slack, self.slack_error + 24 * U * (self.size @ np.abs(step)) + U * np.abs(slack)

    def correction(self, rows):
        """The shortest step that moves the rows chosen to zero slack; zeros for none."""
        return self._shortest(rows, self.slack)

    def opening(self, rows):
        """The shortest direction along which the rows chosen open by one."""
        return self._shortest(rows, np.ones(len(self.slack)))

    def _shortest(self, rows, right):
        from scipy.sparse.linalg import lsmr

        step = np.zeros(self.matrix.shape[1])
        unit = float(np.max(np.abs(right[rows]), initial=0.0))
        if unit > 0.0:
            part, wanted = self.matrix[rows], right[rows] / unit
            for _ in range(2):  # the second removes what the first left
                left = wanted - part @ step
                step += lsmr(part, left, atol=1e-14, btol=1e-14, conlim=1e14)[0]
        return unit * step

    def pulled(self, pushes):
        """C^T pushes, and a bound of the length of its rounding.

        Sums of at most as many terms as a vertex has impacts, and 8 u of each entry.
        """
        terms = int(np.bincount(self.matrix.indices, minlength=1).max(initial=1))
        return self.matrix.T @ pushes, (terms + 8) * U * _norm(self.size.T @ pushes)


def _slack(problem, displacements, rows):
    """Gap less thickness at proposed plus displacements, and a bound of its rounding.

    Both parts relative to the first node. Each takes a difference, two products, and sums
    of 4 and of 3 terms: 8 u of the sizes of its terms. Weights that do not sum to zero add
    what their sum moves.
    """
    nodes, weights, normals = problem.nodes[rows], problem.weights[rows], problem.normals[rows]
    total = np.full(len(nodes), -problem.thickness)
    error = np.zeros(len(nodes))
    sums = np.abs([math.fsum(row) for row in weights.tolist()])
    size = np.abs(normals)
    for part in (problem.proposed, displacements):
        relative = part[nodes] - part[nodes[:, :1]]
        points = np.einsum("jk,jkx->jx", weights, relative)
        total += np.einsum("jx,jx->j", normals, points)
        terms = np.einsum("jk,jkx,jx->j", np.abs(weights), np.abs(relative), size)
        first = np.einsum("jx,jx->j", size, np.abs(part[nodes[:, 0]]))
        error += 10 * U * terms + (1.0 + 1e-9) * sums * first + 2 * U * np.abs(total)
    return total, error


def _bound_on_rows(zone, active, across, pushes):
    """The first bound: z moved onto independent active rows."""
    count = int(active.sum())
    if count > DENSE_ROWS:
        return math.inf
    slack, error = zone.moved(across)
    beyond, multipliers = 0.0, pushes
    if count:
        part = zone.matrix[active]
        values, vectors = np.linalg.eigh((part @ part.T).toarray())
        # entries are off by 24 u, so the matrix by 24 u times count; eigenvalues by rounding
        # of the order of u times the norm, at most count, times count: 8 covers its factor
        smallest = values[0] - (24 + 8 * count) * count * U
        if not smallest > 0.0:
            return math.inf
        residual = _norm(slack[active]) + _norm(error[active])
        beyond = residual / math.sqrt(smallest)
        fitted = np.zeros_like(pushes)
        fitted[active] = vectors @ ((vectors.T @ (part @ (zone.z - across))) / values)
        multipliers = np.maximum(fitted, 0.0)
    # rows have unit length but for a few u
    if not (slack - error - (1.0 + 1e-9) * beyond >= 0.0)[~active].all():
        return math.inf
    point = zone.z - across
    along = min(_misfit(zone, point, multipliers), _misfit(zone, point, pushes))
    return _rounded_up(_norm(across) + 2.0 * beyond + along)


def _misfit(zone, z, pushes):
    pulled, error = zone.pulled(pushes)
    return _norm(z - pulled) + error + 5 * U * _norm(z)


def _bound_inside(zone, active, across, pushes):
    """The second: z moved to where every row holds, and the gap there."""
    slack, error = zone.moved(across)
    missing = np.maximum(error - slack, 0.0)
    step = across
    if missing.any():
        rows = active | (missing > 0.0)
        direction = zone.opening(rows)
        opened = zone.matrix @ direction
        if not (opened[missing > 0.0] > 0.0).all():
            return math.inf
        # twice: moving has a rounding of its own
        step = across - 2.0 * direction * float(
            (missing / np.where(missing > 0.0, opened, 1.0)).max()
        )
        slack, error = zone.moved(step)
        if not (slack >= error).all():
            return math.inf
    products = 2.0 * float(pushes @ (slack + error))
    along = math.hypot(_misfit(zone, zone.z - step, pushes), math.sqrt(products))
    return _rounded_up(_norm(step) + along)


def _rounded_up(length):
    """A norm of n numbers is off by (n + 4) u / 2: less than this for 10^7 of them."""
    return length * (1.0 + 1e-9)
