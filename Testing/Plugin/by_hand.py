# SPDX-License-Identifier: BSD-3-Clause
"""What GuiByHand.xml did is in its files and in the window's log."""
import csv
import os

from paraview import simple

import plugin_testing as testing

FIRST, LAST, FRAMES = 120.0, 180.0, 4  # animated_isovalue.py's


def read_ids(name):
    with open(testing.state(name), newline="") as table:
        return [int(row["GlobalIds"]) for row in csv.DictReader(table)]


class ByHand(testing.TestCase):
    def setUp(self):
        surface = testing.contour(testing.open_volume("wave.bvol"))
        path = testing.output("points.csv")
        simple.SaveData(path, proxy=surface)
        self.ids = set(read_ids(path))

    def test_each_view_shows_the_surface(self):
        image = testing.read_image(testing.state("views.png"))
        rows, columns, _ = image.shape
        right = image[:, columns // 2 :]
        for part in (image[:, : columns // 2], right[: rows // 2], right[rows // 2 :]):
            self.assertGreater((part != part[0, 0]).any(axis=2).mean(), 0.05)

    def test_a_change_is_extracted_once_for_all_views(self):
        log = testing.read_window_log().split("Surfaces are finished before they are saved")[0]
        full = {
            isovalue: testing.count_expected_triangles(isovalue)
            for isovalue in (FIRST, testing.ISOVALUE, testing.OTHER_ISOVALUE)
        }
        surfaces = [count for count in testing.find_triangles(log) if count in full.values()]
        this, other = full[testing.ISOVALUE], full[testing.OTHER_ISOVALUE]
        # Applied, applied; undone, redone, undone.
        self.assertEqual(surfaces, [full[FIRST], this, other, this, other, this])

    def test_selected_cells_have_points_of_the_surface(self):
        ids = read_ids("selected.csv")
        self.assertGreater(len(ids), 100)
        self.assertLess(len(ids), len(self.ids))
        self.assertLessEqual(set(ids), self.ids)

    def test_the_point_that_was_found_is_the_last(self):
        self.assertEqual(read_ids("found.csv"), [max(self.ids)])

    def test_a_script_gets_the_exact_surface_while_a_filter_waits_for_apply(self):
        surfaces = testing.find_triangles(testing.read_window_log())
        exact = [testing.count_expected_triangles(isovalue) for isovalue in (140, testing.ISOVALUE)]
        at = surfaces.index(exact[0])
        self.assertEqual(surfaces[at : at + 2], exact)
        self.assertEqual(surfaces[at - 1], testing.count_expected_triangles())

    def test_frames_are_of_exact_surfaces(self):
        log = testing.read_window_log().split("Surfaces are finished before they are saved")[-1]
        expected = [
            testing.count_expected_triangles(FIRST + frame * (LAST - FIRST) / (FRAMES - 1))
            for frame in range(FRAMES)
        ]
        self.assertEqual(testing.find_triangles(log)[:FRAMES], expected)
        for frame in range(FRAMES):
            self.assertTrue(os.path.exists(testing.state(f"frame.{frame:04}.png")))


testing.run()
