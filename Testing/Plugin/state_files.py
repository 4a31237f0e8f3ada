# SPDX-License-Identifier: BSD-3-Clause
"""States that the GUI saved give the same image in a new process: --states FOLDER"""
import os
import runpy
import unittest

from paraview import simple

import plugin_testing as testing


class StateFiles(unittest.TestCase):
    def setUp(self):
        simple.ResetSession()

    def check_session(self, image):
        view = simple.GetActiveView()
        surface = simple.FindSource("StabbingContour1")
        self.assertEqual(list(surface.Isosurfaces), [testing.ISOVALUE])
        self.assertEqual(testing.count_cells(surface), testing.count_expected_triangles())
        self.assertLess(
            testing.compare_image(view, "StabbingContour.png", image),
            testing.LARGEST_DIFFERENCE,
        )

    def test_pvsm_gives_the_same_image(self):
        simple.LoadState(os.path.join(testing.arguments.states, "gui.pvsm"))
        self.check_session("pvsm.png")

    def test_python_state_gives_the_same_image(self):
        runpy.run_path(os.path.join(testing.arguments.states, "gui_state.py"))
        self.check_session("python.png")


def add_arguments(parser):
    parser.add_argument("--states", required=True, help="the folder that the GUI saved into")


testing.parse_arguments(add_arguments)
testing.load_plugin()
testing.run()
