# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces on the screen: vtkIsosurfaceMapper beside VTK's own mapper, and a surface in PyVista. Needs a display."""

import math
import sys
import unittest

import numpy
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 - makes windows
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow

from scalable_isosurface import vtkIsosurfaceMapper, vtkStabbingContour

try:
    import pyvista
except ImportError:
    pyvista = None

RADIUS = 12.5
SIZE = (301, 233)  # odd ones


def contour_ball():
    """The sphere of RADIUS around the origin."""
    axis = numpy.arange(-16, 17)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    image = vtkImageData()
    image.SetExtent(-16, 16, -16, 16, -16, 16)
    distances = numpy_to_vtk(numpy.sqrt(x * x + y * y + z * z).astype(numpy.float32).ravel(), deep=True)
    distances.SetName("distance")
    image.GetPointData().SetScalars(distances)
    contour = vtkStabbingContour()
    contour.SetInputData(image)
    contour.SetValue(0, RADIUS)
    contour.Update()
    return contour


class Surfaces(unittest.TestCase):
    def draw(self, mapper, surface, change):
        mapper.SetInputDataObject(surface)
        mapper.ScalarVisibilityOff()
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(0.9, 0.6, 0.3)
        change(mapper, actor)
        renderer = vtkRenderer()
        renderer.AddActor(actor)
        renderer.GetActiveCamera().SetPosition(40, 30, 50)
        renderer.ResetCamera()
        window = vtkRenderWindow()
        window.OffScreenRenderingOn()
        window.SetMultiSamples(0)
        window.SetSize(*SIZE)
        window.AddRenderer(renderer)
        window.Render()
        pixels = vtkUnsignedCharArray()
        window.GetPixelData(0, 0, SIZE[0] - 1, SIZE[1] - 1, 1, pixels, 0)
        return vtk_to_numpy(pixels).reshape(SIZE[1], SIZE[0], 3).astype(int)

    def color(self, mapper, actor):
        table = vtkLookupTable()
        table.SetRange(-1, 1)
        table.SetVectorModeToComponent()
        table.SetVectorComponent(0)
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("Normals")
        mapper.InterpolateScalarsBeforeMappingOn()
        mapper.ScalarVisibilityOn()

    def test_mapper_draws_what_the_stock_mapper_draws(self):
        surface = contour_ball().GetOutput()
        scenes = {
            "one color": lambda mapper, actor: None,
            "colored": self.color,
            "flat": lambda mapper, actor: actor.GetProperty().SetInterpolationToFlat(),
            "wireframe": lambda mapper, actor: actor.GetProperty().SetRepresentationToWireframe(),
            "moved": lambda mapper, actor: actor.SetPosition(5, 2, 1),
        }
        images = {}
        for name, change in scenes.items():
            with self.subTest(scene=name):
                stock = self.draw(vtkPolyDataMapper(), surface, change)
                images[name] = self.draw(vtkIsosurfaceMapper(), surface, change)
                self.assertGreater(int((stock != stock[0, 0]).any(axis=2).sum()), 3000)
                self.assertEqual(int((stock != images[name]).any(axis=2).sum()), 0)
        self.assertGreater(int((images["one color"] != images["colored"]).any(axis=2).sum()), 3000)

    @unittest.skipUnless(pyvista, "there is no PyVista")
    def test_pyvista_takes_and_plots_a_surface(self):
        contour = contour_ball()
        mesh = pyvista.wrap(contour.GetOutput())
        self.assertEqual(mesh.n_cells, contour.GetOutput().GetNumberOfPolys())
        self.assertAlmostEqual(mesh.volume / (4 / 3 * math.pi * RADIUS**3), 1, delta=0.01)
        self.assertEqual(mesh.n_open_edges, 0)
        image = mesh.plot(off_screen=True, return_img=True, window_size=SIZE)
        if isinstance(image, tuple):
            image = image[-1]
        self.assertEqual(image.shape[:2], SIZE[::-1])
        self.assertGreater(int((image != image[0, 0]).any(axis=2).sum()), 10000)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
