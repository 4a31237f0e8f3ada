#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Takes the pictures of ParaView's window that the documents show, by playing what a user does.

    take_pictures.py --plugin .../ScalableIsosurface.so --volume head.bvol [NAME...]

Each picture is a list of events of ParaView's test player, and is taken of the whole screen when
nothing on it has changed for a while. Without names all are taken, into Documentation/images. Needs
Xvfb and ImageMagick's import.
"""
import argparse
import os
import subprocess
import tempfile
import time
import zlib

WIDTH, HEIGHT = 1280, 800
REST_SECONDS = 3.0
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
REST = (WINDOW, "pause", "1500")


def menu(name, action):
    return (f"{WINDOW}/menubar/{name}", "activate", action)


def choose_filter(name):
    return menu("menuFilters/Alphabetical", name)


def open_file(path):
    return [menu("menu_File", "actionFileOpen"), (f"{WINDOW}/FileOpenDialog", "filesSelected", path)]


def save_data(path):
    return [menu("menu_File", "actionFileSaveData"), (f"{WINDOW}/FileSaveDialog", "filesSelected", path)]


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


def make_pictures(volume, folder):
    """Lists of events by the pictures' names."""
    opened = [*open_file(volume), APPLY]
    proposed = [*opened, choose_filter("StabbingContour"), REST]
    contoured = [*proposed, APPLY, SOLID, REST]
    spectrum = [*opened, choose_filter("ContourSpectrum"), APPLY, REST]
    distributed = [*contoured, choose_filter("DistributeIsosurface"), APPLY, REST]
    surface = os.path.join(folder, "surface.eix")
    return {
        "panels/reader": [*opened, ALL_PROPERTIES],
        "panels/isosurface": [*contoured, ALL_PROPERTIES],
        "panels/spectrum": [*spectrum, ALL_PROPERTIES],
        "panels/distribute": [*distributed, ALL_PROPERTIES],
        "panels/save-volume": [*opened, *save_data(os.path.join(folder, "copy.bvol"))],
        "panels/save-surface": [*contoured, *save_data(surface)],
    }


def write_script(events, path):
    with open(path, "w", encoding="utf-8") as file:
        file.write('<?xml version="1.0" ?>\n<pqevents>\n')
        for target, command, text in events:
            file.write(f'  <pqevent object="{target}" command="{command}" arguments="{text}" />\n')
        file.write("</pqevents>\n")


def wait_for_rest(window, screen):
    """Until the script was played and nothing on the screen, a file, has changed for a while."""
    for line in window.stdout:
        if PLAYED in line:
            assert "true" in line, "the script was not played to its end"
            break
    start = time.monotonic()
    last, since = None, start
    while time.monotonic() - since < REST_SECONDS:
        assert time.monotonic() - start < LONGEST_SECONDS, "the window does not come to rest"
        time.sleep(0.1)
        with open(screen, "rb") as file:
            now = zlib.crc32(file.read())
        if now != last:
            last, since = now, time.monotonic()


def take_picture(arguments, events, path):
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, "script.xml")
        write_script(events, script)
        display = f":{100 + os.getpid() % 1000}"
        size = f"{WIDTH}x{HEIGHT}x24"
        server = subprocess.Popen(
            ["Xvfb", display, "-screen", "0", size, "-fbdir", folder, "-noreset"],
            stderr=subprocess.DEVNULL,
        )
        screen = os.path.join(folder, "Xvfb_screen0")
        while not os.path.exists(screen):
            time.sleep(0.1)
        environment = {**os.environ, "DISPLAY": display}
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
            wait_for_rest(window, screen)
            subprocess.run(["import", "-window", "root", path], env=environment, check=True)
        finally:
            window.kill()
            window.wait()
            server.terminate()
            server.wait()


def main():
    images = os.path.join(os.path.dirname(os.path.abspath(__file__)), "images")
    parser = argparse.ArgumentParser()
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--volume", required=True)
    parser.add_argument("--output", default=images, help="default: Documentation/images")
    parser.add_argument("names", nargs="*", help="of pictures; default: all")
    arguments = parser.parse_args()
    arguments.plugin = os.path.abspath(arguments.plugin)
    with tempfile.TemporaryDirectory() as folder:
        pictures = make_pictures(os.path.abspath(arguments.volume), folder)
        for name in arguments.names or pictures:
            path = os.path.join(arguments.output, f"{name}.png")
            os.makedirs(os.path.dirname(path), exist_ok=True)
            take_picture(arguments, pictures[name], path)
            print(path, flush=True)


if __name__ == "__main__":
    main()
