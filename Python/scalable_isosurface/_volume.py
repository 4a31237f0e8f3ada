# SPDX-License-Identifier: BSD-3-Clause
"""Volumes in files, as arrays of their samples."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy

from . import _library
from ._arguments import take_integer, take_number, take_numbers, take_text, take_threads
from ._indexing import AxisRange, parse_key
from ._surface import Surface


class Spectrum(NamedTuple):
    """Quantities of the isosurface of each isovalue, as arrays of equal length.

    A quantity that the file does not know is None. Triangles, cells, blocks and bytes are exact; area and
    volume are estimates.
    """

    isovalues: numpy.ndarray  #: ascending, in equal steps; at most 2048
    triangles: Optional[numpy.ndarray]
    cells: Optional[numpy.ndarray]  #: that the surface crosses
    blocks: Optional[numpy.ndarray]  #: that it crosses
    bytes: Optional[numpy.ndarray]  #: that are read of them
    area: Optional[numpy.ndarray]  #: of the surface, in the square of the unit of `Volume.spacing`
    volume: Optional[numpy.ndarray]  #: where samples are at least the isovalue

    def __repr__(self) -> str:
        known = [name for name, values in zip(self._fields[1:], self[1:]) if values is not None]
        first, last = self.isovalues[0], self.isovalues[-1]
        return f"<Spectrum of {len(self.isovalues)} isovalues from {first:.6g} to {last:.6g}: {', '.join(known)}>"


def _find_type(dtype: Any) -> int:
    """The number of a type of points in C."""
    if dtype is None:
        return 0
    if numpy.dtype(dtype).name not in ("float32", "float64"):
        raise ValueError(f"dtype of points is float32 or float64, and not {dtype!r}")
    return _library.VALUE_TYPES.index(numpy.dtype(dtype).name)


#: By what islands are large or small, in the order of C.
_ISLAND_SIZES = ("triangles", "area", "volume")


def _take_name(name: str, value: Any, names: Sequence[str]) -> int:
    """The number of one of some names."""
    if value not in names:
        raise ValueError(f"{name} is {' or '.join(map(repr, names))}, and not {value!r}")
    return names.index(value)


def name_file(path: str) -> bytes:
    """The name in C. What a file of NumPy (.npy) has is told as that of raw samples."""
    if not path.endswith(".npy") or not os.path.isfile(path):
        return os.fsencode(path)
    try:
        array = numpy.lib.format.open_memmap(path, mode="r")
    except ValueError as error:
        raise OSError(f"{path}: cannot be read: {error}") from None
    if array.ndim != 3 or not array.flags.c_contiguous or array.dtype.name not in _library.VALUE_TYPES:
        raise OSError(
            f"{path}: cannot be read: it has the shape {array.shape} and the type {array.dtype}; "
            "create(numpy.load(path, mmap_mode='r'), 'NAME.bvol', axes=...) makes a volume of other arrays "
            "than (z, y, x)"
        )
    size = "x".join(map(str, reversed(array.shape)))
    order = ",big-endian" if array.dtype.str.startswith(">") else ""
    return os.fsencode(f"{path}:{size},{array.dtype.name},header-bytes={array.offset}{order}")


class _Opened:
    """A file and how it was opened; shared by the volumes that were made of one another."""

    def __init__(
        self,
        path: str,
        axes: str,
        index_folder: str,
        threads: Optional[int],
        region: Optional[Sequence[float]],
        place: Mapping[str, Any],
    ) -> None:
        self.how = (path, axes, index_folder, threads, region, place)
        self.path = path
        self.threads = take_threads(threads)
        name = self.name = name_file(path)
        self.is_stored = _library.find_kind(name) == "blocked volume"
        self._file: Optional[_library.VolumeFile] = _library.open_volume(
            name, take_text("axes", axes), os.fsencode(index_folder), self.threads, region=region, **place
        )

    @property
    def file(self) -> _library.VolumeFile:
        if self._file is None:
            raise ValueError(f"{self.path}: the volume is closed")
        return self._file

    def close(self) -> None:
        self._file = None


class Volume:
    """An array of samples in a file, at one time step and one level, which are read when it is indexed.

    `open` makes it. Axes of the array, and so of `shape`, `chunks` and keys, are z, y, x, and, if a sample
    has several components, these. All that lies in the world is in the order x, y, z, as in VTK, ITK and
    NIfTI: `spacing`, `origin`, `direction`, regions and the points of surfaces.

    A key is that of NumPy's basic indexing: integers, slices of any step, ``...`` and ``numpy.newaxis``; along
    one axis also a list or an array of indices in any order, or of truth values. The result is what a NumPy
    array would give, errors included. Only blocks that have chosen samples are read.

    Any number of threads may use a volume; reading and extracting release the GIL. A pickled volume opens
    its file anew, so it can be sent to other processes.

    Examples
    --------
    >>> volume = si.open("waves.bvol")
    >>> volume
    <Volume 'waves.bvol', array 'waves': (20, 30, 40) float32, level 0 of 8>
    >>> volume[3, -1, ::8].round(2)
    array([ 0.06,  0.1 , -0.03,  0.19, -0.11], dtype=float32)
    >>> volume[:, 4].shape
    (20, 40)
    >>> volume.spacing
    (0.5, 1.0, 2.0)
    """

    __slots__ = ("_opened", "_array", "_step", "_level", "_description")

    def __init__(self, opened: _Opened, array: int, step: int, level: int) -> None:
        self._opened = opened
        self._array = array
        self._step = step
        self._level = level
        self._description = opened.file.describe(level)

    # What the array is.

    @property
    def path(self) -> str:
        """The name that was opened."""
        return self._opened.path

    @property
    def name(self) -> str:
        """The name of the array."""
        return self._opened.file.arrays[self._array][0]

    @property
    def dtype(self) -> numpy.dtype:
        """The type of a component of a sample."""
        return numpy.dtype(self._opened.file.arrays[self._array][1])

    @property
    def unit(self) -> str:
        """The unit of the samples, as "HU" (Hounsfield units); "" if the file does not tell."""
        return self._opened.file.arrays[self._array][3]

    @property
    def _components(self) -> int:
        return self._opened.file.arrays[self._array][2]

    def _with_components(self, sizes: Sequence[int]) -> Tuple[int, ...]:
        """Sizes on x, y, z in the order of the array's axes."""
        return (*reversed(sizes), *([self._components] if self._components > 1 else []))

    @property
    def shape(self) -> Tuple[int, ...]:
        """Samples on z, y and x, and components if there are several."""
        return self._with_components(self._description[0])

    @property
    def ndim(self) -> int:
        """3, or 4 if there are several components."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """The number of elements of the array."""
        size = 1
        for count in self.shape:
            size *= count
        return size

    @property
    def nbytes(self) -> int:
        """The memory of all elements."""
        return self.size * self.dtype.itemsize

    @property
    def chunks(self) -> Tuple[int, ...]:
        """What is best read together, in the order of `shape`: a block, or a chunk of the file.

        ``dask.array.from_array(volume, chunks=volume.chunks)`` gives each task whole blocks; without
        ``chunks``, Dask joins some of them to larger ones.
        """
        return self._with_components(self._description[5])

    # Where it lies.

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Between neighbours on x, y and z; of a rectilinear grid (`coordinates`) the mean."""
        x, y, z = self._description[1]
        return x, y, z

    @property
    def origin(self) -> Tuple[float, float, float]:
        """x, y, z of the first sample, ``volume[0, 0, 0]``."""
        x, y, z = self._description[2]
        return x, y, z

    @property
    def direction(self) -> numpy.ndarray:
        """A matrix of 3 x 3, whose columns are the directions of the axes x, y, z of the array.

        Sample ``[k, j, i]`` lies at ``origin + direction @ (spacing * (i, j, k))``.
        """
        return numpy.reshape(self._description[3], (3, 3))

    @property
    def coordinates(self) -> Optional[Tuple[numpy.ndarray, ...]]:
        """Of a rectilinear grid the coordinates on x, y and z; else None."""
        lines = self._description[4]
        return None if lines is None else tuple(numpy.array(axis) for axis in lines)

    @property
    def length_unit(self) -> str:
        """The unit of spacing and coordinates, as "mm" or "um"; "" if the file does not tell."""
        return self._description[6]

    # What else the file has.

    @property
    def arrays(self) -> Tuple[str, ...]:
        """The names of the arrays in the file."""
        return tuple(name for name, *_ in self._opened.file.arrays)

    @property
    def steps(self) -> int:
        """The number of time steps in the file."""
        return len(self._opened.file.times)

    @property
    def times(self) -> Tuple[Optional[float], ...]:
        """The times of the time steps, None where the file does not tell."""
        return tuple(self._opened.file.times)

    @property
    def levels(self) -> int:
        """The number of levels of detail: 1 for a file of another format that has no index."""
        return self._opened.file.levels

    @property
    def attributes(self) -> Dict[str, Any]:
        """The attributes of the dataset in a file of HDF5, Zarr or N5, of an image in Zarr also those of its
        group, read anew each time: texts, numbers, and flat lists of them; None for others and for NaN. Of a
        DICOM series WindowCenter and WindowWidth, of the first window that it names. Empty for other formats,
        and for blocked volumes, which do not have them.
        """
        if self._opened.is_stored:
            return {}
        attributes: Dict[str, Any] = json.loads(_library.read_attributes(self._opened.name, self._opened.how[1]) or "{}")
        return attributes

    @property
    def datasets(self) -> Tuple[str, ...]:
        """What the file of another format has: each name opens as ``open("path:name")``. Of an image in
        OME-Zarr these are the levels of its own pyramid. They are no `levels` here, since their samples are
        averages, and a level has every second sample of the one before.
        """
        return () if self._opened.is_stored else tuple(_library.list_datasets(self._opened.name))

    def array(self, name: str) -> Volume:
        """Another array of the file; also ``volume[name]``.

        Raises
        ------
        KeyError
            The file has no such array.
        """
        return Volume(self._opened, self._find_array(name), self._step, self._level)

    def at(self, step: int) -> Volume:
        """Another time step, counted from 0; from the last one if it is negative.

        Raises
        ------
        IndexError
            There is no such time step.
        """
        return Volume(self._opened, self._array, self._find_step(step), self._level)

    def level(self, number: int) -> Volume:
        """The volume at a level of detail: 0 is all samples, each next one every second of them on each axis.

        Examples
        --------
        >>> si.open("waves.bvol").level(2).shape
        (5, 8, 10)

        Raises
        ------
        IndexError
            There is no such level.
        """
        return Volume(self._opened, self._array, self._step, self._find_level(number))

    def _find_array(self, name: str) -> int:
        if name not in self.arrays:
            raise KeyError(f"{self.path}: has no array {name!r}, but {', '.join(map(repr, self.arrays))}")
        return self.arrays.index(name)

    def _find_step(self, step: int) -> int:
        try:
            return range(self.steps)[take_integer("step", step)]
        except IndexError:
            raise IndexError(f"{self.path}: has {self.steps} time steps, and no step {step}") from None

    def _find_level(self, level: int) -> int:
        number = take_integer("level", level)
        if not 0 <= number < self.levels:
            raise IndexError(f"{self.path}: has {self.levels} levels, and no level {level}")
        return number

    # Samples.

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            return self.array(key)
        selection = parse_key(key, self.shape, self.dtype)
        if selection.is_empty:
            return numpy.empty(selection.shape, self.dtype)
        if selection.runs is None:
            return self._read(selection.axes)[selection.rest]
        axis, runs = selection.runs
        parts = [self._read((*selection.axes[:axis], run, *selection.axes[axis + 1 :])) for run in runs]
        return numpy.concatenate(parts, axis)[selection.rest]

    def _read(self, axes: Sequence[AxisRange]) -> numpy.ndarray:
        samples = numpy.empty([axis.size for axis in axes], self.dtype)
        components = list(range(*axes[3])) if len(axes) > 3 else [0]
        x_y_z = axes[2::-1]
        self._opened.file.read(
            samples,
            components,
            self._opened.threads,
            array=self._array,
            step=self._step,
            level=self._level,
            low=tuple(axis.low for axis in x_y_z),
            high=tuple(axis.high for axis in x_y_z),
            stride=tuple(axis.step for axis in x_y_z),
        )
        return samples

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> numpy.ndarray:
        if copy is False:
            raise ValueError(f"{self.path}: an array of the samples is always a copy")
        samples = self[...]
        return samples if dtype is None else samples.astype(dtype, copy=False)

    # Isosurfaces.

    def isosurface(
        self,
        isovalue: Any,
        *,
        level: Optional[int] = None,
        region: Optional[Sequence[float]] = None,
        normals: bool = True,
        component: Optional[int] = None,
        attributes: Sequence[str] = (),
        dtype: Any = None,
        close_boundary: bool = False,
        inside: str = "above",
        drop_degenerate_triangles: bool = False,
        maximum_islands: int = 0,
        minimum_island_size: float = 0,
        island_size: str = "triangles",
    ) -> Surface:
        """Extracts isosurfaces: triangles and points are those of vtkFlyingEdges3D.

        Normals point to lower values, and corners run counter-clockwise seen from there, whatever the
        direction of the grid. (vtkFlyingEdges3D turns corners in left-handed grids.)

        Only blocks that the surface crosses are read. Of a file of another format without an index, the time
        step is read into memory first, in blocks, which stay there until another step is, or the volume is
        closed.

        Parameters
        ----------
        isovalue : float or sequence of float
            Samples of at least the isovalue are inside.
        level : int, optional
            Of detail. That of this volume if it is not given.
        region : sequence of six float, optional
            x0, x1, y0, y1, z0, z1 in the world: only blocks that meet this box give their triangles, which
            may lie beside it. Of an address without an index: only cells that meet it.
        normals : bool
            Whether to compute normals, from the gradients of the samples.
        component : int, optional
            Which component to contour; if it is not given, the magnitude of several.
        attributes : sequence of str
            Other arrays, to be interpolated at the points.
        dtype : float32 or float64, optional
            Of the points; if it is not given, float64 where float32 has fewer than 16 places between
            neighbouring samples, as at map coordinates, else float32.
        close_boundary : bool
            Whether to close the surface at the sides of the volume, as for printing. Degenerate triangles are
            dropped then.
        inside : "above" or "below"
            Of a closed surface: whether it bounds what is at least the isovalue, or what is below it, as pores;
            then normals point to higher values, and corners run the other way round.
        drop_degenerate_triangles : bool
            Whether to leave out triangles whose corners meet in a sample that is the isovalue.
        maximum_islands : int
            How many connected parts to keep of each isosurface, the largest; 0: all.
        minimum_island_size : float
            Smaller ones are left out.
        island_size : "triangles", "area" or "volume"
            By what islands are large or small: triangles (at full resolution), or area or enclosed volume in the
            unit of `spacing`.

        Raises
        ------
        IndexError, KeyError
            There is no such level, component or array.
        ValueError
            Points cannot have that dtype.
        OSError
            The file cannot be read, or is damaged; the message names it.
        MemoryError
            The surface does not fit memory, or the samples of a file without an index take more than a third
            of what is free: `index` the file then.

        Examples
        --------
        >>> surface = si.open("waves.bvol").isosurface(0.3)
        >>> surface
        <Surface of 0.3: 9691 triangles, 5200 points>
        >>> surface.points.mean(axis=0).round(1)
        array([ 9.7, 14.9, 19.7], dtype=float32)
        >>> si.open("waves.bvol").isosurface(0.3, close_boundary=True, maximum_islands=1, island_size="volume")
        <Surface of 0.3: 14282 triangles, 7135 points>
        """
        file = self._opened.file
        below = _take_name("inside", inside, ("above", "below")) == 1
        if below and not close_boundary:
            raise ValueError("inside='below' is of closed surfaces: close_boundary=True")
        least = take_number("minimum_island_size", minimum_island_size)
        most = take_integer("maximum_islands", maximum_islands, 0)
        size = _take_name("island_size", island_size, _ISLAND_SIZES)
        return Surface(
            **file.isosurface(
                self._opened.threads,
                scalar=self._find_scalar(component, level),
                isovalues=list_isovalues(isovalue),
                region=check_region(region),
                normals=bool(normals),
                attributes=[self._find_array(name) for name in attributes],
                points=_find_type(dtype),
                closed=(-1 if below else 1) if close_boundary else 0,
                drop_degenerate_triangles=bool(drop_degenerate_triangles),
                island_size=size,
                minimum_island=least,
                maximum_islands=most,
            )
        )

    def active_blocks(
        self, isovalue: Any, *, region: Optional[Sequence[float]] = None, component: Optional[int] = None
    ) -> numpy.ndarray:
        """The blocks that isosurfaces cross, without reading their samples.

        Parameters are those of `isosurface`.

        Returns
        -------
        ndarray of int64, shape (blocks, 3, 2)
            First sample and end of each block on z, y and x: ``volume[z0:z1, y0:y1, x0:x1]``. Neighbours
            share a layer of samples. At a coarse level some may be empty.

        Examples
        --------
        >>> si.open("waves.bvol").active_blocks(0.3)
        array([[[ 0, 20],
                [ 0, 30],
                [ 0, 33]],
        <BLANKLINE>
               [[ 0, 20],
                [ 0, 30],
                [32, 40]]])
        """
        return self._opened.file.active_blocks(
            scalar=self._find_scalar(component), isovalues=list_isovalues(isovalue), region=check_region(region)
        )

    def spectrum(self, component: Optional[int] = None) -> Spectrum:
        """What the isosurface of each isovalue is, without extracting it.

        It is read from the file, and belongs to the finest level that is stored in the same blocks. A file of
        another format without an index is read into memory first.

        Examples
        --------
        >>> spectrum = si.open("waves.bvol").spectrum()
        >>> assert spectrum.area is not None
        >>> isovalue = spectrum.isovalues[spectrum.area.argmax()]
        >>> bool(spectrum.isovalues[0] < isovalue < spectrum.isovalues[-1])
        True
        """
        return Spectrum(**self._opened.file.spectrum(self._find_scalar(component)))

    def _find_scalar(self, component: Optional[int], level: Optional[int] = None) -> Tuple[int, int, int, int]:
        number = self._level if level is None else self._find_level(level)
        return self._array, self._find_component(component), self._step, number

    def _find_component(self, component: Optional[int]) -> int:
        if component is None:
            return 0 if self._components == 1 else _library.MAGNITUDE
        try:
            return range(self._components)[take_integer("component", component)]
        except IndexError:
            raise IndexError(
                f"{self.path}: {self.name!r} has {self._components} components, and no {component}"
            ) from None

    # The file.

    def close(self) -> None:
        """Closes the file, for all volumes that were made of one another. Reading is a ValueError then."""
        self._opened.close()

    def __enter__(self) -> Volume:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._opened._file is None:
            return f"<Volume {self.path!r}, closed>"
        step = f", step {self._step} of {self.steps}" if self.steps > 1 else ""
        return (
            f"<Volume {self.path!r}, array {self.name!r}: {self.shape} {self.dtype}{step}, "
            f"level {self._level} of {self.levels}>"
        )

    def __reduce__(self) -> Any:
        path, axes, folder, threads, region, place = self._opened.how
        path = path if "://" in path else os.path.abspath(path)
        how = path, axes, folder and os.path.abspath(folder), threads, region, place
        return _reopen, (how, self.name, self._step, self._level)


def open_volume(
    path: str,
    step: int,
    axes: str = "",
    index_folder: str = "",
    threads: Optional[int] = None,
    region: Optional[Sequence[float]] = None,
    place: Mapping[str, Any] = {},
) -> Volume:
    """The first array of a file that has a volume, at level 0. `place`: spacing, origin and unit in place of the file's."""
    volume = Volume(_Opened(path, axes, index_folder, threads, region, place), 0, 0, 0)
    return volume.at(step)


def _reopen(how: Tuple[Any, ...], name: str, step: int, level: int) -> Volume:
    """A volume that was pickled, of a file that may be another one by now."""
    return Volume(_Opened(*how), 0, 0, 0).at(step).array(name).level(level)


def list_isovalues(isovalue: Any) -> Sequence[float]:
    isovalues = numpy.ravel(take_numbers("isovalue", isovalue))
    if not len(isovalues):
        raise ValueError("there is no isovalue")
    return isovalues.tolist()


def check_place(
    spacing: Optional[Sequence[float]], origin: Optional[Sequence[float]], length_unit: Optional[str]
) -> Mapping[str, Any]:
    place: Dict[str, Any] = {}
    for name, given in (("spacing", spacing), ("origin", origin)):
        if given is not None:
            place[name] = take_numbers(name, given, (3,), "x, y, z").tolist()
    if length_unit is not None:
        place["unit"] = take_text("length_unit", length_unit)
    return place


def check_region(region: Optional[Sequence[float]]) -> Optional[Sequence[float]]:
    return None if region is None else take_numbers("region", region, (6,), "x0, x1, y0, y1, z0, z1").tolist()
