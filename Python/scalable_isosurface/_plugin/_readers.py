# SPDX-License-Identifier: BSD-3-Clause
"""The readers."""

import contextlib
import os

import numpy
from vtkmodules import vtkCommonDataModel as model
from vtkmodules.vtkCommonCore import vtkDataArray, vtkDoubleArray, vtkInformation
from vtkmodules.vtkCommonCore import vtkInformationVector
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline as Pipeline

from .. import _library
from ._algorithm import Algorithm, describe, gather_text, tell_error
from ._arrays import add_array, add_texts, find_piece, make_extent, make_image, MEBIBYTE, set_times, store_units
from ._arrays import to_texts, to_vtk, VTK_VERSION, WHOLE_EXTENT
from ._definitions import RAW_EXTENSIONS
from ._polygons import add_box, fill_surface


class Reader(Algorithm):
    """Reads files, each of which has time steps or is one."""

    def __init__(self, **types):
        super().__init__(**types)
        self.file = None
        self._starts = []

    def list_paths(self):
        names = self.values["FileName"]
        return names if isinstance(names, list) else [names] * bool(names)

    def RequestInformation(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        info.Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        paths, times, self._starts = self.list_paths(), [], []
        with contextlib.suppress(Exception):  # RequestData tells it
            for number, path in enumerate(paths):
                self.open(path)
                own = [time for time in self.list_times() if time is not None]
                own = own or [float(number)] * (len(paths) > 1)
                self._starts += [(time, path) for time in own[:1]]
                times += own
        set_times(info, sorted(set(times)))
        self.tell(info)
        return 1

    def tell(self, info):
        """What else consumers may know before samples are read."""

    def choose(self, info):
        """The file of the time that is asked for."""
        paths, key = self.list_paths(), Pipeline.UPDATE_TIME_STEP()
        if not paths:
            raise ValueError("No file name is set.")
        there = [start for start in self._starts if info.Has(key) and start[0] <= info.Get(key)]
        return max(there)[1] if there else paths[0]

    def RequestData(self, request, inputs, outputs):
        info = outputs.GetInformationObject(0)
        output = model.vtkDataObject.GetData(info)
        output.Initialize()

        def work():
            self.agree(lambda: self.open(self.choose(info)))
            self.prepare(info)
            self.fill(info, output)

        return self.run(outputs, work)

    def prepare(self, info):
        """Collective: what is done before the output is made."""


class vtkBlockedVolumeReader(Reader):
    """A blocked volume: other filters get the finest level that fits; those of this file read the volume itself."""

    def __init__(self):
        super().__init__(outputType="vtkPartitionedDataSet")
        self.found = None  # the grid as the file has it
        self._opened_for = None
        self._text = ""
        self.arrays = {}  # chosen ones

    # The file.

    def name(self, path):
        """What is opened, and as what."""
        return path, "", ""

    def place(self):
        unit = self.values["LengthUnit"]
        place = {"unit": {"": None, "unknown": ""}.get(unit, unit), "local_stores": self.values.get("LocalStores", 0)}
        for name in ("Spacing", "Origin"):
            numbers = self.values[name]
            if len(numbers) not in (0, 3):
                raise ValueError(f"{name} has {len(numbers)} numbers in place of 3")
            place[name.lower()] = numbers
        return place

    def open(self, path):
        """Opens a volume, unless it is open."""
        place = self.place()
        state = os.stat(path) if os.path.isfile(path) else None  # a file that is written anew is opened anew
        wanted = (self.name(path), repr(place), state and (state.st_ino, state.st_mtime_ns, state.st_size))
        if self._opened_for == wanted and self.file:
            return
        self.file = self._opened_for = None
        self.path = path
        self.file = self.open_file(place)
        self.found = (self.open_file({}) if any(place.values()) else self.file).describe(0)
        self._opened_for = wanted
        self.list_arrays()

    def open_file(self, place):
        name, axes, folder = self.name(self.path)
        return _library.open_volume(os.fsencode(name), axes, os.fsencode(folder), 0, self.how, **place)

    def list_times(self):
        return self.file.times

    def CanReadFile(self, path):
        try:
            return int(path.endswith(".bvol") and _library.find_kind(os.fsencode(path)) == "blocked volume")
        except (OSError, ValueError):
            return 0

    # What panels ask.

    def GetFoundSpacing(self):
        return tuple(map(abs, self.found[1])) if self.found else (1.0, 1.0, 1.0)

    def GetFoundOrigin(self):
        return self.found[2] if self.found else (0.0, 0.0, 0.0)

    def GetFoundUnit(self):
        return (self.found and self.found[6]) or "unknown"

    def GetShownText(self):
        return self._text

    def GetNumberOfPointArrays(self):
        return len(self.arrays)

    def GetPointArrayName(self, number):
        return list(self.arrays)[number]

    def GetPointArrayStatus(self, name):
        return int(self.arrays.get(name, True))

    def list_arrays(self):
        """The numbers of the chosen ones."""
        names = [name for name, *_ in self.file.arrays]
        self.arrays = {name: self.values["PointArrayStatus"].get(name, True) for name in names}
        return [number for number, name in enumerate(names) if self.arrays[name]]

    # The pipeline.

    def find_step(self, info):
        return find_step(info, self.file.times) if self.file else 0

    def finish(self):
        """Waits until the volume is exact."""

    def find_level(self, pieces, limit):
        """The finest level whose samples fit, and its grid."""
        sizes = [
            numpy.dtype(kind).itemsize * components
            for name, kind, components, _ in self.file.arrays
            if self.arrays.get(name)
        ]
        for level in range(self.file.levels):
            grid = self.file.describe(level)
            if sum(sizes) * float(numpy.prod(grid[0], dtype=float)) / pieces <= limit:
                return level, grid
        return None, None

    def fill(self, info, output):
        self.file.how = self.how  # not that of a filter that has used the file
        chosen = self.list_arrays()
        step = self.find_step(info)
        if self.file.times[step] is not None:
            output.GetInformation().Set(model.vtkDataObject.DATA_TIME_STEP(), self.file.times[step])
        piece, pieces = find_piece(info)
        level, grid = self.find_level(pieces, self.values["MemoryLimit"] * MEBIBYTE)
        if level is None:
            self.warn(
                f"{self.path}: not even the coarsest level fits the memory limit of "
                f"{self.values['MemoryLimit']} MiB: the output is empty."
            )
            return
        full = " x ".join(map(str, self.file.describe(0)[0]))
        self._text = f"level {level}, {' x '.join(map(str, grid[0]))}, of {full}" if level else f"all of it, {full}"
        low, high = find_slab(grid, piece, pieces)
        if (low < high).all():
            image = make_image(grid, low, high)
            whole = numpy.array([make_extent(grid, numpy.zeros(3, int), numpy.array(grid[0]))], numpy.int32)
            image.GetFieldData().AddArray(to_vtk(whole, WHOLE_EXTENT))
            self.read_arrays(image, chosen, step, level, low, high)
            if pieces > 1:
                mark_shared(image, low, high)
            output.SetNumberOfPartitions(1)
            output.SetPartition(0, image)
        store_units(output, self.file, grid)

    def read_arrays(self, image, chosen, step, level, low, high):
        """Adds arrays of a box to its image."""
        for array in chosen:
            name, kind, components, unit = self.file.arrays[array]
            samples = numpy.empty((int(numpy.prod(high - low)), components), kind)
            box = {"array": array, "step": step, "level": level, "low": tuple(low), "high": tuple(high)}
            self.file.read(samples, range(components), 0, **box)
            add_array(image, to_vtk(samples, name), unit)
            self.tell_range(image.GetPointData().GetArray(name), array, step)

    def tell_range(self, values, array, step):
        """The range of the whole volume, of which a coarse level may lack the ends."""
        components = values.GetNumberOfComponents()
        ranges = [self.file.range((array, component, step, 0)) for component in range(components)]
        if self.file.levels == 1 or not numpy.isfinite(ranges).all():
            return
        of_all = vtkInformationVector()
        for ends in ranges:
            info = vtkInformation()
            info.Set(vtkDataArray.COMPONENT_RANGE(), ends, 2)
            of_all.Append(info)
        for key in (vtkDataArray.PER_COMPONENT(), vtkDataArray.PER_FINITE_COMPONENT()):
            values.GetInformation().Set(key, of_all)


def find_step(info, times):
    """The last step that is not behind the time that is asked for."""
    key = Pipeline.UPDATE_TIME_STEP()
    steps = [step for step, time in enumerate(times) if info.Has(key) and time is not None and time <= info.Get(key)]
    return steps[-1] if steps else 0


def find_slab(grid, piece, pieces):
    """The vertices of a piece: layers of chunks on the longest axis."""
    dimensions, chunk = numpy.array(grid[0]), numpy.array(grid[5])
    low, high = numpy.zeros(3, int), dimensions.copy()
    axis = int(dimensions.argmax())
    layers = -(-max(int(dimensions[axis]) - 1, 1) // int(chunk[axis]))
    low[axis] = layers * piece // pieces * chunk[axis]
    end = layers * (piece + 1) // pieces
    high[axis] = min(end * chunk[axis] + 1, dimensions[axis]) if end > layers * piece // pieces else low[axis]
    return low, high


def mark_shared(image, low, high):
    """Marks the first layer of a slab that the slab before has, too."""
    if not low.any():
        return
    ghosts = numpy.zeros(tuple((high - low)[::-1]), numpy.uint8)
    axis = int(low.argmax())
    ghosts[(slice(None),) * (2 - axis) + (0,)] = model.vtkDataSetAttributes.DUPLICATEPOINT
    image.GetPointData().AddArray(to_vtk(ghosts.ravel(), model.vtkDataSetAttributes.GhostArrayName()))


class vtkInPlaceVolumeReader(vtkBlockedVolumeReader):
    """A file of another format, which is indexed first. In the window of one rank a sample is shown meanwhile."""

    def __init__(self):
        super().__init__()
        self._datasets = None
        self._growing = self._growing_step = self._failed = None
        self._times = []
        self._fetching = _library.Fetching()

    def name(self, path):
        what = self.values["RawSamples"] or self.values["Dataset"].replace("automatic", "")
        return f"{path}:{what}" if what else path, self.values["Axes"], self.values["IndexFolder"]

    def place(self):
        box = self.values["FetchRegion"]
        is_box = all(low <= high for low, high in zip(box[::2], box[1::2]))
        fetch = {"fetch_budget": self.values["FetchBudget"] << 20}
        return {**super().place(), **fetch, "region": box if is_box else None}

    def CanReadFile(self, path):
        try:
            name = os.fsencode(path)
            if _library.find_kind(name) != "source":
                return 0
            return int(is_raw(path) or bool(_library.list_datasets(name) or _library.open_volume(name, "", b"", 0)))
        except (OSError, ValueError):
            return 0

    def GetDatasets(self):
        names = ["automatic"]
        with contextlib.suppress(OSError, ValueError):
            names += _library.list_datasets(os.fsencode(self.values["FileName"]))
        if self.values["Dataset"] not in names:
            names.append(self.values["Dataset"])
        self._datasets = to_texts(names)
        return self._datasets

    def GetIsRaw(self):
        return int(is_raw(self.values["FileName"]))

    def GetIndexText(self):
        if not self.file:
            return ""
        state = "is being written" if self._growing else "up to date" if self.is_indexed() else "Apply indexes the file"
        return f"{os.fsdecode(self.file.path)}: {state}"

    def is_indexed(self):
        return self.file.path.endswith(b".bvol")

    # The index.

    def open(self, path):
        opened = self._opened_for
        super().open(path)
        if self._opened_for != opened:
            self._growing, self._failed, self._times = None, None, self.file.times

    def list_times(self):
        return self._times

    def find_step(self, info):
        return min(super().find_step(info), len(self.file.times) - 1)

    def prepare(self, info):
        """Opens the index, which is written first; or a sample, while it is written."""
        step = find_step(info, self._times)
        if self._growing and step != self._growing_step:
            self._growing = None  # what is written of the index is kept
            self.file = self.open_file(self.place())
        if self._growing:
            self.take()
        elif any(gather_text(self.ranks, "" if self.is_indexed() else "some rank has no index")):
            name, axes, folder = self.name(self.path)
            given = os.fsencode(name), axes, os.fsencode(folder)
            memory = self.values["IndexMemory"] * MEBIBYTE
            place = {**self.place(), "fetching": self._fetching}
            where = folder or os.path.dirname(os.path.abspath(self.path))
            if self.ranks is None and (self.polled or not os.access(where, os.W_OK)):
                self._failed, self._growing_step = None, step
                self._growing = _library.GrowingFile(*given, step, memory, self.how, **place)
                self.take(None if self.polled else 0.1)
            else:
                _library.write_index(*given, memory, 0, self.how, **place)
                self.file = self.open_file(self.place())

    def finish(self):
        if self._failed:
            raise self._failed
        if self._growing:
            self.take(0.1)
            self.Modified()

    def take(self, wait=None):
        """The volume as far as it is there; all of it with `wait`."""
        stage, done, self._sample = self.poll(wait or 0)
        while wait and stage != 2:
            stage, done, self._sample = self.poll(wait)
            if self.advance(done):
                raise _library.Stopped("The index is not finished.")
        self.file = self._growing.take()
        if stage == 2:
            self._growing = None

    def poll(self, wait=0):
        try:
            return self._growing.poll(wait)
        except Exception as error:  # what is shown stays a sample
            self._growing, self._failed = None, error
            raise

    def fill(self, info, output):
        super().fill(info, output)
        if self._growing:
            self._text = self._sample

    def GetNeedsUpdate(self):
        """ParaView's window asks every 100 ms, on the first rank."""
        self.polled = True
        if self._growing:
            try:
                stage, *_ = self.poll()
            except Exception as error:  # pylint: disable=broad-except
                tell_error(describe(error))
                return False
            if stage:
                self.Modified()
                return True
        return False

    TakeIndex = Algorithm.GetRefinement


def is_raw(path):
    return path.lower().endswith(RAW_EXTENSIONS)


class vtkEdgeIndexReader(Reader):
    """Surfaces of edge-index files."""

    def __init__(self):
        super().__init__(outputType="vtkPolyData")
        self._opened_for = None
        self._values = vtkDoubleArray()

    def CanReadFile(self, path):
        try:
            return int(_library.find_kind(os.fsencode(path)) == "edge index")
        except (OSError, ValueError):
            return 0

    def GetContourValues(self):
        return self._values

    def open(self, path):
        wanted = path, self.GetMTime()
        if self._opened_for != wanted:
            self.file = self._opened_for = None
            self.file, self._opened_for = _library.open_surface(os.fsencode(path)), wanted

    def list_times(self):
        return [self.file.time]

    def tell(self, info):
        self._values = to_vtk(numpy.array(self.file.isovalues if self.file else [], float))

    def fill(self, info, output):
        values, file = self.values, self.file
        piece, pieces = find_piece(info)
        if file.missing:
            self.warn(file.missing)
        if values["Preview"] and not file.has_preview:
            self.warn(f"{self._opened_for[0]}: the file has no preview: the surface is read in full.")
        region = add_box(values["RegionPosition"], values["RegionLength"]) if values["UseRegion"] else None
        owner = file.read_piece(
            self.how,
            region,
            preview=int(bool(values["Preview"]) and file.has_preview),
            normals=values["ComputeNormals"],
            global_ids=1,
            vtk_version=VTK_VERSION,
            piece=piece,
            piece_count=pieces,
        )
        fill_surface(output, owner, values["ComputeNormals"], file.array if values["ComputeScalars"] else "")
        if file.length_unit:
            add_texts(output, "PhysicalSizeUnit", [file.length_unit] * 3)
        if file.time is not None:
            output.GetInformation().Set(model.vtkDataObject.DATA_TIME_STEP(), file.time)
