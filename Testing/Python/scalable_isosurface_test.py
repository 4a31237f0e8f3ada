# SPDX-License-Identifier: BSD-3-Clause
"""The package scalable_isosurface, as a script uses it."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringOutputWindow, vtkOutputWindow, vtkVersion
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

import scalable_isosurface
from scalable_isosurface import (
    vtkBlockedVolumeReader,
    vtkBlockedVolumeWriter,
    vtkContourSpectrum,
    vtkEdgeIndexReader,
    vtkEdgeIndexWriter,
    vtkStabbingContour,
)

ISOVALUE = 0.3


def make_image():
    """Waves in a box of 40 x 30 x 20 samples."""
    z, y, x = numpy.meshgrid(numpy.arange(20), numpy.arange(30), numpy.arange(40), indexing="ij")
    values = numpy.sin(0.4 * x) * numpy.cos(0.3 * y) + 0.02 * z
    image = vtkImageData()
    image.SetDimensions(40, 30, 20)
    image.SetSpacing(0.5, 1, 2)
    scalars = numpy_to_vtk(values.astype(numpy.float32).ravel(), deep=True)
    scalars.SetName("waves")
    image.GetPointData().SetScalars(scalars)
    return image


def get_sorted_corners(surface):
    """The triangles' corners as a sorted array, which depends on no order of points or cells."""
    points = vtk_to_numpy(surface.GetPoints().GetData())
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    corners = points[triangles].reshape(-1, 9)
    return corners[numpy.lexsort(corners.T)]


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.volume = os.path.join(cls.folder.name, "waves.bvol")
        cls.image = make_image()
        writer = vtkBlockedVolumeWriter()
        writer.SetInputData(cls.image)
        writer.SetFileName(cls.volume)
        assert writer.Write()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def contour_volume(self):
        reader = vtkBlockedVolumeReader()
        reader.SetFileName(self.volume)
        contour = vtkStabbingContour()
        contour.SetInputConnection(reader.GetOutputPort())
        contour.SetInputArrayToProcess(0, 0, 0, 0, "waves")
        contour.SetValue(0, ISOVALUE)
        return contour

    def test_surface_of_a_written_volume_is_that_of_flying_edges(self):
        contour = self.contour_volume()
        contour.Update()
        stock = vtkFlyingEdges3D()
        stock.SetInputData(self.image)
        stock.SetValue(0, ISOVALUE)
        stock.Update()
        self.assertGreater(stock.GetOutput().GetNumberOfPolys(), 1000)
        numpy.testing.assert_array_equal(
            get_sorted_corners(contour.GetOutput()), get_sorted_corners(stock.GetOutput())
        )

    def test_edge_index_file_gives_the_surface_back(self):
        contour = self.contour_volume()
        path = os.path.join(self.folder.name, "waves.eix")
        writer = vtkEdgeIndexWriter()
        writer.SetInputConnection(contour.GetOutputPort())
        writer.SetFileName(path)
        self.assertTrue(writer.Write())
        reader = vtkEdgeIndexReader()
        reader.SetFileName(path)
        reader.Update()
        contour.Update()
        numpy.testing.assert_array_equal(
            get_sorted_corners(reader.GetOutput()), get_sorted_corners(contour.GetOutput())
        )

    def test_spectrum_counts_the_triangles_of_the_surface(self):
        image = vtkImageData()
        image.DeepCopy(self.image)
        scalars = numpy_to_vtk(
            (100 * vtk_to_numpy(image.GetPointData().GetScalars())).astype(numpy.uint8), deep=True
        )
        scalars.SetName("bytes")
        image.GetPointData().SetScalars(scalars)
        spectrum = vtkContourSpectrum()
        spectrum.SetInputData(image)
        spectrum.SetInputArrayToProcess(0, 0, 0, 0, "bytes")
        spectrum.Update()
        table = spectrum.GetOutput()
        isovalues = vtk_to_numpy(table.GetColumnByName("Isovalue"))
        triangles = vtk_to_numpy(table.GetColumnByName("Triangles"))
        contour = vtkStabbingContour()
        contour.SetInputData(image)
        contour.SetInputArrayToProcess(0, 0, 0, 0, "bytes")
        for row in (20, 40, 60):
            contour.SetValue(0, isovalues[row])
            contour.Update()
            self.assertEqual(contour.GetOutput().GetNumberOfPolys(), triangles[row])

    def test_error_names_file_and_reason_as_those_of_stock_classes_do(self):
        missing = os.path.join(self.folder.name, "missing.bvol")
        window = vtkStringOutputWindow()
        before = vtkOutputWindow.GetInstance()
        vtkOutputWindow.SetInstance(window)
        try:
            reader = vtkBlockedVolumeReader()
            reader.SetFileName(missing)
            reader.Update()
        finally:
            vtkOutputWindow.SetInstance(before)
        self.assertIn(missing, window.GetOutput())

    def test_every_public_class_is_in_the_package(self):
        for module in scalable_isosurface._MODULES:
            extension = importlib.import_module(f"scalable_isosurface.{module}")
            classes = {name for name in dir(extension) if name.startswith("vtk")}
            self.assertEqual(classes, set(scalable_isosurface._MODULES[module]))
            for name in classes:
                self.assertIs(getattr(scalable_isosurface, name), getattr(extension, name))
        self.assertLessEqual(set(scalable_isosurface.__all__), set(dir(scalable_isosurface)))
        with self.assertRaises(AttributeError):
            scalable_isosurface.vtkNoSuchClass

    @unittest.skipIf(vtkVersion.GetVTKVersion().startswith("9.1."), "VTK 9.1 makes no type hints")
    def test_type_hints_and_docstrings_are_those_of_the_headers(self):
        folder = os.path.dirname(scalable_isosurface.__file__)
        with open(os.path.join(folder, "IsosurfaceFilters.pyi")) as hints:
            self.assertIn("class vtkStabbingContour", hints.read())
        with open(os.path.join(folder, "__init__.pyi")) as hints:
            text = hints.read()
        for name in scalable_isosurface._MODULE_OF:
            self.assertIn(f"{name} as {name}", text)
        self.assertIn("isosurfaces of blocked volumes", vtkStabbingContour.__doc__)

    def import_beside(self, vtk_common_core):
        """The last line of a use of a class in a Python whose vtkmodules.vtkCommonCore has this source."""
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "vtkmodules"))
            open(os.path.join(folder, "vtkmodules", "__init__.py"), "w").close()
            if vtk_common_core is not None:
                with open(os.path.join(folder, "vtkmodules", "vtkCommonCore.py"), "w") as source:
                    source.write(vtk_common_core)
            package = os.path.dirname(os.path.dirname(scalable_isosurface.__file__))
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join((folder, package))}
            result = subprocess.run(
                ["python3", "-B", "-c", "import scalable_isosurface\nscalable_isosurface.vtkStabbingContour"],
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertNotEqual(result.returncode, 0)
            return result.stderr.strip().splitlines()[-1]

    def test_python_of_another_vtk_gets_one_line_that_says_so(self):
        line = self.import_beside(
            "class vtkVersion:\n    @staticmethod\n    def GetVTKVersion():\n        return '8.1.0'\n"
        )
        self.assertRegex(
            line, "^ImportError: .*built with VTK 9.*this Python has VTK 8.1.0.*use the python3 beside"
        )

    def test_python_without_vtk_gets_one_line_that_names_what_is_missing(self):
        self.assertRegex(self.import_beside(None), "^ImportError: .*needs the Python modules of VTK 9")

    def use_without_extension(self, version=sys.version_info, module=None):
        """What the package says in a Python of this version, where IsosurfaceFilters is not there or has this source."""
        with tempfile.TemporaryDirectory() as folder:
            if module is not None:
                with open(os.path.join(folder, "IsosurfaceFilters.py"), "w") as source:
                    source.write(module)
            specification = importlib.util.spec_from_file_location(
                "without_extension", scalable_isosurface.__file__, submodule_search_locations=[folder]
            )
            package = importlib.util.module_from_spec(specification)
            with unittest.mock.patch.dict(sys.modules, without_extension=package):
                specification.loader.exec_module(package)
                with unittest.mock.patch.object(package._sys, "version_info", version):
                    with self.assertRaises(ImportError) as raised:
                        package.vtkStabbingContour
        return str(raised.exception)

    def test_another_python_gets_one_line_that_says_which_to_use(self):
        version = ".".join(map(str, sys.version_info[:2]))
        self.assertRegex(
            self.use_without_extension((4, 2, 0)),
            f"built for Python {version}, and this is Python 4.2; use python{version}$",
        )

    def test_missing_library_gets_one_line_that_names_it(self):
        error = "libIsosurfaceCore.so.1: cannot open shared object file"
        self.assertEqual(
            self.use_without_extension(module=f"raise ImportError('{error}')\n"),
            f"IsosurfaceFilters of without_extension cannot be loaded: {error}; "
            "install the package again, with its libraries",
        )


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
