# SPDX-License-Identifier: BSD-3-Clause
"""What GuiFirstContact.xml did: a file without an index was shown at once, and exactly at the end."""
import plugin_testing as testing


class FirstContactWindow(testing.TestCase):
    def test_a_sample_is_shown_before_the_index_is_there(self):
        log = testing.read_window_log()
        self.assertIn("large.zarr.bvol: is being written", log)
        before, after = log.split("large.zarr.bvol: up to date")
        self.assertIn("large.zarr.bvol: is being written", before)
        self.assertNotIn("is being written", after)

    def test_the_last_surface_is_that_of_the_whole_file(self):
        from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

        image = testing.make_large_image()
        contour = vtkFlyingEdges3D()
        contour.SetInputConnection(image.GetClientSideObject().GetOutputPort())
        contour.SetValue(0, testing.ISOVALUE)
        contour.Update()
        surfaces = testing.find_triangles(testing.read_window_log())
        self.assertEqual(surfaces[-1], contour.GetOutput().GetNumberOfPolys())


testing.run()
