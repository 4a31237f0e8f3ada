# SPDX-License-Identifier: BSD-3-Clause
"""Files for pyvista.read(), which finds the reader by the entry points of a wheel."""

from __future__ import annotations

import os
import warnings
from typing import Any

from ._edge_index import EdgeIndex
from ._opening import open
from ._volume import Volume


def read(path: str, **kwargs: Any) -> Any:
    """A volume as pyvista.ImageData or RectilinearGrid, with all arrays of a time step; a surface in a file as PolyData.

    Arguments are those of `open`. Samples that take more than a third of the machine's memory are those of a coarser
    level, if there is one, which a warning tells."""
    opened: Any = open(path, **kwargs)
    if isinstance(opened, EdgeIndex):
        return opened.isosurface().to_pyvista()
    most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 3
    level = 0
    while level + 1 < opened.levels and sum(opened.array(name).level(level).nbytes for name in opened.arrays) > most:
        level += 1
    if level:
        warnings.warn(f"{path}: its samples take too much memory, so level {level} is read", stacklevel=2)
    return _read_grid(opened.level(level))


def _read_grid(volume: Volume) -> Any:
    import pyvista

    if volume.coordinates is not None:
        grid = pyvista.RectilinearGrid(*volume.coordinates)
    else:
        grid = pyvista.ImageData(dimensions=volume.shape[2::-1], spacing=volume.spacing, origin=volume.origin)
        grid.direction_matrix = volume.direction
    for name in volume.arrays:
        samples = volume.array(name)[...]
        grid.point_data[name] = samples.reshape(-1, *samples.shape[3:])
    if volume.length_unit:
        grid.field_data["PhysicalSizeUnit"] = [volume.length_unit]
    return grid
