# SPDX-License-Identifier: BSD-3-Clause
"""For the window of window_stress.py: an isosurface of four time steps, and a slice. STRESS_VOLUME names
the volume."""
import os

from paraview import simple

reader = simple.OpenDataFile(os.environ["STRESS_VOLUME"])
contour = simple.Isosurface(Input=reader, Isosurfaces=[150.0])
slice_of_volume = simple.VolumeSlice(Input=reader)
for shown in (slice_of_volume, contour):
    simple.Show(shown)
simple.ResetCamera()
simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
simple.SetActiveSource(contour)
