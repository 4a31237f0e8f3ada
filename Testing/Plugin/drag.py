# SPDX-License-Identifier: BSD-3-Clause
"""A window from which a file or a folder can be dragged: drag.py PATH

It is at (640, 12), prints "shown" and "taken" (by what is below the mouse), and lives on, since it is asked
for the path after the drop.
"""
import sys

try:
    from PyQt6 import QtCore, QtGui, QtWidgets
except ImportError:
    from PyQt5 import QtCore, QtGui, QtWidgets


class Source(QtWidgets.QLabel):
    def mousePressEvent(self, _event):
        data = QtCore.QMimeData()
        data.setUrls([QtCore.QUrl.fromLocalFile(sys.argv[1])])
        drag = QtGui.QDrag(self)
        drag.setMimeData(data)
        drag.actionChanged.connect(lambda _action: print("taken", flush=True))
        (getattr(drag, "exec", None) or drag.exec_)(QtCore.Qt.DropAction.CopyAction)


application = QtWidgets.QApplication(sys.argv)
source = Source("drag")
source.setWindowFlags(QtCore.Qt.WindowType.BypassWindowManagerHint | QtCore.Qt.WindowType.WindowStaysOnTopHint)
source.setGeometry(600, 0, 80, 24)
source.show()
QtCore.QTimer.singleShot(0, lambda: print("shown", flush=True))
(getattr(application, "exec", None) or application.exec_)()
