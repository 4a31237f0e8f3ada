# SPDX-License-Identifier: BSD-3-Clause
"""For the window: a contour whose isovalue is animated. HAND_VOLUME names the volume."""
import os

from paraview import simple

FIRST, LAST, FRAMES = 120.0, 180.0, 4

reader = simple.OpenDataFile(os.environ["HAND_VOLUME"])
contour = simple.Isosurface(Input=reader, Isosurfaces=[FIRST])
simple.Show(contour)
simple.ResetCamera()
track = simple.GetAnimationTrack("ContourValues", index=0, proxy=contour)
start, end = simple.CompositeKeyFrame(), simple.CompositeKeyFrame()
start.KeyTime, start.KeyValues, start.Interpolation = 0.0, [FIRST], "Ramp"
end.KeyTime, end.KeyValues = 1.0, [LAST]
track.KeyFrames = [start, end]
scene = simple.GetAnimationScene()
scene.PlayMode = "Sequence"
scene.NumberOfFrames = FRAMES
