# SPDX-License-Identifier: BSD-3-Clause
"""A display, a window manager, ParaView's window on it, and a hand: a mouse and a keyboard (xdotool).

The hand never sleeps for a fixed time: what it waits for, it looks for (eye.py). All that it starts ends with it,
even if it is killed.
"""
import ctypes
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from time_limits import WAIT_SECONDS  # noqa: E402  (found in the folder above)

HERE = os.path.dirname(os.path.abspath(__file__))
SETTINGS = """[General]
GeneralSettings.ShowSplashScreen=false
GeneralSettings.ShowWelcomeDialog=false
"""
# Any surface is large enough for what ParaView does to large ones.
PROPERTIES = '{"settings": {"RenderViewSettings": {"LODThreshold": 0.01}}}'
# What File > Connect... lists.
SERVERS = """<Servers><Server name="two ranks" resource="cs://localhost:%d"><ManualStartup/></Server></Servers>"""
SCREEN = (1366, 768)
POLL_SECONDS = 0.05
AGAIN_SECONDS = 3
STEP_SECONDS = WAIT_SECONDS / 5  # one wait; a step takes seconds where nothing else runs
END_WITH_PARENT = 1  # PR_SET_PDEATHSIG
prctl = ctypes.CDLL(None).prctl


def start(command, **options):
    """A process that gets SIGTERM when this one ends in whatever way."""
    return subprocess.Popen(command, preexec_fn=lambda: prctl(END_WITH_PARENT, signal.SIGTERM), **options)


def end(process):
    process.terminate()
    try:
        process.wait(timeout=STEP_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def wait_for(what, look, fits=bool, explain=str):
    """What look() gives as soon as it fits; None never does."""
    deadline = time.monotonic() + STEP_SECONDS
    while True:
        seen = look()
        if seen is not None and fits(seen):
            return seen
        if time.monotonic() > deadline:
            raise AssertionError("waited for %s: %s" % (what, explain(seen)))
        time.sleep(POLL_SECONDS)


class Display:
    """A display of its own, with a window manager."""

    def __init__(self):
        read, write = os.pipe()
        self.server = start(
            ["Xvfb", "-displayfd", str(write), "-noreset", "-screen", "0", "%dx%dx24" % SCREEN],
            pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.environment = {**os.environ, "DISPLAY": ":" + number.readline().strip()}
        self.manager = start(
            ["openbox"], env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def end(self):
        end(self.manager)
        end(self.server)


class Window:
    """ParaView on a display, in a home of its own; its output is in a log."""

    def __init__(self, display, paraview, version, folder, plugin=None, port=None):
        self.display, self.folder = display, folder
        shutil.rmtree(folder, ignore_errors=True)
        settings = os.path.join(folder, ".config", "ParaView")
        os.makedirs(settings)
        servers = SERVERS % port if port else ""
        # ParaView 6.1's settings, and those of older ones.
        for name, text in [("ParaView.ini", SETTINGS), ("ParaView%s.ini" % version, SETTINGS),
                           ("servers.pvsc", servers), ("ParaView-UserSettings.json", PROPERTIES)]:
            with open(os.path.join(settings, name), "w") as file:
                file.write(text)
        # A socket without a file, which nobody has to remove.
        self.eye = "eye.%d.%d" % (os.getpid(), id(self))
        environment = {**display.environment, "EYE": self.eye, "HOME": folder,
                       "XDG_CONFIG_HOME": os.path.join(folder, ".config")}
        environment.pop("PV_PLUGIN_PATH", None)
        loaded = [] if plugin is None else [
            "--plugin-search-paths=" + os.path.dirname(plugin), "--plugins=ScalableIsosurface"]
        self.log = open(os.path.join(folder, "window.log"), "wb")
        self.process = start(
            [paraview, *loaded, "--script=" + os.path.join(HERE, "eye.py")],
            env=environment, cwd=folder, stdout=self.log, stderr=subprocess.STDOUT)
        main = self.wait("find('pqClientMainWindow')")[0]
        # The title, so that the window is as large as the screen.
        self.click((main["at"][0], main["at"][1] - main["size"][1] // 2 - 10), 2)
        self.wait("find('pqClientMainWindow')", lambda found: found and found[0]["size"][0] > SCREEN[0] - 20)

    def end(self):
        self.process.kill()
        self.process.wait()
        self.log.close()

    # The eye

    def look(self, question):
        """The answer of eye.py; None while the window does not answer."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(STEP_SECONDS)
            try:
                connection.connect("\0" + self.eye)
                connection.sendall((question + "\n").encode())
                said = connection.makefile("rb").read()
            except OSError:
                said = b""
        if self.process.poll() is not None:
            with open(self.log.name, errors="replace") as log:
                raise AssertionError("the window has ended (%d) at %s: %s" %
                                     (self.process.returncode, question, log.read()[-1000:]))
        if not said:
            return None
        said = json.loads(said)
        if "error" in said:
            raise AssertionError(question + ": " + said["error"])
        return said["answer"]

    def wait(self, question, fits=bool):
        """Looks until the answer fits."""
        return wait_for(question, lambda: self.look(question), fits,
                        lambda answer: "%s; see %s" % (answer, self.save_screen("waited.png")))

    def save_screen(self, name):
        path = os.path.join(self.folder, name)
        self.look("save_screen(%r)" % path)
        return path

    # The hand

    def do(self, *arguments):
        subprocess.run(["xdotool", *map(str, arguments)], env=self.display.environment, check=True,
                       timeout=STEP_SECONDS)

    def click(self, at, times=1):
        self.do("mousemove", *at, "click", "--repeat", times, "--delay", 60, 1)

    def type(self, text):
        self.do("type", "--delay", 12, text)

    def key(self, *keys):
        self.do("key", *keys)

    def click_until(self, done, question):
        """Clicks the first that is found and enabled. ParaView drops clicks while it computes: then, again."""
        clicked = -AGAIN_SECONDS

        def click():
            nonlocal clicked
            if self.look(done):
                return True
            found = self.look(question)
            if found and found[0]["enabled"] and time.monotonic() > clicked + AGAIN_SECONDS:
                self.click(found[0]["at"])
                clicked = time.monotonic()
            return False

        wait_for(done, click, explain=lambda _: self.save_screen("waited.png"))

    def press(self, name="", kind="QAbstractButton", text=None):
        """Clicks a widget as soon as it is there and enabled."""
        self.click(self.wait("find(%r, %r, %r)" % (name, kind, text),
                             lambda found: found and found[0]["enabled"])[0]["at"])

    def apply(self):
        self.wait("find('Accept')", lambda found: found and found[0]["enabled"])
        self.click_until("find('Accept') and not find('Accept')[0]['enabled']", "find('Accept')")

    def choose(self, *texts):
        """Clicks entries of menus, from the menu bar on."""
        for text, following in zip(texts, texts[1:] + ("",)):
            self.click_until("entries(%r)" % following if following else "not entries(%r)" % text,
                             "entries(%r)" % text)

    def enter(self, title, typed):
        """Types into a dialog."""
        self.wait("dialog().startswith(%r)" % title)
        self.type(typed)
        self.key("Return")

    def answer(self, title, typed):
        """Types into a dialog that ends by it."""
        self.enter(title, typed)
        self.wait("dialog()", lambda said: said != "-" and not said.startswith(title))

    def pick(self, view, text):
        """Clicks a row of a list."""
        rows = self.wait("rows(%r)" % view, lambda rows: rows and any(row["texts"][0] == text for row in rows))
        self.click(next(row for row in rows if row["texts"][0] == text)["at"])

    def drop(self, path, done):
        """Drags a file or folder from another program into the view, and waits until it is done."""
        with open(os.path.join(self.folder, "drag.log"), "w") as log:
            source = start([sys.executable, os.path.join(HERE, "drag.py"), path],
                           env=self.display.environment, stdout=log)

        def has_said(text):
            with open(log.name) as said:
                return text in said.read()

        def move():
            # Each move asks what is below whether it takes the path.
            self.do("mousemove", 640 + time.monotonic_ns() // 10**8 % 20, 450)
            return has_said("taken")

        wait_for("a place to drag from", lambda: has_said("shown"))
        self.do("mousemove", 640, 12, "mousedown", 1)
        wait_for("a window that takes " + path, move)
        self.do("mouseup", 1)
        self.wait(done)
        end(source)

    def select(self, name):
        """Clicks a source in the pipeline browser, which is no list of Qt's: where it is, is tried."""
        browser = self.wait("find('', 'pqPipelineBrowserWidget')")[0]
        x, top = (browser["at"][axis] - browser["size"][axis] // 2 for axis in (0, 1))
        for y in range(top + 8, top + browser["size"][1], 8):
            self.click((x + 60, y))
            if self.wait("[active()]") == [name]:
                return
        raise AssertionError("no %s; see %s" % (name, self.save_screen("waited.png")))

    def see(self):
        """Waits until the view shows a surface that is final and stays as it is, and remembers it."""
        self.wait("find('RefinementStatus')",
                  lambda found: found and re.match("(?i)(level 0 shown|full resolution)", found[0]["text"]))
        self.wait("remember_view()", lambda share: share > 0.02)
