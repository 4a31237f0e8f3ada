# SPDX-License-Identifier: BSD-3-Clause
"""Edge-index files in Save Data and Open: the surface comes back. On any number of ranks."""
import os

from paraview import servermanager, simple

import plugin_testing


def reopen(path):
    surface = simple.OpenDataFile(path)
    surface.UpdatePipeline()
    return surface


class EdgeIndexFiles(plugin_testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.volume = plugin_testing.open_volume("wave.bvol")
        cls.triangles = plugin_testing.count_expected_triangles()

    def test_save_data_and_open_give_the_surface_back_in_every_mode(self):
        contour = plugin_testing.contour(self.volume)
        sizes = {}
        for mode in ("Lossless", "Bounded", "Quantized", "Smallest"):
            with self.subTest(mode=mode):
                path = plugin_testing.output(mode + ".eix")
                simple.SaveData(path, proxy=contour, Mode=mode, Profile="Working")
                surface = reopen(path)
                self.assertEqual(plugin_testing.count_cells(surface), self.triangles)
                self.assertIsNotNone(surface.PointData["GlobalIds"])
                self.assertIsNotNone(surface.PointData["Normals"])
                self.assertEqual(surface.PointData["RTData"].GetRange(), (150.0, 150.0))
                sizes[mode] = os.path.getsize(path)
        self.assertLess(sizes["Bounded"], sizes["Lossless"])

    def test_image_data_give_the_same_surface(self):
        wave = plugin_testing.open_image()
        path = plugin_testing.output("image.eix")
        simple.SaveData(path, proxy=plugin_testing.contour(wave))
        self.assertEqual(plugin_testing.count_cells(reopen(path)), self.triangles)

    def test_a_writer_of_a_script_makes_no_surface(self):
        contour = simple.Isosurface(
            Input=self.volume, ContourBy=["POINTS", "RTData"], Isosurfaces=[plugin_testing.ISOVALUE]
        )
        path = plugin_testing.output("script.eix")
        writer = servermanager.writers.EdgeIndexWriter(Input=contour, FileName=path)
        writer.UpdatePipeline()
        self.assertEqual(contour.GetDataInformation().GetNumberOfCells(), 0)
        self.assertEqual(plugin_testing.count_cells(reopen(path)), self.triangles)

    def test_preview_and_region_are_less(self):
        path = plugin_testing.output("parts.eix")
        simple.SaveData(path, proxy=plugin_testing.contour(self.volume))
        surface = reopen(path)
        surface.Preview = 1
        self.assertLess(plugin_testing.count_cells(surface), self.triangles / 20)
        self.assertGreater(plugin_testing.count_cells(surface), 0)
        surface.Preview = 0
        surface.UseRegion = 1
        surface.RegionPosition = [-40, -35, -30]
        surface.RegionLength = [20, 20, 20]
        self.assertLess(plugin_testing.count_cells(surface), self.triangles / 2)

    def test_normals_and_arrays_are_written_on_request(self):
        contour = plugin_testing.contour(self.volume)
        contour.ComputeScalars = 0
        contour.InterpolatedArrays = ["RTData"]
        path = plugin_testing.output("arrays.eix")
        simple.SaveData(path, proxy=contour, WriteNormals=1, ArrayError=0.5)
        surface = reopen(path)
        surface.ComputeScalars = 0
        surface.UpdatePipeline()
        low, high = surface.PointData["RTData"].GetRange()
        self.assertGreater(low, plugin_testing.ISOVALUE - 0.6)
        self.assertLess(high, plugin_testing.ISOVALUE + 0.6)

    def test_time_steps_open_as_a_series(self):
        times = [0.0, 1.0, 2.0, 3.0]
        path = plugin_testing.output("steps.bvol")
        simple.SaveData(path, proxy=plugin_testing.make_series(), WriteAllTimeSteps=1, BlockSize=16)
        contour = plugin_testing.contour(plugin_testing.open_volume(path))
        simple.SaveData(plugin_testing.output("steps.eix"), proxy=contour, WriteAllTimeSteps=1)
        names = ["steps_%d.eix" % step for step in range(len(times))]
        series = simple.OpenDataFile([plugin_testing.output(name) for name in names])
        series.UpdatePipelineInformation()
        self.assertEqual(list(series.TimestepValues), times)
        for time in times:
            series.UpdatePipeline(time)
            self.assertEqual(
                series.GetDataInformation().GetNumberOfCells(),
                plugin_testing.count_expected_triangles(plugin_testing.ISOVALUE - 10 * time),
            )

    def test_a_clipped_surface_is_refused_and_nothing_is_written(self):
        contour = plugin_testing.contour(self.volume)
        clip = simple.Clip(Input=contour)
        surface = simple.ExtractSurface(Input=clip)
        path = plugin_testing.output("clipped.eix")
        simple.SaveData(path, proxy=surface)
        self.assertFalse(os.path.exists(path))


plugin_testing.run()
