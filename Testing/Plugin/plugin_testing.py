# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the plugin share. Run them in pvpython or pvbatch, on any number of ranks:

    SCRIPT.py --plugin ScalableIsosurface.so --volumes FOLDER --output FOLDER --baselines FOLDER

VOLUMES is what write_volumes.py wrote; OUTPUT is the test's own folder, emptied first.
"""
import argparse
import csv
import functools
import os
import shutil
import sys
import unittest

from paraview import simple

ISOVALUE = 150.0
IMAGE_SIZE = [300, 300]
# vtkImageDifference's thresholded error, which is also that of ParaView's GUI tests. It is 0 on one
# machine; 3 leaves room for another software renderer. The other isovalue makes a surface that
# anybody sees to be another one.
LARGEST_DIFFERENCE = 3.0
OTHER_ISOVALUE = 135.0

arguments = None


def volume(name):
    """The path of one of the volumes; absolute paths stay as they are."""
    return os.path.join(arguments.volumes, name)


def output(name):
    return os.path.join(arguments.output, name)


def baseline(name):
    return os.path.join(arguments.baselines, name)


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
    arguments.output = os.path.abspath(arguments.output)
    shutil.rmtree(arguments.output, ignore_errors=True)
    os.makedirs(arguments.output)


def load_plugin():
    """Into the servers, this process, and paraview.simple."""
    simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))
    if simple.servermanager.ActiveConnection.IsRemote():
        simple.LoadPlugin(arguments.plugin, remote=False, ns=vars(simple))


def read_image(path):
    """Rows of tuples of a PNG file. (In pvbatch scripts run on the first rank alone.)"""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader

    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    columns, rows, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1).astype(int)


def make_mpi_environment():
    """For programs that are started under mpiexec: pvpython, itself a rank, leaves Open MPI's
    variables in the environment, with which a second mpiexec does nothing. How ranks reach each other
    (OMPI_MCA_btl), only the user says."""
    kept = ("OMPI_ALLOW_", "OMPI_MCA_btl")
    return {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("OMPI_", "ORTE_", "PMIX_")) or name.startswith(kept)
    }


def run():
    """Runs the tests of the main script, whose arguments are parsed and plugin is loaded."""
    # ParaView's own scripts give warnings, of which nobody here can do anything.
    result = unittest.main(
        argv=sys.argv[:1], verbosity=2, exit=False, warnings="ignore"
    ).result
    # Only a failure may end in sys.exit(): pvbatch then leaves without finalizing MPI.
    if not result.wasSuccessful():
        sys.exit(1)


def open_volume(name):
    """A reader with its pipeline up to date."""
    reader = simple.OpenDataFile(volume(name))
    reader.UpdatePipeline()
    return reader


def make_series():
    """A volume that changes with time: RTData + 10 t at t = 0, 1, 2, 3."""
    wave = simple.XMLImageDataReader(FileName=[volume("wave.vti")])
    series = simple.ProgrammableFilter(Input=wave)
    series.RequestInformationScript = """
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
info = self.GetOutputInformation(0)
info.Set(pipeline.TIME_STEPS(), [0.0, 1.0, 2.0, 3.0], 4)
info.Set(pipeline.TIME_RANGE(), [0.0, 3.0], 2)
"""
    series.Script = """
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
time = self.GetOutputInformation(0).Get(pipeline.UPDATE_TIME_STEP())
output.PointData.append(inputs[0].PointData["RTData"] + 10 * time, "RTData")
output.VTKObject.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), time)
output.VTKObject.GetPointData().SetActiveScalars("RTData")
"""
    series.UpdatePipelineInformation()
    return series


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


@functools.lru_cache(maxsize=None)
def count_expected_triangles(isovalue=ISOVALUE, function=None):
    """What vtkFlyingEdges3D makes of the whole volume, or of a function of it, on this rank alone.

    The function is one of RTData and of Gradient, RTData's gradient.

    On several ranks ParaView's Contour is no oracle: it counts triangles between pieces twice.
    """
    from vtkmodules.vtkFiltersCore import vtkArrayCalculator, vtkFlyingEdges3D
    from vtkmodules.vtkFiltersGeneral import vtkGradientFilter
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader = vtkXMLImageDataReader()
    reader.SetFileName(volume("wave.vti"))
    calculator = vtkArrayCalculator()
    gradient = vtkGradientFilter()
    gradient.SetInputConnection(reader.GetOutputPort())
    gradient.SetInputScalars(0, "RTData")
    gradient.SetResultArrayName("Gradient")
    calculator.SetInputConnection(gradient.GetOutputPort())
    calculator.AddScalarVariable("RTData", "RTData")
    calculator.AddVectorVariable("Gradient", "Gradient")
    calculator.SetFunction(function or "RTData")
    calculator.SetResultArrayName("Result")
    calculator.SetResultArrayType(10)  # VTK_FLOAT
    edges = vtkFlyingEdges3D()
    edges.SetInputConnection(calculator.GetOutputPort())
    edges.SetInputArrayToProcess(0, 0, 0, 0, "Result")
    edges.SetValue(0, isovalue)
    edges.Update()
    triangles = edges.GetOutput().GetNumberOfPolys()
    assert triangles > 0, "nothing to compare with"
    return triangles


def read_costs(surface):
    """The field data of a Stabbing Contour as a user saves it: a dictionary for each rank."""
    path = output("costs.csv")
    simple.SaveData(path, proxy=surface, FieldAssociation="Field Data")
    with open(path, newline="") as table:
        return list(csv.DictReader(table))


def make_view():
    """A view like the GUI's first one, as large as the baselines."""
    return simple.CreateRenderView(ViewSize=IMAGE_SIZE)


def show_surface(surface, view):
    """Shows a surface in one colour, with the camera that the GUI gives its input."""
    source = surface.Input
    simple.Show(source, view)
    simple.ResetCamera(view)
    simple.Hide(source, view)
    display = simple.Show(surface, view)
    simple.ColorBy(display, None)
    return display


def compare_image(view, baseline_name, image_name):
    """Saves the view's image; its difference from the baseline as vtkImageDifference has it."""
    # Here, because pvbatch loads them with the first image, after MPI is up.
    from vtkmodules.vtkImagingCore import vtkImageDifference
    from vtkmodules.vtkIOImage import vtkPNGReader

    simple.SaveScreenshot(output(image_name), view, ImageResolution=IMAGE_SIZE)
    images = []
    for path in (output(image_name), baseline(baseline_name)):
        reader = vtkPNGReader()
        reader.SetFileName(path)
        reader.Update()
        images.append(reader.GetOutput())
    difference = vtkImageDifference()
    difference.SetInputData(images[0])
    difference.SetImageData(images[1])
    difference.Update()
    return difference.GetThresholdedError()
