# SPDX-License-Identifier: BSD-3-Clause
"""A display, a window manager, ParaView's window on it, and a hand: a mouse and a keyboard (xdotool).

The hand never sleeps for a fixed time: what it waits for, it looks for (eye.py).
"""
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from time_limits import WAIT_SECONDS  # noqa: E402  (found in the folder above)

HERE = os.path.dirname(os.path.abspath(__file__))
SCREEN = (1366, 768)
POLL_SECONDS = 0.05
SETTINGS = """[General]
GeneralSettings.ShowSplashScreen=false
GeneralSettings.ShowWelcomeDialog=false
"""


class Display:
    """A display of its own, with a window manager."""

    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-noreset", "-screen", "0", "%dx%dx24" % SCREEN],
            pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.environment = {**os.environ, "DISPLAY": ":" + number.readline().strip()}
        self.manager = subprocess.Popen(
            ["openbox"], env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def end(self):
        for process in (self.manager, self.server):
            process.terminate()
            process.wait()


class Window:
    """ParaView on a display, in a home of its own; its output is in a log."""

    def __init__(self, display, paraview, folder, plugin=None, *options):
        self.display, self.folder = display, folder
        shutil.rmtree(folder, ignore_errors=True)
        for version in ("ParaView", "ParaView5.11.0", "ParaView5.13.2"):
            os.makedirs(os.path.join(folder, ".config", "ParaView"), exist_ok=True)
            with open(os.path.join(folder, ".config", "ParaView", version + ".ini"), "w") as file:
                file.write(SETTINGS)
        # The path of a socket must be short.
        self.eye = "/tmp/eye.%d.%d" % (os.getpid(), id(self) % 100000)
        environment = {**display.environment, "EYE": self.eye, "HOME": folder,
                       "XDG_CONFIG_HOME": os.path.join(folder, ".config")}
        environment.pop("PV_PLUGIN_PATH", None)
        loaded = [] if plugin is None else [
            "--plugin-search-paths=" + os.path.dirname(plugin), "--plugins=ScalableIsosurface"]
        self.log = open(os.path.join(folder, "window.log"), "wb")
        self.process = subprocess.Popen(
            [paraview, *loaded, *options, "--script=" + os.path.join(HERE, "eye.py")],
            env=environment, cwd=folder, stdout=self.log, stderr=subprocess.STDOUT)
        size = self.wait("find('pqClientMainWindow')")[0]["size"]
        self.click((SCREEN[0] // 3, 8), 2)  # the title, so that the window is as large as the screen
        self.wait("find('pqClientMainWindow')", lambda found: found[0]["size"] != size)

    def end(self):
        self.process.kill()
        self.process.wait()
        self.log.close()
        if os.path.exists(self.eye):
            os.remove(self.eye)

    # The eye

    def look(self, question):
        """The answer of eye.py; None while the window does not answer."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(WAIT_SECONDS)
            try:
                connection.connect(self.eye)
                connection.sendall((question + "\n").encode())
                said = connection.makefile("rb").read()
            except OSError:
                said = b""
        if self.process.poll() is not None:
            raise AssertionError("the window has ended (%d) at %s" % (self.process.returncode, question))
        if not said:
            return None
        said = json.loads(said)
        if "error" in said:
            raise AssertionError(question + ": " + said["error"])
        return said["answer"]

    def wait(self, question, fits=bool):
        """Looks until the answer fits."""
        deadline = time.monotonic() + WAIT_SECONDS
        while True:
            answer = self.look(question)
            if answer is not None and fits(answer):
                return answer
            if time.monotonic() > deadline:
                self.save_screen("waited.png")
                raise AssertionError("%s is still %s" % (question, answer))
            time.sleep(POLL_SECONDS)

    def save_screen(self, name):
        path = os.path.join(self.folder, name)
        assert self.look("save_screen(%r)" % path)
        return path

    # The hand

    def do(self, *arguments):
        subprocess.run(["xdotool", *map(str, arguments)], env=self.display.environment, check=True)

    def click(self, at, times=1):
        self.do("mousemove", *at, "click", "--repeat", times, "--delay", 60, 1)

    def type(self, text):
        self.do("type", "--delay", 12, text)

    def key(self, *keys):
        self.do("key", *keys)

    def press(self, name="", kind="QAbstractButton", text=None):
        """Clicks a widget as soon as it is there and enabled."""
        self.click(self.wait("find(%r, %r, %r)" % (name, kind, text),
                             lambda found: found and found[0]["enabled"])[0]["at"])

    def choose(self, *texts):
        """Clicks entries of menus, from the menu bar on."""
        for text in texts:
            self.click(self.wait("entries(%r)" % text, lambda found: found and found[0]["enabled"])[0]["at"])

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

    def see(self):
        """Waits until the view shows a surface that is final, and remembers it."""
        self.wait("find('RefinementStatus')",
                  lambda found: found and re.match("(?i)(level 0 shown|full resolution)", found[0]["text"]))
        self.wait("remember_view()", lambda share: share > 0.02)
