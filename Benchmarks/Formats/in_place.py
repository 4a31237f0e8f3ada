#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How soon a surface of chunked samples is there: indexed in place, copied, or read as a whole.

    in_place.py BLOCKVOLUME [FOLDER] [--side N] [--isovalues V V] [--cold]

Writes a cube of int16, waves with noise, as HDF5 (shuffle, gzip 1) and as Zarr 2 (blosc lz4), chunks
of 64, into the folder, indexes both in place and copies them, and tells the bytes of each. Then, each
in a process of its own: seconds from opening the file to the surface with normals, those of the
processor, the seconds of the next isovalue, and the peak of memory, of a copied volume, volumes in
place, and of h5py and zarr with vtkFlyingEdges3D, which read all. --cold empties the system's cache of
files before each of them (as root). Needs python3-h5py, python3-zarr (version 2) and the package
scalable_isosurface on PYTHONPATH.
"""
import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time


def write_samples(folder, side):
    import h5py
    import numcodecs
    import numpy
    import zarr

    chunks = (64, 64, 64)
    random = numpy.random.default_rng(0)
    y, x = numpy.meshgrid(numpy.arange(side), numpy.arange(side), indexing="ij")
    array = zarr.open(os.path.join(folder, "w.zarr"), mode="w", shape=(side,) * 3, chunks=chunks, dtype="i2",
                      compressor=numcodecs.Blosc("lz4", 1, 1))
    with h5py.File(os.path.join(folder, "w.h5"), "w") as file:
        dataset = file.create_dataset("d", shape=(side,) * 3, dtype="i2", chunks=chunks, compression="gzip",
                                      compression_opts=1, shuffle=True)
        for first in range(0, side, 64):
            z = numpy.arange(first, min(side, first + 64))[:, None, None]
            waves = 2000 * numpy.sin(0.02 * x + 0.01 * z) * numpy.cos(0.023 * y) * numpy.sin(0.017 * z + 1)
            samples = (waves + random.integers(-8, 9, waves.shape)).astype("i2")
            dataset[first:first + len(z)] = array[first:first + len(z)] = samples


def count_bytes(path):
    return sum(os.path.getsize(os.path.join(folder, name))
               for folder, _, names in os.walk(path) for name in names)


def make_source(kind, folder):
    """The source of a surface, by reading all that is read before the isovalue is known."""
    if kind in ("h5", "zarr"):
        import h5py
        import zarr
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonDataModel import vtkImageData
        from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

        samples = h5py.File(os.path.join(folder, "w.h5"))["d"][:] if kind == "h5" else \
            zarr.open(os.path.join(folder, "w.zarr"), mode="r")[:]
        image = vtkImageData()
        image.SetDimensions(*samples.shape[::-1])
        image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel()))
        contour = vtkFlyingEdges3D()
        contour.SetInputData(image)
        return contour, samples
    from scalable_isosurface import vtkBlockedVolumeReader, vtkStabbingContour

    reader = vtkBlockedVolumeReader()
    reader.SetFileName(os.path.join(folder, kind))
    contour = vtkStabbingContour()
    contour.SetInputConnection(reader.GetOutputPort())
    return contour, reader


def find_peak_mebibytes():
    """Of this program alone: what getrusage() tells may be of the one that started it."""
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024


def measure(kind, folder, isovalue):
    clock, processor = time.perf_counter(), time.process_time()
    contour, _kept = make_source(kind, folder)
    contour.SetValue(0, isovalue)
    contour.Update()
    first, used = time.perf_counter() - clock, time.process_time() - processor
    triangles = contour.GetOutput().GetNumberOfPolys()
    clock = time.perf_counter()
    contour.SetValue(0, isovalue + 1)
    contour.Update()
    print(f"{kind:22} {isovalue:8g} {triangles:12,} triangles  first {first:6.2f} s (processor {used:6.2f})  "
          f"next {time.perf_counter() - clock:6.2f} s  "
          f"peak {find_peak_mebibytes():6.0f} MiB", flush=True)


def index_and_copy(tool, folder):
    for source in ("w.zarr", "w.h5:/d"):
        for name, arguments in (("in place", ["--in-place"]), ("copied", [])):
            file = f"{source.split(':')[0]}-{name.replace(' ', '-')}.bvol"
            path, stores = os.path.join(folder, file), os.path.join(folder, f".{file}.stores")
            clock = time.perf_counter()
            subprocess.run([tool, os.path.join(folder, source), path, "--quiet", *arguments], check=True)
            print(f"{source} {name}: {time.perf_counter() - clock:.1f} s, {count_bytes(stores):,} bytes")


def main():
    if sys.argv[1:2] == ["--measure"]:
        measure(sys.argv[2], sys.argv[3], float(sys.argv[4]))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("blockvolume")
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--side", type=int, default=816)
    parser.add_argument("--isovalues", type=float, nargs="+", default=[1500.0, 0.0])
    parser.add_argument("--cold", action="store_true")
    arguments = parser.parse_args()
    folder = tempfile.mkdtemp(dir=arguments.folder)
    try:
        write_samples(folder, arguments.side)
        index_and_copy(arguments.blockvolume, folder)
        for isovalue in arguments.isovalues:
            for kind in ("w.zarr-copied.bvol", "w.zarr-in-place.bvol", "w.h5-in-place.bvol", "zarr", "h5"):
                if arguments.cold:
                    os.sync()
                    with open("/proc/sys/vm/drop_caches", "w") as file:
                        file.write("3")
                subprocess.run([sys.executable, __file__, "--measure", kind, folder, str(isovalue)], check=True)
    finally:
        shutil.rmtree(folder)


main()
