#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Takes the pictures of ParaView's window that the documents show, by playing what a user does.

    take_pictures.py --plugin .../ScalableIsosurface.so --volume head.bvol --ct cranium.vti [NAME...]

Each picture is a list of events of ParaView's test player, and is taken when nothing on the screen
has changed for a while. Without names all are taken, into Documentation/images. Needs Xvfb,
ImageMagick, libX11 and libXtst.
"""
import argparse
import ctypes
import json
import os
import subprocess
import tempfile
import threading
import time
import zlib

WIDTH, HEIGHT = 1280, 900
PANEL_WIDTH = 480
REST_SECONDS = 3.0
DIALOG_SECONDS = 70.0  # the script of an open dialog does not end, and its cursor blinks
PLAYED = " is finished."  # what ParaView says of a script
LONGEST_SECONDS = 120.0

WINDOW = "pqClientMainWindow"
PANEL = f"{WINDOW}/propertiesDock/propertiesPanel"
FRAMES = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents"
PROPERTIES = f"{FRAMES}/PropertiesFrame/ProxyPanel"
DISPLAY = f"{FRAMES}/DisplayFrame/ProxyPanel"
CHART = f"{PROPERTIES}/ContourValues/IsovalueChart"
APPLY = (f"{PANEL}/Accept", "activate", "")
ALL_PROPERTIES = (f"{PANEL}/SearchBox/AdvancedButton", "set_boolean", "true")
SOLID = (f"{DISPLAY}/ColorEditor/DisplayColorWidget/Variables", "activated", "Solid Color")
BROWSER = f"{WINDOW}/pipelineBrowserDock/pipelineBrowser"
VIEWS = (
    f"{WINDOW}/centralwidget/MultiViewWidget/CoreWidget/qt_tabwidget_stackedwidget"
    "/MultiViewWidget1/Container"
)
SPECTRUM = f"{VIEWS}/Frame.2/CentralWidgetFrame/Viewport"
CHOICE_OF_VIEWS = (
    f"{VIEWS}/Frame.0/CentralWidgetFrame/EmptyView/scrollArea/qt_scrollarea_viewport"
    "/widgetFoo/ConvertActionsFrame"
)
METABUFFER_VIEW = [
    (f"{VIEWS}/Frame.0/Close", "activate", ""),
    (f"{CHOICE_OF_VIEWS}/MetabufferRenderView", "activate", ""),
]
REST = (WINDOW, "pause", "1500")
# The mouse button is held meanwhile: a finer surface waits for its release.
HELD = ("tour/4",)
# Where the mouse is at the end.
HOVER = {"tour/6": (160, 560)}


def menu(name, action):
    return (f"{WINDOW}/menubar/{name}", "activate", action)


def choose_filter(name):
    return menu("menuFilters/Alphabetical", name)


def open_file(path):
    return [menu("menu_File", "actionFileOpen"), (f"{WINDOW}/FileOpenDialog", "filesSelected", path)]


def save_data(path):
    return [menu("menu_File", "actionFileSaveData"), (f"{WINDOW}/FileSaveDialog", "filesSelected", path)]


def scroll_to_end():
    bar = f"{PANEL}/scrollArea/qt_scrollarea_vcontainer/1QScrollBar0"
    return [(bar, "set_int", "600")]


def double_click(x, y):
    return [
        (CHART, "mouseDblClick", f"1,1,0,{x},{y}"),
        (CHART, "mouseRelease", f"1,0,0,{x},{y}"),
    ]


def drag(start, end, y):
    middle = (start + end) // 2
    return [
        (CHART, "mousePress", f"1,1,0,{start},{y}"),
        (CHART, "mouseMove", f"1,0,0,{middle},{y}"),
        (CHART, "mouseMove", f"1,0,0,{end},{y}"),
        (CHART, "mouseRelease", f"1,0,0,{end},{y}"),
    ]


def write_zarr(folder, side=64):
    """A Zarr of one chunk: the squared distance from the middle, in bytes."""
    os.makedirs(folder)
    with open(os.path.join(folder, ".zarray"), "w") as file:
        json.dump({"zarr_format": 2, "shape": [side] * 3, "chunks": [side] * 3, "dtype": "|u1", "order": "C",
                   "compressor": None, "fill_value": 0, "filters": None}, file)
    squares = [(2 * place / (side - 1) - 1) ** 2 for place in range(side)]
    with open(os.path.join(folder, "0.0.0"), "wb") as file:
        file.write(bytes(int(85 * (x + y + z)) for z in squares for y in squares for x in squares))


def make_pictures(volume, ct, folder):
    """Lists of events by the pictures' names."""
    opened = [*open_file(volume), APPLY]
    proposed = [*opened, choose_filter("Isosurface"), REST]
    contoured = [*proposed, APPLY, SOLID, REST]
    added = [*contoured, *double_click(120, 60), APPLY, REST]
    live = (f"{PROPERTIES}/ContourValues/Live", "set_boolean", "true")
    reader = (BROWSER, "mousePress", "1,1,0,40,8,/0:0/0:0")
    released = (BROWSER, "mouseRelease", "1,0,0,40,8,/0:0/0:0")
    charted = [*contoured, reader, released, choose_filter("ContourSpectrum"), APPLY, REST]
    picked = [
        *charted,
        (SPECTRUM, "mouseDblClick", "(0.35,0.5,1,1,0)"),
        (SPECTRUM, "mouseRelease", "(0.35,0.5,1,0,0)"),
    ]
    cut = [*contoured, reader, released, choose_filter("VolumeSlice"), APPLY, REST]
    distributed = [*contoured, choose_filter("DistributeIsosurface"), APPLY, REST]
    surface = os.path.join(folder, "surface.eix")
    ok = (f"{WINDOW}/WriterSettingsDialog/widget/OKButton", "activate", "")
    reopened = [*contoured, *save_data(surface), ok, *open_file(surface), APPLY]
    zarr = os.path.join(folder, "scan.zarr")
    write_zarr(zarr)
    image = [menu("menuSources/Alphabetical", "RTAnalyticSource"), APPLY]
    tissues = [(f"{PROPERTIES}/ContourValues/Tissues/{name}", "activate", "") for name in ("Skin",)]
    chosen = [*open_file(ct), APPLY, choose_filter("Isosurface"), REST, *tissues]
    return {
        "panels/reader": [*opened, ALL_PROPERTIES],
        "panels/in-place": [*open_file(zarr), APPLY, ALL_PROPERTIES, REST],
        "panels/isosurface": [*contoured, ALL_PROPERTIES],
        "panels/isosurface-more": [*contoured, ALL_PROPERTIES, *scroll_to_end()],
        "panels/slice": [*cut, ALL_PROPERTIES],
        "panels/spectrum": [*charted, ALL_PROPERTIES],
        "panels/distribute": [*distributed, ALL_PROPERTIES],
        "panels/edge-index": [*reopened, ALL_PROPERTIES],
        "panels/metabuffer": [*METABUFFER_VIEW, ALL_PROPERTIES, *scroll_to_end()],
        "panels/save-volume": [*image, *save_data(os.path.join(folder, "copy.bvol"))],
        "panels/save-surface": [*contoured, *save_data(surface)],
        "tour/1": open_file(volume),
        "tour/2": opened,
        "tour/3": proposed,
        "tour/4": [*proposed, APPLY, SOLID],
        "tour/5": contoured,
        "tour/6": [*contoured, *double_click(170, 60)],
        "tour/7": [*added, live, *drag(120, 170, 60), REST],
        "tour/8": picked,
        "tour/10": reopened,
        "panels/tissues": [*chosen, ALL_PROPERTIES],
        "tour/11": [*chosen, APPLY, REST],
    }


class Screen:
    """An X server without a screen, whose framebuffer is a file."""

    def __init__(self, folder):
        self.name = f":{100 + os.getpid() % 1000}"
        self.file = os.path.join(folder, "Xvfb_screen0")
        size = f"{WIDTH}x{HEIGHT}x24"
        self.server = subprocess.Popen(
            ["Xvfb", self.name, "-screen", "0", size, "-fbdir", folder, "-noreset"],
            stderr=subprocess.DEVNULL,
        )
        while not os.path.exists(self.file):
            time.sleep(0.1)
        time.sleep(0.5)
        self.x11, self.xtst = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.x11.XDefaultRootWindow.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(self.name.encode()))
        # Windows come and go while they are looked at: without this the program would end.
        handler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
        self.ignore = handler(lambda display, error: 0)
        self.x11.XSetErrorHandler(self.ignore)

    def find_windows(self):
        """Those on the screen and their sizes."""
        root, parent, count = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_uint()
        children = ctypes.POINTER(ctypes.c_ulong)()
        self.x11.XQueryTree(
            self.display,
            ctypes.c_ulong(self.x11.XDefaultRootWindow(self.display)),
            ctypes.byref(root),
            ctypes.byref(parent),
            ctypes.byref(children),
            ctypes.byref(count),
        )
        sizes = []
        for index in range(count.value):
            place = [ctypes.c_int(), ctypes.c_int()]
            size = [ctypes.c_uint() for _ in range(4)]
            self.x11.XGetGeometry(
                self.display,
                ctypes.c_ulong(children[index]),
                ctypes.byref(root),
                *(ctypes.byref(number) for number in place + size),
            )
            sizes.append((children[index], size[0].value, size[1].value))
        return sizes

    def enlarge_window(self):
        """Gives the main window the whole screen, when it is there."""
        found = []
        while not found:
            time.sleep(0.2)
            found = [window for window, width, height in self.find_windows() if width > 900 and height > 500]
        for window in found:
            self.x11.XMoveResizeWindow(self.display, ctypes.c_ulong(window), 0, 0, WIDTH, HEIGHT)
        self.x11.XFlush(self.display)

    def drag(self, start, end):
        for x, y, down in (*((*start, down) for down in (None, True)), (*end, None), (*end, False)):
            self.xtst.XTestFakeMotionEvent(self.display, -1, x, y, ctypes.c_ulong(0))
            self.x11.XFlush(self.display)
            time.sleep(0.2)
            if down is not None:
                self.xtst.XTestFakeButtonEvent(self.display, 1, int(down), ctypes.c_ulong(0))
                self.x11.XFlush(self.display)
                time.sleep(0.2)

    def move(self, x, y):
        self.xtst.XTestFakeMotionEvent(self.display, -1, x, y, ctypes.c_ulong(0))
        self.x11.XFlush(self.display)

    def hold_button(self):
        """Over the status bar, where it does nothing."""
        self.move(20, HEIGHT - 8)
        self.xtst.XTestFakeButtonEvent(self.display, 1, 1, ctypes.c_ulong(0))
        self.x11.XFlush(self.display)

    def read(self):
        with open(self.file, "rb") as file:
            return zlib.crc32(file.read())

    def stop(self):
        self.server.terminate()
        self.server.wait()


def write_script(events, path):
    with open(path, "w", encoding="utf-8") as file:
        file.write('<?xml version="1.0" ?>\n<pqevents>\n')
        for target, command, text in events:
            file.write(f'  <pqevent object="{target}" command="{command}" arguments="{text}" />\n')
        file.write("</pqevents>\n")


def keep_lines(window):
    """What the window says, as it says it."""
    lines = []
    threading.Thread(target=lambda: lines.extend(window.stdout), daemon=True).start()
    return lines


def wait_for_rest(lines, screen):
    """Until the script was played and nothing on the screen has changed for a while; false if a
    dialog is open, where scripts do not end."""
    start = since = time.monotonic()
    last = None
    played = False
    while not played or time.monotonic() - since < REST_SECONDS:
        if not played and time.monotonic() - start > DIALOG_SECONDS:
            break
        assert time.monotonic() - start < LONGEST_SECONDS, "the window does not come to rest"
        time.sleep(0.1)
        now = screen.read()
        if now != last:
            last, since = now, time.monotonic()
        ends = [line for line in list(lines) if PLAYED in line]
        assert all("true" in line for line in ends), "".join(lines)
        played = bool(ends)
    return played


def take_picture(arguments, events, path):
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, "script.xml")
        write_script(events, script)
        screen = Screen(folder)
        environment = {**os.environ, "DISPLAY": screen.name}
        window = subprocess.Popen(
            [
                "paraview",
                "--dr",
                f"--plugin-search-paths={os.path.dirname(arguments.plugin)}",
                "--plugins=ScalableIsosurface",
                f"--test-directory={folder}",
                f"--test-script={script}",
            ],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        try:
            screen.enlarge_window()
            lines = keep_lines(window)
            name = os.path.splitext("/".join(path.split(os.sep)[-2:]))[0]
            if name in HELD:
                time.sleep(REST_SECONDS)
                screen.hold_button()
            if wait_for_rest(lines, screen) and name not in HELD:
                # Room for the panel: the borders between the docks.
                screen.drag((296, 600), (PANEL_WIDTH, 600))
                screen.drag((120, 401), (120, 401 - 130))
                if name in HOVER:
                    screen.move(*HOVER[name])
                wait_for_rest(lines, screen)
            subprocess.run(["import", "-window", "root", path], env=environment, check=True)
            shape = ["-resize", "900x"]
            if "/panels/" in path and "/save-" not in path:
                shape = ["-crop", f"{PANEL_WIDTH}x{HEIGHT}+0+0", "+repage"]
            subprocess.run(["convert", path, *shape, "+dither", "-colors", "96", f"PNG8:{path}"], check=True)
        finally:
            window.kill()
            window.wait()
            screen.stop()


def main():
    images = os.path.join(os.path.dirname(os.path.abspath(__file__)), "images")
    parser = argparse.ArgumentParser()
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--volume", required=True)
    parser.add_argument("--ct", required=True, help="Examples/debian_scans.py's cranium_ct")
    parser.add_argument("--output", default=images, help="default: Documentation/images")
    parser.add_argument("names", nargs="*", help="of pictures; default: all")
    arguments = parser.parse_args()
    arguments.plugin = os.path.abspath(arguments.plugin)
    with tempfile.TemporaryDirectory() as folder:
        pictures = make_pictures(os.path.abspath(arguments.volume), os.path.abspath(arguments.ct), folder)
        for name in arguments.names or pictures:
            path = os.path.join(arguments.output, f"{name}.png")
            os.makedirs(os.path.dirname(path), exist_ok=True)
            take_picture(arguments, pictures[name], path)
            print(path, flush=True)


if __name__ == "__main__":
    main()
