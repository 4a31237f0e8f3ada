# SPDX-License-Identifier: BSD-3-Clause
"""The chart that GuiContourSpectrum.xml made by Apply alone, as its state file has it."""
import xml.etree.ElementTree as ElementTree

import plugin_testing as testing


class SpectrumChart(testing.TestCase):
    def setUp(self):
        state = ElementTree.parse(testing.state("chart.pvsm"))
        self.view = state.find(".//Proxy[@type='XYChartView']")
        self.lines = state.find(".//Proxy[@type='ContourSpectrumRepresentation']")

    @staticmethod
    def read(proxy, name):
        elements = proxy.find(f"Property[@name='{name}']").findall("Element")
        return [element.get("value") for element in elements]

    def test_shows_the_triangles_alone(self):
        series = self.read(self.lines, "SeriesVisibility")
        shown = [name for name, visible in zip(series[::2], series[1::2]) if visible == "1"]
        self.assertEqual(shown, ["Triangles"])

    def test_is_logarithmic_from_the_least_to_the_most_triangles(self):
        self.assertEqual(self.read(self.view, "LeftAxisLogScale"), ["1"])
        self.assertGreater(float(self.read(self.view, "LeftAxisRangeMinimum")[0]), 0)
        self.assertGreater(float(self.read(self.view, "LeftAxisRangeMaximum")[0]), 85000)

    def test_axes_have_titles(self):
        self.assertEqual(self.read(self.view, "LeftAxisTitle"), ["Triangles"])
        self.assertEqual(self.read(self.view, "BottomAxisTitle"), ["RTData"])


testing.run(with_plugin=False)
