# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the plugin share. Run them in pvpython or pvbatch, on any number of ranks:

    SCRIPT.py --plugin ScalableIsosurface.so --volumes FOLDER --output FOLDER --baselines FOLDER

VOLUMES is what write_volumes.py wrote; OUTPUT is the test's own folder, emptied first.
"""
import argparse
import csv
import functools
import json
import os
import re
import shutil
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree

from paraview import simple

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from time_limits import WAIT_SECONDS  # noqa: E402, F401  (found in the folder above)

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


def get_stores(path):
    """The folder of a blocked volume's stores: that of version 1.0.0, or else the hidden one."""
    folder, name = os.path.split(path)
    return path + ".stores" if os.path.exists(path + ".stores") else os.path.join(folder, f".{name}.stores")


def baseline(name):
    return os.path.join(arguments.baselines, name)


def parse_arguments():
    """Tests take those of them that they need."""
    global arguments
    parser = argparse.ArgumentParser()
    for name in ("plugin", "volumes", "output"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--baselines")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--port", type=int, help="of a pvserver on this machine, to be its client")
    parser.add_argument("--also", nargs="*", default=[], help="scripts whose tests run in this session, too")
    parser.add_argument("--states", help="the folder of the GUI tests' output")
    parser.add_argument("--xml", help="the folder of the plugin's XML files")
    parser.add_argument("--documentation", help="the folder of the pages for users")
    parser.add_argument("--help-file", help="the .qch of the plugin")
    parser.add_argument("--mpiexec", help="up to the number of ranks")
    for name in ("pvbatch", "pvserver", "pvpython", "paraview"):
        parser.add_argument("--" + name)
    parser.add_argument("--played", help="the folder of what the GUI plays")
    parser.add_argument("--preloaded", help="the library that gives the GUI's player commands that wait")
    parser.add_argument("--window-python-path", help="PYTHONPATH of the GUI")
    parser.add_argument("--long", action="store_true", help="run what else takes minutes")
    parser.add_argument("--in-window", action="store_true", help="run the tests of the GUI alone")
    parser.add_argument("--minutes", type=float, default=10, help="of a test of random deeds")
    parser.add_argument("--seed", type=int, default=1, help="of its first window")
    parser.add_argument("--python", help="a Python with h5py")
    parser.add_argument("--wall", action="store_true", help="write the tiles of a wall")
    arguments = parser.parse_args()
    arguments.output = os.path.abspath(arguments.output)
    shutil.rmtree(arguments.output, ignore_errors=True)
    os.makedirs(arguments.output)


def load_plugin():
    """Into the servers, this process, and paraview.simple."""
    if arguments.port:
        simple.Connect("localhost", arguments.port)
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


def read_window(view):
    """What a view's window shows, without drawing again."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    window = view.GetRenderWindow()
    columns, rows = window.GetSize()
    pixels = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, columns - 1, rows - 1, 1, pixels, 0)
    return vtk_to_numpy(pixels).reshape(rows, columns, 3).astype(int)


def make_mpi_environment():
    """For programs that are started under mpiexec: pvpython, itself a rank, leaves Open MPI's
    variables in the environment, with which a second mpiexec does nothing. How ranks reach each other
    and wait, only the user says."""
    kept = ("OMPI_ALLOW_", "OMPI_MCA_btl", "OMPI_MCA_mpi_yield")
    return {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("OMPI_", "ORTE_", "PMIX_")) or name.startswith(kept)
    }


def run_on_ranks(script, *script_arguments, options=(), **popen):
    """Starts a script beside this one in pvbatch, on all ranks, with the plugin as its first argument."""
    here = os.path.dirname(os.path.abspath(__file__))
    return subprocess.Popen(
        [
            *arguments.mpiexec.split(),
            str(popen.pop("ranks", arguments.ranks)),
            *popen.pop("before", ()),
            arguments.pvbatch,
            *options,
            os.path.join(here, script),
            arguments.plugin,
            *script_arguments,
        ],
        env=make_mpi_environment(),
        text=True,
        errors="replace",
        **popen,
    )


def read_log(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def start_server(log, *options):
    """A pvserver on all ranks, and its port, which the system chooses."""
    with open(log, "wb") as file:
        server = subprocess.Popen(
            [
                *arguments.mpiexec.split(),
                str(arguments.ranks),
                arguments.pvserver,
                "--server-port=0",
                "--verbosity=1",
                *options,
            ],
            stdout=file,
            stderr=subprocess.STDOUT,
            env=make_mpi_environment(),
        )
    deadline = time.monotonic() + WAIT_SECONDS
    while not (accepts := re.search(r"Accepting connection.*:(\d+)\n", read_log(log))):
        assert server.poll() is None, "the server has ended"
        assert time.monotonic() < deadline, "the server does not start"
        time.sleep(0.1)
    return server, int(accepts[1])


def run(with_plugin=True):
    """Runs the tests of the main script and of those that --also names; on import those do nothing."""
    if arguments:
        return
    parse_arguments()
    if with_plugin:
        load_plugin()
    # ParaView's own scripts give warnings, of which nobody here can do anything.
    result = unittest.main(
        module=None,
        argv=[sys.argv[0], "__main__", *arguments.also],
        verbosity=2,
        exit=False,
        warnings="ignore",
    ).result
    # Only a failure may end in sys.exit(): pvbatch then leaves without finalizing MPI.
    if not result.wasSuccessful():
        sys.exit(1)


class TestCase(unittest.TestCase):
    def check_triangles(self, surface, isovalue=ISOVALUE, function=None):
        """A surface of all ranks has the triangles of vtkFlyingEdges3D."""
        expected = count_expected_triangles(isovalue, function)
        self.assertEqual(count_cells(surface), expected, f"at {isovalue}")

    def load_state(self, path):
        ranks = simple.servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()
        if ranks > 1 and simple.GetParaViewVersion() >= (6, 1):
            # Otherwise one rank reads the file, all are to reduce its error, and ParaView waits forever.
            simple.LoadState(path, location=simple.servermanager.vtkPVSession.SERVERS)
        else:
            simple.LoadState(path)

    def check_image(self, view, baseline_name, image_name):
        self.assertLess(compare_image(view, baseline_name, image_name), LARGEST_DIFFERENCE)


class Properties:
    """Those of a proxy, to be given back: tests share views and displays, since Show takes a third of a
    second on each rank."""

    def __init__(self, proxy):
        self.proxy = proxy
        self.values = self.read()

    def read(self):
        properties = {name: self.proxy.GetProperty(name) for name in self.proxy.ListProperties()}
        values = simple.servermanager.VectorProperty, simple.servermanager.ProxyProperty
        return {
            name: one.GetData() if len(one) == 1 else list(one.GetData())
            for name, one in properties.items()
            if isinstance(one, values)
            and not isinstance(one, simple.servermanager.InputProperty)
            and not one.SMProperty.GetInformationOnly()
            and len(one) > 0
        }

    def give_back(self):
        changed = self.read()
        for name, value in self.values.items():
            if changed.get(name) != value:
                self.proxy.SetPropertyWithName(name, value)
        self.proxy.UpdateVTKObjects()


def state(name):
    """The path of what a test of the GUI has saved."""
    return os.path.join(arguments.states, name)


def read_state(name, proxy, property_name):
    """A property's numbers in a state file, of each proxy of a type in the order they were made."""
    proxies = xml.etree.ElementTree.parse(state(name)).findall(f".//Proxy[@type='{proxy}']")
    proxies.sort(key=lambda element: int(element.get("id")))
    path = f"Property[@name='{property_name}']/Element"
    return [[float(value.get("value")) for value in one.findall(path)] for one in proxies]


def read_window_log():
    return read_log(state("window.log"))


def find_triangles(log):
    """Of the surfaces that a window's contours made, in their order."""
    return [int(count) for count in re.findall(r"rank 0: .* (\d+) triangles", log)]


def read_header(path):
    """Of a blocked volume."""
    with open(path) as file:
        return json.load(file)


def open_image():
    image = simple.XMLImageDataReader(FileName=[volume("wave.vti")])
    image.UpdatePipeline()
    return image


def open_volume(name):
    """A reader with its pipeline up to date."""
    reader = simple.OpenDataFile(volume(name))
    reader.UpdatePipeline()
    return reader


def read_samples(image):
    """Of the array RTData, z slowest."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    samples = vtk_to_numpy(image.GetPointData().GetArray("RTData"))
    return samples.reshape(image.GetDimensions()[::-1])


def write_zarr(folder, samples, chunk):
    """An array of version 2 without compression, its last chunks partial."""
    import numpy

    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, ".zarray"), "w") as file:
        json.dump({"zarr_format": 2, "shape": samples.shape, "chunks": [chunk] * 3, "dtype": "<f4",
                   "compressor": None, "fill_value": 0, "order": "C", "filters": None}, file)
    for place in numpy.ndindex(*[-(-count // chunk) for count in samples.shape]):
        part = samples[tuple(slice(at * chunk, (at + 1) * chunk) for at in place)]
        whole = numpy.zeros((chunk,) * 3, "f4")
        whole[tuple(slice(count) for count in part.shape)] = part
        whole.tofile(os.path.join(folder, ".".join(map(str, place))))


def make_large_image():
    """Of more samples than a sample of a file has."""
    wavelet = simple.Wavelet(WholeExtent=[-80, 80, -65, 65, -55, 55])
    wavelet.UpdatePipeline()
    return wavelet


def make_series():
    """A volume that changes with time: RTData + 10 t at t = 0, 1, 2, 3."""
    import numpy

    # The filter imports all of numpy into the main script, since numpy 2 its `testing`, too.
    numpy.__all__ = [name for name in numpy.__all__ if name != "testing"]
    series = simple.ProgrammableFilter(Input=open_image())
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
    surface = simple.Isosurface(
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
    """The field data of a Isosurface as a user saves it: a dictionary for each rank."""
    path = output("costs.csv")
    simple.SaveData(path, proxy=surface, FieldAssociation="Field Data")
    with open(path, newline="") as table:
        return list(csv.DictReader(table))


def make_view():
    """A view like the GUI's first one, as large as the baselines, of their background: that of ParaView 6
    is so near to a surface that the images' difference may be missed."""
    return simple.CreateRenderView(
        ViewSize=IMAGE_SIZE, UseColorPaletteForBackground=0, Background=[0.32, 0.34, 0.43]
    )


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
