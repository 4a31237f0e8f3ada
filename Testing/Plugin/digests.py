# SPDX-License-Identifier: BSD-3-Clause
"""Digests of the arrays of VTK's data, for scripts that compare what two plugins make."""
import hashlib
import json

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy


def write(data, stem, algorithm):
    """Writes those of this rank into STEM and the number of the rank."""
    from vtkmodules.vtkParallelCore import vtkMultiProcessController

    controller = vtkMultiProcessController.GetGlobalController()
    rank = controller.GetLocalProcessId() if controller else 0
    with open(f"{stem}{rank}", "w") as file:
        json.dump(describe(data), file)
    if controller:
        controller.Barrier()


def describe(data):
    if data.IsA("vtkCompositeDataSet"):
        iterator = data.NewIterator()
        parts = []
        while not iterator.IsDoneWithTraversal():
            parts.append(describe(iterator.GetCurrentDataObject()))
            iterator.GoToNextItem()
        return parts
    found = {"class": data.GetClassName()}
    if data.IsA("vtkTable"):
        found["rows"] = list_arrays(data.GetRowData())
        return found
    found["size"] = [data.GetNumberOfPoints(), data.GetNumberOfCells()]
    if data.IsA("vtkPolyData"):
        if data.GetPoints() and data.GetNumberOfPoints():
            found["points"] = digest(data.GetPoints().GetData())
        for name, cells in (("polygons", data.GetPolys()), ("lines", data.GetLines())):
            if cells.GetNumberOfCells():
                found[name] = [digest(cells.GetConnectivityArray()), digest(cells.GetOffsetsArray())]
    elif data.IsA("vtkImageData"):
        found["place"] = [data.GetExtent(), data.GetOrigin(), data.GetSpacing()]
    found["on points"] = list_arrays(data.GetPointData())
    found["on cells"] = list_arrays(data.GetCellData())
    return found


def list_arrays(data):
    arrays = [data.GetArray(number) for number in range(data.GetNumberOfArrays())]
    return {array.GetName(): digest(array) for array in arrays if array and array.GetNumberOfTuples()}


def digest(array):
    values = numpy.ascontiguousarray(vtk_to_numpy(array))
    return [str(values.dtype), list(values.shape), hashlib.sha256(values.tobytes()).hexdigest()[:16]]
