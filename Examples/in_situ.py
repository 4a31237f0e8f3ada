#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A simulation that saves its isosurfaces while it runs: blocked volumes to explore later, surfaces to look at now.

    PYTHONPATH=build/release/lib/python3/dist-packages mpirun -n 4 python3 Examples/in_situ.py

Solves the wave equation for a pulse in a box with rigid walls, on any number of ranks, each with a slab of the grid
(numpy, mpi4py). Every few steps all ranks together append a time step to wave.bvol, by vtkBlockedVolumeWriter, and
write the isosurface of the pressure into wave_0.eix, wave_1.eix, ..., by vtkStabbingContour and vtkEdgeIndexWriter:
each rank only touches its own slab. ParaView opens the .eix files as one series, and the .bvol at any isovalue. The
output goes to the current folder. With --catalyst Examples/in_situ_catalyst.py, the steps go to that script of
ParaView's Catalyst instead.
"""

import argparse

import numpy
from mpi4py import MPI  # initializes MPI, which VTK finds done
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkParallelCore import vtkMultiProcessController
from vtkmodules.vtkParallelMPI import vtkMPIController

from scalable_isosurface import vtkBlockedVolumeWriter, vtkEdgeIndexWriter, vtkStabbingContour


class Wave:
    """The pressure on this rank's slab of n x n x n vertices, with one layer more on both sides."""

    def __init__(self, ranks, n):
        self.ranks = ranks
        self.n = n
        self.first, self.end = (n * part // ranks.size for part in (ranks.rank, ranks.rank + 1))
        z, y, x = numpy.meshgrid(
            numpy.arange(self.first - 1, self.end + 1), numpy.arange(n), numpy.arange(n), indexing="ij"
        )
        square = (x - 0.5 * n) ** 2 + (y - 0.4 * n) ** 2 + (z - 0.35 * n) ** 2
        self.now = numpy.exp(-square / (0.06 * n) ** 2)
        self.before = self.now.copy()

    def step(self):
        """One step of the leapfrog scheme, with a Courant number of 0.5."""
        p = numpy.pad(self.now, ((0, 0), (1, 1), (1, 1)), mode="edge")
        inner = p[1:-1, 1:-1, 1:-1]
        neighbours = p[2:, 1:-1, 1:-1] + p[:-2, 1:-1, 1:-1] + p[1:-1, 2:, 1:-1] + p[1:-1, :-2, 1:-1]
        neighbours = neighbours + p[1:-1, 1:-1, 2:] + p[1:-1, 1:-1, :-2]
        after = self.now.copy()
        after[1:-1] = 2 * inner - self.before[1:-1] + 0.25 * (neighbours - 6 * inner)
        self.before, self.now = self.now, after
        self.exchange_layers()

    def exchange_layers(self):
        """Ranks tell their neighbours the layers at their borders; the walls reflect."""
        rank, last = self.ranks.rank, self.ranks.size - 1
        self.now[0], self.now[-1] = self.now[1], self.now[-2]
        if rank > 0:
            self.now[0] = self.ranks.sendrecv(self.now[1], dest=rank - 1, source=rank - 1)
        if rank < last:
            self.now[-1] = self.ranks.sendrecv(self.now[-2], dest=rank + 1, source=rank + 1)

    def get_image(self, time):
        """This rank's slab as image data. Slabs meet: each ends with the first layer of the next one."""
        end = min(self.end + 1, self.n)
        slab = self.now[1 : 1 + end - self.first].astype(numpy.float32)
        image = vtkImageData()
        image.SetExtent(0, self.n - 1, 0, self.n - 1, self.first, end - 1)
        pressure = numpy_to_vtk(slab.ravel(), deep=True)
        pressure.SetName("pressure")
        image.GetPointData().SetScalars(pressure)
        image.GetInformation().Set(vtkDataObject.DATA_TIME_STEP(), time)
        return image


class Output:
    """Writes each saved step, as a time step of a volume and as a surface."""

    def __init__(self, n, isovalue):
        self.slab = vtkTrivialProducer()
        self.slab.SetWholeExtent(0, n - 1, 0, n - 1, 0, n - 1)
        self.volume = vtkBlockedVolumeWriter()
        self.volume.SetInputConnection(self.slab.GetOutputPort())
        self.volume.SetFileName("wave.bvol")
        self.contour = vtkStabbingContour()
        self.contour.SetInputConnection(self.slab.GetOutputPort())
        self.contour.SetValue(0, isovalue)
        self.surface = vtkEdgeIndexWriter()
        self.surface.SetInputConnection(self.contour.GetOutputPort())
        self.saved = 0

    def save(self, image, step):
        self.slab.SetOutput(image)
        self.volume.SetAppendTimeStep(self.saved > 0)
        self.surface.SetFileName(f"wave_{self.saved}.eix")
        if not self.volume.Write() or not self.surface.Write():
            raise SystemExit(1)  # on all ranks: they agree on errors
        self.saved += 1


class Catalyst:
    """Hands each saved step to a script of ParaView's Catalyst."""

    def __init__(self, script, n):
        from paraview.catalyst import bridge

        self.bridge = bridge
        self.extent = [0, n - 1] * 3
        bridge.initialize()
        bridge.add_pipeline(script, 2)

    def save(self, image, step):
        self.bridge.coprocess(float(step), step, image, wholeExtent=self.extent)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vertices", type=int, default=96, help="of the grid, along each axis")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--every", type=int, default=10, help="steps between two that are saved")
    parser.add_argument("--isovalue", type=float, default=0.03)
    parser.add_argument("--catalyst", metavar="SCRIPT", help="hand the steps to this script of ParaView's Catalyst")
    arguments = parser.parse_args()

    if arguments.catalyst:
        output = Catalyst(arguments.catalyst, arguments.vertices)  # starts ParaView, which finds MPI
    else:
        controller = vtkMPIController()
        controller.Initialize()
        vtkMultiProcessController.SetGlobalController(controller)
        output = Output(arguments.vertices, arguments.isovalue)
    wave = Wave(MPI.COMM_WORLD, arguments.vertices)
    for step in range(arguments.steps + 1):
        if step % arguments.every == 0:
            output.save(wave.get_image(float(step)), step)
            if wave.ranks.rank == 0:
                print(f"step {step}: saved", flush=True)
        wave.step()
    if arguments.catalyst:
        output.bridge.finalize()
    else:
        vtkMultiProcessController.SetGlobalController(None)
        controller.Finalize(1)  # mpi4py finalizes MPI


if __name__ == "__main__":
    main()
