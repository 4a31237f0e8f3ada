# SPDX-License-Identifier: BSD-3-Clause
"""What GuiTissues.xml chose by buttons has its colors, and a legend, in a state file and in the trace."""
from paraview import simple

import plugin_testing as testing


class Tissues(testing.TestCase):
    def check_skin_and_bone(self, image):
        view = simple.GetActiveView()
        display = simple.GetDisplayProperties(simple.FindSource("Isosurface1"), view)
        simple.SaveScreenshot(testing.output(image), view, ImageResolution=testing.IMAGE_SIZE)
        self.assertEqual(
            list(display.LookupTable.Annotations),
            ["-300", "Skin, -300 HU", "300", "Bone, 300 HU"],
        )
        self.assertEqual(list(display.LookupTable.IndexedOpacities), [0.35, 1])
        self.assertTrue(display.LookupTable.EnableOpacityMapping)
        self.assertTrue(display.IsScalarBarVisible(view))

    def test_the_state_has_them(self):
        simple.ResetSession()
        self.assertEqual(
            testing.read_state("tissues.pvsm", "Isosurface", "ContourValues"), [[-300, 300]]
        )
        self.load_state(testing.state("tissues.pvsm"))
        self.check_skin_and_bone("state.png")

    def test_a_trace_has_them(self):
        with open(testing.state("trace.py"), encoding="utf-8") as file:
            exec(compile(file.read(), "trace.py", "exec"), vars(simple).copy())
        self.check_skin_and_bone("trace.png")


testing.run()
