# SPDX-License-Identifier: BSD-3-Clause
"""Run by ParaView's window: says whether its list of plugins has ours, and marks it for Auto Load.

The list is what Tools > Manage Plugins shows, and the mark is what its check box sets. The window saves it
when it closes.
"""
from paraview.simple import servermanager

plugins = servermanager.vtkSMProxyManager.GetProxyManager().GetPluginManager().GetLocalInformation()
for index in range(plugins.GetNumberOfPlugins()):
    if plugins.GetPluginName(index) == "ScalableIsosurface":
        print("Listed, loaded:", int(plugins.GetPluginLoaded(index)), flush=True)
        plugins.SetAutoLoad(index, True)
