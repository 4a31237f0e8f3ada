# SPDX-License-Identifier: BSD-3-Clause
"""What GuiNumbers.xml and GuiEdgeIndexRegion.xml typed into panels, as their state files have it; the
pages that "?" opens."""
import glob
import os
import re
import sqlite3
import xml.etree.ElementTree as ElementTree
import zlib

import plugin_testing as testing


class Panels(testing.TestCase):
    def test_a_budget_of_triangles_is_a_64_bit_number(self):
        path = "GuiNumbers/numbers.pvsm"
        self.assertEqual(testing.read_state(path, "Isosurface", "MaximumTriangles"), [[6e9]])

    def test_a_grid_is_that_of_the_file_but_for_what_is_typed(self):
        path = "GuiNumbers/numbers.pvsm"
        self.assertEqual(testing.read_state(path, "BlockedVolumeReader", "Spacing"), [[1, 1, 2.5]])
        self.assertEqual(testing.read_state(path, "BlockedVolumeReader", "Origin"), [[]])

    def test_region_of_an_edge_index_file_is_a_box_of_the_world(self):
        # The bounds of the surface's box: the grid of wave.vti.
        path = "GuiEdgeIndexRegion/reset.pvsm"
        self.assertEqual(testing.read_state(path, "EdgeIndexReader", "RegionPosition"), [[-40, -35, -30]])
        self.assertEqual(testing.read_state(path, "EdgeIndexReader", "RegionLength"), [[81, 75, 66]])
        path = "GuiEdgeIndexRegion/typed.pvsm"
        self.assertEqual(testing.read_state(path, "EdgeIndexReader", "RegionPosition"), [[-40, -35, -30]])
        self.assertEqual(testing.read_state(path, "EdgeIndexReader", "RegionLength"), [[30, 75, 66]])

    def read_help(self):
        """The names and the contents of all pages and images."""
        if not os.path.exists(testing.arguments.help_file):
            self.skipTest("this ParaView makes no help for plugins")
        pages = sqlite3.connect(testing.arguments.help_file)
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


testing.run(with_plugin=False)
