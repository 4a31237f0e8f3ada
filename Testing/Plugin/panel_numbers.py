# SPDX-License-Identifier: BSD-3-Clause
"""What GuiNumbers.xml and GuiEdgeIndexRegion.xml typed into panels, as their state files have it; the
pages that "?" opens."""
import glob
import os
import re
import sqlite3
import unittest
import xml.etree.ElementTree as ElementTree
import zlib

import plugin_testing as testing


def read(path, proxy, name):
    state = ElementTree.parse(os.path.join(testing.arguments.states, path))
    elements = state.findall(f".//Proxy[@type='{proxy}']/Property[@name='{name}']/Element")
    return [float(element.get("value")) for element in elements]


class Panels(unittest.TestCase):
    def test_a_budget_of_triangles_is_a_64_bit_number(self):
        path = "GuiNumbers/numbers.pvsm"
        self.assertEqual(read(path, "StabbingContour", "MaximumTriangles"), [6e9])

    def test_region_of_an_edge_index_file_is_a_box_of_the_world(self):
        # The bounds of the surface's box: the grid of wave.vti.
        path = "GuiEdgeIndexRegion/reset.pvsm"
        self.assertEqual(read(path, "EdgeIndexReader", "RegionPosition"), [-40, -35, -30])
        self.assertEqual(read(path, "EdgeIndexReader", "RegionLength"), [81, 75, 66])
        path = "GuiEdgeIndexRegion/typed.pvsm"
        self.assertEqual(read(path, "EdgeIndexReader", "RegionPosition"), [-40, -35, -30])
        self.assertEqual(read(path, "EdgeIndexReader", "RegionLength"), [30, 75, 66])

    def read_help(self):
        """The names and the contents of all pages and images."""
        if not os.path.exists(testing.arguments.help):
            self.skipTest("this ParaView makes no help for plugins")
        pages = sqlite3.connect(testing.arguments.help)
        contents = "SELECT Name, Data FROM FileNameTable JOIN FileDataTable ON FileId = Id"
        return {name: zlib.decompress(data[4:]) for name, data in pages.execute(contents) if name}

    def test_the_guide_is_in_the_help_with_its_images(self):
        pages = self.read_help()
        names = glob.glob(os.path.join(testing.arguments.documentation, "reference", "*.md"))
        names = [os.path.splitext(os.path.basename(name))[0] for name in names]
        for page in ["tour", "window", "user-guide"] + names:
            text = pages[f"{page}.html"].decode()
            for target in re.findall(r'(?:href|src)="([^"#]+)', text):
                if not target.startswith("http"):
                    self.assertIn(target, set(pages), page)
            for target in re.findall(r'href="#([^"]+)', text):
                self.assertTrue(f'id="{target}"' in text, target)
        self.assertTrue(b'src="images/tour/1.png"' in pages["tour.html"])

    def test_every_filter_and_reader_has_a_page_that_help_finds(self):
        names = self.read_help()
        for path in glob.glob(os.path.join(testing.arguments.xml, "*.xml")):
            for group in ElementTree.parse(path).getroot().findall("ProxyGroup"):
                if group.get("name") in ("filters", "sources", "writers"):
                    for proxy in group:
                        with self.subTest(proxy=proxy.get("name")):
                            # What ParaView's help reaction looks for.
                            self.assertIn(f"{group.get('name')}.{proxy.get('name')}.html", names)


def add_arguments(parser):
    parser.add_argument("--states", required=True, help="the folder of the GUI tests' output")
    parser.add_argument("--xml", required=True, help="the folder of the plugin's XML files")
    parser.add_argument("--documentation", required=True, help="the folder of the pages for users")
    parser.add_argument("--help-file", dest="help", required=True, help="the .qch of the plugin")


if __name__ == "__main__":
    testing.parse_arguments(add_arguments)
    testing.run()
