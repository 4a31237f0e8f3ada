# SPDX-License-Identifier: BSD-3-Clause
"""What the plugin's proxies offer: names, defaults, and a tooltip for each property."""
import glob
import os
import xml.etree.ElementTree

from paraview import servermanager, simple

import plugin_testing as testing

updates = []


class Proxies(testing.TestCase):
    def test_every_proxy_and_property_has_a_documentation(self):
        files = glob.glob(os.path.join(testing.arguments.xml, "*.xml"))
        self.assertTrue(files)
        for path in files:
            root = xml.etree.ElementTree.parse(path).getroot()
            for proxy in root.iter():
                if not proxy.tag.endswith("Proxy") or not proxy.get("class"):
                    continue
                with self.subTest(file=os.path.basename(path), proxy=proxy.get("name")):
                    documentation = proxy.find("Documentation")
                    self.assertTrue(documentation.text.strip())
                    self.assertTrue(documentation.get("short_help"))
                    self.assertTrue(documentation.get("long_help"))
                for element in proxy:
                    if not element.tag.endswith("Property"):
                        continue
                    with self.subTest(proxy=proxy.get("name"), property=element.get("name")):
                        self.assertTrue((element.findtext("Documentation") or "").strip())

    def test_plugin_updates_the_definitions_once(self):
        # At each update the window makes all of its menus anew, which takes half a second.
        self.assertEqual(len(updates), 1)

    def test_nobody_can_edit_what_a_proxy_tells(self):
        # In a panel such a property is a field like any other. ParaView leaves out lists alone.
        for path in glob.glob(os.path.join(testing.arguments.xml, "*.xml")):
            root = xml.etree.ElementTree.parse(path).getroot()
            for element in root.iter():
                if element.get("information_only") != "1" or not element.get("number_of_elements"):
                    continue
                with self.subTest(file=os.path.basename(path), property=element.get("name")):
                    decorator = element.find("Hints/PropertyWidgetDecorator")
                    self.assertTrue(
                        element.get("panel_widget") == "information_line"
                        or element.get("panel_visibility") == "never"
                        or (decorator is not None and decorator.get("value") == "-1")
                    )

    def check_properties(self, proxy, names):
        for name in names:
            with self.subTest(name=name):
                self.assertIn(name, dir(proxy))
        for name in proxy.ListProperties():
            tooltip = proxy.GetProperty(name).SMProperty.GetDocumentation()
            with self.subTest(name=name):
                self.assertTrue(tooltip and tooltip.GetDescription().strip())

    def test_reader_has_its_properties(self):
        reader = testing.open_volume("wave.bvol")
        self.check_properties(
            reader, ["FileName", "PointArrayStatus", "MemoryLimit", "CacheSize"]
        )
        self.assertEqual(list(reader.PointArrayStatus), ["RTData"])

    def test_contour_has_the_properties_of_the_stock_one_with_its_defaults(self):
        reader = testing.open_volume("wave.bvol")
        ours = simple.Isosurface(Input=reader)
        names = ["ContourBy", "ComputeNormals", "ComputeScalars", "GenerateTriangles"]
        self.check_properties(ours, names + ["Component", "Isosurfaces"])
        options = ["InterpolatedArrays", "DropDegenerateTriangles", "CloseBoundary", "Inside", "UseRegion"]
        options += ["RegionPosition", "RegionLength", "FrustumPlanes"]
        options += ["IslandSize", "MinimumIslandSize", "MaximumIslands", "UseIslandPoint"]
        options += ["IslandPoint", "ComputeIslandIds", "IslandSummary"]
        options += ["Level", "TimeBudget", "MaximumTriangles", "Progressive", "Refine", "Final"]
        options += ["RefinementMemory", "SkipNotANumber"]
        self.check_properties(ours, options)
        source = testing.open_image()
        stock = simple.Contour(Input=source)
        self.assertEqual(ours.Level, 0)
        for name in names:
            with self.subTest(name=name):
                self.assertEqual(str(getattr(ours, name)), str(getattr(stock, name)))

    def test_earlier_names_are_accepted(self):
        reader = testing.open_volume("wave.bvol")
        old = simple.StabbingContour(Input=reader, Isosurfaces=[testing.ISOVALUE], SkipNaN=1, Level=1)
        new = simple.Isosurface(Input=reader, Isosurfaces=[testing.ISOVALUE], SkipNotANumber=1, Level=1)
        self.assertEqual(testing.count_cells(old), testing.count_cells(new))
        self.assertEqual(new.SMProxy.GetXMLName(), "Isosurface")
        display = simple.Show(old, testing.make_view())
        simple.Render()
        self.assertEqual(display.SMProxy.GetXMLName(), "IsosurfaceRepresentation")
        self.assertTrue(display.LookupTable.InterpretValuesAsCategories)

    def test_NaN_is_skipped_by_either_name(self):
        holes = simple.ProgrammableFilter(Input=testing.open_image())
        holes.Script = """
import numpy
samples = inputs[0].PointData["RTData"]
output.PointData.append(numpy.where(samples > 200, numpy.nan, samples), "Holes")
"""
        holes.UpdatePipeline()
        for name in ("SkipNaN", "SkipNotANumber"):
            with self.subTest(name=name):
                surface = simple.Isosurface(
                    Input=holes, ContourBy=["POINTS", "Holes"], Isosurfaces=[testing.ISOVALUE]
                )
                cells = []
                for skips in (0, 1, 0):
                    setattr(surface, name, skips)
                    cells.append(testing.count_cells(surface))
                self.assertLess(cells[1], cells[0])
                self.assertEqual(cells[2], cells[0])

    def test_levels_end_with_the_coarsest_of_the_volume(self):
        def get_maximum(contour):
            return contour.GetProperty("Level").SMProperty.GetDomain("range").GetMaximum(0)

        contour = testing.contour(testing.open_volume("wave.bvol"))
        coarsest = get_maximum(contour)
        contour.Level = 64  # beyond the coarsest it is that
        contour.UpdatePipeline()
        self.assertEqual(contour.FieldData["Level"].GetRange(), (coarsest, coarsest))
        self.assertGreaterEqual(coarsest, 4, "blocks of 16 cells have levels of 16 to 1 cells")
        source = testing.open_image()
        self.assertEqual(get_maximum(simple.Isosurface(Input=source)), 0)

    def test_writer_has_its_properties_in_save_data(self):
        source = testing.open_image()
        writer = simple.CreateWriter(testing.output("new.bvol"), source)
        self.check_properties(
            writer, ["FileName", "BlockSize", "NumberOfStores", "Distribution", "RandomSeed"]
        )
        self.check_properties(
            writer,
            ["ChooseArraysToWrite", "PointDataArrays", "WriteAllTimeSteps", "AppendTimeStep"],
        )

    def test_distribution_has_its_properties(self):
        contour = testing.contour(testing.open_volume("wave.bvol"))
        surface = simple.DistributeIsosurface(Input=contour)
        names = ["Mode", "MaximumError", "NormalError", "ArrayError", "Profile", "DrawingRanks"]
        self.check_properties(surface, names + ["RoundBytes", "NumberOfThreads"])
        self.assertEqual(surface.Mode, "Lossless")
        self.assertEqual(surface.Profile, "Working")

    def test_edge_index_files_have_their_writer_and_reader(self):
        contour = testing.contour(testing.open_volume("wave.bvol"))
        path = testing.output("new.eix")
        writer = simple.CreateWriter(path, contour)
        names = ["FileName", "Mode", "MaximumError", "QuantizationBits", "Profile", "PreviewLevel"]
        names += ["WriteArrays", "ArrayError", "WriteNormals", "NormalError"]
        self.check_properties(writer, names + ["MemoryLimit", "WriteAllTimeSteps"])
        writer.UpdatePipeline()
        reader = simple.OpenDataFile(path)
        names = ["Preview", "UseRegion", "RegionPosition", "RegionLength"]
        self.check_properties(reader, names + ["ComputeScalars", "ComputeNormals"])


definitions = servermanager.ActiveConnection.Session.GetSessionProxyManager().GetProxyDefinitionManager()
definitions.AddObserver(
    servermanager.vtkSIProxyDefinitionManager.ProxyDefinitionsUpdated, lambda *_: updates.append(1)
)
testing.run()
