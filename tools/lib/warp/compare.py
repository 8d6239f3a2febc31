"""Sinew against NVIDIA Warp on one core: the block of tests/scenes/free-block.toml, by the same formulas and the same time steps.

Which time steps, and what must come out, is what a run of Sinew has recorded: a form of the step in Warp counts if it ends with the same kinetic
energy and particles in the same places. Then both take turns. Only steps are timed: in Warp those alone; in Sinew by the run's own clock of
steps, and by the processor's time of a run less that of a run of one step.

usage: compare.py SINEW FOLDER [--check] [--repeat N] [--steps N]
"""
import argparse
import csv
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import warp as wp
from forms import Case, forms

SCENE = Path(__file__).parents[3] / "tests/scenes/free-block.toml"
AT_REST = ["body.block.velocity=[0, 0, 0]", "body.block.angular-velocity=[0, 0, 0]"]
CASES = {"a block that breathes": AT_REST, "a block that breathes, flies and turns": []}
#: Of the kinetic energy; and of a cell, for places.
TOLERANCE = 1e-10


class Sinew:
    """The command, and a folder for its runs."""

    def __init__(self, command, folder):
        self.command, self.folder = command, folder

    def run(self, steps, changes, isa, history_every):
        """The summary of a run on one thread, with the processor's time that its process took [s]."""
        quiet = ["output.frames=0", f"output.history-every={history_every}", "output.checkpoint.final=false"]
        command = [self.command, "run", SCENE, "--quiet", "--force", "--threads", "1", "--steps", steps, "--out", self.folder]
        for change in [*quiet, "output.checkpoint.wall=0", *changes]:
            command += ["--set", change]
        environment = {key: value for key, value in os.environ.items() if key != "SINEW_ISA"}
        environment |= {"SINEW_ISA": isa} if isa else {}
        with open(self.folder.with_suffix(".txt"), "w+", encoding="utf-8") as said:
            process = subprocess.Popen([str(word) for word in command], env=environment, stdout=said, stderr=said)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            if process.returncode != 0:
                said.seek(0)
                sys.exit(f"{command[0]} failed:\n{said.read()}")
        summary = json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
        return summary | {"processor_s": usage.ru_utime + usage.ru_stime}

    def version(self):
        return subprocess.run([self.command, "--version"], check=True, capture_output=True, text=True).stdout.strip()


class Recorded:
    """A run of Sinew step by step, and the case that it ran."""

    def __init__(self, sinew, steps, changes, isa):
        self.hash = sinew.run(steps, changes, isa, 1)["state_hash"]
        self.case = Case(tomllib.loads((sinew.folder / "scene.toml").read_text(encoding="utf-8")))
        with open(sinew.folder / "history.csv", newline="", encoding="utf-8") as file:
            self.rows = list(csv.DictReader(file))
        assert len(self.rows) == steps + 1, f"{len(self.rows)} rows for {steps} steps"
        self.steps = [float(row["step_size_s"]) for row in self.rows[1:]]
        self.kinetic = float(self.rows[-1]["rubber.kinetic_j"])
        self.probes = sorted({name.split(".")[1] for name in self.rows[0] if name.startswith("probe.")})
        ways = [np.max(np.abs(self.place(-1, probe) - self.place(0, probe))) for probe in self.probes]
        assert len(ways) >= 3 and max(ways) > 1e-2 * self.case.constants.cell, f"what is followed hardly moves: {ways} m"

    def place(self, row, probe):
        return np.array([float(self.rows[row][f"probe.{probe}.position_{axis}_m"]) for axis in "xyz"])

    def differences(self, form):
        """How far the form's end is from this run's: of the kinetic energy, and the farthest particle in cells."""
        x, h = form.x.numpy(), self.case.constants.cell
        farthest = 0.0
        for probe in self.probes:
            particle = np.argmin(np.sum((self.case.x - self.place(0, probe)) ** 2, axis=1))
            assert np.max(np.abs(self.case.x[particle] - self.place(0, probe))) < 1e-9 * h, f"no particle begins at {probe}"
            farthest = max(farthest, np.max(np.abs(x[particle] - self.place(-1, probe))) / h)
        return abs(form.kinetic() / self.kinetic - 1), farthest


def agree(recorded, named):
    """Ends the program unless all forms compute what Sinew did."""
    kinetic = float(recorded.rows[0]["rubber.kinetic_j"])
    print(f"  {len(recorded.steps)} steps; kinetic energy from {kinetic:.6e} to {recorded.kinetic:.6e} J")
    for name, form in named.items():
        form.run(recorded.steps)
        energy, place = recorded.differences(form)
        good = energy <= TOLERANCE and place <= TOLERANCE
        print(f"  {'agrees' if good else 'DIFFERS':8}{name:26} kinetic energy by {energy:.1e}, places by {place:.1e} cells")
        if not good:
            sys.exit(f"Warp and Sinew do not compute the same (tolerance {TOLERANCE}): no speeds are compared")


class Rates:
    """Million particle updates a second of one program, repetition by repetition."""

    def __init__(self):
        self.wall, self.processor = [], []

    def add(self, updates, wall, processor):
        self.wall.append(1e-6 * updates / wall)
        self.processor.append(1e-6 * updates / processor)

    def line(self, name):
        of = (f"{max(rates):8.2f}{statistics.median(rates):8.2f}" for rates in (self.processor, self.wall))
        return f"  {name:34}" + "  ".join(of)


def race(sinew, recorded, named, changes, isa, repeat):
    """Both take turns; prints the table."""
    count, steps = len(recorded.case.x), len(recorded.steps)
    ours, theirs = Rates(), {name: Rates() for name in named}
    for _ in range(repeat):
        once = sinew.run(1, changes, isa, steps)
        run = sinew.run(steps, changes, isa, steps)
        assert run["state_hash"] == recorded.hash, "Sinew ended in another state than before"
        ours.add(count * (steps - 1), run["stepping_s"] * (steps - 1) / steps, run["processor_s"] - once["processor_s"])
        for name, form in named.items():
            theirs[name].add(count * steps, *form.run(recorded.steps))
    best = max(theirs, key=lambda name: max(theirs[name].processor))
    print(f"  {'million particle updates a second':34}{'processor':>16}  {'clock':>16}")
    print(f"  {'on one core':34}" + "  ".join(2 * [f"{'best':>8}{'median':>8}"]))
    print(ours.line("Sinew"))
    for name, rates in theirs.items():
        print(rates.line(f"Warp, {name}"))
    pairs = ((ours.processor, theirs[best].processor), (ours.wall, theirs[best].wall))
    ratios = (f"{max(a) / max(b):8.2f}{statistics.median(a) / statistics.median(b):8.2f}" for a, b in pairs)
    print(f"  {'Sinew / the best of Warp':34}" + "  ".join(ratios))
    print(f"  the best of Warp: {best}")


def instruction_sets(widest):
    """Sinew's names of instruction sets to compare on, each with the flags by which Warp's compiler uses the same."""
    flags = wp.config.cpu_compiler_flags
    sets = [(widest, flags)]
    if widest == "avx512":
        sets.append(("avx2", flags.replace("-march=native", "-target-cpu x86-64-v3")))
    return sets


def processor_name():
    try:
        found = re.search(r"^model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M)
    except OSError:
        found = None
    return found[1] if found else platform.processor() or platform.machine()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("sinew", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--check", action="store_true", help="few steps: whether both compute the same, and no speeds")
    parser.add_argument("--repeat", type=int, default=5, help="repetitions (5)")
    parser.add_argument("--steps", type=int, help="steps (100; 12 with --check)")
    given = parser.parse_args()
    steps = given.steps or (12 if given.check else 100)
    if steps < 2 or given.repeat < 1:
        parser.error("it takes two steps and one repetition at least")

    given.folder.mkdir(parents=True, exist_ok=True)
    wp.config.kernel_cache_dir, wp.config.log_level = str(given.folder.resolve() / "kernels"), wp.LOG_ERROR
    sinew = Sinew(given.sinew.resolve(), given.folder.resolve() / "run")
    widest = sinew.run(1, [], None, 1)["isa"]
    print(f"{sinew.version()}, Warp {wp.__version__}, numpy {np.__version__}, Python {platform.python_version()}")
    print(f"{processor_name()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    for isa, flags in instruction_sets(widest)[: 1 if given.check else None]:
        for title, changes in CASES.items():
            print(f"\n{title}, {isa}")
            recorded = Recorded(sinew, steps, changes, isa)
            named = forms(recorded.case, {"enable_backward": False, "cpu_compiler_flags": flags})
            agree(recorded, named)
            if not given.check:
                race(sinew, recorded, named, changes, isa, given.repeat)
    print(f"\nload at the end {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
