# SPDX-License-Identifier: BSD-3-Clause
"""For the window: loads the plugin as a line of its Python shell does. From the environment:
PLUGIN_TO_LOAD.
"""
import os

from paraview.simple import *

LoadPlugin(os.environ["PLUGIN_TO_LOAD"], remote=False, ns=globals())
Isosurface  # the function is there at once
