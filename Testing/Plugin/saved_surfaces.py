# SPDX-License-Identifier: BSD-3-Clause
"""What GuiSaving.xml saved right after changes is the full surface."""
import csv
import os
import unittest

from paraview import simple

import plugin_testing as testing


def find(name):
    return os.path.join(testing.arguments.states, name)


class SavedSurfaces(unittest.TestCase):
    def test_data_are_those_of_the_full_surface(self):
        surface = simple.PLYReader(FileNames=[find("saved.ply")])
        self.assertEqual(
            testing.count_cells(surface), testing.count_expected_triangles(testing.OTHER_ISOVALUE)
        )

    def test_data_behind_a_surface_that_was_stopped_are_of_the_full_one(self):
        with open(find("area.csv"), newline="") as table:
            (saved,) = csv.DictReader(table)
        surface = testing.contour(testing.open_volume("noise.bvol"), 127.5, "Noise")
        integral = simple.IntegrateVariables(Input=surface)
        integral.UpdatePipeline()
        full = integral.PointData["Noise"].GetRange()[0]
        self.assertAlmostEqual(float(saved["Noise"]) / full, 1, places=4)

    def test_a_screenshot_taken_soon_is_that_taken_later(self):
        soon = testing.read_image(find("soon.png"))
        self.assertTrue((soon == testing.read_image(find("later.png"))).all())
        self.assertGreater(soon.std(), 1)

    def test_surfaces_are_finished_by_each_dialog_that_saves(self):
        with open(find("window.log"), encoding="utf-8", errors="replace") as file:
            self.assertEqual(file.read().count("Surfaces are finished before they are saved"), 4)


if __name__ == "__main__":
    testing.parse_arguments(lambda parser: parser.add_argument("--states"))
    testing.load_plugin()
    testing.run()
