# SPDX-License-Identifier: BSD-3-Clause
"""Distribute Isosurface in ParaView: the contour's surface and image, in compact parts. On any
number of ranks, and through a server (--port)."""
import csv
import unittest

from paraview import simple

import plugin_testing as testing


class DistributeIsosurface(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.volume = testing.open_volume("wave.bvol")
        cls.contour = simple.StabbingContour(
            Input=cls.volume, ContourBy=["POINTS", "RTData"], Isosurfaces=[testing.ISOVALUE]
        )
        cls.triangles = testing.count_expected_triangles()

    def setUp(self):
        if testing.arguments.port and "image" not in self.id():
            self.skipTest("seen without a server")
        self.contour.Isosurfaces = [testing.ISOVALUE]

    def distribute(self, **properties):
        surface = simple.DistributeIsosurface(Input=self.contour, **properties)
        self.addCleanup(simple.Delete, surface)
        return surface

    def read_costs(self, surface):
        path = testing.output("costs.csv")
        simple.SaveData(path, proxy=surface, FieldAssociation="Field Data")
        with open(path, newline="") as table:
            return list(csv.DictReader(table))

    def test_surface_is_the_contours_in_every_mode(self):
        for mode in ("Lossless", "Bounded", "Smallest"):
            with self.subTest(mode=mode):
                surface = self.distribute(Mode=mode)
                self.assertEqual(testing.count_cells(surface), self.triangles)
                self.assertIsNotNone(surface.PointData["GlobalIds"])
                self.assertIsNotNone(surface.PointData["Normals"])
                self.assertEqual(surface.PointData["RTData"].GetRange(), (150.0, 150.0))

    def test_contour_makes_no_surface_on_several_ranks(self):
        contour = simple.StabbingContour(
            Input=self.volume, ContourBy=["POINTS", "RTData"], Isosurfaces=[testing.ISOVALUE]
        )
        surface = simple.DistributeIsosurface(Input=contour)
        self.assertEqual(testing.count_cells(surface), self.triangles)
        own = contour.GetDataInformation().GetNumberOfCells()
        self.assertEqual(own, self.triangles if testing.arguments.ranks == 1 else 0)

    def test_every_rank_tells_its_cost(self):
        ranks = testing.arguments.ranks
        if ranks == 1:
            self.skipTest("nothing travels")
        surface = self.distribute(DrawingRanks=2)
        self.assertEqual(testing.count_cells(surface), self.triangles)
        costs = self.read_costs(surface)
        self.assertEqual(len(costs), ranks)
        triangles = [int(row["Triangles"]) for row in costs]
        self.assertEqual(sum(triangles), self.triangles)
        self.assertEqual(triangles[2:], [0] * (ranks - 2))
        self.assertLess(max(triangles), 0.6 * self.triangles)
        for name in ("RawBytes", "EncodedBytes", "SentBytes"):
            self.assertGreater(sum(int(row[name]) for row in costs), 0)

    def test_surface_follows_the_contour(self):
        surface = self.distribute()
        self.assertEqual(testing.count_cells(surface), self.triangles)
        self.contour.Isosurfaces = [testing.OTHER_ISOVALUE]
        expected = testing.count_expected_triangles(testing.OTHER_ISOVALUE)
        self.assertEqual(testing.count_cells(surface), expected)

    def test_surface_follows_the_time(self):
        path = testing.output("series.bvol")
        simple.SaveData(path, proxy=testing.make_series(), WriteAllTimeSteps=1)
        contour = simple.StabbingContour(
            Input=simple.OpenDataFile(path), ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0]
        )
        surface = simple.DistributeIsosurface(Input=contour)
        for time in (0, 3, 1):
            surface.UpdatePipeline(time)
            expected = testing.count_expected_triangles(150.0 - 10 * time)
            self.assertEqual(surface.GetDataInformation().GetNumberOfCells(), expected)

    def test_other_filters_follow(self):
        surface = self.distribute()
        clip = simple.Clip(Input=surface, ClipType="Plane")
        self.assertGreater(testing.count_cells(clip), 0)
        self.assertLess(testing.count_cells(clip), self.triangles)

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
            path = testing.output(name + ".png")
            simple.SaveScreenshot(path, view, ImageResolution=view.ViewSize)
            images[name] = testing.read_image(path)
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


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--port", type=int, help="of a pvserver to be its client")


testing.parse_arguments(add_arguments)
if testing.arguments.port:
    simple.Connect("localhost", testing.arguments.port)
testing.load_plugin()
testing.run()
