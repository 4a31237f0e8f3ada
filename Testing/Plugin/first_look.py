# SPDX-License-Identifier: BSD-3-Clause
"""What is seen before anybody has chosen anything: isovalues that are proposed, and the colors of a first
script and of a CT. On any number of ranks, or of the server at a port: what is proposed is the same."""
from paraview import simple

import plugin_testing as testing

PROPOSED = 161.0  # of RTData, whose range is 37 to 277: not the middle, 157.18
GREY = [-160, 0, 0, 0, 240, 1, 1, 1]


def read_map(display):
    return list(display.LookupTable.RGBPoints)


class FirstLook(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        image = testing.open_image()
        ct = simple.Calculator(
            Input=image, ResultArrayName="HU", Function="(RTData - 150) * 10", ResultArrayType="Float"
        )
        cls.ct = testing.output("ct.bvol")
        simple.SaveData(cls.ct, proxy=ct)

    def propose(self, source, **properties):
        return list(simple.Isosurface(Input=source, **properties).Isosurfaces)

    def test_the_same_isovalue_is_proposed_for_an_image_and_its_volume(self):
        self.assertEqual(self.propose(testing.open_image()), [PROPOSED])
        self.assertEqual(self.propose(testing.open_volume("wave.bvol")), [PROPOSED])

    def test_a_script_need_not_update_the_reader(self):
        self.assertEqual(self.propose(simple.OpenDataFile(testing.volume("wave.bvol"))), [PROPOSED])

    def test_bone_is_proposed_for_hounsfield_units(self):
        for source in (testing.open_volume(self.ct), simple.OpenDataFile(self.ct)):
            self.assertEqual(self.propose(source), [300])
        without_bone = simple.Calculator(
            Input=testing.open_image(), ResultArrayName="HU", Function="RTData", ResultArrayType="Float"
        )
        without_bone.UpdatePipeline()
        self.assertEqual(self.propose(without_bone, ContourBy=["POINTS", "HU"]), [PROPOSED])

    def test_the_proposal_is_that_of_the_component(self):
        vectors = simple.XMLImageDataReader(FileName=[testing.volume("vectors.vti")])
        vectors.UpdatePipeline()
        proposed = [
            self.propose(vectors, ContourBy=["POINTS", "Gradient"], Component=component)
            for component in (0, 3)
        ]
        self.assertLess(abs(proposed[0][0]), 1)  # of both signs
        self.assertGreater(proposed[1][0], 1)  # the magnitude

    def test_a_script_without_ContourBy_has_the_colors_of_one_with_it(self):
        images = []
        for properties in ({}, {"ContourBy": ["POINTS", "RTData"]}):
            view = testing.make_view()
            reader = simple.OpenDataFile(testing.volume("wave.bvol"))
            surface = simple.Isosurface(Input=reader, Isosurfaces=[testing.ISOVALUE], **properties)
            display = simple.Show(surface, view)
            simple.Render(view)
            self.assertTrue(display.LookupTable.InterpretValuesAsCategories)
            simple.ResetCamera(view)
            simple.Render(view)
            images.append(testing.read_window(view))
        self.assertTrue((images[0] == images[1]).all())
        # White, and not the blue at the low end of a map of colors.
        surface = images[0][(images[0] != images[0][0, 0]).any(axis=2)]
        self.assertGreater(len(surface), 3000)
        self.assertLess(float(abs(surface[:, 0] - surface[:, 2]).mean()), 20)

    def test_slices_of_a_ct_are_grey_until_somebody_changes_that(self):
        view = testing.make_view()
        reader = testing.open_volume(self.ct)
        slices = [simple.VolumeSlice(Input=reader, Origin=[0, 0, place]) for place in (0, 10)]
        display = simple.Show(slices[0], view)
        self.assertEqual(display.Representation, "Slice")
        simple.Render(view)
        self.assertEqual(read_map(display), GREY)
        image = testing.read_window(view)
        tissue = image[100:200, 100:200]
        self.assertTrue((tissue.max(axis=2) - tissue.min(axis=2) <= 1).all())
        chosen = [-1000, 1, 0, 0, 1000, 0, 1, 0]
        display.LookupTable.RGBPoints = chosen
        simple.Render(view)
        other = simple.Show(slices[1], view)
        simple.Render(view)
        self.assertEqual((read_map(display), read_map(other)), (chosen, chosen))

    def test_a_volume_is_shown_as_three_slices_through_its_middle(self):
        images = []
        reader = simple.OpenDataFile(testing.volume("wave.bvol"))
        image = testing.open_image()
        extent = image.GetDataInformation().GetExtent()
        for sources in ([reader], [image] * 3):
            view = testing.make_view()
            for axis, source in enumerate(sources):
                if source is image:
                    voi = list(extent)
                    voi[2 * axis] = voi[2 * axis + 1] = sum(extent[2 * axis : 2 * axis + 2]) // 2
                    display = simple.Show(simple.ExtractSubset(Input=image, VOI=voi), view, Representation="Surface")
                    display.Ambient, display.Diffuse, display.Specular = 1, 0, 0
                    simple.ColorBy(display, ("POINTS", "RTData"))
                else:
                    display = simple.Show(reader, view)
                    self.assertEqual(display.Representation, "Three Slices")
                    self.assertEqual(display.ColorArrayName[1], "RTData")
                display.LookupTable.RescaleTransferFunction(37, 277)
            view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [60, 90, 70], [0, 0, 0], [0, 0, 1]
            simple.ResetCamera(view)
            simple.Render(view)
            images.append(testing.read_window(view).astype(int))
        self.assertGreater((images[0] != images[0][0, 0]).any(axis=2).mean(), 0.1)
        self.assertLess((abs(images[0] - images[1]).max(axis=2) > 8).mean(), 0.002)

    def test_what_others_make_of_a_volume_is_shown_as_ever(self):
        for source in (testing.open_image(), simple.OpenDataFile(testing.volume("wave.bvol"))):
            view = testing.make_view()
            display = simple.Show(simple.Contour(Input=source, Isosurfaces=[PROPOSED]), view)
            self.assertEqual((display.SMProxy.GetXMLName(), display.Representation), ("GeometryRepresentation", "Surface"))
            display = simple.Show(simple.Slice(Input=source), view)
            self.assertEqual((display.SMProxy.GetXMLName(), display.Representation), ("GeometryRepresentation", "Surface"))

    def test_a_ct_is_shown_in_grey(self):
        view = testing.make_view()
        display = simple.Show(simple.OpenDataFile(self.ct), view)
        simple.Render(view)
        self.assertEqual((display.Representation, read_map(display)), ("Three Slices", GREY))

    def test_slices_of_others_have_the_map_of_their_range(self):
        view = testing.make_view()
        display = simple.Show(simple.VolumeSlice(Input=testing.open_volume("wave.bvol")), view)
        simple.Render(view)
        self.assertNotEqual(read_map(display), GREY)
        self.assertGreater(len(set(read_map(display)[1:4])), 1)


testing.run()
