# SPDX-License-Identifier: BSD-3-Clause
"""ScalableIsosurface for any ParaView since 5.9, without a build: *Tools > Manage Plugins > Load New*.

The package scalable_isosurface lies in the folder beside this file."""

import os
import platform
import sys

from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkVersion

FOLDER = os.path.dirname(os.path.abspath(__file__))


def find_system_error():
    """What of this system the library does not run on; "" if nothing."""
    wanted = "Linux on x86_64 with glibc"
    found = f"{platform.system()} on {platform.machine()} with {platform.libc_ver()[0] or 'another C library'}"
    return "" if found == wanted else f" (it is for {wanted}, and this is {found})"


def find_loaded():
    """The file of another plugin of this name that is loaded; "" if there is none."""
    from paraview.modules.vtkRemotingCore import vtkPVPluginTracker

    tracker = vtkPVPluginTracker.GetInstance()
    for number in range(tracker.GetNumberOfPlugins()):
        file = tracker.GetPluginFileName(number) or ""
        if tracker.GetPluginLoaded(number) and os.path.splitext(os.path.basename(file))[0] == "ScalableIsosurface":
            return "" if os.path.realpath(file) == os.path.realpath(__file__) else file
    return ""


def tell(kind, text):
    """One line, in the window and the terminal."""
    from vtkmodules.vtkParallelCore import vtkMultiProcessController

    controller = vtkMultiProcessController.GetGlobalController()
    if not controller or controller.GetLocalProcessId() == 0:
        show = getattr(vtkOutputWindow.GetInstance(), f"Display{kind}Text")
        show(f"{kind}: ScalableIsosurface: {' '.join(text.split())}\n")


def load_package():
    """The package beside this file, and no other. Raises an ImportError of one line."""
    if vtkVersion.GetVTKMajorVersion() < 9:
        raise ImportError(f"needs ParaView 5.9 or newer, and this one has VTK {vtkVersion.GetVTKVersion()}")
    sys.path.insert(0, FOLDER)
    try:
        import scalable_isosurface as package

        loaded, beside = (os.path.realpath(path) for path in (package.__path__[0], os.path.join(FOLDER, package.__name__)))
        if loaded != beside and os.path.isdir(beside):
            raise ImportError(f"{beside} cannot be loaded, since {loaded} is loaded already")
        import scalable_isosurface._plugin
    except ImportError as error:
        if error.name == "numpy":
            raise ImportError(f"needs NumPy, which ParaView's Python has not: {error}") from None
        raise ImportError(f"{error}{find_system_error()}") from None
    finally:
        sys.path.remove(FOLDER)
    return package


class Definitions:
    """Has what ParaView's loader looks for: the XML of a plugin. A plugin that cannot work has no proxies: where loading
    fails, ParaView tells of five other things."""

    _pvsm_proxy_xml = "<ServerManagerConfiguration/>"


paraview_plugin_name = "ScalableIsosurface"
try:
    loaded = find_loaded()
    if loaded:
        tell("Warning", f"{__file__}: is not loaded, since {loaded} is loaded already")
    else:
        package = load_package()
        paraview_plugin_version = package.__version__
        Definitions._pvsm_proxy_xml = package._plugin.DEFINITIONS
except (ImportError, OSError, SyntaxError) as error:  # of the package, or of the XML in it
    paraview_plugin_name += " (cannot be used)"
    tell("Error", f"is not loaded: {error}")
