# SPDX-License-Identifier: BSD-3-Clause
"""Apply on Contour Spectrum makes a line chart over the isovalue, with the right numbers."""

from paraview import servermanager, simple

import plugin_testing as testing

COLUMNS = ["Isovalue", "Triangles", "ActiveCells", "ActiveBlocks", "Bytes", "Area", "Volume"]


def fetch(source):
    """The table's columns, as lists."""
    table = servermanager.Fetch(source)
    return {
        table.GetColumnName(column): [
            table.GetValue(row, column).ToDouble() for row in range(table.GetNumberOfRows())
        ]
        for column in range(table.GetNumberOfColumns())
    }


def find_series(view):
    """The names of the curves that the chart draws."""
    chart = view.SMProxy.GetClientSideObject().GetContextItem()
    return {chart.GetPlot(index).GetLabel() for index in range(chart.GetNumberOfPlots())}


class ContourSpectrum(testing.TestCase):
    def test_of_a_volume_is_that_of_its_image(self):
        stored = fetch(simple.ContourSpectrum(Input=testing.open_volume("wave.bvol")))
        source = testing.open_image()
        counted = fetch(simple.ContourSpectrum(Input=source))
        self.assertEqual(list(stored), COLUMNS)
        self.assertGreater(len(stored["Isovalue"]), 1000)
        for name in COLUMNS[:3]:
            with self.subTest(name=name):
                self.assertEqual(stored[name], counted[name])
        for name in COLUMNS[5:]:
            with self.subTest(name=name):
                for ours, expected in zip(stored[name], counted[name]):
                    self.assertAlmostEqual(ours, expected, delta=1 + 1e-3 * expected)

    def test_has_the_triangles_of_the_contour(self):
        reader = testing.open_volume("wave.bvol")
        table = fetch(simple.ContourSpectrum(Input=reader))
        row = len(table["Isovalue"]) // 2
        contour = simple.Isosurface(Input=reader, Isosurfaces=[table["Isovalue"][row]])
        contour.UpdatePipeline()
        cells = contour.GetDataInformation().GetNumberOfCells()
        self.assertEqual(table["Triangles"][row], cells)

    def test_is_shown_as_lines_over_the_isovalue(self):
        spectrum = simple.ContourSpectrum(Input=testing.open_volume("wave.bvol"))
        spectrum.UpdatePipeline()
        controller = servermanager.vtkSMParaViewPipelineControllerWithRendering()
        # What Apply does: the view that the filter asks for.
        view = controller.ShowInPreferredView(spectrum.SMProxy, 0, None)
        self.assertEqual(view.GetXMLName(), "XYChartView")
        chart = servermanager._getPyProxy(view)
        lines = simple.GetDisplayProperties(spectrum, view=chart)
        self.assertEqual(str(lines.XArrayName).strip("'"), "Isovalue")
        self.assertEqual(lines.UseIndexForXAxis, 0)
        simple.Render(chart)
        simple.SaveScreenshot(testing.output("chart.png"), chart)
        self.assertLessEqual(set(COLUMNS[1:]), find_series(chart))
        table = fetch(spectrum)
        bottom = chart.SMProxy.GetClientSideObject().GetContextItem().GetAxis(1)
        self.assertLessEqual(bottom.GetMinimum(), table["Isovalue"][0])
        self.assertGreaterEqual(bottom.GetMaximum(), table["Isovalue"][-1])
        self.assertLess(bottom.GetMaximum(), 2 * table["Isovalue"][-1])

    def test_has_columns_for_the_stores(self):
        spectrum = simple.ContourSpectrum(Input=testing.open_volume("wave.bvol"))
        spectrum.ColumnsPerStore = "Triangles"
        table = fetch(spectrum)
        stores = [name for name in table if name.startswith("Triangles[")]
        self.assertTrue(stores)
        for row, triangles in enumerate(table["Triangles"]):
            self.assertEqual(sum(table[name][row] for name in stores), triangles)


testing.run()
