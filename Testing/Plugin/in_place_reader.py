# SPDX-License-Identifier: BSD-3-Clause
"""Zarr and HDF5 are opened by the reader that indexes them in place: --python PATH (with h5py)

The oracle is vtkFlyingEdges3D on the samples that were written.
"""
import filecmp
import os
import shutil
import subprocess
import time

import numpy
from paraview import simple
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

import plugin_testing as testing

CHUNK = 16


def read_samples():
    reader = vtkXMLImageDataReader()
    reader.SetFileName(testing.volume("wave.vti"))
    reader.Update()
    return testing.read_samples(reader.GetOutput()).astype("f4")


def write_zarr(folder, samples):
    testing.write_zarr(folder, samples, CHUNK)


def write_hdf5(path, samples):
    numpy.save(path + ".npy", samples)
    subprocess.run(
        [testing.arguments.python, "-c",
         "import h5py, numpy, sys\n"
         "samples = numpy.load(sys.argv[1] + '.npy')\n"
         "with h5py.File(sys.argv[1], 'w') as file:\n"
         "    for name, factor in (('run/half', 0.5), ('run/whole', 1)):\n"
         "        file.create_dataset(name, data=samples * factor, chunks=(11, 13, 17), compression='gzip')\n",
         path],
        check=True, env=testing.make_mpi_environment())


def list_stores(index):
    return sorted(os.listdir(index + ".stores"))


def count_triangles(reader, isovalue=testing.ISOVALUE):
    reader.UpdatePipeline()
    names = [reader.PointData.GetArray(n).Name for n in range(reader.PointData.GetNumberOfArrays())]
    array = next(name for name in names if name != "vtkGhostType")
    return testing.count_cells(testing.contour(reader, isovalue, array))


class InPlaceReader(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.samples = read_samples()
        cls.expected = testing.count_expected_triangles()

    def setUp(self):
        simple.ResetSession()
        self.source = testing.output(self.id().split(".")[-1] + ".zarr")
        self.index = self.source + ".bvol"

    def open(self, path, **properties):
        reader = simple.OpenDataFile(path, **properties)
        self.assertEqual(reader.GetXMLName(), "InPlaceVolumeReader")
        return reader

    def test_zarr_is_indexed_once_and_opens_at_once_then(self):
        write_zarr(self.source, self.samples)
        reader = self.open(os.path.join(self.source, ".zarray"))
        self.assertFalse(os.path.exists(self.index), "written before anybody applied")
        self.assertEqual(count_triangles(reader), self.expected)
        written = list_stores(self.index)
        self.assertEqual(count_triangles(self.open(self.source)), self.expected)
        self.assertEqual(list_stores(self.index), written)

    def test_contour_alone_has_the_file_indexed(self):
        write_zarr(self.source, self.samples)
        reader = simple.InPlaceVolumeReader(FileName=self.source)
        surface = simple.StabbingContour(Input=reader, Isosurfaces=[testing.ISOVALUE])
        self.assertEqual(testing.count_cells(surface), self.expected)

    def test_changed_source_is_indexed_anew(self):
        write_zarr(self.source, self.samples)
        self.assertEqual(count_triangles(self.open(self.source)), self.expected)
        time.sleep(0.01)
        write_zarr(self.source, 2 * self.samples)
        reader = self.open(self.source)
        self.assertEqual(count_triangles(reader, 2 * testing.ISOVALUE), self.expected)

    def test_dataset_of_hdf5_is_chosen_and_its_index_goes_to_a_folder(self):
        path, folder = testing.output("run.h5"), testing.output("indices")
        write_hdf5(path, self.samples)
        reader = self.open(path)
        self.assertEqual(list(reader.GetProperty("Dataset").GetAvailable()),
                         ["automatic", "/run/half", "/run/whole"])
        reader.Dataset = "/run/half"
        reader.IndexFolder = folder
        self.assertEqual(count_triangles(reader, testing.ISOVALUE / 2), self.expected)
        reader.Dataset = "/run/whole"
        self.assertEqual(count_triangles(reader), self.expected)
        self.assertEqual(sorted(name for name in os.listdir(folder) if name.endswith(".bvol")),
                         ["run.h5-run-half.bvol", "run.h5-run-whole.bvol"])

    def test_other_volume_at_the_place_of_the_index_is_kept(self):
        write_zarr(self.source, self.samples)
        shutil.copy(testing.volume("wave.bvol"), self.index)
        shutil.copytree(testing.volume("wave.bvol.stores"), self.index + ".stores")
        reader = self.open(self.source)
        self.assertEqual(testing.count_cells(reader), 0)
        reader.UpdatePropertyInformation()
        self.assertIn("is no index of", reader.Index)
        self.assertTrue(filecmp.cmp(self.index, testing.volume("wave.bvol"), shallow=False))

    def test_state_file_opens_the_indexed_source(self):
        write_zarr(self.source, self.samples)
        self.assertEqual(count_triangles(self.open(self.source)), self.expected)
        state = testing.output("in_place.pvsm")
        simple.SaveState(state)
        simple.ResetSession()
        simple.LoadState(state)
        surface = next(proxy for key, proxy in simple.GetSources().items() if key[0].startswith("StabbingContour"))
        self.assertEqual(testing.count_cells(surface), self.expected)


testing.run()
