#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Files of mrcfile, read by blockvolume: check_mrc.py TOOL MPIEXEC SCRATCH CLAIM"""
import sys

import mrcfile
import numpy

from sample_volumes import SourceCase, make_samples, run_claim


class Files(SourceCase):
    def save(self, name, samples):
        compression = "gzip" if name.endswith(".gz") else None
        with mrcfile.new(self.path(name), samples, compression=compression, overwrite=True) as file:
            file.voxel_size = 1


class Samples(Files):
    def test_modes_and_byte_orders(self):
        for number, dtype in enumerate(("int8", "int16", "float32", "uint16", "float16")):
            for order in "<>" if dtype == "int16" else "<>"[number % 2]:
                with self.subTest(type=dtype, order=order):
                    samples = make_samples(dtype)
                    name = "a.mrc.gz" if dtype == "uint16" else "a.mrc"
                    self.save(name, samples.astype(samples.dtype.newbyteorder(order)))
                    if dtype == "float16":
                        samples = samples.astype("float32")
                    self.assert_equal_volumes(self.write(name, "o.bvol", ranks=2 if number == 3 else 1),
                                              self.write_raw(samples, "MRC", unit="angstrom"))

    def test_bytes_of_imod_are_unsigned(self):
        samples = make_samples("uint8") + 100
        self.save("i.rec", samples.view("int8"))
        with open(self.path("i.rec"), "r+b") as file:
            file.seek(152)
            file.write(numpy.array([1146047817, 0], "<i4").tobytes())
        self.assert_equal_volumes(self.write("i.rec", "o.bvol"),
                                  self.write_raw(samples, "MRC", unit="angstrom"))

    def test_order_of_axes(self):
        samples = make_samples("int16")
        for axes in ((3, 2, 1), (2, 3, 1), (1, 2, 3)):
            with self.subTest(axes=axes):
                # The file's columns, rows and sections are the axes x=1, y=2, z=3 of these numbers.
                stored = samples.transpose([3 - axis for axis in axes[::-1]])
                self.save("x.map", numpy.ascontiguousarray(stored))
                with mrcfile.open(self.path("x.map"), "r+") as file:
                    file.header.mapc, file.header.mapr, file.header.maps = axes
                    for name, size in zip("xyz", samples.shape[::-1]):
                        file.header["m" + name] = size
                        file.header.cella[name] = size * 0.5
                    file.header.nxstart = 4
                origin = [0, 0, 0]
                origin[axes[0] - 1] = 4 * 0.5
                self.assert_equal_volumes(
                    self.write("x.map", "o.bvol"),
                    self.write_raw(samples, "MRC", spacing=(0.5, 0.5, 0.5), origin=origin, unit="angstrom"))

    def test_cell_origin_and_extended_header(self):
        samples = make_samples("float32")
        with mrcfile.new(self.path("e.mrc"), samples, overwrite=True) as file:
            file.voxel_size = (0.5, 2, 4)
            file.header.origin = (-3, 7, 1.5)
            file.set_extended_header(numpy.arange(4096, dtype="uint8"))
        self.assert_equal_volumes(
            self.write("e.mrc", "o.bvol"),
            self.write_raw(samples, "MRC", spacing=(0.5, 2, 4), origin=(-3, 7, 1.5), unit="angstrom"))


class StacksAndErrors(Files):
    def test_images_and_bytes_that_are_no_part_of_a_volume_are_told(self):
        samples = make_samples("int16", (9, 8, 7))
        self.save("v.mrc", samples)
        with mrcfile.mmap(self.path("v.mrc"), "r+") as file:
            file.header.ispg, file.header.mz = 0, 1
        self.assertIn("images that are no slices of a volume", self.convert("v.mrc")[2])
        self.save("v.mrc", samples)
        self.assertEqual(self.convert("v.mrc")[2], "")
        with open(self.path("v.mrc"), "ab") as file:
            file.write(bytes(5))
        self.assertIn("v.mrc: 5 bytes behind the samples are not read", self.convert("v.mrc")[2])

    def test_a_stack_of_volumes_has_time_steps(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(2)])
        self.save("s.mrc", steps)
        self.assert_equal_volumes(self.write("s.mrc", "o.bvol", "--step", "1"),
                                  self.write_raw(steps[1], "MRC", "--time", "1", unit="angstrom"))

    def test_errors_name_file_and_reason(self):
        self.save("c.mrc", make_samples("complex64", (9, 8, 7)))
        self.assert_error("c.mrc", "c.mrc: cannot be read: its mode 4")
        self.save("t.mrc", make_samples("int16"))
        with open(self.path("t.mrc"), "rb") as file:
            whole = file.read()
        for size in (0, 1000, 1024, len(whole) - 1):
            with open(self.path("u.mrc"), "wb") as file:
                file.write(whole[:size])
            self.assert_error("u.mrc", "u.mrc", "truncated")
        with open(self.path("u.mrc"), "wb") as file:
            file.write(b"no volume at all" * 100)
        self.assert_error("u.mrc", "u.mrc: cannot be read: it is not an MRC file")


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
