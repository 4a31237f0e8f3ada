#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Images of surfaces without their hidden triangles, beside those of all triangles. Needs an X display."""
import unittest

import numpy
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401: makes the classes below draw
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData, vtkPlane
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import (vtkActor, vtkHardwareSelector, vtkPolyDataMapper, vtkProperty,
                                         vtkRenderer, vtkRenderWindow)

from scalable_isosurface import vtkIsosurfaceMapper, vtkStabbingContour

SIDE = 80


def make_image():
    """Layers behind layers, with noise."""
    place = numpy.arange(SIDE, dtype="f4") / SIDE - 0.5
    x, y, z = place[None, None, :], place[None, :, None], place[:, None, None]
    distance = numpy.sqrt(x * x + y * y + z * z)
    samples = numpy.sin(60 * distance + 3 * numpy.sin(20 * x) + 2 * numpy.sin(17 * y))
    samples = samples + numpy.random.default_rng(1).normal(0, 0.25, samples.shape)
    image = vtkImageData()
    image.SetDimensions(SIDE, SIDE, SIDE)
    image.SetOrigin(-SIDE / 2, -SIDE / 2, -SIDE / 2)
    array = numpy_to_vtk(samples.astype("f4").ravel(), deep=True)
    array.SetName("samples")
    image.GetPointData().SetScalars(array)
    return image


IMAGE = make_image()


def make_surface(isovalue):
    contour = vtkStabbingContour()
    contour.SetInputData(IMAGE)
    contour.SetValue(0, isovalue)
    contour.Update()
    return contour.GetOutput()


SURFACE = make_surface(0.1)


class Window:
    """A window that shows the surface, with or without its hidden triangles."""

    def __init__(self, culling, samples=0):
        self.mapper = vtkIsosurfaceMapper()
        self.mapper.SetOcclusionCulling(culling)
        self.mapper.SetInputDataObject(SURFACE)
        self.mapper.ScalarVisibilityOff()
        self.actor = vtkActor()
        self.actor.SetMapper(self.mapper)
        self.older_still = vtkProperty()
        self.older_still.SetColor(0.1, 0.3, 0.9)
        self.older = vtkProperty()
        self.older.SetColor(0.9, 0.8, 0.1)
        self.renderer = vtkRenderer()
        self.renderer.AddActor(self.actor)
        self.window = vtkRenderWindow()
        self.window.SetMultiSamples(samples)
        self.window.SetOffScreenRendering(True)
        self.window.SetSize(500, 400)
        self.window.AddRenderer(self.renderer)
        self.renderer.ResetCamera()

    def add_sphere(self, radius, opacity=1.0, center=(0, 0, 0)):
        source = vtkSphereSource()
        source.SetRadius(radius)
        source.SetCenter(center)
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(source.GetOutputPort())
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(1, 0.5, 0)
        actor.GetProperty().SetOpacity(opacity)
        self.renderer.AddActor(actor)

    def draw_portion(self, seconds=0.001):
        """Draws a part of an image that is not shown; whether it is whole."""
        self.renderer.ResetCameraClippingRange()
        self.window.SwapBuffersOff()
        vtkIsosurfaceMapper.BeginBudget(seconds)
        self.window.Render()
        self.window.SwapBuffersOn()
        return vtkIsosurfaceMapper.EndBudget()

    def draw_in_portions(self):
        """How many it took."""
        count = 1
        while not self.draw_portion():
            count += 1
            assert count < 1000, "it begins again and again"
        return count

    def show(self):
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        width, height = self.window.GetSize()
        pixels = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        return vtk_to_numpy(pixels).copy()


class Drawing(unittest.TestCase):

    def setUp(self):
        self.start()

    def start(self, samples=0):
        self.all = Window(vtkIsosurfaceMapper.NEVER, samples)
        self.some = Window(vtkIsosurfaceMapper.ALWAYS, samples)

    def change(self, change):
        for window in (self.all, self.some):
            change(window)

    def check(self, most):
        """The images are equal, and at most this share of the triangles was drawn."""
        expected, shown = self.all.show(), self.some.show()
        self.assertGreater(len(numpy.unique(expected)), 20, "nothing is shown")
        self.assertEqual(numpy.count_nonzero(expected != shown), 0)
        share = self.some.mapper.GetNumberOfDrawnTriangles() / self.all.mapper.GetNumberOfDrawnTriangles()
        self.assertLessEqual(share, most)
        return share

    def turn(self, window):
        window.renderer.GetActiveCamera().Azimuth(37)
        window.renderer.GetActiveCamera().Elevation(11)

    def test_every_view_is_the_same_with_fewer_triangles(self):
        self.assertGreater(SURFACE.GetNumberOfPolys(), 150000)
        self.assertEqual(self.check(1), 1, "nothing is known of the first image")
        for parallel in (False, True):
            self.change(lambda window: window.renderer.GetActiveCamera().SetParallelProjection(parallel))
            for _ in range(4):
                self.change(self.turn)
                self.check(1)
                self.check(0.85)

    def test_views_from_inside_and_through_the_near_plane(self):
        for depth in (0.9, 0.5, 0.1):
            def move(window):
                camera = window.renderer.GetActiveCamera()
                camera.SetPosition(0, 0, depth * SIDE / 2)
                camera.SetFocalPoint(0, 0, depth * SIDE / 2 - 1)
            self.change(move)
            self.check(1)
            self.change(lambda window: window.renderer.GetActiveCamera().Yaw(40))
            self.check(1)
            self.check(0.85)

    def test_zoomed_views_have_what_is_in_the_image_alone(self):
        self.check(1)
        self.change(lambda window: window.renderer.GetActiveCamera().Zoom(5))
        self.check(1)
        self.check(0.3)
        self.change(lambda window: window.renderer.GetActiveCamera().Yaw(2))
        self.check(0.4)

    def test_a_new_surface_a_new_size_and_a_moved_actor(self):
        self.check(1)
        self.check(0.85)
        self.change(lambda window: window.mapper.SetInputDataObject(make_surface(0.15)))
        self.check(0.85)
        self.change(lambda window: window.window.SetSize(301, 203))
        self.check(1)
        self.change(lambda window: window.actor.RotateX(50))
        self.change(lambda window: window.actor.SetScale(1, 0.6, 1.2))
        self.check(1)
        self.check(0.85)

    def test_clipped_flat_and_colored_surfaces(self):
        plane = vtkPlane()
        plane.SetNormal(0.3, 0.1, -1)
        self.change(lambda window: window.mapper.AddClippingPlane(plane))
        self.check(1)
        self.check(0.95)
        self.change(lambda window: window.mapper.RemoveAllClippingPlanes())
        self.check(1)
        self.change(lambda window: window.actor.GetProperty().SetInterpolationToFlat())
        self.check(1)

        def color(window):
            window.mapper.ScalarVisibilityOn()
            window.mapper.SetScalarModeToUsePointFieldData()
            window.mapper.SelectColorArray("Normals")
        self.change(color)
        self.check(1)
        self.check(0.85)

    def test_other_actors_before_and_behind(self):
        self.change(lambda window: window.add_sphere(SIDE / 4, 1, (SIDE / 3, 0, SIDE / 3)))
        self.change(lambda window: window.add_sphere(SIDE / 3, 0.4, (-SIDE / 3, 0, SIDE / 3)))
        for _ in range(3):
            self.check(1)
            self.change(self.turn)

    def test_what_does_not_hide_is_drawn_as_a_whole(self):
        def make_translucent(window):
            window.actor.GetProperty().SetOpacity(0.5)
        self.change(make_translucent)
        self.assertEqual(self.check(1), 1)
        self.assertEqual(self.check(1), 1)
        self.change(lambda window: window.actor.ForceOpaqueOn())
        self.assertEqual(self.check(1), 1)
        self.assertEqual(self.check(1), 1)
        self.change(lambda window: window.actor.ForceOpaqueOff())
        self.change(lambda window: window.actor.GetProperty().SetOpacity(1))
        self.change(lambda window: window.actor.GetProperty().SetRepresentationToWireframe())
        self.check(1)
        self.check(1)
        self.start(samples=4)
        self.check(1)
        self.check(1)

    def test_selections_are_those_of_all_triangles(self):
        found = []
        for window in (self.all, self.some):
            window.show()
            window.show()
            selector = vtkHardwareSelector()
            selector.SetRenderer(window.renderer)
            selector.SetArea(100, 100, 300, 300)
            selector.SetFieldAssociation(vtkDataObject.FIELD_ASSOCIATION_CELLS)
            nodes = selector.Select()
            found.append(vtk_to_numpy(nodes.GetNode(0).GetSelectionList()).copy())
        self.assertGreater(len(found[0]), 1000)
        self.assertTrue(numpy.array_equal(*found))
        self.check(0.85)

    def test_an_image_in_portions_is_that_of_one(self):
        self.check(1)
        for _ in range(3):
            self.change(self.turn)
            self.assertGreater(self.some.draw_in_portions(), 4)
            self.check(1)
            self.assertGreater(self.some.draw_in_portions(), 4)
            self.check(0.85)

    def test_what_is_not_whole_is_not_shown(self):
        before = self.some.show()
        self.turn(self.some)
        self.assertFalse(self.some.draw_portion())
        width, height = self.some.window.GetSize()
        pixels = vtkUnsignedCharArray()
        self.some.window.GetPixelData(0, 0, width - 1, height - 1, 1, pixels, 0)
        self.assertTrue(numpy.array_equal(vtk_to_numpy(pixels), before))

    def test_an_image_amid_portions_is_whole(self):
        self.check(1)
        self.change(self.turn)
        self.assertFalse(self.some.draw_portion())
        self.assertFalse(self.some.draw_portion())
        self.check(1)

    def test_a_change_amid_portions_is_seen(self):
        self.check(1)

        def dim(window):
            window.renderer.GetLights().GetItemAsObject(0).SetIntensity(0.4)
        changes = [
            self.turn,
            lambda window: window.actor.GetProperty().SetColor(0.2, 0.9, 0.4),
            lambda window: window.actor.RotateX(40),
            lambda window: window.renderer.SetBackground(0.3, 0.1, 0.5),
            lambda window: window.add_sphere(SIDE / 4, 1, (SIDE / 3, 0, SIDE / 3)),
            lambda window: window.mapper.SetInputDataObject(make_surface(0.15)),
            lambda window: window.window.SetSize(310, 290),
            dim,
            self.add_plane,
            lambda window: window.plane.SetOrigin(0, 5, 0),
            lambda window: window.actor.SetProperty(window.older),
            lambda window: window.actor.SetBackfaceProperty(window.older_still),
        ]
        for change in changes:
            self.assertFalse(self.some.draw_portion())
            self.change(change)
            self.some.draw_in_portions()
            self.check(1)
            self.some.draw_in_portions()
            self.change(change)
            self.check(1)

    def add_plane(self, window):
        window.plane = vtkPlane()
        window.plane.SetNormal(0, 1, 0)
        window.mapper.AddClippingPlane(window.plane)

    def test_stereo_images_in_portions_come_to_an_end(self):
        def show_both_eyes(window):
            window.window.StereoRenderOn()
            window.window.SetStereoTypeToAnaglyph()
        self.change(show_both_eyes)
        self.check(1)
        self.change(self.turn)
        self.assertLess(self.some.draw_in_portions(), 20)
        self.check(1)

    def test_buffers_of_a_large_surface_are_written_in_portions(self):
        sphere = vtkSphereSource()
        sphere.SetThetaResolution(1500)
        sphere.SetPhiResolution(1000)
        sphere.SetRadius(SIDE / 2)
        sphere.Update()  # 3 million triangles, 1.5 million points
        surface = sphere.GetOutput()
        heights = numpy_to_vtk(vtk_to_numpy(surface.GetPoints().GetData())[:, 1].copy(), deep=True)
        heights.SetName("heights")
        surface.GetPointData().AddArray(heights)
        stock = Window(vtkIsosurfaceMapper.NEVER)
        stock.mapper = vtkPolyDataMapper()
        stock.mapper.ScalarVisibilityOff()
        stock.actor.SetMapper(stock.mapper)
        for window in (stock, self.all, self.some):
            window.mapper.SetInputDataObject(surface)
        # Memory for places, normals and numbers of points, and their two, two and three portions.
        for _ in range(10):
            self.assertFalse(self.all.draw_portion(0))
            self.assertFalse(self.some.draw_portion(0))
        self.assertTrue(self.all.draw_portion(0))
        self.some.draw_in_portions()
        self.check(1)

        def check_beside_stock():
            self.assertEqual(numpy.count_nonzero(stock.show() != self.some.show()), 0)
        check_beside_stock()

        for window in (stock, self.all, self.some):
            window.mapper.ScalarVisibilityOn()
            window.mapper.SetScalarModeToUsePointFieldData()
            window.mapper.SelectColorArray("heights")
            window.mapper.InterpolateScalarsBeforeMappingOn()
            window.mapper.SetScalarRange(-SIDE / 2, SIDE / 2)
        self.some.draw_in_portions()
        check_beside_stock()
        for window in (stock, self.all, self.some):
            window.mapper.ScalarVisibilityOff()

        # What is unwritten is dropped for another surface, by VTK's own buffers, and with the window's.
        self.some.draw_portion(0)
        self.some.mapper.SetInputDataObject(SURFACE)
        self.some.draw_portion(0)
        self.some.mapper.SetInputDataObject(surface)
        self.some.draw_portion(0)
        for window in (stock, self.some):
            window.actor.GetProperty().SetRepresentationToWireframe()
        check_beside_stock()
        for window in (stock, self.some):
            window.actor.GetProperty().SetRepresentationToSurface()
        check_beside_stock()
        self.some.mapper.Modified()
        self.some.draw_portion(0)
        self.some.window.Finalize()
        check_beside_stock()

    def test_two_surfaces_in_portions(self):
        other = make_surface(-0.3)

        def add(window):
            mapper = vtkIsosurfaceMapper()
            mapper.SetOcclusionCulling(window.mapper.GetOcclusionCulling())
            mapper.SetInputDataObject(other)
            mapper.ScalarVisibilityOff()
            actor = vtkActor()
            actor.SetMapper(mapper)
            actor.SetPosition(SIDE / 3, 0, 0)
            actor.GetProperty().SetColor(1, 0.5, 0)
            window.renderer.AddActor(actor)
        self.change(add)
        self.check(1)
        for _ in range(3):
            self.change(self.turn)
            self.assertGreater(self.some.draw_in_portions(), 8)
            self.check(1)


if __name__ == "__main__":
    unittest.main()
