#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Slices, a box and values at points of a blocked volume, beside stock VTK, which loads the volume first.

    volume_samples.py VOLUME.bvol [SCAN.mhd] [--warm]

SCAN has the same samples, for the peer; without it there is none, as of a volume that is larger than
memory. Each in a process of its own that has loaded its libraries, without files in the system's cache
(that takes root; --warm leaves them there). Seconds:

    first     from opening the file to the slice through the middle, across z
    next      the same a hundred slices away
    drag      a tenth of the distance of slices away: the same blocks
    x, y      across x and y, through the middle
    oblique   a plane of normal 1 2 3
    coarse    in a window: from a jump of that plane to the coarse slice, and the longest of 40 such
              slices while the plane is dragged, beside the reading of the exact one
    box       256 samples a side around the middle
    line      1000 values along a diagonal
    surface   a million points of a ball

Stock: vtkMetaImageReader, vtkImageReslice (linear), vtkExtractVOI, vtkProbeFilter. Needs the package
scalable_isosurface on PYTHONPATH.
"""
import argparse
import json
import os
import subprocess
import sys
import time

OBLIQUE = (1 / 14**0.5, 2 / 14**0.5, 3 / 14**0.5)


class Clock:
    def __init__(self):
        self.seconds = {}

    def measure(self, name, step):
        begin = time.perf_counter()
        result = step()
        self.seconds[name] = round(time.perf_counter() - begin, 3)
        return result


def make_points(bounds, kind):
    from vtkmodules.vtkFiltersSources import vtkLineSource, vtkSphereSource

    if kind == "line":
        points = vtkLineSource()
        points.SetPoint1(bounds[0::2])
        points.SetPoint2(bounds[1::2])
        points.SetResolution(999)
    else:
        points = vtkSphereSource()
        points.SetCenter([(bounds[2 * axis] + bounds[2 * axis + 1]) / 2 for axis in range(3)])
        points.SetRadius(0.3 * min(bounds[2 * axis + 1] - bounds[2 * axis] for axis in range(3)))
        points.SetThetaResolution(1000)
        points.SetPhiResolution(1000)
    points.Update()
    return points


def measure_drag(cut, middle, step):
    """The longest time in which a window would not answer."""
    cut.AllowCoarse(1)
    longest = 0
    for drag in range(41):
        cut.SetOrigin([middle[axis] + (100 + 3 * drag) * step[axis] * OBLIQUE[axis] for axis in range(3)])
        begin = time.perf_counter()
        cut.Update()
        longest = max(longest, time.perf_counter() - begin)
        cut.PrepareRefinement(0)
        time.sleep(0.03)
    cut.DropRefinement()
    cut.AllowCoarse(0)
    return round(longest, 3)


def measure_ours(path):
    import scalable_isosurface as ours

    clock = Clock()
    reader = ours.vtkBlockedVolumeReader()
    cut = ours.vtkVolumeSlice()
    cut.SetMaximumPoints(100)
    cut.SetInputConnection(reader.GetOutputPort())

    def open_and_cut():
        reader.SetFileName(path)
        reader.SetMemoryLimit(1)
        reader.Update()
        bounds = reader.GetOutput().GetPartition(0).GetBounds()
        cut.SetOrigin([(bounds[2 * axis] + bounds[2 * axis + 1]) / 2 for axis in range(3)])
        cut.Update()
        return bounds

    bounds = clock.measure("first", open_and_cut)
    middle, step = cut.GetOrigin(), cut.GetOutput().GetSpacing()

    def cut_at(normal, origin):
        cut.SetNormal(normal)
        cut.SetOrigin(origin)
        cut.Update()

    x, y, z = middle
    clock.measure("next", lambda: cut_at((0, 0, 1), (x, y, z + 100 * step[2])))
    clock.measure("drag", lambda: cut_at((0, 0, 1), (x, y, z + 100.1 * step[2])))
    clock.measure("x", lambda: cut_at((1, 0, 0), middle))
    clock.measure("y", lambda: cut_at((0, 1, 0), middle))
    clock.measure("oblique", lambda: cut_at(OBLIQUE, middle))
    clock.seconds["coarse"] = measure_drag(cut, middle, step)
    region = ours.vtkVolumeRegion()
    region.SetInputConnection(reader.GetOutputPort())
    region.SetPosition([middle[axis] - 127.5 * step[axis] for axis in range(3)])
    region.SetLength([255 * step[axis] for axis in range(3)])
    clock.measure("box", region.Update)
    for kind in ("line", "surface"):
        points = make_points(bounds, kind)
        probe = ours.vtkVolumeProbe()
        probe.SetInputConnection(reader.GetOutputPort())
        probe.SetSourceConnection(points.GetOutputPort())
        clock.measure(kind, probe.Update)
    return clock.seconds


def measure_stock(path):
    from vtkmodules.vtkFiltersCore import vtkProbeFilter
    from vtkmodules.vtkImagingCore import vtkExtractVOI, vtkImageReslice
    from vtkmodules.vtkIOImage import vtkMetaImageReader

    clock = Clock()
    reader = vtkMetaImageReader()
    cut = vtkImageReslice()
    cut.SetInputConnection(reader.GetOutputPort())
    cut.SetOutputDimensionality(2)
    cut.SetInterpolationModeToLinear()
    axes = {
        (0, 0, 1): ((1, 0, 0), (0, 1, 0)),
        (1, 0, 0): ((0, 1, 0), (0, 0, 1)),
        (0, 1, 0): ((1, 0, 0), (0, 0, 1)),
        OBLIQUE: ((2 / 5**0.5, -1 / 5**0.5, 0), (3 / 70**0.5, 6 / 70**0.5, -5 / 70**0.5)),
    }

    def cut_at(normal, origin):
        first, second = axes[normal]
        cut.SetResliceAxesDirectionCosines(*first, *second, *normal)
        cut.SetResliceAxesOrigin(origin)
        cut.Update()

    def open_and_cut():
        reader.SetFileName(path)
        reader.Update()
        middle = reader.GetOutput().GetCenter()
        cut_at((0, 0, 1), middle)
        return middle

    middle = clock.measure("first", open_and_cut)
    image = reader.GetOutput()
    step, extent = image.GetSpacing(), image.GetExtent()
    x, y, z = middle
    clock.measure("next", lambda: cut_at((0, 0, 1), (x, y, z + 100 * step[2])))
    clock.measure("drag", lambda: cut_at((0, 0, 1), (x, y, z + 100.1 * step[2])))
    clock.measure("x", lambda: cut_at((1, 0, 0), middle))
    clock.measure("y", lambda: cut_at((0, 1, 0), middle))
    clock.measure("oblique", lambda: cut_at(OBLIQUE, middle))
    box = vtkExtractVOI()
    box.SetInputConnection(reader.GetOutputPort())
    box.SetVOI([extent[2 * axis + 1] // 2 + end for axis in range(3) for end in (-127, 128)])
    clock.measure("box", box.Update)
    for kind in ("line", "surface"):
        points = make_points(image.GetBounds(), kind)
        probe = vtkProbeFilter()
        probe.SetSourceConnection(reader.GetOutputPort())
        probe.SetInputConnection(points.GetOutputPort())
        clock.measure(kind, probe.Update)
    return clock.seconds


def measure(who, path, is_cold):
    """Loads libraries first, as those of a window that is open."""
    if who == "ours":
        import scalable_isosurface

        scalable_isosurface.vtkVolumeSlice  # loads the module
    else:
        import vtkmodules.vtkFiltersCore  # noqa: F401
        import vtkmodules.vtkImagingCore  # noqa: F401
        import vtkmodules.vtkIOImage  # noqa: F401
    if is_cold:
        os.sync()
        with open("/proc/sys/vm/drop_caches", "w") as file:
            file.write("3")
    seconds = measure_ours(path) if who == "ours" else measure_stock(path)
    with open("/proc/self/status") as file:
        peak = next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) // 1024
    print(json.dumps({**seconds, "peak MiB": peak}))


def main():
    if sys.argv[1:2] == ["--measure"]:
        measure(sys.argv[2], sys.argv[3], sys.argv[4] == "cold")
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("volume")
    parser.add_argument("scan", nargs="?")
    parser.add_argument("--warm", action="store_true")
    arguments = parser.parse_args()
    for who, path in (("ours", arguments.volume), ("stock", arguments.scan)):
        if path:
            done = subprocess.run(
                [sys.executable, __file__, "--measure", who, path, "warm" if arguments.warm else "cold"],
                stdout=subprocess.PIPE, check=True)  # fmt: skip
            times = json.loads(done.stdout.splitlines()[-1])
            print(f"{who:5} " + "  ".join(f"{name} {times[name]}" for name in times), flush=True)


main()
