# SPDX-License-Identifier: BSD-3-Clause
"""Files that are opened, and files that are indexed."""

from __future__ import annotations

import os
import warnings
from typing import Optional, Sequence, Union

from . import _library
from ._arguments import take_path, take_text, take_threads
from ._edge_index import EdgeIndex
from ._volume import check_place, check_region, name_file, open_volume, Volume

#: Bytes that indexing and writing may take, as ParaView's writer.
MEMORY = 1 << 30


def open(
    path: Union[str, os.PathLike],
    step: int = 0,
    *,
    axes: str = "",
    index_folder: Union[str, os.PathLike] = "",
    threads: Optional[int] = None,
    region: Optional[Sequence[float]] = None,
    spacing: Optional[Sequence[float]] = None,
    origin: Optional[Sequence[float]] = None,
    length_unit: Optional[str] = None,
) -> Volume:
    """Opens a volume. Samples are read when the volume is indexed.

    Parameters
    ----------
    path : str or path
        A blocked volume (.bvol), or a file or folder of another format: MetaImage,
        NRRD, NIfTI, MRC, TIFF, DICOM, HDF5, NetCDF, Zarr, N5, raw samples, or an array (z, y, x) of
        NumPy (.npy). What is meant within a file (`Volume.datasets`) follows a colon:
        ``"run.h5:/entry/data"``, ``"scan.raw:512x512x300,uint16"``.
    step : int
        The number of the time step; negative from the last one on.
    axes : str
        What the axes of a dataset are, the slowest first, of the letters x y z t c. Empty: as it says.
    index_folder : str or path
        Where the index of a file of another format may be (`index`). Empty: beside it.
    threads : int, optional
        Threads for each read and extraction; as many as there are cores if it is not given. One is best where
        the caller has many threads itself, as Dask has.
    region : sequence of six float, optional
        x0, x1, y0, y1, z0, z1 in the world: of a file of another format, only the part that has this box, which is
        a volume of whole chunks with its place in the world.
    spacing, origin : sequence of three float, optional
        x, y, z of the distance of vertices, and of the first vertex, in place of the file's. `region` counts with them.
    length_unit : str, optional
        In place of the file's: ``"mm"``, ``"um"``, ``"nm"``. Empty: none.

    Returns
    -------
    Volume
        Of a file of another format, its index, if it has a current one. Without an index it has one level.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    OSError
        It cannot be read; the message names the file and the reason.
    IndexError
        There is no such time step.

    Warns
    -----
    UserWarning
        What of a file of another format is not read, or not used; if it has an index, `index` has told it.

    Examples
    --------
    >>> si.open("waves.nrrd")
    <Volume 'waves.nrrd', array 'ImageFile': (20, 30, 40) float32, level 0 of 1>
    >>> with si.open("waves.bvol") as volume:
    ...     round(float(volume[10, 15, 20]), 3)
    -0.009
    """
    name = take_path("path", path)
    if _library.find_kind(os.fsencode(name)) == "edge index":
        return EdgeIndex(name, threads)  # type: ignore[return-value] # as before there was open_surface
    place = check_place(spacing, origin, length_unit)
    folder = take_path("index_folder", index_folder)
    volume = open_volume(name, step, axes, folder, threads, check_region(region), place)
    tell_left_out(name, volume._opened.file.left_out)
    return volume


def tell_left_out(path: str, what: str) -> None:
    """To be called by the function that the user calls."""
    if what:
        warnings.warn(f"{path}: {what}", stacklevel=3)


def open_surface(path: Union[str, os.PathLike], *, threads: Optional[int] = None) -> EdgeIndex:
    """Opens a surface in an edge-index file (.eix), which is decoded when it is asked for.

    Parameters
    ----------
    path : str or path
        Of the file.
    threads : int, optional
        For decoding; as many as there are cores if it is not given.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    OSError
        It cannot be read, or is no edge-index file; the message names it.

    Examples
    --------
    >>> si.open_surface("waves.eix").isosurface()
    <Surface of 0.3: 9691 triangles, 5200 points>
    """
    return EdgeIndex(take_path("path", path), threads)


def index(
    path: Union[str, os.PathLike],
    *,
    axes: str = "",
    index_folder: Union[str, os.PathLike] = "",
    threads: Optional[int] = None,
    region: Optional[Sequence[float]] = None,
    fetch_budget: int = 0,
) -> Volume:
    """Indexes a file of another format where it lies, and opens it by the index.

    The index is a small blocked volume beside the file (``scan.nrrd.bvol``), the same that ParaView's reader
    makes: what isosurfaces need to find their blocks, and all coarser levels. Samples stay in the file; of a
    gzip stream, which can only be read in order, the index has them. If there is a current index, nothing is
    written. Cost: one pass over the file.

    Parameters
    ----------
    path, axes, index_folder, threads, region
        As for `open`. A few more threads read ahead and write. The index of a part is one of its own.
    fetch_budget : int
        Bytes that may be fetched from an address; 0: no limit.

    Raises
    ------
    OSError
        The file cannot be read, the index cannot be written, or the budget is spent. What is indexed is kept, so
        that a call with a larger budget goes on.

    Examples
    --------
    >>> si.index("waves.nrrd", index_folder="indices")
    <Volume 'waves.nrrd', array 'ImageFile': (20, 30, 40) float32, level 0 of 7>
    """
    name = take_path("path", path)
    folder = take_path("index_folder", index_folder)
    file = name_file(name)
    _library.find_kind(file)  # says so if there is no such file
    how = take_text("axes", axes), os.fsencode(folder), MEMORY, take_threads(threads)
    region = check_region(region)
    tell_left_out(name, _library.write_index(file, *how, region=region, fetch_budget=fetch_budget))
    return open_volume(name, 0, axes, folder, threads, region)
