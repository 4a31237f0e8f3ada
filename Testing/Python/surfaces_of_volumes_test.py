# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of scalable_isosurface.open beside those of VTK's filters, and of edge-index files."""

import gc
import os
import pickle
import sys
import tempfile
import unittest
import warnings

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkRectilinearGrid
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

import scalable_isosurface as si
from scalable_isosurface import (
    vtkBlockedVolumeReader,
    vtkBlockedVolumeWriter,
    vtkEdgeIndexWriter,
    vtkStabbingContour,
)

try:
    import pyvista
except ImportError:
    pyvista = None

VTK_VERSION = vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()
SPACING = (0.5, 1, 2)
ORIGIN = (3, -4, 5)


def make_waves():
    z, y, x = numpy.meshgrid(numpy.arange(40), numpy.arange(50), numpy.arange(70), indexing="ij")
    return (100 * numpy.sin(0.4 * x) * numpy.cos(0.3 * y) + 2 * z).astype(numpy.int16)


def contour_by_flying_edges(samples, isovalues):
    image = vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.SetSpacing(SPACING)
    image.SetOrigin(ORIGIN)
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel(), deep=True))
    edges = vtkFlyingEdges3D()
    edges.SetInputData(image)
    for number, isovalue in enumerate(isovalues):
        edges.SetValue(number, isovalue)
    edges.Update()
    return edges.GetOutput()


def get_arrays(surface):
    """Points, triangles and normals of a vtkPolyData."""
    return (
        vtk_to_numpy(surface.GetPoints().GetData()),
        vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3),
        vtk_to_numpy(surface.GetPointData().GetNormals()),
    )


def sort_corners(points, triangles):
    """The triangles' corners, in an order that depends on no order of points or cells."""
    corners = points[triangles].reshape(-1, 9)
    return corners[numpy.lexsort(corners.T)]


class BesideVTK(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.samples = make_waves()
        cls.path = os.path.join(cls.folder.name, "waves.bvol")
        cls.volume = si.create(cls.samples, cls.path, spacing=SPACING, origin=ORIGIN, name="waves")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def make_contour(self, isovalues):
        reader = vtkBlockedVolumeReader()
        reader.SetFileName(self.path)
        contour = vtkStabbingContour()
        contour.SetInputConnection(reader.GetOutputPort())
        contour.SetInputArrayToProcess(0, 0, 0, 0, "waves")
        for number, isovalue in enumerate(isovalues):
            contour.SetValue(number, isovalue)
        return contour

    def test_surface_is_that_of_flying_edges(self):
        for isovalues in ([30.5], [-20], [60, 10.25]):
            surface = self.volume.isosurface(isovalues)
            stock = get_arrays(contour_by_flying_edges(self.samples, isovalues))
            self.assertGreater(len(surface.triangles), 1000)
            numpy.testing.assert_array_equal(
                sort_corners(surface.points, surface.triangles), sort_corners(*stock[:2])
            )

    def test_surface_is_that_of_the_contour_filter(self):
        contour = self.make_contour([30.5, 60])
        contour.Update()
        points, triangles, normals = get_arrays(contour.GetOutput())
        surface = self.volume.isosurface([30.5, 60])
        numpy.testing.assert_array_equal(surface.points, points)
        numpy.testing.assert_array_equal(surface.triangles, triangles)
        numpy.testing.assert_allclose(surface.normals, normals, atol=1e-6)

    def test_vtk_shares_the_memory_of_the_arrays(self):
        surface = self.volume.isosurface([30.5, 60])
        data = surface.to_vtk()
        points, triangles, normals = get_arrays(data)
        for ours, theirs in ((surface.points, points), (surface.triangles, triangles), (surface.normals, normals)):
            numpy.testing.assert_array_equal(ours, theirs)
            # Filters before VTK 9.4 need ids of 64 bits.
            is_copied = ours is surface.triangles and VTK_VERSION < (9, 4)
            self.assertEqual(numpy.shares_memory(ours, theirs), not is_copied)
        isovalues = vtk_to_numpy(data.GetPointData().GetArray("isovalue"))
        self.assertEqual(isovalues.tolist(), [30.5] * surface.point_offsets[1] + [60] * len(surface.part(1).points))
        del surface
        self.assertEqual(get_arrays(data)[0].tolist(), points.tolist())

    def test_what_vtk_has_outlives_the_surface(self):
        volume = si.create(numpy.tile(self.samples, (3, 3, 3)), os.path.join(self.folder.name, "large.bvol"))
        for convert in (si.Surface.to_vtk, *([si.Surface.to_pyvista] if pyvista else [])):
            surface = volume.isosurface(30.5)
            copies = surface.points.copy(), surface.triangles.copy(), surface.normals.copy()
            self.assertGreater(surface.triangles.nbytes, 2**20)
            data = convert(surface)
            del surface
            gc.collect()
            others = [volume.isosurface(isovalue) for isovalue in (30, 31, 32)]  # into what was freed
            for copy, theirs in zip(copies, get_arrays(data)):
                numpy.testing.assert_array_equal(theirs, copy)
            del others

    @unittest.skipUnless(pyvista, "there is no PyVista")
    def test_pyvista_takes_a_surface(self):
        surface = self.volume.isosurface(30.5)
        mesh = surface.to_pyvista()
        self.assertEqual(mesh.n_cells, len(surface.triangles))
        numpy.testing.assert_array_equal(mesh.points, surface.points)

    def test_rectilinear_grids_have_coordinates(self):
        lines = [numpy.cumsum(1 + 0.1 * (numpy.arange(size) % 7)) for size in self.samples.shape[::-1]]
        grid = vtkRectilinearGrid()
        grid.SetDimensions(*self.samples.shape[::-1])
        for set_line, line in zip((grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates), lines):
            set_line(numpy_to_vtk(line, deep=True))
        scalars = numpy_to_vtk(self.samples.ravel(), deep=True)
        scalars.SetName("waves")
        grid.GetPointData().SetScalars(scalars)
        writer = vtkBlockedVolumeWriter()
        writer.SetInputData(grid)
        writer.SetFileName(os.path.join(self.folder.name, "lines.bvol"))
        self.assertTrue(writer.Write())
        volume = si.open(writer.GetFileName())
        copy = si.create(volume, os.path.join(self.folder.name, "copy.bvol"))
        for opened in (volume, copy):
            for line, coordinates in zip(lines, opened.coordinates):
                numpy.testing.assert_array_equal(coordinates, line)
            numpy.testing.assert_array_equal(opened.level(1).coordinates[1], lines[1][::2])
        numpy.testing.assert_array_equal(copy.isosurface(30.5).points, volume.isosurface(30.5).points)
        ends = [line[-1] + 0.001 for line in lines]
        self.assertTrue((volume.isosurface(30.5).points.max(axis=0) < ends).all())
        regular = si.create(volume, os.path.join(self.folder.name, "regular.bvol"), spacing=(1, 1, 1))
        self.assertIsNone(regular.coordinates)

    def test_edge_index_file_gives_the_surface_back(self):
        path = os.path.join(self.folder.name, "waves.eix")
        contour = self.make_contour([30.5, 60])
        writer = vtkEdgeIndexWriter()
        writer.SetInputConnection(contour.GetOutputPort())
        writer.SetFileName(path)
        self.assertTrue(writer.Write())
        file = si.open(path)
        self.assertIsInstance(file, si.EdgeIndex)
        self.assertEqual((file.isovalues, file.name, file.time), ((30.5, 60), "waves", None))
        whole = self.volume.isosurface([30.5, 60])
        for again in (file, pickle.loads(pickle.dumps(file))):
            surface = again.isosurface()
            numpy.testing.assert_array_equal(surface.points, whole.points)
            numpy.testing.assert_array_equal(surface.triangles, whole.triangles)
        alone = file.isosurface(60, normals=False)
        self.assertEqual((alone.isovalues.tolist(), alone.normals), ([60], None))
        numpy.testing.assert_array_equal(alone.points, whole.part(1).points)
        self.assertRaisesRegex(ValueError, "waves.eix: has no surface of 61", file.isosurface, 61)
        for source in (file, self.volume):
            turned = source.isosurface([60, 30.5, 60])
            self.assertEqual(turned.isovalues.tolist(), [60, 30.5, 60])
            for number, part in enumerate((1, 0, 1)):
                numpy.testing.assert_array_equal(turned.part(number).points, whole.part(part).points)
                numpy.testing.assert_array_equal(turned.part(number).triangles, whole.part(part).triangles)
            self.assertRaisesRegex(ValueError, "there is no isovalue", source.isosurface, [])
        self.assertTrue(file.has_preview)
        self.assertLess(len(file.isosurface(preview=True).points), len(whole.points) / 2)

        contour = self.make_contour([1000])
        writer.SetInputConnection(contour.GetOutputPort())
        writer.SetFileName(os.path.join(self.folder.name, "empty.eix"))
        self.assertTrue(writer.Write())
        for source in (si.open(writer.GetFileName()), self.volume):
            empty = source.isosurface(1000)
            self.assertEqual((empty.normals.shape, empty.normals.dtype), ((0, 3), numpy.float32))
            self.assertIsNone(source.isosurface(1000, normals=False).normals)
            data = empty.to_vtk()
            self.assertEqual((data.GetNumberOfPolys(), data.GetPointData().GetNormals().GetNumberOfTuples()), (0, 0))

        size = os.path.getsize(path)
        os.truncate(path, size // 2)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            part = si.open(path).isosurface()
        self.assertRegex(str(caught[0].message), "waves.eix: the file was cut off, is damaged")
        self.assertLess(len(part.points), len(whole.points))
        with open(path, "r+b") as file:
            file.truncate(40)
        self.assertRaisesRegex(OSError, "waves.eix", si.open, path)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
