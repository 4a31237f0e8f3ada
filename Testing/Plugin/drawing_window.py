# SPDX-License-Identifier: BSD-3-Clause
"""What the window of GuiDrawing.xml showed of a surface that was drawn in portions."""
import re

import plugin_testing as testing


class DrawingWindow(testing.TestCase):
    def read(self, name):
        return testing.read_image(testing.state(name))

    def test_images_in_portions_are_those_of_one(self):
        portions = [int(n) for n in re.findall(r"drawn in (\d+) portions", testing.read_window_log())]
        self.assertGreater(max(portions), 1, portions)  # the faster the machine, the fewer
        for image in range(3):
            shown, drawn = self.read(f"shown{image}.png"), self.read(f"drawn{image}.png")
            self.assertGreater((shown != shown[0, 0]).any(axis=2).mean(), 0.05, "nothing is shown")
            self.assertEqual((shown != drawn).sum(), 0, f"image {image}")

    def test_the_camera_was_turned_and_came_nearer(self):
        images = [self.read(f"drawn{image}.png") for image in range(3)]
        for before, after in zip(images, images[1:]):
            self.assertGreater((before != after).any(axis=2).mean(), 0.05)

    def test_the_wheel_shows_a_thinned_surface_at_once(self):
        at_once, whole = self.read("after1.png"), self.read("drawn2.png")
        self.assertGreater((self.read("drawn1.png") != at_once).any(axis=2).mean(), 0.05, "it is the image before")
        self.assertGreater((whole != at_once).any(axis=2).mean(), 0.01, "it was drawn as a whole")


testing.run()
