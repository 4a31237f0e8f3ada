#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From a scan to an isosurface with VTK's classes alone, without ParaView's window or server manager.

    PYTHONPATH=build/release/lib/python3/dist-packages python3 Examples/contour_in_python.py [--isovalue VALUE]

Writes the head MRI of Debian's mricron-data as a blocked volume, finds out what isosurfaces cost, and extracts one
into a .vtp file. The folder of the output is --output, by default the current one.
"""

import argparse
import os

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from scalable_isosurface import (
    vtkBlockedVolumeReader,
    vtkBlockedVolumeWriter,
    vtkContourSpectrum,
    vtkStabbingContour,
)

SCAN = "/usr/share/mricron/templates/ch2.nii.gz"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scan", default=SCAN, help="a NIfTI file")
    parser.add_argument("--isovalue", type=float, default=40)
    parser.add_argument("--output", default=".")
    arguments = parser.parse_args()

    scan = vtkNIFTIImageReader()
    scan.SetFileName(arguments.scan)
    writer = vtkBlockedVolumeWriter()
    writer.SetInputConnection(scan.GetOutputPort())
    writer.SetFileName(os.path.join(arguments.output, "head.bvol"))
    if not writer.Write():
        raise SystemExit(1)

    volume = vtkBlockedVolumeReader()
    volume.SetFileName(writer.GetFileName())

    spectrum = vtkContourSpectrum()
    spectrum.SetInputConnection(volume.GetOutputPort())
    spectrum.Update()
    isovalues, triangles, size = (
        vtk_to_numpy(spectrum.GetOutput().GetColumnByName(name)) for name in ("Isovalue", "Triangles", "Bytes")
    )
    row = abs(isovalues - arguments.isovalue).argmin()
    print(f"Isovalue {isovalues[row]:g} has {triangles[row]:.0f} triangles in {size[row]:.0f} bytes of the volume.")

    contour = vtkStabbingContour()
    contour.SetInputConnection(volume.GetOutputPort())
    contour.SetValue(0, isovalues[row])
    contour.Update()
    surface = contour.GetOutput()
    print(f"The surface has {surface.GetNumberOfPolys()} triangles and {surface.GetNumberOfPoints()} points.")

    file = vtkXMLPolyDataWriter()
    file.SetInputData(surface)
    file.SetFileName(os.path.join(arguments.output, "head.vtp"))
    if not file.Write():
        raise SystemExit(1)


if __name__ == "__main__":
    main()
