"""A port of five stages to Warp: S2, S3, S6, S7 and S9, in float64 and float32.

Run it as `izo conform --exec "python tests/ports/warp/port.py"`. Warp compiles the kernels for the
CPU; with a CUDA device, change DEVICE. Everything a port needs besides its kernels is at the end:
read a line of JSON, launch, write a line.
"""

import json
import sys
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import warp as wp

DEVICE = "cpu"
DTYPES = {"f8": (wp.float64, np.float64), "f4": (wp.float32, np.float32)}
# Distances below this fraction of the size of a pair count as contact, and a step along the path
# leaves this share of the distance.
CONTACT = {"f8": 1e-13, "f4": 3e-6}
SHARE_LEFT = 0.05


@cache
def kernels(dtype: str) -> SimpleNamespace:
    """Return the kernels for one type of floats."""
    real = DTYPES[dtype][0]
    vec3 = wp.types.vector(length=3, dtype=real)
    vec4 = wp.types.vector(length=4, dtype=real)

    @wp.func
    def clamp01(s: real):
        # a NaN (0 / 0, an edge without length) becomes 0
        if s > real(0.0):
            return wp.min(s, real(1.0))
        return real(0.0)

    @wp.func
    def nearest_on_segment(a: vec3, b: vec3):
        ab = b - a
        return clamp01(-wp.dot(a, ab) / wp.dot(ab, ab))

    @wp.func
    def vertex_face(a: vec3, b: vec3, c: vec3):
        # Weights of the vertex at the origin and of the corners; C. Ericson, 5.1.5.
        ab = b - a
        ac = c - a
        bc = c - b
        n = wp.cross(ab, ac)
        area_a = wp.dot(n, wp.cross(b, c))
        area_b = wp.dot(n, wp.cross(c, a))
        area_c = wp.dot(n, wp.cross(a, b))
        total = area_a + area_b + area_c
        if area_a > real(0.0) and area_b > real(0.0) and area_c > real(0.0):
            return vec4(real(1.0), -area_a / total, -area_b / total, -area_c / total)
        s = nearest_on_segment(a, b)
        t = nearest_on_segment(b, c)
        u = nearest_on_segment(c, a)
        p = a + s * ab
        q = b + t * bc
        r = c - u * ac
        if wp.dot(p, p) <= wp.dot(q, q) and wp.dot(p, p) <= wp.dot(r, r):
            return vec4(real(1.0), s - real(1.0), -s, real(0.0))
        if wp.dot(q, q) <= wp.dot(r, r):
            return vec4(real(1.0), real(0.0), t - real(1.0), -t)
        return vec4(real(1.0), -u, real(0.0), u - real(1.0))

    @wp.func
    def points_at(p: vec3, a: vec3, b: vec3, s: real, r: real, best: vec4):
        # the better of two guesses of the closest points
        d = s * p - a - r * (b - a)
        e = best[1] * p + best[2] * a + best[3] * b
        if wp.dot(d, d) < wp.dot(e, e):
            return vec4(real(1.0) - s, s, r - real(1.0), -r)
        return best

    @wp.func
    def edge_edge(p: vec3, a: vec3, b: vec3):
        # Weights of the edge from the origin to p and of the edge a b. The closest points are
        # inside both edges, or one of them is an end. Nearly parallel edges have an inner solution
        # that is mostly rounding, so the ends are always tried.
        d = b - a
        n = wp.cross(p, d)
        nn = wp.dot(n, n)
        s = clamp01(wp.dot(wp.cross(a, d), n) / nn)
        r = clamp01(wp.dot(wp.cross(a, p), n) / nn)
        best = vec4(real(1.0) - s, s, r - real(1.0), -r)
        best = points_at(p, a, b, real(0.0), nearest_on_segment(a, b), best)
        best = points_at(p, a, b, real(1.0), nearest_on_segment(a - p, b - p), best)
        best = points_at(p, a, b, nearest_on_segment(-a, p - a), real(0.0), best)
        return points_at(p, a, b, nearest_on_segment(-b, p - b), real(1.0), best)

    @wp.func
    def weights_of(is_edge_edge: int, a: vec3, b: vec3, c: vec3):
        if is_edge_edge == 1:
            return edge_edge(a, b, c)
        return vertex_face(a, b, c)

    @wp.func
    def node_at(x0: wp.array(dtype=vec3), x1: wp.array(dtype=vec3), k: int, t: real):
        # relative to node 0, and differences first: far from the origin this loses no digits
        return (real(1.0) - t) * (x0[k] - x0[0]) + t * (x1[k] - x1[0])

    @wp.func
    def speed_of(x0: wp.array(dtype=vec3), x1: wp.array(dtype=vec3), is_edge_edge: int):
        # No two points of the sides approach each other faster than two of their nodes do.
        fastest = real(0.0)
        first = 1 + is_edge_edge
        for i in range(first):
            for k in range(first, 4):
                fastest = wp.max(fastest, wp.length((x1[k] - x1[i]) - (x0[k] - x0[i])))
        return fastest

    @wp.func
    def size_of(x0: wp.array(dtype=vec3), x1: wp.array(dtype=vec3)):
        size = real(0.0)
        for k in range(1, 4):
            size = wp.max(size, wp.max(wp.length(x0[k] - x0[0]), wp.length(x1[k] - x1[0])))
        return size

    @wp.kernel(module="unique")
    def first_contact(
        # In:
        start: wp.array(dtype=vec3),
        end: wp.array(dtype=vec3),
        is_edge_edge: int,
        contact: real,
        share_left: real,
        # Out:
        meets_out: wp.array(dtype=int),
        toi_out: wp.array(dtype=real),
    ):
        # Conservative advancement: in a time of distance / speed the sides cannot meet. The limit
        # is more than the rounding of the distance.
        t = real(0.0)
        speed = speed_of(start, end, is_edge_edge)
        limit = contact * size_of(start, end)
        meets_out[0] = 0
        for _ in range(100000):
            a = node_at(start, end, 1, t)
            b = node_at(start, end, 2, t)
            c = node_at(start, end, 3, t)
            w = weights_of(is_edge_edge, a, b, c)
            distance = wp.length(w[1] * a + w[2] * b + w[3] * c)
            if distance <= limit:
                meets_out[0] = 1
                toi_out[0] = t
                return
            if speed == real(0.0) or t == real(1.0):
                return
            t = wp.min(t + (real(1.0) - share_left) * (distance - limit) / speed, real(1.0))
        meets_out[0] = 1
        toi_out[0] = t

    @wp.kernel(module="unique")
    def frame(
        # In:
        start: wp.array(dtype=vec3),
        end: wp.array(dtype=vec3),
        is_edge_edge: int,
        toi: real,
        flat: real,
        # Out:
        weights_out: wp.array(dtype=vec4),
        normal_out: wp.array(dtype=vec3),
    ):
        a = node_at(start, end, 1, toi)
        b = node_at(start, end, 2, toi)
        c = node_at(start, end, 3, toi)
        w = weights_of(is_edge_edge, a, b, c)
        u = b - a
        v = c - a
        if is_edge_edge == 1:
            u = a
            v = c - b
        n = wp.cross(u, v)
        a0 = node_at(start, end, 1, real(0.0))
        b0 = node_at(start, end, 2, real(0.0))
        c0 = node_at(start, end, 3, real(0.0))
        apart = w[1] * a0 + w[2] * b0 + w[3] * c0
        gap = wp.dot(n, apart)
        size = wp.max(wp.length(a0), wp.max(wp.length(b0), wp.length(c0)))
        is_degenerate = wp.length(n) <= flat * wp.length(u) * wp.length(v)
        if is_degenerate or wp.abs(gap) <= flat * size * wp.length(n):
            # no normal, or the pair moves in one plane: the direction that separates the start
            first = weights_of(is_edge_edge, a0, b0, c0)
            n = first[1] * a0 + first[2] * b0 + first[3] * c0
        elif gap < real(0.0):
            n = -n
        weights_out[0] = w
        normal_out[0] = wp.normalize(n)

    @wp.kernel(module="unique")
    def constraints(
        # In:
        nodes: wp.array2d(dtype=int),
        weights: wp.array(dtype=vec4),
        normals: wp.array(dtype=vec3),
        positions: wp.array(dtype=vec3),
        thickness: real,
        # Out:
        constraints_out: wp.array(dtype=real),
    ):
        j = wp.tid()
        w = weights[j]
        point = vec3()
        for k in range(1, 4):
            # the weights sum to 0, so positions relative to the first node give the same gap
            point += w[k] * (positions[nodes[j, k]] - positions[nodes[j, 0]])
        constraints_out[j] = thickness - wp.dot(normals[j], point)

    @wp.kernel(module="unique")
    def objective(
        # In:
        positions: wp.array(dtype=vec3),
        proposed: wp.array(dtype=vec3),
        masses: wp.array(dtype=real),
        pinned: wp.array(dtype=int),
        total_mass: real,
        # Out:
        objective_out: wp.array(dtype=real),
        gradient_out: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        if pinned[i] == 0:
            move = positions[i] - proposed[i]
            share = masses[i] / total_mass
            wp.atomic_add(objective_out, 0, share * wp.dot(move, move))
            gradient_out[i] = real(2.0) * share * move

    @wp.kernel(module="unique")
    def push(
        # In:
        nodes: wp.array2d(dtype=int),
        weights: wp.array(dtype=vec4),
        normals: wp.array(dtype=vec3),
        values: wp.array(dtype=real),
        multipliers: wp.array(dtype=real),
        pinned: wp.array(dtype=int),
        penalty: real,
        # Out:
        value_out: wp.array(dtype=real),
        gradient_out: wp.array(dtype=vec3),
    ):
        j = wp.tid()
        rest = multipliers[j] / penalty
        pushed = wp.max(values[j] + rest, real(0.0))
        wp.atomic_add(value_out, 0, real(0.5) * penalty * (pushed * pushed - rest * rest))
        for k in range(4):
            if pinned[nodes[j, k]] == 0:
                pull = penalty * pushed * weights[j][k]
                wp.atomic_add(gradient_out, nodes[j, k], -pull * normals[j])

    @wp.kernel(module="unique")
    def update(
        # In:
        multipliers: wp.array(dtype=real),
        values: wp.array(dtype=real),
        penalty: real,
        # Out:
        multipliers_out: wp.array(dtype=real),
    ):
        j = wp.tid()
        multipliers_out[j] = wp.max(multipliers[j] + penalty * values[j], real(0.0))

    return SimpleNamespace(
        real=real,
        vec3=vec3,
        vec4=vec4,
        first_contact=first_contact,
        frame=frame,
        constraints=constraints,
        objective=objective,
        push=push,
        update=update,
    )


def launch(kernel: Any, size: int, inputs: list[Any], outputs: list[Any]) -> None:
    """Run a kernel on DEVICE."""
    wp.launch(kernel, dim=size, inputs=inputs, outputs=outputs, device=DEVICE)


class Arrays:
    """The inputs of a case as arrays of Warp, and outputs of the right type.

    Args:
        inputs: The inputs of the request.
        dtype: `f8` or `f4`.
    """

    def __init__(self, inputs: dict[str, Any], dtype: str) -> None:
        """Keep the inputs."""
        self.inputs, self.k, self.dtype = inputs, kernels(dtype), dtype

    def real(self, name: str) -> Any:
        """Return a number."""
        return self.k.real(float.fromhex(self.inputs[name]))

    def array(self, name: str, kind: Any, width: int = 1) -> Any:
        """Return an array of floats, whose items have `width` numbers."""
        numbers = [float.fromhex(word) for word in self.inputs[name]]
        rows = np.array(numbers, DTYPES[self.dtype][1])
        rows = rows if width == 1 else rows.reshape(-1, width)
        return wp.array(rows, dtype=kind, device=DEVICE)

    def integers(self, name: str, width: int = 1) -> Any:
        """Return an array of integers."""
        rows = np.array(self.inputs[name], np.int32)
        return wp.array(rows if width == 1 else rows.reshape(-1, width), dtype=int, device=DEVICE)

    def zeros(self, size: int, kind: Any) -> Any:
        """Return an output of zeros."""
        return wp.zeros(size, dtype=kind, device=DEVICE)


def flat(array: Any) -> list[Any]:
    """Return the numbers of an array of Warp, row by row."""
    return array.numpy().ravel().tolist()


def answer_s2(a: Arrays) -> dict[str, Any]:
    """Find the first contact of a pair."""
    meets, toi = a.zeros(1, int), a.zeros(1, a.k.real)
    pair = [a.array("start", a.k.vec3, 3), a.array("end", a.k.vec3, 3), a.inputs["is_edge_edge"]]
    limits = [a.k.real(CONTACT[a.dtype]), a.k.real(SHARE_LEFT)]
    launch(a.k.first_contact, 1, [*pair, *limits], [meets, toi])
    return {"meets": 1, "toi": flat(toi)[0]} if flat(meets)[0] else {"meets": 0}


def answer_s3(a: Arrays) -> dict[str, Any]:
    """Compute the weights and the normal of an impact."""
    weights, normal = a.zeros(1, a.k.vec4), a.zeros(1, a.k.vec3)
    pair = [a.array("start", a.k.vec3, 3), a.array("end", a.k.vec3, 3), a.inputs["is_edge_edge"]]
    flat_below = a.k.real(1e-10 if a.dtype == "f8" else 1e-5)
    launch(a.k.frame, 1, [*pair, a.real("toi"), flat_below], [weights, normal])
    return {"weights": flat(weights), "normal": flat(normal)}


def constraints_of(a: Arrays) -> tuple[list[Any], Any]:
    """Return the impacts of a zone, and its constraints at the positions."""
    impacts = [
        a.integers("nodes", 4),
        a.array("weights", a.k.vec4, 4),
        a.array("normals", a.k.vec3, 3),
    ]
    values = a.zeros(len(impacts[0]), a.k.real)
    at = [a.array("positions", a.k.vec3, 3), a.real("thickness")]
    launch(a.k.constraints, len(values), [*impacts, *at], [values])
    return impacts, values


def objective_of(a: Arrays) -> tuple[Any, Any]:
    """Return the objective and its gradient."""
    pinned = np.array(a.inputs["pinned"], bool)
    masses = np.array([float.fromhex(word) for word in a.inputs["masses"]])
    total = a.k.real(float(masses[~pinned].sum()))
    value, gradient = a.zeros(1, a.k.real), a.zeros(len(pinned), a.k.vec3)
    points = [a.array("positions", a.k.vec3, 3), a.array("proposed", a.k.vec3, 3)]
    rest = [a.array("masses", a.k.real), a.integers("pinned"), total]
    launch(a.k.objective, len(pinned), [*points, *rest], [value, gradient])
    return value, gradient


def answer_s6(a: Arrays) -> dict[str, Any]:
    """Compute the objective, its gradient and the constraints."""
    value, gradient = objective_of(a)
    constraints = flat(constraints_of(a)[1])
    return {
        "objective": flat(value)[0],
        "gradient": flat(gradient),
        "constraints": constraints,
    }


def answer_s7(a: Arrays) -> dict[str, Any]:
    """Compute the augmented Lagrangian and its gradient."""
    value, gradient = objective_of(a)
    impacts, values = constraints_of(a)
    rest = [a.array("multipliers", a.k.real), a.integers("pinned"), a.real("penalty")]
    launch(a.k.push, len(values), [*impacts, values, *rest], [value, gradient])
    return {"value": flat(value)[0], "gradient": flat(gradient)}


def answer_s9(a: Arrays) -> dict[str, Any]:
    """Update the multipliers."""
    inputs = [a.array("multipliers", a.k.real), a.array("constraints", a.k.real), a.real("penalty")]
    updated = a.zeros(len(inputs[0]), a.k.real)
    launch(a.k.update, len(updated), inputs, [updated])
    return {"multipliers": flat(updated)}


ANSWERS = {
    "S2": answer_s2,
    "S3": answer_s3,
    "S6": answer_s6,
    "S7": answer_s7,
    "S9": answer_s9,
}


def reply(request: dict[str, Any]) -> dict[str, Any]:
    """Return the reply to a request."""
    if "hello" in request:
        return {
            "name": "warp",
            "version": wp.__version__,
            "stages": list(ANSWERS),
            "dtypes": list(DTYPES),
        }
    if request["stage"] not in ANSWERS:
        return {"id": request["id"], "status": "unsupported"}
    output = ANSWERS[request["stage"]](Arrays(request["input"], request["dtype"]))
    return {"id": request["id"], "status": "ok", "output": output}


def main() -> None:
    """Answer each line until there are no more."""
    replies = sys.stdout
    sys.stdout = sys.stderr  # Warp prints what it compiles; only replies go to standard output
    for line in sys.stdin:
        print(json.dumps(reply(json.loads(line))), file=replies, flush=True)


if __name__ == "__main__":
    main()
