"""The first hour of a new user, as a script: what README.md and docs/ promise, done and checked from outside.

    new_user.py SINEW FOLDER

SINEW is the program, FOLDER takes scenes and results (what it wrote there before is replaced). Needs numpy, h5py, pandas, pyvista and ovito.
Written from README.md and docs/ alone.
"""

import json, math, os, re, shutil, struct, subprocess, sys, time
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))

import numpy as np
import pyvista
import sinew
from ovito.io import import_file

SINEW, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve() / "new-user"
START = time.time()

BALL = """
title = "A steel ball into soft tissue"
domain = { lower = ["-20 mm", "-20 mm", "-24 mm"], upper = ["20 mm", "20 mm", "20 mm"], cell = "2 mm" }
run = { until = "1 ms", threads = 2 }
contact = [{ between = ["steel", "flesh"], law = "friction", friction = 0.1 }]
[material]
steel = { law = "rigid", motion = "free", density = "7.8 g/cm^3" }
flesh = { law = "tissue", density = 1050, c1 = "3 kPa", c3 = "1 kPa", c4 = 10, c5 = "100 kPa", lambda-star = 1.1, bulk-modulus = "500 kPa" }
[[body]]
name = "ball"
material = "steel"
shape = { sphere = { center = [0, 0, "12 mm"], radius = "4 mm" } }
velocity = [0, 0, "-30 m/s"]
[[body]]
name = "block"
material = "flesh"
shape = { box = { lower = ["-16 mm", "-16 mm", "-16 mm"], upper = ["16 mm", "16 mm", "6 mm"] } }
[[probe]]
name = "hit"
material = "flesh"
field = "velocity"
at = [0, 0, "6 mm"]
interval = "0.02 ms"
[output]
frames = 5
fields = ["velocity", "fiber_stretch", "failure"]
period = [{ from = "0.2 ms", to = "0.4 ms", frames-every = "0.05 ms" }]
"""

# A quarter of a strip, 20 mm between two grips that hold along x alone: uniaxial tension.
LENGTH, SIDE, BULK, SHEAR, SPEED = 20e-3, 2e-3, 1e6, 0.4e6, 0.16
STRIP = f"""
title = "A strip of rubber"
domain = {{ lower = [0, 0, 0], upper = ["40 mm", "4 mm", "4 mm"], cell = "1 mm" }}
material.rubber = {{ law = "neo-hookean", density = 1000, bulk-modulus = {BULK}, shear-modulus = {SHEAR} }}
boundary = {{ y-min = "symmetric", z-min = "symmetric" }}
load.damping = "500 1/s"
run = {{ until = "40 ms", threads = 2 }}
output.frames = 4
body = [{{ name = "strip", material = "rubber", shape.box = {{ lower = [0, 0, 0], upper = ["24 mm", {SIDE}, {SIDE}] }} }}]
[[drive]]
name = "left"
material = "rubber"
components = "x"
region = {{ box = {{ lower = [0, 0, 0], upper = ["2 mm", {SIDE}, {SIDE}] }} }}
[[drive]]
name = "right"
material = "rubber"
components = "x"
region = {{ box = {{ lower = ["22 mm", 0, 0], upper = ["24 mm", {SIDE}, {SIDE}] }} }}
velocity = [{SPEED}, 0, 0]
"""


def run(*arguments):
    """What `sinew ARGUMENTS` says on standard output; it must succeed."""
    done = subprocess.run([SINEW, *map(str, arguments)], cwd=FOLDER, capture_output=True, text=True)
    assert done.returncode == 0, f"sinew {arguments}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def png(path):
    """Width, height and number of pictures of a PNG."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[12:16] == b"IHDR" and b"IEND" in data[-12:], path
    film = data.find(b"acTL", 0, 200)
    return *struct.unpack(">II", data[16:24]), 1 if film < 0 else struct.unpack(">I", data[film + 4 : film + 8])[0]


def uniaxial(stretch):
    """Force of the strip: W = mu/2 (J^(-2/3) I1 - 3) + K/2 ((J^2 - 1)/2 - ln J), no stress across; the thinning by bisection."""

    def along(thin):
        j = stretch * thin**2
        volume, shear = BULK / 2 * (j**2 - 1), SHEAR * j ** (-2 / 3) / 3
        return volume + shear * (thin**2 - stretch**2), volume + 2 * shear * (stretch**2 - thin**2)

    low, high = 0.5, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if along(middle)[0] < 0 else (low, middle)
    return along(low)[1] / stretch * SIDE**2


def told(step, text):
    print(f"{time.time() - START:5.1f} s  {step}: {text}")


shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir(parents=True)
(FOLDER / "ball.toml").write_text(BALL)
(FOLDER / "strip.toml").write_text(STRIP)

# a) A scene of my own, checked and shot; a program reads along.
check = run("check", "ball.toml")
cells, particles = re.search(r"cells +(\S+ x \S+ x \S+)", check)[1], [int(n) for n in re.findall(r": (\d+) particles", check)]
assert cells == "20 x 20 x 22" and len(particles) == 2, check
said = [json.loads(line) for line in run("run", "ball.toml", "--log", "json").splitlines()]
assert [said[0]["event"], said[-1]["event"]] == ["begin", "picture"] and "end" in [line["event"] for line in said], said
ball = sinew.read(FOLDER / "runs/ball")
summary = ball.summary
assert summary["status"] == "completed" and summary["time_s"] == 1e-3 and summary["particles"] == sum(particles)
mass = summary["materials"]["steel"]["mass_kg"]
assert abs(mass / (7800 * 4 / 3 * math.pi * 0.004**3) - 1) < 0.1, f"stairs have the mass of a ball within a tenth: {mass}"
assert abs(summary["momentum_kg_m_s"][2] / (-30 * mass) - 1) < 1e-9, "nothing holds the matter: momentum stays"
assert -30 < summary["materials"]["steel"]["mean_velocity_m_s"][2] < -10 and 0.01 < summary["failed_fraction"]["any"] < 0.5
told("a", f"{summary['particles']} particles, the ball leaves {summary['failed_fraction']['any']:.1%} failed")

# Probe and period: rows of the probe alone are empty elsewhere; frames come every 0.2 ms, and every 0.05 ms from 0.2 to 0.4 ms.
table, whole = ball.history.table(probes_alone=True), ball.history.table()
hit = table.dropna(subset=["probe.hit.velocity_z_m_s"])
assert len(hit) >= 45 and np.diff(hit["time_s"]).max() < 0.06e-3 and hit["probe.hit.velocity_z_m_s"].min() < -5 and len(whole) < len(table)
times = np.array([frame.time for frame in ball.frames])
asked = [0, 0.2, 0.25, 0.3, 0.35, 0.4, 0.6, 0.8, 1.0]
assert len(times) == len(asked) and all(0 <= t - 1e-3 * a < 0.02e-3 for t, a in zip(times, asked)), times
told("g", f"{len(hit)} rows of the probe, {len(times)} frames")

# b) Force over displacement, for a paper.
run("run", "strip.toml")
strip = sinew.read(FOLDER / "runs/strip")
way, force = strip.history["drive.right.displacement_x_m"], strip.history["drive.right.force_x_n"]
near = abs(way / LENGTH - 0.3) < 0.01
(slope, level), exact = np.polyfit(way[near] / LENGTH - 0.3, force[near], 1), uniaxial(1.3)
assert near.sum() >= 10 and abs(level / exact - 1) < 0.03, (level, exact)
columns = ["--x", "drive.right.displacement_x_m", "--y", "drive.right.force_x_n", "--minus", "drive.left.force_x_n"]
for name in ("tension.svg", "tension.png"):
    run("plot", "runs/strip", *columns, "--width", "85 mm", "--dpi", 300, "--out", name)
svg = (FOLDER / "tension.svg").read_text()
assert re.search(r'<svg[^>]* width="85mm"', svg) and "force" in svg and png(FOLDER / "tension.png")[0] == round(85 / 25.4 * 300)
told("b", f"{level:.4f} N at 30 %, in closed form {exact:.4f} N ({level / exact - 1:+.1%})")

# c) All frames in PyVista, with time.
run("export", "runs/ball", "--format", "vtp")
reader = pyvista.get_reader(str(FOLDER / "runs/ball/vtp/particles.pvd"))
assert np.all(np.diff(reader.time_values) > 0) and np.allclose(reader.time_values, times, rtol=1e-12)
for k, frame in enumerate(ball.frames):
    reader.set_active_time_point(k)
    mesh = reader.read()[0]
    assert mesh.n_points == len(frame.id) and np.array_equal(np.sort(mesh["id"]), np.sort(frame.id))
plotter = pyvista.Plotter(off_screen=True, window_size=(600, 400))
plotter.add_mesh(mesh.clip("y", invert=False), scalars="fiber_stretch", point_size=6, nan_color="gray")
plotter.view_xz()
plotter.screenshot(str(FOLDER / "pyvista.png"))
assert png(FOLDER / "pyvista.png")[:2] == (600, 400)
told("c", f"PyVista reads {len(reader.time_values)} frames")

# d) OVITO, by both of its formats.
for form, name in (("netcdf", "particles.nc"), ("lammps", "particles.dump")):
    run("export", "runs/ball", "--format", form)
    pipeline = import_file(str(FOLDER / "runs/ball" / form / name))
    assert pipeline.source.num_frames == len(times)
    for k, frame in enumerate(ball.frames):
        shown = pipeline.compute(k).particles
        assert shown.count == summary["particles"]
        assert np.allclose(np.nanmax(shown["fiber_stretch"]), np.nanmax(frame["fiber_stretch"]), rtol=1e-5)
told("d", f"OVITO reads {pipeline.source.num_frames} frames of {shown.count} particles")

# e) Further: 10 ms more.
shutil.copytree(FOLDER / "runs/strip", FOLDER / "runs/longer")
run("run", "--restart", "runs/longer", "--until", "50 ms")
longer = sinew.read(FOLDER / "runs/longer")
rows = longer.history["time_s"]
assert longer.summary["time_s"] == 50e-3 and rows[-1] == 50e-3 and np.all(np.diff(rows) > 0) and longer.summary["steps"] > strip.summary["steps"]
assert len(longer.frames) == len(strip.frames) + 1 and math.isclose(longer.history["drive.right.displacement_x_m"][-1], 50e-3 * SPEED, rel_tol=1e-9)
told("e", f"goes on from {strip.summary['time_s'] * 1e3:g} to {longer.summary['time_s'] * 1e3:g} ms")

# f) A section colored by the stretch of the fibers, and a film of it.
run("picture", "runs/ball", "--field", "fiber_stretch", "--plane", "y", "--frame", "0,3,last", "--width", "160 mm", "--dpi", 160, "--out", "section.png")
run("picture", "runs/ball", "--field", "fiber_stretch", "--plane", "y", "--width", "80 mm", "--movie", "film.png")
assert abs(png(FOLDER / "section.png")[0] - 160 / 25.4 * 160) <= 1 and png(FOLDER / "section.png")[2] == 1 and png(FOLDER / "film.png")[2] == len(times)
told("f", f"a section of {png(FOLDER / 'section.png')[:2]} pixels, a film of {png(FOLDER / 'film.png')[2]} pictures")
