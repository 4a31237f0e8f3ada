# SPDX-License-Identifier: BSD-3-Clause
"""The reader describes the volume, whatever level of detail it gives; several files are a series."""
import os
import shutil

from paraview import simple

import plugin_testing as testing


def make_large_volume(name, scale):
    """A volume of 129^3 samples that 1 MiB does not hold, with one sample far above the others
    where only level 0 has it."""
    wave = simple.Wavelet(WholeExtent=[0, 128, 0, 128, 0, 128], Center=[64, 64, 64])
    marked = simple.Calculator(
        Input=wave,
        ResultArrayName="Marked",
        Function=f"{scale} * (RTData + 5000 * (coordsX == 33) * (coordsY == 35) * (coordsZ == 37))",
    )
    simple.SaveData(
        testing.output(name), proxy=marked, ChooseArraysToWrite=1, PointDataArrays=["Marked"]
    )
    marked.UpdatePipeline()
    return marked.PointData["Marked"].GetRange()


class DescribedVolume(testing.TestCase):
    def test_range_is_that_of_the_volume(self):
        expected = make_large_volume("large.bvol", 1)
        reader = simple.OpenDataFile(testing.output("large.bvol"), MemoryLimit=1)
        reader.UpdatePipeline()
        self.assertLess(reader.GetDataInformation().GetNumberOfPoints(), 129**3 / 4)
        self.assertGreater(expected[1], 4000)
        for ours, theirs in zip(reader.PointData["Marked"].GetRange(), expected):
            self.assertAlmostEqual(ours, theirs, places=3)
        # The isovalue that is proposed is of the volume, too.
        contour = simple.Isosurface(Input=reader)
        self.assertGreater(contour.Isosurfaces[0], expected[0])
        self.assertLess(contour.Isosurfaces[0], expected[1])

    def test_tells_what_is_shown_of_it(self):
        make_large_volume("told.bvol", 1)
        reader = simple.OpenDataFile(testing.output("told.bvol"), MemoryLimit=1)
        reader.UpdatePipeline()
        reader.UpdatePropertyInformation()
        self.assertEqual(reader.GetProperty("Shown")[0], "level 2, 33 x 33 x 33, of 129 x 129 x 129")
        reader.MemoryLimit = 256
        reader.UpdatePipeline()
        reader.UpdatePropertyInformation()
        self.assertEqual(reader.GetProperty("Shown")[0], "all of it, 129 x 129 x 129")

    def test_several_files_are_a_series_in_time(self):
        make_large_volume("series1.bvol", 1)
        make_large_volume("series2.bvol", 2)
        reader = simple.OpenDataFile([testing.output(f"series{n}.bvol") for n in (1, 2)])
        self.assertEqual(len(reader.TimestepValues), 2)
        counts = []
        for time, isovalue in zip(reader.TimestepValues, (150, 300)):
            contour = simple.Isosurface(Input=reader, Isosurfaces=[isovalue])
            contour.UpdatePipeline(time)
            counts.append(contour.GetDataInformation().GetNumberOfCells())
        self.assertGreater(counts[0], 0)
        self.assertEqual(counts[0], counts[1])

    def test_reload_files_shows_what_was_written_since(self):
        first = make_large_volume("again.bvol", 1)
        reader = simple.OpenDataFile(testing.output("again.bvol"))
        reader.UpdatePipeline()
        for path in (testing.output("again.bvol"), testing.get_stores(testing.output("again.bvol"))):
            if os.path.isdir(path):
                shutil.rmtree(path)
            else:
                os.remove(path)
        second = make_large_volume("again.bvol", 3)
        simple.ReloadFiles(reader)
        reader.UpdatePipeline()
        self.assertAlmostEqual(reader.PointData["Marked"].GetRange()[1], second[1], places=2)
        self.assertNotAlmostEqual(first[1], second[1], places=2)


testing.run()
