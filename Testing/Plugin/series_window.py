# SPDX-License-Identifier: BSD-3-Clause
"""What GuiIsovaluesOfSeries.xml did by the buttons of the time: each time that it went to has a coarse
surface first, and the exact one where it came to rest."""
import os
import re
import unittest

from paraview import simple

import plugin_testing as testing


def read_triangles():
    """Of the surfaces that the window's contours made, in their order."""
    path = os.path.join(testing.arguments.states, "window.log")
    with open(path, encoding="utf-8", errors="replace") as file:
        return [int(count) for count in re.findall(r"rank 0: .* (\d+) triangles", file.read())]


class SeriesWindow(unittest.TestCase):
    def test_each_time_is_coarse_first_and_exact_at_rest(self):
        series = testing.open_volume("series.bvol")
        # The default isovalue, in the middle of the first time step's values.
        contour = simple.StabbingContour(Input=series)
        exact = []
        for time in range(4):
            contour.UpdatePipeline(time)
            exact.append(contour.GetDataInformation().GetNumberOfCells())
        surfaces = read_triangles()[1:]  # behind the composite
        # Applied, to the end, to the begin; then played: 1, 2, 3.
        rests = [1, 3, 5, 9]
        self.assertEqual([surfaces[n] for n in rests], [exact[0], exact[3], exact[0], exact[3]])
        self.assertEqual(len(surfaces), rests[-1] + 1)
        coarse = [count for n, count in enumerate(surfaces) if n not in rests]
        for count, time in zip(coarse, [0, 3, 0, 1, 2, 3]):
            self.assertLess(10 * count, exact[time])


if __name__ == "__main__":
    testing.parse_arguments(lambda parser: parser.add_argument("--states"))
    testing.load_plugin()
    testing.run()
