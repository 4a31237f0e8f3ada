# SPDX-License-Identifier: BSD-3-Clause
"""Random deeds of a user's hand in the window of a server of several ranks, one window after another, for
as many minutes as are asked for:

    window_stress.py ... --ranks 4 --pvserver PATH --paraview PATH --mpiexec "mpiexec -n"
        --window-python-path FOLDER [--minutes 120] [--seed 1]

Each window plays deeds that its seed draws. A failure names the seed, with which it is played again.
"""
import os
import random
import re
import subprocess
import time
from xml.sax.saxutils import quoteattr

import plugin_testing as testing

DEEDS = 60
WINDOW = "pqClientMainWindow"
PANEL = f"{WINDOW}/propertiesDock/propertiesPanel"
PROPERTIES = f"{PANEL}/scrollArea/qt_scrollarea_viewport/scrollAreaWidgetContents/PropertiesFrame/ProxyPanel"
CHART = f"{PROPERTIES}/ContourValues/IsovalueChart"
FRAME = (
    f"{WINDOW}/centralwidget/MultiViewWidget/CoreWidget/qt_tabwidget_stackedwidget"
    "/MultiViewWidget1/Container/Frame.0"
)
VIEW = f"{FRAME}/CentralWidgetFrame/Viewport"
BROWSER = f"{WINDOW}/pipelineBrowserDock/pipelineBrowser"
READER, CONTOUR = "/0:0/0:0", "/0:0/0:0/0:0"


class Hand:
    """What a hand does, as events of ParaView's test player."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.events = []
        self.has_reloaded = False

    def do(self, widget, command, arguments=""):
        self.events.append((widget, command, str(arguments)))

    def rest(self, most=600):
        for _ in range(self.random.randrange(0, most, 50) // 50):
            self.do(WINDOW, "pause", 50)

    def apply(self):
        self.do(f"{PANEL}/Accept", "activate")

    def select(self, source):
        self.do(BROWSER, "mousePress", f"1,1,0,60,8,{source}")
        self.do(BROWSER, "mouseRelease", f"1,0,0,60,8,{source}")

    def type_isovalue(self):
        table = f"{PROPERTIES}/ContourValues/ScalarValueList/Table"
        self.do(table, "setCurrent", "0.0")
        self.do(table, "edit", "0.0")
        self.do(table, "editAccepted", f"0.0,{self.random.uniform(60, 270):.2f}")
        self.apply()

    def change_back_and_forth(self):
        self.type_isovalue()
        self.rest()
        for action in ("actionEditUndo", "actionEditRedo"):
            self.do(f"{WINDOW}/menubar/menu_Edit", "activate", action)
            self.rest(200)

    def drag_isovalue(self):
        self.do(f"{PROPERTIES}/ContourValues/Live", "set_boolean", "true")
        self.do(CHART, "mousePress", f"1,1,0,{self.random.randrange(30, 250)},60")
        for _ in range(self.random.randrange(1, 12)):
            x = self.random.randrange(30, 250)
            self.do(CHART, "mouseMove", f"1,0,0,{x},60")
            self.rest(150)
        self.do(CHART, "mouseRelease", f"1,0,0,{x},60")
        if self.random.random() < 0.5:
            self.do(f"{PROPERTIES}/ContourValues/Live", "set_boolean", "false")

    def zoom_chart(self):
        self.do(CHART, "mouseWheel", f"{self.random.choice([-480, 240, 480])},0,0,60,60")

    def turn(self):
        self.do(VIEW, "mousePress", "(0.5,0.5,1,1,0)")
        for _ in range(self.random.randrange(1, 10)):
            x, y = self.random.uniform(0.2, 0.8), self.random.uniform(0.2, 0.8)
            self.do(VIEW, "mouseMove", f"({x:.3f},{y:.3f},1,0,0)")
        self.do(VIEW, "mouseRelease", "(0.5,0.6,1,0,0)")

    def select_cells(self):
        self.do(f"{FRAME}/actionSelectSurfaceCells", "set_boolean", "true")
        self.do(VIEW, "mousePress", "(0.3,0.4,1,1,0)")
        x, y = self.random.uniform(0.31, 0.7), self.random.uniform(0.41, 0.7)
        self.do(VIEW, "mouseMove", f"({x:.3f},{y:.3f},1,0,0)")
        self.do(VIEW, "mouseRelease", f"({x:.3f},{y:.3f},1,0,0)")

    def hover(self):
        kind = self.random.choice(["Points", "Cells"])
        self.do(f"{FRAME}/actionHoveringSurface{kind}", "set_boolean", "true")
        for _ in range(self.random.randrange(1, 8)):
            x, y = self.random.uniform(0.2, 0.8), self.random.uniform(0.2, 0.8)
            self.do(VIEW, "mouseMove", f"({x:.3f},{y:.3f},0,0,0)")
            self.rest(200)
        self.do(f"{FRAME}/actionHoveringSurface{kind}", "set_boolean", "false")

    def go_in_time(self):
        # First, previous, next, last.
        self.do(f"{WINDOW}/VCRToolbar/1QToolButton{self.random.choice([0, 1, 4, 5])}", "activate")

    def reload(self):
        self.select(READER)
        self.do(f"{WINDOW}/menubar/menu_File", "activate", "actionReloadFiles")
        if not self.has_reloaded:  # ParaView asks once
            buttons = f"{WINDOW}/reloadOptionsMessageBox/qt_msgbox_buttonbox"
            self.do(f"{buttons}/reloadExistingButton", "activate")
            self.has_reloaded = True
        self.rest()
        self.select(CONTOUR)

    def play(self):
        deeds = [
            (self.type_isovalue, 3),
            (self.change_back_and_forth, 1),
            (self.drag_isovalue, 4),
            (self.zoom_chart, 1),
            (self.turn, 4),
            (self.select_cells, 2),
            (self.hover, 3),
            (self.go_in_time, 3),
            (self.reload, 1),
        ]
        for _ in range(DEEDS):
            self.random.choices(*zip(*deeds))[0]()
            self.rest(self.random.choice([50, 200, 1000]))
        return self.events


def write_events(path, events):
    with open(path, "w") as file:
        file.write('<?xml version="1.0" ?>\n<pqevents>\n')
        for widget, command, arguments in events:
            file.write(
                f"  <pqevent object={quoteattr(widget)} command={quoteattr(command)}"
                f" arguments={quoteattr(arguments)} />\n"
            )
        file.write("</pqevents>\n")


class WindowStress(testing.TestCase):
    def play(self, seed):
        folder = testing.output(f"seed-{seed}")
        os.makedirs(folder)
        script = os.path.join(folder, "deeds.xml")
        write_events(script, Hand(seed).play())
        plugins = os.path.dirname(testing.arguments.plugin)
        plugin = [f"--plugin-search-paths={plugins}", "--plugins=ScalableIsosurface"]
        server, port = testing.start_server(os.path.join(folder, "server.log"), *plugin)
        here = os.path.dirname(os.path.abspath(__file__))
        try:
            with open(os.path.join(folder, "window.log"), "wb") as log:
                window = subprocess.run(
                    [
                        testing.arguments.paraview,
                        "--dr",
                        *plugin,
                        f"--server-url=cs://localhost:{port}",
                        f"--script={os.path.join(here, 'stress_scene.py')}",
                        f"--test-directory={folder}",
                        f"--test-script={script}",
                        "--exit",
                    ],
                    env={
                        **testing.make_mpi_environment(),
                        "PYTHONPATH": testing.arguments.window_python_path,
                        "STRESS_VOLUME": testing.volume("series.bvol"),
                        # No stock question when a hand hovers for the first time: the player waits forever.
                        "DASHBOARD_TEST_FROM_CTEST": "1",
                    },
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    timeout=testing.WAIT_SECONDS,
                    check=False,
                )
            self.assertEqual(window.returncode, 0)
            self.assertEqual(server.wait(timeout=testing.WAIT_SECONDS), 0)
        finally:
            server.kill()
            server.wait()
        for name in ("window.log", "server.log"):
            log = testing.read_log(os.path.join(folder, name))
            self.assertEqual(re.findall(r".*(?:ERR\||ERROR|Wrong tag|Traceback).*", log), [], name)

    def test_no_deed_ends_the_window_or_the_server(self):
        end = time.monotonic() + 60 * testing.arguments.minutes
        seed = testing.arguments.seed
        while time.monotonic() < end:
            with self.subTest(seed=seed):
                self.play(seed)
            seed += 1
        print(f"{seed - testing.arguments.seed} windows of {DEEDS} deeds", flush=True)


testing.run(with_plugin=False)
