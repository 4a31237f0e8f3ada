# SPDX-License-Identifier: BSD-3-Clause
"""What GuiProgressive.xml did by hand: each change gave a coarse surface first and the full one last,
and nothing of that is in the state that was saved."""
import os
import re
import unittest
import xml.etree.ElementTree as ElementTree

from paraview import simple

import plugin_testing as testing


def read_triangles():
    """Of the surfaces that the window's Stabbing Contour made, in their order."""
    path = os.path.join(testing.arguments.states, "window.log")
    with open(path, encoding="utf-8", errors="replace") as file:
        return [
            int(count)
            for count in re.findall(r"Stabbing Contour: rank 0: .* (\d+) triangles", file.read())
        ]


class ProgressiveWindow(unittest.TestCase):
    def test_each_change_gives_a_coarse_surface_first_and_the_full_one_last(self):
        surfaces = read_triangles()
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
        path = os.path.join(testing.arguments.states, "window.pvsm")
        state = ElementTree.parse(path)
        contour = state.find(".//Proxy[@type='StabbingContour']")
        progressive = contour.find("Property[@name='Progressive']/Element")
        self.assertEqual(progressive.get("value"), "0")
        simple.LoadState(path)
        (surface,) = [
            source
            for source in simple.GetSources().values()
            if source.GetXMLName() == "StabbingContour"
        ]
        self.assertEqual(testing.count_cells(surface), testing.count_expected_triangles())


if __name__ == "__main__":
    testing.parse_arguments(lambda parser: parser.add_argument("--states"))
    testing.load_plugin()
    testing.run()
