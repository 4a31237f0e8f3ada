# SPDX-License-Identifier: BSD-3-Clause
"""The isovalues that GuiSpectrumPick.xml and pick_rows.py picked, as their state files have them."""

import plugin_testing as testing


def read_isovalues(name):
    return testing.read_state(name, "Isosurface", "ContourValues")


class SpectrumPick(testing.TestCase):
    def test_a_double_click_sets_the_isovalue_under_the_mouse(self):
        ((isovalue,),) = read_isovalues("set.pvsm")
        # At 0.4 of a chart's width, whose axis goes from 20 to 300 between its margins.
        self.assertGreater(isovalue, 60)
        self.assertLess(isovalue, 132)
        self.assertEqual(isovalue, round(isovalue, 1), "digits that no pixel shows")

    def test_with_ctrl_it_adds_one(self):
        (before,) = read_isovalues("set.pvsm")
        (after,) = read_isovalues("added.pvsm")
        self.assertEqual(after[:-1], before)
        self.assertGreater(after[-1], before[0] + 60)

    def test_each_is_a_step_to_undo(self):
        self.assertEqual(read_isovalues("undone.pvsm"), read_isovalues("set.pvsm"))

    def test_selected_rows_are_isovalues_and_ends_of_ranges(self):
        from paraview import simple

        reader = testing.open_volume("wave.bvol")
        table = simple.servermanager.Fetch(simple.ContourSpectrum(Input=reader))
        column = table.GetRowData().GetArray("Isovalue")
        expected = [column.GetValue(row) for row in (100, 103, 300)]
        picked, other = read_isovalues("rows.pvsm")
        self.assertEqual(picked, expected)
        self.assertNotEqual(other, expected, "a contour of another input")


testing.run()
