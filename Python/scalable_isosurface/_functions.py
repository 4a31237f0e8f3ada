# SPDX-License-Identifier: BSD-3-Clause
"""The functions and structures of the library of C, as ctypes knows them. scalable_isosurface.h says what they are."""

from __future__ import annotations

import ctypes
import errno
import os
import struct
from ctypes import c_char_p, c_double, c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p, POINTER
from typing import Any, Callable, Dict, List, Tuple

from . import __version__, _LIBRARY

#: As a component: that of several.
MAGNITUDE = -1


def _structure(name: str, *fields: Tuple[str, Any]) -> Any:
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _sized(name: str, *fields: Tuple[str, Any]) -> Tuple[Callable[..., Any], Any]:
    """A function that makes a structure which begins with its size, and the type of it."""
    sized = _structure(name, ("size", c_size_t), *fields)

    def make(**values: Any) -> Any:
        made = sized(ctypes.sizeof(sized), **values)
        for member, value in values.items():
            if isinstance(value, int) and value >> 31 and getattr(made, member) != value:  # ctypes leaves bits out
                raise ValueError(f"{member} is too large: {value}")
        return made

    return make, sized


_three_integers, _three_numbers = c_int64 * 3, c_double * 3
_Array = _structure("si_array", ("name", c_char_p), ("type", c_int32), ("components", c_int32), ("unit", c_char_p))
_Scalar = _structure(
    "si_scalar", ("array", c_size_t), ("component", c_int32), ("step", c_size_t), ("level", c_size_t)
)
_Values = _structure(
    "si_values", ("name", c_char_p), ("type", c_int32), ("components", c_int32), ("values", c_void_p)
)
_Progress = ctypes.CFUNCTYPE(ctypes.c_int, c_double)  # the context behind it is not needed
_Warn = ctypes.CFUNCTYPE(ctypes.c_int, c_char_p)
_make_run, _Run = _sized(
    "si_run",
    ("threads", c_int32), ("progress", _Progress), ("warn", _Warn), ("context", c_void_p), ("ranks", c_void_p),
)  # fmt: skip
_, _Texts = _sized("si_texts", ("count", c_size_t), ("texts", POINTER(c_char_p)))
_make_opening, _ = _sized(
    "si_opening",
    ("axes", c_char_p), ("index_folder", c_char_p), ("spacing", POINTER(c_double)), ("origin", POINTER(c_double)),
    ("length_unit", c_char_p), ("local_stores", c_int32), ("region", POINTER(c_double)), ("fetch_budget", c_uint64),
    ("fetching", c_void_p),
)  # fmt: skip
_, _VolumeInfo = _sized(
    "si_volume_info",
    ("path", c_char_p), ("array_count", c_size_t), ("arrays", POINTER(_Array)), ("step_count", c_size_t),
    ("times", POINTER(c_double)), ("level_count", c_size_t), ("left_out", c_char_p),
)  # fmt: skip
_make_grid, _Grid = _sized(
    "si_grid",
    ("dimensions", _three_integers), ("spacing", _three_numbers), ("origin", _three_numbers),
    ("direction", c_double * 9), ("lines", POINTER(c_double) * 3), ("length_unit", c_char_p),
    ("chunk", _three_integers), ("first", _three_integers), ("zero", _three_numbers),
)  # fmt: skip
_make_box, _ = _sized(
    "si_box",
    ("array", c_size_t), ("step", c_size_t), ("level", c_size_t), ("low", _three_integers),
    ("high", _three_integers), ("stride", _three_integers), ("component_count", c_size_t),
    ("components", POINTER(c_int32)),
)  # fmt: skip
_QUANTITIES = ("triangles", "cells", "blocks", "bytes", "area", "volume")
_, _Spectrum = _sized(
    "si_spectrum", ("count", c_size_t), ("isovalues", c_void_p), *((name, c_void_p) for name in _QUANTITIES)
)
_make_request, _ = _sized(
    "si_surface_request",
    ("scalar", _Scalar), ("isovalue_count", c_size_t), ("isovalues", POINTER(c_double)),
    ("region", POINTER(c_double)), ("attribute_count", c_size_t), ("attributes", POINTER(c_size_t)),
    ("normals", c_int32), ("global_ids", c_int32), ("points", c_int32), ("closed", c_int32),
    ("drop_degenerate_triangles", c_int32), ("island_size", c_int32), ("minimum_island", c_double),
    ("maximum_islands", c_uint64), ("maximum_triangles", c_uint64), ("maximum_seconds", c_double),
    ("vtk_version", c_int32), ("polygons", c_int32), ("skip_not_a_number", c_int32), ("island_ids", c_int32),
    ("island_point", POINTER(c_double)), ("half_space_count", c_size_t), ("half_spaces", POINTER(c_double)),
)  # fmt: skip
_, _Boxes = _sized("si_boxes", ("count", c_size_t), ("boxes", c_void_p))
_Path = _structure("si_path", ("count", c_size_t), ("numbers", POINTER(c_int64)))
_, _Surface = _sized(
    "si_surface",
    ("point_count", c_size_t), ("triangle_count", c_size_t), ("point_type", c_int32), ("corner_type", c_int32),
    ("points", c_void_p), ("corners", c_void_p), ("normals", c_void_p), ("global_ids", c_void_p),
    ("part_count", c_size_t), ("isovalues", c_void_p), ("first_points", c_void_p), ("first_triangles", c_void_p),
    ("attribute_count", c_size_t), ("attributes", POINTER(_Values)), ("level", c_size_t), ("offsets", c_void_p),
    ("island_ids", c_void_p), ("islands", c_void_p), ("block_count", c_size_t), ("blocks", POINTER(_Path)),
    ("block_ids", c_void_p),
)  # fmt: skip
_make_piece, _Piece = _sized(
    "si_piece",
    ("grid", POINTER(_Grid)), ("whole", POINTER(c_int64)), ("own", POINTER(c_int64)), ("array_count", c_size_t),
    ("arrays", POINTER(_Array)), ("samples", POINTER(c_void_p)), ("hidden_cells", c_void_p),
    ("hidden_vertices", c_void_p), ("block", _Path), ("identity", c_uint64),
)  # fmt: skip
_, _SurfaceInfo = _sized(
    "si_surface_file_info",
    ("isovalue_count", c_size_t), ("isovalues", POINTER(c_double)), ("array", c_char_p), ("source", c_char_p),
    ("time", c_double), ("length_unit", c_char_p), ("attribute_count", c_size_t), ("attributes", POINTER(c_char_p)),
    ("has_preview", c_int32), ("missing", c_char_p),
)  # fmt: skip
_make_settings, _ = _sized(
    "si_settings",
    ("block_size", c_int32), ("codec_level", c_int32), ("codec", c_char_p), ("stores", c_uint32),
    ("replicas", c_uint32), ("append", c_int32), ("memory", c_uint64), ("distribution", c_int32),
    ("random_seed", c_uint64),
)  # fmt: skip
_, _Reading = _sized(
    "si_reading",
    ("context", c_void_p), ("step", c_size_t), ("array", c_size_t), ("low", _three_integers),
    ("high", _three_integers), ("samples", c_void_p), ("bytes", c_size_t),
)  # fmt: skip
_make_reading, _ = _sized(
    "si_surface_reading",
    ("preview", c_int32), ("normals", c_int32), ("global_ids", c_int32), ("vtk_version", c_int32), ("piece", c_int32),
    ("piece_count", c_int32), ("region", POINTER(c_double)),
)  # fmt: skip
_make_coding, _ = _sized(
    "si_coding",
    ("mode", c_int32), ("preview_level", c_int32), ("maximum_error", c_double), ("array_error", c_double),
    ("normal_error", c_double), ("profile", c_int32), ("memory", c_uint64),
    ("quantization_bits", c_int32),
)  # fmt: skip
_, _Slice = _sized(
    "si_slice", ("grid", POINTER(_Grid)), ("level", c_size_t), ("values", c_void_p), ("inside", c_void_p)
)
_make_growing_state, _ = _sized(
    "si_growing_state",
    ("stage", c_int32), ("done", c_double), ("seconds_left", c_double), ("share", c_double), ("text", c_char_p),
)  # fmt: skip
_AllGather = ctypes.CFUNCTYPE(ctypes.c_int, c_void_p, c_void_p, c_void_p, c_size_t)
_Exchange = ctypes.CFUNCTYPE(
    ctypes.c_int, c_void_p, POINTER(c_void_p), POINTER(c_size_t), POINTER(c_void_p), POINTER(c_size_t)
)
_make_ranks, _ = _sized(
    "si_ranks",
    ("rank", c_int32), ("count", c_int32), ("context", c_void_p), ("all_gather", _AllGather), ("exchange", _Exchange),
)  # fmt: skip
_Reader = ctypes.CFUNCTYPE(ctypes.c_int, POINTER(_Reading))

# What functions take: p a pointer, s a text, z a size, i an int, d a double, u an unsigned integer of 64 bits, r a
# reader.
_KINDS: Dict[str, Any] = {"p": c_void_p, "s": c_char_p, "z": c_size_t, "i": ctypes.c_int, "d": c_double, "u": c_uint64, "r": _Reader}
_FUNCTIONS = {
    "find_kind": "sp",
    "list_datasets": "spp",
    "read_attributes": "sspp",
    "volume_open": "sppp",
    "volume_read": "pppzp",
    "volume_range": "pppp",
    "volume_probe": "ppizpppp",
    "volume_slice": "ppppdpp",
    "volume_spectrum": "pppp",
    "volume_propose": "pppp",
    "volume_find_blocks": "pppp",
    "volume_extract": "pppp",
    "images_create": "p",
    "images_extract": "pzpppp",
    "surface_file_open": "spp",
    "volume_estimate": "pppp",
    "volume_write_surface": "ppspp",
    "surface_file_read": "pzpiipp",
    "surface_file_read_piece": "pppp",
    "write_volume": "spzpzprppp",
    "volume_write": "pspppp",
    "write_index": "spup",
    "growing_begin": "spzdupp",
    "growing_poll": "pdpp",
    "growing_take": "ppp",
}
# What gives a structure, or NULL; what takes one back.
_GIVERS: Dict[str, Tuple[str, Any]] = {
    "volume_describe": ("p", POINTER(_VolumeInfo)),
    "volume_grid": ("pz", POINTER(_Grid)),
    "surface_file_describe": ("p", POINTER(_SurfaceInfo)),
    "version": ("", c_int32),
    "error": ("", c_char_p),
    "fetching_new": ("", c_void_p),
    "type_name": ("i", c_char_p),
    **{
        name: ("p", None)
        for name in (
            "texts_free", "volume_close", "slice_free", "spectrum_free", "boxes_free", "surface_free", "images_free",
            "surface_file_close", "growing_stop", "growing_free", "fetching_free",
        )
    },
}  # fmt: skip


def encode(text: str) -> bytes:
    if "\0" in text:
        raise ValueError(f"a text has no character of code 0: {text!r}")
    return text.encode()


def _text(given: bytes) -> str:
    """Of a name that is not UTF-8, the other bytes are told by their numbers."""
    return given.decode("utf-8", "backslashreplace")


class Stopped(OSError):
    """A callback has stopped a call."""


def _check(status: int, *_: Any) -> int:
    """Raises what Python calls an error of the library."""
    if status == 0:
        return 0
    message = _text(_error())
    if status == 1:
        raise ValueError(message)
    if status in (2, 4):
        raise OSError(errno.ENOENT if status == 2 else errno.ENOSPC, message)
    raise {7: MemoryError, 8: Stopped, 100: RuntimeError}.get(status, OSError)(message)


def _load() -> Any:
    """The functions of the library, without si_. An ImportError says in one line what is wrong."""
    folder = os.path.dirname(os.path.abspath(__file__))
    beside = os.path.join(folder, os.path.basename(_LIBRARY))
    path = beside if os.path.exists(beside) else os.path.normpath(os.path.join(folder, _LIBRARY))
    try:
        _check_file(path)
        library = ctypes.CDLL(path)
        version = library.si_version()
        found = f"{version // 10000}.{version // 100 % 100}.{version % 100}"
        if found != __version__:
            raise OSError(f"the library is of version {found}, and the Python files are of {__version__}")
        return _find_functions(library)
    except (OSError, AttributeError) as error:
        import platform

        reason = getattr(error, "strerror", None) or str(error).replace(f"{path}: ", "")
        if isinstance(error, OSError) and platform.libc_ver()[0] != "glibc":
            reason += "; it needs glibc, and the C library of this Python is another"
        raise ImportError(
            f"{path} cannot be loaded: {reason}; install scalable_isosurface for this Python again", path=path
        ) from None


def _check_file(path: str) -> None:
    """Raises an OSError unless all of the library is there, for this processor. The loader maps what the header tells:
    of a part of a library the process would die."""
    with open(path, "rb") as file:
        header = file.read(64)
        if len(header) < 64 or header[:4] != b"\x7fELF":
            raise OSError("it is damaged, or no library")
        machine, sections, entry_size, count = struct.unpack_from("=H20xQ10xHH", header, 18)
        file.seek(min(sections + entry_size * max(count - 1, 0), 1 << 62))
        last = file.read(entry_size)  # header of a section: what a library ends with
    built_for = {62: "x86_64", 183: "aarch64"}.get(machine, os.uname().machine)
    if built_for != os.uname().machine:
        raise OSError(f"it is for {built_for}, and this processor is {os.uname().machine}")
    if len(last) < entry_size or not any(last):
        raise OSError("it is damaged: its end is missing")


def _find_functions(library: ctypes.CDLL) -> Any:
    functions = type("Library", (), {})()
    for name, (kinds, result) in {**{name: (kinds, c_int32) for name, kinds in _FUNCTIONS.items()}, **_GIVERS}.items():
        function: Any = library[f"si_{name}"]
        function.argtypes = [_KINDS[kind] for kind in kinds]
        function.restype = result
        if name in _FUNCTIONS:
            function.errcheck = _check
        setattr(functions, name, function)
    return functions


_si = _load()
_error = _si.error

#: The names of all types of samples, by their numbers.
VALUE_TYPES: List[str] = []
while _si.type_name(len(VALUE_TYPES)):
    VALUE_TYPES.append(_si.type_name(len(VALUE_TYPES)).decode())
