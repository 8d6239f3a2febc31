"""The explicit step of one neo-Hookean material in NVIDIA Warp, in double precision: uniform GIMP, FLIP, stress last. The formulas are those of
Sinew's tasks, so that both give the same numbers.

Three forms of it. On a CPU a launch runs on one core, and an atomic addition is a plain one.

- plain: an array for each quantity of the nodes, and 27 nodes a particle, one by one.
- by axis: sums go axis by axis, and a node is two vectors of four numbers; the stress is part of the transfer to the nodes.
- sweep: by axis, and a particle that has read one grid adds to the next one in the same kernel.
"""
import warp as wp

real = wp.float64
sym = wp.types.vector(length=6, dtype=real)  # xx, xy, xz, yy, yz, zz
reals, fours = wp.array(dtype=real), wp.array(dtype=wp.vec4d)
vectors, tensors, syms = wp.array(dtype=wp.vec3d), wp.array(dtype=wp.mat33d), wp.array(dtype=sym)


@wp.struct
class Constants:
    """Of the material, the particles and the grid, in SI."""

    bulk: real
    shear: real
    mass: real
    volume: real  # undeformed
    cell: real
    inverse_cell: real
    pic: real
    least_mass: real
    n: int  # nodes an axis


@wp.struct
class Stencil:
    """Weights and gradients on three nodes an axis."""

    first: int
    wx: wp.vec3d
    wy: wp.vec3d
    wz: wp.vec3d
    gx: wp.vec3d
    gy: wp.vec3d
    gz: wp.vec3d


@wp.func
def weights(t: real):
    # of a particle of half-size r = 1/4 cell, with t = x/h - r - floor(x/h - r)
    u = real(1.0) - t
    e = wp.max(real(0.5) - u, real(0.0))
    d = wp.max(u - real(0.5), real(0.0))
    w0, w2 = u * u - d * d, e * e
    return wp.vec3d(w0, real(1.0) - w0 - w2, w2)


@wp.func
def gradients(t: real, inverse_cell: real):
    g2 = wp.max(t - real(0.5), real(0.0)) * real(2.0)
    g0 = g2 - real(1.0)
    return wp.vec3d(g0, -g0 - g2, g2) * inverse_cell


@wp.func
def stencil(x: wp.vec3d, c: Constants):
    r, h = real(0.25), c.inverse_cell
    y = x * h - wp.vec3d(r, r, r)
    i, j, k = int(wp.floor(y[0])), int(wp.floor(y[1])), int(wp.floor(y[2]))
    tx, ty, tz = y[0] - real(i), y[1] - real(j), y[2] - real(k)
    s = Stencil()
    s.first = (i * c.n + j) * c.n + k
    s.wx = weights(tx)
    s.gx = gradients(tx, h)
    s.wy = weights(ty)
    s.gy = gradients(ty, h)
    s.wz = weights(tz)
    s.gz = gradients(tz, h)
    return s


@wp.func
def kirchhoff(f: wp.mat33d, c: Constants):
    j = wp.determinant(f)
    root = real(1.0) / wp.cbrt(j)
    b = (f * wp.transpose(f)) * (root * root)
    pressure = real(0.5) * c.bulk * (j * j - real(1.0))
    normal = pressure - c.shear * (b[0, 0] + b[1, 1] + b[2, 2]) / real(3.0)
    xx, yy, zz = c.shear * b[0, 0] + normal, c.shear * b[1, 1] + normal, c.shear * b[2, 2] + normal
    return sym(xx, c.shear * b[0, 1], c.shear * b[0, 2], yy, c.shear * b[1, 2], zz)


@wp.func
def deformed(l: wp.mat33d, f: wp.mat33d, dt: real):
    return f + (l * f) * dt


@wp.func
def flip(v: wp.vec3d, on_grid: wp.vec3d, change: wp.vec3d, pic: real):
    return (real(1.0) - pic) * (v + change) + pic * on_grid


def plain(options):
    """Kernels of the plain form, compiled with `options` of a Warp module."""
    kernel = wp.kernel(module="unique", module_options=options)

    @kernel
    def to_nodes(x: vectors, v: vectors, tau: syms, mass: reals, momentum: vectors, force: vectors, c: Constants):
        p = wp.tid()
        s = stencil(x[p], c)
        t, mv = tau[p] * -c.volume, v[p] * c.mass
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    w = s.wx[i] * s.wy[j] * s.wz[k]
                    gx, gy, gz = s.gx[i] * s.wy[j] * s.wz[k], s.wx[i] * s.gy[j] * s.wz[k], s.wx[i] * s.wy[j] * s.gz[k]
                    fx = t[0] * gx + t[1] * gy + t[2] * gz
                    fy = t[1] * gx + t[3] * gy + t[4] * gz
                    fz = t[2] * gx + t[4] * gy + t[5] * gz
                    node = s.first + (i * c.n + j) * c.n + k
                    wp.atomic_add(mass, node, w * c.mass)
                    wp.atomic_add(momentum, node, w * mv)
                    wp.atomic_add(force, node, wp.vec3d(fx, fy, fz))

    @kernel
    def nodes(mass: reals, momentum: vectors, force: vectors, dt: real, c: Constants):
        # velocities in the place of momenta, their changes in that of forces
        n = wp.tid()
        if mass[n] > c.least_mass:
            change = force[n] * (dt / mass[n])
            momentum[n] = momentum[n] / mass[n] + change
            force[n] = change
        else:
            momentum[n] = wp.vec3d()
            force[n] = wp.vec3d()

    @kernel
    def to_particles(
        x: vectors, v: vectors, f: tensors, tau: syms, velocity: vectors, change: vectors, dt: real, c: Constants
    ):
        p = wp.tid()
        s = stencil(x[p], c)
        on_grid, gain, l = wp.vec3d(), wp.vec3d(), wp.mat33d()
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    w = s.wx[i] * s.wy[j] * s.wz[k]
                    gx, gy, gz = s.gx[i] * s.wy[j] * s.wz[k], s.wx[i] * s.gy[j] * s.wz[k], s.wx[i] * s.wy[j] * s.gz[k]
                    node = s.first + (i * c.n + j) * c.n + k
                    on_grid += w * velocity[node]
                    gain += w * change[node]
                    l += wp.outer(velocity[node], wp.vec3d(gx, gy, gz))
        new = deformed(l, f[p], dt)
        f[p] = new
        tau[p] = kirchhoff(new, c)
        v[p] = flip(v[p], on_grid, gain, c.pic)
        x[p] = x[p] + on_grid * dt

    @kernel
    def stress(f: tensors, tau: syms, c: Constants):
        p = wp.tid()
        tau[p] = kirchhoff(f[p], c)

    return to_nodes, nodes, to_particles, stress


def by_axis(options, ragged):
    """Kernels whose nodes are pairs of vectors: [m, m v] and [f, 0], and then [v, 0] and [dv, 0]; third nodes that a particle does not
    reach are left out if `ragged`."""
    kernel = wp.kernel(module="unique", module_options=options)
    always = not ragged

    @wp.func
    def scatter(nodes: fours, s: Stencil, v: wp.vec3d, f: wp.mat33d, c: Constants):
        t = kirchhoff(f, c) * -c.volume
        m, o = c.mass, real(0.0)
        a = wp.vec4d(m, m * v[0], m * v[1], m * v[2])
        tx, ty, tz = wp.vec4d(t[0], t[1], t[2], o), wp.vec4d(t[1], t[3], t[4], o), wp.vec4d(t[2], t[4], t[5], o)
        for i in range(3):
            if always or i < 2 or s.wx[2] > o:
                ai, xi, yi, zi = s.wx[i] * a, s.gx[i] * tx, s.wx[i] * ty, s.wx[i] * tz
                for j in range(3):
                    if always or j < 2 or s.wy[2] > o:
                        aj, xj, zj = s.wy[j] * ai, s.wy[j] * xi + s.gy[j] * yi, s.wy[j] * zi
                        row = 2 * (s.first + (i * c.n + j) * c.n)
                        wp.atomic_add(nodes, row, s.wz[0] * aj)
                        wp.atomic_add(nodes, row + 1, s.wz[0] * xj + s.gz[0] * zj)
                        wp.atomic_add(nodes, row + 2, s.wz[1] * aj)
                        wp.atomic_add(nodes, row + 3, s.wz[1] * xj + s.gz[1] * zj)
                        if always or s.wz[2] > o:
                            wp.atomic_add(nodes, row + 4, s.wz[2] * aj)
                            wp.atomic_add(nodes, row + 5, s.wz[2] * xj + s.gz[2] * zj)

    @wp.func
    def along_z(nodes: fours, first: int, factors: wp.vec3d, weights: wp.vec3d):
        sum = factors[0] * nodes[first] + factors[1] * nodes[first + 2]
        if always or weights[2] > real(0.0):
            sum += factors[2] * nodes[first + 4]
        return sum

    @wp.func
    def gather(nodes: fours, s: Stencil, c: Constants):
        # sums of v and dv, and the derivatives of v
        o = real(0.0)
        v, dv, vx, vy, vz = wp.vec4d(), wp.vec4d(), wp.vec4d(), wp.vec4d(), wp.vec4d()
        for i in range(3):
            if always or i < 2 or s.wx[2] > o:
                vi, di, yi, zi = wp.vec4d(), wp.vec4d(), wp.vec4d(), wp.vec4d()
                for j in range(3):
                    if always or j < 2 or s.wy[2] > o:
                        row = 2 * (s.first + (i * c.n + j) * c.n)
                        on_z = along_z(nodes, row, s.wz, s.wz)
                        vi += s.wy[j] * on_z
                        yi += s.gy[j] * on_z
                        zi += s.wy[j] * along_z(nodes, row, s.gz, s.wz)
                        di += s.wy[j] * along_z(nodes, row + 1, s.wz, s.wz)
                v += s.wx[i] * vi
                vx += s.gx[i] * vi
                vy += s.wx[i] * yi
                vz += s.wx[i] * zi
                dv += s.wx[i] * di
        l = wp.mat33d(vx[0], vy[0], vz[0], vx[1], vy[1], vz[1], vx[2], vy[2], vz[2])
        return wp.vec3d(v[0], v[1], v[2]), wp.vec3d(dv[0], dv[1], dv[2]), l

    @kernel
    def to_nodes(x: vectors, v: vectors, f: tensors, nodes: fours, c: Constants):
        p = wp.tid()
        scatter(nodes, stencil(x[p], c), v[p], f[p], c)

    @kernel
    def nodes(nodes: fours, dt: real, c: Constants):
        n = 2 * wp.tid()
        a, f, o = wp.vec4d(nodes[n]), wp.vec4d(nodes[n + 1]), real(0.0)
        velocity, change = wp.vec4d(), wp.vec4d()
        if a[0] > c.least_mass:
            change = f * (dt / a[0])
            velocity = wp.vec4d(a[1], a[2], a[3], o) / a[0] + change
        nodes[n] = velocity
        nodes[n + 1] = change

    @kernel
    def to_particles(x: vectors, v: vectors, f: tensors, nodes: fours, dt: real, c: Constants):
        p = wp.tid()
        on_grid, change, l = gather(nodes, stencil(x[p], c), c)
        f[p] = deformed(l, f[p], dt)
        v[p] = flip(v[p], on_grid, change, c.pic)
        x[p] = x[p] + on_grid * dt

    @kernel
    def sweep(x: vectors, v: vectors, f: tensors, nodes: fours, following: fours, dt: real, c: Constants):
        p = wp.tid()
        on_grid, change, l = gather(nodes, stencil(x[p], c), c)
        f_new = deformed(l, f[p], dt)
        v_new = flip(v[p], on_grid, change, c.pic)
        x_new = x[p] + on_grid * dt
        scatter(following, stencil(x_new, c), v_new, f_new, c)
        f[p] = f_new
        v[p] = v_new
        x[p] = x_new

    return to_nodes, nodes, to_particles, sweep
