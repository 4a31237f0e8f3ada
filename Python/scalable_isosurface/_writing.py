# SPDX-License-Identifier: BSD-3-Clause
"""Blocked volumes made of arrays and files."""

from __future__ import annotations

import copy
import errno
import os
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy

from . import _library
from ._arguments import take_integer, take_number, take_numbers, take_path, take_text, take_threads
from ._opening import MEMORY, tell_left_out
from ._volume import Volume, open_volume

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class _Settings(NamedTuple):
    block_size: int
    stores: int
    replicas: int
    codec: bytes
    codec_level: int
    memory: int
    threads: int


class _Place(NamedTuple):
    """Where the samples are to lie; None: as the source says."""

    spacing: Optional[Sequence[float]]
    origin: Optional[Sequence[float]]
    direction: Any
    length_unit: Optional[str]

    def make_writing(self, path: str, description: Sequence[Any], settings: Dict[str, Any]) -> _library.VolumeWriting:
        """`description`: of the source, as that of a VolumeFile."""
        dimensions, spacing, origin, direction, lines, _, unit = description[:7]
        if self.spacing is not None:
            spacing, lines, unit = _take_three("spacing", self.spacing), None, ""
        elif lines is not None and (self.origin is not None or self.direction is not None):
            raise ValueError("the coordinates of a rectilinear grid say where it lies; spacing makes it regular")
        if self.origin is not None:
            origin = _take_three("origin", self.origin)
        if self.direction is not None:
            direction = take_numbers("direction", self.direction, (3, 3), "3 x 3 numbers").ravel().tolist()
        if self.length_unit is not None:
            unit = take_text("length_unit", self.length_unit)
        return _library.VolumeWriting(
            os.fsencode(path),
            lines,
            settings,
            dimensions=tuple(dimensions),
            spacing=tuple(spacing),
            origin=tuple(origin),
            direction=tuple(direction),
            length_unit=_library.encode(unit),
        )


def create(
    source: Any,
    path: Union[str, os.PathLike],
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Any = None,
    length_unit: Optional[str] = None,
    name: Optional[str] = None,
    time: Union[None, float, Sequence[float]] = None,
    append: bool = False,
    overwrite: bool = False,
    axes: str = "",
    block_size: int = 32,
    compression: str = "lz4",
    stores: int = 1,
    replicas: int = 1,
    memory: int = MEMORY,
    threads: Optional[int] = None,
) -> Volume:
    """Writes a blocked volume, in memory of constant size, and opens it.

    Parameters
    ----------
    source : array, Volume, mapping or str
        An array of the shape (z, y, x), or (z, y, x, components): of NumPy, Zarr, h5py or Dask, a `Volume`, or
        anything that has ``shape``, ``dtype`` and slices. It is read box by box, some of them more than once.
        A mapping of names to such arrays of one shape is a volume of several arrays. The name of a file stands
        for all of its arrays and time steps (see `open`); with several steps it cannot be `path` itself, nor
        a file whose index is `path`. Nor can a `Volume` of such a file, or of one that has other arrays.
    path : str or path
        Of the volume, ``NAME.bvol``, in a folder that is there.
    spacing, origin : sequence of three float, optional
        On x, y, z. If they are not given, those of the file or the `Volume`; else 1 and 0. Of a rectilinear
        grid, origin and direction can be given only with spacing, which makes a regular grid of it.
    direction : array of 3 x 3, optional
        Its columns are the directions of x, y, z.
    length_unit : str, optional
        Of spacing and origin: "m", "mm", "um", "nm", "angstrom", "inch", ... If it is not given, that of the
        file or the `Volume`; but with spacing none.
    name : str, optional
        Of the array, if there is one. If it is not given, that of the `Volume`, or "scalars".
    time : float or sequence of float, optional
        Of the time step, or of each. If it is not given, that of the file or the `Volume`; of an array with
        an axis t the numbers 0, 1, 2 and so on.
    append : bool
        Whether to append to the volume that is there, which must have the same grid, arrays and settings, and
        earlier times.
    overwrite : bool
        Whether to replace a volume that is there, with all of its time steps, when the new one is complete.
    axes : str
        Of an array: what its axes are, a letter each: x, y and z, perhaps t (time steps) and c (components).
        Of a file: see `open`.
    block_size : int
        16, 32 or 64 cells a side.
    compression : str
        ``"none"``, ``"lz4"`` or ``"zstd"``, perhaps with a level: ``"zstd:9"``.
    stores, replicas : int
        For reading on several nodes or disks.
    memory : int
        Bytes that writing may take.
    threads : int, optional
        As many as there are cores if it is not given.

    Raises
    ------
    ValueError, TypeError
        The source cannot be a volume, or a setting makes no sense.
    FileExistsError
        There is a file at `path`, and neither `append` nor `overwrite` is set.
    OSError
        A file cannot be read or written; the message names it. What a slice of the source raises is raised, too.

    Warns
    -----
    UserWarning
        The disk may be too small: the samples do not fit uncompressed. They are written nevertheless. Or:
        what of a file is not read (see `open`).

    Examples
    --------
    >>> ramp = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
    >>> volume = si.create(ramp, "ramp.bvol", spacing=(0.5, 0.5, 2), name="ramp")
    >>> volume
    <Volume 'ramp.bvol', array 'ramp': (2, 3, 4) uint8, level 0 of 6>
    >>> bool((volume[:] == ramp).all())
    True
    """
    target = take_path("path", path)
    if not target.endswith(".bvol"):
        raise ValueError(f"{target}: the name of a blocked volume ends with .bvol")
    if not os.path.isdir(os.path.dirname(target) or "."):
        raise FileNotFoundError(errno.ENOENT, "there is no such folder", os.path.dirname(target))
    if os.path.lexists(target) and not append and not overwrite:
        raise FileExistsError(errno.EEXIST, "is there already; overwrite=True replaces it", target)
    codec, _, codec_level = take_text("compression", compression).partition(":")
    if codec_level and not codec_level.isdecimal():
        raise ValueError(f"{compression!r} is no compression; levels are numbers")
    settings = _Settings(
        take_integer("block_size", block_size),
        take_integer("stores", stores, 1),
        take_integer("replicas", replicas, 1),
        _library.encode(codec),
        int(codec_level or 0),
        take_integer("memory", memory, 1),
        take_threads(threads),
    )
    place = _Place(spacing, origin, direction, length_unit)
    if isinstance(source, (str, os.PathLike)):
        if name is not None:
            raise ValueError("name: the arrays of a file have names")
        file = open_volume(take_path("source", source), 0, axes, threads=threads)
        tell_left_out(file.path, file._opened.file.left_out)
        _write_file(file, target, place, settings, None if time is None else take_number("time", time), bool(append))
    else:
        name = None if name is None else take_text("name", name)
        _write_arrays(source, target, place, settings, time, bool(append), name, take_text("axes", axes))
    return open_volume(target, -1, threads=threads)


def _write_file(
    volume: Volume, path: str, place: _Place, settings: _Settings, time: Optional[float], append: bool
) -> None:
    """Writes all time steps of a file."""
    with volume:
        file = volume._opened.file
        if time is not None and volume.steps > 1:
            raise ValueError(f"time: {volume.path} has {volume.steps} time steps")
        _check_output(path, volume, volume.steps == 1, "several time steps")
        writing = place.make_writing(path, file.describe(0), {**settings._asdict(), "append": append})
        writing.write_file(file, volume.times if time is None else [time])


def _write_arrays(
    source: Any,
    path: str,
    place: _Place,
    settings: _Settings,
    time: Union[None, float, Sequence[float]],
    append: bool,
    name: Optional[str],
    axes: str,
) -> None:
    """Writes the time steps of arrays."""
    if isinstance(source, Mapping):
        if name is not None:
            raise ValueError("name: the arrays of a mapping have names")
        arrays = [_Samples(array, str(key), axes) for key, array in source.items()]
    else:
        arrays = [_Samples(source, name or (source.name if isinstance(source, Volume) else "scalars"), axes)]
    if not arrays:
        raise ValueError("there is no array")
    volumes = [array.source for array in arrays if isinstance(array.source, Volume)]
    for volume in volumes:
        is_whole = volume.steps == 1 and {other.name for other in volumes}.issuperset(volume.arrays)
        _check_output(path, volume, append or is_whole, "other time steps or arrays")
    first = arrays[0]
    if any((array.shape, array.steps) != (first.shape, first.steps) for array in arrays):
        raise ValueError("the arrays have not the same shape")
    if isinstance(first.source, Volume) and not axes:
        description: Tuple[Any, ...] = first.source._description
        time = first.source.times[first.source._step] if time is None else time
    else:
        description = (first.shape[::-1], (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), _IDENTITY, None, None, "")
    times: List[Optional[float]] = [None]
    if time is not None:
        times = take_numbers("time", time).reshape(-1).tolist()
    elif "t" in axes:
        times = [float(step) for step in range(first.steps)]
    if len(times) != first.steps:
        raise ValueError(f"time: there are {first.steps} time steps, and {len(times)} times")
    writing = place.make_writing(path, description, {**settings._asdict(), "append": append})
    steps = [
        [(array.name, array.at(step), array.kind, array.components, array.unit) for array in arrays]
        for step in range(first.steps)
    ]
    writing.write_arrays(steps, times, first.chunk)


def _check_output(path: str, volume: Volume, is_whole: bool, others: str) -> None:
    """Raises a ValueError if the new volume would replace the source, or the index by which that was opened. A
    whole blocked volume may be replaced."""
    for name in (os.fsdecode(volume._opened.file.path), volume.path):
        file = name
        while ":" in file and not os.path.exists(file):
            file = file.rpartition(":")[0]  # "run.h5:/data"
        if os.path.exists(file) and os.path.exists(path) and os.path.samefile(file, path):
            if file != name or not name.endswith(".bvol"):
                raise ValueError(f"{path}: is its own source, a file of another format; write another file")
            if not is_whole:
                raise ValueError(f"{path}: is its own source, and has {others}; write another file")


def _take_three(name: str, numbers: Any) -> List[float]:
    return take_numbers(name, numbers, (3,), "three numbers, on x, y, z").tolist()


#: The types of samples that other types of arrays become.
_WIDENED = {"bool": "uint8", "float16": "float32"}


class _Samples:
    """A source of samples in the order z, y, x and components. Samples that are masked are NaN."""

    def __init__(self, source: Any, name: str, axes: str) -> None:
        if not hasattr(source, "shape") or not hasattr(source, "dtype"):
            source = numpy.asanyarray(source)
        shape = tuple(source.shape)
        if not axes and (len(shape) not in (3, 4) or 0 in shape):
            raise ValueError(
                f"{name!r} has the shape {shape}; that of a volume is (z, y, x) or (z, y, x, components); axes= "
                "names others"
            )
        self.axes = axes or "zyxc"[: len(shape)]
        if len(shape) != len(self.axes) or 0 in shape:
            raise ValueError(f"axes: {name!r} has the shape {shape}, which is not that of {axes!r}")
        if not set("xyz") <= set(self.axes) <= set("xyztc") or len(set(self.axes)) != len(self.axes):
            raise ValueError(f"axes: {axes!r} does not name x, y, z, and perhaps t and c, once each")
        try:
            self._dtype = numpy.dtype(source.dtype).newbyteorder("=")
        except TypeError:
            raise TypeError(f"{name!r} has samples of {source.dtype}; give an array of NumPy") from None
        self.kind = _WIDENED.get(self._dtype.name, self._dtype.name)
        if self.kind not in _library.VALUE_TYPES:
            raise TypeError(f"{name!r} has the type {self.kind}; samples are of {', '.join(_library.VALUE_TYPES)}")
        sizes = dict(zip(self.axes, shape))
        self.source = source
        self.name = name
        self.shape = (sizes["z"], sizes["y"], sizes["x"])
        self.components = sizes.get("c", 1)
        self.unit = source.unit if isinstance(source, Volume) else ""
        self.steps = sizes.get("t", 1)
        # Of Zarr (sizes) or Dask (sizes of each chunk).
        chunks = dict(zip(self.axes, getattr(source, "chunks", None) or ()))
        self.chunk = [int(numpy.max(chunks[axis])) for axis in "xyz"] if chunks else None
        self._step = 0

    def at(self, step: int) -> _Samples:
        """Those of a time step."""
        of_step = copy.copy(self)
        of_step._step = step
        return of_step

    def __getitem__(self, key: Tuple[slice, slice, slice]) -> numpy.ndarray:
        chosen = dict(zip("zyxct", (*key, slice(None), self._step)))
        samples = numpy.asanyarray(self.source[tuple(chosen[axis] for axis in self.axes)])
        left = self.axes.replace("t", "")
        samples = samples.transpose([left.index(axis) for axis in "zyxc" if axis in left])
        # A variable of NetCDF that is scaled has another type than its slices.
        if not numpy.can_cast(samples.dtype, self._dtype, "same_kind"):
            raise TypeError(f"{self.name!r} has the type {self._dtype.name}, but slices of {samples.dtype.name}")
        if isinstance(samples, numpy.ma.MaskedArray):
            if numpy.ma.is_masked(samples) and samples.dtype.kind != "f":
                raise ValueError(
                    f"{self.name!r} has masked samples, and {samples.dtype.name} has no NaN for them; "
                    "write array.filled(VALUE), or array.astype('float32')"
                )
            samples = samples.filled(numpy.nan) if samples.dtype.kind == "f" else samples.data
        return numpy.asarray(samples, self.kind)
