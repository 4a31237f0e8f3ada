# SPDX-License-Identifier: BSD-3-Clause
"""Save Data: its properties arrive in the file; a file can be saved over. On any number of ranks."""
import os

from paraview import simple

import plugin_testing as testing


class SaveData(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wave = testing.open_image()
        cls.triangles = testing.count_expected_triangles()

    def save(self, name, source=None, **properties):
        path = testing.output(name)
        simple.SaveData(path, proxy=source or self.wave, **properties)
        return path

    def test_properties_arrive_in_the_header_and_none_of_them_changes_the_surface(self):
        for number, (size, stores, method, seed) in enumerate(
            [(16, 1, "Greedy", 0), (32, 3, "Random", 7), (64, 5, "Slab", 0), (16, 4, "Balanced", 0)]
        ):
            with self.subTest(method=method):
                path = self.save(
                    f"volume{number}.bvol",
                    BlockSize=size,
                    NumberOfStores=stores,
                    Distribution=method,
                    RandomSeed=seed,
                )
                header = testing.read_header(path)
                self.assertEqual(header["blockSize"], size)
                self.assertEqual(header["stores"], stores)
                self.assertEqual(len(header["timeSteps"][0]["stores"]), stores)
                self.assertEqual(header["distribution"], {"method": method.lower(), "seed": seed})
                surface = testing.contour(testing.open_volume(path))
                self.assertEqual(testing.count_cells(surface), self.triangles)

    def test_default_is_a_store_a_rank_and_blocks_of_32(self):
        header = testing.read_header(self.save("default.bvol"))
        self.assertEqual(header["blockSize"], 32)
        self.assertEqual(header["stores"], testing.arguments.ranks)
        self.assertEqual(header["distribution"]["method"], "greedy")

    def test_random_seed_decides_where_blocks_go(self):
        def stores(name, seed):
            path = self.save(
                name, BlockSize=16, NumberOfStores=4, Distribution="Random", RandomSeed=seed
            )
            return [store["checksum"] for store in testing.read_header(path)["timeSteps"][0]["stores"]]

        first = stores("seed1.bvol", 1)
        self.assertEqual(first, stores("seed1_again.bvol", 1))
        self.assertNotEqual(first, stores("seed2.bvol", 2))

    def test_saving_over_a_file_shows_the_new_data_after_reload(self):
        path = self.save("over.bvol")
        reader = testing.open_volume(path)
        surface = testing.contour(reader)
        self.assertEqual(testing.count_cells(surface), self.triangles)

        # The same grid with other samples: a cache that knows a block by file and number alone
        # would give the old ones.
        shifted = simple.Calculator(
            Input=self.wave, ResultArrayName="RTData", Function="RTData+20"
        )
        self.save("over.bvol", source=shifted)
        simple.ReloadFiles(reader)
        self.check_triangles(surface, testing.ISOVALUE - 20)
        low, high = reader.PointData["RTData"].GetRange()
        old_low, old_high = self.wave.PointData["RTData"].GetRange()
        self.assertAlmostEqual(low, old_low + 20, places=3)
        self.assertAlmostEqual(high, old_high + 20, places=3)

    def test_a_blocked_volume_is_saved_anew_at_full_resolution(self):
        path = self.save("source.bvol", NumberOfStores=2)
        for name in ("copy.bvol", "source.bvol"):  # over its own file, too
            with self.subTest(name=name):
                reader = simple.OpenDataFile(path)
                reader.MemoryLimit = 1
                reader.UpdatePipeline()
                copy = self.save(
                    name, source=reader, BlockSize=16, NumberOfStores=3, Compression="Zstd"
                )
                header = testing.read_header(copy)
                self.assertEqual((header["blockSize"], header["stores"]), (16, 3))
                self.assertEqual(header["grid"], testing.read_header(path)["grid"])
                simple.Delete(reader)
                surface = testing.contour(testing.open_volume(copy))
                self.assertEqual(testing.count_cells(surface), self.triangles)

    def test_a_blocked_volume_can_be_saved_as_one_alone(self):
        factory = simple.servermanager.vtkSMProxyManager.GetProxyManager().GetWriterFactory()

        def get_types(proxy):
            proxy.UpdatePipeline()
            return factory.GetSupportedFileTypes(proxy.SMProxy, 0)

        reader = testing.open_volume(self.save("offered.bvol"))
        self.assertIn("Blocked Volume(*.bvol )", get_types(reader))
        mesh = simple.Tetrahedralize(Input=reader)
        self.assertNotIn("bvol", get_types(mesh))

    def test_time_steps_of_a_blocked_volume_are_saved_anew_within_a_memory_limit(self):
        series = testing.open_volume("series.bvol")
        copy = self.save("series.bvol", source=series, WriteAllTimeSteps=1, MemoryLimit=64)
        old, new = testing.read_header(testing.volume("series.bvol")), testing.read_header(copy)
        self.assertEqual(
            [step["time"] for step in new["timeSteps"]], [step["time"] for step in old["timeSteps"]]
        )
        last = old["timeSteps"][-1]["time"]
        counts = []
        for source in (series, testing.open_volume(copy)):
            surface = testing.contour(source)
            surface.UpdatePipeline(last)
            counts.append(surface.GetDataInformation().GetNumberOfCells())
        self.assertEqual(counts[0], counts[1])

    def test_several_images_are_no_blocked_volume(self):
        pair = simple.OpenDataFile(testing.volume("pair.vtm"))
        self.assertFalse(os.path.exists(self.save("pair.bvol", source=pair)))

    def test_what_a_filter_makes_of_a_blocked_volume_is_saved_as_it_is(self):
        reader = testing.open_volume(self.save("plain.bvol"))
        shifted = simple.Calculator(Input=reader, ResultArrayName="RTData", Function="RTData+20")
        path = self.save("shifted.bvol", source=shifted)
        surface = testing.contour(testing.open_volume(path), testing.ISOVALUE + 20)
        self.assertEqual(testing.count_cells(surface), self.triangles)


testing.run()
