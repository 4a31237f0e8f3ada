# SPDX-License-Identifier: BSD-3-Clause
"""Options of Isosurface in Python, on N ranks of pvbatch:

    surface_quality.py ... --ranks N
"""
import plugin_testing as testing


class SurfaceQuality(testing.TestCase):
    def test_closed_surface_looks_like_a_body(self):
        view = testing.make_view()
        # wave.vti reaches this value at its border.
        surface = testing.contour(testing.open_volume("wave.bvol"), testing.OTHER_ISOVALUE)
        opened = testing.count_cells(surface)
        testing.show_surface(surface, view)
        surface.CloseBoundary = 1
        self.assertGreater(testing.count_cells(surface), opened)
        self.check_image(view, "ClosedSurface.png", "closed.png")

        # The comparison would see an open surface.
        surface.CloseBoundary = 0
        self.assertGreater(
            testing.compare_image(view, "ClosedSurface.png", "open.png"),
            10 * testing.LARGEST_DIFFERENCE,
        )

    def test_region_limits_what_is_read(self):
        surface = testing.contour(testing.open_volume("wave.bvol"))
        everywhere = self.count_active_blocks(surface)
        cells = testing.count_cells(surface)
        bounds = surface.GetDataInformation().GetBounds()
        surface.UseRegion = 1
        surface.RegionPosition = [bounds[0], bounds[2], bounds[4]]
        surface.RegionLength = [(bounds[1] - bounds[0]) / 8, 1000.0, 1000.0]
        self.assertLess(self.count_active_blocks(surface), everywhere)
        self.assertGreater(self.count_active_blocks(surface), 0)
        surface.RegionLength = [1000.0] * 3
        self.assertEqual(testing.count_cells(surface), cells)
        surface.UseRegion = 0
        # A camera that looks the other way.
        surface.FrustumPlanes = [1, 0, 0, -1e4] * 6
        self.assertEqual(testing.count_cells(surface), 0)
        surface.FrustumPlanes = [0] * 24
        self.assertEqual(testing.count_cells(surface), cells)

    def test_islands_are_told_and_what_is_hidden_is_not_there(self):
        surface = testing.contour(testing.open_volume("wave.bvol"), testing.OTHER_ISOVALUE)
        cells = testing.count_cells(surface)
        surface.UpdatePropertyInformation()
        self.assertFalse(surface.IslandSummary)
        surface.IslandSize = "Area"
        surface.ComputeIslandIds = 1
        self.assertEqual(testing.count_cells(surface), cells)
        islands = int(surface.FieldData["Islands"].GetRange()[0])
        self.assertGreater(islands, 1)
        self.assertEqual(surface.CellData["IslandId"].GetRange(), (0, islands - 1))
        surface.MaximumIslands = 1
        kept = testing.count_cells(surface)
        self.assertTrue(0 < kept < cells)
        surface.UpdatePropertyInformation()
        self.assertTrue(
            surface.IslandSummary.startswith(f"1 of {islands:,} islands, {100 * kept / cells:.1f} %"),
            surface.IslandSummary,
        )

    def test_no_array_is_interpolated_until_it_is_asked_for(self):
        for source in (testing.open_volume("wave.bvol"), self.open_image()):
            surface = testing.contour(source)
            self.assertEqual(list(surface.InterpolatedArrays), [])
            surface.ComputeScalars = 0
            surface.UpdatePipeline()
            self.assertIsNone(surface.PointData.GetArray("RTData"))
            surface.InterpolatedArrays = ["RTData"]
            surface.UpdatePipeline()
            low, high = surface.PointData.GetArray("RTData").GetRange()
            self.assertAlmostEqual(low, testing.ISOVALUE, places=3)
            self.assertAlmostEqual(high, testing.ISOVALUE, places=3)
            surface.InterpolatedArrays = []
            surface.UpdatePipeline()
            self.assertIsNone(surface.PointData.GetArray("RTData"))

    def open_image(self):
        source = testing.open_image()
        return source

    def count_active_blocks(self, surface):
        surface.UpdatePipeline()
        return sum(int(row["ActiveBlocks"]) for row in testing.read_costs(surface))


testing.run()
