# SPDX-License-Identifier: BSD-3-Clause
"""What GuiIsovaluesOfSeries.xml did by the buttons of the time: each time that it went to has a coarse
surface first, and the exact one where it came to rest."""

from paraview import simple

import plugin_testing as testing


class SeriesWindow(testing.TestCase):
    def test_each_time_is_coarse_first_and_exact_at_rest(self):
        series = testing.open_volume("series.bvol")
        # The default isovalue, in the middle of the first time step's values.
        contour = simple.Isosurface(Input=series)
        exact = []
        for time in range(4):
            contour.UpdatePipeline(time)
            exact.append(contour.GetDataInformation().GetNumberOfCells())
        surfaces = testing.find_triangles(testing.read_window_log())[1:]  # behind the composite
        # Applied, to the end, to the begin; then played: 1, 2, 3.
        rests = [1, 3, 5, 9]
        self.assertEqual([surfaces[n] for n in rests], [exact[0], exact[3], exact[0], exact[3]])
        self.assertEqual(len(surfaces), rests[-1] + 1)
        coarse = [count for n, count in enumerate(surfaces) if n not in rests]
        for count, time in zip(coarse, [0, 3, 0, 1, 2, 3]):
            self.assertLess(10 * count, exact[time])


testing.run()
