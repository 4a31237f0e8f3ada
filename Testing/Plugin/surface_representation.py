# SPDX-License-Identifier: BSD-3-Clause
"""The representation that views give surfaces of this plugin beside the stock one, in the same
session: same pictures, pixel for pixel, on any number of ranks and in both views.

Translucent surfaces are compared on one rank alone: stock compositing of them fails on several ranks
of the ParaView that these tests were made with.
"""
import unittest

from paraview import simple

import plugin_testing as testing

SIZE = [301, 233]  # odd ones
OURS = "IsosurfaceRepresentation"
STOCK = "GeometryRepresentation"
VIEWS = ("RenderView", "MetabufferRenderView")


def set_type(name):
    return lambda display, view: display.SetRepresentationType(name)


def color_by(name, component=None):
    def change(display, view):
        simple.ColorBy(display, ("POINTS", name) + ((component,) if component else ()))
        display.RescaleTransferFunctionToDataRange(False, True)

    return change


def color_on_a_log_scale(display, view):
    color_by("Normals", "Magnitude")(display, view)
    table = simple.GetColorTransferFunction("Normals", display, separate=True)
    table.RescaleTransferFunction(0.5, 2.0)
    table.MapControlPointsToLogSpace()
    table.UseLogScale = 1


def color_by_categories(display, view):
    color_by("RTData")(display, view)
    table = simple.GetColorTransferFunction("RTData", display, separate=True)
    table.InterpretValuesAsCategories = 1
    table.Annotations = ["120", "low", "200", "high"]
    table.IndexedColors = [1, 0, 0, 0, 0, 1]


def set_properties(**values):
    def change(display, view):
        for name, value in values.items():
            setattr(display, name, value)

    return change


SCENES = {
    "as shown": lambda display, view: None,
    "one color": lambda display, view: simple.ColorBy(display, None),
    "wireframe": set_type("Wireframe"),
    "points": set_type("Points"),
    "edges": set_type("Surface With Edges"),
    "outline": set_type("Outline"),
    "feature edges": set_type("Feature Edges"),
    "component": color_by("Normals", "Y"),
    "magnitude": color_by("Normals", "Magnitude"),
    "global ids": color_by("GlobalIds"),
    "log scale": color_on_a_log_scale,
    "categories": color_by_categories,
    "no texture of colors": set_properties(InterpolateScalarsBeforeMapping=0),
    "direct colors": set_properties(MapScalars=0),
    "flat": set_properties(Interpolation="Flat"),
    "shiny": set_properties(Specular=0.8, Ambient=0.2, DiffuseColor=[0.2, 0.9, 0.4]),
    "moved": set_properties(
        Position=[3, 1, 0], Scale=[1, 0.5, 1.2], Orientation=[10, 30, 0], Origin=[1, 2, 3]
    ),
    "triangulated": set_properties(Triangulate=1),
    "back in another color": set_properties(
        BackfaceRepresentation="Surface", BackfaceDiffuseColor=[1, 0, 0]
    ),
    "back culled": set_properties(BackfaceRepresentation="Cull Backface"),
    "coordinates as they are": set_properties(CoordinateShiftScaleMethod="Disable"),
    "coordinates shifted": set_properties(CoordinateShiftScaleMethod="Auto Shift Scale"),
    "coordinates of the camera": set_properties(
        CoordinateShiftScaleMethod="Focal Point Shift Scale"
    ),
    "data axes": lambda display, view: setattr(display.DataAxesGrid, "GridAxesVisibility", 1),
}

IN_BOTH_VIEWS = ("as shown", "one color", "wireframe", "edges", "categories", "moved")


class SurfaceRepresentation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wave = simple.Wavelet(WholeExtent=[-10, 10, -10, 10, -10, 10])
        # Whole numbers give degenerate triangles.
        cls.surface = simple.StabbingContour(
            Input=cls.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[120.0, 200.0]
        )

    def show(self, kind, representation, surface=None):
        view = simple.CreateView(kind)
        self.addCleanup(simple.Delete, view)
        view.ViewSize = SIZE
        view.RemoteRenderThreshold = 0
        display = simple.Show(surface or self.surface, view, representation)
        self.assertEqual(display.SMProxy.GetXMLName(), representation)
        simple.Render(view)
        view.CameraPosition, view.CameraFocalPoint = (38, 30, 57), (0, 0, 0)
        view.CameraViewUp, view.CameraViewAngle = (0, 1, 0), 30
        return view, display

    def save(self, view, name):
        path = testing.output(name.replace(" ", "-") + ".png")
        simple.SaveScreenshot(path, view, ImageResolution=view.ViewSize)
        return testing.read_picture(path)

    def count_different(self, one, other):
        self.assertEqual(one.shape, other.shape)
        return int((one != other).any(axis=2).sum())

    def compare(self, kind, name, change, surface=None, least=300):
        pictures = []
        for representation in (STOCK, OURS):
            view, display = self.show(kind, representation, surface)
            change(display, view)
            pictures.append(self.save(view, kind + name + representation))
        self.assertEqual(self.count_different(*pictures), 0)
        self.assertGreaterEqual(int((pictures[0] != pictures[0][0, 0]).any(axis=2).sum()), least)
        return pictures[0]

    def test_is_what_show_gives(self):
        for kind in VIEWS:
            view = simple.CreateView(kind)
            self.addCleanup(simple.Delete, view)
            display = simple.Show(self.surface, view)
            self.assertEqual(display.SMProxy.GetXMLName(), OURS)
            self.assertEqual(display.Representation, "Surface")
            distributed = simple.DistributeIsosurface(Input=self.surface)
            self.addCleanup(simple.Delete, distributed)
            self.assertEqual(simple.Show(distributed, view).SMProxy.GetXMLName(), OURS)
            others = simple.Smooth(Input=self.surface)
            self.addCleanup(simple.Delete, others)
            self.assertEqual(simple.Show(others, view).SMProxy.GetXMLName(), STOCK)

    def test_offers_the_stock_types_and_properties(self):
        view, ours = self.show("RenderView", OURS)
        stock = simple.Show(simple.Smooth(Input=self.surface), view)
        self.assertEqual(ours.SMProxy.GetXMLName(), OURS)
        for name in stock.ListProperties():
            self.assertIn(name, ours.ListProperties())
        self.assertEqual(
            sorted(ours.GetProperty("RepresentationTypesInfo")),
            sorted(stock.GetProperty("RepresentationTypesInfo")),
        )

    def test_same_pictures_of_all_scenes(self):
        for name, change in SCENES.items():
            for kind in VIEWS if name in IN_BOTH_VIEWS else VIEWS[:1]:
                with self.subTest(view=kind, scene=name):
                    self.compare(kind, name, change)

    def test_same_pictures_of_translucent_surfaces(self):
        if testing.arguments.ranks > 1:
            self.skipTest("stock translucency fails on several ranks")
        self.compare("RenderView", "translucent", set_properties(Opacity=0.4))

    def test_same_pictures_of_other_data(self):
        def smooth(**options):
            return simple.StabbingContour(
                Input=self.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[130.5], **options
            )

        surfaces = {
            "polygons": smooth(GenerateTriangles=0),
            "no normals": smooth(ComputeNormals=0),
            "no scalars": smooth(ComputeScalars=0),
            "no degenerate triangles": smooth(DropDegenerateTriangles=1),
            "empty": simple.StabbingContour(
                Input=self.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[1e6]
            ),
            "another filter's": simple.GroupDatasets(Input=[smooth(), self.surface]),
            "volume": self.wave,
        }
        for name, surface in surfaces.items():
            with self.subTest(surface=name):
                self.compare("RenderView", name, SCENES["as shown"], surface, least=0)

    def test_hidden_blocks_are_hidden(self):
        group = simple.GroupDatasets(Input=[self.surface, self.wave])
        self.addCleanup(simple.Delete, group)

        def hide_one(display, view):
            display.BlockSelectors = ["/Root/*[1]"]

        shown = self.compare("RenderView", "one-block", hide_one, group)
        both = self.compare("RenderView", "blocks", SCENES["as shown"], group)
        self.assertGreater(self.count_different(shown, both), 300)

    def test_a_new_isovalue_shows_the_new_surface(self):
        surface = simple.StabbingContour(
            Input=self.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[120.0]
        )
        self.addCleanup(simple.Delete, surface)
        views = [self.show("RenderView", representation, surface)[0]
                 for representation in (STOCK, OURS)]
        last = None
        for isovalue in (120.0, 150.0, 180.25, 120.0):
            surface.Isosurfaces = [isovalue]
            pictures = [self.save(view, f"{isovalue}-{n}") for n, view in enumerate(views)]
            self.assertEqual(self.count_different(*pictures), 0)
            if last is not None:
                self.assertGreater(self.count_different(last, pictures[1]), 300)
            last = pictures[1]

    def test_selections_are_those_of_the_stock_representation(self):
        for select in (simple.SelectSurfaceCells, simple.SelectSurfacePoints):
            found, pictures = [], []
            for representation in (STOCK, OURS):
                view, _ = self.show("RenderView", representation)
                simple.Render(view)
                select(Rectangle=[60, 60, 200, 150], View=view)
                extracted = simple.ExtractSelection(Input=self.surface)
                extracted.UpdatePipeline()
                information = extracted.GetDataInformation()
                found.append((information.GetNumberOfCells(), information.GetNumberOfPoints(),
                              information.GetBounds()))
                pictures.append(self.save(view, "selected-" + representation))
                simple.Delete(extracted)
                simple.ClearSelection(self.surface)
            self.assertEqual(found[0], found[1])
            self.assertGreater(found[0][0], 50)
            self.assertEqual(self.count_different(*pictures), 0)

    def read_window(self, view):
        """What the view's window shows, without drawing again."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        window = view.GetRenderWindow()
        columns, rows = window.GetSize()
        pixels = vtkUnsignedCharArray()
        window.GetPixelData(0, 0, columns - 1, rows - 1, 1, pixels, 0)
        return vtk_to_numpy(pixels).reshape(rows, columns, 3).astype(int)

    def test_while_the_camera_moves_a_thinned_surface_is_shown(self):
        surface = simple.StabbingContour(
            Input=self.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0]
        )
        self.addCleanup(simple.Delete, surface)
        for kind in VIEWS:
            view, display = self.show(kind, OURS, surface)
            view.UseFXAA, view.OrientationAxesVisibility = 0, 0
            view.LODThreshold, view.LODResolution = 0, 0.05
            full = self.save(view, "still")
            view.SMProxy.InteractiveRender()
            moving = self.read_window(view)
            covered = [int((picture != picture[0, 0]).any(axis=2).sum())
                       for picture in (full, moving)]
            self.assertGreater(covered[1], 0.8 * covered[0])
            self.assertLess(covered[1], 1.2 * covered[0])
            if moving.shape == full.shape:
                self.assertGreater(self.count_different(full, moving), 100)
            self.assertEqual(self.count_different(self.save(view, "rests"), full), 0)


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, required=True)
    parser.add_argument("--port", type=int, help="of a pvserver; without it there is none")


testing.parse_arguments(add_arguments)
if testing.arguments.port:
    simple.Connect("localhost", testing.arguments.port)
testing.load_plugin()
testing.run()
