# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of generated volumes: the stone of a rock as a closed mesh, and a time series.

    pvpython gallery.py --plugin .../ScalableIsosurface.so [--output FOLDER]

Writes into FOLDER (default: the current one):
    rock.bvol, rock.stl, rock.png         a porous rock, closed, with its triangles
    drops.bvol, drops-0.png ... -2.png    three of the nine time steps of drops that meet
"""
import argparse
import os

from paraview import servermanager, simple

BACKGROUND = [0.16, 0.18, 0.22]

# Correlated noise, by its spectrum, as in models of porous rock: above 0 is stone.
ROCK = """
import numpy
size = 144
noise = numpy.random.default_rng(5).standard_normal((size, size, size))
axes = numpy.meshgrid(*[numpy.fft.fftfreq(size)] * 3)
frequency = numpy.sqrt(numpy.sum([axis ** 2 for axis in axes], axis=0))
rock = numpy.fft.ifftn(numpy.fft.fftn(noise) * numpy.exp(-((frequency / 0.035) ** 2))).real
rock = rock / rock.std() + 0.25
output.SetDimensions(size, size, size)
output.PointData.append(rock.astype(numpy.float32).ravel(), "density")
output.VTKObject.GetPointData().SetActiveScalars("density")
"""

# Two drops and a third one, which meet while time goes from 0 to 1.
DROPS = """
import numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
time = self.GetOutputInformation(0).Get(pipeline.UPDATE_TIME_STEP())
size = 96
z, y, x = numpy.meshgrid(*[numpy.linspace(-1, 1, size)] * 3, indexing="ij")
far = 0.65 * (1 - time)
drops = ((0.16, 1, 0, 0), (0.14, -0.8, 0.6, 0), (0.12, 0, -0.8, 0.6))
fields = [
    radius / numpy.sqrt((x - far * a) ** 2 + (y - far * b) ** 2 + (z - far * c) ** 2 + 1e-3)
    for radius, a, b, c in drops
]
field = numpy.sum(fields, axis=0)
output.SetDimensions(size, size, size)
output.PointData.append(field.astype(numpy.float32).ravel(), "field")
output.VTKObject.GetPointData().SetActiveScalars("field")
output.VTKObject.GetInformation().Set(vtk.vtkDataObject.DATA_TIME_STEP(), time)
"""
INFORMATION = """
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
info = self.GetOutputInformation(0)
info.Set(pipeline.WHOLE_EXTENT(), [0, {0}, 0, {0}, 0, {0}], 6)
"""
STEPS = """
info.Set(pipeline.TIME_STEPS(), [step / 8 for step in range(9)], 9)
info.Set(pipeline.TIME_RANGE(), [0.0, 1.0], 2)
"""


def write_volume(script, last, path, **options):
    source = simple.ProgrammableSource(OutputDataSetType="vtkImageData", Script=script)
    source.ScriptRequestInformation = INFORMATION.format(last) + (STEPS if options else "")
    source.UpdatePipelineInformation()
    simple.SaveData(path, proxy=source, **options)
    reader = simple.OpenDataFile(path)
    reader.UpdatePipeline()
    return reader


def make_view(size):
    view = simple.CreateRenderView(ViewSize=size, OrientationAxesVisibility=0)
    view.UseColorPaletteForBackground = 0
    view.Background = BACKGROUND
    return view


def show(surface, view, color, representation="Surface"):
    display = simple.Show(surface, view)
    simple.ColorBy(display, None)
    display.DiffuseColor = display.AmbientColor = color
    display.Representation = representation
    return display


def draw_rock(folder):
    reader = write_volume(ROCK, 143, os.path.join(folder, "rock.bvol"))
    mesh = simple.Isosurface(
        Input=reader, Isosurfaces=[0.0], MaximumIslands=1, CloseBoundary=1
    )
    mesh.Level = 1  # a quarter of the triangles
    simple.SaveData(os.path.join(folder, "rock.stl"), proxy=mesh)
    view = make_view([560, 448])
    display = show(mesh, view, [0.78, 0.66, 0.5], "Surface With Edges")
    display.EdgeColor = [0.45, 0.36, 0.26]
    view.CameraPosition = [330, 290, 400]
    view.CameraFocalPoint = [80, 76, 80]
    view.CameraViewAngle = 15
    simple.SaveScreenshot(os.path.join(folder, "rock.png"), view)
    edges = simple.FeatureEdges(Input=mesh, FeatureEdges=0, NonManifoldEdges=0)
    edges.UpdatePipeline()
    mesh.UpdatePropertyInformation()
    print(
        f"rock: {mesh.IslandSummary}; {mesh.GetDataInformation().GetNumberOfCells()} triangles, "
        f"{edges.GetDataInformation().GetNumberOfCells()} open edges"
    )


def draw_drops(folder):
    reader = write_volume(DROPS, 95, os.path.join(folder, "drops.bvol"), WriteAllTimeSteps=1)
    surface = simple.Isosurface(Input=reader, Isosurfaces=[0.75], ComputeIslandIds=1)
    islands = []
    for number, time in enumerate((0.0, 0.25, 0.5)):
        view = make_view([280, 280])
        surface.UpdatePipeline(time)
        field = servermanager.Fetch(surface).GetFieldData()
        islands.append(int(field.GetArray("Islands").GetTuple1(0)))
        view.ViewTime = time
        show(surface, view, [0.45, 0.65, 0.85])
        view.CameraPosition = [48, 48, 420]
        view.CameraFocalPoint = [48, 48, 48]
        view.CameraViewAngle = 15
        simple.SaveScreenshot(os.path.join(folder, f"drops-{number}.png"), view)
    print(f"drops: {islands} islands")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))
    os.makedirs(arguments.output, exist_ok=True)
    draw_rock(arguments.output)
    draw_drops(arguments.output)


main()
