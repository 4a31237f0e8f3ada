# SPDX-License-Identifier: BSD-3-Clause
"""What GuiSaving.xml saved right after changes is the full surface."""
import csv

from paraview import simple

import plugin_testing as testing


class SavedSurfaces(testing.TestCase):
    def test_data_are_those_of_the_full_surface(self):
        surface = simple.PLYReader(FileNames=[testing.state("saved.ply")])
        self.check_triangles(surface, testing.OTHER_ISOVALUE)

    def test_data_behind_a_surface_that_was_stopped_are_of_the_full_one(self):
        with open(testing.state("area.csv"), newline="") as table:
            (saved,) = csv.DictReader(table)
        surface = simple.Isosurface(Input=testing.open_volume("noise.bvol"))  # as it was proposed in the window
        integral = simple.IntegrateVariables(Input=surface)
        integral.UpdatePipeline()
        full = integral.PointData["Noise"].GetRange()[0]
        self.assertAlmostEqual(float(saved["Noise"]) / full, 1, places=4)

    def test_a_screenshot_taken_soon_is_that_taken_later(self):
        soon = testing.read_image(testing.state("soon.png"))
        self.assertTrue((soon == testing.read_image(testing.state("later.png"))).all())
        self.assertGreater(soon.std(), 1)

    def test_surfaces_are_finished_by_each_dialog_that_saves(self):
        log = testing.read_window_log()
        self.assertEqual(log.count("Surfaces are finished before they are saved"), 4)


testing.run()
