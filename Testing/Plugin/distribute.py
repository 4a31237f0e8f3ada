# SPDX-License-Identifier: BSD-3-Clause
"""Distribute Isosurface in ParaView: the contour's surface and image, in compact parts. On any
number of ranks, and through a server (--port)."""

from paraview import simple

import plugin_testing


class DistributeIsosurface(plugin_testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.volume = plugin_testing.open_volume("wave.bvol")
        cls.contour = simple.Isosurface(
            Input=cls.volume, ContourBy=["POINTS", "RTData"], Isosurfaces=[plugin_testing.ISOVALUE]
        )
        cls.triangles = plugin_testing.count_expected_triangles()

    def setUp(self):
        if plugin_testing.arguments.port and "image" not in self.id():
            self.skipTest("seen without a server")
        self.contour.Isosurfaces = [plugin_testing.ISOVALUE]

    def distribute(self, **properties):
        surface = simple.DistributeIsosurface(Input=self.contour, **properties)
        self.addCleanup(simple.Delete, surface)
        return surface

    def test_surface_is_the_contours_in_every_mode(self):
        for mode in ("Lossless", "Bounded", "Smallest"):
            with self.subTest(mode=mode):
                surface = self.distribute(Mode=mode)
                self.assertEqual(plugin_testing.count_cells(surface), self.triangles)
                self.assertIsNotNone(surface.PointData["GlobalIds"])
                self.assertIsNotNone(surface.PointData["Normals"])
                self.assertEqual(surface.PointData["RTData"].GetRange(), (150.0, 150.0))

    def test_contour_makes_no_surface_on_several_ranks(self):
        contour = simple.Isosurface(
            Input=self.volume, ContourBy=["POINTS", "RTData"], Isosurfaces=[plugin_testing.ISOVALUE]
        )
        surface = simple.DistributeIsosurface(Input=contour)
        self.assertEqual(plugin_testing.count_cells(surface), self.triangles)
        own = contour.GetDataInformation().GetNumberOfCells()
        self.assertEqual(own, self.triangles if plugin_testing.arguments.ranks == 1 else 0)

    def test_every_rank_tells_its_cost(self):
        ranks = plugin_testing.arguments.ranks
        if ranks == 1:
            self.skipTest("nothing travels")
        surface = self.distribute(DrawingRanks=2)
        self.assertEqual(plugin_testing.count_cells(surface), self.triangles)
        costs = plugin_testing.read_costs(surface)
        self.assertEqual(len(costs), ranks)
        triangles = [int(row["Triangles"]) for row in costs]
        self.assertEqual(sum(triangles), self.triangles)
        self.assertEqual(triangles[2:], [0] * (ranks - 2))
        self.assertLess(max(triangles), 0.6 * self.triangles)
        for name in ("RawBytes", "EncodedBytes", "SentBytes"):
            self.assertGreater(sum(int(row[name]) for row in costs), 0)

    def test_surface_follows_the_contour(self):
        surface = self.distribute()
        self.assertEqual(plugin_testing.count_cells(surface), self.triangles)
        self.contour.Isosurfaces = [plugin_testing.OTHER_ISOVALUE]
        expected = plugin_testing.count_expected_triangles(plugin_testing.OTHER_ISOVALUE)
        self.assertEqual(plugin_testing.count_cells(surface), expected)

    def test_surface_follows_the_time(self):
        path = plugin_testing.output("series.bvol")
        simple.SaveData(path, proxy=plugin_testing.make_series(), WriteAllTimeSteps=1)
        contour = simple.Isosurface(
            Input=simple.OpenDataFile(path), ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0]
        )
        surface = simple.DistributeIsosurface(Input=contour)
        for time in (0, 3, 1):
            surface.UpdatePipeline(time)
            expected = plugin_testing.count_expected_triangles(150.0 - 10 * time)
            self.assertEqual(surface.GetDataInformation().GetNumberOfCells(), expected)

    def test_other_filters_follow(self):
        surface = self.distribute()
        clip = simple.Clip(Input=surface, ClipType="Plane")
        self.assertGreater(plugin_testing.count_cells(clip), 0)
        self.assertLess(plugin_testing.count_cells(clip), self.triangles)

    def test_metabuffer_image_is_that_of_the_contour(self):
        view = simple.CreateView("MetabufferRenderView")
        view.ViewSize = [301, 233]
        view.OrientationAxesVisibility = 0
        view.RemoteRenderThreshold = 0
        images = {}
        surfaces = {
            "contour": self.contour,
            "exact": self.distribute(NormalError=0),
            "lossless": self.distribute(),
        }
        for name, surface in surfaces.items():
            simple.ColorBy(simple.Show(surface, view), None)
            if name == "contour":
                simple.ResetCamera(view)
            path = plugin_testing.output(name + ".png")
            simple.SaveScreenshot(path, view, ImageResolution=view.ViewSize)
            images[name] = plugin_testing.read_image(path)
            simple.Hide(surface, view)
        simple.Delete(view)
        contour = images["contour"]
        self.assertGreater(int((contour != contour[0, 0]).any(axis=2).sum()), 10000)
        # The same triangles in another order: who of equally near ones is seen, is by chance.
        difference = abs(images["exact"] - contour).max(axis=2)
        self.assertLessEqual(int(difference.max()), 1)
        self.assertLessEqual(int((difference > 0).sum()), 20)
        difference = abs(images["lossless"] - contour).max(axis=2)
        self.assertLess((difference > 1).mean(), 0.02)


plugin_testing.run()
