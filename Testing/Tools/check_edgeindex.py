#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs edgeindex as its users do: check_edgeindex.py TOOL FILES SCRATCH CLAIM

FILES are the golden files of the format; what they hold is told in Testing/Data/README.md.
"""
import collections
import json
import os
import shutil
import struct
import subprocess
import sys
import unittest

TOOL, FILES, SCRATCH, CLAIM = sys.argv[1:5]
NAMES = sorted(name for name in os.listdir(FILES) if name.endswith(".eix"))


def run(*arguments):
    """Return code, standard output and standard error of a run."""
    result = subprocess.run(
        [TOOL, *arguments], capture_output=True, text=True, cwd=SCRATCH, timeout=60
    )
    return result.returncode, result.stdout, result.stderr


def golden(name):
    return os.path.join(FILES, name)


def scratch(name):
    return os.path.join(SCRATCH, name)


def read_ply(path):
    """Numbers of points and a list of triangles."""
    with open(path, "rb") as file:
        data = file.read()
    header, body = data.split(b"end_header\n", 1)
    points = triangles = 0
    properties = 0
    element = None
    for line in header.decode().split("\n"):
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            element, points = "vertex", int(words[2])
        elif words[:2] == ["element", "face"]:
            element, triangles = "face", int(words[2])
        elif words[:1] == ["property"] and element == "vertex":
            properties += {"float": 4, "uchar": 1}[words[1]]
    body = body[points * properties :]
    cells = []
    for n in range(triangles):
        size, *corners = struct.unpack_from("<Biii", body, 13 * n)
        assert size == 3
        cells.append(tuple(corners))
    return points, cells


def read_obj(path):
    points, cells = 0, []
    with open(path) as file:
        for line in file:
            words = line.split()
            points += words[:1] == ["v"]
            if words[:1] == ["f"]:
                cells.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:]))
    return points, cells


def count_open_sides(cells):
    """Sides of triangles that are not the side of another one, the other way round."""
    sides = collections.Counter()
    for cell in cells:
        for n in range(3):
            sides[cell[n], cell[(n + 1) % 3]] += 1
    return sum(1 for a, b in sides if a != b and (b, a) not in sides)


class InfoTellsWhatIsThere(unittest.TestCase):
    def test_json(self):
        modes = {}
        for name in NAMES:
            with self.subTest(name=name):
                code, out, err = run("info", golden(name), "--json")
                self.assertEqual((code, err), (0, ""))
                told = json.loads(out)
                self.assertTrue(told["isComplete"])
                self.assertEqual(told["bytes"], os.path.getsize(golden(name)))
                self.assertGreater(sum(one["points"] for one in told["isovalues"]), 0)
                modes[name] = told["settings"]["mode"]
        self.assertEqual(modes["quantized.eix"], "quantized")
        self.assertEqual(modes["lossless-int16.eix"], "lossless")
        self.assertEqual(modes["bounded.eix"], "bounded")

    def test_text(self):
        code, out, _ = run("info", golden("bounded.eix"))
        self.assertEqual(code, 0)
        for word in ("dimensions", "bounded, to within", "bits a point"):
            self.assertIn(word, out)

    def test_what_is_missing(self):
        with open(golden("bounded.eix"), "rb") as file:
            data = file.read()
        with open(scratch("cut.eix"), "wb") as file:
            file.write(data[: len(data) * 3 // 4])
        code, out, _ = run("info", "cut.eix", "--json")
        self.assertEqual(code, 0)
        told = json.loads(out)
        self.assertFalse(told["isComplete"])
        self.assertIn("blocks are complete", told["missing"])


class VerifyFindsAnyFault(unittest.TestCase):
    def test_sound_files(self):
        for name in NAMES:
            with self.subTest(name=name):
                code, out, err = run("verify", golden(name))
                self.assertEqual(code, 0, err)
                self.assertIn("sound", out)
                self.assertEqual(run("verify", golden(name), "--quiet"), (0, "", ""))

    def test_damage(self):
        with open(golden("lossless-int16.eix"), "rb") as file:
            data = file.read()
        for place in range(10, len(data), len(data) // 40):
            with self.subTest(place=place):
                damaged = bytearray(data)
                damaged[place] ^= 4
                with open(scratch("damaged.eix"), "wb") as file:
                    file.write(damaged)
                code, _, err = run("verify", "damaged.eix", "--quiet")
                self.assertEqual(code, 1)
                self.assertTrue(err.startswith("edgeindex: damaged.eix: "), err)
                self.assertEqual(err.count("\n"), 1)


class DecodeWritesTriangles(unittest.TestCase):
    def test_all_formats_hold_one_surface(self):
        for name in NAMES:
            with self.subTest(name=name):
                found = {}
                for ending in ("ply", "stl", "vtp", "obj"):
                    code, out, err = run("decode", golden(name), "out." + ending)
                    self.assertEqual(code, 0, err)
                    found[ending] = out.split(",")[:2]
                words = out.split(": ", 1)[1].split()
                points, triangles = int(words[0]), int(words[2])
                self.assertEqual(len({str(value) for value in found.values()}), 1)
                for count, cells in (read_ply(scratch("out.ply")), read_obj(scratch("out.obj"))):
                    self.assertEqual((count, len(cells)), (points, triangles))
                    self.assertLess(max(max(cell) for cell in cells), points)
                with open(scratch("out.stl"), "rb") as file:
                    self.assertEqual(struct.unpack_from("<I", file.read(84), 80)[0], triangles)
                with open(scratch("out.vtp"), "rb") as file:
                    self.assertIn(b"GlobalIds", file.read())
        self.assertFalse([name for name in os.listdir(SCRATCH) if ".part" in name])

    def test_points_are_shared(self):
        run("decode", golden("lossless-int16.eix"), "out.ply")
        points, cells = read_ply(scratch("out.ply"))
        # Open at the border of the grid only: twice as many triangles as points, but for that.
        self.assertGreater(len(cells), 1.5 * points)
        self.assertLess(count_open_sides(cells), len(cells) / 4)

    def test_a_file_that_was_cut_off(self):
        with open(golden("bounded.eix"), "rb") as file:
            data = file.read()
        with open(scratch("cut.eix"), "wb") as file:
            file.write(data[: len(data) * 3 // 4])
        code, _, err = run("decode", "cut.eix", "cut.ply", "--quiet")
        self.assertEqual(code, 0, err)
        self.assertIn("warning", err)
        self.assertGreater(len(read_ply(scratch("cut.ply"))[1]), 0)


class ErrorsAreOneLine(unittest.TestCase):
    def check(self, *arguments):
        code, out, err = run(*arguments)
        self.assertEqual(code, 1)
        self.assertTrue(err.startswith("edgeindex: "), err)
        self.assertEqual(err.count("\n"), 1, err)
        return err

    def test_errors(self):
        self.assertIn("none.eix", self.check("info", "none.eix"))
        self.assertIn("none.eix", self.check("decode", "none.eix", "out.ply"))
        self.assertIn(".vtp", self.check("decode", golden("bounded.eix"), "out.xyz"))
        self.assertIn("nowhere", self.check("decode", golden("bounded.eix"), "nowhere/out.ply", "--quiet"))
        self.check()
        self.check("paint", golden("bounded.eix"))
        self.check("info")
        with open(scratch("text.eix"), "w") as file:
            file.write("not a surface" * 40)
        self.assertIn("text.eix", self.check("verify", "text.eix"))

    def test_help(self):
        self.assertEqual(run("--help")[0], 0)
        self.assertEqual(run("decode", "--help")[0], 0)
        self.assertEqual(run("--version")[0], 0)


shutil.rmtree(SCRATCH, ignore_errors=True)
os.makedirs(SCRATCH)
unittest.main(argv=[sys.argv[0], CLAIM], verbosity=2)
