# SPDX-License-Identifier: BSD-3-Clause
"""The Metabuffer render view beside the stock one, in the same session: same images, pixel for
pixel, on any number of ranks, with everything that a user puts into an image.

Translucent surfaces are left out: on several ranks stock compositing of them fails, in any view of
the ParaView that these tests were made with.
"""
import glob

from paraview import simple

import plugin_testing as testing

SIZE = [301, 233]  # odd ones

# Position, focal point, view angle, parallel scale (0: perspective).
CAMERAS = {
    "far": ((38, 30, 57), (0, 0, 0), 30, 0),
    "near": ((0, 0, 45), (5, 3, 0), 20, 0),
    "inside": ((3, 0, 0), (10, 1, -3), 60, 0),
    "parallel": ((38, 30, 57), (0, 0, 0), 30, 12),
}


class MetabufferView(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wave = simple.Wavelet(WholeExtent=[-10, 10, -10, 10, -10, 10])
        cls.surface = simple.Contour(
            Input=cls.wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[120.0, 200.0]
        )
        cls.outline = simple.Outline(Input=cls.wave)
        cls.shared = {}

    def setUp(self):
        with_server = ("from_every_camera", "outlined", "fxaa", "time_budget")
        if testing.arguments.port and not any(name in self.id() for name in with_server):
            self.skipTest("seen without a server")

    def make_view(self, kind):
        view = simple.CreateView(kind)
        view.ViewSize = SIZE
        view.RemoteRenderThreshold = 0
        display = simple.Show(self.surface, view)
        simple.ColorBy(display, ("POINTS", "Normals", "Magnitude"))
        simple.ColorBy(display, ("POINTS", "RTData"))
        simple.Render(view)
        return view

    def get_view(self, kind, camera="far", size=None):
        """The one that all tests share, as it was at first."""
        if kind not in self.shared:
            view = self.make_view(kind)
            display = simple.GetRepresentation(self.surface, view)
            self.shared[kind] = view, [testing.Properties(proxy) for proxy in (view, display)]
        view, originals = self.shared[kind]
        for properties in originals:
            properties.give_back()
        view.ViewSize = size or SIZE
        self.place_camera(view, camera)
        return view

    def get_own_view(self, kind, camera="far"):
        view = self.make_view(kind)
        self.addCleanup(simple.Delete, view)
        self.place_camera(view, camera)
        return view

    def place_camera(self, view, name):
        position, focal_point, angle, scale = CAMERAS[name]
        view.CameraPosition, view.CameraFocalPoint = position, focal_point
        view.CameraViewUp, view.CameraViewAngle = (0, 1, 0), angle
        view.CameraParallelProjection = 1 if scale else 0
        view.CameraParallelScale = scale or 1

    def save(self, view, name, size=None):
        path = testing.output(name + ".png")
        simple.SaveScreenshot(path, view, ImageResolution=size or view.ViewSize)
        return testing.read_image(path)

    def check_same(self, image, expected):
        self.assertEqual(image.shape, expected.shape)
        self.assertEqual(int((image != expected).any(axis=2).sum()), 0)
        self.assertGreater(int((image != image[0, 0]).any(axis=2).sum()), 1000)

    def check_views(self, name, change=None, size=None, camera="far", get_view=None):
        """The views' images after the same change of both."""
        images = []
        for kind in ("RenderView", "MetabufferRenderView"):
            view = (get_view or self.get_view)(kind, camera)
            if change:
                change(view)
            images.append(self.save(view, name + kind, size))
        self.check_same(images[1], images[0])

    def require_several_ranks(self):
        if testing.arguments.ranks == 1:
            self.skipTest("a single rank draws as in the stock view")

    def test_same_image_from_every_camera(self):
        for camera in ("far", "inside") if testing.arguments.port else CAMERAS:
            with self.subTest(camera=camera):
                self.check_views("camera-" + camera, camera=camera)

    def test_same_image_with_and_without_fxaa_and_in_other_sizes(self):
        for fxaa in (0, 1):
            self.check_views("fxaa%d" % fxaa, lambda view: setattr(view, "UseFXAA", fxaa))
        # Larger than the window: ParaView joins several images.
        self.check_views("large", size=[777, 555])

    def test_same_image_with_annotations(self):
        def annotate(view):
            display = simple.GetRepresentation(self.surface, view)
            display.SetScalarBarVisibility(view, True)
            text = simple.Text(Text="Metabuffer")
            simple.Show(text, view)
            self.addCleanup(simple.Delete, text)
            view.AxesGrid.Visibility = 1
            view.CenterAxesVisibility = 1

        self.check_views("annotations", annotate, get_view=self.get_own_view)

    def test_same_image_with_several_representations_and_backgrounds(self):
        def change(view):
            simple.Show(self.outline, view)
            display = simple.GetRepresentation(self.surface, view)
            display.SetRepresentationType("Surface With Edges")
            view.UseColorPaletteForBackground = 0
            view.BackgroundColorMode = "Gradient"
            view.Background, view.Background2 = [0.1, 0.2, 0.5], [0.8, 0.7, 0.2]

        self.check_views("representations", change, get_view=self.get_own_view)

    def test_same_image_with_tone_mapping(self):
        def change(view):
            view.UseToneMapping = 1

        self.check_views("tone", change)

    def test_nothing_to_show(self):
        images = []
        for kind in ("RenderView", "MetabufferRenderView"):
            view = self.get_view(kind)
            simple.Hide(self.surface, view)
            images.append(self.save(view, "nothing" + kind))
        self.assertEqual(int((images[0] != images[1]).sum()), 0)

    def test_full_display_as_viewports_gives_the_same_image(self):
        def change(view):
            if "ViewportMode" in view.ListProperties():
                view.ViewportMode = "Full display"

        self.check_views("full-display", change)

    def test_compositing_by_icet_gives_the_same_image(self):
        def change(view):
            if "CompositeMode" in view.ListProperties():
                view.CompositeMode = "IceT"

        self.check_views("icet", change)

    def test_smooth_upsampling_shows_more_colors_than_blocks(self):
        self.require_several_ranks()
        view = self.get_view("MetabufferRenderView")
        view.UseFXAA = 0
        view.ResolutionMode = "Per rank"
        view.ResolutionDivisors = [4]
        blocks = self.save(view, "blocks")
        view.SmoothUpsampling = 1
        smooth = self.save(view, "smooth")
        count = [len({tuple(c) for row in image for c in row}) for image in (blocks, smooth)]
        self.assertGreater(count[1], 2 * count[0])

    def test_a_lower_resolution_is_the_small_stock_image_upsampled(self):
        self.require_several_ranks()
        size = [300, 240]
        for divisor in (2, 4, 5):
            with self.subTest(divisor=divisor):
                small = self.get_view("RenderView", size=[length // divisor for length in size])
                ours = self.get_view("MetabufferRenderView", size=size)
                for view in (small, ours):
                    view.UseFXAA = 0
                    view.OrientationAxesVisibility = 0
                ours.ResolutionMode = "Per rank"
                ours.ResolutionDivisors = [divisor]
                expected = self.save(small, "small%d" % divisor)
                image = self.save(ours, "upsampled%d" % divisor)
                expected = expected.repeat(divisor, axis=0).repeat(divisor, axis=1)
                self.check_same(image, expected)

    def test_full_resolution_comes_back(self):
        self.require_several_ranks()
        view = self.get_view("MetabufferRenderView")
        full = self.save(view, "full")
        view.ResolutionMode = "Per rank"
        view.ResolutionDivisors = [4, 2]
        coarse = self.save(view, "coarse")
        view.ResolutionMode = "Full"
        self.check_same(self.save(view, "full-again"), full)
        self.assertGreater(int((coarse != full).any(axis=2).sum()), 500)

    def test_frames_of_a_time_budget_are_coarse_until_the_camera_rests(self):
        self.require_several_ranks()
        view = self.get_view("MetabufferRenderView")
        view.UseFXAA = 0
        view.OrientationAxesVisibility = 0
        full = self.save(view, "still")
        view.ResolutionMode = "Time budget"
        view.FrameTimeBudget = 0.001
        images = []
        for _ in range(3):
            view.SMProxy.InteractiveRender()
            images.append(testing.read_window(view))
        # The coarsest resolution: in the middle of blocks of 16 pixels neighbors are equal.
        changes = (images[-1][:, 1:] != images[-1][:, :-1]).any(axis=2)
        self.assertGreater(int(changes[:, 15::16].sum()), 100)
        self.assertEqual(int(changes.sum()), int(changes[:, 15::16].sum()))
        self.check_same(self.save(view, "rests"), full)

    def test_supersampled_pixels_are_means_of_those_of_a_larger_image(self):
        self.require_several_ranks()
        size = [300, 240]
        large = self.get_view("RenderView", size=[2 * length for length in size])
        ours = self.get_view("MetabufferRenderView", size=size)
        for view in (large, ours):
            view.UseFXAA = 0
            view.OrientationAxesVisibility = 0
        ours.AntiAliasing = 1
        fine = self.save(large, "fine")
        image = self.save(ours, "supersampled")
        mean = (fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2]) / 4
        # The background is mixed in after the mean was rounded.
        self.assertLessEqual(float(abs(image - mean).max()), 1.5)
        self.assertGreater(int((image != fine[::2, ::2]).any(axis=2).sum()), 500)

    def test_animations_have_the_frames_of_the_stock_view(self):
        frames = {}
        for kind in ("RenderView", "MetabufferRenderView"):
            view = self.get_view(kind)
            scene = simple.GetAnimationScene()
            scene.PlayMode = "Sequence"
            scene.NumberOfFrames = 3
            # An object that moves.
            display = simple.GetRepresentation(self.surface, view)
            # "Position" before ParaView 5.13.
            place = "Translation" if hasattr(display, "Translation") else "Position"
            track = simple.GetAnimationTrack(place, index=0, proxy=display)
            first, last = simple.CompositeKeyFrame(), simple.CompositeKeyFrame()
            first.KeyTime, first.KeyValues = 0.0, [0.0]
            last.KeyTime, last.KeyValues = 1.0, [6.0]
            track.KeyFrames = [first, last]
            simple.SaveAnimation(
                testing.output(kind + ".png"), view, FrameWindow=[0, 2], ImageResolution=SIZE
            )
            simple.Delete(track)
            paths = sorted(glob.glob(testing.output(kind + ".*.png")))
            frames[kind] = [testing.read_image(path) for path in paths]
        self.assertEqual(len(frames["RenderView"]), 3)
        for ours, stock in zip(frames["MetabufferRenderView"], frames["RenderView"]):
            self.check_same(ours, stock)
        self.assertGreater(int((stock != frames["RenderView"][0]).any(axis=2).sum()), 500)

    def test_viewports_are_outlined_in_colors_of_their_own(self):
        self.require_several_ranks()
        view = self.get_view("MetabufferRenderView")
        view.UseFXAA = 0
        plain = self.save(view, "plain")
        view.ShowViewports = 1
        outlined = self.save(view, "outlined")
        changed = (plain != outlined).any(axis=2)
        colors = {tuple(color) for color in outlined[changed]}
        self.assertEqual(len(colors), testing.arguments.ranks)
        self.assertLess(int(changed.sum()), 0.2 * changed.size)

    def test_depths_are_those_of_the_stock_view(self):
        from vtkmodules.util.numpy_support import vtk_to_numpy

        depths = []
        for kind in ("RenderView", "MetabufferRenderView"):
            view = self.get_view(kind)
            simple.Render(view)
            view.CaptureDepthBuffer()
            captured = view.GetClientSideObject().GetCapturedZBuffer()
            depths.append(vtk_to_numpy(captured).copy())
        self.assertEqual(depths[0].shape, depths[1].shape)
        self.assertEqual(int((depths[0] != depths[1]).sum()), 0)
        self.assertGreater(int((depths[0] < 1).sum()), 1000)

    def test_selections_are_those_of_the_stock_view(self):
        counts = []
        for kind in ("RenderView", "MetabufferRenderView"):
            view = self.get_view(kind)
            simple.Render(view)
            simple.SelectSurfaceCells(Rectangle=[60, 60, 200, 150], View=view)
            selected = simple.ExtractSelection(Input=self.surface)
            counts.append(testing.count_cells(selected))
            simple.Delete(selected)
            simple.ClearSelection(self.surface)
        self.assertEqual(counts[0], counts[1])
        self.assertGreater(counts[0], 50)

    def test_the_view_is_one_of_the_session_and_goes(self):
        view = simple.CreateView("MetabufferRenderView")
        self.assertIn(view, simple.GetViews())
        self.assertEqual(view.GetXMLName(), "MetabufferRenderView")
        simple.Delete(view)


testing.run()
