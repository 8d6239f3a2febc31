"""Reads what a run of Sinew leaves in its folder.

>>> import sinew
>>> run = sinew.read("runs/tension")
>>> run.history["time_s"]                # columns of history.csv: numpy arrays, or a pandas table by run.history.table()
>>> frame = run.frames[-1]               # the last one; it is read when something of it is asked for
>>> frame["von_mises"], frame.position   # numpy arrays, a row a particle, in SI
>>> frame.of("strip")["velocity"]        # of one material
>>> frame.pyvista().plot()               # with pyvista

docs/FIELDS.md of Sinew says what fields there are, and what they mean.
"""
import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

__all__ = ["Field", "Frame", "History", "Run", "read"]


def read(folder):
    """The run in a folder.

    :param folder: Folder of a run, finished or not.
    :raises FileNotFoundError: If it holds no run.
    """
    return Run(folder)


@dataclass(frozen=True)
class Field:
    """What a column of the frames is."""

    name: str
    #: SI unit, "1" for pure numbers.
    unit: str
    meaning: str
    #: Numbers a particle: 1, 3 (x, y, z), 6 (xx, yy, zz, xy, yz, xz) or 9 (row by row).
    components: int
    #: What the values 0, 1, ... mean, if they are codes.
    codes: tuple


class Run:
    """A run: ``frames``, ``history``, ``summary``."""

    def __init__(self, folder):
        self.folder = Path(folder)
        if not (self.folder / "history.csv").is_file():
            raise FileNotFoundError(f"{self.folder} holds no history.csv: name the folder of a run of Sinew")
        self.frames = Frames(self.folder / "particles.vtkhdf")

    def __repr__(self):
        return f"<run {self.folder}: {len(self.frames)} frames>"

    @property
    def summary(self):
        """``summary.json`` as a dict; None while the run goes on."""
        path = self.folder / "summary.json"
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None

    @property
    def history(self):
        """``history.csv`` as it is now."""
        return History(self.folder / "history.csv")

    @property
    def materials(self):
        """Names of the materials; the index of a name is the ``material`` of its particles."""
        return self.frames.materials

    @property
    def fields(self):
        """What the frames show, by name."""
        return self.frames.fields


class History(Mapping):
    """Columns of ``history.csv`` by name, each a numpy array."""

    def __init__(self, path):
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        if not rows:
            raise ValueError(f"{path} is empty")
        self._columns = dict(zip(rows[0], map(_numbers, zip(*rows[1:])))) if len(rows) > 1 else {
            name: np.array([]) for name in rows[0]
        }

    def __getitem__(self, name):
        if name not in self._columns:
            raise KeyError(f"{name}: the history has {', '.join(self._columns)}")
        return self._columns[name]

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    def table(self, probes_alone=False):
        """As a pandas table; rows that a probe's own interval has made, with no other columns, only if ``probes_alone``."""
        import pandas

        table = pandas.DataFrame(dict(self._columns))
        if probes_alone or "residual_j" not in table:
            return table
        return table[table["residual_j"].notna()].reset_index(drop=True)


def _numbers(cells):
    """An array of numbers; of texts, where they are none."""
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


class Frames(Sequence):
    """The frames of a run, in the order of time."""

    def __init__(self, path):
        self._path = path
        self.times, self._steps, self._counts, self._numbers, self._parts = np.array([]), [], [], [], []
        self.materials, self.fields = [], {}
        if not path.is_file():
            return
        with h5py.File(path, "r", locking=False) as file:
            root = file["VTKHDF"]
            steps = root["Steps"]
            #: Time of each frame [s].
            self.times = steps["Values"][:]
            self._steps, self._counts = steps["StepsTaken"][:], root["NumberOfPoints"][:]
            self._numbers = steps["FileNumber"][:]
            # one file each, where it is not said
            self._parts = steps["FileParts"][:] if "FileParts" in steps else np.ones(len(self.times), int)
            for name, column in root["PointData"].items():
                about = column.attrs
                if name == "material":
                    names = about.get("names", [])
                    # very many are lines of one text
                    self.materials = names.split("\n") if isinstance(names, str) else [str(it) for it in names]
                elif name != "id":
                    width = column.shape[1] if column.ndim > 1 else 1
                    codes = tuple(str(it) for it in about.get("codes", []))
                    self.fields[name] = Field(name, about["unit"], about.get("meaning", ""), width, codes)

    def __len__(self):
        return len(self.times)

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        if not -len(self) <= k < len(self):
            raise IndexError(f"there is no frame {k}: the run has {len(self)}")
        return Frame(self, k % len(self))

    def _column(self, k, name):
        # the files of the frame: where one is missing or damaged the index would show other numbers
        paths = [self._path.with_name("particles") / file for file in _files(self._numbers[k], self._parts[k])]
        parts = []
        for path in paths:
            try:
                with h5py.File(path, "r", locking=False) as file:
                    parts.append(file[name][:])
            except (OSError, KeyError) as error:
                raise OSError(f"frame {k} cannot be read: {path}: {error}") from error
        column = parts[0] if len(parts) == 1 else np.concatenate(parts)
        if len(column) != self._counts[k]:
            raise OSError(f"frame {k} cannot be read: {paths[0]} and its other parts have {len(column)} particles and not {self._counts[k]}")
        return column


def _files(number, parts):
    """Names of the files of a frame: one, or one of each rank."""
    return [f"{number:06}.h5"] if parts == 1 else [f"{number:06}-{part + 1}of{parts}.h5" for part in range(parts)]


class Frame(Mapping):
    """The particles at one time: columns by name, a row a particle."""

    def __init__(self, frames, k, rows=None):
        self._frames, self._k, self._rows = frames, k, rows
        #: Time [s] and steps taken.
        self.time, self.step = float(frames.times[k]), int(frames._steps[k])
        self._read = {}

    # two frames are the same if they are one
    __eq__, __hash__ = object.__eq__, object.__hash__

    def __repr__(self):
        return f"<frame {self._k} at {self.time:g} s: {len(self.id)} particles with {', '.join(self)}>"

    def _column(self, name):
        if name not in self._read:
            column = self._frames._column(self._k, name)
            self._read[name] = column if self._rows is None else column[self._rows]
        return self._read[name]

    def __getitem__(self, name):
        if name not in self._frames.fields:
            raise KeyError(f"{name}: the frames have {', '.join(self._frames.fields)}; output.fields of a scene says what they show")
        return self._column(f"PointData/{name}")

    def __iter__(self):
        return iter(self._frames.fields)

    def __len__(self):
        return len(self._frames.fields)

    @property
    def position(self):
        """Positions [m]."""
        return self._column("Points")

    @property
    def id(self):
        """Identities: the same for a particle in all frames."""
        return self._column("PointData/id")

    @property
    def material(self):
        """Indices of materials."""
        return self._column("PointData/material")

    def of(self, material):
        """The particles of a material, by its name."""
        names = self._frames.materials
        if material not in names:
            raise KeyError(f"{material}: the materials are {', '.join(names)}")
        return self.where(self.material == names.index(material))

    def where(self, rows):
        """Some of the particles: rows by number, or a mask."""
        rows = np.arange(len(self.id))[rows if isinstance(rows, slice) else np.asarray(rows, dtype=None if len(rows) else int)]
        return Frame(self._frames, self._k, rows if self._rows is None else self._rows[rows])

    def sorted(self):
        """The same particles in the order of their identities, which is the same in all frames."""
        return self.where(np.argsort(self.id))

    def pyvista(self):
        """As points of pyvista, with all columns."""
        import pyvista

        points = pyvista.PolyData(self.position.astype(float))
        if len(self.id):
            points.point_data["id"], points.point_data["material"] = self.id, self.material
            for name in self:
                points.point_data[name] = self[name]
        points.field_data["TimeValue"] = [self.time]
        points.field_data["material_names"] = self._frames.materials
        return points
