# SPDX-License-Identifier: BSD-3-Clause
"""A client of client_and_server.py: what the ranks of a server show of the same scene.

Without --wall SaveScreenshot writes the image, wall.png; with it each rank of the server writes
its tile of the wall as tile-RANK.npy.
"""
from paraview import simple

import plugin_testing

# In the server's ranks. A wall's window has the size of all of it, and the tile in a corner.
SAVE_TILE = """
import numpy
from paraview.modules import vtkRemotingViews  # for the classes' methods
from paraview.modules.vtkRemotingCore import vtkProcessModule
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

module = vtkProcessModule.GetProcessModule()
session = module.GetActiveSession() or module.GetSession()
window = session.GetSIObject({view}).GetVTKObject().GetRenderWindow()
pixels = vtkUnsignedCharArray()
window.GetPixelData(0, 0, {columns} - 1, {rows} - 1, 1, pixels, 0)
numpy.save(
    "{folder}/tile-%d.npy" % module.GetPartitionId(),
    vtk_to_numpy(pixels).reshape({rows}, {columns}, 3),
)
"""
TILE = 400  # of ParaView's walls in windows with borders


def make_view(size):
    wave = simple.Wavelet(WholeExtent=[-10, 10, -10, 10, -10, 10])
    surface = simple.Contour(
        Input=wave, ContourBy=["POINTS", "RTData"], Isosurfaces=[120.0, 200.0]
    )
    view = simple.CreateView("MetabufferRenderView" if plugin_testing.arguments.wall else "RenderView")
    view.ViewSize = size
    view.RemoteRenderThreshold = 0
    # Tiles have their own, and their edges show.
    view.OrientationAxesVisibility = 0
    view.UseFXAA = 0
    simple.ColorBy(simple.Show(surface, view), ("POINTS", "RTData"))
    view.CameraPosition, view.CameraFocalPoint = (38, 30, 57), (0, 0, 0)
    view.CameraViewUp, view.CameraViewAngle = (0, 1, 0), 30
    layout = simple.CreateLayout("wall")
    simple.AssignViewToLayout(view, layout)
    layout.SetSize(*size)
    return view, wave


plugin_testing.parse_arguments()
plugin_testing.load_plugin()
SIZE = [TILE * plugin_testing.arguments.ranks, TILE]
VIEW, WAVE = make_view(SIZE)
simple.Render(VIEW)
if plugin_testing.arguments.wall:
    script = simple.ProgrammableFilter(Input=WAVE)
    script.Script = SAVE_TILE.format(
        view=VIEW.SMProxy.GetGlobalID(),
        columns=TILE,
        rows=TILE,
        folder=plugin_testing.arguments.output,
    )
    script.UpdatePipeline()
else:
    simple.SaveScreenshot(plugin_testing.output("wall.png"), VIEW, ImageResolution=SIZE)
