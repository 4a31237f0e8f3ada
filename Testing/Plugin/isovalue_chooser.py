# SPDX-License-Identifier: BSD-3-Clause
"""What GuiIsovalues.xml did by hand is in the property, and so in states, undo steps and the trace."""

from paraview import simple

import plugin_testing as testing


def read_isovalues(name):
    """Of the one Isosurface in a state file that the GUI saved."""
    (isovalues,) = testing.read_state(name, "Isosurface", "ContourValues")
    return isovalues


class IsovalueChooser(testing.TestCase):
    def test_adds_an_isovalue_where_the_mouse_was(self):
        first, second = read_isovalues("added.pvsm")
        source = testing.open_image()
        low, high = source.PointData["RTData"].GetRange()
        proposed = simple.Isosurface(Input=testing.open_volume("wave.bvol"))
        self.assertEqual([first], list(proposed.Isosurfaces))
        self.assertGreater(second, low)
        self.assertLess(second, first)
        simple.Delete(proposed)  # the trace has one of its name

    def test_dragging_changes_one_isovalue(self):
        before = read_isovalues("added.pvsm")
        after = read_isovalues("dragged.pvsm")
        self.assertEqual(after[0], before[0])
        self.assertGreater(after[1], before[1])

    def test_a_drag_is_one_step_to_undo_and_redo(self):
        self.assertEqual(read_isovalues("undone.pvsm"), read_isovalues("added.pvsm"))
        self.assertEqual(read_isovalues("redone.pvsm"), read_isovalues("dragged.pvsm"))

    def test_the_trace_does_the_same_again(self):
        reader = simple.OpenDataFile(testing.volume("wave.bvol"))
        simple.RenameSource("wave.bvol", reader)
        with open(testing.state("trace.py"), encoding="utf-8") as file:
            trace = file.read()
        values = ", ".join(repr(value) for value in read_isovalues("dragged.pvsm"))
        self.assertIn(f"isosurface1.Isosurfaces = [{values}]", trace)
        # ParaView 5.13 records this line for its own sources, too, and fails where it is played.
        trace = trace.replace("ColorBy(isosurface1Display, None)\n", "")
        exec(compile(trace, "trace.py", "exec"), vars(simple).copy())
        contour = simple.FindSource("Isosurface1")
        self.assertEqual(list(contour.Isosurfaces), [testing.ISOVALUE])
        self.check_triangles(contour)

    def test_nobody_sees_the_spectrum_behind_the_chart(self):
        for name in ("added.pvsm", "trace.py"):
            with self.subTest(name=name):
                with open(testing.state(name), encoding="utf-8") as file:
                    self.assertNotIn("ContourSpectrum", file.read())


testing.run()
