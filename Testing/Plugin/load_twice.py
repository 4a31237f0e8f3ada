# SPDX-License-Identifier: BSD-3-Clause
"""The plugin, which PV_PLUGIN_PATH has loaded, is loaded by a script in every way: the path of its file,
and of a copy of that, are the arguments. What is printed, the test looks at.
"""
import os
import shutil
import sys

from paraview import simple

plugin, copy = sys.argv[1:]
assert hasattr(simple, "StabbingContour"), "PV_PLUGIN_PATH has not loaded it"
os.makedirs(os.path.dirname(copy), exist_ok=True)
shutil.copy(plugin, copy)
folder, name = os.path.split(plugin)
for path in (plugin, plugin, os.path.join(folder, ".", name), copy):
    for remote in (True, False):
        simple.LoadPlugin(path, remote=remote, ns=globals())
simple.LoadDistributedPlugin("ScalableIsosurface", ns=globals())
surface = StabbingContour(Input=simple.Wavelet(), ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0])
surface.UpdatePipeline()
print("triangles:", surface.GetDataInformation().GetNumberOfCells())
