# Core and Formats, as the modules of this package use them. Vertices and sizes are x, y, z.
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy

MAGNITUDE: int
VALUE_TYPES: List[str]

def find_kind(name: bytes) -> str: ...
def open_volume(path: bytes, axes: str, folder: bytes, threads: int) -> VolumeFile: ...
def open_surface(path: bytes) -> SurfaceFile: ...
def list_datasets(path: bytes) -> List[str]: ...
def read_attributes(path: bytes, axes: str) -> str: ...
def write_index(path: bytes, axes: str, folder: bytes, memory: int, threads: int) -> str: ...

class VolumeFile:
    @property
    def path(self) -> bytes: ...
    @property
    def arrays(self) -> List[Tuple[str, str, int, str]]: ...
    @property
    def times(self) -> List[Optional[float]]: ...
    @property
    def levels(self) -> int: ...
    @property
    def left_out(self) -> str: ...
    def describe(self, level: int) -> Tuple[Any, ...]: ...
    def read(
        self,
        samples: numpy.ndarray,
        array: int,
        components: Sequence[int],
        step: int,
        level: int,
        low: Sequence[int],
        high: Sequence[int],
        stride: Sequence[int],
        threads: int,
    ) -> None: ...
    def spectrum(self, array: int, component: int, step: int, level: int) -> Dict[str, Any]: ...
    def active_blocks(
        self,
        array: int,
        component: int,
        step: int,
        level: int,
        isovalues: Sequence[float],
        bounds: Optional[Sequence[float]],
    ) -> numpy.ndarray: ...
    def isosurface(
        self,
        array: int,
        component: int,
        step: int,
        level: int,
        isovalues: Sequence[float],
        bounds: Optional[Sequence[float]],
        normals: bool,
        attributes: Sequence[int],
        precision: int,
        closing: Tuple[bool, bool, bool],
        islands: Optional[Tuple[int, float, int]],
        threads: int,
    ) -> Dict[str, Any]: ...

class SurfaceFile:
    @property
    def path(self) -> str: ...
    @property
    def missing(self) -> str: ...
    @property
    def attributes(self) -> List[str]: ...
    @property
    def isovalues(self) -> List[float]: ...
    @property
    def array(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def time(self) -> Optional[float]: ...
    @property
    def length_unit(self) -> str: ...
    @property
    def has_preview(self) -> bool: ...
    def read(self, isovalues: Sequence[int], preview: bool, normals: bool, threads: int) -> Dict[str, Any]: ...

class VolumeWriting:
    def __init__(
        self,
        path: bytes,
        dimensions: Sequence[int],
        spacing: Sequence[float],
        origin: Sequence[float],
        direction: Sequence[float],
        lines: Optional[Sequence[Sequence[float]]],
        length_unit: str,
    ) -> None: ...
    def set(
        self,
        block_size: int,
        stores: int,
        replicas: int,
        codec: str,
        codec_level: int,
        time: Optional[float],
        append: bool,
        memory: int,
        threads: int,
    ) -> None: ...
    def write_arrays(
        self,
        steps: Sequence[Sequence[Tuple[str, Any, str, int, str]]],
        times: Sequence[Optional[float]],
        chunk: Optional[Sequence[int]],
    ) -> None: ...
    def write_file(self, file: VolumeFile, times: Sequence[Optional[float]]) -> None: ...
