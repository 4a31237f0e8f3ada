#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Files of nibabel, read by blockvolume: check_nifti.py TOOL MPIEXEC SCRATCH CLAIM"""
import gzip
import json
import os
import subprocess
import sys

import nibabel
import numpy

from sample_volumes import TYPES, WAIT_SECONDS, SourceCase, make_samples, run_claim


class Files(SourceCase):
    def save(self, name, samples, affine=None, kind=nibabel.Nifti1Image, endianness="<", **scale):
        """Writes samples of (z, y, x), or (t, z, y, x), as nibabel does: x first."""
        header = kind.header_class(endianness=endianness)
        image = kind(samples.T, numpy.eye(4) if affine is None else affine, header,
                     dtype=samples.dtype)
        image.header.set_slope_inter(scale.get("slope", 1), scale.get("inter", 0))
        nibabel.save(image, self.path(name))

    def grid_of(self, path):
        code, out, err = self.run_tool("--info", path, "--json")
        self.assertEqual(code, 0, err)
        return json.loads(out)["grid"]


class Samples(Files):
    def test_types_versions_byte_orders_and_gzip(self):
        for number, dtype in enumerate(TYPES):
            kind = nibabel.Nifti2Image if number % 3 else nibabel.Nifti1Image
            name = "a.nii.gz" if number % 4 == 3 else "a.nii"
            with self.subTest(type=dtype, kind=kind, name=name):
                samples = make_samples(dtype)
                self.save(name, samples, kind=kind, endianness="<>"[number % 2])
                self.assert_equal_volumes(self.write(name, "o.bvol", ranks=2 if number == 3 else 1),
                                          self.write_raw(samples, "NIFTI"))

    def test_slope_and_intercept(self):
        samples = make_samples("int16")
        data = samples.T.copy()
        image = nibabel.Nifti1Image(data, numpy.eye(4))
        nibabel.save(image, self.path("s.nii"))
        with open(self.path("s.nii"), "r+b") as file:
            file.seek(112)
            file.write(numpy.array([0.37, -12.5], "<f4").tobytes())
        values = nibabel.load(self.path("s.nii")).get_fdata().T.astype("float32")
        self.assertEqual(values.min(), values.flat[samples.argmin()])
        self.assert_equal_volumes(self.write("s.nii", "o.bvol", "--memory", "8"),
                                  self.write_raw(values, "NIFTI"))

    def test_time_steps(self):
        steps = numpy.stack([make_samples("uint8", phase=step) for step in range(2)])
        for name in ("t.nii", "t.nii.gz"):
            image = nibabel.Nifti1Image(steps.T, numpy.eye(4))
            image.header["pixdim"][4] = 2.5
            nibabel.save(image, self.path(name))
            self.assert_equal_volumes(self.write(name, "o.bvol", "--step", "1"),
                                      self.write_raw(steps[1], "NIFTI", "--time", "2.5"))
        self.write("t.nii", "o.bvol")
        code, out, _ = self.run_tool("--info", "o.bvol", "--json")
        self.assertEqual([step["time"] for step in json.loads(out)["timeSteps"]], [0, 2.5])

    def test_ranks_that_see_different_time_steps(self):
        steps = numpy.stack([make_samples("uint8", phase=step) for step in range(3)])
        for first, arguments in ((2, []), (1, ["--time", "4"])):
            for rank in (0, 1):
                folder = self.path(f"{first}-{rank}")
                os.mkdir(folder)
                self.save(os.path.join(folder, "t.nii"), steps[:first + rank])
            # Several programs in one command (":") crash the mpiexec of Debian 13.
            command = [self.mpiexec, "--oversubscribe", "-n", "2",
                       "sh", "-c", 'cd "$0-$OMPI_COMM_WORLD_RANK" && exec "$@"', self.path(str(first)), self.tool,
                       "t.nii", self.path("e.bvol"), *arguments]
            with self.subTest(arguments=arguments):
                result = subprocess.run(command, text=True, capture_output=True,
                                        timeout=WAIT_SECONDS)
                lines = [line for line in result.stderr.splitlines() if "blockvolume:" in line]
                self.assertEqual((result.returncode, len(lines)), (1, 1), result.stderr)
                self.assertIn("t.nii: the ranks see different numbers of time steps", lines[0])
                self.assertFalse(os.path.exists(self.path("e.bvol")))


class GridsAndErrors(Files):
    def test_sform_and_qform(self):
        turn = nibabel.eulerangles.euler2mat(0.3, -0.8, 2.1)
        affine = numpy.eye(4)
        affine[:3, :3] = turn * (0.5, 2, 1.25) * (1, 1, -1)
        affine[:3, 3] = (-90, 12.5, 7)
        samples = make_samples("uint8", (9, 8, 7))
        for form in ("sform", "qform"):
            image = nibabel.Nifti1Image(samples.T, affine)
            image.set_sform(affine, 1 if form == "sform" else 0)
            image.set_qform(numpy.eye(4) if form == "sform" else affine, 1)
            nibabel.save(image, self.path("g.nii"))
            expected = nibabel.load(self.path("g.nii")).affine
            grid = self.grid_of(self.write("g.nii", "o.bvol"))
            found = numpy.reshape(grid["direction"], (3, 3)) * grid["spacing"]
            numpy.testing.assert_allclose(found, expected[:3, :3], atol=1e-6)
            numpy.testing.assert_allclose(grid["origin"], expected[:3, 3], rtol=1e-6)

    def patch(self, name, *places):
        """Writes numbers into a header of NIfTI-1: place, type, values."""
        with open(self.path(name), "r+b") as file:
            for place, dtype, values in places:
                file.seek(place)
                file.write(numpy.array(values, dtype).tobytes())

    def test_an_sform_of_zeros_is_none(self):
        affine = numpy.diag([-0.5, 2, 1.25, 1])
        affine[:3, 3] = (90, 12.5, 7)
        image = nibabel.Nifti1Image(make_samples("uint8", (9, 8, 7)).T, affine)
        image.set_qform(affine, 1)
        nibabel.save(image, self.path("z.nii"))
        self.patch("z.nii", (254, "<i2", 2), (280, "<f4", [0] * 12))
        grid, _, err = self.convert("z.nii")
        found = numpy.reshape(grid["direction"], (3, 3)) * grid["spacing"]
        numpy.testing.assert_allclose(found, affine[:3, :3], atol=1e-6)
        numpy.testing.assert_allclose(grid["origin"], affine[:3, 3])
        self.assertIn("sform is all zeros: it is placed by its qform", err)
        self.patch("z.nii", (252, "<i2", 0))
        grid, _, err = self.convert("z.nii")
        self.assertEqual((grid["spacing"], grid["origin"]), ([0.5, 2, 1.25], [0, 0, 0]))
        self.assertIn("by its distances of samples alone", err)

    def test_distances_of_0_or_below_and_a_factor_of_0(self):
        image = nibabel.Nifti1Image(make_samples("uint8", (9, 8, 7)).T, numpy.eye(4))
        image.set_sform(numpy.eye(4), 0)
        image.set_qform(numpy.eye(4), 1)
        nibabel.save(image, self.path("d.nii"))
        self.patch("d.nii", (76, "<f4", [0, -3, 0, 2]))
        grid = self.convert("d.nii")[0]
        # As nibabel mends them: the magnitude, and 1 for 0; a factor of 0 mirrors nothing.
        self.assertEqual((grid["spacing"], grid["direction"]), ([3, 1, 2], numpy.eye(3).ravel().tolist()))

    def test_units_of_space_and_time(self):
        steps = numpy.stack([make_samples("uint8", (9, 8, 7), phase=step) for step in range(2)])
        for number, (space, time, unit, told) in enumerate((
                ("mm", "sec", "mm", ""), ("micron", "msec", "um", "time steps are in ms"),
                ("meter", "usec", "m", "time steps are in us"), ("unknown", "hz", None, "in Hz"))):
            kind = nibabel.Nifti2Image if number % 2 else nibabel.Nifti1Image
            image = kind(steps.T, numpy.eye(4))
            image.header.set_xyzt_units(space, time)
            nibabel.save(image, self.path("u.nii"))
            grid, _, err = self.convert("u.nii")
            self.assertEqual(grid.get("unit"), unit)
            self.assertIn(told, err)
            self.assertEqual(bool(told), bool(err), err)

    def test_an_offset_of_0_and_sizes_of_0(self):
        samples = make_samples("int16", (9, 8, 7))
        for kind, place in ((nibabel.Nifti1Image, (108, "<f4", 0)), (nibabel.Nifti2Image, (168, "<i8", 0))):
            self.save("o.nii", samples, kind=kind)
            self.patch("o.nii", place)
            self.assert_equal_volumes(self.write("o.nii", "o.bvol"), self.write_raw(samples, "NIFTI"))
        self.save("o.nii", samples)
        self.patch("o.nii", (40, "<i2", [5, 7, 8, 9, 0, 0]))
        self.assert_equal_volumes(self.write("o.nii", "o.bvol"), self.write_raw(samples, "NIFTI"))

    def test_pairs_of_files(self):
        samples = make_samples("int16", (9, 8, 7))
        affine = numpy.diag([2, 3, 4, 1])
        nibabel.save(nibabel.Nifti1Pair(samples.T, affine), self.path("p.hdr"))
        expected = self.write_raw(samples, "NIFTI", spacing=(2, 3, 4))
        for name in ("p.hdr", "p.img"):
            self.assert_equal_volumes(self.write(name, "o.bvol"), expected)
        os.remove(self.path("p.img"))
        self.assert_error("p.hdr", "p.img")

    def test_analyze_is_scaled_and_placed_as_by_nibabel(self):
        samples = make_samples("int16", (9, 8, 7))
        for number, (told, places) in enumerate((
                ("the middle", []), ("the middle", [(112, "f4", [0.5, -3])]), ("", [(253, "i2", [3, 2, -4])]),
                ("the middle", [(112, "f4", [numpy.nan, 7]), (253, "i2", [300, 2, 4])]),
                ("glmin to glmax", [(124, "f4", [10, 2]), (140, "i4", [100, 0])]),
                ("orient", [(252, "u1", 3), (112, "f4", [2, numpy.inf])]))):
            endianness = "<>"[number % 2]
            header = nibabel.AnalyzeHeader(endianness=endianness)
            header.set_data_dtype("int16")
            header.set_data_shape((7, 8, 9))
            header.set_zooms((2, 3, 4))
            nibabel.AnalyzeImage(samples.T, None, header).to_filename(self.path("a.hdr"))
            self.patch("a.hdr", *((place, endianness + dtype, values) for place, dtype, values in places),
                       (56, "S4", b"mm"))
            expected = nibabel.load(self.path("a.img"))
            _, _, err = self.convert("a.img")
            self.assertIn("Analyze 7.5", err)
            self.assertIn(told, err)
            image = nibabel.Nifti1Image(
                expected.get_fdata().astype("int16" if number in (0, 2, 3) else "float32"), expected.affine)
            image.header.set_xyzt_units("mm")
            nibabel.save(image, self.path("n.nii"))
            self.assert_equal_volumes(self.write("a.hdr", "o.bvol"), self.write("n.nii", "n.bvol"))
        os.rename(self.path("a.hdr"), self.path("a.nii"))
        self.assert_error("a.nii", "it is not a file of NIfTI")

    def test_vectors_and_halves_of_a_scale_are_refused(self):
        self.save("f.nii", make_samples("float32", (9, 8, 7))[None, None].repeat(3, 0))
        self.patch("f.nii", (68, "<i2", 1007))
        self.assert_error("f.nii", "3 samples on its axis number 5", "vector", "1007")
        self.save("f.nii", make_samples("int16", (9, 8, 7)))
        self.patch("f.nii", (112, "<f4", [2, numpy.nan]))
        self.assert_error("f.nii", "an intercept that is not finite")
        for slope in (0, numpy.nan):
            self.patch("f.nii", (112, "<f4", [slope, 7]))
            self.assertEqual(self.convert("f.nii")[1], {"NIFTI": ""})

    def test_errors_name_file_and_reason(self):
        samples = make_samples("complex64", (9, 8, 7))
        self.save("c.nii", samples)
        self.assert_error("c.nii", "c.nii: cannot be read: its data type 32")
        self.save("v.nii", make_samples("int16", (9, 8, 7))[None].repeat(2, 0))
        self.assert_error("v.nii", "v.nii: has 2 time steps", arguments=["--step", "2"])
        self.assert_error("v.nii:more", "v.nii:more", "one volume")
        self.save("t.nii", make_samples("int16"))
        with open(self.path("t.nii"), "rb") as file:
            whole = file.read()
        for size in (0, 100, 352, len(whole) // 2, len(whole) - 1):
            with open(self.path("u.nii"), "wb") as file:
                file.write(whole[:size])
            self.assert_error("u.nii", "u.nii", "truncated", ranks=2 if size == 352 else 1)
        packed = gzip.compress(whole)
        with open(self.path("u.nii.gz"), "wb") as file:
            file.write(packed[:len(packed) // 2])
        self.assert_error("u.nii.gz", "u.nii.gz", "truncated")


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
