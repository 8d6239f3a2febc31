"""Runs the Python of the README beside a run of problems/tension.

usage: check_readme.py SINEW FOLDER
SINEW is the command; runs go to FOLDER. Needs pyvista, pandas and matplotlib.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

root = Path(__file__).resolve().parents[2]
sinew, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
folder.mkdir(parents=True, exist_ok=True)
words = [sinew, "run", root / "problems/tension", "-q", "--force", "--steps", "400", "--out", folder / "runs/tension"]
subprocess.run(list(map(str, words)), check=True, stdout=subprocess.DEVNULL)

import matplotlib  # noqa: E402

matplotlib.use("Agg")
import pyvista  # noqa: E402

pyvista.OFF_SCREEN = True
os.chdir(folder)
sys.path.insert(0, str(root / "python"))
blocks = re.findall(r"```python\n(.*?)```", (root / "README.md").read_text(), re.S)
assert blocks, "the README has no Python"
for block in blocks:
    names: dict = {}
    exec(compile(block, "README.md", "exec"), names)
    force, way = names["force"], names["way"]
    assert len(force) == len(way) > 3 and max(force) > 0, (force, way)
    assert names["frame"]["von_mises"].max() > 0
print(f"{len(blocks)} program of the README ran")
