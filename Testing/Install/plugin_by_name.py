# SPDX-License-Identifier: BSD-3-Clause
"""Loads the plugin as it is installed, by its name, and contours with it.

    pvbatch plugin_by_name.py             in this process
    pvpython plugin_by_name.py --server   in a server of its own
"""
import subprocess
import sys

from paraview import simple


def contour():
    simple.LoadDistributedPlugin("ScalableIsosurface", remote=True, ns=vars(simple))
    if simple.servermanager.ActiveConnection.IsRemote():
        simple.LoadDistributedPlugin("ScalableIsosurface", remote=False, ns=vars(simple))
    surface = simple.Isosurface(
        Input=simple.Wavelet(), ContourBy=["POINTS", "RTData"], Isosurfaces=[150.0]
    )
    surface.UpdatePipeline()
    print("Triangles:", surface.GetDataInformation().GetNumberOfCells(), flush=True)


def contour_on_server():
    server = subprocess.Popen(
        ["pvserver", "--server-port=0"], stdout=subprocess.PIPE, text=True, bufsize=1
    )
    try:
        for line in server.stdout:
            if line.startswith("Accepting connection"):
                simple.Connect("localhost", int(line.rsplit(":", 1)[1]))
                break
        contour()
        simple.Disconnect()
    finally:
        server.terminate()
        server.wait()


if "--server" in sys.argv:
    contour_on_server()
else:
    contour()
