# SPDX-License-Identifier: BSD-3-Clause
"""Save Data: its properties arrive in the file; a file can be saved over. On any number of ranks."""
import json
import unittest

from paraview import simple

import plugin_testing as testing


def read_header(path):
    with open(path) as file:
        return json.load(file)


class SaveData(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wave = simple.XMLImageDataReader(FileName=[testing.volume("wave.vti")])
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
                header = read_header(path)
                self.assertEqual(header["blockSize"], size)
                self.assertEqual(header["stores"], stores)
                self.assertEqual(len(header["timeSteps"][0]["stores"]), stores)
                self.assertEqual(header["distribution"], {"method": method.lower(), "seed": seed})
                surface = testing.contour(testing.open_volume(path))
                self.assertEqual(testing.count_cells(surface), self.triangles)

    def test_default_is_a_store_a_rank_and_blocks_of_32(self):
        header = read_header(self.save("default.bvol"))
        self.assertEqual(header["blockSize"], 32)
        self.assertEqual(header["stores"], testing.arguments.ranks)
        self.assertEqual(header["distribution"]["method"], "greedy")

    def test_random_seed_decides_where_blocks_go(self):
        def stores(name, seed):
            path = self.save(
                name, BlockSize=16, NumberOfStores=4, Distribution="Random", RandomSeed=seed
            )
            return [store["checksum"] for store in read_header(path)["timeSteps"][0]["stores"]]

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
        self.assertEqual(
            testing.count_cells(surface), testing.count_expected_triangles(testing.ISOVALUE - 20)
        )
        low, high = reader.PointData["RTData"].GetRange()
        old_low, old_high = self.wave.PointData["RTData"].GetRange()
        self.assertAlmostEqual(low, old_low + 20, places=3)
        self.assertAlmostEqual(high, old_high + 20, places=3)


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, required=True)


testing.parse_arguments(add_arguments)
testing.load_plugin()
testing.run()
