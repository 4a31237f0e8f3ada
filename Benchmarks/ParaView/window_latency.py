#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How soon ParaView's window answers when an isovalue is dragged on the contour spectrum.

    window_latency.py --plugin .../ScalableIsosurface.so [--isovalue V] [--server URL] VOLUME.bvol

Starts an X server without a screen (Xvfb) and ParaView on it, opens the volume, contours it with
Live on, and drags the handle by X events, as a hand does. What is seen is taken from the server's
framebuffer; what was extracted and drawn from ParaView's log.

    answer       from a move of the handle to the first change of the chart
    picture      from the move to the first change of the view
    exact        from the move, after which the handle is released, to the last change of the view,
                 beside what must be: the extraction of the exact surface, and drawing it once more
    freeze       the longest time between two changes of the chart while the mouse moves over it, 30
                 times a second: while the handle is dragged, and while the surface is refined
    camera       from a move of the camera while the surface is refined to the change of the view
    reach        the same for a hand that moves from the chart to the view for a second before

--at-once switches coarse surfaces off, for comparison. With --server, a server is expected at the
URL, cs://host:port; it must be able to load the plugin. Needs libX11 and libXtst.
"""
import argparse
import ctypes
import mmap
import os
import re
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
DRAG_SECONDS = 6.0
REACH_SECONDS = 1.0

PANEL = "pqClientMainWindow/propertiesDock/propertiesPanel"
PROPERTIES = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/PropertiesFrame/ProxyPanel"
DISPLAY = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/DisplayFrame/ProxyPanel"
SETUP = f"""<?xml version="1.0" ?>
<pqevents>
  <pqevent object="pqClientMainWindow/menubar/menu_File" command="activate" arguments="actionFileOpen" />
  <pqevent object="pqClientMainWindow/FileOpenDialog" command="filesSelected" arguments="@VOLUME@" />
  <pqevent object="{PANEL}/Accept" command="activate" arguments="" />
  <pqevent object="pqClientMainWindow/menubar/menuFilters/Alphabetical" command="activate" arguments="Isosurface" />
  @ISOVALUE@
  <pqevent object="{PANEL}/Accept" command="activate" arguments="" />
  <pqevent object="{DISPLAY}/ColorEditor/DisplayColorWidget/Variables" command="activated" arguments="Solid Color" />
  @AT_ONCE@
  <pqevent object="{PROPERTIES}/ContourValues/Live" command="set_boolean" arguments="true" />
  <pqevent object="pqClientMainWindow" command="pause" arguments="200" />
</pqevents>
"""
LIST = f"{PROPERTIES}/ContourValues/ScalarValueList/Table"
ISOVALUE = f"""<pqevent object="{LIST}" command="setCurrent" arguments="0.0" />
  <pqevent object="{LIST}" command="edit" arguments="0.0" />
  <pqevent object="{LIST}" command="editAccepted" arguments="0.0,@VALUE@" />"""
AT_ONCE = """<pqevent object="pqClientMainWindow/statusbar/RefinementStatus/Menu" command="activate" arguments="CoarseFirst" />"""


class Screen:
    """An X server whose framebuffer is a file."""

    def __init__(self, folder, number):
        self.name = f":{number}"
        self.server = subprocess.Popen(
            # A cursor would be in the framebuffer, and a change by itself.
            ["Xvfb", self.name, "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-fbdir", folder]
            + ["-noreset", "-nocursor"],
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


def wait_for_rest(screen, box, rest=REST_SECONDS):
    """Until nothing has changed for a while; returns when the last change was."""
    last, since = screen.hash(box), time.monotonic()
    while time.monotonic() - since < rest:
        time.sleep(POLL_SECONDS)
        now = screen.hash(box)
        if now != last:
            last, since = now, time.monotonic()
    return since


def wait_for_change(screen, boxes, since, limit=20):
    """For each box the seconds to its first change; None if there was none in time."""
    before = [screen.hash(box) for box in boxes]
    seconds = [None] * len(boxes)

    def wait():
        while None in seconds and time.monotonic() - since() < limit:
            for n, box in enumerate(boxes):
                if seconds[n] is None and screen.hash(box) != before[n]:
                    seconds[n] = time.monotonic() - since()
            time.sleep(POLL_SECONDS)
        return seconds

    return wait


DRAWN = re.compile(r"\} ([\d.]+) s: \S+ StillRender")


class Log:
    """What ParaView has logged since it was looked at."""

    def __init__(self, path):
        self.path = path
        self.read = 0

    def peek(self):
        with open(self.path, encoding="utf-8", errors="replace") as file:
            file.seek(self.read)
            return file.read(), file.tell()

    def is_final(self):
        return "the surface is final" in self.peek()[0]

    def wait_for_final(self, limit=120):
        deadline = time.monotonic() + limit
        while not self.is_final() and time.monotonic() < deadline:
            time.sleep(0.01)

    def wait_for_drawing(self, limit=60):
        """The seconds of an image, which may be drawn in portions."""
        deadline = time.monotonic() + limit
        while time.monotonic() < deadline:
            text = self.peek()[0]
            if DRAWN.search(text) and ("portions" in text or "portions" not in self.everything()):
                break
            time.sleep(0.01)
        return sum(self.next()[1])

    def everything(self):
        with open(self.path, encoding="utf-8", errors="replace") as file:
            return file.read()

    def next(self):
        text, self.read = self.peek()
        extracted = re.findall(r"Stabbing Contour: rank 0.* (\d+) triangles.* extract ([\d.]+) s", text)
        drawn = DRAWN.findall(text)
        return (
            [(int(triangles), float(seconds)) for triangles, seconds in extracted],
            [float(seconds) for seconds in drawn],
        )


class Hand:
    """Drags a handle of the chart, and the camera."""

    def __init__(self, screen, chart, view, x, y):
        self.screen, self.chart, self.view = screen, chart, view
        self.x, self.y = x, y
        self.steps = 0

    def step(self):
        """Moves the handle a little, there and back in turn."""
        self.steps += 1
        self.x += 5 if self.steps % 8 < 4 else -5
        self.screen.move(self.x, self.y)

    def drag_once(self):
        """Drags the handle by one step; the seconds to the answer and to the picture."""
        self.screen.move(self.x, self.y)
        time.sleep(0.3)
        self.screen.press(True)
        time.sleep(0.1)
        begin = [0.0]
        wait = wait_for_change(self.screen, [self.chart, self.view], lambda: begin[0])
        begin[0] = time.monotonic()
        self.step()
        answer, picture = wait()
        self.screen.press(False)
        return begin[0], answer, picture

    def hover(self, is_done):
        """The longest time between two changes of the chart under a moving mouse."""
        begin = last = time.monotonic()
        longest, step = 0, 0
        chart = self.screen.hash(self.chart)
        while not is_done():
            step += 1
            self.screen.move(self.x + 12 + (step % 40 if step % 80 < 40 else 40 - step % 40), self.y)
            until = begin + step / 30
            while time.monotonic() < until:
                now = self.screen.hash(self.chart)
                if now != chart:
                    longest = max(longest, time.monotonic() - last)
                    chart, last = now, time.monotonic()
                time.sleep(POLL_SECONDS)
        return max(longest, time.monotonic() - last)

    def reach(self):
        """Moves from the handle to the middle of the view, as slowly as a hand."""
        x, y = (self.view[0] + self.view[2]) // 2, (self.view[1] + self.view[3]) // 2
        moves = round(REACH_SECONDS * 60)
        begin = time.monotonic()
        for n in range(moves):
            self.screen.move(self.x + (x - self.x) * n // moves, self.y + (y - self.y) * n // moves)
            time.sleep(max(0, begin + (n + 1) / 60 - time.monotonic()))

    def press_view(self):
        """Seconds from a press and a move in the view to its first change."""
        x, y = (self.view[0] + self.view[2]) // 2, (self.view[1] + self.view[3]) // 2
        begin = [0.0]
        wait = wait_for_change(self.screen, [self.view], lambda: begin[0])
        begin[0] = time.monotonic()
        self.screen.press(True)
        self.screen.move(x + 30, y + 10)
        (seconds,) = wait()
        self.screen.press(False)
        self.screen.move(self.x, self.y)
        return seconds

    def turn_camera(self):
        """Seconds from a move of the camera to the change of the view."""
        x, y = (self.view[0] + self.view[2]) // 2, (self.view[1] + self.view[3]) // 2
        self.screen.move(x, y)
        self.screen.press(True)
        self.screen.move(x + 3, y)
        wait_for_rest(self.screen, self.view, 0.5)
        begin = [0.0]
        wait = wait_for_change(self.screen, [self.view], lambda: begin[0])
        begin[0] = time.monotonic()
        self.screen.move(x + 30, y + 10)
        (seconds,) = wait()
        self.screen.move(x, y)
        time.sleep(0.2)
        self.screen.press(False)
        self.screen.move(self.x, self.y)
        return seconds


def show(name, values, unit="s"):
    values = [value for value in values if value is not None]
    if values:
        print(
            f"{name}: median {statistics.median(values):.3f} {unit}, most {max(values):.3f} {unit}",
            flush=True,
        )


def wait_for_final(hand, log, limit=120):
    """Until the exact surface is drawn; returns when the view changed last."""
    last, since = hand.screen.hash(hand.view), time.monotonic()
    deadline = since + limit
    while not log.is_final() and time.monotonic() < deadline:
        now = hand.screen.hash(hand.view)
        if now != last:
            last, since = now, time.monotonic()
        time.sleep(POLL_SECONDS)
    return since


def measure(hand, log, steps):
    """Prints what the module's documentation says."""
    answers, pictures, exacts, ratios, freezes, rows = [], [], [], [], [], []
    cameras, reaches = [], []
    for _ in range(steps):
        log.next()
        begin, answer, picture = hand.drag_once()
        exact = max(wait_for_final(hand, log), begin) - begin
        extracted, _ = log.next()
        hand.turn_camera()
        drawn = log.wait_for_drawing()  # of the same surface, when the camera rests
        answers.append(answer)
        pictures.append(picture)
        exacts.append(exact)
        if extracted and drawn:
            rows.append((extracted, drawn))
            ratios.append(exact / (extracted[-1][1] + drawn))
    for _ in range(max(2, steps // 3)):
        log.next()
        hand.drag_once()
        freezes.append(hand.hover(log.is_final))
        log.next()
        hand.drag_once()
        cameras.append(hand.turn_camera())
        log.wait_for_final()
        log.next()
        hand.drag_once()
        hand.reach()
        reaches.append(hand.press_view())
        log.wait_for_final()
    hand.screen.move(hand.x, hand.y)
    time.sleep(0.3)
    hand.screen.press(True)
    end = time.monotonic() + DRAG_SECONDS
    freeze = hand.hover(lambda: time.monotonic() > end)
    hand.screen.press(False)
    for extracted, drawn in rows:
        print(
            "  surfaces: "
            + ", ".join(f"{count:,} in {seconds:.3f} s" for count, seconds in extracted)
            + f"; drawn again in {drawn:.3f} s"
        )
    show("answer", answers)
    show("picture", pictures)
    show("exact at rest", exacts)
    show("exact / (extraction + drawing)", ratios, "x")
    show("freeze while it is refined", freezes)
    show("freeze while the handle is dragged", [freeze])
    show("camera", cameras)
    show("reach", reaches)


def make_setup(arguments):
    isovalue = "" if arguments.isovalue is None else ISOVALUE
    return (
        SETUP.replace("@ISOVALUE@", isovalue.replace("@VALUE@", f"{arguments.isovalue}"))
        .replace("@AT_ONCE@", AT_ONCE if arguments.at_once else "")
        .replace("@VOLUME@", os.path.abspath(arguments.volume))
    )


def start_window(arguments, screen, folder):
    setup = os.path.join(folder, "setup.xml")
    with open(setup, "w", encoding="utf-8") as file:
        file.write(make_setup(arguments))
    log_path = os.path.join(folder, "log")
    options = [
        "--dr",
        f"--plugin-search-paths={os.path.dirname(os.path.abspath(arguments.plugin))}",
        "--plugins=ScalableIsosurface",
        f"--log={os.path.join(folder, 'window.log')},1",
        f"--test-directory={folder}",
        f"--test-script={setup}",
    ]
    if arguments.server:
        options.append(f"--server-url={arguments.server}")
    environment = {
        **os.environ,
        "DISPLAY": screen.name,
        "XDG_CONFIG_HOME": folder,
        "PARAVIEW_LOG_RENDERING_VERBOSITY": "1",
    }
    with open(log_path, "wb") as log:
        window = subprocess.Popen(
            [arguments.paraview, *options], stdout=log, stderr=subprocess.STDOUT, env=environment
        )
    deadline = time.monotonic() + arguments.wait
    while True:
        with open(log_path, encoding="utf-8", errors="replace") as log:
            text = log.read()
        if "is finished" in text:
            break
        if time.monotonic() > deadline or window.poll() is not None:
            window.kill()
            raise RuntimeError(text[-2000:])
        time.sleep(0.5)
    if "Success =  true" not in text:
        window.kill()
        raise RuntimeError(text[-2000:])
    return window


def find_hand(screen, view):
    """The chart and its handle, where they are on the screen."""
    left, top, right, bottom = screen.find_color(CURVE, (0, 400, 300, 760))
    chart = (max(0, left - 5), max(0, top - 20), right + 5, bottom + 20)
    # The grip of the one handle has a dark outline above the plot.
    grip = screen.find_color((0, 0, 0), (left, top - 11, right, top - 2), 110)
    return Hand(screen, chart, view, (grip[0] + grip[2]) // 2, (top + bottom) // 2)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("volume")
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--paraview", default="paraview")
    parser.add_argument("--isovalue", type=float)
    parser.add_argument("--server")
    parser.add_argument("--at-once", action="store_true", help="without coarse surfaces")
    parser.add_argument("--steps", type=int, default=9)
    parser.add_argument("--display", type=int, default=91)
    parser.add_argument("--wait", type=float, default=120, help="seconds for the setup, at most")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        screen = Screen(folder, arguments.display)
        window = None
        try:
            window = start_window(arguments, screen, folder)
            view = (420, 260, 1100, 660)
            log = Log(os.path.join(folder, "window.log"))
            log.wait_for_final()
            wait_for_rest(screen, view)
            measure(find_hand(screen, view), log, arguments.steps)
        finally:
            if window:
                window.terminate()
                window.wait()
            screen.server.terminate()
            screen.server.wait()


if __name__ == "__main__":
    main()
