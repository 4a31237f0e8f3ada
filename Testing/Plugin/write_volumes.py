# SPDX-License-Identifier: BSD-3-Clause
"""Writes the volumes that the tests of the plugin read: write_volumes.py PLUGIN FOLDER

    wave.vti    82 x 76 x 67 samples of ParaView's Wavelet, float, at a negative extent
    wave.bvol   the same as a blocked volume of 4 stores and blocks of 16 cells
    wave.eix    its isosurface of 150
    vectors.vti wave.vti with its gradient; here, since pieces would have seams of it between them
"""
import os
import sys

from paraview import simple

plugin, folder = sys.argv[1:3]
os.makedirs(folder, exist_ok=True)
simple.LoadPlugin(plugin, ns=vars(simple))
wave = simple.Wavelet(WholeExtent=[-40, 41, -35, 40, -30, 36])
simple.SaveData(os.path.join(folder, "wave.vti"), proxy=wave, DataMode="Binary")
vectors = simple.Gradient(Input=wave, ScalarArray=["POINTS", "RTData"])
simple.SaveData(os.path.join(folder, "vectors.vti"), proxy=vectors, DataMode="Binary")
simple.SaveData(
    os.path.join(folder, "wave.bvol"), proxy=wave, BlockSize=16, NumberOfStores=4
)
wave = simple.OpenDataFile(os.path.join(folder, "wave.bvol"))
contour = simple.StabbingContour(Input=wave, Isosurfaces=[150])
contour.UpdatePipeline()
simple.SaveData(os.path.join(folder, "wave.eix"), proxy=contour)
