# SPDX-License-Identifier: BSD-3-Clause
"""Draws a surface from ever new directions until somebody kills a rank:

    pvbatch draw_forever.py PLUGIN VOLUME VIEW FOLDER

Each rank leaves its process number in a file FOLDER/RANK; "drawn" is there after the first frame.
"""
import os
import sys

from paraview import simple

plugin, volume, view_name, folder = sys.argv[1:]
simple.LoadPlugin(plugin, remote=True, ns=vars(simple))
view = simple.CreateView(view_name)
view.ViewSize = [300, 300]
reader = simple.BlockedVolumeReader(FileName=volume)
contour = simple.Isosurface(Input=reader, ContourBy=["POINTS", "RTData"], Isosurfaces=[150])
simple.Show(contour, view)
numbers = simple.ProgrammableSource(
    Script=f"""
import os
from vtkmodules.vtkParallelCore import vtkMultiProcessController
rank = vtkMultiProcessController.GetGlobalController().GetLocalProcessId()
with open(os.path.join({folder!r}, str(rank)), "w") as file:
    file.write(str(os.getpid()))
"""
)
numbers.UpdatePipeline()
frame = 0
while True:
    simple.GetActiveCamera().Azimuth(7)
    simple.Render(view)
    frame += 1
    if frame == 3:
        open(os.path.join(folder, "drawn"), "w").close()
