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


def look(*_):
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
        os._exit(0)


def look_at(*_):
    try:
        look()
    except Exception:
        traceback.print_exc()
        os._exit(1)


simple.LoadPlugin(os.environ["ONE_FILE_PLUGIN"], remote=False, ns=vars(simple))
view = simple.GetActiveViewOrCreate("RenderView")
interactor = view.GetInteractor()
reader = contour = None


def begin_work(*_):
    """In the event loop, behind the first question of the window for news."""
    global reader, contour
    if contour:
        return look_at()
    if not reader:
        reader = simple.OpenDataFile(os.environ["ONE_FILE_VOLUME"])
    if not reader.GetClientSideObject().polled:
        return None  # the window asks whether there is something new, before anybody can click on Apply
    contour = simple.Isosurface(Input=reader, Isosurfaces=[150.0])
    simple.Show(contour, view)
    simple.ResetCamera(view)
    simple.Render(view)
    return look_at()


interactor.AddObserver("TimerEvent", begin_work)
interactor.CreateRepeatingTimer(400)
