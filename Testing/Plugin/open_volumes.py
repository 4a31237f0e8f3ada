# SPDX-License-Identifier: BSD-3-Clause
"""Opens and contours one volume after the other, as a user would who does not give up:

    pvbatch open_volumes.py PLUGIN VOLUME...

Prints the triangles of each.
"""
import os
import sys

from paraview import simple

simple.LoadPlugin(sys.argv[1], remote=True, ns=vars(simple))
for path in sys.argv[2:]:
    triangles = 0
    try:
        reader = simple.BlockedVolumeReader(FileName=path)  # OpenDataFile refuses some at once
        surface = simple.Isosurface(
            Input=reader, ContourBy=["POINTS", "RTData"], Isosurfaces=[150]
        )
        surface.UpdatePipeline()
        triangles = surface.GetDataInformation().GetNumberOfCells()
        # And without a contour.
        simple.BlockedVolumeReader(FileName=path).UpdatePipeline()
    except RuntimeError as error:
        print(f"{os.path.basename(path)}: {error}", flush=True)
    print(f"{os.path.basename(path)}: {triangles} triangles", flush=True)
