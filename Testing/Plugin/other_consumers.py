# SPDX-License-Identifier: BSD-3-Clause
"""Isosurface beside and behind ParaView's own filters. Any number of ranks."""

from paraview import simple

import plugin_testing as testing


class Beside(testing.TestCase):
    """Consumers of the same reader see the whole volume, whatever Isosurface asks for."""

    def setUp(self):
        self.image = testing.open_image()
        self.reader = simple.OpenDataFile(testing.volume("wave.bvol"))

    def slice_of(self, source):
        # Between two layers of samples, and away from the faces of blocks.
        cut = simple.Slice(Input=source, Triangulatetheslice=0)
        cut.SliceType.Origin = [0.5, 2.5, 10.5]
        cut.SliceType.Normal = [0, 0, 1]
        return cut

    def area_and_integral(self, source):
        integral = simple.IntegrateVariables(Input=self.slice_of(source))
        integral.UpdatePipeline()
        area = integral.CellData["Area"].GetRange()[0]
        return area, integral.PointData["RTData"].GetRange()[0]

    def assert_whole(self, source):
        source.UpdatePipeline()
        self.assertEqual(
            source.GetDataInformation().GetBounds(), self.image.GetDataInformation().GetBounds()
        )
        area, integral = self.area_and_integral(source)
        expected_area, expected = self.area_and_integral(self.image)
        self.assertAlmostEqual(area / expected_area, 1, places=5)
        self.assertAlmostEqual(integral / expected, 1, places=5)

    def test_slice_before_the_contour_stays_whole(self):
        self.assert_whole(self.reader)
        surface = testing.contour(self.reader)
        self.assert_whole(self.reader)
        # An isovalue that few blocks have.
        surface.Isosurfaces = [270.0]
        surface.UpdatePipeline()
        self.assert_whole(self.reader)
        self.check_triangles(surface, 270.0)

    def test_slice_after_the_contour_is_whole(self):
        surface = testing.contour(self.reader, 270.0)
        self.assert_whole(self.reader)
        surface.Isosurfaces = [testing.ISOVALUE]
        self.check_triangles(surface)
        self.assert_whole(self.reader)

    def test_two_contours_do_not_disturb_each_other(self):
        first = testing.contour(self.reader, 270.0)
        second = testing.contour(self.reader, testing.ISOVALUE)
        self.check_triangles(first, 270.0)
        self.check_triangles(second)
        first.Isosurfaces = [testing.OTHER_ISOVALUE]
        self.check_triangles(first, testing.OTHER_ISOVALUE)
        self.check_triangles(second)

    def test_filter_between_serves_contour_and_slice(self):
        between = simple.PassArrays(Input=self.reader, PointDataArrays=["RTData"])
        surface = testing.contour(between, 270.0)
        self.assert_whole(between)
        self.check_triangles(surface, 270.0)
        surface.Isosurfaces = [testing.ISOVALUE]
        self.check_triangles(surface)
        self.assert_whole(between)

    def test_volume_of_cells_counts_none_twice(self):
        integral = simple.IntegrateVariables(Input=self.reader)
        expected = simple.IntegrateVariables(Input=self.image)
        testing.contour(self.reader, 270.0)
        for source in (integral, expected):
            source.UpdatePipeline()
        self.assertAlmostEqual(
            integral.CellData["Volume"].GetRange()[0] / expected.CellData["Volume"].GetRange()[0],
            1,
            places=5,
        )


class Behind(testing.TestCase):
    """Behind a filter the surface is that of the filter's output: no silent wrong result."""

    def setUp(self):
        self.image = testing.open_image()
        self.reader = simple.OpenDataFile(testing.volume("wave.bvol"))

    def test_pass_arrays_gives_the_same_surface(self):
        passed = simple.PassArrays(Input=self.reader, PointDataArrays=["RTData"])
        self.check_triangles(testing.contour(passed))

    def test_calculator_is_contoured_by_its_own_values(self):
        calculator = simple.Calculator(
            Input=self.reader, ResultArrayName="RTData", Function="300-RTData"
        )
        for isovalue in (30.0, testing.ISOVALUE, 250.0):
            with self.subTest(isovalue=isovalue):
                self.check_triangles(testing.contour(calculator, isovalue), isovalue, "300-RTData")

    def test_calculated_array_is_contoured(self):
        calculator = simple.Calculator(
            Input=self.reader, ResultArrayName="Shifted", Function="RTData+1000"
        )
        surface = testing.contour(calculator, 1150.0, "Shifted")
        self.check_triangles(surface, 1150.0, "RTData+1000")

    def test_filter_that_needs_neighbours_has_no_seams_between_blocks(self):
        gradient = simple.Gradient(
            Input=self.reader, ScalarArray=["POINTS", "RTData"], ResultArrayName="Gradient"
        )
        steepness = simple.Calculator(
            Input=gradient, ResultArrayName="Steepness", Function="mag(Gradient)"
        )
        steepness.ResultArrayType = "Float"
        self.check_triangles(testing.contour(steepness, 12.0, "Steepness"), 12.0, "mag(Gradient)")

    def test_image_in_memory_gives_the_stock_surface(self):
        self.check_triangles(testing.contour(self.image))


testing.run()
