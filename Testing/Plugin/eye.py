# SPDX-License-Identifier: BSD-3-Clause
"""What a person sees of ParaView's window, for hand.py: paraview --script=eye.py, with EYE, a name.

A socket of that name (in no folder) takes expressions of the functions below, one a connection, and answers in JSON.
They look, and never touch: what is done is done by mouse and keyboard.
"""
import json
import os
import socket
import sys

import numpy

try:
    from PyQt6 import QtCore, QtWidgets
except ImportError:
    from PyQt5 import QtCore, QtWidgets

POLL_MILLISECONDS = 20


def place(widget, rectangle=None):
    """The middle of a widget, or of a rectangle in it, on the screen."""
    rectangle = rectangle or widget.rect()
    middle = widget.mapToGlobal(rectangle.center())
    return [middle.x(), middle.y()]


def top():
    """The dialog that has to be answered, or else the windows."""
    modal = QtWidgets.QApplication.activePopupWidget() or QtWidgets.QApplication.activeModalWidget()
    return [modal] if modal else QtWidgets.QApplication.topLevelWidgets()


def find(name="", kind="QWidget", text=None):
    """Visible widgets of an object name, class and text, in what has to be answered."""
    found = []
    for window in top():
        for widget in [window] + window.findChildren(QtWidgets.QWidget):
            label = getattr(widget, "text", getattr(widget, "title", getattr(widget, "windowTitle", str)))
            if isinstance(widget, QtWidgets.QComboBox):
                label = widget.currentText
            if (widget.isVisible() and name in ("", widget.objectName()) and widget.inherits(kind)
                    and (text is None or text == (label() or "").replace("&", ""))
                    and not widget.visibleRegion().isEmpty()):
                found.append({"name": widget.objectName(), "at": place(widget), "enabled": widget.isEnabled(),
                              "text": label() or "", "title": widget.windowTitle(),
                              "size": [widget.width(), widget.height()]})
    return found


def is_shown(name):
    """Whether a widget of an object name is shown, though one may have to scroll to it."""
    return any(widget.isVisible() and widget.objectName() == name
               for window in top() for widget in window.findChildren(QtWidgets.QWidget))


def dialog():
    """The title of the dialog that has to be answered; "-" until it takes what is typed."""
    modal = QtWidgets.QApplication.activeModalWidget()
    return "" if not modal else modal.windowTitle() if modal.isActiveWindow() else "-"


def entries(text):
    """The places of the entries that begin with this text, in the menu bar and the menus that are open."""
    found = []
    for window in QtWidgets.QApplication.topLevelWidgets():
        for menu in [window] + window.findChildren(QtWidgets.QMenuBar):
            if isinstance(menu, (QtWidgets.QMenu, QtWidgets.QMenuBar)) and menu.isVisible():
                for action in menu.actions():
                    if action.text().replace("&", "").startswith(text) and action.isVisible():
                        found.append({"at": place(menu, menu.actionGeometry(action)),
                                      "enabled": action.isEnabled()})
    return found


def rows(name):
    """The rows of a list, table or tree: texts, those below, place, whether one is selected."""
    for window in top():
        for view in window.findChildren(QtWidgets.QAbstractItemView, name):
            if view.isVisible():
                model, root = view.model(), view.rootIndex()
                # Qt's models of lists hide what trees have.
                columns = 1 if isinstance(view, QtWidgets.QListView) else model.columnCount(root)
                found = []
                for row in range(model.rowCount(root)):
                    index = model.index(row, 0, root)
                    inner = 0 if columns == 1 else model.rowCount(index)
                    found.append({
                        "texts": [str(model.index(row, column, root).data() or "") for column in range(columns)],
                        "inner": [str(model.index(at, 0, index).data()) for at in range(inner)],
                        "at": place(view.viewport(), view.visualRect(index)),
                        "selected": view.selectionModel().isSelected(index)})
                return found
    return None


def read_view():
    """The pixels of the first view, as they are on the screen."""
    view = next(widget for window in QtWidgets.QApplication.topLevelWidgets()
                for widget in window.findChildren(QtWidgets.QWidget)
                if widget.inherits("pqQVTKWidget") and widget.isVisible())
    corner = view.mapToGlobal(QtCore.QPoint(0, 0))
    image = QtWidgets.QApplication.primaryScreen().grabWindow(
        0, corner.x(), corner.y(), view.width(), view.height()).toImage()
    image = image.convertToFormat(image.Format.Format_RGB32)
    bits = image.constBits()
    bits.setsize(image.bytesPerLine() * image.height())
    return numpy.frombuffer(bits, "u1").reshape(image.height(), -1, 4)[:, :image.width(), :3].astype("i2")


def remember_view():
    """The share of pixels that are not background, of which there is most; 0 if others were remembered."""
    view = read_view()
    steady = remembered and numpy.array_equal(remembered[0], view)
    remembered[:] = [view]
    colors, counts = numpy.unique(view.reshape(-1, 3), axis=0, return_counts=True)
    return 1 - counts.max() / counts.sum() if steady else 0


def compare_view():
    """The share of pixels that differ from those remembered last; 1 if there is no such view."""
    try:
        view = read_view()
    except StopIteration:
        return 1.0
    if view.shape != remembered[0].shape:
        return 1.0
    return float((abs(view - remembered[0]).max(axis=2) > 40).mean())


def count_cells():
    """Of what the pipeline browser lists, by names."""
    from paraview import simple

    return {name[0]: source.GetDataInformation().GetNumberOfCells()
            for name, source in simple.GetSources().items()}


def active():
    """The name of the source that is selected."""
    from paraview import simple

    source = simple.GetActiveSource()
    return next((name[0] for name, other in simple.GetSources().items() if other == source), "")


def is_remote():
    """Whether data are on a server."""
    from paraview import servermanager

    return servermanager.ActiveConnection.IsRemote()


def save_screen(path):
    return QtWidgets.QApplication.primaryScreen().grabWindow(0).save(path)


def answer():
    try:
        connection, _ = server.accept()
    except BlockingIOError:
        return
    with connection:
        connection.setblocking(True)
        question = connection.makefile("r", encoding="utf-8").readline()
        try:
            said = {"answer": eval(question, globals())}
        except Exception as error:  # noqa: BLE001  (whatever it is, the test tells it)
            said = {"error": repr(error)}
        connection.sendall(json.dumps(said).encode())


remembered = []
server = socket.socket(socket.AF_UNIX)
server.bind("\0" + os.environ["EYE"])
server.listen()
server.setblocking(False)
timer = QtCore.QTimer()
timer.timeout.connect(answer)
timer.start(POLL_MILLISECONDS)
sys.modules["eye"] = sys.modules[__name__]
QtWidgets.QApplication.instance().eye = server, timer, globals()
