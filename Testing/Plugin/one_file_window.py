# SPDX-License-Identifier: BSD-3-Clause
"""First contact in the window, with the plugin in one file of Python: what is shown is told line by line, until the surface
is exact. ONE_FILE_PLUGIN, ONE_FILE_VOLUME and ONE_FILE_OUTPUT name the plugin, the file and a folder.
"""
import json
import os
import threading
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
        write("shown", told)
        if not is_exact:
            os._exit(1)
        show_coarse()


def write(name, found):
    with open(os.path.join(folder, f"{name}.json"), "w") as file:
        json.dump(found, file)


def count_shown():
    return simple.GetRepresentation(contour, view).GetRepresentedDataInformation().GetNumberOfCells()


def show_coarse():
    """A surface of another isovalue is coarse first, and the exact one takes its time."""
    global coarse
    from scalable_isosurface import _library
    from scalable_isosurface._plugin import _surfaces

    extract = _library.VolumeFile.extract

    def extract_slowly(*arguments, **named):
        time.sleep(0 if threading.current_thread() is threading.main_thread() else 5)
        return extract(*arguments, **named)

    _library.VolumeFile.extract = extract_slowly
    _surfaces.LARGE = 1000
    contour.Isosurfaces = [155.0]
    simple.Render(view)
    coarse = {"coarse": count_shown(), "final": contour.GetClientSideObject().GetFinal()}


def save():
    """While the window shows the coarse surface; and what it shows then."""
    if "saved" not in coarse:
        path = os.path.join(folder, "saved.ply")
        simple.SaveData(path, proxy=contour)
        with open(path, "rb") as file:
            lines = file.read(1000).split(b"\n")
        coarse["saved"] = next(int(line.split()[2]) for line in lines if line.startswith(b"element face"))
    elif count_shown() == coarse["saved"] or time.monotonic() - begin > 180:
        write("saving", {**coarse, "shown": count_shown()})
        os._exit(0)


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
reader = contour = coarse = None


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
    save() if coarse else look()


interactor.AddObserver("TimerEvent", go_on)
interactor.CreateRepeatingTimer(400)
