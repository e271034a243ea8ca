"""A port of stages S6 to S8 as short as it gets, in numpy. Tests break one of its methods each."""

import numpy as np

KINDS = {"f8": np.float64, "f4": np.float32}


def dot(a, b):
    """Return a @ b, summed in the order of the products: that of `@` depends on the processor."""
    total = a[0] * b[0]
    for i in range(1, len(a)):
        total = total + a[i] * b[i]
    return total


class Port:
    """Reads the inputs of a case in its type of floats, and computes in it."""

    def __init__(self, inputs, dtype):
        self.real = KINDS[dtype]
        self.inputs = inputs
        self.nodes = np.reshape(inputs["nodes"], (-1, 4))
        self.a = self.read("weights", 4)
        self.n = self.read("normals", 3)
        self.y = self.read("proposed", 3)
        self.x = self.read("positions", 3)
        self.m = self.read("masses", 1)
        self.free = np.array(inputs["pinned"]) == 0
        self.d = self.real(inputs["thickness"])
        self.start()

    def start(self):
        """Do nothing here: a place for mistakes."""

    def read(self, name, width):
        return np.array(self.inputs[name], self.real).reshape(-1, width)

    def numbers(self, name):
        return np.array(self.inputs[name], self.real)

    # stage S6
    def w(self):
        mass = np.where(self.free[:, None], self.m, 0)
        return self.real(2) * mass / self.total_mass()

    def total_mass(self):
        return self.m[self.free].sum()

    def moved(self):
        return np.where(self.free[:, None], self.x - self.y, 0)

    def objective(self):
        return (self.w() * self.moved() ** 2).sum() / self.real(2)

    def gap(self, j):
        points = self.x[self.nodes[j]] - self.x[self.nodes[j, 0]]
        return dot(self.n[j], dot(self.a[j], points))

    def constraint(self, gap):
        return self.d - gap

    def constraints(self):
        return np.array([self.constraint(self.gap(j)) for j in range(len(self.nodes))], self.real)

    # stage S7
    def pushed(self):
        return np.maximum(self.constraints() + self.numbers("multipliers") / self.mu(), 0)

    def mu(self):
        return self.real(self.inputs["penalty"])

    def of_multipliers(self):
        return (self.numbers("multipliers") ** 2).sum() / (self.real(2) * self.mu())

    def value(self):
        of_impacts = self.mu() / self.real(2) * (self.pushed() ** 2).sum()
        return self.objective() + of_impacts - self.of_multipliers()

    def forces(self):
        return np.maximum(self.numbers("multipliers") + self.mu() * self.constraints(), 0)

    def pull(self, gradient, i, vector):
        gradient[i] -= vector

    def gradient(self):
        gradient = self.w() * self.moved()
        for j, force in enumerate(self.forces()):
            for i, a in zip(self.nodes[j], self.a[j], strict=True):
                if self.free[i]:
                    self.pull(gradient, i, a * self.n[j] * force)
        return gradient

    # stage S8
    def prepare(self):
        """Return phi'(0), phi'' without impacts, c + l / mu, and A p."""
        p = self.read("direction", 3)
        t = self.constraints() + self.numbers("multipliers") / self.mu()
        q = [dot(self.n[j], dot(self.a[j], p[self.nodes[j]])) for j in range(len(self.nodes))]
        return self.slope(p), (self.w() * p * p).sum(), t, np.array(q, self.real)

    def slope(self, p):
        return (self.gradient() * p).sum()

    def phi(self, line, step):
        """Return phi(step) - phi(0), phi' and phi'' there."""
        slope, curvature, t, q = line
        move, half = step * q, self.real(0.5)
        stays, leaves = (t > 0) & (t > move), (t > 0) & (t <= move)
        enters = (t <= 0) & (t > move)
        value = (move[stays] ** 2).sum() + (t * (2 * move - t))[leaves].sum()
        value += ((t - move)[enters] ** 2).sum()
        rise = (move * q)[stays].sum() + (t * q)[leaves].sum() + ((move - t) * q)[enters].sum()
        second = (q * q)[stays | enters].sum()
        change = step * (slope + half * curvature * step) + half * self.mu() * value
        return change, slope + curvature * step + self.mu() * rise, curvature + self.mu() * second

    def is_low_enough(self, line, step):
        return self.phi(line, step)[0] < self.real(self.inputs["armijo"]) * step * line[0]

    def is_flat_enough(self, line, step):
        return abs(self.phi(line, step)[1]) <= self.real(self.inputs["wolfe"]) * abs(line[0])

    def failed(self, step):
        return self.real(0)

    def shrinks(self):
        return self.real(self.inputs["shrink"])

    def search(self):
        """Return the step, and the steps tried."""
        line, step = self.prepare(), self.real(self.inputs["first"])
        tried = [step]
        if self.inputs["search"] == "exact":
            return self.best(line, step), None
        if self.inputs["search"] == "wolfe":
            return self.bisect(line, step), None
        while not self.is_low_enough(line, step):
            step = self.real(step * self.shrinks())
            if step < self.real(self.inputs["smallest_step"]):
                return self.failed(tried[-1]), tried
            tried.append(step)
        return step, tried

    def best(self, line, step):
        """Return where phi' is 0, by bisection and Newton's steps."""
        return self.between(line, step, lambda s: self.phi(line, s)[1] > 0, lambda s: False)

    def bisect(self, line, step):
        def is_long(s):
            return self.phi(line, s)[1] > 0 or not self.is_low_enough(line, s)

        def is_right(s):
            return self.is_low_enough(line, s) and self.is_flat_enough(line, s)

        return self.between(line, step, is_long, is_right)

    def between(self, line, step, is_long, is_right):
        if not line[0] < 0:
            return self.failed(-line[0] / self.phi(line, self.real(0))[2])
        low, high = self.real(0), self.real(np.inf)
        for _ in range(400):
            if is_right(step):
                return step
            low, high = (low, step) if is_long(step) else (step, high)
            step = self.real(2) * low if np.isinf(high) else (low + high) / self.real(2)
        rise, second = self.phi(line, step)[1:]
        return step - rise / second

    def change(self, line, step):
        return self.phi(line, step)[0]


def answer(stage, port=Port):
    """Return the function that answers cases of a stage, as `tests.ports.own` has them."""

    def reply(inputs, dtype):
        own = port(inputs, dtype)
        with np.errstate(all="ignore"):
            return {"S6": six, "S7": seven, "S8": eight}[stage](own)

    return reply


def six(own):
    return {
        "objective": float(own.objective()),
        "gradient": (own.w() * own.moved()).ravel().tolist(),
        "constraints": own.constraints().tolist(),
    }


def seven(own):
    return {"value": float(own.value()), "gradient": own.gradient().ravel().tolist()}


def eight(own):
    step, tried = own.search()
    reply = {"step": float(step), "change": float(own.change(own.prepare(), step))}
    return reply if tried is None else {**reply, "tried": [float(s) for s in tried]}
