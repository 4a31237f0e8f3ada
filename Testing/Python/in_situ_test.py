# SPDX-License-Identifier: BSD-3-Clause
"""Compares what Examples/in_situ.py wrote on one rank with what its other runs wrote:
in_situ_test.py FOLDER RUN..."""
import os
import sys
import unittest

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

from scalable_isosurface import vtkBlockedVolumeReader, vtkEdgeIndexReader

FOLDER, *RUNS = sys.argv[1:]
del sys.argv[1:]
STEPS = 3
ISOVALUE = 0.03


def read(run, step):
    with open(os.path.join(FOLDER, run, f"wave_{step}.eix"), "rb") as file:
        return file.read()


class InSitu(unittest.TestCase):
    def test_surfaces_are_those_of_one_rank_byte_for_byte(self):
        for run in RUNS:
            for step in range(STEPS):
                self.assertTrue(read(run, step) == read("OneRankWrites", step), (run, step))
        self.assertNotEqual(read("OneRankWrites", 0), read("OneRankWrites", 1))

    def test_each_surface_is_flying_edges_of_the_saved_time_step(self):
        volume = vtkBlockedVolumeReader()
        volume.SetFileName(os.path.join(FOLDER, "FourRanksWrite", "wave.bvol"))
        for step in range(STEPS):
            volume.UpdateTimeStep(10.0 * step)
            edges = vtkFlyingEdges3D()
            edges.SetInputData(volume.GetOutput().GetPartition(0))
            edges.SetInputArrayToProcess(0, 0, 0, 0, "pressure")
            edges.SetValue(0, ISOVALUE)
            edges.Update()
            surface = vtkEdgeIndexReader()
            surface.SetFileName(os.path.join(FOLDER, "FourRanksWrite", f"wave_{step}.eix"))
            surface.Update()
            expected, found = (
                {tuple(point) for point in vtk_to_numpy(data.GetPoints().GetData())}
                for data in (edges.GetOutput(), surface.GetOutput())
            )
            self.assertGreater(len(expected), 100)
            self.assertEqual(expected, found)
            self.assertEqual(edges.GetOutput().GetNumberOfPolys(), surface.GetOutput().GetNumberOfPolys())


if __name__ == "__main__":
    unittest.main()
