#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plain Python beside its peers, in one run: boxes of samples beside Zarr with the same codec, surfaces beside
vtkStabbingContour. Files are in the system's cache. Peers take turns; each row is the minimum of the repetitions,
which other programs disturb least. Usage:

    boxes_and_surfaces.py [VOLUME] [--isovalue 1200] [--box 256] [--repeats 9] [--folder /tmp]

VOLUME is any file that scalable_isosurface opens, copied first; without one, 320 x 320 x 320 samples of uint16 with
noise are made.
"""
import argparse
import os
import shutil
import tempfile
import time

import numpy
import numcodecs
import zarr

import scalable_isosurface as si
from scalable_isosurface import vtkBlockedVolumeReader, vtkStabbingContour


def make_samples(size):
    """Waves of 1000 with noise of 10, of which the low bits do not compress."""
    z, y, x = (0.05 * axis for axis in numpy.ogrid[:size, :size, :size])
    waves = 1000 + 500 * (numpy.sin(x) * numpy.cos(y) + numpy.sin(z) * numpy.cos(x))
    return (waves + numpy.random.default_rng(1).normal(0, 10, waves.shape)).astype(numpy.uint16)


def measure(work):
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def count_bytes(path):
    """Of all files below a path, and of the file itself."""
    stores = os.path.join(os.path.dirname(path), f".{os.path.basename(path)}.stores")
    below = [os.path.join(folder, name) for top in (path, stores) for folder, _, names in os.walk(top)
             for name in names]
    return sum(map(os.path.getsize, below))


def choose_box(shape, size):
    """A box in the middle, whose corner is beside those of blocks and chunks."""
    low = [max(0, axis - size) // 2 + 5 for axis in shape]
    return tuple(slice(begin, begin + size) for begin in low)


def compare_boxes(samples, folder, codec, size, repeats):
    """Prints seconds for a box, and how many times as long Zarr takes."""
    path = os.path.join(folder, f"{codec}.bvol")
    si.create(samples, path, compression=codec, overwrite=True)
    single = {"lz4": numcodecs.LZ4(), "zstd": numcodecs.Zstd(1)}[codec]
    codecs = {"alone": single, "in Blosc": numcodecs.Blosc(codec, 1, numcodecs.Blosc.SHUFFLE)}
    peers = {}
    stored = count_bytes(path)
    sizes = {"cold block cache": stored, "warm block cache": stored}
    for chunk in (32, 64, 128):
        for name, compressor in codecs.items():
            target = os.path.join(folder, f"{codec}-{chunk}-{name}.zarr")
            peers[f"Zarr, chunks of {chunk}, {codec} {name}"] = zarr.open(
                target, "w", shape=samples.shape, chunks=(chunk,) * 3, dtype=samples.dtype, compressor=compressor
            )
            zarr.open(target, "r+")[:] = samples
            sizes[f"Zarr, chunks of {chunk}, {codec} {name}"] = count_bytes(target)
    seconds = {}
    box = choose_box(samples.shape, size)
    for _ in range(repeats):
        with si.open(path) as volume:
            volume[:1, :1, :1]  # opens the directory
            for name in ("cold block cache", "warm block cache"):
                seconds.setdefault(name, []).append(measure(lambda: volume[box]))
            assert (volume[box] == samples[box]).all()
        for name, array in peers.items():
            seconds.setdefault(name, []).append(measure(lambda: array[box]))
    ours = min(seconds["cold block cache"])
    for name, times in seconds.items():
        print(
            f"{codec:5} {name:36} {sizes[name] / 1e6:6.1f} MB {min(times) * 1e3:7.1f} ms, "
            f"{min(times) / ours:5.2f} of the cold block cache"
        )


def compare_steps(path, samples, repeats):
    """Prints seconds for every 32nd sample, which a coarser level has, beside reading all and leaving most out."""
    seconds = {"every 32nd sample": [], "all samples, then every 32nd": []}
    for _ in range(repeats):
        for name, read in zip(seconds, (lambda v: v[::32, ::32, ::32], lambda v: v[...][::32, ::32, ::32])):
            with si.open(path) as volume:
                seconds[name].append(measure(lambda: read(volume)))
                assert (read(volume) == samples[::32, ::32, ::32]).all()
    for name, times in seconds.items():
        print(f"{name}: {min(times) * 1e3:.1f} ms")


def compare_surfaces(path, isovalue, repeats):
    """Prints seconds for a surface here and by the filter, which share the block cache."""
    volume = si.open(path)
    reader = vtkBlockedVolumeReader()
    reader.SetFileName(path)
    contour = vtkStabbingContour()
    contour.SetInputConnection(reader.GetOutputPort())
    contour.SetInputArrayToProcess(0, 0, 0, 0, volume.name)
    contour.SetValue(0, isovalue)

    def update():
        contour.Modified()
        contour.Update()

    seconds = {"vtkStabbingContour": [], "Volume.isosurface": []}
    triangles = len(volume.isosurface(isovalue).triangles)
    for _ in range(repeats):
        seconds["vtkStabbingContour"].append(measure(update))
        seconds["Volume.isosurface"].append(measure(lambda: volume.isosurface(isovalue)))
    assert contour.GetOutput().GetNumberOfPolys() == triangles
    filtered, plain = map(min, seconds.values())
    print(
        f"{triangles} triangles: vtkStabbingContour {filtered * 1e3:.1f} ms, "
        f"Volume.isosurface {plain * 1e3:.1f} ms, {plain / filtered:.3f} of it"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?")
    parser.add_argument("--isovalue", type=float, default=1200)
    parser.add_argument("--box", type=int, default=256)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--folder")
    options = parser.parse_args()
    samples = si.open(options.volume)[...] if options.volume else make_samples(320)
    folder = tempfile.mkdtemp(dir=options.folder)
    try:
        print(f"{samples.shape} {samples.dtype}, boxes of {options.box}, {os.cpu_count()} cores")
        for codec in ("lz4", "zstd"):
            compare_boxes(samples, folder, codec, options.box, options.repeats)
        compare_steps(os.path.join(folder, "lz4.bvol"), samples, options.repeats)
        compare_surfaces(os.path.join(folder, "lz4.bvol"), options.isovalue, options.repeats)
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
