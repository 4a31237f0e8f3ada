# SPDX-License-Identifier: BSD-3-Clause
"""The isovalue is animated and the frames are saved: each shows the exact surface of its isovalue."""

from paraview import simple

import plugin_testing as testing

FIRST, LAST, FRAMES = 120.0, 180.0, 4


class Animation(testing.TestCase):
    def test_each_frame_is_the_image_of_its_isovalue(self):
        contour = testing.contour(testing.open_volume("wave.bvol"), FIRST)
        view = testing.make_view()
        testing.show_surface(contour, view)
        track = simple.GetAnimationTrack("ContourValues", index=0, proxy=contour)
        start, end = simple.CompositeKeyFrame(), simple.CompositeKeyFrame()
        start.KeyTime, start.KeyValues, start.Interpolation = 0.0, [FIRST], "Ramp"
        end.KeyTime, end.KeyValues = 1.0, [LAST]
        track.KeyFrames = [start, end]
        scene = simple.GetAnimationScene()
        scene.PlayMode = "Sequence"
        scene.NumberOfFrames = FRAMES
        size = testing.IMAGE_SIZE
        # Since 5.13, ParaView's default is one frame where no source has time steps.
        window = [0, FRAMES - 1]
        path = testing.output("frame.png")
        simple.SaveAnimation(path, view, ImageResolution=size, FrameWindow=window)
        track.Enabled = 0
        for frame in range(FRAMES):
            isovalue = FIRST + frame * (LAST - FIRST) / (FRAMES - 1)
            with self.subTest(isovalue=isovalue):
                contour.Isosurfaces = [isovalue]
                self.check_triangles(contour, isovalue)
                still = testing.output(f"still-{frame}.png")
                simple.SaveScreenshot(still, view, ImageResolution=size)
                still = testing.read_image(still)
                shown = testing.read_image(testing.output(f"frame.{frame:04}.png"))
                self.assertLess((shown != still).any(axis=2).mean(), 1e-3)
                self.assertGreater((still != still[0, 0]).any(axis=2).mean(), 0.05)


testing.run()
