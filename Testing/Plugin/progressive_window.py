# SPDX-License-Identifier: BSD-3-Clause
"""What GuiProgressive.xml did by hand: each change gave a coarse surface first and the full one last,
and nothing of that is in the state that was saved."""

from paraview import simple

import plugin_testing as testing


class ProgressiveWindow(testing.TestCase):
    def test_each_change_gives_a_coarse_surface_first_and_the_full_one_last(self):
        surfaces = testing.find_triangles(testing.read_window_log())
        full = testing.count_expected_triangles()
        other = testing.count_expected_triangles(testing.OTHER_ISOVALUE)
        # The other isovalue, this one, the other one by Undo, this one by Redo.
        for expected in (other, full, other, full):
            self.assertIn(expected, surfaces)
            end = surfaces.index(expected)
            coarse, surfaces = surfaces[:end], surfaces[end + 1 :]
            self.assertGreater(len(coarse), 0, f"before {expected} triangles")
            self.assertLess(20 * coarse[0], expected)
            self.assertEqual(coarse, sorted(coarse))
        self.assertEqual(surfaces, [])

    def test_state_gives_the_full_surface(self):
        (progressive,) = testing.read_state("window.pvsm", "Isosurface", "Progressive")
        self.assertEqual(progressive, [0])
        simple.LoadState(testing.state("window.pvsm"))
        (surface,) = [
            source
            for source in simple.GetSources().values()
            if source.GetXMLName() == "Isosurface"
        ]
        self.check_triangles(surface)


testing.run()
