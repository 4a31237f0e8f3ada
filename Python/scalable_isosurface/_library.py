# SPDX-License-Identifier: BSD-3-Clause
"""The library of C, as the modules of this package use it. scalable_isosurface.h says what its functions do.

Vertices and sizes are x, y, z here; the modules turn them into NumPy's order."""

from __future__ import annotations

import ctypes
import math
import warnings
from ctypes import byref, c_double, c_int32, c_int64, c_size_t, c_void_p, POINTER
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy

from ._functions import (  # noqa: F401  (some are for the modules that use this one)
    MAGNITUDE, Stopped, VALUE_TYPES, _AllGather, _Array, _Boxes, _Exchange, _Path, _Piece, _Progress, _QUANTITIES,
    _Reader, _Scalar, _Slice, _Spectrum, _Surface, _Texts, _Warn, _make_box, _make_coding, _make_grid,
    _make_growing_state, _make_opening, _make_piece, _make_ranks, _make_reading, _make_request, _make_run,
    _make_settings, _si, _text, _three_numbers, encode,
)  # fmt: skip


class Ranks:
    """The ranks of a parallel program. `all_gather` fills an array with those of all ranks; `exchange` is called once
    for each other rank, in an order in which partners meet, with what is sent and what is filled."""

    def __init__(
        self,
        rank: int,
        count: int,
        all_gather: Callable[[numpy.ndarray, numpy.ndarray], Any],
        exchange: Callable[[int, numpy.ndarray, numpy.ndarray], Any],
    ) -> None:
        self.rank, self.count, self.all_gather = rank, count, all_gather

        def gather(_: Any, mine: int, whole: int, size: int) -> int:
            try:
                all_gather(_find_bytes(mine, size), _find_bytes(whole, size * count))
            except BaseException:  # pylint: disable=broad-except  # the library tells that ranks do not answer
                return 1
            return 0

        def swap(_: Any, outgoing: Any, sent: Any, incoming: Any, received: Any) -> int:
            for turn in range(count):
                other = (turn - rank) % count
                if other != rank:
                    try:
                        exchange(
                            other, _find_bytes(outgoing[other], sent[other]), _find_bytes(incoming[other], received[other])
                        )
                    except BaseException:  # pylint: disable=broad-except
                        return 1
            return 0

        self._callbacks = _AllGather(gather), _Exchange(swap)
        self.structure = _make_ranks(rank=rank, count=count, all_gather=self._callbacks[0], exchange=self._callbacks[1])


def _find_bytes(address: Optional[int], size: int) -> numpy.ndarray:
    """Memory of the library, during a call."""
    memory: Any = (ctypes.c_uint8 * size).from_address(address) if address and size else b""
    return numpy.frombuffer(memory, numpy.uint8)


class How:
    """How calls run: on which ranks, and who learns of their progress and warnings, and may stop them."""

    def __init__(
        self,
        ranks: Optional[Ranks] = None,
        progress: Optional[Callable[[float], int]] = None,
        warn: Optional[Callable[[str], Any]] = None,
    ) -> None:
        self.ranks, self.progress, self.warn = ranks, progress, warn
        self.alone = How(None, progress, warn) if ranks else self  #: for calls that are not collective


_ALONE = How()


class _Call:
    """A call that reads or writes. It ends with what a callback has raised: a handler of a signal, a warning where
    these are errors, or a source."""

    #: Calls that have ended, for the next ones: making callbacks takes longer than many a call.
    _idle: List[_Call] = []

    def __init__(self) -> None:
        self._raised: List[BaseException] = []
        self._caller = 0
        self._told: Optional[List[str]] = None
        self._how = _ALONE
        self._run = _make_run(
            progress=_Progress(self.listen(self._advance, 1)), warn=_Warn(self.listen(self._warn, 1))
        )
        self.run = byref(self._run)

    @classmethod
    def begin(
        cls, threads: int = 0, caller: int = 0, told: Optional[List[str]] = None, how: How = _ALONE
    ) -> _Call:
        """`caller`: how many frames above the function with this call a warning is of. `told`: takes them instead."""
        try:
            call = cls._idle.pop()
        except IndexError:
            call = cls()
        call._run.threads = min(threads, (1 << 31) - 1)
        call._caller = caller
        call._told = told
        call._how = how
        call._run.ranks = None if how.ranks is None else ctypes.addressof(how.ranks.structure)
        return call

    def _advance(self, done: float) -> int:
        return self._how.progress(done) if self._how.progress else 0

    def _warn(self, message: bytes) -> int:
        if self._how.warn:
            self._how.warn(_text(message))
        elif self._told is None:
            warnings.warn(_text(message), stacklevel=3 + self._caller)
        else:
            self._told.append(_text(message))
        return 0

    def listen(self, step: Callable[[Any], int], failure: int) -> Callable[[Any], int]:
        """A callback that gives `failure` once the step has raised an exception.

        It is the function of a generator, which waits within its `try`: the exception of a signal is raised at the
        entry of a function of Python, where nobody but ctypes would catch it."""

        def wait() -> Iterator[Any]:
            answer: Optional[int] = None
            while True:
                try:
                    while True:
                        answer = step((yield answer))
                except GeneratorExit:
                    return
                except BaseException as error:  # pylint: disable=broad-except
                    self._raised.append(error)
                    answer = failure

        waiting: Any = wait()
        next(waiting)
        return waiting.send  # type: ignore[no-any-return]

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: Any) -> None:
        if self._raised:  # whoever clears its frames, as unittest does, ends the generators
            raise self._raised[0] from None
        self._how = _ALONE
        self._idle.append(self)


class _Owned:
    """What the library has given, and takes back when nobody has it."""

    def __init__(self, kind: Any, free: Callable[[Any], None]) -> None:
        self.pointer: Any = POINTER(kind)() if kind else c_void_p()
        self.place = byref(self.pointer)
        self._free = free

    def __del__(self) -> None:
        self._free(self.pointer)


class _Memory:
    """An array of an owner, which NumPy keeps."""

    __slots__ = ("owner", "__array_interface__")
    owner: _Owned
    __array_interface__: Dict[str, Any]


_CODES = {name: numpy.dtype(name).str for name in VALUE_TYPES}


def _view(owner: _Owned, address: Optional[int], dtype: str, *shape: int) -> numpy.ndarray:
    if address is None or 0 in shape:
        return numpy.empty(shape, dtype)
    memory = _Memory()
    memory.owner = owner
    memory.__array_interface__ = {"version": 3, "data": (address, False), "typestr": _CODES[dtype], "shape": shape}
    return numpy.asarray(memory)


def view_cells(owner: _Owned) -> Dict[str, Any]:
    """What else a surface has that VTK's filters give: offsets, global_ids and island_ids, or None, four numbers of
    the islands of each part, its level, the paths of blocks and that of each point."""
    surface = owner.pointer.contents
    kind, triangles = VALUE_TYPES[surface.corner_type], surface.triangle_count
    offsets = _view(owner, surface.offsets, kind, triangles + 1)
    return {
        "offsets": offsets,
        "corners": _view(owner, surface.corners, kind, int(offsets[-1]) if triangles else 0),
        "global_ids": _view(owner, surface.global_ids, "int64", surface.point_count),
        "island_ids": _view(owner, surface.island_ids, "int64", triangles) if surface.island_ids else None,
        "islands": _view(owner, surface.islands, "int64", surface.part_count, 4) if surface.islands else None,
        "level": surface.level,
        "blocks": [tuple(path.numbers[: path.count]) for path in surface.blocks[: surface.block_count]],
        "block_ids": _view(owner, surface.block_ids, "int32", surface.point_count if surface.block_count else 0),
    }


def view_surface(owner: _Owned, normals: bool) -> Dict[str, Any]:
    """What Surface is made of, by the names of its arguments."""
    surface = owner.pointer.contents
    points, triangles, parts = surface.point_count, surface.triangle_count, surface.part_count
    return {
        "points": _view(owner, surface.points, VALUE_TYPES[surface.point_type], points, 3),
        "triangles": _view(owner, surface.corners, VALUE_TYPES[surface.corner_type], triangles, 3),
        "normals": _view(owner, surface.normals, "float32", points, 3) if normals else None,
        "isovalues": _view(owner, surface.isovalues, "float64", parts),
        "point_offsets": _view(owner, surface.first_points, "int64", parts + 1),
        "triangle_offsets": _view(owner, surface.first_triangles, "int64", parts + 1),
        "attributes": {
            _text(one.name): _view(
                owner, one.values, VALUE_TYPES[one.type], points, *([one.components] if one.components > 1 else [])
            )
            for one in surface.attributes[: surface.attribute_count]
        },
    }


def find_kind(name: bytes) -> str:
    kind = c_int32()
    _si.find_kind(name, byref(kind))
    return ("blocked volume", "edge index", "source")[kind.value]


def _list_texts(function: Any, *arguments: bytes) -> List[str]:
    texts = _Owned(_Texts, _si.texts_free)
    with _Call.begin() as call:
        function(*arguments, call.run, texts.place)
    return [_text(text) for text in texts.pointer.contents.texts[: texts.pointer.contents.count]]


def list_datasets(path: bytes) -> List[str]:
    return _list_texts(_si.list_datasets, path)


def read_attributes(path: bytes, axes: str) -> str:
    return _list_texts(_si.read_attributes, path, encode(axes))[0]


class Fetching(_Owned):
    """si_fetching: what indexes have fetched of an address, one after another."""

    def __init__(self) -> None:
        super().__init__(None, _si.fetching_free)
        self.pointer = c_void_p(_si.fetching_new())


def _opening(
    axes: str,
    folder: bytes,
    spacing: Sequence[float] = (),
    origin: Sequence[float] = (),
    unit: Optional[str] = None,
    local_stores: int = 0,
    region: Optional[Sequence[float]] = None,
    fetch_budget: int = 0,
    fetching: Optional[Fetching] = None,
) -> Any:
    """A reference to a si_opening."""
    return byref(
        _make_opening(
            axes=encode(axes),
            index_folder=folder,
            spacing=_three_numbers(*spacing) if spacing else None,
            origin=_three_numbers(*origin) if origin else None,
            length_unit=None if unit is None else encode(unit),
            local_stores=local_stores,
            region=None if region is None else (c_double * 6)(*region),
            fetch_budget=fetch_budget,
            fetching=fetching and fetching.pointer,
        )
    )


def open_volume(path: bytes, axes: str, folder: bytes, threads: int, how: How = _ALONE, **place: Any) -> VolumeFile:
    """`place`: spacing, origin and unit in place of the file's; local_stores; region."""
    owned = _Owned(None, _si.volume_close)
    with _Call.begin(threads, how=how.alone) as call:
        _si.volume_open(path, _opening(axes, folder, **place), call.run, owned.place)
    return VolumeFile(owned, how)


def open_surface(path: bytes) -> SurfaceFile:
    return SurfaceFile(path)


def write_index(
    path: bytes, axes: str, folder: bytes, memory: int, threads: int, how: How = _ALONE, **place: Any
) -> str:
    """What of the file is left out."""
    told: List[str] = []
    with _Call.begin(threads, told=told, how=how) as call:
        _si.write_index(path, _opening(axes, folder, **place), memory, call.run)
    return "".join(told)


class GrowingFile:
    """si_growing: a file that is shown while it is indexed."""

    def __init__(self, path: bytes, axes: str, folder: bytes, step: int, memory: int, how: How, **place: Any) -> None:
        self._owned = _Owned(None, _si.growing_free)
        self._how = how
        with _Call.begin(how=how) as call:
            opening = _opening(axes, folder, **place)
            _si.growing_begin(path, opening, step, 0, memory, call.run, self._owned.place)

    def poll(self, seconds: float = 0) -> Tuple[int, float, str]:
        """The stage (0: nothing is new, 1: there is a larger sample, 2: the volume is ready), the finished part of the
        index, and what the sample is of the file."""
        state = _make_growing_state()
        with _Call.begin(how=self._how) as call:
            _si.growing_poll(self._owned.pointer, seconds, call.run, byref(state))
        return state.stage, state.done, _text(state.text or b"")

    def take(self) -> VolumeFile:
        owned = _Owned(None, _si.volume_close)
        with _Call.begin(how=self._how) as call:
            _si.growing_take(self._owned.pointer, call.run, owned.place)
        return VolumeFile(owned, self._how)


def _fill_grid(grid: Any, lines: Optional[Sequence[Sequence[float]]]) -> Any:
    for axis, line in enumerate(lines or ()):
        grid.lines[axis] = (c_double * len(line))(*line)
    return grid


def _describe(grid: Any) -> Tuple[Any, ...]:
    lines = [line[:size] for line, size in zip(grid.lines, grid.dimensions)] if grid.lines[0] else None
    parts = (tuple(part) for part in (grid.dimensions, grid.spacing, grid.origin, grid.direction))
    return (*parts, lines, tuple(grid.chunk), _text(grid.length_unit), tuple(grid.first), tuple(grid.zero))


class VolumeFile:
    """si_volume."""

    def __init__(self, owned: _Owned, how: How) -> None:
        self._owned = owned
        self.how = how
        info = _si.volume_describe(self._owned.pointer).contents
        self.path: bytes = info.path
        self.arrays: List[Tuple[str, str, int, str]] = [
            (_text(array.name), VALUE_TYPES[array.type], array.components, _text(array.unit))
            for array in info.arrays[: info.array_count]
        ]
        self.times: List[Optional[float]] = [
            None if math.isnan(time) else time for time in info.times[: info.step_count]
        ]
        self.levels: int = info.level_count
        self.left_out: str = _text(info.left_out)

    def describe(self, level: int) -> Tuple[Any, ...]:
        """Dimensions, spacing, origin, direction, lines or None, chunk, unit of length, first and zero."""
        return _describe(_si.volume_grid(self._owned.pointer, level).contents)

    def read(
        self, samples: numpy.ndarray, components: Sequence[int], threads: int, how: Optional[How] = None, **box: Any
    ) -> None:
        """`box`: members of si_box."""
        numbers = (c_int32 * len(components))(*components)
        whole = _make_box(component_count=len(components), components=numbers, **box)
        with _Call.begin(threads, how=how or self.how.alone) as call:
            memory = samples.__array_interface__["data"][0]
            _si.volume_read(self._owned.pointer, byref(whole), memory, samples.nbytes, call.run)

    def spectrum(self, scalar: Tuple[int, int, int, int]) -> Dict[str, Any]:
        """`scalar`: array, component, time step and level."""
        owner = _Owned(_Spectrum, _si.spectrum_free)
        with _Call.begin(how=self.how.alone) as call:
            _si.volume_spectrum(self._owned.pointer, byref(_Scalar(*scalar)), call.run, owner.place)
        found = owner.pointer.contents
        quantities: Dict[str, Any] = {"isovalues": _view(owner, found.isovalues, "float64", found.count).copy()}
        for name in _QUANTITIES:
            address = getattr(found, name)
            dtype = "float64" if name in ("area", "volume") else "uint64"
            quantities[name] = None if address is None else _view(owner, address, dtype, found.count).copy()
        return quantities

    def range(self, scalar: Tuple[int, int, int, int]) -> Tuple[float, float]:
        """Of the finite samples; NaN if there are none."""
        found = (c_double * 2)()
        with _Call.begin(how=self.how.alone) as call:
            _si.volume_range(self._owned.pointer, byref(_Scalar(*scalar)), call.run, found)
        return found[0], found[1]

    def propose(self, scalar: Tuple[int, int, int, int]) -> float:
        """An isovalue to begin with; NaN if there are not two values."""
        found = c_double()
        with _Call.begin(how=self.how.alone) as call:
            _si.volume_propose(self._owned.pointer, byref(_Scalar(*scalar)), call.run, byref(found))
        return found.value

    def probe(
        self, scalar: Tuple[int, int, int, int], nearest: bool, points: numpy.ndarray, values: numpy.ndarray
    ) -> numpy.ndarray:
        """Fills `values` at points of the world, those within the grid alone: the truth of that is returned."""
        inside = numpy.zeros(len(points), numpy.uint8)
        places = numpy.ascontiguousarray(points, numpy.float64)
        with _Call.begin(how=self.how.alone) as call:
            _si.volume_probe(
                self._owned.pointer, byref(_Scalar(*scalar)), nearest, len(points), places.ctypes.data,
                values.ctypes.data, inside.ctypes.data, call.run,
            )  # fmt: skip
        return inside

    def slice(
        self, scalar: Tuple[int, int, int, int], origin: Sequence[float], normal: Sequence[float], most: float
    ) -> Optional[Tuple[Any, int, numpy.ndarray, numpy.ndarray]]:
        """Grid, level, tuples of values (y, x, components), and which are within the volume; None beside it."""
        owner = _Owned(_Slice, _si.slice_free)
        with _Call.begin(how=self.how.alone) as call:
            _si.volume_slice(
                self._owned.pointer, byref(_Scalar(*scalar)), _three_numbers(*origin), _three_numbers(*normal), most,
                call.run, owner.place,
            )  # fmt: skip
        if not owner.pointer:
            return None
        found = owner.pointer.contents
        _, kind, components, _ = self.arrays[scalar[0]]
        x, y, _ = found.grid.contents.dimensions
        return (
            _describe(found.grid.contents), found.level, _view(owner, found.values, kind, y, x, components),
            _view(owner, found.inside, "uint8", y, x),
        )  # fmt: skip

    def estimate(self, **request: Any) -> float:
        triangles = c_double()
        with _Call.begin(how=self.how) as call:
            _si.volume_estimate(self._owned.pointer, _request(**request), call.run, byref(triangles))
        return triangles.value

    def write_surface(self, path: bytes, coding: Dict[str, Any], **request: Any) -> None:
        """`coding`: members of si_coding."""
        with _Call.begin(how=self.how) as call:
            settings = byref(_make_coding(**coding))
            _si.volume_write_surface(self._owned.pointer, _request(**request), path, settings, call.run)

    def active_blocks(self, **request: Any) -> numpy.ndarray:
        """The vertices of active blocks: number, axis (z, y, x), ends [low, high)."""
        owner = _Owned(_Boxes, _si.boxes_free)
        with _Call.begin(caller=2) as call:
            _si.volume_find_blocks(self._owned.pointer, _request(**request), call.run, owner.place)
        boxes = _view(owner, owner.pointer.contents.boxes, "int64", owner.pointer.contents.count, 3, 2)
        return boxes[:, ::-1].copy()

    def isosurface(self, threads: int, normals: bool, **request: Any) -> Dict[str, Any]:
        return view_surface(self.extract(threads, normals=normals, **request), normals)

    def extract(self, threads: int, how: Optional[How] = None, **request: Any) -> _Owned:
        """The structure of the library (`view_surface`, `view_cells`)."""
        owner = _Owned(_Surface, _si.surface_free)
        with _Call.begin(threads, caller=3, how=how or self.how) as call:
            _si.volume_extract(self._owned.pointer, _request(**request), call.run, owner.place)
        return owner


def _request(
    isovalues: Sequence[float],
    region: Optional[Sequence[float]] = None,
    attributes: Sequence[int] = (),
    island_point: Optional[Sequence[float]] = None,
    half_spaces: Sequence[float] = (),
    **others: Any,
) -> Any:
    """A reference to a si_surface_request with such other members."""
    return byref(
        _make_request(
            isovalue_count=len(isovalues),
            isovalues=(c_double * len(isovalues))(*isovalues),
            region=None if region is None else (c_double * 6)(*region),
            attribute_count=len(attributes),
            attributes=(c_size_t * len(attributes))(*attributes),
            island_point=None if island_point is None else _three_numbers(*island_point),
            half_space_count=len(half_spaces) // 4,
            half_spaces=(c_double * len(half_spaces))(*half_spaces),
            **others,
        )
    )


class Piece:
    """si_piece: `grid` has members of si_grid; an array name, type, components and its memory. What is not here is NULL."""

    def __init__(
        self,
        grid: Dict[str, Any],
        lines: Optional[Sequence[Sequence[float]]],
        arrays: Sequence[Tuple[str, str, int, numpy.ndarray]],
        hidden: Tuple[Optional[numpy.ndarray], Optional[numpy.ndarray]],
        block: Sequence[int],
        identity: int,
        **boxes: Optional[Sequence[int]],
    ) -> None:
        self._kept = arrays, hidden
        whole = _fill_grid(_make_grid(**grid), lines)
        kinds = [_Array(encode(name), VALUE_TYPES.index(kind), size, b"") for name, kind, size, _ in arrays]
        addresses = [memory.__array_interface__["data"][0] for *_, memory in arrays]
        cells, vertices = (None if one is None else one.__array_interface__["data"][0] for one in hidden)
        self.structure = _make_piece(
            grid=ctypes.pointer(whole),
            array_count=len(arrays),
            arrays=(_Array * len(arrays))(*kinds),
            samples=(c_void_p * len(arrays))(*addresses),
            hidden_cells=cells,
            hidden_vertices=vertices,
            block=_Path(len(block), (c_int64 * len(block))(*block)),
            identity=identity,
            **{name: None if box is None else (c_int64 * 6)(*box) for name, box in boxes.items()},
        )


class Images:
    """si_images."""

    def __init__(self) -> None:
        self._owned = _Owned(None, _si.images_free)
        _si.images_create(self._owned.place)

    def extract(self, pieces: Sequence[Piece], how: How, **request: Any) -> _Owned:
        """Of this rank's pieces."""
        owner = _Owned(_Surface, _si.surface_free)
        given = (POINTER(_Piece) * len(pieces))(*(ctypes.pointer(piece.structure) for piece in pieces))
        with _Call.begin(how=how) as call:
            _si.images_extract(self._owned.pointer, len(pieces), given, _request(**request), call.run, owner.place)
        return owner


class SurfaceFile:
    """si_surface_file."""

    def __init__(self, path: bytes) -> None:
        self._owned = _Owned(None, _si.surface_file_close)
        with _Call.begin() as call:
            _si.surface_file_open(path, call.run, self._owned.place)
        info = _si.surface_file_describe(self._owned.pointer).contents
        self.isovalues: List[float] = info.isovalues[: info.isovalue_count]
        self.array: str = _text(info.array)
        self.source: str = _text(info.source)
        self.time: Optional[float] = None if math.isnan(info.time) else info.time
        self.length_unit: str = _text(info.length_unit)
        self.attributes: List[str] = [_text(name) for name in info.attributes[: info.attribute_count]]
        self.has_preview: bool = info.has_preview != 0
        self.missing: str = _text(info.missing)

    def read(self, isovalues: Sequence[int], preview: bool, normals: bool, threads: int) -> Dict[str, Any]:
        numbers = (c_size_t * len(isovalues))(*isovalues)
        owner = _Owned(_Surface, _si.surface_free)
        with _Call.begin(threads) as call:
            _si.surface_file_read(
                self._owned.pointer, len(numbers), numbers, preview, normals, call.run, owner.place
            )
        return view_surface(owner, normals)

    def read_piece(self, how: How, region: Optional[Sequence[float]], **reading: Any) -> Any:
        """`reading`: other members of si_surface_reading. The structure is that of the library (`view_surface`)."""
        owner = _Owned(_Surface, _si.surface_free)
        bounds = None if region is None else (c_double * 6)(*region)
        with _Call.begin(how=how.alone) as call:
            _si.surface_file_read_piece(
                self._owned.pointer, byref(_make_reading(region=bounds, **reading)), call.run, owner.place
            )
        return owner


def _read_slice(source: Any, reading: Any, kind: str, components: int) -> int:
    """Fills what a reader is asked for."""
    key = tuple(slice(low, high, 1) for low, high in zip(reading.low[::-1], reading.high[::-1]))
    samples = numpy.asarray(source[key], kind)
    shape = tuple(part.stop - part.start for part in key)
    # Of one component the last axis may be there or not.
    if samples.shape != (*shape, components) and (components > 1 or samples.shape != shape):
        raise ValueError("a slice of the array has not the shape that was asked for")
    memory = (ctypes.c_char * reading.bytes).from_address(reading.samples)
    numpy.frombuffer(memory, kind).reshape(samples.shape)[...] = samples
    return 1


class VolumeWriting:
    """A blocked volume to be written."""

    def __init__(self, path: bytes, lines: Optional[Sequence[Sequence[float]]], settings: Dict[str, Any], **grid: Any):
        """`grid`: members of si_grid; `settings`: of si_settings, and threads."""
        self._path = path
        self.how = _ALONE
        self._grid = _fill_grid(_make_grid(**grid), lines)
        self._threads = settings.pop("threads")
        self._settings = _make_settings(**settings)

    def write_arrays(
        self,
        steps: Sequence[Sequence[Tuple[str, Any, str, int, str]]],
        times: Sequence[Optional[float]],
        chunk: Optional[Sequence[int]],
    ) -> None:
        """`steps`: of each array name, source, type, components and unit."""
        self._grid.chunk = tuple(chunk or ())
        arrays = [
            _Array(encode(name), VALUE_TYPES.index(kind), components, encode(unit))
            for name, _, kind, components, unit in steps[0]
        ]

        def read(pointer: Any) -> int:
            reading = pointer.contents
            _, source, kind, components, _ = steps[reading.step][reading.array]
            return _read_slice(source, reading, kind, components)

        with _Call.begin(self._threads, caller=3, how=self.how) as call:
            _si.write_volume(
                self._path,
                byref(self._grid),
                len(arrays),
                (_Array * len(arrays))(*arrays),
                len(times),
                self._list_times(times),
                _Reader(call.listen(read, 0)),
                None,
                byref(self._settings),
                call.run,
            )

    def write_file(self, file: VolumeFile, times: Sequence[Optional[float]]) -> None:
        """All time steps of a file."""
        with _Call.begin(self._threads, caller=3, how=self.how) as call:
            _si.volume_write(
                file._owned.pointer,
                self._path,
                byref(self._grid),
                self._list_times(times),
                byref(self._settings),
                call.run,
            )

    @staticmethod
    def _list_times(times: Sequence[Optional[float]]) -> Any:
        return (c_double * len(times))(*(math.nan if time is None else time for time in times))
