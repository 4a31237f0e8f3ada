#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How soon ParaView's window answers when an isovalue is dragged on the contour spectrum.

    window_latency.py --plugin .../ScalableIsosurface.so VOLUME.bvol

Starts an X server without a screen (Xvfb) and ParaView on it, opens the volume, contours it with
Progressive and Live on, and drags the handle by X events, as a hand does. What is seen is taken from
the server's framebuffer: the *answer* is the first change of the chart, the *picture* the first one
of the view. Then the handle is moved 30 times a second; the longest time between two changes of the
chart is how long the window was frozen. Needs libX11 and libXtst.
"""
import argparse
import ctypes
import mmap
import os
import statistics
import struct
import subprocess
import tempfile
import time
import zlib

WIDTH, HEIGHT = 1400, 1000
CURVE = (52, 120, 190)  # of the spectrum in pqIsovalueChart, red, green, blue
POLL_SECONDS = 0.002
REST_SECONDS = 1.0  # without a change: nothing more comes

PANEL = "pqClientMainWindow/propertiesDock/propertiesPanel"
PROPERTIES = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/PropertiesFrame/ProxyPanel"
DISPLAY = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/DisplayFrame/ProxyPanel"
SETUP = f"""<?xml version="1.0" ?>
<pqevents>
  <pqevent object="pqClientMainWindow/menubar/menu_File" command="activate" arguments="actionFileOpen" />
  <pqevent object="pqClientMainWindow/FileOpenDialog" command="filesSelected" arguments="@VOLUME@" />
  <pqevent object="{PANEL}/Accept" command="activate" arguments="" />
  <pqevent object="pqClientMainWindow/menubar/menuFilters/Alphabetical" command="activate" arguments="StabbingContour" />
  <pqevent object="{PROPERTIES}/Progressive/CheckBox" command="set_boolean" arguments="@PROGRESSIVE@" />
  <pqevent object="{PROPERTIES}/ContourValues/Live" command="set_boolean" arguments="true" />
  <pqevent object="{PANEL}/Accept" command="activate" arguments="" />
  <pqevent object="{DISPLAY}/ColorEditor/DisplayColorWidget/Variables" command="activated" arguments="Solid Color" />
  <pqevent object="pqClientMainWindow" command="pause" arguments="200" />
</pqevents>
"""


class Screen:
    """An X server whose framebuffer is a file."""

    def __init__(self, folder, number):
        self.name = f":{number}"
        self.server = subprocess.Popen(
            ["Xvfb", self.name, "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-fbdir", folder, "-noreset"],
            stderr=subprocess.DEVNULL,
        )
        path = os.path.join(folder, "Xvfb_screen0")
        deadline = time.monotonic() + 10
        while not os.path.exists(path) or os.path.getsize(path) < WIDTH * HEIGHT * 4:
            assert time.monotonic() < deadline, "Xvfb does not start"
            time.sleep(0.1)
        with open(path, "r+b") as file:
            self.memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        header, colors = struct.unpack(">I", self.memory[:4])[0], 0
        fields = struct.unpack(">25I", self.memory[:100])
        self.stride, colors = fields[12], fields[19]
        self.start = header + colors * 12
        time.sleep(0.5)
        self.x11 = ctypes.CDLL("libX11.so.6")
        self.xtst = ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(self.name.encode()))

    def row(self, y, left, right):
        at = self.start + y * self.stride
        return self.memory[at + 4 * left : at + 4 * right]

    def hash(self, box):
        left, top, right, bottom = box
        checksum = 0
        for y in range(top, bottom, 2):
            checksum = zlib.crc32(self.row(y, left, right), checksum)
        return checksum

    def find_color(self, color, box, tolerance=12):
        """The bounds of the pixels of about a color (blue, green, red in memory)."""
        left, top, right, bottom = box
        found = []
        for y in range(top, bottom):
            row = self.row(y, left, right)
            for x in range(0, right - left):
                if all(abs(row[4 * x + 2 - n] - color[n]) < tolerance for n in range(3)):
                    found.append((left + x, y))
        assert found, "the chart is not there"
        xs, ys = zip(*found)
        return min(xs), min(ys), max(xs), max(ys)

    def move(self, x, y):
        self.xtst.XTestFakeMotionEvent(self.display, -1, x, y, ctypes.c_ulong(0))
        self.x11.XFlush(self.display)

    def press(self, down):
        self.xtst.XTestFakeButtonEvent(self.display, 1, int(down), ctypes.c_ulong(0))
        self.x11.XFlush(self.display)


def wait_for_rest(screen, box):
    last, since = screen.hash(box), time.monotonic()
    while time.monotonic() - since < REST_SECONDS:
        time.sleep(0.02)
        now = screen.hash(box)
        if now != last:
            last, since = now, time.monotonic()
    return since


def measure_steps(screen, chart, view, x, y, steps):
    """Seconds to the answer, to the picture, and to the last picture, of single moves."""
    answers, pictures, finals = [], [], []
    for step in range(steps):
        before_chart, before_view = screen.hash(chart), screen.hash(view)
        x += 5 if step % 8 < 4 else -5
        begin = time.monotonic()
        screen.move(x, y)
        answer = picture = None
        while picture is None and time.monotonic() - begin < 20:
            now = time.monotonic() - begin
            if answer is None and screen.hash(chart) != before_chart:
                answer = now
            if screen.hash(view) != before_view:
                picture = now
            time.sleep(POLL_SECONDS)
        if answer is not None and picture is not None:
            answers.append(answer)
            pictures.append(picture)
        finals.append(wait_for_rest(screen, view) - begin)
    return answers, pictures, finals, x


def measure_stream(screen, chart, x, y, seconds):
    """The longest time between two changes of the chart while the handle moves without a rest."""
    begin = last = time.monotonic()
    longest, checksum, step = 0, screen.hash(chart), 0
    while time.monotonic() - begin < seconds:
        step += 1
        screen.move(x + (step % 40 if step % 80 < 40 else 40 - step % 40), y)
        until = begin + step / 30
        while time.monotonic() < until:
            now = screen.hash(chart)
            if now != checksum:
                longest = max(longest, time.monotonic() - last)
                checksum, last = now, time.monotonic()
            time.sleep(POLL_SECONDS)
    return max(longest, time.monotonic() - last)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("volume")
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--paraview", default="paraview")
    parser.add_argument("--steps", type=int, default=12)
    parser.add_argument("--display", type=int, default=91)
    parser.add_argument("--wait", type=float, default=120, help="seconds for the setup, at most")
    parser.add_argument("--without-progressive", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        screen = Screen(folder, arguments.display)
        setup = os.path.join(folder, "setup.xml")
        with open(setup, "w", encoding="utf-8") as file:
            progressive = "false" if arguments.without_progressive else "true"
            file.write(
                SETUP.replace("@VOLUME@", os.path.abspath(arguments.volume)).replace(
                    "@PROGRESSIVE@", progressive
                )
            )
        log_path = os.path.join(folder, "log")
        plugin = arguments.plugin
        with open(log_path, "wb") as log:
            window = subprocess.Popen(
                [
                    arguments.paraview,
                    "--dr",
                    f"--plugin-search-paths={os.path.dirname(os.path.abspath(plugin))}",
                    "--plugins=ScalableIsosurface",
                    f"--test-directory={folder}",
                    f"--test-script={setup}",
                ],
                stdout=log,
                stderr=subprocess.STDOUT,
                env={**os.environ, "DISPLAY": screen.name, "XDG_CONFIG_HOME": folder},
            )
        try:
            deadline = time.monotonic() + arguments.wait
            while True:
                with open(log_path, encoding="utf-8", errors="replace") as log:
                    text = log.read()
                if "is finished" in text:
                    break
                assert time.monotonic() < deadline and window.poll() is None, text[-2000:]
                time.sleep(0.5)
            assert "Success =  true" in text, text[-2000:]
            view = (420, 260, 1100, 660)
            wait_for_rest(screen, view)
            left, top, right, bottom = screen.find_color(CURVE, (0, 400, 300, 760))
            chart = (max(0, left - 5), max(0, top - 20), right + 5, bottom + 20)
            # The grip of the one handle has a dark outline above the plot.
            grip = screen.find_color((0, 0, 0), (left, top - 11, right, top - 2), 110)
            x, y = (grip[0] + grip[2]) // 2, (top + bottom) // 2
            screen.move(x, y)
            time.sleep(0.5)
            screen.press(True)
            answers, pictures, finals, x = measure_steps(
                screen, chart, view, x, y, arguments.steps
            )
            assert pictures, "nothing moved: the handle was not hit"
            longest = measure_stream(screen, chart, x, y, 6)
            screen.press(False)
            done = wait_for_rest(screen, view)
            print(f"moves with an answer and a picture: {len(pictures)} of {arguments.steps}")
            for name, values in (
                ("answer", answers),
                ("first picture", pictures),
                ("last picture of the drag", finals),
            ):
                print(
                    f"{name}: median {statistics.median(values):.3f} s, most {max(values):.3f} s"
                )
            print(f"longest time without an answer, at 30 moves a second: {longest:.3f} s")
            del done
        finally:
            window.terminate()
            window.wait()
            screen.server.terminate()
            screen.server.wait()


if __name__ == "__main__":
    main()
