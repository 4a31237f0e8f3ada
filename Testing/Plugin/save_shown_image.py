# SPDX-License-Identifier: BSD-3-Clause
"""For the Python shell of the window: saves what the view shows, and what it shows once it is drawn at once.
Then turns the mouse's wheel."""
import os

from paraview import simple
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

view = simple.GetActiveView()


def save(name):
    grab = vtkWindowToImageFilter()
    grab.SetInput(view.GetRenderWindow())
    grab.ShouldRerenderOff()
    grab.ReadFrontBufferOn()
    writer = vtkPNGWriter()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetFileName(os.path.join(os.environ["IMAGES"], name))
    writer.Write()


number = globals().get("number", -1) + 1  # the shell keeps it
save(f"shown{number}.png")
simple.Render(view)
save(f"drawn{number}.png")
if number > 0:
    view.GetInteractor().MouseWheelForwardEvent()
save(f"after{number}.png")
