# SPDX-License-Identifier: BSD-3-Clause
"""Images in memory, and rectilinear grids, as pieces for the library."""

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkDataArray
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkFiltersCore import vtkCellDataToPointData

from .. import _library
from ._arrays import list_leaves, WHOLE_EXTENT

POINTS, CELLS, POINTS_THEN_CELLS = 0, 1, 3  # associations of vtkDataObject
Flags = model.vtkDataSetAttributes


def list_images(data, path=()):
    """The datasets of a tree, each with the path of its block: partitions of a block have one path."""
    if data is None:
        return
    if data.IsA("vtkMultiBlockDataSet"):
        for number in range(data.GetNumberOfBlocks()):
            yield from list_images(data.GetBlock(number), (*path, number))
    elif data.IsA("vtkPartitionedDataSetCollection"):
        for number in range(data.GetNumberOfPartitionedDataSets()):
            yield from list_images(data.GetPartitionedDataSet(number), (*path, number))
    elif data.IsA("vtkPartitionedDataSet"):
        for number in range(data.GetNumberOfPartitions()):
            yield from list_images(data.GetPartitionAsDataObject(number), path)
    elif data.IsA("vtkCompositeDataSet"):
        for leaf, number in list_leaves(data, numbers=True):
            yield from list_images(leaf, (*path, number))
    elif data.IsA("vtkImageData") or data.IsA("vtkRectilinearGrid"):
        if data.GetNumberOfPoints():
            yield data, path
    else:
        raise ValueError(
            f"the input has a {data.GetClassName()}, but only image data and rectilinear grids can be contoured here: "
            "take Contour, or put Resample To Image in front"
        )


def name_block(data, path):
    """The names on the way to a block."""
    names = []
    for number in path:
        if data is None or not (data.IsA("vtkMultiBlockDataSet") or data.IsA("vtkPartitionedDataSetCollection")):
            break
        info = data.GetMetaData(number) if data.HasMetaData(number) else None
        if info and info.Has(model.vtkCompositeDataSet.NAME()):
            names.append(info.Get(model.vtkCompositeDataSet.NAME()))
        data = data.GetBlock(number) if data.IsA("vtkMultiBlockDataSet") else data.GetPartitionedDataSet(number)
    return "/".join(names)


def find_array(image, info):
    """The array that a filter's GetInputArrayInformation means, and what it is on; None if the image lacks it."""
    name = info.Get(model.vtkDataObject.FIELD_NAME())
    for place, data in ((POINTS, image.GetPointData()), (CELLS, image.GetCellData())):
        if info.Get(model.vtkDataObject.FIELD_ASSOCIATION()) in (place, POINTS_THEN_CELLS):
            array = data.GetArray(name) if name else data.GetScalars()
            if array:
                return array, place
    return None, POINTS


def tell_missing(data, name):
    text = "the input has no point array " + (f'"{name}"' if name else "that is active") + " to contour"
    for image, _ in list_images(data):
        cells = image.GetCellData()
        arrays = [cells.GetArray(number) for number in range(cells.GetNumberOfArrays())]
        names = [f'"{array.GetName()}"' for array in arrays if array and array.GetName() != Flags.GhostArrayName()]
        if names:
            return f"{text}; it has the cell arrays {', '.join(names)}, which can be chosen as such"
    return text


class Pieces:
    """The pieces of this rank. An array on cells becomes one on points, as vtkCellDataToPointData does it."""

    def __init__(self, filter_info, data, input_info, chosen, interpolated, with_scalars):
        self.pieces, self.name, self.component_names = [], "", []
        self.are_there = False
        self.components = 1
        for image, path in list_images(data):
            self.are_there = True
            array, place = find_array(image, filter_info)
            if not array:
                continue
            self.name = array.GetName() or self.name
            self.components = array.GetNumberOfComponents()
            if self.components > 1 and not 0 <= chosen <= self.components:
                raise ValueError(f'array "{self.name}" has {self.components} components, and no component {chosen}')
            names = [name for name in interpolated if not (with_scalars and name == self.name)]
            arrays = [array if place == POINTS else average(image, array), *(find_interpolated(image, name) for name in names)]
            self.component_names = [
                (name, [one.GetComponentName(n) for n in range(one.GetNumberOfComponents())])
                for name, one in zip(names, arrays[1:])
            ]
            samples = [take_samples(image, one) for one in arrays]
            whole = find_whole(image, input_info if image is data else None)
            identity = max(image.GetMTime(), *(one.GetMTime() for one in arrays))
            hidden = find_hidden(image)
            grid, lines = describe(image)
            self.pieces.append(
                _library.Piece(grid, lines, samples, hidden, path, identity, whole=whole, own=find_own(image))
            )


def take_samples(image, array):
    """Name, type, components and memory."""
    name, tuples = array.GetName() or "", array.GetNumberOfTuples()
    if tuples != image.GetNumberOfPoints():
        raise ValueError(f'array "{name}" has {tuples} values for {image.GetNumberOfPoints()} points')
    if not array.HasStandardMemoryLayout():
        plain = vtkDataArray.CreateDataArray(array.GetDataType())
        plain.DeepCopy(array)
        array = plain
    samples = numpy_support.vtk_to_numpy(array) if array.GetDataTypeAsString() != "bit" else numpy.empty(0, bool)
    if samples.dtype.name not in _library.VALUE_TYPES:
        raise ValueError(f'array "{name}" is of type {array.GetDataTypeAsString()}, which has no isosurfaces')
    return name, samples.dtype.name, array.GetNumberOfComponents(), samples


def find_interpolated(image, name):
    array, cells = image.GetPointData().GetArray(name), image.GetCellData().GetArray(name)
    if not array and cells:
        array = average(image, cells)
    if not array or array.GetNumberOfTuples() != image.GetNumberOfPoints():
        raise ValueError(f'the input has no numeric point array or cell array "{name}" to interpolate everywhere')
    return array


def average(image, cells):
    if any(flags is not None for flags in find_hidden(image)):
        raise ValueError(f'array "{cells.GetName()}" is on cells, some of which are hidden: the plugin in C++ contours it')
    alone = image.NewInstance()
    alone.CopyStructure(image)
    alone.GetCellData().AddArray(cells)
    averages = vtkCellDataToPointData()
    averages.SetInputData(alone)
    averages.Update()
    return averages.GetOutput().GetPointData().GetArray(cells.GetName())


def find_whole(image, info):
    """The extent of what an image is declared to be a part of."""
    if info is not None and image.IsA("vtkImageData") and info.Has(Pipeline.WHOLE_EXTENT()):
        return info.Get(Pipeline.WHOLE_EXTENT())
    array = image.GetFieldData().GetArray(WHOLE_EXTENT)
    if not array or array.GetNumberOfComponents() != 6 or array.GetNumberOfTuples() != 1:
        return None
    whole, extent = [int(end) for end in array.GetTuple(0)], image.GetExtent()
    contains = all(a <= b for a, b in zip(whole[::2], extent[::2])) and all(a >= b for a, b in zip(whole[1::2], extent[1::2]))
    return whole if contains else None


def find_flags(array, count, bits):
    """Whether any of the bits is set, a byte for each of `count`; None if none is set."""
    if not array or array.GetNumberOfValues() != count:
        return None
    flags = ((numpy_support.vtk_to_numpy(array) & int(bits)) != 0).astype(numpy.uint8)
    return flags if flags.any() else None


def find_hidden(image):
    """Cells and vertices that are hidden."""
    if not image.IsA("vtkUniformGrid"):
        return None, None
    bits = Flags.HIDDENCELL | Flags.REFINEDCELL
    cells = find_flags(image.GetCellGhostArray(), image.GetNumberOfCells(), bits)
    return cells, find_flags(image.GetPointGhostArray(), image.GetNumberOfPoints(), Flags.HIDDENPOINT)


def find_own(image):
    """The vertices of the cells that are no copies of another piece's, from the first vertex on; None: all."""
    copies = find_flags(image.GetCellGhostArray(), image.GetNumberOfCells(), Flags.DUPLICATECELL)
    if copies is None:
        return None
    own = copies.reshape([max(1, size - 1) for size in image.GetDimensions()[::-1]]) == 0
    box = []
    for axis in range(3):
        there = numpy.flatnonzero(own.any(axis=tuple(2 - other for other in range(3) if other != axis)))
        box += [int(there[0]), int(there[-1]) + 2] if len(there) else [0, 0]
    return box


def describe(image):
    """Members of si_grid, and the lines of a rectilinear grid."""
    extent = image.GetExtent()
    grid = {"dimensions": image.GetDimensions(), "first": extent[::2]}
    if image.IsA("vtkRectilinearGrid"):
        lines = (image.GetXCoordinates(), image.GetYCoordinates(), image.GetZCoordinates())
        identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        return {**grid, "spacing": (1.0,) * 3, "direction": identity}, [
            numpy_support.vtk_to_numpy(line).astype(float).tolist() for line in lines
        ]
    matrix, zero = image.GetDirectionMatrix(), image.GetOrigin()
    direction = tuple(matrix.GetElement(row, column) for row in range(3) for column in range(3))
    return {**grid, "spacing": image.GetSpacing(), "direction": direction, "origin": zero, "zero": zero}, None
