# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces in edge-index files."""

from __future__ import annotations

import os
import warnings
from typing import Any, Optional, Tuple

from . import _library
from ._arguments import take_threads
from ._surface import Surface
from ._volume import list_isovalues


class EdgeIndex:
    """A surface in an edge-index file (.eix), decoded when it is asked for.

    `open_surface` makes it.

    Attributes
    ----------
    path : str
        Of the file.
    isovalues : tuple of float
        Of the surfaces in the file.
    name : str
        Of the array that was contoured.
    source : str
        Where the samples came from, in the words of who wrote the file.
    time : float or None
        Of the time step.
    length_unit : str
        Of the points: "mm", "um", ...; "" if it is not known.
    attributes : tuple of str
        Names of the arrays on the points.
    has_preview : bool
        Whether the file has a coarse surface, too.

    Examples
    --------
    >>> file = si.open_surface("waves.eix")
    >>> file
    <EdgeIndex 'waves.eix' of 'waves': isovalues 0.3>
    >>> file.isosurface()
    <Surface of 0.3: 9691 triangles, 5200 points>
    """

    def __init__(self, path: str, threads: Optional[int] = None) -> None:
        self._threads = threads
        self._file = _library.open_surface(os.fsencode(path))
        if self._file.missing:
            warnings.warn(self._file.missing, stacklevel=3)
        self.path: str = path
        self.isovalues: Tuple[float, ...] = tuple(self._file.isovalues)
        self.name: str = self._file.array
        self.source: str = self._file.source
        self.time: Optional[float] = self._file.time
        self.length_unit: str = self._file.length_unit
        self.attributes: Tuple[str, ...] = tuple(self._file.attributes)
        self.has_preview: bool = self._file.has_preview

    def __repr__(self) -> str:
        isovalues = ", ".join(f"{isovalue:.6g}" for isovalue in self.isovalues)
        return f"<EdgeIndex {self.path!r} of {self.name!r}: isovalues {isovalues}>"

    def __reduce__(self) -> Any:
        return EdgeIndex, (os.path.abspath(self.path), self._threads)

    def isosurface(self, isovalue: Any = None, *, preview: bool = False, normals: bool = True) -> Surface:
        """Decodes the surface.

        Parameters
        ----------
        isovalue : float or sequence of float, optional
            Some of `isovalues`, in the order that the surface is to have; all if it is not given.
        preview : bool
            The coarse surface, if the file has one (`has_preview`), without attributes.
        normals : bool
            Those in the file; if there are none, the mean of those of the triangles around a point.

        Raises
        ------
        ValueError
            The file has no surface of the isovalue, or no preview; or the sequence is empty.
        OSError
            The file cannot be read, or is damaged; the message names it.
        """
        numbers = []
        for wanted in [] if isovalue is None else list_isovalues(isovalue):
            if wanted not in self.isovalues:
                raise ValueError(f"{self.path}: has no surface of {wanted:g}, but of {self.isovalues}")
            numbers.append(self.isovalues.index(wanted))
        if preview and not self.has_preview:
            raise ValueError(f"{self.path}: has no preview")
        return Surface(**self._file.read(numbers, bool(preview), bool(normals), take_threads(self._threads)))
