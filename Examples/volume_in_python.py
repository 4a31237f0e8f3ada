#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From a file to a slice, an isosurface and a picture of both, with NumPy and Matplotlib alone: the head MRI of
Debian's mricron-data, or any file that scalable_isosurface opens.

    PYTHONPATH=build/release/lib/python3/dist-packages python3 Examples/volume_in_python.py [FILE [ISOVALUE]]
"""

import sys

import matplotlib.pyplot as plot
import scalable_isosurface as si

scan = sys.argv[1] if len(sys.argv) > 1 else "/usr/share/mricron/templates/ch2.nii.gz"
volume = si.open(scan)
print(volume, "spacing", volume.spacing)
isovalue = float(sys.argv[2]) if len(sys.argv) > 2 else 40
surface = volume.isosurface(isovalue)
print(f"The surface has {len(surface.triangles)} triangles and {len(surface.points)} points.")
_, (left, right) = plot.subplots(1, 2, figsize=(10, 5), subplot_kw={"aspect": "equal"})
left.imshow(volume[len(volume) // 2], cmap="gray", origin="lower")
right.scatter(*surface.points[::20, :2].T, 1, surface.points[::20, 2])
plot.savefig("volume_in_python.png")
