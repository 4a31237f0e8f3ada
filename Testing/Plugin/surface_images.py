# SPDX-License-Identifier: BSD-3-Clause
"""The surface as an image and as a table, on N ranks of pvbatch, or of the server at a port:

    surface_images.py ... --ranks N [--port PORT]
"""
import plugin_testing as testing


class SurfaceImages(testing.TestCase):
    def test_surface_looks_as_in_the_gui_and_costs_a_row_a_rank(self):
        view = testing.make_view()
        surface = testing.contour(testing.open_volume("wave.bvol"))
        testing.show_surface(surface, view)
        self.check_image(view, "StabbingContour.png", "surface.png")
        self.check_costs(surface, testing.ISOVALUE)

        # The comparison would see another surface.
        surface.Isosurfaces = [testing.OTHER_ISOVALUE]
        self.assertGreater(
            testing.compare_image(view, "StabbingContour.png", "another.png"),
            10 * testing.LARGEST_DIFFERENCE,
        )
        self.check_costs(surface, testing.OTHER_ISOVALUE)

    def check_costs(self, surface, isovalue):
        rows = testing.read_costs(surface)
        ranks = range(testing.arguments.ranks)
        self.assertEqual([row["Rank"] for row in rows], [str(rank) for rank in ranks])
        triangles = sum(int(row["Triangles"]) for row in rows)
        self.assertEqual(triangles, testing.count_cells(surface))
        self.assertEqual(triangles, testing.count_expected_triangles(isovalue))
        for row in rows:
            self.assertEqual(
                int(row["ActiveBlocks"]), int(row["BlocksRead"]) + int(row["BlockCacheHits"])
            )


testing.run()
