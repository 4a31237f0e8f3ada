# SPDX-License-Identifier: BSD-3-Clause
"""A client and its server, which both load the plugin in one file of Python:

    one_file_server.py PLUGIN VOLUMES EXPECTED IMAGE --server HOST:PORT

EXPECTED is what one_file.py --save wrote. The server's surface has as many triangles, and its picture is saved.
"""
import json
import os
import sys

from paraview import servermanager, simple

plugin, volumes, expected, image, _, server = sys.argv[1:7]
host, port = server.split(":")
simple.Connect(host, int(port))
simple.LoadPlugin(plugin, remote=True, ns=vars(simple))
simple.LoadPlugin(plugin, remote=False, ns=vars(simple))
contour = simple.Isosurface(Input=simple.OpenDataFile(os.path.join(volumes, "wave.bvol")))
contour.UpdatePipeline()
with open(expected) as file:
    surfaces = json.load(file)["default"]["ranks"]
found = contour.GetDataInformation().GetNumberOfCells()
assert found == sum(surface["size"][1] for surface in surfaces) > 0, found
view = simple.CreateRenderView(ViewSize=[600, 500])
simple.Show(contour, view)
simple.ResetCamera(view)
simple.SaveScreenshot(image, view)
print(f"{found} triangles by {servermanager.ActiveConnection.GetNumberOfDataPartitions()} ranks")
simple.Disconnect()
