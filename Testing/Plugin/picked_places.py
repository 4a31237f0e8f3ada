# SPDX-License-Identifier: BSD-3-Clause
"""What is under the mouse: the island to keep, and values on slices and surfaces. The window's keys and
hovering take places as these tests do."""

import vtk.util.numpy_support as arrays
from paraview import servermanager, simple

import plugin_testing as testing

ISOVALUE = 80  # of several islands


def pick(view, place):
    """As the key P: the point of what is shown at a pixel."""
    point, normal = [0.0] * 3, [0.0] * 3
    if view.SMProxy.ConvertDisplayToPointOnSurface(place, point, normal, False):
        return point
    return None


def select_point(source, view, place):
    """As hovering over points: coordinates and value of the point nearest to a pixel."""
    simple.SelectSurfacePoints(Rectangle=[*place, place[0] + 1, place[1] + 1], View=view)
    selected = simple.ExtractSelection(Input=source)
    data = servermanager.Fetch(selected)
    simple.ClearSelection()
    return data.GetPoint(0), data.GetPointData().GetArray("RTData").GetTuple1(0)


class PickedPlaces(testing.TestCase):
    def setUp(self):
        self.image = testing.open_image()
        self.reader = testing.open_volume("wave.bvol")
        self.view = testing.make_view()

    def test_the_island_under_the_mouse_is_kept(self):
        surface = testing.contour(self.reader, ISOVALUE)
        connectivity = simple.Connectivity(
            Input=simple.Contour(Input=self.image, Isosurfaces=[ISOVALUE])
        )
        connectivity.ExtractionMode = "Extract Closest Point Region"
        testing.show_surface(surface, self.view)
        found = set()
        for place in ([x, y] for x in range(30, 300, 40) for y in range(30, 300, 40)):
            surface.UseIslandPoint = 0
            simple.Render(self.view)
            point = pick(self.view, place)
            if point:
                surface.IslandPoint = connectivity.ClosestPoint = point
                surface.UseIslandPoint = 1
                found.add(testing.count_cells(surface))
                self.assertEqual(testing.count_cells(surface), testing.count_cells(connectivity))
        self.assertGreater(len(found), 1, "pixels of several islands")

    def test_a_slice_shown_as_a_surface_tells_its_values(self):
        for normal in ([0, 0, 1], [1, 2, 3]):
            cut = simple.VolumeSlice(Input=self.reader, Normal=normal)
            simple.Show(cut, self.view).Representation = "Surface"
            simple.ResetCamera(self.view)
            simple.Render(self.view)
            point, value = select_point(cut, self.view, [150, 150])
            expected = self.probe(point)
            self.assertAlmostEqual(value, expected, places=3)
            picked = pick(self.view, [150, 150])
            self.assertLess(sum((a - b) ** 2 for a, b in zip(picked, point)) ** 0.5, 2)
            simple.Hide(cut, self.view)

    def probe(self, point):
        """Of stock."""
        place = simple.PointSource(Center=point, Radius=0, NumberOfPoints=1)
        values = simple.ResampleWithDataset(SourceDataArrays=self.image, DestinationMesh=place)
        return arrays.vtk_to_numpy(
            servermanager.Fetch(values).GetPointData().GetArray("RTData")
        )[0]


testing.run()
