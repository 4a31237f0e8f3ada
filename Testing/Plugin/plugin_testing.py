# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the plugin share. Run them in pvpython or pvbatch, on any number of ranks:

    SCRIPT.py --plugin ScalableIsosurface.so --volumes FOLDER --output FOLDER --baselines FOLDER

VOLUMES is what write_volumes.py wrote; OUTPUT is the test's own folder, emptied first.
"""
import argparse
import csv
import os
import shutil
import sys
import unittest

from paraview import simple

ISOVALUE = 150.0
PICTURE_SIZE = [300, 300]
# vtkImageDifference's thresholded error, which is also that of ParaView's GUI tests. It is 0 on one
# machine; 3 leaves room for another software renderer. The other isovalue makes a surface that
# anybody sees to be another one.
LARGEST_DIFFERENCE = 3.0
OTHER_ISOVALUE = 135.0

arguments = None


def volume(name):
    return os.path.join(arguments.volumes, name)


def output(name):
    return os.path.join(arguments.output, name)


def baseline(name):
    return os.path.join(arguments.baselines, name)


def load_plugin(remote=False):
    simple.LoadPlugin(arguments.plugin, remote=remote, ns=vars(simple))


def parse_arguments(add_arguments=None):
    global arguments
    parser = argparse.ArgumentParser()
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--volumes", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--baselines")
    if add_arguments:
        add_arguments(parser)
    arguments = parser.parse_args()
    shutil.rmtree(arguments.output, ignore_errors=True)
    os.makedirs(arguments.output)


def run(add_arguments=None):
    """Runs the tests of the main script."""
    parse_arguments(add_arguments)
    result = unittest.main(argv=sys.argv[:1], verbosity=2, exit=False).result
    # Only a failure may end in sys.exit(): pvbatch then leaves without finalizing MPI.
    if not result.wasSuccessful():
        sys.exit(1)


def open_volume(name):
    """A reader with its pipeline up to date."""
    reader = simple.OpenDataFile(name if os.path.isabs(name) else volume(name))
    reader.UpdatePipeline()
    return reader


def contour(source, isovalue=ISOVALUE, array="RTData"):
    surface = simple.StabbingContour(
        Input=source, ContourBy=["POINTS", array], Isosurfaces=[isovalue]
    )
    surface.UpdatePipeline()
    return surface


def count_cells(proxy):
    """Cells of all ranks."""
    proxy.UpdatePipeline()
    return proxy.GetDataInformation().GetNumberOfCells()


def count_stock_triangles(isovalue=ISOVALUE, source=None):
    """What ParaView's own Contour makes of the volume that the blocked ones were written from."""
    source = source or simple.XMLImageDataReader(FileName=[volume("wave.vti")])
    return count_cells(
        simple.Contour(Input=source, ContourBy=["POINTS", "RTData"], Isosurfaces=[isovalue])
    )


def read_costs(surface):
    """The field data of a Stabbing Contour as a user saves it: a dictionary for each rank."""
    path = output("costs.csv")
    simple.SaveData(path, proxy=surface, FieldAssociation="Field Data")
    with open(path, newline="") as table:
        return list(csv.DictReader(table))


def make_view():
    """A view like the GUI's first one, as large as the baselines."""
    return simple.CreateRenderView(ViewSize=PICTURE_SIZE)


def show_surface(surface, view):
    """Shows a surface in one colour, with the camera that the GUI gives its input."""
    source = surface.Input
    simple.Show(source, view)
    simple.ResetCamera(view)
    simple.Hide(source, view)
    display = simple.Show(surface, view)
    simple.ColorBy(display, None)
    return display


def compare_picture(view, baseline_name, picture_name):
    """Saves the view's picture; its difference from the baseline as vtkImageDifference has it."""
    # Here, because pvbatch loads them with the first picture, after MPI is up.
    from vtkmodules.vtkImagingCore import vtkImageDifference
    from vtkmodules.vtkIOImage import vtkPNGReader

    simple.SaveScreenshot(output(picture_name), view, ImageResolution=PICTURE_SIZE)
    pictures = []
    for path in (output(picture_name), baseline(baseline_name)):
        reader = vtkPNGReader()
        reader.SetFileName(path)
        reader.Update()
        pictures.append(reader.GetOutput())
    difference = vtkImageDifference()
    difference.SetInputData(pictures[0])
    difference.SetImageData(pictures[1])
    difference.Update()
    return difference.GetThresholdedError()
