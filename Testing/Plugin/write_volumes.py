# SPDX-License-Identifier: BSD-3-Clause
"""Writes the volumes that the tests of the plugin read: write_volumes.py PLUGIN FOLDER

    wave.vti    82 x 76 x 67 samples of ParaView's Wavelet, float, at a negative extent
    wave.mhd    the same, which two readers take
    wave.bvol   the same as a blocked volume of 4 stores and blocks of 16 cells
    wave.eix    its isosurface of 150
    series.bvol four time steps: RTData + 10 t
    pair.vtm    two images, of RTData and of RTData + 100
    slab.bvol   RTData, 601 x 601 x 9: slices that are coarse first
    noise.bvol  129^3 samples without order: an isosurface of six million triangles
    large.zarr  161 x 131 x 111 samples of the Wavelet, more than a sample of a file has
    vectors.vti wave.vti with its gradient; here, since pieces would have seams of it between them
"""
import argparse
import glob
import os
import shutil
import sys

from paraview import servermanager, simple
from vtkmodules.vtkIOImage import vtkMetaImageWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

import plugin_testing as testing

plugin, folder = sys.argv[1:3]
os.makedirs(folder, exist_ok=True)
simple.LoadPlugin(plugin, ns=vars(simple))
wave = simple.Wavelet(WholeExtent=[-40, 41, -35, 40, -30, 36])
simple.SaveData(os.path.join(folder, "wave.vti"), proxy=wave, DataMode="Binary")
reader = vtkXMLImageDataReader()
reader.SetFileName(os.path.join(folder, "wave.vti"))
writer = vtkMetaImageWriter()
writer.SetInputConnection(reader.GetOutputPort())
writer.SetFileName(os.path.join(folder, "wave.mhd"))
writer.SetCompression(False)
writer.Write()
vectors = simple.Gradient(Input=wave, ScalarArray=["POINTS", "RTData"])
simple.SaveData(os.path.join(folder, "vectors.vti"), proxy=vectors, DataMode="Binary")
ct = simple.Calculator(
    Input=wave, ResultArrayName="HU", Function="(RTData - 150) * 10", ResultArrayType="Float"
)
simple.SaveData(os.path.join(folder, "ct.vti"), proxy=ct, DataMode="Binary", PointDataArrays=["HU"])
simple.SaveData(
    os.path.join(folder, "wave.bvol"), proxy=wave, BlockSize=16, NumberOfStores=4
)
wave = simple.OpenDataFile(os.path.join(folder, "wave.bvol"))
contour = simple.Isosurface(Input=wave, Isosurfaces=[150])
contour.UpdatePipeline()
simple.SaveData(os.path.join(folder, "wave.eix"), proxy=contour)
testing.arguments = argparse.Namespace(volumes=folder)
series = testing.make_series()
simple.SaveData(os.path.join(folder, "series.bvol"), proxy=series, WriteAllTimeSteps=1)
samples = testing.read_samples(servermanager.Fetch(testing.make_large_image()))
testing.write_zarr(os.path.join(folder, "large.zarr"), samples, 64)
for index in glob.glob(os.path.join(folder, "large.zarr.bvol*")):
    (shutil.rmtree if os.path.isdir(index) else os.remove)(index)  # of an earlier run
image = simple.XMLImageDataReader(FileName=[os.path.join(folder, "wave.vti")])
raised = simple.Calculator(Input=image, ResultArrayName="RTData", Function="RTData + 100")
raised.ResultArrayType = "Float"
pair = simple.GroupDatasets(Input=[image, raised])
simple.SaveData(os.path.join(folder, "pair.vtm"), proxy=pair, DataMode="Binary")
noise = simple.ProgrammableFilter(Input=simple.Wavelet(WholeExtent=[0, 128, 0, 128, 0, 128]))
noise.CopyArrays = 0
noise.Script = """
import numpy
samples = numpy.random.default_rng(1).integers(0, 256, 129**3)
output.PointData.append(samples.astype(numpy.uint8), "Noise")
output.VTKObject.GetPointData().SetActiveScalars("Noise")
"""
simple.SaveData(os.path.join(folder, "noise.bvol"), proxy=noise)
slab = simple.Wavelet(WholeExtent=[0, 600, 0, 600, 0, 8])
simple.SaveData(os.path.join(folder, "slab.bvol"), proxy=slab)
