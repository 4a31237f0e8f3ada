# SPDX-License-Identifier: BSD-3-Clause
"""Images of an isosurface with and without its hidden triangles, side by side in one run.

    python3 hidden_triangles.py [--volume FILE.vti --array NAME] --isovalue V [--step S]
        [--zoom Z] [--size 1280 800] [--rounds 4] [--culling ALWAYS]

Needs the package scalable_isosurface and a display. Without a volume it is a rough sheet, which has next
to no hidden triangles. In each round it draws the image twice more, the next isovalue, and the
surface turned by 5 and by 25 degrees, first with all triangles. It prints the median seconds of both,
their ratio, and how many pixels differ.
"""
import argparse
import statistics
import time

import numpy
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401: makes the classes below draw
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOXML import vtkXMLImageDataReader
from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer, vtkRenderWindow

from scalable_isosurface import vtkIsosurfaceMapper, vtkStabbingContour


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--volume")
    parser.add_argument("--array")
    parser.add_argument("--isovalue", type=float, default=0.0)
    parser.add_argument("--step", type=float, default=1.0)
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 800])
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--culling", choices=("SOFTWARE", "ALWAYS"), default="ALWAYS")
    return parser.parse_args()


def open_volume(arguments):
    if arguments.volume:
        reader = vtkXMLImageDataReader()
        reader.SetFileName(arguments.volume)
        reader.Update()
        return reader.GetOutput()
    heights = 12 + numpy.random.default_rng(1).normal(0, 0.3, (1, 900, 900))
    samples = (numpy.arange(24)[:, None, None] - heights).astype("f4")
    image = vtkImageData()
    image.SetDimensions(900, 900, 24)
    array = numpy_to_vtk(samples.ravel(), deep=True)
    array.SetName("height")
    image.GetPointData().SetScalars(array)
    return image


def make_surface(image, arguments, isovalue):
    contour = vtkStabbingContour()
    contour.SetInputData(image)
    array = arguments.array or image.GetPointData().GetArrayName(0)
    contour.SetInputArrayToProcess(0, 0, 0, 0, array)
    contour.SetValue(0, isovalue)
    contour.Update()
    return contour.GetOutput()


class Window:

    def __init__(self, surface, culling, arguments):
        self.mapper = vtkIsosurfaceMapper()
        self.mapper.SetOcclusionCulling(culling)
        self.mapper.SetInputDataObject(surface)
        self.mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(self.mapper)
        self.renderer = vtkRenderer()
        self.renderer.AddActor(actor)
        self.window = vtkRenderWindow()
        self.window.SetMultiSamples(0)
        self.window.SetOffScreenRendering(True)
        self.window.SetSize(arguments.size)
        self.window.AddRenderer(self.renderer)
        self.renderer.ResetCamera()
        self.renderer.GetActiveCamera().Zoom(arguments.zoom)

    def render(self):
        """The seconds, and the pixels."""
        self.renderer.ResetCameraClippingRange()
        begin = time.perf_counter()
        self.window.Render()
        self.window.WaitForCompletion()
        seconds = time.perf_counter() - begin
        width, height = self.window.GetSize()
        pixels = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        return seconds, vtk_to_numpy(pixels).reshape(-1, 3).copy()

    def turn(self, degrees):
        self.renderer.GetActiveCamera().Azimuth(degrees)
        self.renderer.GetActiveCamera().Elevation(degrees / 3)


def main():
    arguments = parse_arguments()
    image = open_volume(arguments)
    surface = make_surface(image, arguments, arguments.isovalue)
    windows = [Window(surface, culling, arguments)
               for culling in (vtkIsosurfaceMapper.NEVER, getattr(vtkIsosurfaceMapper, arguments.culling))]
    seconds = {}
    shares = {}
    different = 0

    def compare(name):
        nonlocal different
        images = [window.render() for window in windows]
        seconds.setdefault(name, []).append([image[0] for image in images])
        drawn = [window.mapper.GetNumberOfDrawnTriangles() for window in windows]
        shares.setdefault(name, []).append(drawn[1] / drawn[0])
        different += int((images[0][1] != images[1][1]).any(axis=1).sum())

    compare("first")
    for step in range(1, arguments.rounds + 1):
        compare("again")
        compare("again")
        surface = make_surface(image, arguments, arguments.isovalue + step * arguments.step)
        for window in windows:
            window.mapper.SetInputDataObject(surface)
        compare("isovalue")
        compare("again")
        for degrees in (5, 25):
            for window in windows:
                window.turn(degrees)
            compare(f"turned by {degrees}")
    print(f"{surface.GetNumberOfPolys():,} triangles; {different} pixels differ")
    for name, times in seconds.items():
        every, some = (statistics.median(column) for column in zip(*times))
        ratio = statistics.median(pair[1] / pair[0] for pair in times)
        print(f"{name:14} all {every:.3f} s  without hidden ones {some:.3f} s  ratio {ratio:.2f}  "
              f"drawn {100 * statistics.median(shares[name]):.0f} %")


main()
