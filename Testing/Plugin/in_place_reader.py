# SPDX-License-Identifier: BSD-3-Clause
"""Files of volumes are opened by the reader that indexes them in place: --python PATH (with h5py and others)

The oracle is vtkFlyingEdges3D on the samples that were written.
"""
import filecmp
import os
import shutil
import subprocess
import time

import numpy
from paraview import simple, smstate
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkIOImage import vtkTIFFWriter
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


def write_with_python(program, path, samples):
    """Runs a program in the other Python: it has the samples, and the path."""
    numpy.save(path + ".npy", samples)
    subprocess.run(
        [testing.arguments.python, "-c",
         "import numpy, sys; path = sys.argv[1]; samples = numpy.load(path + '.npy')\n" + program, path],
        check=True, env=testing.make_mpi_environment())


def write_hdf5(path, samples):
    write_with_python(
        "import h5py\n"
        "with h5py.File(path, 'w') as file:\n"
        "    for name, factor in (('run/half', 0.5), ('run/whole', 1)):\n"
        "        file.create_dataset(name, data=samples * factor, chunks=(11, 13, 17), compression='gzip')\n",
        path, samples)


def write_nifti(path, samples):
    write_with_python("import nibabel\n"
                      "nibabel.save(nibabel.Nifti1Image(samples.transpose(), numpy.eye(4)), path)\n",
                      path, samples)


def write_mrc(path, samples):
    write_with_python("import mrcfile\nmrcfile.write(path, samples)\n", path, samples)


def write_netcdf(path, samples):
    write_with_python(
        "import netCDF4\n"
        "with netCDF4.Dataset(path, 'w') as file:\n"
        "    for name, size in zip('zyx', samples.shape):\n"
        "        file.createDimension(name, size)\n"
        "    file.createVariable('density', 'f4', ('z', 'y', 'x'), zlib=True)[:] = samples\n",
        path, samples)


def write_dicom(folder, samples, added="Modality = 'CT'"):
    """A slice a file, without extensions."""
    os.makedirs(folder)
    write_with_python(
        "from pydicom.dataset import Dataset, FileDataset, FileMetaDataset\n"
        "for number, pixels in enumerate(samples.astype('<i2')):\n"
        "    meta = FileMetaDataset()\n"
        "    meta.MediaStorageSOPClassUID = '1.2.840.10008.5.1.4.1.1.2'\n"
        "    meta.MediaStorageSOPInstanceUID = f'1.2.{number + 1}'\n"
        "    meta.TransferSyntaxUID = '1.2.840.10008.1.2.1'\n"
        "    file = FileDataset('', Dataset(), file_meta=meta, preamble=bytes(128))\n"
        "    file.is_little_endian, file.is_implicit_VR = True, False\n"
        "    file.SOPClassUID = meta.MediaStorageSOPClassUID\n"
        "    file.SOPInstanceUID = meta.MediaStorageSOPInstanceUID\n"
        "    file.SeriesInstanceUID = '1.2'\n"
        f"    file.{added}\n"
        "    file.ImagePositionPatient = [0, 0, number]\n"
        "    file.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]\n"
        "    file.PixelSpacing = [1, 1]\n"
        "    file.Rows, file.Columns = pixels.shape\n"
        "    file.SamplesPerPixel = file.PixelRepresentation = 1\n"
        "    file.PhotometricInterpretation = 'MONOCHROME2'\n"
        "    file.BitsAllocated = file.BitsStored = 16\n"
        "    file.HighBit = 15\n"
        "    file.PixelData = pixels.tobytes()\n"
        "    file['PixelData'].VR = 'OW'\n"
        "    file.save_as(f'{path}/IM{number:04}', write_like_original=False)\n",
        folder, samples)


def write_header(path, text, samples):
    with open(path, "wb") as file:
        file.write(text.encode() + samples.tobytes())


def write_metaimage(path, samples):
    write_header(path, "ObjectType = Image\nNDims = 3\nDimSize = %d %d %d\nElementType = MET_FLOAT\n"
                 "ElementDataFile = LOCAL\n" % samples.shape[::-1], samples)


def write_nrrd(path, samples):
    write_header(path, "NRRD0004\ntype: float\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n"
                 "endian: little\n\n" % samples.shape[::-1], samples)


def write_tiff(path, samples):
    """A page a slice, compressed."""
    image = vtkImageData()
    image.SetDimensions(samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel(), deep=True))
    writer = vtkTIFFWriter()
    writer.SetInputData(image)
    writer.SetFileName(path)
    writer.SetCompressionToPackBits()
    writer.Write()


# Of formats that ParaView's readers load as a whole, or not at all.
WRITERS = {"scan.mha": write_metaimage, "scan.nrrd": write_nrrd, "scan.nii": write_nifti, "scan.nii.gz": write_nifti,
           "scan.mrc": write_mrc, "scan.nc": write_netcdf, "scan.tif": write_tiff}


def list_stores(index):
    return sorted(os.listdir(testing.get_stores(index)))


def count_triangles(reader, isovalue=testing.ISOVALUE):
    reader.UpdatePipeline()
    names = [reader.PointData.GetArray(n).Name for n in range(reader.PointData.GetNumberOfArrays())]
    array = next(name for name in names if name != "vtkGhostType")
    return testing.count_cells(testing.contour(reader, isovalue, array))


def list_readers(path):
    """The readers among which the window lets choose."""
    manager = simple.servermanager
    factory = manager.vtkSMProxyManager.GetProxyManager().GetReaderFactory()
    factory.UpdateAvailableReaders()
    readers = factory.GetReaders(path, manager.ActiveConnection.Session)
    return [readers.GetString(at + 1) for at in range(0, readers.GetLength(), 3)]


class InPlaceReader(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.samples = read_samples()
        cls.expected = testing.count_expected_triangles()

    def setUp(self):
        of_one = ("every_format", "left_to_other_readers", "states")
        if testing.arguments.ranks > 1 and any(name in self.id() for name in of_one):
            self.skipTest("a format is opened on one rank as on several")
        simple.ResetSession()
        self.source = testing.output(self.id().split(".")[-1] + ".zarr")
        self.index = self.source + ".bvol"

    def open(self, path, **properties):
        reader = simple.OpenDataFile(path, **properties)
        self.assertEqual(reader.GetXMLName(), "AnySizeVolumeReader")
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
        surface = simple.Isosurface(Input=reader, Isosurfaces=[testing.ISOVALUE])
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

    def write_steps(self, path):
        """RTData + 10 t at the times 0, 1, 2."""
        write_with_python("import h5py\n"
                          "with h5py.File(path, 'w') as file:\n"
                          "    file['steps'] = numpy.stack([samples + 10 * t for t in range(3)])\n",
                          path, self.samples)

    def test_times_of_a_file_are_known_and_each_request_gets_its_step_before_there_is_an_index(self):
        path = testing.output("steps.h5")
        self.write_steps(path)
        reader = simple.OpenDataFile(path)
        reader.UpdatePipelineInformation()
        self.assertEqual(list(reader.TimestepValues), [0.0, 1.0, 2.0])
        self.assertFalse(os.path.exists(path + ".bvol"))
        surface = simple.StabbingContour(Input=reader, Isosurfaces=[testing.ISOVALUE])
        view = testing.make_view()
        simple.Show(surface, view)
        scene = simple.GetAnimationScene()
        scene.UpdateAnimationUsingDataTimeSteps()
        for time_step in (2.0, 0.0, 1.0):
            scene.AnimationTime = time_step
            simple.Render(view)
            self.assertEqual(surface.GetDataInformation().GetNumberOfCells(),
                             testing.count_expected_triangles(testing.ISOVALUE - 10 * time_step))
        simple.Delete(view)

    def test_all_time_steps_of_a_file_without_an_index_are_saved(self):
        path, saved = testing.output("unindexed.h5"), testing.output("steps.bvol")
        self.write_steps(path)
        simple.SaveData(saved, proxy=simple.OpenDataFile(path), WriteAllTimeSteps=1)
        surface = simple.StabbingContour(Input=simple.OpenDataFile(saved), Isosurfaces=[testing.ISOVALUE])
        for time_step in range(3):
            surface.UpdatePipeline(time_step)
            self.assertEqual(surface.GetDataInformation().GetNumberOfCells(),
                             testing.count_expected_triangles(testing.ISOVALUE - 10 * time_step))

    def test_a_file_that_is_broken_removed_and_mended_is_what_reload_gives(self):
        path = testing.output("reloaded.mha")
        write_metaimage(path, self.samples)
        reader = self.open(path)
        surface = simple.StabbingContour(Input=reader, Isosurfaces=[testing.ISOVALUE])
        behind = simple.Calculator(Input=surface, Function="1")
        for damage in (lambda: os.truncate(path, 1000), lambda: os.remove(path)):
            self.assertEqual(testing.count_cells(behind), self.expected)
            damage()
            simple.ReloadFiles(reader)
            for isovalue in (testing.ISOVALUE, testing.OTHER_ISOVALUE, testing.ISOVALUE):
                surface.Isosurfaces = [isovalue]
                self.assertEqual([testing.count_cells(proxy) for proxy in (behind, surface)], [0, 0])
            write_metaimage(path, self.samples)
            simple.ReloadFiles(reader)

    def write_all(self):
        """A file of each format; their paths."""
        paths = []
        for name, write in WRITERS.items():
            written = testing.output(name)
            if not os.path.exists(written):
                write(written, self.samples)
            paths.append(testing.output(self.id().split(".")[-1] + "_" + name))
            shutil.copy(written, paths[-1])
        return paths

    def test_every_format_is_opened_and_indexed(self):
        for path in self.write_all():
            with self.subTest(path=path):
                self.assertEqual(list_readers(path).count("AnySizeVolumeReader"), 1)
                self.assertNotIn("InPlaceVolumeReader", list_readers(path))
                self.assertEqual(count_triangles(self.open(path)), self.expected)
                self.assertTrue(os.path.exists(path + ".bvol"))

    def test_folder_and_slice_of_dicom_are_the_series(self):
        folder = testing.output("series")
        write_dicom(folder, self.samples)
        expected = testing.count_expected_triangles(150.5, "floor(RTData)")
        for path in (folder, folder + "/IM0003"):
            with self.subTest(path=path):
                self.assertEqual(count_triangles(self.open(path), 150.5), expected)
                index = path + ".index.bvol"
                indexed, copied = simple.OpenDataFile(index), testing.output("copy.bvol")
                simple.SaveData(copied, proxy=indexed)
                for volume in (indexed, simple.OpenDataFile(copied)):
                    contour = simple.Isosurface(Input=volume)
                    contour.UpdatePipeline()
                    contour.UpdatePropertyInformation()
                    self.assertEqual(contour.Unit, "HU")

    def test_a_window_of_dicom_is_shown_and_units_are_told(self):
        window = "WindowCenter, file.WindowWidth, file.Modality = [50, 300], [350, 1500], "
        usual = [-160, 240]
        for number, (added, shown, title) in enumerate((
                ("Modality = 'CT'", usual, "DICOM (HU)"), (window + "'CT'", [-125, 225], "DICOM (HU)"),
                (window + "'MR'", [-125, 225], "DICOM"), ("WindowCenter, file.Modality = 50, 'CT'", usual, "DICOM (HU)"))):
            with self.subTest(added=added):
                write_dicom(testing.output(f"ct{number}"), self.samples, added)
                reader = self.open(testing.output(f"ct{number}"))
                view = testing.make_view()
                ruler = simple.Show(simple.Ruler(), view)
                for source in (reader, simple.VolumeSlice(Input=reader)):
                    display = simple.Show(source, view)
                    display.SetScalarBarVisibility(view, True)
                    simple.Render(view)
                    colors = display.LookupTable
                    self.assertEqual(list(colors.RGBPoints), [shown[0], 0, 0, 0, shown[1], 1, 1, 1])
                    self.assertEqual(simple.GetScalarBar(colors, view).Title, title)
                    colors.RGBPoints, colors.AutomaticRescaleRangeMode = [0, 1, 0, 0, 1, 0, 1, 0], 0  # as nobody's
                self.assertRegex(ruler.LabelFormat, "[^ ] mm$")
                self.assertEqual(view.AxesGrid.YTitle, "Y Axis (mm)")
                simple.Hide(reader, view)
                simple.Hide(source, view)
                simple.Show(simple.OpenDataFile(testing.volume("wave.bvol")), view)
                simple.Render(view)
                self.assertRegex(ruler.LabelFormat, "g}?$")
                self.assertEqual(view.AxesGrid.YTitle, "Y Axis")

    def test_raw_samples_are_described_by_the_name_or_the_property(self):
        size = "x".join(map(str, self.samples.shape[::-1]))
        named, other = testing.output(f"scan_{size}_float32.raw"), testing.output("scan.raw")
        self.samples.tofile(named)
        self.assertEqual(count_triangles(self.open(named)), self.expected)
        write_header(other, "header", self.samples.astype(">f4"))
        self.assertNotIn("AnySizeVolumeReader", list_readers(other))
        reader = simple.VolumeReaderAnySize(FileName=other)
        reader.UpdatePipelineInformation()
        self.assertEqual(reader.SMProxy.GetProperty("IsRaw").GetElement(0), 1)
        reader.RawSamples = size + ",float32,big-endian,header-bytes=6"
        self.assertEqual(count_triangles(reader), self.expected)

    def test_a_grid_that_is_set_holds_and_is_saved_and_an_empty_one_is_that_of_the_file(self):
        image = vtkImageData()
        image.SetDimensions(self.samples.shape[::-1])
        image.SetSpacing(0.5, 0.75, 2)
        image.SetOrigin(-3, 5, 1e3)
        image.GetPointData().SetScalars(numpy_to_vtk(self.samples.ravel(), deep=True))
        contour = vtkFlyingEdges3D()
        contour.SetInputData(image)
        contour.SetValue(0, testing.ISOVALUE)
        contour.Update()
        expected = contour.GetOutput().GetBounds()
        size = "x".join(map(str, self.samples.shape[::-1]))
        page, raw = testing.output("placed.tif"), testing.output(f"placed_{size}_float32.raw")
        write_tiff(page, self.samples)
        self.samples.tofile(raw)
        for path in (page, raw):
            with self.subTest(path=path):
                simple.ResetSession()
                reader = self.open(path)
                found = lambda name: list(reader.GetProperty(name).GetData())
                reader.UpdatePropertyInformation()
                self.assertEqual([found("SpacingInfo"), found("OriginInfo")], [[1, 1, 1], [0, 0, 0]])
                reader.Spacing, reader.Origin, reader.LengthUnit = [0.5, 0.75, 2], [-3, 5, 1e3], "um"
                surface = simple.Isosurface(Input=reader, Isosurfaces=[testing.ISOVALUE])
                self.assertEqual(testing.count_cells(surface), self.expected)
                self.assertEqual(surface.GetDataInformation().GetBounds(), expected)
                self.assertIsNotNone(surface.FieldData.GetArray("PhysicalSizeUnit"))
                state = testing.output("placed.pvsm")
                simple.SaveState(state)
                simple.ResetSession()
                self.load_state(state)
                surface = simple.FindSource("Isosurface1")
                self.assertEqual(testing.count_cells(surface), self.expected)
                self.assertEqual(surface.GetDataInformation().GetBounds(), expected)
                reader = surface.Input
                self.assertEqual(list(reader.Spacing), [0.5, 0.75, 2])
                reader.Spacing, reader.Origin, reader.LengthUnit = [], [], ""
                self.assertEqual(testing.count_cells(surface), self.expected)
                bounds = surface.GetDataInformation().GetBounds()
                for axis, (spacing, origin) in enumerate(zip(image.GetSpacing(), image.GetOrigin())):
                    for end in (2 * axis, 2 * axis + 1):
                        self.assertAlmostEqual(origin + spacing * bounds[end], expected[end], places=3)
                reader.Spacing = [0, 1, 1]
                self.assertEqual(testing.count_cells(surface), 0)

    def test_damaged_files_are_opened_and_give_no_surface(self):
        for name in ("truncated.nii", "truncated.nii.gz"):
            path = testing.output(name)
            write_nifti(path, self.samples)
            os.truncate(path, os.path.getsize(path) // 2)
            with self.subTest(path=path):
                self.assertEqual(testing.count_cells(self.open(path)), 0)
                self.assertFalse(os.path.exists(path + ".bvol"))

    def test_files_without_a_volume_are_left_to_other_readers(self):
        names = ["table.h5", "page.tif", "scan.map", "volume.vti"]
        table, page, other, image = (testing.output(name) for name in names)
        write_with_python("import h5py\n"
                          "with h5py.File(path, 'w') as file:\n"
                          "    file['table'] = samples[0]\n", table, self.samples)
        write_tiff(page, self.samples[:1])
        write_header(other, "no MRC file", self.samples)
        shutil.copy(testing.volume("wave.vti"), image)
        for path in (table, page, other, image, testing.arguments.volumes):
            with self.subTest(path=path):
                self.assertNotIn("AnySizeVolumeReader", list_readers(path))

    def test_other_volume_at_the_place_of_the_index_is_kept(self):
        write_zarr(self.source, self.samples)
        shutil.copy(testing.volume("wave.bvol"), self.index)
        shutil.copytree(testing.get_stores(testing.volume("wave.bvol")), testing.get_stores(self.index))
        reader = self.open(self.source)
        self.assertEqual(testing.count_cells(reader), 0)
        reader.UpdatePropertyInformation()
        self.assertIn("is no index of", reader.Index)
        self.assertTrue(filecmp.cmp(self.index, testing.volume("wave.bvol"), shallow=False))

    def check_surfaces(self, count):
        surfaces = [proxy for key, proxy in simple.GetSources().items() if key[0].startswith("Isosurface")]
        self.assertEqual([testing.count_cells(surface) for surface in surfaces], [self.expected] * count)

    def test_states_open_every_format_again(self):
        paths = self.write_all()
        for path in paths:
            self.assertEqual(count_triangles(self.open(path)), self.expected)
        state = testing.output("in_place.pvsm")
        simple.SaveState(state)
        script = smstate.get_state()
        simple.ResetSession()
        self.load_state(state)
        self.check_surfaces(len(paths))
        simple.ResetSession()
        self.assertIn("VolumeReaderAnySize(", script)
        exec(script, {})
        self.check_surfaces(len(paths))

    def test_an_address_is_the_volume(self):
        write_zarr(self.source, self.samples)
        folder, name = os.path.split(self.source)
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Python", "address_server.py")
        server = subprocess.Popen([testing.arguments.python, script, folder], stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE, text=True, env=testing.make_mpi_environment())
        self.addCleanup(server.communicate)  # which ends it
        address = f"{server.stdout.readline().strip()}/{name}"
        reader = simple.VolumefromanAddress(Address=address, IndexFolder=self.source + ".index")
        self.assertEqual(count_triangles(reader), self.expected)
        self.assertTrue(os.path.exists(f"{self.source}.index/{name}.bvol"))
        script = smstate.get_state()
        simple.ResetSession()
        self.assertIn("VolumefromanAddress(", script)
        exec(script, {})
        self.check_surfaces(1)

    def test_states_and_scripts_of_before_open_the_source(self):
        write_zarr(self.source, self.samples)
        count_triangles(simple.InPlaceVolumeReader(FileName=self.source))
        state = testing.output("before.pvsm")
        simple.SaveState(state)
        with open(state) as file:
            self.assertIn('type="InPlaceVolumeReader"', file.read())
        simple.ResetSession()
        self.load_state(state)
        self.check_surfaces(1)


testing.run()
