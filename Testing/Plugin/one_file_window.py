# SPDX-License-Identifier: BSD-3-Clause
"""First contact in the window, with the plugin in one file of Python: what is shown is told line by line, until the surface
is exact. ONE_FILE_PLUGIN, ONE_FILE_VOLUME and ONE_FILE_OUTPUT name the plugin, the file and a folder.
"""
import json
import os
import time
import traceback

from paraview import simple

folder = os.environ["ONE_FILE_OUTPUT"]
begin = time.monotonic()
told = []


def look():
    """What is shown now."""
    made = contour.GetClientSideObject(), reader.GetClientSideObject()
    reader.UpdatePropertyInformation()
    shown = {
        "index": str(reader.Index).rpartition(": ")[2],
        "shown": str(reader.Shown),
        "triangles": made[0].GetOutputDataObject(0).GetNumberOfPolys(),
        "final": made[0].GetFinal(),
    }
    if not told or told[-1] != shown:
        told.append(shown)
        print(f"{time.monotonic() - begin:.2f} s", shown, flush=True)
        simple.SaveScreenshot(os.path.join(folder, f"shown{len(told)}.png"), view)
    is_exact = shown["final"] and shown["index"] == "up to date"
    if is_exact or time.monotonic() - begin > 120:
        with open(os.path.join(folder, "shown.json"), "w") as file:
            json.dump(told, file)
        os._exit(0 if is_exact else 1)


def at_work(function):
    """A function for a timer, which ParaView 6.1 lets tick within calls of simple, too."""
    works = False

    def run(*_):
        nonlocal works
        if works:
            return
        works = True
        try:
            function()
        except Exception:
            traceback.print_exc()
            os._exit(1)
        works = False

    return run


simple.LoadPlugin(os.environ["ONE_FILE_PLUGIN"], remote=False, ns=vars(simple))
view = simple.GetActiveViewOrCreate("RenderView")
interactor = view.GetInteractor()
reader = contour = None


@at_work
def go_on():
    """In the event loop, behind the first question of the window for news."""
    global reader, contour
    if not reader:
        reader = simple.OpenDataFile(os.environ["ONE_FILE_VOLUME"])
    if not reader.GetClientSideObject().polled:
        return  # the window asks whether there is something new, before anybody can click on Apply
    if not contour:
        contour = simple.Isosurface(Input=reader, Isosurfaces=[150.0])
        simple.Show(contour, view)
        simple.ResetCamera(view)
        simple.Render(view)
    look()


interactor.AddObserver("TimerEvent", go_on)
interactor.CreateRepeatingTimer(400)
