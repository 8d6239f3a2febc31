"""The block of tests/scenes/free-block.toml in Warp, and the forms of its step."""
import time

import numpy as np
import warp as wp
from kernels import Constants, by_axis, plain, sym


class Case:
    """What the block is, read from the scene as a run has resolved it: a table of plain numbers in SI."""

    def __init__(self, scene):
        domain, (body,), (material,) = scene["domain"], scene["body"], scene["material"].values()
        box, h = body["shape"]["box"], domain["cell"]
        lower, upper = np.array(box["lower"]), np.array(box["upper"])
        cells = np.rint((upper - lower) / h).astype(int)
        first = np.rint((lower - domain["lower"]) / h)
        # in cells x, y, z with z fastest, and so the eight points of a cell
        corner = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), -1).reshape(-1, 1, 3)
        point = (np.stack(np.meshgrid(*3 * [np.arange(2)], indexing="ij"), -1).reshape(1, 8, 3) + 0.5) / 2
        self.x = np.array(domain["lower"]) + (first + corner + point).reshape(-1, 3) * h
        turned = np.cross(np.array(body["angular-velocity"], float), self.x - self.x.mean(0))
        self.v = np.array(body["velocity"]) + turned
        self.f = np.broadcast_to(np.diag(body["stretch"]).astype(float), (len(self.x), 3, 3)).copy()
        volume = (h / 2) ** 3 / np.prod(body["stretch"])
        c = self.constants = Constants()
        c.bulk, c.shear, c.pic = material["bulk-modulus"], material["shear-modulus"], scene["run"]["pic"]
        c.mass, c.volume, c.cell, c.inverse_cell = material["density"] * volume, volume, h, 1 / h
        c.least_mass = 1e-14 * material["density"] * h**3
        c.n = int(np.rint((domain["upper"][0] - domain["lower"][0]) / h)) + 1
        self.nodes = c.n**3


class Form:
    """A form of the step: `run` takes steps from the start and returns seconds of the clock and of the processor."""

    def __init__(self, case):
        self.case = case
        self.x, self.v = (wp.array(each, dtype=wp.vec3d) for each in (case.x, case.v))
        self.f = wp.array(case.f, dtype=wp.mat33d)
        self.count = len(case.x)

    def run(self, steps):
        for array, start in ((self.x, self.case.x), (self.v, self.case.v), (self.f, self.case.f)):
            array.assign(start)
        self.begin()
        wall, cpu = time.perf_counter(), time.process_time()
        for dt in steps:
            self.step(dt)
        return time.perf_counter() - wall, time.process_time() - cpu

    def kinetic(self):
        """Kinetic energy [J]."""
        return 0.5 * self.case.constants.mass * float(np.sum(self.v.numpy() ** 2))

    def launch(self, kernel, count, *given):
        wp.launch(kernel, dim=count, inputs=[*given, self.case.constants])


class Plain(Form):
    def __init__(self, case, options):
        super().__init__(case)
        self.to_nodes, self.nodes, self.to_particles, self.stress = plain(options)
        self.mass = wp.zeros(case.nodes, dtype=wp.float64)
        self.momentum, self.force = (wp.zeros(case.nodes, dtype=wp.vec3d) for _ in range(2))
        self.tau = wp.zeros(self.count, dtype=sym)

    def begin(self):
        self.launch(self.stress, self.count, self.f, self.tau)

    def step(self, dt):
        grid = self.mass, self.momentum, self.force
        for array in grid:
            array.zero_()
        self.launch(self.to_nodes, self.count, self.x, self.v, self.tau, *grid)
        self.launch(self.nodes, self.case.nodes, *grid, dt)
        self.launch(self.to_particles, self.count, self.x, self.v, self.f, self.tau, *grid[1:], dt)


class ByAxis(Form):
    def __init__(self, case, options, ragged):
        super().__init__(case)
        self.to_nodes, self.nodes, self.to_particles, self.sweep = by_axis(options, ragged)
        self.particles = self.x, self.v, self.f
        self.grid = wp.zeros(2 * case.nodes, dtype=wp.vec4d)

    def begin(self):
        pass

    def step(self, dt):
        self.grid.zero_()
        self.launch(self.to_nodes, self.count, *self.particles, self.grid)
        self.launch(self.nodes, self.case.nodes, self.grid, dt)
        self.launch(self.to_particles, self.count, *self.particles, self.grid, dt)


class Sweep(ByAxis):
    def __init__(self, case, options, ragged):
        super().__init__(case, options, ragged)
        self.following = wp.zeros_like(self.grid)

    def begin(self):
        self.grid.zero_()
        self.launch(self.to_nodes, self.count, *self.particles, self.grid)

    def step(self, dt):
        self.following.zero_()
        self.launch(self.nodes, self.case.nodes, self.grid, dt)
        self.launch(self.sweep, self.count, *self.particles, self.grid, self.following, dt)
        self.grid, self.following = self.following, self.grid


def forms(case, options):
    """All forms by name, with how many nodes a particle visits."""
    return {
        "plain, 27 nodes": Plain(case, options),
        "by axis, 27 nodes": ByAxis(case, options, ragged=False),
        "by axis, 8 to 27 nodes": ByAxis(case, options, ragged=True),
        "one sweep, 8 to 27 nodes": Sweep(case, options, ragged=True),
    }
