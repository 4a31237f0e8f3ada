# SPDX-License-Identifier: BSD-3-Clause
"""Progressive contours in Python, on N ranks of pvbatch, or of the server at a port:

    progressive.py ... --ranks N [--port PORT]
"""

from paraview import simple

import plugin_testing as testing


class Progressive(testing.TestCase):
    def make_surface(self):
        surface = testing.contour(testing.open_volume("wave.bvol"))
        surface.Progressive = 1
        return surface

    def read_levels(self, surface):
        """The level of the surface, which must be the same on all ranks."""
        surface.UpdatePipeline()
        rows = testing.read_costs(surface)
        self.assertEqual(len(rows), testing.arguments.ranks)
        levels = {int(row["Level"]) for row in rows}
        self.assertEqual(len(levels), 1)
        return levels.pop()

    def is_final(self, surface):
        surface.UpdatePropertyInformation()
        return bool(surface.Final)

    def finish(self, surface):
        """The levels of all surfaces up to the final one, each with its number of triangles."""
        levels = {self.read_levels(surface): testing.count_cells(surface)}
        while not self.is_final(surface):
            self.assertLess(len(levels), 10)
            surface.Refine()
            levels[self.read_levels(surface)] = testing.count_cells(surface)
        return levels

    def test_surface_gets_finer_until_it_is_that_of_flying_edges(self):
        levels = self.finish(self.make_surface())
        self.assertEqual(list(levels), sorted(levels, reverse=True))
        self.assertGreater(len(levels), 2)
        self.assertLessEqual(20 * list(levels.values())[0], levels[0])
        self.assertEqual(levels[0], testing.count_expected_triangles())

    def setUp(self):
        with_server = ("gets_finer", "images_end")
        if testing.arguments.port and not any(name in self.id() for name in with_server):
            self.skipTest("seen without a server")

    def test_another_isovalue_begins_anew(self):
        surface = self.make_surface()
        levels = self.finish(surface)
        surface.Isosurfaces = [testing.OTHER_ISOVALUE]
        others = self.finish(surface)
        self.assertGreater(list(others)[0], 0)
        self.assertEqual(
            others[0], testing.count_expected_triangles(testing.OTHER_ISOVALUE)
        )
        surface.Isosurfaces = [testing.ISOVALUE]
        surface.Level = 1
        self.assertEqual(self.read_levels(surface), list(levels)[0])
        surface.Progressive = 0
        self.assertEqual(self.read_levels(surface), 1)
        self.assertTrue(self.is_final(surface))

    def test_images_end_with_that_of_the_full_surface(self):
        view = testing.make_view()
        surface = self.make_surface()
        testing.show_surface(surface, view)
        differences = []
        while True:
            image = f"pass{len(differences)}.png"
            differences.append(
                testing.compare_image(view, "StabbingContour.png", image)
            )
            if self.is_final(surface):
                break
            surface.Refine()
        self.assertLess(differences[-1], testing.LARGEST_DIFFERENCE)
        # The comparison, which that of the window is too, sees a surface that is not final.
        self.assertGreater(differences[0], 3 * testing.LARGEST_DIFFERENCE)

    def test_filters_behind_follow(self):
        surface = self.make_surface()
        behind = simple.Elevation(Input=surface)
        first = testing.count_cells(behind)
        while not self.is_final(surface):
            surface.Refine()
            testing.count_cells(behind)
        self.assertLessEqual(20 * first, testing.count_cells(behind))
        self.check_triangles(behind)


testing.run()
