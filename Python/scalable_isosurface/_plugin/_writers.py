# SPDX-License-Identifier: BSD-3-Clause
"""The writers."""

import os

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkDataArray, vtkDataArraySelection, vtkInformationVector
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline
from vtkmodules.vtkFiltersCore import vtkCellDataToPointData

from .. import _library
from ._algorithm import Algorithm
from ._arrays import list_leaves, MEBIBYTE
from ._surfaces import Consumer, vtkStabbingContour


class Writer(Algorithm):
    """Writes when ParaView says so."""

    def __init__(self):
        super().__init__(inputs=1, outputs=0)

    def Write(self):
        return self.run(vtkInformationVector(), self.write)

    def find_times(self):
        """The time steps to write; [None]: the current one."""
        producer = self.GetInputAlgorithm(0, 0)
        producer.UpdateInformation()
        info, key = producer.GetOutputInformation(0), Pipeline.TIME_STEPS()
        is_all = self.values["WriteAllTimeSteps"] and info.Has(key)
        return list(info.Get(key)) if is_all else [None]

    def update_input(self, time, *piece):
        """The input of this rank, or, with a piece, that piece of it."""
        producer = self.GetInputAlgorithm(0, 0)
        piece = piece or ((self.ranks.rank, self.ranks.count, 0) if self.ranks else (0, 1, 0))
        asked = self.GetInputInformation(0, 0)
        if time is None and asked.Has(Pipeline.UPDATE_TIME_STEP()):
            time = asked.Get(Pipeline.UPDATE_TIME_STEP())
        if time is None:
            producer.UpdatePiece(*piece)
        else:
            producer.UpdateTimeStep(time, *piece)
        return producer.GetOutputDataObject(self.GetInputConnection(0, 0).GetIndex())


class vtkEdgeIndexWriter(Writer):
    """Writes what Isosurface gives as an edge-index file."""

    def write(self):
        contour = self.agree(self.find_contour)
        times = self.find_times()
        for number, time in enumerate(times):
            self.update_input(time)
            contour.find_reader().finish()
            stem, ending = os.path.splitext(self.values["FileName"])
            path = f"{stem}_{number}{ending}" if len(times) > 1 else self.values["FileName"]
            file, request = self.agree(lambda: self.make_request(contour))
            file.write_surface(os.fsencode(path), self.make_coding(), **request)

    def find_contour(self):
        contour = self.GetInputAlgorithm(0, 0)
        while contour.IsA("vtkPVPostFilter") or contour.IsA("vtkPassThrough"):
            contour = contour.GetInputAlgorithm(0, 0)
        if not isinstance(contour, vtkStabbingContour):
            raise ValueError(
                "Only the unchanged output of Isosurface can be written to an edge-index file: save that output, before "
                "it is clipped or filtered, or save this surface in another format, such as .vtp."
            )
        if not contour.find_reader() or not contour.find_reader().file:
            raise ValueError(
                "Of surfaces of data in memory the plugin in C++ alone writes an edge-index file: save this surface in "
                "another format, such as .vtp."
            )
        return contour

    def make_request(self, contour):
        """The volume of Isosurface, and the members of si_surface_request."""
        values, reader = self.values, contour.find_reader()
        request = contour.make_request(reader.file, reader.find_step(contour.GetOutputInformation(0)))
        request["normals"] = int(values["WriteNormals"] and request["normals"])
        request["attributes"] = request["attributes"] if values["WriteArrays"] else []
        request["drop_degenerate_triangles"] = request["drop_degenerate_triangles"] and not request["closed"]
        reader.file.how = self.how
        return reader.file, request

    def make_coding(self):
        values = self.values
        return {
            "mode": values["Mode"],
            "preview_level": values["PreviewLevel"],
            "maximum_error": values["MaximumError"],
            "array_error": values["ArrayError"],
            "normal_error": values["NormalError"] or -1,
            "profile": values["Profile"],
            "memory": values["MemoryLimit"] * MEBIBYTE,
            "quantization_bits": values["QuantizationBits"],
        }


class vtkBlockedVolumeWriter(Writer):
    """Writes images, or the volume of a reader of this file at full resolution, as a blocked volume."""

    def __init__(self):
        super().__init__()
        self._arrays = vtkDataArraySelection()

    def GetPointDataArraySelection(self):
        return self._arrays

    find_reader = Consumer.find_reader

    def write(self):
        append = self.values["AppendTimeStep"]
        for time in self.find_times():
            reader = self.find_reader()
            data = self.update_input(time, *(() if reader else (0, 1, 0)))  # the library asks each rank for all of it
            if reader:
                reader.finish()
            grid, arrays, time = self.agree(lambda: self.collect(reader, data))
            self.write_step(grid, arrays, time, int(append))
            append = True

    def write_step(self, grid, arrays, time, append):
        values = self.values
        settings = {
            "threads": 0,
            "block_size": values["BlockSize"],
            "codec": (b"none", b"lz4", b"zstd")[values["Compression"]],
            "codec_level": values["CompressionLevel"],
            "stores": values["NumberOfStores"],
            "replicas": values["NumberOfReplicas"],
            "memory": values["MemoryLimit"] * MEBIBYTE,
            "distribution": values["Distribution"],
            "random_seed": values["RandomSeed"],
            "append": append,
        }
        place = dict(zip(("dimensions", "spacing", "origin", "direction"), grid), first=grid[7], zero=grid[8])
        unit = _library.encode(grid[6])
        writing = _library.VolumeWriting(
            os.fsencode(values["FileName"]), grid[4], settings, length_unit=unit, **place
        )
        writing.how = self.how
        writing.write_arrays([arrays], [time], grid[5])

    def is_chosen(self, name):
        return not self.values["ChooseArraysToWrite"] or self._arrays.ArrayIsEnabled(name)

    def collect(self, reader, data):
        """The grid, the arrays with what gives their samples, and the time."""
        if reader:
            file, step = reader.file, reader.find_step(reader.GetOutputInformation(0))
            arrays = [
                (name, Box(file, number, step, kind, components), kind, components, unit)
                for number, (name, kind, components, unit) in enumerate(file.arrays)
                if self.is_chosen(name) and reader.arrays.get(name, True)
            ]
            return file.describe(0), arrays, file.times[step]
        info, key = data.GetInformation(), model.vtkDataObject.DATA_TIME_STEP()
        time = info.Get(key) if info.Has(key) else None
        grids = [data] if data.IsA("vtkDataSet") else list(list_leaves(data))
        if len(grids) != 1 or not (grids[0].IsA("vtkImageData") or grids[0].IsA("vtkRectilinearGrid")):
            raise ValueError("the input is not one image or rectilinear grid, of which each rank can have all")
        image = grids[0]
        if self.values["WriteCellArrays"]:
            averages = vtkCellDataToPointData()
            averages.SetInputData(image)
            averages.Update()
            image = averages.GetOutput()
        arrays = list(self.list_samples(image))
        if not arrays or not image.GetNumberOfPoints():
            raise ValueError("the input has no point array to write")
        return describe_image(image), arrays, time

    def list_samples(self, image):
        data, dimensions = image.GetPointData(), image.GetDimensions()[::-1]
        arrays = [data.GetArray(number) for number in range(data.GetNumberOfArrays())]
        # The active scalars come first: they decide which store a block goes to, and what is contoured.
        for array in sorted(arrays, key=lambda array: array is not data.GetScalars()):
            if not array or array.GetName() == model.vtkDataSetAttributes.GhostArrayName():
                continue
            samples = numpy_support.vtk_to_numpy(array)
            components = array.GetNumberOfComponents()
            if self.is_chosen(array.GetName()) and samples.dtype.name in _library.VALUE_TYPES:
                unit = array.GetInformation().Get(vtkDataArray.UNITS_LABEL()) or ""
                shape = (*dimensions, components) if components > 1 else dimensions
                yield array.GetName(), samples.reshape(shape), samples.dtype.name, components, unit


class Box:
    """The samples of an array of a volume, as slices."""

    def __init__(self, file, array, step, kind, components):
        self._file, self._kind, self._components = file, kind, components
        self._box = {"array": array, "step": step}

    def __getitem__(self, key):
        low, high = ([getattr(part, end) for part in key[::-1]] for end in ("start", "stop"))
        shape = [part.stop - part.start for part in key] + ([self._components] if self._components > 1 else [])
        samples = numpy.empty(shape, self._kind)
        # The library asks for samples in threads of its own, where nobody may learn of progress.
        self._file.read(samples, range(self._components), 0, _library.How(), low=tuple(low), high=tuple(high), **self._box)
        return samples


def describe_image(image):
    """The grid of an image, as the library describes one."""
    dimensions, chunk = image.GetDimensions(), ()
    identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    units = image.GetFieldData().GetAbstractArray("PhysicalSizeUnit")
    unit = units.GetValue(0) if units and units.GetNumberOfValues() else ""
    if image.IsA("vtkRectilinearGrid"):
        lines = [image.GetXCoordinates(), image.GetYCoordinates(), image.GetZCoordinates()]
        lines = [numpy_support.vtk_to_numpy(line).astype(float).tolist() for line in lines]
        spacing = [(line[-1] - line[0]) / max(len(line) - 1, 1) or 1.0 for line in lines]
        origin = tuple(line[0] for line in lines)
        return dimensions, tuple(spacing), origin, identity, lines, chunk, unit, (0, 0, 0), origin
    matrix = image.GetDirectionMatrix()
    direction = tuple(matrix.GetElement(row, column) for row in range(3) for column in range(3))
    first = image.GetPoint(0)
    zero = image.GetOrigin()
    return dimensions, image.GetSpacing(), first, direction, None, chunk, unit, image.GetExtent()[::2], zero
