# SPDX-License-Identifier: BSD-3-Clause
"""The first hour with the window, by mouse and keyboard (hand.py). In plain Python:

    first_hour.py --paraview PATH --version NUMBER --pvbatch PATH --pvserver PATH --mpiexec "mpiexec -n"
        --plugin PATH --volumes FOLDER --output FOLDER TEST...

What ParaView's player of tests calls, it does not see: what a dialog lists, whether a button is enabled.
"""
import argparse
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import unittest

import numpy

import hand

arguments = None
LISTED_BY_STOCK = ["surface.vtp", "image.vti", "table.csv"]
# A name of each of our formats.
LISTED_BY_US = [
    "volume.bvol", "surface.eix", "a.mhd", "a.mha", "a.nrrd", "a.nhdr", "a.nii", "a.nii.gz", "a.mrc", "a.map", "a.rec",
    "a.tif", "a.tiff", "A.TIF", "a.dcm", "A.DCM", "a.ima", "a.h5", "a.hdf5", "a.vtkhdf", "a.nxs", "a.ims", "a.nc",
    "a.raw", "a.raw.gz", "zarr.json",
]
MADE = re.compile("Isosurface|VolumeSlice|Ruler")
LISTED_BY_NOBODY = ["IM0001", "7", "s", "notes.xyzw"]


def make_samples(size=48):
    """A ball in a box: 0 far away, 1200 in the middle, 300 (bone) at three quarters of the way."""
    at = numpy.indices((size,) * 3) - (size - 1) / 2
    return (1200 - 1200 * numpy.sqrt((at**2).sum(axis=0)) / (size / 2)).clip(0).astype("<i2")


def write_dicom(folder, samples, series=1, description="Thorax 1.0"):
    """A slice a file, without extensions, as on a CD."""
    from pydicom.dataset import Dataset, FileDataset, FileMetaDataset

    os.makedirs(folder, exist_ok=True)
    for number, pixels in enumerate(samples):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
        meta.MediaStorageSOPInstanceUID = "1.2.%d.%d" % (series, number + 1)
        meta.TransferSyntaxUID = "1.2.840.10008.1.2.1"
        file = FileDataset("", Dataset(), file_meta=meta, preamble=bytes(128))
        file.is_little_endian, file.is_implicit_VR = True, False
        file.SOPClassUID = meta.MediaStorageSOPClassUID
        file.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
        file.SeriesInstanceUID = "1.2.826.0.1.3680043.8.498.%d" % series
        file.SeriesDescription, file.Modality = description, "CT"
        file.ImagePositionPatient, file.ImageOrientationPatient = [0, 0, number], [1, 0, 0, 0, 1, 0]
        file.PixelSpacing = [1, 1]
        file.Rows, file.Columns = pixels.shape
        file.SamplesPerPixel, file.PixelRepresentation = 1, 1
        file.PhotometricInterpretation = "MONOCHROME2"
        file.BitsAllocated = file.BitsStored = 16
        file.HighBit = 15
        file.PixelData = pixels.tobytes()
        file["PixelData"].VR = "OW"
        file.save_as("%s/IM%d%04d" % (folder, series, number), write_like_original=False)


def write_tiff_stack(folder, samples):
    """Unsigned 16-bit slices that say nothing about their distances."""
    os.makedirs(folder)
    for number, pixels in enumerate(samples.astype("<u2")):
        rows, columns = pixels.shape
        entries = [(256, columns), (257, rows), (258, 16), (259, 1), (262, 1), (273, 8), (277, 1), (278, rows),
                   (279, pixels.nbytes)]
        with open("%s/slice_%04d.tif" % (folder, number), "wb") as file:
            file.write(struct.pack("<2sHI", b"II", 42, 8 + pixels.nbytes) + pixels.tobytes())
            file.write(struct.pack("<H", len(entries)))
            for tag, value in entries:
                file.write(struct.pack("<HHII", tag, 4, 1, value))
            file.write(struct.pack("<I", 0))


def write_n5(folder, samples):
    """One block without compression."""
    os.makedirs(folder + "/0/0")
    size = list(samples.shape[::-1])
    with open(folder + "/attributes.json", "w") as file:
        json.dump({"n5": "2.0.0", "dimensions": size, "blockSize": size, "dataType": "int16",
                   "compression": {"type": "raw"}}, file)
    with open(folder + "/0/0/0", "wb") as file:
        file.write(struct.pack(">HHIII", 0, 3, *size) + samples.astype(">i2").tobytes())


class FirstHour(unittest.TestCase):
    def setUp(self):
        self.folder = os.path.join(arguments.output, self.id().split(".")[-1])
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        self.display = hand.Display()
        self.addCleanup(self.display.end)

    def path(self, name):
        return os.path.join(self.folder, name)

    def open_window(self, plugin=True, port=None):
        window = hand.Window(self.display, arguments.paraview, arguments.version, self.path("home"),
                             arguments.plugin if plugin else None, port)
        self.addCleanup(window.end)
        return window

    def list_files(self, folder, plugin):
        """What File > Open lists of a folder under its default type."""
        window = self.open_window(plugin=plugin)
        window.choose("File", "Open...")
        window.enter("Open File", folder)
        names = [row["inner"] or row["texts"][:1]
                 for row in window.wait("rows('Files')", lambda rows: rows and rows[0]["texts"][0] == "folder")]
        window.save_screen(self.path("listed%d.png" % plugin))
        return window, sorted(sum(names, []))

    def contour(self, window):
        self.check_width(window)
        window.apply()
        # More than the lines of a box.
        window.wait("remember_view()", lambda share: share > 0.1)
        window.wait("is_shown('PointArrayStatus')")
        window.choose("Filters", "Scalable Isosurface", "Isosurface")
        self.check_width(window)
        window.apply()
        window.see()

    def check_width(self, window):
        """A panel before Apply, which has our widgets alone, does not scroll sideways. (Behind it, ParaView's own
        editor of colors is wider than the dock, for whatever source.)"""
        window.wait("find('Accept')", lambda found: found and found[0]["enabled"])
        bars = window.look("find('', 'QScrollBar')")
        self.assertTrue(bars)
        self.assertEqual([bar for bar in bars if bar["size"][0] > bar["size"][1]], [])

    def measure(self, window):
        """A ruler in the view."""
        before = window.look("count_cells()")
        window.choose("Sources", "Alphabetical", "Ruler")
        window.apply()
        window.wait("len(count_cells()) > %d" % len(before))
        window.see()

    def check_state(self, window):
        """What is on screen is the same after it is saved and loaded, and in pvbatch."""
        self.check_no_messages(window)
        window.save_screen(self.path("before.png"))
        state = self.path("what.pvsm")
        # A reader's are those that were asked for last.
        cells = [item for item in window.look("count_cells()").items() if MADE.match(item[0])]
        window.choose("File", "Save State...")
        window.answer("Save State", state)
        window.choose("Edit", "Reset Session")
        if window.wait("dialog() or count_cells() == {}") is not True:  # it asks whether to
            window.wait("dialog() not in ('', '-')")
            window.key("Return")
        window.wait("count_cells() == {}")
        window.choose("File", "Load State...")
        window.enter("Load State", state)
        window.wait("dialog().startswith('Load State Options')")
        window.key("Return")
        window.wait("compare_view()", lambda share: share < 0.02)
        window.save_screen(self.path("after.png"))
        self.check_no_messages(window)
        window.wait("count_cells()", lambda now: all(item in now.items() for item in cells))
        said = subprocess.run(
            [arguments.pvbatch, os.path.join(hand.HERE, "show_state.py"), arguments.plugin, state],
            env=self.display.environment, timeout=hand.STEP_SECONDS, check=True, text=True, stdout=subprocess.PIPE)
        self.assertIn("Isosurface1", dict(cells))
        for item in cells:
            self.assertIn(repr(item), said.stdout)

    def check_no_messages(self, window):
        """The window of ParaView's errors and warnings opens with the first of them."""
        self.assertEqual(window.look("find('', 'pqOutputWidget')"), [])

    def test_dialog_lists_what_stock_lists_and_ours(self):
        os.makedirs(self.path("data/folder"))
        os.makedirs(self.path("data/.volume.bvol.stores"))
        for name in LISTED_BY_STOCK + LISTED_BY_US + LISTED_BY_NOBODY:
            open(self.path("data/" + name), "w").close()
        window, stock = self.list_files(self.path("data"), plugin=False)
        window.end()
        self.assertLess(set(LISTED_BY_STOCK), set(stock))
        window, ours = self.list_files(self.path("data"), plugin=True)
        self.assertEqual(ours, sorted(set(stock) | set(LISTED_BY_US)))
        self.assertFalse(set(LISTED_BY_NOBODY) & set(ours))
        # A file that no type lists, under All Files.
        write_dicom(self.path("ct"), make_samples(8))
        window.press("EntityType", "QComboBox")
        window.key("Down", "Return")
        window.wait("any('IM0001' in row['texts'] + row['inner'] for row in rows('Files') or [])")
        window.press("EntityName", "QLineEdit")
        window.enter("Open File", self.path("ct/IM10001"))
        window.wait("dialog().startswith('Open Data')")
        window.save_screen(self.path("proposed.png"))
        self.assertEqual(window.look("[row['texts'] for row in rows('listWidget') if row['selected']]"),
                         [["Volume Reader (Any Size)"]])

    def test_a_folder_of_dicom_is_opened_by_clicking(self):
        write_dicom(self.path("cd/ct"), make_samples())
        window = self.open_window()
        window.choose("File", "Open Volume Folder")
        window.enter("Open Volume Folder", self.path("cd"))
        window.pick("Files", "ct")
        window.press("OK")
        window.wait("dialog() == ''")
        self.check_width(window)
        self.assertFalse(window.look("is_shown('PointArrayStatus')"))  # before Apply there is none
        self.contour(window)
        self.measure(window)
        window.select("ct")
        window.choose("Filters", "Scalable Isosurface", "Volume Slice")
        window.apply()
        window.see()
        self.check_state(window)

    def test_folders_are_dropped_and_chosen(self):
        write_dicom(self.path("ct"), make_samples(8))
        write_tiff_stack(self.path("stack"), make_samples(8))
        write_n5(self.path("a.n5"), make_samples(8))
        shutil.copytree(os.path.join(arguments.volumes, "large.zarr"), self.path("a.zarr"))
        folders = ["ct", "stack", "a.n5", "a.zarr"]
        window = self.open_window()
        for count, folder in enumerate(folders):
            window.drop(self.path(folder), "len(count_cells()) > %d" % count)
        for folder in ["a.n5", "a.zarr"]:
            shutil.copytree(self.path(folder), self.path("chosen/" + folder[2:]))
            self.open_folder(window, self.path("chosen/" + folder[2:]))
        window.apply()
        cells = window.wait("count_cells()", lambda cells: all(cells.values()))
        # Of large.zarr, a sample may be shown.
        self.assertEqual([cells[name] for name in ("ct", "stack", "a.n5", "n5")], [7**3] * 4)
        self.check_no_messages(window)

    def open_folder(self, window, folder):
        """Typing a folder enters it; without a name, OK takes the folder that is shown."""
        before = window.look("count_cells()")
        window.choose("File", "Open Volume Folder")
        window.enter("Open Volume Folder", folder)
        last = max(os.listdir(folder))
        window.wait("rows('Files')", lambda rows: rows and any(last in str(row) for row in rows))
        window.press("OK")
        window.wait("len(count_cells()) > %d" % len(before))

    def test_a_stack_of_tiff_is_printed(self):
        write_tiff_stack(self.path("stack"), make_samples())
        window = self.open_window()
        self.open_folder(window, self.path("stack"))
        self.contour(window)
        window.choose("File", "Save Data...")
        window.answer("Save File", self.path("ball.stl"))
        window.wait("dialog().startswith('Configure')")
        window.key("Return")
        window.wait("dialog() == ''")
        with open(self.path("ball.stl"), "rb") as file:
            self.assertIn(struct.unpack("<80xI", file.read(84))[0], window.look("count_cells()").values())
        self.check_state(window)

    def test_a_series_is_on_a_server_of_two_ranks(self):
        port, server = self.start_server()
        window = self.open_window(port=port)
        window.choose("File", "Connect...")
        window.wait("dialog().startswith('Choose Server')")
        window.pick("servers", "two ranks")
        window.press("connect")
        window.wait("dialog() == '' and is_remote()")
        self.open_folder(window, os.path.join(arguments.volumes, "large.zarr"))
        window.apply()
        window.choose("File", "Open...")
        window.enter("Open File", arguments.volumes)
        window.pick("Files", "series.bvol")
        window.press("OK")
        window.wait("dialog() == ''")
        self.contour(window)
        self.measure(window)
        self.check_state(window)
        window.end()
        server.wait(timeout=hand.STEP_SECONDS)

    def start_server(self):
        with open(self.path("server.log"), "w") as log:
            server = hand.start(
                [*arguments.mpiexec.split(), "2", arguments.pvserver, "--server-port=0"],
                env={**self.display.environment, "PV_PLUGIN_PATH": os.path.dirname(arguments.plugin)},
                stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(hand.end, server)

        def find_port():
            with open(self.path("server.log"), errors="replace") as log:
                return re.search(r"Accepting connection.*:(\d+)$", log.read(), re.MULTILINE)
        return int(hand.wait_for("the server's port", find_port)[1]), server

    def test_what_plain_python_saves_is_opened(self):
        subprocess.run(
            [sys.executable, "-c",
             "import sys, numpy, scalable_isosurface as si\n"
             "volume = si.create(numpy.load(sys.argv[1]), sys.argv[2], name='ball')\n",
             self.save_samples(), self.path("ball.bvol")], check=True)
        window = self.open_window()
        window.choose("File", "Open...")
        window.answer("Open File", self.path("ball.bvol"))
        self.contour(window)
        self.measure(window)
        self.check_state(window)

    def save_samples(self):
        numpy.save(self.path("ball.npy"), make_samples())
        return self.path("ball.npy")


def run():
    global arguments
    parser = argparse.ArgumentParser()
    for name in ("paraview", "version", "pvbatch", "pvserver", "mpiexec", "plugin", "volumes", "output"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("tests", nargs="*")
    arguments = parser.parse_args()
    arguments.output = os.path.abspath(arguments.output)
    unittest.main(argv=[sys.argv[0]] + ["FirstHour." + test for test in arguments.tests], verbosity=2)


run()
