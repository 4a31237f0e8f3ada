# SPDX-License-Identifier: BSD-3-Clause
"""A progressive isosurface: coarse at once, then finer, an image of each.

    mpirun -n 2 pvbatch progressive.py --plugin .../ScalableIsosurface.so [--output FOLDER]
        [--volume VOLUME.bvol --array NAME] [--isovalues VALUE ...]

Any number of ranks will do. By default the skin of a head MRI (see debian_scans.py). Writes
FOLDER/progressive_ISOVALUE_levelL.png for each level L that is shown.
"""
import argparse
import os
import sys
import time

from paraview import simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)


def write_head(folder):
    """The default volume, in blocks small enough for it to have several levels of them."""
    path = os.path.join(folder, "progressive.bvol")
    debian_scans.write_blocked_volume(debian_scans.head_mri(), path, BlockSize=16, NumberOfStores=4)
    return path


def show_passes(contour, view):
    """Draws the surface from coarse to fine; yields, for each, its information and the seconds."""
    while True:
        start = time.time()
        simple.Render(view)
        yield contour.GetDataInformation().DataInformation, time.time() - start
        contour.UpdatePropertyInformation()
        if contour.Final:
            return
        contour.Refine()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    parser.add_argument("--volume", help="a blocked volume; default: a head MRI")
    parser.add_argument("--array", default="T1", help="the point array to contour")
    parser.add_argument("--isovalues", type=float, nargs="+", default=[40.5, 80.5])
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))

    reader = simple.OpenDataFile(arguments.volume or write_head(arguments.output))
    contour = simple.Isosurface(
        Input=reader, ContourBy=["POINTS", arguments.array], Progressive=1
    )
    view = simple.CreateRenderView(ViewSize=[600, 600], OrientationAxesVisibility=0)
    for isovalue in arguments.isovalues:
        contour.Isosurfaces = [isovalue]
        simple.ColorBy(simple.Show(contour, view), None)
        if isovalue == arguments.isovalues[0]:
            camera = view.GetActiveCamera()
            camera.SetPosition(0.4, 1, 0.2)
            camera.SetFocalPoint(0, 0, 0)
            camera.SetViewUp(0, 0, 1)
            simple.ResetCamera(view)
        for information, seconds in show_passes(contour, view):
            fields = information.GetFieldDataInformation()
            level = int(fields.GetArrayInformation("Level").GetComponentRange(0)[0])
            name = f"progressive_{isovalue:g}_level{level}.png"
            simple.SaveScreenshot(os.path.join(arguments.output, name), view)
            print(
                f"isovalue {isovalue:g}, level {level}: "
                f"{information.GetNumberOfCells()} triangles after {seconds:.3f} s"
            )


main()
