# SPDX-License-Identifier: BSD-3-Clause
"""States that the GUI saved give the same image in a new process: --states FOLDER"""
import runpy

from paraview import simple

import plugin_testing as testing


class StateFiles(testing.TestCase):
    def setUp(self):
        simple.ResetSession()

    def check_session(self, image):
        view = simple.GetActiveView()
        surface = simple.FindSource("Isosurface1")
        self.assertEqual(list(surface.Isosurfaces), [testing.ISOVALUE])
        self.check_triangles(surface)
        self.check_image(view, "StabbingContour.png", image)

    def test_pvsm_gives_the_same_image(self):
        self.load_state(testing.state("gui.pvsm"))
        self.check_session("pvsm.png")

    def test_python_state_gives_the_same_image(self):
        runpy.run_path(testing.state("gui_state.py"))
        self.check_session("python.png")


testing.run()
