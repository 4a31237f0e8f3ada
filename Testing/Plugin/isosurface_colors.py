# SPDX-License-Identifier: BSD-3-Clause
"""Several isosurfaces have a color and a line in the legend each, and keep them when isovalues change.

The oracle of images is a stock Contour for each isovalue, in one solid color each."""
import functools
import runpy

from paraview import simple, smstate

import plugin_testing as testing

SIZE = [301, 233]
ISOVALUES = [100.0, 150.5, 210.1]
VIEWS = ("RenderView", "MetabufferRenderView")
RED, GREEN = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]


def on_the_client(test):
    """A test of what the client keeps, whatever the number of ranks."""

    @functools.wraps(test)
    def on_one_rank(self):
        if testing.arguments.ranks > 1:
            self.skipTest("the client keeps color maps; one process is enough")
        test(self)

    return on_one_rank


def draw(view):
    simple.Render(view)
    return testing.read_window(view)


def read_categories(display):
    """Isovalue, text, color and opacity of each category, in the order of the legend."""
    table = display.LookupTable
    texts, colors = list(table.Annotations), list(table.IndexedColors)
    return [
        (float(texts[2 * n]), texts[2 * n + 1], colors[3 * n : 3 * n + 3], table.IndexedOpacities[n])
        for n in range(len(texts) // 2)
    ]


class IsosurfaceColors(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wave = simple.Wavelet(WholeExtent=[-10, 10, -10, 10, -10, 10])
        cls.stock = {}

    def setUp(self):
        self.surface = self.contour(ISOVALUES)

    def make_view(self, kind="RenderView"):
        view = self.make_lasting_view(kind)
        self.addCleanup(simple.Delete, view)
        return view

    def make_lasting_view(self, kind):
        view = simple.CreateView(kind)
        view.ViewSize, view.UseFXAA, view.OrientationAxesVisibility = SIZE, 0, 0
        view.RemoteRenderThreshold = 0
        simple.Render(view)  # the first one of a session sets the camera
        view.CameraPosition, view.CameraFocalPoint = (38, 30, 57), (0, 0, 0)
        view.CameraViewUp, view.CameraViewAngle = (0, 1, 0), 30
        return view

    def contour(self, isovalues):
        return simple.Isosurface(
            Input=self.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=isovalues
        )

    def draw_stock(self, isovalues, colors, kind="RenderView"):
        """In a view that all tests share, which has as many contours as have been asked for."""
        if kind not in self.stock:
            self.stock[kind] = self.make_lasting_view(kind), []
        view, shown = self.stock[kind]
        while len(shown) < len(isovalues):
            contour = simple.Contour(Input=self.wave, ContourBy=["POINTS", "RTData"])
            display = simple.Show(contour, view, "GeometryRepresentation")
            simple.ColorBy(display, None)
            shown.append((contour, display))
        for n, (contour, display) in enumerate(shown):
            display.Visibility = 1 if n < len(isovalues) else 0
            if display.Visibility:
                contour.Isosurfaces = [isovalues[n]]
                display.AmbientColor = display.DiffuseColor = colors[n]
        return draw(view)

    def check_same(self, image, expected):
        # A category's color is rounded to 8 bits before it is lit. Stock images of a server differ from each other.
        different = (abs(image - expected) > 3).any(axis=2).sum()
        self.assertLessEqual(int(different), 150 if testing.arguments.port else 5)
        self.assertGreater(int((image != image[0, 0]).any(axis=2).sum()), 3000)

    def check(self, view, display, isovalues, kind="RenderView"):
        image = draw(view)
        categories = read_categories(display)
        self.assertEqual([category[0] for category in categories], isovalues)
        # Else the panel of the color map would look for values, and ask the user if a rank has none.
        self.assertTrue(display.LookupTable.AnnotationsInitialized)
        colors = [category[2] for category in categories]
        self.assertEqual(len({tuple(color) for color in colors}), len(isovalues))
        self.check_same(image, self.draw_stock(isovalues, colors, kind))
        return categories

    def test_each_isosurface_has_a_color_and_a_line_in_the_legend(self):
        for kind in VIEWS:
            with self.subTest(view=kind):
                view = self.make_view(kind)
                display = simple.Show(self.surface, view)
                categories = self.check(view, display, ISOVALUES, kind)
                self.assertEqual([category[1] for category in categories], ["100", "150.5", "210.1"])

    def test_isovalues_that_stay_keep_their_looks_and_one_that_moves_too(self):
        view = self.make_view()
        display = simple.Show(self.surface, view)
        first = self.check(view, display, ISOVALUES)
        colors = [category[2] for category in first]
        for isovalues, expected in (
            ([100.0, 170.0, 210.1], colors),
            ([210.1, 100.0], [colors[2], colors[0]]),
            ([210.1, 100.0, 130.0], [colors[2], colors[0], colors[1]]),
        ):
            self.surface.Isosurfaces = isovalues
            changed = self.check(view, display, isovalues)
            self.assertEqual([category[2] for category in changed], expected)

    @on_the_client
    def test_what_a_user_chose_is_kept(self):
        view = self.make_view()
        display = simple.Show(self.surface, view)
        simple.Render(view)
        table = display.LookupTable
        table.IndexedColors = [*RED, *GREEN, 0.0, 0.0, 1.0]
        table.Annotations = ["100", "crust", "150.5", "mantle, 150.5", "210.1", "core"]
        table.IndexedOpacities = [0.25, 1, 1]
        self.surface.Isosurfaces = [100.0, 160.0]
        simple.Render(view)
        self.assertEqual(
            read_categories(display),
            [(100, "crust", RED, 0.25), (160, "mantle, 160", GREEN, 1)],
        )

    @on_the_client
    def test_one_isosurface_looks_as_without_colors_and_has_no_legend(self):
        surface = self.contour([150.5])
        view = self.make_view()
        display = simple.Show(surface, view)
        display.SetScalarBarVisibility(view, True)
        self.check(view, display, [150.5])
        self.assertEqual(read_categories(display), [(150.5, "150.5", [1, 1, 1], 1)])
        self.assertFalse(display.IsScalarBarVisible(view))

    @on_the_client
    def test_the_legend_goes_where_the_colors_are(self):
        view = self.make_view()
        display = simple.Show(self.surface, view)
        display.SetScalarBarVisibility(view, True)
        simple.Render(view)
        self.assertTrue(display.IsScalarBarVisible(view))
        shared = simple.GetColorTransferFunction("RTData")
        self.assertFalse(shared.InterpretValuesAsCategories)
        legend = simple.GetScalarBar(display.LookupTable, view)
        self.assertEqual(legend.Title, "Isosurfaces")  # a slice may have one of the array's name
        self.assertFalse(simple.GetScalarBar(shared, view).Visibility)

    @on_the_client
    def test_the_color_map_of_the_array_comes_back(self):
        stock = self.make_view()
        simple.Show(self.surface, stock, "GeometryRepresentation")
        expected = draw(stock)
        view = self.make_view()
        display = simple.Show(self.surface, view)
        simple.Render(view)
        display.IsosurfaceColors = 0
        self.check_same(draw(view), expected)
        self.assertFalse(display.UseSeparateColorMap)
        display.IsosurfaceColors = 1
        simple.Render(view)
        self.assertEqual(len(read_categories(display)), 3)
        simple.ColorBy(display, ("POINTS", "Normals"), separate=True)
        simple.Render(view)
        self.assertEqual(display.LookupTable, simple.GetColorTransferFunction("Normals"))
        simple.ColorBy(display, None)
        plain = draw(view)
        self.assertTrue((plain == draw(view)).all())

    @on_the_client
    def test_states_have_the_same_image(self):
        simple.ResetSession()  # whose views would be in the states, too
        self.setUpClass()
        self.setUp()
        view = self.make_view()
        display = simple.Show(self.surface, view)
        simple.Render(view)
        display.LookupTable.IndexedColors = [*RED, *GREEN, 0.0, 0.0, 1.0]
        expected = draw(view)
        simple.SaveState(testing.output("colors.pvsm"))
        with open(testing.output("colors.py"), "w", encoding="utf-8") as file:
            file.write(smstate.get_state())
        self.check_same(expected, self.draw_stock(ISOVALUES, [RED, GREEN, [0.0, 0.0, 1.0]]))
        for load in (
            lambda: self.load_state(testing.output("colors.pvsm")),
            lambda: runpy.run_path(testing.output("colors.py")),
        ):
            simple.ResetSession()
            load()
            loaded = simple.GetActiveView()
            loaded.RemoteRenderThreshold, loaded.UseFXAA = 0, 0
            self.check_same(draw(loaded), expected)

    def make_ct(self):
        return simple.Calculator(
            Input=self.wave, Function="(RTData-150)*10", ResultArrayName="HU", ResultArrayType="Float"
        )

    @on_the_client
    def test_tissues_of_a_ct_have_their_names_colors_and_opacities(self):
        view = self.make_view()
        ct = simple.Isosurface(
            Input=self.make_ct(), ContourBy=["POINTS", "HU"], Isosurfaces=[-300.0]
        )
        display = simple.Show(ct, view)
        simple.Render(view)
        skin = [0.93, 0.76, 0.65]
        self.assertEqual(read_categories(display), [(-300, "Skin, -300 HU", skin, 0.35)])
        self.assertFalse(display.LookupTable.EnableOpacityMapping)
        ct.Isosurfaces = [-300.0, 300.0, 226.0]
        simple.Render(view)
        texts = [category[1] for category in read_categories(display)]
        self.assertEqual(texts, ["Skin, -300 HU", "Bone, 300 HU", "226 HU"])
        ct.Isosurfaces = [-300.0, 310.0]
        simple.Render(view)
        bone = [0.95, 0.91, 0.80]
        self.assertEqual(
            read_categories(display),
            [(-300, "Skin, -300 HU", skin, 0.35), (310, "Bone, 310 HU", bone, 1)],
        )

    def test_the_first_image_has_bone_behind_skin_as_behind_a_stock_surface(self):
        ct = self.make_ct()
        view = self.make_view()
        surface = simple.Isosurface(
            Input=ct, ContourBy=["POINTS", "HU"], Isosurfaces=[-300.0, 300.0]
        )
        display = simple.Show(surface, view)
        image = draw(view)
        stock = self.make_view()
        for isovalue, (_, _, color, opacity) in zip((-300, 300), read_categories(display)):
            contour = simple.Contour(Input=ct, ContourBy=["POINTS", "HU"], Isosurfaces=[isovalue])
            shown = simple.Show(contour, stock, "GeometryRepresentation")
            simple.ColorBy(shown, None)
            shown.AmbientColor = shown.DiffuseColor = color
            shown.Opacity = opacity
        self.check_same(image, draw(stock))
        display.LookupTable.EnableOpacityMapping = 0
        self.assertGreater(int((abs(image - draw(view)) > 3).any(axis=2).sum()), 3000)

    def test_a_surface_that_is_opened_from_a_file_has_the_same_colors(self):
        path = testing.output("colors.eix")
        view = self.make_view()
        display = simple.Show(self.surface, view)
        simple.Render(view)
        expected = read_categories(display)
        simple.Hide(self.surface, view)
        simple.SaveData(path, proxy=self.surface)
        file = simple.OpenDataFile(path)
        display = simple.Show(file, view)
        simple.Render(view)
        self.assertEqual(read_categories(display), expected)
        simple.SaveData(path, proxy=self.contour([150.5, 210.1]))
        simple.ReloadFiles(file)
        simple.Render(view)
        self.assertEqual(read_categories(display), expected[1:])

    def test_a_distributed_surface_has_the_same_colors(self):
        view = self.make_view()
        display = simple.Show(simple.DistributeIsosurface(Input=self.surface), view)
        self.check(view, display, ISOVALUES)


testing.run()
