"""Exports frames of a run in every format and compares what other programs read with the run's own frames.

usage: check_export.py SINEW RUN [--viewers]
With --viewers PyVista, pandas and OVITO read them, too; else what they need need not be there.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

sys.path.insert(0, str(Path(__file__).parents[2] / "python"))
import sinew  # noqa: E402


def export(binary, run, name, out):
    command = [binary, "export", str(run), "--format", name, "--out", str(out)]
    return Path(subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip())


def same(one, other, what):
    one, other = np.asarray(one), np.asarray(other)
    assert one.shape == other.shape, (what, one.shape, other.shape)
    assert np.array_equal(one, other, equal_nan=one.dtype.kind == "f"), what


def check_vtp(collection, run):
    times = [line.split('"')[1] for line in collection.read_text().splitlines() if "timestep" in line]
    same([float(time) for time in times], run.frames.times, "times")
    for k, frame in enumerate(run.frames):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(collection.with_name(f"frame-{k:06}.vtp")))
        reader.Update()
        data, frame = reader.GetOutput(), frame.sorted()
        assert data.GetNumberOfVerts() == data.GetNumberOfPoints() == len(frame.id)
        same(vtk_to_numpy(data.GetPoints().GetData()), frame.position, "positions")
        arrays = data.GetPointData()
        same(vtk_to_numpy(arrays.GetArray("id")), frame.id, "id")
        same(vtk_to_numpy(arrays.GetArray("material")), frame.material, "material")
        for name in frame:
            same(vtk_to_numpy(arrays.GetArray(name)), frame[name], name)
        names = data.GetFieldData().GetAbstractArray("material_names")
        assert [names.GetValue(i) for i in range(names.GetNumberOfValues())] == run.materials
        assert data.GetFieldData().GetArray("TimeValue").GetValue(0) == frame.time
    print(f"vtp: {len(run.frames)} frames agree")


def check_csv(last, run):
    frame = run.frames[-1].sorted()
    with open(last.with_name(f"frame-{len(run.frames) - 1:06}.csv")) as file:
        header = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",", dtype=np.float64, ndmin=2)
    columns = [frame.id[:, None], frame.material[:, None], frame.position]
    columns += [frame[name].reshape(len(frame.id), -1) for name in frame]
    same(table.astype(np.float32), np.hstack(columns).astype(np.float32), "csv")
    assert len(header) == table.shape[1], header
    print("csv: the last frame agrees")


def check_ovito(path, run):
    from ovito.io import import_file

    pipeline = import_file(str(path))
    assert pipeline.source.num_frames == len(run.frames), pipeline.source.num_frames
    for k, frame in enumerate(run.frames):
        frame, seen = frame.sorted(), pipeline.compute(k).particles
        assert seen.count == len(frame.id)
        same(seen["Particle Identifier"][...], frame.id.astype(int), "id")
        same(seen["Particle Type"][...], frame.material.astype(int), "material")
        same(seen["Position"][...].astype(np.float32), frame.position, "positions")
        same(seen["Velocity"][...].astype(np.float32), frame["velocity"], "velocity")
        same(seen["von_mises"][...].astype(np.float32), frame["von_mises"], "von_mises")
    print(f"OVITO: {path.name}, {len(run.frames)} frames agree")


def check_pyvista(collection, run):
    import pyvista

    reader = pyvista.get_reader(str(collection))
    assert list(reader.time_values) == list(run.frames.times)
    reader.set_active_time_value(reader.time_values[-1])
    seen, frame = reader.read()[0], run.frames[-1].sorted()
    same(seen.points, frame.position, "positions")
    same(seen["velocity"], frame["velocity"], "velocity")
    # of the run's own file it sees the first frame alone
    seen = pyvista.read(str(run.folder / "particles.vtkhdf"))
    assert seen.n_points == len(run.frames[0].id), seen.n_points
    points = run.frames[-1].of(run.materials[-1]).pyvista()
    assert points.n_points == (run.frames[-1].material == len(run.materials) - 1).sum()
    assert run.history.table()["time_s"].iloc[-1] == run.history["time_s"][-1]
    print("PyVista and pandas: times and arrays agree")


def main(binary, folder, viewers):
    run = sinew.read(folder)
    with tempfile.TemporaryDirectory() as out:
        exported = {name: export(binary, folder, name, Path(out) / name) for name in ("vtp", "csv", "netcdf", "lammps")}
        check_vtp(exported["vtp"], run)
        check_csv(exported["csv"], run)
        if viewers:
            check_pyvista(exported["vtp"], run)
            check_ovito(exported["netcdf"], run)
            check_ovito(exported["lammps"], run)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], "--viewers" in sys.argv[3:])
