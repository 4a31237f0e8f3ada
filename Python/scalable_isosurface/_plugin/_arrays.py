# SPDX-License-Identifier: BSD-3-Clause
"""Arrays, grids and field data of VTK."""

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util import numpy_support
from vtkmodules.util.vtkConstants import VTK_ID_TYPE, VTK_INT
from vtkmodules.vtkCommonCore import vtkDataArray, vtkStringArray, vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

VTK_VERSION = 100 * vtkVersion.GetVTKMajorVersion() + vtkVersion.GetVTKMinorVersion()
MEBIBYTE = 1 << 20
#: In field data: the extent of the volume that an image is a part of.
WHOLE_EXTENT = "BlockedVolumeExtent"
ID_TYPES = {4: VTK_INT, 8: VTK_ID_TYPE}


def to_vtk(values, name="", kind=None):
    """An array of VTK on the memory of one of NumPy."""
    array = numpy_support.numpy_to_vtk(values, array_type=kind)
    array.SetName(name)
    return array


def make_cells(offsets, corners):
    """A vtkCellArray on the memory of two arrays of NumPy."""
    cells = model.vtkCellArray()
    given = [(values, to_vtk(values, "", ID_TYPES[values.dtype.itemsize])) for values in (offsets, corners)]
    cells.SetData(*(array for _, array in given))
    for (values, _), array in zip(given, (cells.GetOffsetsArray(), cells.GetConnectivityArray())):
        array._numpy_reference = values  # VTK before 9.6 has arrays of its own on this memory
    return cells


def set_times(info, times):
    """Tells the times of a source."""
    for key in (Pipeline.TIME_STEPS(), Pipeline.TIME_RANGE()):
        info.Remove(key)
    times = [time for time in times if time is not None]
    if times:
        info.Set(Pipeline.TIME_STEPS(), times, len(times))
        info.Set(Pipeline.TIME_RANGE(), (times[0], times[-1]), 2)


def find_piece(info):
    piece, pieces = info.Get(Pipeline.UPDATE_PIECE_NUMBER()), info.Get(Pipeline.UPDATE_NUMBER_OF_PIECES())
    return (piece or 0, pieces) if pieces else (0, 1)


def make_extent(grid, low, high):
    """Of the vertices [low, high)."""
    return tuple(int(end + first) for pair in zip(low, high - 1, grid[7]) for first in pair[2:] for end in pair[:2])


def make_image(grid, low, high):
    """The vertices [low, high) of a grid, without arrays."""
    extent = make_extent(grid, low, high)
    if grid[4]:
        image = model.vtkRectilinearGrid()
        image.SetExtent(extent)
        for axis, put in enumerate((image.SetXCoordinates, image.SetYCoordinates, image.SetZCoordinates)):
            put(to_vtk(numpy.array(grid[4][axis][low[axis] : high[axis]])))
        return image
    image = model.vtkImageData()
    image.SetExtent(extent)
    image.SetSpacing(grid[1])
    image.SetOrigin(grid[8])
    image.SetDirectionMatrix(grid[3])
    return image


def add_array(image, values, unit=""):
    if unit:
        values.GetInformation().Set(vtkDataArray.UNITS_LABEL(), unit)
    data = image.GetPointData()
    data.AddArray(values)
    if not data.GetScalars():
        data.SetActiveScalars(values.GetName())


def store_units(output, file, grid):
    """What the plugin in C++ tells in field data: the unit of length, and those of arrays."""
    if grid[6]:
        add_texts(output, "PhysicalSizeUnit", [grid[6]] * 3)
    for name, *_, unit in file.arrays:
        if unit:
            add_texts(output, f"{name} Unit", [unit])


def add_texts(data, name, texts):
    data.GetFieldData().AddArray(to_texts(texts, name))


def to_texts(texts, name=""):
    array = vtkStringArray()
    array.SetName(name)
    for text in texts:
        array.InsertNextValue(text)
    return array


def find_points(data):
    """The points of a dataset."""
    if data.IsA("vtkPointSet"):
        return numpy_support.vtk_to_numpy(data.GetPoints().GetData()) if data.GetPoints() else numpy.empty((0, 3))
    if data.IsA("vtkRectilinearGrid"):
        lines = [data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates()]
        x, y, z = (numpy_support.vtk_to_numpy(line).astype(float) for line in lines)
    else:
        extent = data.GetExtent()
        x, y, z = (numpy.arange(extent[2 * axis], extent[2 * axis + 1] + 1.0) for axis in range(3))
    points = numpy.stack(numpy.meshgrid(z, y, x, indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    if data.IsA("vtkImageData"):
        direction = data.GetDirectionMatrix()
        matrix = numpy.array([[direction.GetElement(row, column) for column in range(3)] for row in range(3)])
        points = (points * data.GetSpacing()) @ matrix.T + data.GetOrigin()
    return points


def list_leaves(composite, numbers=False):
    """`numbers`: with their flat numbers."""
    iterator = composite.NewIterator()
    while not iterator.IsDoneWithTraversal():
        leaf = iterator.GetCurrentDataObject()
        yield (leaf, iterator.GetCurrentFlatIndex()) if numbers else leaf
        iterator.GoToNextItem()
