# SPDX-License-Identifier: BSD-3-Clause
"""What ParaView's Catalyst does of each step that in_situ.py --catalyst hands to it: writes the isosurface.

The plugin is found by its name where it is installed; else PLUGIN is its path in the environment.
"""

import os

from paraview import catalyst, simple

if "PLUGIN" in os.environ:
    simple.LoadPlugin(os.environ["PLUGIN"], remote=False, ns=vars(simple))
else:
    simple.LoadDistributedPlugin("ScalableIsosurface", remote=False, ns=vars(simple))

slab = simple.TrivialProducer(registrationName="input")
surface = simple.Isosurface(Input=slab, ContourBy=["POINTS", "pressure"], Isosurfaces=[0.03])
options = catalyst.Options()
saved = 0


def catalyst_execute(info):
    global saved
    simple.SaveData(f"wave_{saved}.eix", proxy=surface)
    saved += 1
