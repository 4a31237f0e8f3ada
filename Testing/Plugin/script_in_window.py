# SPDX-License-Identifier: BSD-3-Clause
"""For the Python shell of the window: another isovalue for the contour there, and back."""
from paraview import simple

contour = simple.FindSource("Isosurface1")
before = list(contour.Isosurfaces)
for isovalues in ([140.0], before):
    contour.Isosurfaces = isovalues
    contour.UpdatePipeline()
