# SPDX-License-Identifier: BSD-3-Clause
"""Runs the examples in the docstrings of scalable_isosurface beside the files that they open."""

import doctest
import importlib
import os
import sys
import tempfile

import numpy

import scalable_isosurface as si
from scalable_isosurface import vtkBlockedVolumeReader, vtkEdgeIndexWriter, vtkStabbingContour


def write_files():
    z, y, x = numpy.meshgrid(numpy.arange(20), numpy.arange(30), numpy.arange(40), indexing="ij")
    waves = (numpy.sin(0.4 * x) * numpy.cos(0.3 * y) + 0.02 * z).astype(numpy.float32)
    si.create(waves, "waves.bvol", spacing=(0.5, 1, 2), name="waves")
    with open("waves.nrrd", "wb") as file:
        file.write(b"NRRD0005\ntype: float\ndimension: 3\nsizes: 40 30 20\nencoding: raw\nendian: little\n\n")
        file.write(waves.astype("<f4").tobytes())
    reader = vtkBlockedVolumeReader()
    reader.SetFileName("waves.bvol")
    contour = vtkStabbingContour()
    contour.SetInputConnection(reader.GetOutputPort())
    contour.SetInputArrayToProcess(0, 0, 0, 0, "waves")
    contour.SetValue(0, 0.3)
    writer = vtkEdgeIndexWriter()
    writer.SetInputConnection(contour.GetOutputPort())
    writer.SetFileName("waves.eix")
    assert writer.Write()


def main():
    failed = tried = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        write_files()
        # Numbers as NumPy 1 prints them, too.
        options = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        for name in ("_edge_index", "_indexing", "_opening", "_surface", "_volume", "_writing"):
            module = importlib.import_module(f"scalable_isosurface.{name}")
            result = doctest.testmod(module, extraglobs={"si": si, "np": numpy}, optionflags=options)
            failed += result.failed
            tried += result.attempted
        os.chdir("/")
    print(f"{tried} examples, {failed} are wrong")
    return 1 if failed or tried < 15 else 0


if __name__ == "__main__":
    sys.exit(main())
