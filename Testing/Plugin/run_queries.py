# SPDX-License-Identifier: BSD-3-Clause
"""Extracts, writes, reads, distributes and measures surfaces, and prints nothing itself.

    run_queries.py ScalableIsosurface.so volume.bvol FOLDER
"""
import os
import sys

from paraview import simple

plugin, volume, folder = sys.argv[1:]
simple.LoadPlugin(plugin, remote=True, ns=vars(simple))
reader = simple.OpenDataFile(volume)
reader.UpdatePipeline()
surface = simple.Isosurface(Input=reader, ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0])
surface.UpdatePipeline()
simple.DistributeIsosurface(Input=surface).UpdatePipeline()
simple.ContourSpectrum(Input=reader).UpdatePipeline()
path = os.path.join(folder, "surface.eix")
simple.SaveData(path, proxy=surface)
simple.OpenDataFile(path).UpdatePipeline()
simple.SaveData(os.path.join(folder, "copy.bvol"), proxy=simple.Wavelet())
