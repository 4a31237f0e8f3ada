# SPDX-License-Identifier: BSD-3-Clause
"""Vectors, chosen arrays, and time steps in ParaView: saved, animated, appended, reloaded."""

from paraview import simple

import plugin_testing


def make_vectors():
    vectors = simple.XMLImageDataReader(FileName=[plugin_testing.volume("vectors.vti")])
    vectors.UpdatePipeline()
    return vectors


class Arrays(plugin_testing.TestCase):
    def test_vectors_are_contoured_by_component_and_by_magnitude(self):
        vectors = make_vectors()
        path = plugin_testing.output("vectors.bvol")
        simple.SaveData(path, proxy=vectors, BlockSize=16, NumberOfStores=3)
        header = plugin_testing.read_header(path)
        components = {array["name"]: array["components"] for array in header["arrays"]}
        self.assertEqual(components, {"RTData": 1, "Gradient": 3})
        reader = plugin_testing.open_volume(path)
        surface = simple.Isosurface(
            Input=reader, ContourBy=["POINTS", "Gradient"], Isosurfaces=[5.0]
        )
        for component, function in enumerate(
            ["dot(Gradient,iHat)", "dot(Gradient,jHat)", "dot(Gradient,kHat)", "mag(Gradient)"]
        ):
            with self.subTest(function=function):
                surface.Component = component
                self.check_triangles(surface, 5.0, function)

    def test_vectors_are_interpolated_with_all_components(self):
        path = plugin_testing.output("interpolated.bvol")
        simple.SaveData(path, proxy=make_vectors(), BlockSize=16)
        surface = plugin_testing.contour(plugin_testing.open_volume(path))
        surface.InterpolatedArrays = ["Gradient"]
        surface.UpdatePipeline()
        array = surface.PointData["Gradient"]
        self.assertEqual(array.GetNumberOfComponents(), 3)
        # Normals are the negative gradient, so the vectors are those of the points.
        check = simple.Calculator(
            Input=surface,
            AttributeType="Point Data",
            Function="dot(Normals,Gradient)/mag(Gradient)",
            ResultArrayName="Cosine",
        )
        check.UpdatePipeline()
        self.assertLess(check.PointData["Cosine"].GetRange()[1], -0.9)

    def test_range_of_isovalues_is_that_of_the_component(self):
        path = plugin_testing.output("ranges.bvol")
        simple.SaveData(path, proxy=make_vectors())
        reader = plugin_testing.open_volume(path)
        surface = simple.Isosurface(Input=reader, ContourBy=["POINTS", "Gradient"])
        domain = surface.GetProperty("Isosurfaces").SMProperty.FindDomain("vtkSMArrayRangeDomain")
        for component in range(4):
            surface.Component = component
            low, high = reader.PointData["Gradient"].GetRange(component if component < 3 else -1)
            self.assertAlmostEqual(domain.GetMinimum(0), low, places=5)
            self.assertAlmostEqual(domain.GetMaximum(0), high, places=5)

    def test_arrays_are_chosen_in_save_data(self):
        path = plugin_testing.output("chosen.bvol")
        simple.SaveData(
            path, proxy=make_vectors(), ChooseArraysToWrite=1, PointDataArrays=["Gradient"]
        )
        self.assertEqual([array["name"] for array in plugin_testing.read_header(path)["arrays"]], ["Gradient"])


class TimeSteps(plugin_testing.TestCase):
    def check_steps(self, reader, times):
        """In an animation, each step shows its own surface."""
        self.assertEqual(list(reader.TimestepValues), times)
        surface = plugin_testing.contour(reader)
        view = plugin_testing.make_view()
        simple.Show(surface, view)
        scene = simple.GetAnimationScene()
        scene.UpdateAnimationUsingDataTimeSteps()
        # Backwards, so that each one is a change.
        for time in reversed(times):
            scene.AnimationTime = time
            self.assertEqual(view.ViewTime, time)
            simple.Render(view)
            # What the view shows, without an update of our own.
            cells = surface.GetDataInformation().GetNumberOfCells()
            expected = plugin_testing.count_expected_triangles(plugin_testing.ISOVALUE - 10 * time)
            self.assertEqual(cells, expected, f"time {time}")
        simple.Delete(view)
        simple.Delete(surface)

    def test_all_are_saved_into_one_file_and_animated(self):
        path = plugin_testing.output("series.bvol")
        simple.SaveData(
            path, proxy=plugin_testing.make_series(), WriteAllTimeSteps=1, BlockSize=16, NumberOfStores=2
        )
        self.assertEqual(
            [step["time"] for step in plugin_testing.read_header(path)["timeSteps"]], [0.0, 1.0, 2.0, 3.0]
        )
        reader = simple.OpenDataFile(path)
        reader.UpdatePipelineInformation()
        self.check_steps(reader, [0.0, 1.0, 2.0, 3.0])
        simple.Delete(reader)

    def test_appended_ones_are_seen_after_reload(self):
        path = plugin_testing.output("appended.bvol")
        series = plugin_testing.make_series()
        reader = None
        for time in range(3):
            series.UpdatePipeline(time)
            simple.GetAnimationScene().AnimationTime = time
            simple.SaveData(path, proxy=series, AppendTimeStep=1, BlockSize=16, NumberOfStores=2)
            if reader is None:
                reader = simple.OpenDataFile(path)
            else:
                simple.ReloadFiles(reader)
            reader.UpdatePipelineInformation()
            times = [float(step) for step in range(time + 1)]
            if len(times) > 1:
                self.check_steps(reader, times)
        simple.Delete(reader)


plugin_testing.run()
