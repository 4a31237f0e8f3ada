# SPDX-License-Identifier: BSD-3-Clause
"""Volume Slice, Volume Region and Volume Probe."""

import contextlib
import os

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util import numpy_support
from vtkmodules.util.vtkConstants import VTK_CHAR
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkExecutive, vtkExtentTranslator
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkFiltersCore import vtkFlyingEdges2D

from ._arrays import add_array, find_piece, find_points, list_leaves, make_cells, make_extent, make_image, MEBIBYTE
from ._arrays import set_times, store_units, to_vtk
from ._polygons import add_box
from ._surfaces import Consumer


class ImageConsumer(Consumer):
    """Gives an image of which each rank has a piece."""

    def __init__(self, **types):
        super().__init__(inputs=1, **types)
        self._text = ""

    def GetShownText(self):
        return self._text

    def RequestInformation(self, request, inputs, outputs):
        for port in range(outputs.GetNumberOfInformationObjects()):
            outputs.GetInformationObject(port).Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        with contextlib.suppress(Exception):  # RequestData tells it
            reader, file, step = self.take_volume(outputs)
            if file.path.endswith(b".bvol"):
                self.tell(outputs, *self.plan(reader, file, step)[:2])
        return 1

    @staticmethod
    def tell(outputs, grid, extent):
        info = outputs.GetInformationObject(0)
        info.Set(Pipeline.WHOLE_EXTENT(), extent, 6)
        info.Set(Pipeline.UPDATE_EXTENT(), extent, 6)
        info.Set(model.vtkDataObject.ORIGIN(), grid[8], 3)
        info.Set(model.vtkDataObject.SPACING(), grid[1], 3)

    def RequestData(self, request, inputs, outputs):
        return self.run(outputs, lambda: self.fill(request, outputs))

    def fill(self, request, outputs):
        reader, file, step = self.take_volume(outputs)
        plan = self.plan(reader, file, step)
        self.tell(outputs, *plan[:2])
        port = max(0, request.Get(vtkExecutive.FROM_OUTPUT_PORT()))
        piece, pieces = find_piece(outputs.GetInformationObject(port))
        extent = [0, -1, 0, -1, 0, -1]
        there = vtkExtentTranslator().PieceToExtentThreadSafe(
            piece, pieces, 0, plan[1], extent, vtkExtentTranslator.BLOCK_MODE, 0
        )
        low, high = (numpy.array(ends) - plan[0][7] for ends in (extent[::2], numpy.array(extent[1::2]) + 1))
        output = model.vtkDataObject.GetData(outputs, 0)
        output.Initialize()
        if there and (low < high).all():
            image = self.make(reader, file, step, plan, low, high)
            store_units(image, file, plan[0])
            image.GetFieldData().AddArray(to_vtk(numpy.array([plan[2]], float), "Level"))
            output.ShallowCopy(image)


class vtkVolumeSlice(ImageConsumer):
    """The samples on a plane, and their isolines."""

    def __init__(self):
        super().__init__(outputs=2, outputType="vtkImageData")
        self._plan = None, None

    def FillOutputPortInformation(self, port, info):
        info.Set(model.vtkDataObject.DATA_TYPE_NAME(), "vtkPolyData" if port else "vtkImageData")
        return 1

    def GetFinal(self):
        return 1

    def cut(self, file, array, step):
        values = self.values
        cut = file.slice((array, 0, step, 0), values["Origin"], values["Normal"], 1e6 * values["MaximumPoints"])
        if cut is None:
            raise ValueError(f"{os.fsdecode(file.path)}: the plane is beside the volume, or its normal is 0")
        return cut

    def plan(self, reader, file, step):
        """Grid, extent, level, and the slice of the first array."""
        first = (reader.list_arrays() or [0])[0]
        wanted = (file, first, step, self.GetMTime())
        if self._plan[0] != wanted:
            cut = self.cut(file, first, step)
            grid, level = cut[:2]
            self._plan = wanted, (grid, make_extent(grid, numpy.zeros(3, int), numpy.array(grid[0])), level, (first, cut))
        return self._plan[1]

    def make(self, reader, file, step, plan, low, high):
        grid, _, level, first = plan
        image = make_image(grid, low, high)
        part = slice(low[1], high[1]), slice(low[0], high[0])
        inside = first[1][3]
        for array in reader.list_arrays():
            name, _, components, unit = file.arrays[array]
            cut = first[1] if array == first[0] else self.cut(file, array, step)
            values = cut[2][part].reshape(-1, components).copy()
            if not self.values["Interpolation"]:
                file.probe((array, 0, step, level), True, find_points(image), values)
            for component in range(components):
                values[~inside[part].ravel().astype(bool), component] = file.range((array, component, step, 0))[0]
            add_array(image, to_vtk(values, name), unit)
            reader.tell_range(image.GetPointData().GetArray(name), array, step)
        if not inside.all():
            hidden = numpy.where(inside[part].ravel(), 0, model.vtkDataSetAttributes.HIDDENPOINT).astype(numpy.uint8)
            image.GetPointData().AddArray(to_vtk(hidden, model.vtkDataSetAttributes.GhostArrayName()))
        full = "full resolution" if level == 0 else f"level {level}"
        self._text = f"{grid[0][0]} x {grid[0][1]} points, {full}"
        return image

    def fill(self, request, outputs):
        lines = model.vtkPolyData.GetData(outputs, 1)
        lines.Initialize()
        super().fill(request, outputs)
        image = model.vtkImageData.GetData(outputs, 0)
        name = self.values["IsolineArray"]
        data = image.GetPointData()
        array = data.GetArray(name) if name else data.GetScalars()
        if not self.values["Isolines"] or min(image.GetDimensions()[:2]) < 2:
            return
        if not array:
            self.warn(f'there are no isolines: the slice has no array "{name}"')
            return
        scalars = model.vtkImageData()
        scalars.CopyStructure(image)
        scalars.GetPointData().SetScalars(array)
        contour = vtkFlyingEdges2D()
        contour.SetInputData(scalars)
        for number, value in enumerate(self.values["Isolines"]):
            contour.SetValue(number, value)
        contour.Update()
        lines.ShallowCopy(contour.GetOutput())
        if data.GetArray(model.vtkDataSetAttributes.GhostArrayName()):
            remove_hidden_lines(image, lines)


def remove_hidden_lines(image, lines):
    """Drops the lines in cells with a hidden point."""
    columns, rows, _ = image.GetDimensions()
    hidden = numpy_support.vtk_to_numpy(image.GetPointGhostArray()).reshape(rows, columns) > 0
    cells = hidden[:-1, :-1] | hidden[1:, :-1] | hidden[:-1, 1:] | hidden[1:, 1:]
    if lines.GetNumberOfLines() == 0:
        return
    ends = numpy_support.vtk_to_numpy(lines.GetLines().GetConnectivityArray()).reshape(-1, 2)
    middles = numpy_support.vtk_to_numpy(lines.GetPoints().GetData())[ends].mean(axis=1)
    matrix = numpy.array(
        [[image.GetPhysicalToIndexMatrix().GetElement(row, column) for column in range(4)] for row in range(4)]
    )
    places = middles @ matrix[:3, :3].T + matrix[:3, 3] - numpy.array(image.GetExtent()[::2])
    x, y = (numpy.clip(places[:, axis].astype(int), 0, size - 2) for axis, size in enumerate((columns, rows)))
    used, corners = numpy.unique(ends[~cells[y, x]], return_inverse=True)
    corners = numpy.ascontiguousarray(corners.ravel(), numpy.int64)
    points = vtkPoints()
    points.SetData(to_vtk(numpy_support.vtk_to_numpy(lines.GetPoints().GetData())[used]))
    scalars = lines.GetPointData().GetScalars()
    values = to_vtk(numpy_support.vtk_to_numpy(scalars)[used], scalars.GetName())
    lines.Initialize()
    lines.SetPoints(points)
    lines.SetLines(make_cells(numpy.arange(0, len(corners) + 1, 2), corners))
    lines.GetPointData().SetScalars(values)


class vtkVolumeRegion(ImageConsumer):
    """The samples in a box."""

    def __init__(self):
        super().__init__(outputType="vtkDataObject")

    def RequestDataObject(self, request, inputs, outputs):
        reader = self.find_reader()
        isLined = bool(reader and reader.file and reader.file.describe(0)[4])
        kind = model.vtkRectilinearGrid if isLined else model.vtkImageData
        info = outputs.GetInformationObject(0)
        data = model.vtkDataObject.GetData(info)
        if not data or not data.IsA(kind.__name__):
            info.Set(model.vtkDataObject.DATA_OBJECT(), kind())
        return 1

    def plan(self, reader, file, step):
        """Grid, extent and level."""
        low, high = find_vertices(file.describe(0), add_box(self.values["Position"], self.values["Length"]))
        if (low >= high).any():
            raise ValueError(f"{os.fsdecode(file.path)}: the box is beside the volume")
        sizes = [numpy.dtype(file.arrays[array][1]).itemsize * file.arrays[array][2] for array in reader.list_arrays()]
        limit = self.values["MemoryLimit"] * MEBIBYTE * (self.ranks.count if self.ranks else 1)
        for level in range(file.levels):
            grid = file.describe(level)
            last = numpy.array(grid[0]) - 1
            first = numpy.minimum(last, low >> level)
            end = numpy.minimum(last, (high + (1 << level) - 2) >> level) + 1
            if sum(sizes) * float(numpy.prod((end - first).astype(float))) <= limit:
                return grid, make_extent(grid, first, end), level
        raise ValueError(
            f"{os.fsdecode(file.path)}: not even the coarsest level of the box fits the memory limit of "
            f"{self.values['MemoryLimit']} MiB"
        )

    def make(self, reader, file, step, plan, low, high):
        image = make_image(plan[0], low, high)
        reader.read_arrays(image, reader.list_arrays(), step, plan[2], low, high)
        size = " x ".join(str(last - first + 1) for first, last in zip(plan[1][::2], plan[1][1::2]))
        self._text = f"{size} samples, " + ("full resolution" if plan[2] == 0 else f"level {plan[2]}")
        return image


def find_vertices(grid, box):
    """The vertices of a grid around a box of the world; none if it is beside it."""
    dimensions = numpy.array(grid[0])
    corners = numpy.array(numpy.meshgrid(box[:2], box[2:4], box[4:], indexing="ij")).reshape(3, -1)
    if grid[4]:
        places = [numpy.interp(corner, line, range(len(line)), -1, len(line)) for corner, line in zip(corners, grid[4])]
    else:
        matrix = numpy.reshape(grid[3], (3, 3)) * numpy.array(grid[1])
        places = numpy.linalg.solve(matrix, corners - numpy.array(grid[2])[:, None])
    tolerance = 1e-6  # of a cell
    low = numpy.floor(numpy.min(places, axis=1) + tolerance)
    high = numpy.ceil(numpy.max(places, axis=1) - tolerance)
    if (high < 0).any() or (low > dimensions - 1).any():
        return numpy.zeros(3, int), numpy.zeros(3, int)
    return numpy.maximum(low, 0).astype(int), numpy.minimum(high + 1, dimensions).astype(int)


class vtkVolumeProbe(Consumer):
    """The values at the points of other data."""

    def __init__(self):
        super().__init__(inputs=2, outputType="vtkDataObject")

    def SetSourceConnection(self, points):
        self.SetInputConnection(1, points)

    def RequestDataObject(self, request, inputs, outputs):
        points = model.vtkDataObject.GetData(inputs[1], 0)
        info = outputs.GetInformationObject(0)
        data = model.vtkDataObject.GetData(info)
        if points and (not data or not data.IsA(points.GetClassName())):
            info.Set(model.vtkDataObject.DATA_OBJECT(), points.NewInstance())
        return 1

    def RequestInformation(self, request, inputs, outputs):
        info, points = outputs.GetInformationObject(0), inputs[1].GetInformationObject(0)
        for key in (Pipeline.WHOLE_EXTENT(), model.vtkDataObject.ORIGIN(), model.vtkDataObject.SPACING()):
            info.CopyEntry(points, key)
        keys, times = Pipeline.TIME_STEPS(), set()
        for one in inputs:
            given = one.GetInformationObject(0)
            times.update(given.Get(keys) or () if given.Has(keys) else ())
        set_times(info, sorted(times))
        return 1

    def RequestData(self, request, inputs, outputs):
        made = model.vtkDataObject.GetData(outputs, 0)
        made.Initialize()
        return self.run(outputs, lambda: self.fill(outputs, model.vtkDataObject.GetData(inputs[1], 0), made))

    def fill(self, outputs, points, made):
        reader, file, step = self.take_volume(outputs)
        made.ShallowCopy(points)
        if made.IsA("vtkCompositeDataSet"):
            made.RecursiveShallowCopy(points) if hasattr(made, "RecursiveShallowCopy") else made.CompositeShallowCopy(points)
            for leaf in list_leaves(made):
                self.probe(reader, file, step, leaf)
        else:
            self.probe(reader, file, step, made)

    def probe(self, reader, file, step, data):
        places = find_points(data)
        inside = numpy.zeros(len(places), numpy.uint8)
        for array in reader.list_arrays():
            name, kind, components, unit = file.arrays[array]
            isReal = numpy.dtype(kind).kind == "f"
            values = numpy.full((len(places), components), numpy.nan if isReal else 0, kind)
            inside = file.probe((array, 0, step, 0), not self.values["Interpolation"], places, values)
            data.GetPointData().AddArray(to_vtk(values, name))
        mask = to_vtk(inside.view(numpy.int8), "vtkValidPointMask", VTK_CHAR)
        data.GetPointData().AddArray(mask)
