#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Folders and patterns of files, read by blockvolume: check_folders.py TOOL MPIEXEC SCRATCH CLAIM"""
import filecmp
import json
import os
import shutil
import struct
import sys
import zlib

import numpy

from sample_volumes import SourceCase, list_files, make_samples, run_claim

SHAPE = (12, 9, 14)


def make_png(samples):
    """An image of 8 or 16 bits a sample; of three bytes a pixel if it has a third axis."""
    height, width = samples.shape[:2]
    rows = samples.astype(samples.dtype.newbyteorder(">")).tobytes()
    size = len(rows) // height
    lines = b"".join(b"\0" + rows[y * size:(y + 1) * size] for y in range(height))
    color = 0 if samples.ndim == 2 else 2

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", width, height, 8 * samples.itemsize, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")


def make_bmp(samples):
    """An image of 8 bits a pixel, its last row first, with a palette of greys."""
    height, width = samples.shape
    rows = b"".join(row.tobytes().ljust((width + 3) // 4 * 4, b"\0") for row in samples[::-1])
    palette = b"".join(bytes((grey, grey, grey, 0)) for grey in range(256))
    head = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 8, 0, len(rows), 0, 0, 256, 0)
    return b"BM" + struct.pack("<IHHI", 54 + len(palette) + len(rows), 0, 0, 54 + len(palette)) + head + palette + rows


class Folders(SourceCase):
    def save(self, folder, kind, images, make):
        os.makedirs(self.path(folder))
        for number, image in enumerate(images):
            with open(self.path(f"{folder}/slice{number + 1}.{kind}"), "wb") as file:
                file.write(make(image))
        with open(self.path(f"{folder}/._slice1.{kind}"), "wb") as file:
            file.write(b"\0\5\x16\7" + bytes(99))
        with open(self.path(f"{folder}/notes.txt"), "w") as file:
            file.write("no slice")

    def assert_same_samples(self, path, expected):
        mine, others = list_files(path), list_files(expected)
        self.assertEqual(sorted(mine), sorted(others))
        for name in mine:
            if name != "header":  # which has the array's name
                self.assertTrue(filecmp.cmp(mine[name], others[name], shallow=False), name)


class SlicesOfImages(Folders):
    def test_a_folder_or_pattern_is_the_volume_of_its_slices(self):
        for kind, dtype, make in (("png", "uint8", make_png), ("png", "uint16", make_png),
                                  ("bmp", "uint8", make_bmp)):
            with self.subTest(kind=kind, dtype=dtype):
                folder = kind + dtype
                samples = make_samples(dtype, SHAPE)
                self.save(folder, kind, samples, make)
                expected = self.write_raw(samples, "x")
                self.assert_same_samples(self.write(folder, "o.bvol"), expected)
                self.assert_same_samples(self.write(f"{folder}/*.{kind}", "o.bvol", ranks=2), expected)
                err = self.run_tool(folder, "o.bvol")[2]
                self.assertIn("passed over: 1 hidden (._slice1." + kind + "), 1 of another kind (notes.txt)", err)
                self.assertIn("cannot be indexed in place", self.run_tool("--in-place", folder, "e.bvol")[2])

    def test_colors_are_components(self):
        samples = make_samples("uint8", SHAPE)
        self.save("rgb", "png", numpy.stack([samples, samples // 2, samples // 3], axis=3), make_png)
        self.write("rgb", "o.bvol")
        with open(self.path("o.bvol"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["arrays"][0]["components"], 3)

    def test_slices_that_are_missing_or_differ_are_an_error(self):
        samples = make_samples("uint8", SHAPE)
        self.save("m", "png", samples, make_png)
        shutil.copy(self.path("m/slice3.png"), self.path("m/slice3 (1).png"))
        self.assertIn("1 copied (slice3 (1).png)", self.run_tool("m", "o.bvol")[2])
        shutil.copy(self.path("m/slice4.png"), self.path("m/slice3 (1).png"))
        self.assert_error("m", "m/slice3 (1).png: is named as a copy of m/slice3.png and differs from it")
        os.remove(self.path("m/slice3 (1).png"))
        with open(self.path("m/slice6.png"), "wb") as file:
            file.write(make_png(samples[5, :4]))
        self.assert_error("m", "m/slice6.png: cannot be read: its size or type differs from that of m/slice1.png")
        with open(self.path("m/slice6.png"), "wb") as file:
            file.write(b"no image")
        self.assert_error("m", "m/slice6.png: cannot be read")
        os.remove(self.path("m/slice6.png"))
        self.assert_error("m", "m/slice7.png: a slice of the series is missing")
        os.mkdir(self.path("every third"))
        for number in (3, 6, 9):
            shutil.copy(self.path(f"m/slice{number}.png".replace("6", "5")), self.path(f"every third/slice{number}.png"))
        self.assertIn("the numbers in the names go up by 3", self.run_tool("every third", "o.bvol")[2])
        os.rename(self.path("every third/slice9.png"), self.path("every third/mask9.png"))
        self.assertIn("the names differ in more than one number (mask9.png, slice6.png): all are slices of one volume",
                      self.run_tool("every third", "o.bvol")[2])


class TimeSteps(Folders):
    def make(self, name, samples):
        with open(self.path(name), "wb") as file:
            if name.endswith(".nrrd"):
                sizes = " ".join(str(size) for size in samples.shape[::-1])
                file.write(f"NRRD0004\ntype: float\ndimension: 3\nsizes: {sizes}\nencoding: raw\n"
                           "endian: little\n\n".encode() + samples.astype("<f4").tobytes())
            else:
                extent = " ".join(f"0 {size - 1}" for size in samples.shape[::-1])
                values = " ".join(str(value) for value in samples.ravel())
                file.write(f"""<VTKFile type="ImageData"><ImageData WholeExtent="{extent}" Origin="0 0 0"
                    Spacing="1 1 1"><Piece Extent="{extent}"><PointData><DataArray type="Float32" Name="x"
                    format="ascii">{values}</DataArray></PointData></Piece></ImageData></VTKFile>""".encode())

    def test_a_pattern_of_volumes_is_a_volume_of_time_steps(self):
        steps = {number: make_samples("float32", SHAPE, phase=number) for number in (1, 2, 10)}
        os.mkdir(self.path("steps"))
        for number, samples in steps.items():
            for kind in ("nrrd", "vti"):
                self.make(f"steps/s{number}.{kind}", samples)
        for step, samples in enumerate(steps.values()):
            samples.tofile(self.path("x.raw"))
            place = ["--dimensions", ",".join(str(size) for size in SHAPE[::-1]), "--type", "float32"]
            code, _, err = self.run_tool("x.raw", "e.bvol", "--stores", "3", *place, "--time", str(step),
                                         *(["--append"] if step else []))
            self.assertEqual(code, 0, err)
        for kind, options in (("nrrd", []), ("vti", []), ("nrrd", ["--in-place"])):
            with self.subTest(kind=kind, options=options):
                path = self.write(f"steps/*.{kind}", "o.bvol", *options)
                with open(path, encoding="utf-8") as file:
                    times = [step["time"] for step in json.load(file)["timeSteps"]]
                self.assertEqual(times, [0, 1, 2])
                if options:
                    code, _, err = self.run_tool("--verify", "--quiet", path)
                    self.assertEqual((code, err), (0, ""))
                else:
                    self.assert_same_samples(path, self.path("e.bvol"))
        self.assertIn("the 3 files are time steps", self.run_tool("steps/*.vti", "o.bvol")[2])
        self.assert_same_samples(self.write("steps/*.nrrd", "o.bvol", "--step", "2"),
                                 self.write_raw(steps[10], "x"))
        for kind in ("nrrd", "vti"):
            self.make(f"steps/s3.{kind}", steps[1][1:])
            code, _, err = self.run_tool(f"steps/*.{kind}", "new.bvol")
            self.assertEqual((code, os.path.exists(self.path("new.bvol"))), (1, False))
            self.assertIn("it has another extent", err)


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
