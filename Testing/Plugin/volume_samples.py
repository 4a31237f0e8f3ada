# SPDX-License-Identifier: BSD-3-Clause
"""Volume Slice, Volume Region and Volume Probe give what stock filters give of the whole image. Any number of ranks."""

import vtk.util.numpy_support as arrays
from paraview import servermanager, simple

import plugin_testing as testing


class Samples(testing.TestCase):
    def setUp(self):
        self.image = testing.open_image()
        self.reader = simple.OpenDataFile(testing.volume("wave.bvol"))
        self.reader.UpdatePipeline()  # as Apply does: then the bounds are known
        self.bounds = self.image.GetDataInformation().GetBounds()

    def integrate(self, source, size="Area"):
        integral = simple.IntegrateVariables(Input=source)
        integral.UpdatePipeline()
        return integral.CellData[size].GetRange()[0], integral.PointData["RTData"].GetRange()[0]

    def test_slice_integrates_as_that_of_stock(self):
        for normal in ([0, 0, 1], [0, 1, 0]):
            ours = simple.VolumeSlice(Input=self.reader, Origin=[0.5, 2.5, 10.25], Normal=normal)
            stock = simple.Slice(Input=self.image, Triangulatetheslice=0)
            stock.SliceType.Origin = [0.5, 2.5, 10.25]
            stock.SliceType.Normal = normal
            area, integral = self.integrate(ours)
            expected_area, expected = self.integrate(stock)
            self.assertAlmostEqual(area / expected_area, 1, places=5)
            self.assertAlmostEqual(integral / expected, 1, places=5)

    def test_slice_is_drawn_as_a_texture_through_the_middle(self):
        ours = simple.VolumeSlice(Input=self.reader)
        middle = [(self.bounds[2 * axis] + self.bounds[2 * axis + 1]) / 2 for axis in range(3)]
        self.assertEqual(list(ours.Origin), middle)
        view = testing.make_view()
        self.assertEqual(simple.Show(ours, view).Representation, "Slice")
        simple.Render(view)
        ours.UpdatePropertyInformation()
        self.assertRegex(ours.Shown, "^[0-9]+ x [0-9]+ points, full resolution$")

    def test_isolines_are_the_second_output(self):
        ours = simple.VolumeSlice(Input=self.reader, Isolines=[testing.ISOVALUE])
        ours.UpdatePipeline()
        lines = servermanager.OutputPort(ours, 1)
        lines.UpdatePipeline()
        self.assertGreater(lines.GetDataInformation().GetNumberOfCells(), 20)

    def test_region_is_a_box_of_the_image(self):
        ours = simple.VolumeRegion(Input=self.reader)
        self.assertEqual(list(ours.Position), [self.bounds[0], self.bounds[2], self.bounds[4]])
        ours.Position = [self.bounds[0] + 2, self.bounds[2] + 1, self.bounds[4]]
        ours.Length = [5, 6, 7]
        ours.UpdatePipeline()
        extent = self.image.GetDataInformation().GetExtent()
        stock = simple.ExtractSubset(Input=self.image)
        stock.VOI = [
            extent[0] + 2, extent[0] + 7, extent[2] + 1, extent[2] + 7, extent[4], extent[4] + 7
        ]  # fmt: skip
        stock.UpdatePipeline()
        for information in ("GetBounds", "GetExtent"):
            self.assertEqual(
                getattr(ours.GetDataInformation(), information)(),
                getattr(stock.GetDataInformation(), information)(),
            )
        volume, integral = self.integrate(ours, "Volume")
        expected_volume, expected = self.integrate(stock, "Volume")
        self.assertAlmostEqual(volume / expected_volume, 1, places=5)
        self.assertAlmostEqual(integral / expected, 1, places=5)

    def test_values_along_a_line_are_those_of_stock(self):
        line = simple.Line(
            Point1=[self.bounds[0], self.bounds[2], self.bounds[4]],
            Point2=[self.bounds[1], self.bounds[3], self.bounds[5]],
            Resolution=200,
        )
        ours = simple.VolumeProbe(Input=self.reader, Source=line)
        stock = simple.ResampleWithDataset(SourceDataArrays=self.image, DestinationMesh=line)
        values = [
            arrays.vtk_to_numpy(servermanager.Fetch(source).GetPointData().GetArray("RTData"))
            for source in (ours, stock)
        ]
        self.assertEqual(len(values[0]), 201)
        self.assertLess(abs(values[0] - values[1]).max(), 1e-3)

    def test_slice_of_a_file_that_is_indexed_first_is_whole_at_once(self):
        path = testing.output("raw_40x30x20_uint16.raw")
        with open(path, "wb") as file:
            file.write(bytes(range(240)) * 200)
        ours = simple.VolumeSlice(Input=simple.OpenDataFile(path), Origin=[0, 0, 3])
        ours.UpdatePipeline()
        self.assertEqual(ours.GetDataInformation().GetExtent(), (0, 39, 0, 29, 0, 0))


testing.run()
