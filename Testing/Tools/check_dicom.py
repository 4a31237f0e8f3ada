#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Series of pydicom, read by blockvolume: check_dicom.py TOOL MPIEXEC SCRATCH CLAIM"""
import json
import os
import re
import shutil
import sys

import numpy
from pydicom import dcmread
from pydicom.data import get_testdata_file
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.uid import DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, \
    ExplicitVRLittleEndian, ImplicitVRLittleEndian, RLELossless

from sample_volumes import SourceCase, make_samples, remove_volume, run_claim

SHAPE = (9, 37, 70)


class Files(SourceCase):
    def save(self, folder, samples, series="1.2.3", syntax=ExplicitVRLittleEndian, origin=(0, 0, 0),
             spacing=(1, 1, 1), row=(1, 0, 0), column=(0, 1, 0), step=None, slope=1, intercept=0,
             bits=None, modality="MR", scaled_to=None, write=float):
        """A file a slice, with names in an order that is not that of the places."""
        os.makedirs(self.path(folder), exist_ok=True)
        step = numpy.cross(row, column) if step is None else numpy.asarray(step)
        for number, slice_samples in enumerate(samples):
            meta = FileMetaDataset()
            meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
            meta.MediaStorageSOPInstanceUID = f"{series}.{number + 1}"
            meta.TransferSyntaxUID = syntax
            name = self.path(f"{folder}/{series}-{(7 * number) % len(samples)}")
            file = FileDataset(name, Dataset(), file_meta=meta, preamble=b"\0" * 128,
                               is_little_endian=syntax != ExplicitVRBigEndian,
                               is_implicit_VR=syntax == ImplicitVRLittleEndian)
            file.SOPClassUID = meta.MediaStorageSOPClassUID
            file.SOPInstanceUID = meta.MediaStorageSOPInstanceUID
            file.SeriesInstanceUID = series
            file.SeriesDescription = "head " + series
            file.Modality = modality
            if scaled_to is not None:
                file.RescaleType = scaled_to
            file.ImagePositionPatient = [write(value) for value in
                                         numpy.array(origin) + number * spacing[2] * step]
            file.ImageOrientationPatient = [*map(float, row), *map(float, column)]
            file.PixelSpacing = [spacing[1], spacing[0]]
            file.Rows, file.Columns = slice_samples.shape
            file.SamplesPerPixel = 1
            file.PhotometricInterpretation = "MONOCHROME2"
            file.BitsAllocated = 8 * samples.dtype.itemsize
            file.BitsStored = bits or file.BitsAllocated
            file.HighBit = file.BitsStored - 1
            file.PixelRepresentation = int(samples.dtype.kind == "i")
            file.RescaleSlope, file.RescaleIntercept = slope, intercept
            if syntax == RLELossless:
                file.compress(RLELossless, slice_samples)
            else:
                order = ">" if syntax == ExplicitVRBigEndian else "<"
                pixels = slice_samples.astype(slice_samples.dtype.newbyteorder(order))
                file.PixelData = pixels.tobytes().ljust((pixels.nbytes + 1) // 2 * 2, b"\0")
            file["PixelData"].VR = "OB" if samples.dtype.itemsize == 1 else "OW"
            file.save_as(name, write_like_original=False)
        return name


class Series(Files):
    def test_types_and_transfer_syntaxes(self):
        cases = [("uint8", ExplicitVRLittleEndian), ("int16", ImplicitVRLittleEndian),
                 ("uint16", ExplicitVRBigEndian), ("int16", RLELossless),
                 ("int32", DeflatedExplicitVRLittleEndian)]
        for number, (dtype, syntax) in enumerate(cases):
            with self.subTest(type=dtype, syntax=syntax.name):
                samples = make_samples(dtype, SHAPE)
                self.save(f"s{number}", samples, syntax=syntax, origin=(-3, 7, 1.5),
                          spacing=(0.5, 0.25, 2))
                path = self.write(f"s{number}", "o.bvol", ranks=2 if number == 3 else 1)
                self.assert_equal_volumes(path, self.write_raw(
                    samples, "DICOM", spacing=(0.5, 0.25, 2), origin=(-3, 7, 1.5), unit="mm"))

    def test_the_same_image_in_other_transfer_syntaxes(self):
        # Images of pydicom, as series of three slices; those of the dose have 32 bits.
        for name, of_name in (("MR_small_bigendian", "MR_small"), ("MR_small_RLE", "MR_small"),
                              ("MR_small_jp2klossless", "MR_small"),
                              ("MR_small_jpeg_ls_lossless", "MR_small"),
                              ("rtdose_expb_1frame", "rtdose_1frame")):
            with self.subTest(name=name):
                plain = dcmread(get_testdata_file(of_name + ".dcm"))
                samples = numpy.stack([plain.pixel_array] * 3)
                spacing = (float(plain.PixelSpacing[1]), float(plain.PixelSpacing[0]), 2)
                file = dcmread(get_testdata_file(name + ".dcm"))
                os.makedirs(self.path(name))
                for number in range(3):
                    file.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
                    file.ImagePositionPatient = [4, -7, 1.5 + 2 * number]
                    file.save_as(self.path(f"{name}/{number}.dcm"))
                self.assert_equal_volumes(
                    self.write(name, "o.bvol"),
                    self.write_raw(samples, "DICOM", spacing=spacing, origin=(4, -7, 1.5), unit="mm"))

    def test_slope_and_intercept(self):
        samples = make_samples("uint16", SHAPE)
        for slope, intercept, bits, dtype in ((1, -1024, 12, "int16"), (1, -1024, 16, "int32"),
                                              (0.5, 0.25, 16, "float32")):
            with self.subTest(slope=slope, bits=bits):
                shutil.rmtree(self.path("r"), ignore_errors=True)
                self.save("r", samples, slope=slope, intercept=intercept, bits=bits)
                values = (samples * float(slope) + intercept).astype(dtype)
                self.assert_equal_volumes(self.write("r", "o.bvol"),
                                          self.write_raw(values, "DICOM", unit="mm"))

    def test_hounsfield_units_are_told(self):
        samples = make_samples("int16", SHAPE)
        for number, (modality, scaled_to, unit) in enumerate(
                [("CT", None, "HU"), ("CT", "US", None), ("MR", None, None), ("PT", "HU", "HU")]):
            with self.subTest(modality=modality, scaled_to=scaled_to):
                self.save(f"u{number}", samples, modality=modality, scaled_to=scaled_to)
                path = self.write(f"u{number}", f"u{number}.bvol")
                with open(path, encoding="utf-8") as file:
                    self.assertEqual(json.load(file)["arrays"][0].get("unit"), unit)

    def test_units_of_samples_and_frames_of_reference(self):
        samples = make_samples("int16", SHAPE)
        for scaled_to, modality, units, expected in (("OD", "CT", None, "OD"), ("US", "CT", None, ""),
                                                     ("", "PT", "BQML", "BQML"), ("", "MR", None, "")):
            name = self.save("u", samples, modality=modality, scaled_to=scaled_to)
            for number, path in enumerate(sorted(os.listdir(os.path.dirname(name)))):
                path = os.path.join(os.path.dirname(name), path)
                file = dcmread(path)
                file.FrameOfReferenceUID = f"1.2.{number % 2}"
                if units:
                    file.Units = units
                file.save_as(path)
            _, arrays, err = self.convert("u")
            self.assertEqual(arrays, {"DICOM": expected})
            self.assertIn("several Frames of Reference", err)

    def test_in_place(self):
        samples = make_samples("int16", SHAPE)
        last = self.save("p", samples, syntax=RLELossless)
        path = self.write("p", "o.bvol", "--in-place")
        code, _, err = self.run_tool("--verify", "--quiet", path)
        self.assertEqual((code, err), (0, ""))
        with open(last, "r+b") as file:
            file.seek(-9, os.SEEK_END)
            file.write(b"\1")
        code, _, err = self.run_tool("--verify", "--quiet", path)
        self.assertEqual(code, 1)
        self.assertIn("was changed since", err)

    def test_choice_of_series(self):
        head, other = make_samples("int16", SHAPE), make_samples("int16", SHAPE, phase=1)
        last = self.save("two", head, series="1.2.3")
        self.save("two", other, series="1.2.45")
        with open(self.path("two/notes.txt"), "w") as file:
            file.write("no image")
        self.assert_error("two", "name one of its series, as in \"two:head 1.2.3 (MR, 9 slices of 70 x 37)\", \"head")
        expected = self.write_raw(other, "DICOM", unit="mm")
        for name in ("two:1.2.45", "two:.45", "two:head 1.2.45 (MR, 9 slices of 70 x 37)"):
            self.assert_equal_volumes(self.write(name, "o.bvol"), expected)
        self.assert_equal_volumes(self.write(last, "o.bvol"), self.write_raw(head, "DICOM", unit="mm"))
        code, out, _ = self.run_tool("--list", "two")
        self.assertEqual((code, len(out.splitlines())), (0, 2))
        self.assertRegex(out, r"head 1\.2\.3 \(MR, 9 slices of 70 x 37\) +9 x 37 x 70 +int16 +series 1.2.3, transfer syntax")

    def test_series_that_read_alike_are_told_apart(self):
        samples = make_samples("int16", (3, 6, 8))
        for uid, number in (("1.2.30000001", 4), ("1.2.30000002", 5), ("1.2.30000003", 5), ("1.2.4", 4)):
            self.save("alike", samples + number, series=uid)
            for name in range(3):
                name = self.path(f"alike/{uid}-{name}")
                file = dcmread(name)
                file.SeriesNumber = number
                file.SeriesDescription = "T2*: axial/" + ("other" if uid == "1.2.4" else "head")
                file.save_as(name)
        names = [re.split("  +", line)[0] for line in self.run_tool("--list", "alike")[1].splitlines()]
        alike = "T2*_ axial/head (MR, 3 slices of 8 x 6, series "
        self.assertEqual(names, [alike + "4)", alike + "5, UID ...30000002)", alike + "5, UID ...30000003)",
                                 "T2*_ axial/other (MR, 3 slices of 8 x 6)"])
        for name, number in zip(names, (4, 5, 5, 4)):
            self.assert_equal_volumes(self.write("alike:" + name, "o.bvol"),
                                      self.write_raw(samples + number, "DICOM", unit="mm"))

    def test_a_segmentation_beside_a_series(self):
        samples = make_samples("int16", SHAPE)
        self.save("seg", samples)
        path = self.save("seg", samples[:1].astype("uint8"), series="1.2.9")
        file = dcmread(path)
        file.BitsAllocated, file.BitsStored, file.HighBit = 1, 1, 0
        file.NumberOfFrames = len(samples)
        file.PixelData = numpy.packbits(samples > 0, bitorder="little").tobytes().ljust(2 * 1456, b"\0")
        file.save_as(path)
        self.assert_equal_volumes(self.write("seg", "o.bvol"), self.write_raw(samples, "DICOM", unit="mm"))
        self.assert_error("seg:1.2.9", "seg/1.2.9-0: cannot be read: its samples have 1 bits")
        out = self.run_tool("--list", "seg")[1]
        self.assertRegex(out, r"1\.2\.9  +\? +\? +seg/1\.2\.9-0: cannot be read: its samples have 1 bits")


class PlacesAndErrors(Files):
    def test_orientation_and_tilted_gantry(self):
        samples = make_samples("int16", SHAPE)
        row, column = numpy.array((0, 0.6, 0.8)), numpy.array((1.0, 0, 0))
        self.save("o", samples, row=row, column=column, spacing=(0.5, 0.25, 2), origin=(1, 2, 3))
        self.write("o", "o.bvol")
        grid = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["grid"]
        expected = numpy.stack([row, column, numpy.cross(row, column)], axis=1)
        numpy.testing.assert_allclose(numpy.reshape(grid["direction"], (3, 3)), expected, atol=1e-9)
        self.assertEqual((grid["origin"], grid["spacing"]), ([1, 2, 3], [0.5, 0.25, 2]))
        tilted = numpy.array((0, 0.28, 0.96))
        self.save("g", samples, step=tilted, spacing=(1, 1, 2))
        err = self.run_tool("g", "o.bvol")[2]
        self.assertIn("the gantry is tilted by 16.3 degrees", err)
        grid = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["grid"]
        numpy.testing.assert_allclose(grid["direction"], (1, 0, 0, 0, 1, 0.28, 0, 0, 0.96),
                                      atol=1e-9)

    def test_distances_are_those_of_the_headers_without_rounding_errors(self):
        samples = make_samples("int16", SHAPE)
        for number, distance in enumerate((0.7, 0.625, 1.1, 1 / 3)):
            folder = f"d{number}"
            self.save(folder, samples, spacing=(0.5, 0.25, distance), origin=(0, 0, -113.7))
            self.write(folder, "o.bvol")
            grid = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["grid"]
            if number < 3:
                self.assertEqual(grid["spacing"], [0.5, 0.25, distance])
            else:
                self.assertAlmostEqual(grid["spacing"][2], distance, places=12)

    def test_distances_are_as_exact_as_the_digits_of_the_headers(self):
        samples = make_samples("int16", SHAPE)
        row = (0.8, 0.6, 0)
        for number, (write, unit, distance, expected, options) in enumerate((
            (lambda v: f"{v:.1f}", 0.1, 1 / 3, 0.34, {}),  # 8 steps are 2.7
            (lambda v: f"{v:.1f}", 0.1, 1.25, 1.25, {}),
            (lambda v: f"{v:.3f}", 0.001, 0.625, 0.625, {}),
            # -113.699997, -112.999997, ...
            (lambda v: f"{numpy.float32(v):.6f}", 1.6e-5, 0.7, 0.7, {}),
            (lambda v: f"{v:.6e}", 1e-4, 0.7, 0.7, {}),
            (lambda v: f"{v:.4f}", 1e-4, 0.7, 0.7, {"column": (0, 0, 1), "row": (0.8, 0.6, 0)}),
        )):
            folder = f"e{number}"
            self.save(folder, samples, spacing=(0.5, 0.25, distance), origin=(1, 2, -113.7),
                      write=write, **options)
            self.write(folder, "o.bvol")
            grid = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["grid"]
            self.assertEqual(grid["spacing"], [0.5, 0.25, expected])
            # The last slice is where its header says, to the last digit.
            places = [numpy.array([*map(float, dcmread(self.path(f"{folder}/1.2.3-{name}"))
                                        .ImagePositionPatient)]) for name in (0, 7 * 8 % 9)]
            self.assertLessEqual(abs(numpy.linalg.norm(places[1] - places[0]) - 8 * expected), unit)
        # However they are rounded, a slice that is missing is found.
        for number, digits in enumerate((1, 2, 6)):
            folder = f"m{number}"
            self.save(folder, samples, spacing=(1, 1, 1 / 3), write=lambda v: f"{v:.{digits}f}")
            os.remove(self.path(f"{folder}/1.2.3-1"))
            self.assert_error(folder, folder + "/1.2.3-", "a slice is missing")

    def test_no_tilt_is_told_of_digits_that_lack(self):
        samples = make_samples("int16", SHAPE)[:2]
        self.save("n", samples, row=(0.8, 0.6, 0), column=(0, 0, 1), spacing=(1, 1, 1.25),
                  origin=(0.3, 0.3, 0), write=lambda v: f"{v:.1f}")
        code, _, err = self.run_tool("n", "o.bvol")
        self.assertEqual(code, 0)
        self.assertNotIn("tilted", err)

    def test_files_of_other_kinds_are_told(self):
        os.mkdir(self.path("none"))
        with open(self.path("none/a.dcm"), "wb") as file:
            file.write(bytes(range(256)))
        code, out, err = self.run_tool("--list", "none/a.dcm")
        self.assertEqual((code, out, err.count("\n")), (1, "", 1), err)
        self.assertIn("none/a.dcm: cannot be read: there are no images of DICOM", err)
        samples = make_samples("int16", SHAPE)
        path = self.save("frames", samples[:1])
        file = dcmread(path)
        file.SOPClassUID = file.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2.1"
        file.NumberOfFrames = len(samples)
        file.PerFrameFunctionalGroupsSequence = []
        for number in range(len(samples)):  # as an enhanced CT has them
            groups, place = Dataset(), Dataset()
            place.ImagePositionPatient = [0, 0, number]
            groups.PlanePositionSequence = [place]
            file.PerFrameFunctionalGroupsSequence.append(groups)
        del file.ImagePositionPatient
        file.PixelData = samples.tobytes()
        file.save_as(path)
        self.assert_error("frames", "frames/1.2.3-0", "it has 9 frames")

        path = self.save("palette", samples.astype("uint8")[:1])
        file = dcmread(path)
        file.PhotometricInterpretation = "PALETTE COLOR"
        file.save_as(path)
        self.assert_error("palette", "palette/1.2.3-0", "colours (PALETTE COLOR)")
        path = self.save("colors", samples.astype("uint8")[:1])
        file = dcmread(path)
        file.PhotometricInterpretation, file.SamplesPerPixel = "RGB", 3
        file.PlanarConfiguration = 0
        file.PixelData = numpy.repeat(samples[0].astype("uint8"), 3).tobytes()
        file.save_as(path)
        self.assert_error("colors", "colors/1.2.3-0", "colours (RGB)")

        self.save("mixed", samples)
        other = self.path("other")
        os.rename(self.path("mixed/1.2.3-1"), other)
        self.save("unsigned", samples.astype("uint16"))
        shutil.copy(self.path("unsigned/1.2.3-1"), self.path("mixed/1.2.3-1"))
        self.assert_equal_volumes(  # the type has the values of both
            self.write("mixed", "o.bvol"), self.write_raw(samples.astype("int32"), "DICOM", unit="mm"))

    def test_what_is_no_series_of_slices_is_told(self):
        samples = make_samples("int16", SHAPE)
        for key, values, reason in (
            ("p", {"PixelSpacing": [1, 1.01]}, "its Pixel Spacing differs"),
            ("o", {"ImageType": ["ORIGINAL", "PRIMARY", "M", "MOSAIC"]}, "a mosaic of slices"),
            ("l", {"ModalityLUTSequence": [Dataset()]}, "a table (Modality LUT Sequence)"),
            ("r", {"RescaleSlope": 0}, "its Rescale Slope is 0"),
            ("f", {"NumberOfFrames": "2"}, "it has 2 frames"),
            ("c", {"PhotometricInterpretation": "RGB", "SamplesPerPixel": 3}, "colours (RGB)"),
        ):
            path = self.save(key, samples)
            file = dcmread(path)
            for name, value in values.items():
                setattr(file, name, value)
            file.save_as(path)
            self.assert_error(key, key + "/1.2.3-", reason)

    def test_errors_name_file_and_reason(self):
        samples = make_samples("int16", SHAPE)
        self.save("m", samples)
        missing = self.path("m/1.2.3-1")  # slice 4: 7 * 4 % 9
        moved = self.path("kept")
        os.rename(missing, moved)
        self.assert_error("m", "m/1.2.3-", "a slice is missing", ranks=2)
        with open(moved, "rb") as file:
            whole = file.read()
        for part in (140, 300, len(whole) - samples[0].nbytes // 2, len(whole) - 1):
            with open(missing, "wb") as file:
                file.write(whole[:part])
            self.assert_error("m", "m/1.2.3-1: cannot be read", "truncated")
        self.save("w", samples[:, :20], series="1.2.3")
        shutil.copy(self.path("w/1.2.3-1"), missing)
        self.assert_error("m", "m/1.2.3-", "its size differs")


class Folders(Files):
    SHAPE = (71, 6, 8)

    def save_some(self, folder, **more):
        samples = make_samples("int16", self.SHAPE)
        self.save(folder, samples, **more)
        return samples

    def assert_read(self, name, samples, *words, unit="mm"):
        """The volume of that name has the samples, and the terminal says so much and no more."""
        expected = self.write_raw(samples, "DICOM", unit=unit)
        path = self.path("o.bvol")
        remove_volume(path)
        code, _, err = self.run_tool(name, path, "--stores", "3")
        self.assertEqual(code, 0, err)
        self.assert_equal_volumes(path, expected)
        told = [line for line in err.splitlines() if line.startswith("blockvolume:")]
        self.assertEqual(len(told), 1 if words else 0, err)
        for word in words:
            self.assertIn(word, told[0])

    def put(self, name, data):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "wb") as file:
            file.write(data)

    def test_files_that_are_no_slices_are_passed_over_and_counted(self):
        samples = self.save_some("f")
        apple = b"\0\5\x16\7\0\2\0\0Mac OS X        " + bytes(100)
        for name in os.listdir(self.path("f")):
            self.put("f/._" + name, apple)
        for name, data in ((".DS_Store", b"\0\0\0\1Bud1"), ("Thumbs.db", b"\xd0\xcf"), ("apple.dcm", apple),
                           ("notes.txt", b"8"), ("__MACOSX/a.dcm", b"no")):
            self.put("f/" + name, data)
        self.assert_read("f", samples, "f: passed over: 74 hidden (", "2 without an image of DICOM (apple.dcm, ...)")
        self.assert_read("f/1.2.3-0", samples)
        self.assert_read("f/1.2.3-*", samples)
        self.put("none/a/notes.txt", b"8")
        code, _, err = self.run_tool("none", "e.bvol")
        self.assertEqual((code, err.count("TIFF,")), (1, 1), err)  # among all kinds that are read

    def test_trees_and_files_without_preamble(self):
        samples = self.save_some("flat")
        names = sorted(os.listdir(self.path("flat")))
        for number, name in enumerate(names):
            with open(self.path("flat/" + name), "rb") as file:
                data = file.read()
            self.put(f"tree/st{number % 2}/se/{name}", data)
            self.put("bare/" + name, data[132:])
        self.put("tree/logo.jpg", b"\xff\xd8")
        shutil.copy(get_testdata_file("DICOMDIR"), self.path("tree/DICOMDIR"))
        for name in ("tree", "tree/DICOMDIR"):
            self.assert_read(name, samples, "2 without an image of DICOM (DICOMDIR, ...)")
        self.assert_read("bare", samples)
        self.assert_read("bare/" + names[3], samples)
        implicit = self.save_some("implicit", syntax=ImplicitVRLittleEndian)
        for name in names:
            path = self.path("implicit/" + name)
            dataset = dcmread(path)
            del dataset.file_meta
            dataset.preamble = None
            dataset.save_as(path)
        self.assert_read("implicit", implicit)
        self.save("tree/other", samples[:2], series="1.2.9")
        self.assert_error("tree", "name one of its series", "head 1.2.3 (MR, 71 slices", "head 1.2.9 (MR, 2 slices")
        self.assert_read("tree:1.2.3", samples, "passed over")

    def test_scouts_and_copies(self):
        samples = self.save_some("s")
        self.save("scouts", samples[:2], row=(1, 0, 0), column=(0, 0, -1))
        self.save("marked", samples[:1], origin=(0, 0, -50))
        marked = dcmread(self.path("marked/1.2.3-0"))
        marked.ImageType = ["ORIGINAL", "PRIMARY", "LOCALIZER"]
        marked.save_as(self.path("s/a localizer"))
        for number in range(2):
            shutil.copy(self.path(f"scouts/1.2.3-{number}"), self.path(f"s/a scout {number}"))
        shutil.copy(self.path("s/1.2.3-3"), self.path("s/1.2.3-3 (1)"))
        self.assert_read("s", samples, "1 of a scout (a localizer)", "2 of another orientation (a scout 0, ...)",
                         "1 copied (1.2.3-3 (1))")
        other = dcmread(self.path("s/1.2.3-3"))
        other.EchoNumbers = 2
        other.PixelData = bytes(len(other.PixelData))
        other.save_as(self.path("s/1.2.3-3 (1)"))
        self.assert_error("s", "s/1.2.3-3 (1): cannot be read: it lies where s/1.2.3-3 does, and has another "
                               "Echo Numbers (2, not )")

    def test_what_is_not_obeyed_is_told(self):
        for key, values, words in (
            ("MONOCHROME1", {"PhotometricInterpretation": "MONOCHROME1"}, "low samples are the bright ones"),
            ("padding", {"PixelPaddingValue": -2000}, "(Pixel Padding Value -2000)"),
            ("spacing", {"PixelSpacing": None}, "there is no Pixel Spacing"),
            ("between", {"SpacingBetweenSlices": 3}, "1 mm apart by their positions, 3 by Spacing Between"),
            ("dose", {"DoseGridScaling": 0.5}, "not multiplied by the Dose Grid Scaling 0.5"),
            ("real", {"RealWorldValueMappingSequence": [Dataset()]}, "Real World Value Mapping is not applied"),
        ):
            with self.subTest(key=key):
                samples = make_samples("int16", (3, 6, 8))
                self.save(key, samples)
                for name in os.listdir(self.path(key)):
                    file = dcmread(self.path(f"{key}/{name}"))
                    for element, value in values.items():
                        if element == "PixelPaddingValue":
                            file.add_new(0x00280120, "SS", value)
                        else:
                            setattr(file, element, value)
                    file.save_as(self.path(f"{key}/{name}"))
                self.assert_read(key, samples, words, unit="" if key == "spacing" else "mm")


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
