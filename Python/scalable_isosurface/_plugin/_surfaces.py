# SPDX-License-Identifier: BSD-3-Clause
"""Isosurface and Contour Spectrum."""

import atexit
import contextlib
import math
import os
import threading
import weakref

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.util.vtkConstants import VTK_ID_TYPE
from vtkmodules.vtkCommonCore import vtkDataArray, vtkDoubleArray
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

from .. import _library
from ._algorithm import Algorithm, gather_text
from ._arrays import add_texts, store_units, to_vtk, VTK_VERSION
from ._images import CELLS, find_array as find_contoured, list_images, name_block, Pieces, POINTS_THEN_CELLS, tell_missing
from ._polygons import add_box, fill_surface, summarise
from ._readers import vtkBlockedVolumeReader, vtkInPlaceVolumeReader

#: Hounsfield units.
BONE = 300.0
#: Triangles from which on the window shows a coarse surface first.
LARGE = 500000


class Consumer(Algorithm):
    """Takes the volume of a reader of this file."""

    #: What else there is for other data.
    in_memory = "For data in memory use ParaView's Slice, Extract Subset or Resample With Dataset"

    def find_reader(self, port=0):
        """The reader of an input; None if that has other data."""
        algorithm = self
        while algorithm.GetNumberOfInputConnections(port):
            algorithm, port = algorithm.GetInputAlgorithm(port, 0), 0
            if isinstance(algorithm, vtkBlockedVolumeReader):
                return algorithm
            if not (algorithm.IsA("vtkPVPostFilter") or algorithm.IsA("vtkPassThrough")):
                break
        return None

    def take_volume(self, outputs):
        """The reader, its file, which runs as this filter does, and the time step."""
        reader = self.find_reader()
        if not reader or not reader.file:
            raise ValueError(f"the input is no blocked volume or volume in place. {self.in_memory}")
        reader.file.how = self.how
        return reader, reader.file, reader.find_step(outputs.GetInformationObject(0))

    def FillInputPortInformation(self, port, info):
        info.Set(self.INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject")
        return 1

    def find_scalar(self, file, step, level=0):
        """The scalar that is contoured, as the library has it."""
        name = self.GetInputArrayInformation(0).Get(model.vtkDataObject.FIELD_NAME()) or ""
        array = find_array(file, name) if name else 0
        components = file.arrays[array][2]
        component = self.values["Component"] if components > 1 else 0
        if component > components:
            raise ValueError(f'array "{file.arrays[array][0]}" has {components} components, and no component {component}')
        return array, _library.MAGNITUDE if component == components else component, step, level

    def list_contoured(self):
        """The arrays of images at the input that are contoured, if they are there."""
        for image, _ in list_images(self.GetInputDataObject(0, 0)):
            array = find_contoured(image, self.GetInputArrayInformation(0))[0]
            if array:
                yield array

    def GetUnit(self):
        reader = self.find_reader()
        with contextlib.suppress(Exception):
            if reader:
                name, *_, unit = reader.file.arrays[self.find_scalar(reader.file, 0)[0]]
                return unit or ("HU" if name == "HU" else "")
            for array in self.list_contoured():
                unit = array.GetInformation().Get(vtkDataArray.UNITS_LABEL()) or ("HU" if array.GetName() == "HU" else "")
                if unit:
                    return unit
        return ""

    def GetShare(self):
        """Of the volume: charts of samples are those of the plugin in C++."""
        return 1.0

    def GetProposal(self):
        """An isovalue to begin with; NaN if there is none."""
        reader = self.find_reader()
        with contextlib.suppress(Exception):
            if not reader:
                ranges = numpy.array([array.GetFiniteRange(0) for array in self.list_contoured()])
                low, high = ranges[:, 0].min(), ranges[:, 1].max()
                return BONE if self.GetUnit() == "HU" and low < BONE <= high else (low + high) / 2
            if not isinstance(reader, vtkInPlaceVolumeReader) or reader.is_indexed():
                scalar = self.find_scalar(reader.file, 0)
                low, high = reader.file.range(scalar)
                return BONE if self.GetUnit() == "HU" and low < BONE <= high else reader.file.propose(scalar)
        return math.nan


def find_array(file, name):
    names = [array[0] for array in file.arrays]
    if name not in names:
        raise ValueError(f'{os.fsdecode(file.path)}: has no array "{name}"')
    return names.index(name)


class vtkStabbingContour(Consumer):
    """Isosurfaces."""

    def __init__(self):
        super().__init__(inputs=1, outputType="vtkPolyData")
        self._summary, self._final = "", 1
        self._work, self._refines = None, False
        self._images = None
        self._awaited, self._is_unseen = None, False

    def GetIslandSummary(self):
        return self._summary

    def GetFinal(self):
        return self._final

    def GetLevelRange(self):
        reader = self.find_reader()
        return 0, reader.file.levels - 1 if reader and reader.file else 0

    def Refine(self):
        if not self._final:
            self._refines = True
            self.Modified()

    def make_request(self, file, step):
        """The members of si_surface_request, of a volume."""
        values = self.values
        scalar = self.find_scalar(file, step, min(values["Level"], file.levels - 1))
        contoured = file.arrays[scalar[0]][0]
        names = [name for name in values["InterpolatedArrays"] if not (name == contoured and values["ComputeScalars"])]
        attributes = [find_array(file, name) for name in dict.fromkeys(names)]
        return self.add_options(scalar=scalar, attributes=attributes)

    def add_options(self, **request):
        """Those of the properties that volumes and images have in common."""
        values = self.values
        planes = values["FrustumPlanes"]
        return dict(
            **request,
            isovalues=[isovalue for isovalue in values["ContourValues"] if not math.isnan(isovalue)],
            region=add_box(values["RegionPosition"], values["RegionLength"]) if values["UseRegion"] else None,
            normals=values["ComputeNormals"],
            global_ids=1,
            points={0: 8, 1: 9}.get(values["OutputPointsPrecision"], 0),
            closed=(-1 if values["Inside"] else 1) if values["CloseBoundary"] else 0,
            drop_degenerate_triangles=values["DropDegenerateTriangles"],
            island_size=values["IslandSize"],
            minimum_island=values["MinimumIslandSize"],
            maximum_islands=values["MaximumIslands"],
            maximum_triangles=values["MaximumTriangles"],
            maximum_seconds=values["TimeBudget"],
            vtk_version=VTK_VERSION,
            polygons=int(not values["GenerateTriangles"]),
            skip_not_a_number=values["SkipNotANumber"] or values["SkipNaN"],
            island_ids=values["ComputeIslandIds"],
            island_point=values["IslandPoint"] if values["UseIslandPoint"] else None,
            half_spaces=[
                sign * number for plane in zip(*[iter(planes)] * 4) for sign, number in zip((-1, -1, -1, 1), plane)
            ]
            if any(planes)
            else [],
        )

    def RequestUpdateExtent(self, request, inputs, outputs):
        """Of images, normals at the border of a piece need one sample beyond it; averages of cells, one cell more."""
        info = inputs[0].GetInformationObject(0)
        pieces = outputs.GetInformationObject(0).Get(Pipeline.UPDATE_NUMBER_OF_PIECES())
        if not self.find_reader() and pieces > 1:
            levels = int(bool(self.values["ComputeNormals"])) + self.takes_cells(info)
            info.Set(Pipeline.UPDATE_NUMBER_OF_GHOST_LEVELS(), levels)
        return 1

    def takes_cells(self, info):
        """Whether arrays on cells are needed, as far as that is known before there is data."""

        def is_active(place):
            return model.vtkDataObject.GetActiveFieldInformation(info, place, model.vtkDataSetAttributes.SCALARS) is not None

        association = self.GetInputArrayInformation(0).Get(model.vtkDataObject.FIELD_ASSOCIATION())
        return association == CELLS or (association == POINTS_THEN_CELLS and not is_active(0) and is_active(CELLS)) or any(
            model.vtkDataObject.GetNamedFieldInformation(info, CELLS, name) for name in self.values["InterpolatedArrays"]
        )

    def RequestData(self, request, inputs, outputs):
        output = model.vtkPolyData.GetData(outputs, 0)
        output.Initialize()
        if self.find_reader():
            return self.run(outputs, lambda: self.fill(outputs, output))
        return self.run(outputs, lambda: self.fill_of_images(inputs[0].GetInformationObject(0), output))

    def fill_of_images(self, info, output):
        """Of images in memory."""
        values, data = self.values, model.vtkDataObject.GetData(info)
        self._final, self._summary = 1, ""
        filter_info = self.GetInputArrayInformation(0)

        def prepare():
            self._images = self._images or _library.Images()
            names = list(dict.fromkeys(values["InterpolatedArrays"]))
            mine = Pieces(filter_info, data, info, values["Component"], names, values["ComputeScalars"])
            component = values["Component"] if mine.components > 1 else 0
            magnitude = component == mine.components
            scalar = 0, _library.MAGNITUDE if magnitude else component, 0, 0
            return mine, self.add_options(scalar=scalar, attributes=range(1, 1 + len(mine.component_names)))

        mine, request = self.agree(prepare)
        told = gather_text(self.ranks, "pieces" if mine.pieces else "images" if mine.are_there else "")
        if "images" in told and "pieces" not in told:
            raise ValueError(tell_missing(data, filter_info.Get(model.vtkDataObject.FIELD_NAME())))
        if not request["isovalues"]:
            return
        owner = self._images.extract(mine.pieces, self.how, **request)
        made = self.put(output, owner, request, mine.name)
        for name, names in mine.component_names:
            array = output.GetPointData().GetArray(name)
            for number, one in enumerate(names):
                if array and one:
                    array.SetComponentName(number, one)
        if made["blocks"]:
            add_texts(output, "BlockNames", [name_block(data, path) for path in made["blocks"]])

    def put(self, output, owner, request, contoured):
        """A surface into the output. What fill_surface gives."""
        made = fill_surface(output, owner, request["normals"], contoured if self.values["ComputeScalars"] else "")
        self._summary = summarise(made["islands"], request["isovalues"]) if made["islands"] is not None else ""
        for name, number in (
            ("Rank", self.ranks.rank if self.ranks else 0),
            ("Triangles", len(made["offsets"]) - 1),
            ("Level", made["level"]),
        ):
            output.GetFieldData().AddArray(to_vtk(numpy.array([number], float), name))
        return made

    def fill(self, outputs, output):
        def prepare():
            _, file, step = self.take_volume(outputs)
            return file, self.make_request(file, step)

        file, request = self.agree(prepare)
        if not request["isovalues"]:
            return
        owner = self.extract(file, request)
        self.put(output, owner, request, file.arrays[request["scalar"][0]][0])
        store_units(output, file, file.describe(0))

    def extract(self, file, request):
        """The surface that is to be shown now: in the window of one rank, or if it is progressive, first a coarse one of
        what is large."""
        wanted = file, repr(request)
        work, self._work = self._work, None
        is_awaited, self._awaited = self._awaited == self.find_change(), None
        if work and work.wanted == wanted and (is_awaited or not work.thread.is_alive()):
            self._final, self._is_unseen = 1, not work.is_told
            return work.take(self.advance)
        if work:
            work.stop()
        refines, self._refines = self._refines, False
        self._final = 1
        window = self.polled and self.ranks is None
        if (window or self.values["Progressive"]) and not (refines and not window):
            triangles = file.estimate(**request)
            most = min(triangles / 20, request["maximum_triangles"] or triangles)
            if triangles > (LARGE if window else 0) and file.levels > 1:
                owner = file.extract(0, **dict(request, maximum_triangles=max(int(most), 1)))
                self._final = int(owner.pointer.contents.level == request["scalar"][3])
                if window and not self._final:
                    self._work = Work(wanted, file, request)
                return owner
        return file.extract(0, **request)

    def find_change(self):
        """Another one when properties or the volume have changed."""
        return self.GetMTime(), self.find_reader().GetMTime()

    def GetNeedsUpdate(self):
        """ParaView's window asks every 100 ms, on the first rank."""
        self.polled = True
        news, self._is_unseen = self._is_unseen, False
        if self._work and self._work.is_done():
            self._work.is_told = True
            self.Modified()
            return True
        if self._work and not self._awaited:
            # Views that show the coarse surface are not told, and do not ask. Who asks now, as a writer does, waits for
            # the exact one.
            self.Modified()
            self._awaited = self.find_change()
        return news


class Work:
    """A surface that is extracted beside the main thread."""

    #: Those that may be at work when Python ends.
    living: "weakref.WeakSet[Work]" = weakref.WeakSet()

    def __init__(self, wanted, file, request):
        self.wanted = wanted
        self._made = self._error = None
        self._stops = self.is_told = False
        how = _library.How(None, lambda _: int(self._stops))

        def extract():
            try:
                self._made = file.extract(0, how=how, **request)
            except Exception as error:  # pylint: disable=broad-except  # told by take
                self._error = error

        self.thread = threading.Thread(target=extract, daemon=True)
        self.thread.start()
        self.living.add(self)

    def is_done(self):
        self.thread.join(0.005)  # ParaView's main thread may keep the GIL otherwise
        return not self.thread.is_alive()

    def stop(self):
        self._stops = True

    def take(self, advance):
        """Waits for it."""
        while self.thread.is_alive():
            self.thread.join(0.1)
            if advance(0):
                self.stop()
                raise _library.Stopped("The surface is not finished.")
        if self._error:
            raise self._error
        return self._made


@atexit.register
def end_all_work():
    """A thread that comes back to a Python that has ended would end the process."""
    for work in list(Work.living):
        work.stop()
        work.thread.join()


class vtkContourSpectrum(Consumer):
    """What the isosurface of each isovalue is."""

    in_memory = "For data in memory use the plugin in C++"

    def __init__(self):
        super().__init__(inputs=1, outputType="vtkTable")
        self._rows = vtkDoubleArray()

    def GetSpectrum(self):
        return self._rows

    def RequestData(self, request, inputs, outputs):
        return self.run(outputs, lambda: self.fill(outputs, model.vtkTable.GetData(outputs, 0)))

    def fill(self, outputs, table):
        table.Initialize()
        _, file, step = self.take_volume(outputs)
        if self.values["ColumnsPerStore"] >= 0:
            raise ValueError("ColumnsPerStore is in the plugin in C++ alone")
        if self.ranks and self.ranks.rank > 0:
            return
        spectrum = file.spectrum(self.find_scalar(file, step))
        names = dict(zip(spectrum, ("Isovalue", "Triangles", "ActiveCells", "ActiveBlocks", "Bytes", "Area", "Volume")))
        for name, values in spectrum.items():
            if values is not None:
                isInteger = values.dtype.kind == "u"
                table.AddColumn(
                    to_vtk(values.astype(numpy.int64) if isInteger else values, names[name], VTK_ID_TYPE if isInteger else None)
                )
        count = len(spectrum["isovalues"])
        rows = [numpy.full(count, numpy.nan) if values is None else values for values in spectrum.values()]
        self._rows = to_vtk(numpy.ascontiguousarray(numpy.transpose(rows), float))
