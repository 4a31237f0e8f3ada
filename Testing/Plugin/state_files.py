# SPDX-License-Identifier: BSD-3-Clause
"""States that the GUI saved give the same picture in a new process: --states FOLDER"""
import os
import unittest

from paraview import simple

import plugin_testing as testing


class StateFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        testing.load_plugin(remote=True)

    def setUp(self):
        simple.ResetSession()

    def check_state(self, name, picture):
        simple.LoadState(os.path.join(testing.arguments.states, name))
        view = simple.GetActiveView()
        surface = simple.FindSource("StabbingContour1")
        self.assertEqual(list(surface.Isosurfaces), [testing.ISOVALUE])
        self.assertEqual(testing.count_cells(surface), testing.count_stock_triangles())
        self.assertLess(
            testing.compare_picture(view, "StabbingContour.png", picture),
            testing.LARGEST_DIFFERENCE,
        )

    def test_pvsm_gives_the_same_picture(self):
        self.check_state("gui.pvsm", "pvsm.png")

    def test_python_state_gives_the_same_picture(self):
        self.check_state("gui_state.py", "python.png")


def add_arguments(parser):
    parser.add_argument("--states", required=True, help="the folder that the GUI saved into")


testing.run(add_arguments)
