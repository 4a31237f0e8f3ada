# SPDX-License-Identifier: BSD-3-Clause
"""Blocked volumes made of arrays and files."""

from __future__ import annotations

import os
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy

from . import _core
from ._opening import MEMORY
from ._volume import Volume, open_volume

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class _Settings(NamedTuple):
    block_size: int
    stores: int
    replicas: int
    codec: str
    codec_level: int
    memory: int
    threads: int


class _Place(NamedTuple):
    """Where the samples are to lie; None: as the source says."""

    spacing: Optional[Sequence[float]]
    origin: Optional[Sequence[float]]
    direction: Any
    length_unit: Optional[str]

    def make_writing(self, path: str, description: Sequence[Any]) -> _core.VolumeWriting:
        """`description`: of the source, as that of a VolumeFile."""
        dimensions, spacing, origin, direction, lines, _, unit = description
        if self.spacing is not None:
            spacing, lines, unit = _list_three("spacing", self.spacing), None, ""
        elif lines is not None and (self.origin is not None or self.direction is not None):
            raise ValueError("the coordinates of a rectilinear grid say where it lies; spacing makes it regular")
        if self.origin is not None:
            origin = _list_three("origin", self.origin)
        if self.direction is not None:
            direction = numpy.reshape(numpy.asarray(self.direction, float), 9).tolist()
        if self.length_unit is not None:
            unit = self.length_unit
        return _core.VolumeWriting(path, dimensions, spacing, origin, direction, lines, unit)


def create(
    source: Any,
    path: Union[str, os.PathLike],
    *,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    direction: Any = None,
    length_unit: Optional[str] = None,
    name: Optional[str] = None,
    time: Optional[float] = None,
    append: bool = False,
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
        Of the volume, ``NAME.bvol``. One that is there is replaced when the new one is complete, with all of
        its time steps.
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
    time : float, optional
        Of the time step. If it is not given, that of the file or the `Volume`.
    append : bool
        Whether to append a time step to the volume that is there, which must have the same grid, arrays and
        settings, and earlier times.
    axes : str
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
    OSError
        A file cannot be read or written; the message names it. What a slice of the source raises is raised, too.

    Warns
    -----
    UserWarning
        The disk may be too small: the samples do not fit uncompressed. They are written nevertheless.

    Examples
    --------
    >>> ramp = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
    >>> volume = si.create(ramp, "ramp.bvol", spacing=(0.5, 0.5, 2), name="ramp")
    >>> volume
    <Volume 'ramp.bvol', array 'ramp': (2, 3, 4) uint8, level 0 of 6>
    >>> bool((volume[:] == ramp).all())
    True
    """
    target = os.fspath(path)
    if not target.endswith(".bvol"):
        raise ValueError(f"{target}: the name of a blocked volume ends with .bvol")
    codec, _, codec_level = compression.partition(":")
    if codec_level and not codec_level.isdecimal():
        raise ValueError(f"{compression!r} is no compression; levels are numbers")
    settings = _Settings(block_size, stores, replicas, codec, int(codec_level or 0), memory, threads or 0)
    place = _Place(spacing, origin, direction, length_unit)
    if isinstance(source, (str, os.PathLike)):
        if name is not None:
            raise ValueError("name: the arrays of a file have names")
        _write_file(open_volume(os.fspath(source), 0, axes, threads=threads), target, place, settings, time, append)
    else:
        _write_arrays(source, target, place, settings, time, append, name)
    return open_volume(target, -1, threads=threads)


def _write_file(
    volume: Volume, path: str, place: _Place, settings: _Settings, time: Optional[float], append: bool
) -> None:
    """Writes all time steps of a file."""
    with volume:
        file = volume._opened.file
        if time is not None and volume.steps > 1:
            raise ValueError(f"time: {volume.path} has {volume.steps} time steps")
        if volume.steps > 1 and _is_file_of(volume, path):
            raise ValueError(f"{path}: is its own source, and has several time steps; write another file")
        writing = place.make_writing(path, file.describe(0))
        writing.set(**settings._asdict(), time=time, append=append)
        writing.write_file(file, volume.times if time is None else [time])


def _write_arrays(
    source: Any,
    path: str,
    place: _Place,
    settings: _Settings,
    time: Optional[float],
    append: bool,
    name: Optional[str],
) -> None:
    """Writes a time step of arrays."""
    if isinstance(source, Mapping):
        if name is not None:
            raise ValueError("name: the arrays of a mapping have names")
        arrays = [_describe(array, str(key)) for key, array in source.items()]
    else:
        arrays = [_describe(source, name or (source.name if isinstance(source, Volume) else "scalars"))]
    if not arrays:
        raise ValueError("there is no array")
    volumes = [array for _, array, *_ in arrays if isinstance(array, Volume)]
    for volume in volumes:
        is_whole = volume.steps == 1 and {other.name for other in volumes}.issuperset(volume.arrays)
        if not append and not is_whole and _is_file_of(volume, path):
            raise ValueError(f"{path}: is its own source, and has other time steps or arrays; write another file")
    first = arrays[0][1]
    if any(array.shape[:3] != first.shape[:3] for _, array, _, _ in arrays):
        raise ValueError("the arrays have not the same shape")
    dimensions = first.shape[2::-1]
    if isinstance(first, Volume):
        description: Tuple[Any, ...] = first._description
        time = first.times[first._step] if time is None else time
    else:
        description = (dimensions, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), _IDENTITY, None, None, "")
    writing = place.make_writing(path, description)
    writing.set(**settings._asdict(), time=time, append=append)
    writing.write_arrays(arrays, _find_chunk(first))


def _is_file_of(volume: Volume, path: str) -> bool:
    """Whether a volume, or the index by which it was opened, is the file at a path."""
    opened = volume._opened.file.path  # "run.h5:/data" of another format, which is no blocked volume
    return os.path.exists(opened) and os.path.exists(path) and os.path.samefile(opened, path)


def _list_three(what: str, numbers: Any) -> List[float]:
    """Numbers on x, y, z."""
    if numpy.shape(numbers) != (3,):
        raise ValueError(f"{what} is three numbers, on x, y, z, and not {numbers!r}")
    return numpy.asarray(numbers, float).tolist()


def _describe(array: Any, name: str) -> Tuple[str, Any, str, int, str]:
    """Name, array, type, components and unit."""
    if not hasattr(array, "shape") or not hasattr(array, "dtype"):
        array = numpy.asarray(array)
    shape = tuple(array.shape)
    if len(shape) not in (3, 4) or 0 in shape:
        raise ValueError(
            f"{name!r} has the shape {shape}; that of a volume is (z, y, x) or (z, y, x, components)"
        )
    kind = numpy.dtype(array.dtype).newbyteorder("=").name
    if kind not in _core.VALUE_TYPES:
        raise TypeError(f"{name!r} has the type {kind}; samples are of {', '.join(_core.VALUE_TYPES)}")
    unit = array.unit if isinstance(array, Volume) else ""
    return name, array, kind, shape[3] if len(shape) == 4 else 1, unit


def _find_chunk(array: Any) -> Optional[List[int]]:
    """The chunks of Zarr (sizes) or Dask (sizes of each chunk) on x, y, z; None if there are none."""
    chunks = getattr(array, "chunks", None)
    if not chunks:
        return None
    return [int(numpy.max(chunks[axis])) for axis in (2, 1, 0)]
