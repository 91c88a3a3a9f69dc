"""Reads what a run left as VTK does, and ends with 1 where NAME.vtkhdf holds anything else than the many NAME-0000.vtu."""
import glob
import sys

import numpy as np
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy


def arrays(grid):
    data = grid.GetPointData()
    found = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
    found["points"] = vtk_to_numpy(grid.GetPoints().GetData())
    found["corners"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    found["types"] = np.array([grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())])
    return found


def steps(file):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(file)
    reader.UpdateInformation()
    key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = [reader.GetOutputInformation(0).Get(key, n) for n in range(reader.GetNumberOfSteps())]
    for time in times:
        reader.UpdateTimeStep(time)
        yield arrays(reader.GetOutputDataObject(0))


def main(folder):
    files = sorted(glob.glob(folder + "/**/*.vtkhdf", recursive=True))
    for file in files:
        many = sorted(glob.glob(glob.escape(file[: -len(".vtkhdf")]) + "-[0-9]*.vtu"))
        found = list(steps(file))
        assert len(found) == len(many) > 1, (file, len(found), len(many))
        for name, step in zip(many, found):
            reader = vtk.vtkXMLUnstructuredGridReader()
            reader.SetFileName(name)
            reader.Update()
            expected = arrays(reader.GetOutput())
            assert {key.replace("/", "|") for key in expected} == set(step), (name, list(expected), list(step))
            for key, values in expected.items():
                assert np.array_equal(values, step[key.replace("/", "|")]), (name, key)
    print(len(files), "files")


main(sys.argv[1])
