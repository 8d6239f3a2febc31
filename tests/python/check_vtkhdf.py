"""Opens a particle file with h5py, with VTK's own reader and with Sinew's package and compares every frame.

usage: check_vtkhdf.py FILE
VTK accepts many broken files and returns fewer points or arrays in silence, so counts and arrays are compared.
"""
import sys
from pathlib import Path

import h5py
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

sys.path.insert(0, str(Path(__file__).parents[2] / "python"))
import sinew  # noqa: E402


def main(path):
    with h5py.File(path, "r", locking=False) as file:
        root = file["VTKHDF"]
        steps = root["Steps"]
        frames = int(steps.attrs["NSteps"])
        assert root.attrs["Type"] == b"PolyData", root.attrs["Type"]
        times = steps["Values"][:frames]
        if frames == 0:
            return print("no frames")

        reader = vtk.vtkHDFReader()
        assert reader.CanReadFile(path)
        reader.SetFileName(path)
        reader.UpdateInformation()
        assert reader.GetNumberOfSteps() == frames, reader.GetNumberOfSteps()
        key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        seen = reader.GetOutputInformation(0).Get(key)
        # VTK gives a file of one frame no time.
        assert frames == 1 or np.array_equal(seen, times), (seen, times)

        ours = sinew.Frames(Path(path))
        assert len(ours) == frames, len(ours)
        for k, time in enumerate(times):
            start, count = int(steps["PointOffsets"][k]), int(root["NumberOfPoints"][k])
            rows = slice(start, start + count)
            reader.UpdateTimeStep(time)
            data = reader.GetOutputDataObject(0)
            if data.IsA("vtkPartitionedDataSet"):
                data = data.GetPartition(0)
            assert data.GetNumberOfPoints() == count, (k, data.GetNumberOfPoints(), count)
            assert data.GetNumberOfVerts() == data.GetNumberOfCells() == count
            if count == 0:
                continue
            assert np.array_equal(vtk_to_numpy(data.GetVerts().GetConnectivityArray()), np.arange(count))
            assert np.array_equal(vtk_to_numpy(data.GetPoints().GetData()), root["Points"][rows])
            assert np.array_equal(ours[k].position, root["Points"][rows]), k
            arrays = data.GetPointData()
            assert arrays.GetNumberOfArrays() == len(root["PointData"]), (k, arrays.GetNumberOfArrays())
            for name, column in root["PointData"].items():
                array = arrays.GetArray(name)
                assert array is not None, (k, name)
                read = vtk_to_numpy(array)
                assert read.dtype == column.dtype, (name, read.dtype)
                floats = column.dtype.kind == "f"
                assert np.array_equal(read, column[rows], equal_nan=floats), (k, name)
                assert np.array_equal(ours[k]._column(f"PointData/{name}"), column[rows], equal_nan=floats), (k, name)
                assert name in ("id", "material") or "unit" in column.attrs, name
                # bytes were written until a scene could have more than 256 materials
                assert name != "material" or column.dtype in (np.uint8, np.uint16), column.dtype
            print(f"frame {k}: t = {time:g} s, {count} particles, {arrays.GetNumberOfArrays()} arrays agree")


if __name__ == "__main__":
    main(sys.argv[1])
