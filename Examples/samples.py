# SPDX-License-Identifier: BSD-3-Clause
"""A surface and the samples around it: an open head, with slices, isolines and no dust.

    mpirun -n 2 pvbatch samples.py --plugin .../ScalableIsosurface.so [--output FOLDER]

Any number of ranks will do. Writes into FOLDER (default: the current one):
    samples.bvol   the head MRI of Debian's mricron-data as a blocked volume
    samples.png    skin without dust, cut open; two slices in gray, one with the skin's isoline
    line.csv       the samples along a line through the head
"""
import argparse
import os
import sys

from paraview import servermanager, simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)

SKIN = 40.5
SKIN_COLOR = (0.93, 0.76, 0.65)
GRAY = [0, 0, 0, 0, 200, 1, 1, 1]  # "window and level": 0 is black, 200 is white


def open_head(folder):
    path = os.path.join(folder, "samples.bvol")
    debian_scans.write_blocked_volume(debian_scans.head_mri(), path, NumberOfStores=4)
    reader = simple.OpenDataFile(path)
    reader.UpdatePipeline()
    return reader


def show_skin(reader, bounds, view):
    """The largest island of the skin, behind the plane of the front slice."""
    middle = (bounds[2] + bounds[3]) / 2
    skin = simple.Isosurface(
        Input=reader, ContourBy=["POINTS", "T1"], Isosurfaces=[SKIN], MaximumIslands=1
    )
    skin.UseRegion = 1
    skin.RegionPosition = [bounds[0], bounds[2], bounds[4]]
    skin.RegionLength = [bounds[1] - bounds[0], middle - bounds[2], bounds[5] - bounds[4]]
    behind = simple.Clip(Input=skin, ClipType="Plane")
    behind.ClipType.Origin = [bounds[0], middle, bounds[4]]
    behind.ClipType.Normal = [0, 1, 0]
    display = simple.Show(behind, view)
    simple.ColorBy(display, None)
    display.DiffuseColor = display.AmbientColor = SKIN_COLOR
    return skin


def show_slice(reader, origin, normal, view):
    cut = simple.VolumeSlice(Input=reader, Origin=origin, Normal=normal, Isolines=[SKIN])
    display = simple.Show(cut, view)
    simple.ColorBy(display, ("POINTS", "T1"))
    display.LookupTable.RGBPoints = GRAY
    display.LookupTable.ColorSpace = "RGB"
    display.SetScalarBarVisibility(view, False)
    return cut


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))
    reader = open_head(arguments.output)
    bounds = reader.GetDataInformation().GetBounds()
    middle = [(bounds[2 * axis] + bounds[2 * axis + 1]) / 2 for axis in range(3)]

    view = simple.CreateRenderView(ViewSize=[1000, 640], OrientationAxesVisibility=0)
    view.UseColorPaletteForBackground = 0
    view.Background = [0.16, 0.18, 0.22]
    skin = show_skin(reader, bounds, view)
    front = show_slice(reader, middle, [0, 1, 0], view)
    show_slice(reader, [middle[0], middle[1], bounds[4] + 5], [0, 0, 1], view)
    lines = simple.Show(servermanager.OutputPort(front, 1), view)
    simple.ColorBy(lines, None)
    lines.AmbientColor = lines.DiffuseColor = [0.95, 0.45, 0.2]
    lines.LineWidth = 2
    view.CameraFocalPoint = [middle[0], middle[1] - 25, middle[2] - 6]
    view.CameraPosition = [middle[0] + 400, middle[1] + 300, middle[2] + 170]
    view.CameraViewUp = [0, 0, 1]
    view.CameraParallelProjection = 1
    view.CameraParallelScale = 122
    simple.SaveScreenshot(os.path.join(arguments.output, "samples.png"), view)

    ends = [[bounds[0], middle[1], middle[2]], [bounds[1], middle[1], middle[2]]]
    line = simple.Line(Point1=ends[0], Point2=ends[1], Resolution=180)
    simple.SaveData(
        os.path.join(arguments.output, "line.csv"), proxy=simple.VolumeProbe(Input=reader, Source=line)
    )
    skin.UpdatePropertyInformation()
    front.UpdatePropertyInformation()
    print(f"slice: {front.Shown}; skin: {skin.IslandSummary}")


main()
