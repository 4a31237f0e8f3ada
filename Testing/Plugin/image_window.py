# SPDX-License-Identifier: BSD-3-Clause
"""What GuiImage.xml did by hand to an image in memory: surfaces are coarse first and exact last. A
script gets the exact one at once."""

from paraview import simple
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkImagingCore import vtkRTAnalyticSource

import plugin_testing as testing

EXTENT = (-80, 79, -80, 79, -80, 79)
COARSE = 120_000  # triangles of a coarse surface, at most; the exact ones have four times as many


def count_expected_triangles(isovalues):
    source = vtkRTAnalyticSource()
    source.SetWholeExtent(*EXTENT)
    contour = vtkFlyingEdges3D()
    contour.SetInputConnection(source.GetOutputPort())
    for number, isovalue in enumerate(isovalues):
        contour.SetValue(number, isovalue)
    contour.Update()
    return contour.GetOutput().GetNumberOfPolys()


class ImageWindow(testing.TestCase):
    def test_surfaces_are_coarse_first_and_exact_last(self):
        surfaces = testing.find_triangles(testing.read_window_log())
        isovalues = testing.read_state("window.pvsm", "Isosurface", "ContourValues")[0]
        self.assertEqual(len(isovalues), 2)
        self.assertEqual(surfaces[1], count_expected_triangles(isovalues[:1]))
        self.assertEqual(surfaces[-1], count_expected_triangles(isovalues))
        self.assertLess(surfaces[0], COARSE)
        for before, after in zip(surfaces, surfaces[1:]):
            self.assertTrue(before < COARSE or after < COARSE, f"{before}, then {after}")

    def test_a_script_gets_the_exact_surface_at_once(self):
        surface = testing.contour(simple.Wavelet(WholeExtent=EXTENT))
        self.assertEqual(testing.count_cells(surface), count_expected_triangles([testing.ISOVALUE]))
        surface.UpdatePropertyInformation()
        self.assertTrue(surface.Final)


testing.run()
