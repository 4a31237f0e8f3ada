#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs edgeindex as its users do: check_edgeindex.py TOOL FILES SCRATCH CLAIM

FILES are the golden files of the format; what they hold is told in Testing/Data/README.md.
"""
import collections
import ctypes
import ctypes.util
import fcntl
import json
import math
import os
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "Readers"))
from read_edge_index import EdgeIndexFile  # noqa: E402  (found in a folder beside this one)
from read_interval_tree import hash64  # noqa: E402  (found in a folder beside this one)
from time_limits import WAIT_SECONDS  # noqa: E402  (found in the folder above)

TOOL, FILES, SCRATCH, CLAIM = sys.argv[1:5]
# Its points are not all numbers; nor are its normals, some of which have length 0.
NOT_NUMBERS = "not-numbers.eix"
NAMES = sorted(name for name in os.listdir(FILES) if name.endswith(".eix"))


def run(*arguments):
    """Return code, standard output and standard error of a run."""
    result = subprocess.run(
        [TOOL, *arguments], capture_output=True, text=True, cwd=SCRATCH, timeout=WAIT_SECONDS
    )
    return result.returncode, result.stdout, result.stderr


def run_limited(size, *arguments):
    """The same where no file may have more bytes, as on a full disk."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    result = subprocess.run([TOOL, *arguments], capture_output=True, text=True, cwd=SCRATCH,
                            timeout=WAIT_SECONDS, preexec_fn=limit)
    return result.returncode, result.stdout, result.stderr


def is_as_told(name, err):
    """Whether a run without a summary says what is left out, and nothing else."""
    told = r"edgeindex: warning: \S+: \d+ triangles with a point that is not a number are left out\n"
    return re.fullmatch(told if name == NOT_NUMBERS else "", err)


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
            properties += {"double": 8, "float": 4, "uchar": 1}[words[1]]
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


def read_ply_points(path):
    """Coordinates of the points, and triangles."""
    points, cells = read_ply(path)
    with open(path, "rb") as file:
        header, body = file.read().split(b"end_header\n", 1)
    wide = b"property double x" in header
    size = 4 * header.count(b"property float ") + 8 * header.count(b"property double ")
    return [struct.unpack_from("<3d" if wide else "<3f", body, size * n) for n in range(points)], cells


def read_obj_points(path):
    """Coordinates of the points, and triangles."""
    with open(path) as file:
        lines = [line.split() for line in file]
    return [tuple(map(float, line[1:])) for line in lines if line[0] == "v"], read_obj(path)[1]


def place(name, origin, spacing, direction, to):
    """A golden file whose grid lies elsewhere. Its directory is that of another header: it is left out."""
    with open(golden(name), "rb") as file:
        data = file.read()
    size = struct.unpack_from("<I", data, 12)[0]
    header = data[:96] + struct.pack("<15d", *origin, *spacing, *direction) + data[216 : size - 8]
    with open(scratch(to), "wb") as file:
        file.write(header + struct.pack("<Q", hash64(header)) + data[size:])


def read_stl_points(path):
    """The corners of each triangle, as coordinates."""
    with open(path, "rb") as file:
        data = file.read()
    count = struct.unpack_from("<I", data, 80)[0]
    assert len(data) == 84 + 50 * count
    values = [struct.unpack_from("<9f", data, 84 + 50 * n + 12) for n in range(count)]
    return [(one[:3], one[3:6], one[6:]) for one in values]


class Glb:
    """A binary glTF file; what is compressed is decoded by libmeshoptimizer."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        magic, version, size, length, kind = struct.unpack_from("<4sIII4s", data)
        assert (magic, version, size, kind) == (b"glTF", 2, len(data), b"JSON")
        self.json = json.loads(data[20 : 20 + length])
        size, kind = struct.unpack_from("<I4s", data, 20 + length)
        assert kind == b"BIN\0" and len(data) == 28 + length + size
        self.binary = data[28 + length :]
        assert self.json["buffers"][0]["byteLength"] == size

    def read_view(self, number):
        view = self.json["bufferViews"][number]
        code = view.get("extensions", {}).get("EXT_meshopt_compression")
        if not code:
            return self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        library = ctypes.CDLL(ctypes.util.find_library("meshoptimizer"))
        source = self.binary[code["byteOffset"] : code["byteOffset"] + code["byteLength"]]
        count, stride = ctypes.c_size_t(code["count"]), ctypes.c_size_t(code["byteStride"])
        result = ctypes.create_string_buffer(view["byteLength"])
        decode = {"TRIANGLES": library.meshopt_decodeIndexBuffer,
                  "ATTRIBUTES": library.meshopt_decodeVertexBuffer}[code["mode"]]
        assert decode(result, count, stride, source, ctypes.c_size_t(len(source))) == 0
        if code.get("filter") == "OCTAHEDRAL":
            library.meshopt_decodeFilterOct(result, count, stride)
        return result.raw

    def read(self, number):
        accessor = self.json["accessors"][number]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind = {5120: "b", 5125: "I", 5126: "f"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        stride = view.get("byteStride", width * struct.calcsize(kind))
        data = self.read_view(accessor["bufferView"])
        assert len(data) == accessor["count"] * stride
        values = [struct.unpack_from(f"<{width}{kind}", data, stride * n)
                  for n in range(accessor["count"])]
        if "min" in accessor:
            for axis in range(width):
                assert min(value[axis] for value in values) == accessor["min"][axis]
                assert max(value[axis] for value in values) == accessor["max"][axis]
        return values

    def triangles(self):
        """The corners of each triangle, as coordinates, of all meshes."""
        found = []
        root, = self.json["scenes"][0]["nodes"]
        for node in self.json["nodes"][root]["children"]:
            for part in self.json["meshes"][self.json["nodes"][node]["mesh"]]["primitives"]:
                points = self.read(part["attributes"]["POSITION"])
                corners = [value for (value,) in self.read(part["indices"])]
                found += [tuple(points[corner] for corner in corners[n : n + 3])
                          for n in range(0, len(corners), 3)]
        return found

    def count_normals(self):
        """Points with a normal, all of which must have unit length, or nearly where they have 8 bits."""
        count = 0
        for mesh in self.json["meshes"]:
            for part in mesh["primitives"]:
                if "NORMAL" in part["attributes"]:
                    accessor = self.json["accessors"][part["attributes"]["NORMAL"]]
                    unit, error = (127, 0.03) if accessor["componentType"] == 5120 else (1, 1e-6)
                    for normal in self.read(part["attributes"]["NORMAL"]):
                        length = sum(value * value for value in normal) ** 0.5 / unit
                        assert abs(length - 1) < error, normal
                        count += 1
        return count


def turn(triangle):
    """The same triangle, whichever corner comes first."""
    return min(triangle[n:] + triangle[:n] for n in range(3))


def count_triangles(triangles):
    return collections.Counter(turn(tuple(one)) for one in triangles)


def are_numbers(triangle):
    return all(math.isfinite(value) for point in triangle for value in point)


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

    def test_names_that_are_not_utf8(self):
        code, out, _ = run("info", golden("normals.eix"), "--json")
        told = json.loads(out)
        names = [told["array"], told["source"], *(one["name"] for one in told["attributes"])]
        self.assertGreater(len(names), 2)
        with open(golden("normals.eix"), "rb") as file:
            data = file.read()
        header = data[: struct.unpack_from("<I", data, 12)[0] - 8]
        for name in map(str.encode, names):
            size = struct.pack("<I", len(name))
            self.assertIn(size + name, header)
            header = header.replace(size + name, size + b"\xff" * len(name))
        path = os.fsdecode(scratch("").encode() + b"name-\xff.eix")
        with open(path, "wb") as file:
            file.write(header + struct.pack("<Q", hash64(header)))
        for arguments in (["info", path], ["info", path, "--json"]):
            result = subprocess.run([TOOL, *arguments], capture_output=True, timeout=WAIT_SECONDS)
            self.assertEqual((result.returncode, result.stderr), (0, b""))
            for name in names:
                self.assertIn(('"' + "\ufffd" * len(name) + '"').encode(), result.stdout)

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


class OutputIsReplacedInOneStep(unittest.TestCase):
    OUTPUTS = ("out.ply", "out.stl", "out.glb", "out.vtp", "out.obj")

    def setUp(self):
        for name in os.listdir(SCRATCH):
            os.remove(scratch(name))

    def fill(self, name, data=b"of the user"):
        with open(scratch(name), "wb") as file:
            file.write(data)
        return data

    def read(self, name):
        with open(scratch(name), "rb") as file:
            return file.read()

    def test_files_beside_it_stay(self):
        mine = self.fill("out.part.ply"), self.fill("out.part.ply.faces"), self.fill("out.part.vtp")
        with open(golden("bounded.eix"), "rb") as file:
            damaged = bytearray(file.read())
        damaged[len(damaged) // 2] ^= 4
        self.fill("damaged.eix", damaged)
        for name in self.OUTPUTS:
            for source, expected in ((golden("bounded.eix"), 0), ("damaged.eix", 1)):
                with self.subTest(name=name, source=source):
                    self.assertEqual(run("decode", source, name, "--quiet")[0], expected)
        left = {"damaged.eix", "out.part.ply", "out.part.ply.faces", "out.part.vtp", *self.OUTPUTS}
        self.assertEqual(set(os.listdir(SCRATCH)), left)
        self.assertEqual(mine, tuple(map(self.read, ("out.part.ply", "out.part.ply.faces", "out.part.vtp"))))

    def test_a_second_writer_fails_and_changes_nothing(self):
        for name in self.OUTPUTS:
            with self.subTest(name=name):
                older, partial = self.fill(name), self.fill(name + ".part", b"of the first")
                with open(scratch(name + ".part"), "rb") as first:
                    fcntl.flock(first, fcntl.LOCK_EX)
                    code, _, err = run("decode", golden("bounded.eix"), name, "--quiet")
                self.assertEqual(code, 1)
                self.assertEqual(err, f"edgeindex: {name}.part: cannot be locked: another program is "
                                      "writing there\n")
                self.assertEqual((self.read(name), self.read(name + ".part")), (older, partial))

    def test_what_a_killed_run_has_left_is_removed(self):
        for name in self.OUTPUTS:
            with self.subTest(name=name):
                self.assertEqual(run("decode", golden("bounded.eix"), name, "--quiet"), (0, "", ""))
                expected = self.read(name)
                self.fill(name + ".part", b"left" * 1000000)
                if name == "out.ply":
                    self.fill(name + ".part.faces")
                self.assertEqual(run("decode", golden("bounded.eix"), name, "--quiet"), (0, "", ""))
                self.assertEqual(self.read(name), expected)
        self.assertEqual(sorted(os.listdir(SCRATCH)), sorted(self.OUTPUTS))


class PiecesAreOneSurface(unittest.TestCase):
    """--memory 1 is less than any file needs: each row of blocks is a piece."""

    def test_any_memory_gives_the_same_points_and_triangles(self):
        for name in NAMES:
            with self.subTest(name=name):
                for memory in ("1", "1024"):
                    code, _, err = run("decode", golden(name), memory + ".ply", "--memory", memory,
                                       "--quiet")
                    self.assertEqual(code, 0, err)
                    self.assertTrue(is_as_told(name, err), err)
                some, cells = read_ply_points(scratch("1.ply"))
                points, all_cells = read_ply_points(scratch("1024.ply"))
                self.assertEqual(len(cells), len(all_cells))
                self.assertEqual(collections.Counter(some), collections.Counter(points))
                self.assertEqual(count_triangles(tuple(some[n] for n in cell) for cell in cells),
                                 count_triangles(tuple(points[n] for n in cell) for cell in all_cells))
                self.assertEqual(count_open_sides(cells), count_open_sides(all_cells))

    def test_stl_and_glb_have_the_triangles_of_ply(self):
        normals = 0
        for name in NAMES:
            for memory in ("1", "1024") if name == "lossless-int16.eix" else ("1",):
                with self.subTest(name=name, memory=memory):
                    for output in (["o.ply"], ["o.stl"], ["o.glb"], ["c.glb", "--compress"]):
                        code, _, err = run("decode", golden(name), *output, "--memory", memory,
                                           "--quiet")
                        self.assertEqual(code, 0, err)
                        self.assertTrue(is_as_told(name, err), err)
                    points, cells = read_ply_points(scratch("o.ply"))
                    expected = count_triangles(tuple(points[n] for n in cell) for cell in cells)
                    self.assertEqual(count_triangles(read_stl_points(scratch("o.stl"))), expected)
                    plain = Glb(scratch("o.glb"))
                    self.assertEqual(count_triangles(plain.triangles()), expected)
                    compressed = Glb(scratch("c.glb"))
                    self.assertEqual(count_triangles(compressed.triangles()), expected)
                    self.assertLessEqual(compressed.count_normals(), plain.count_normals())
                    normals += compressed.count_normals()
        self.assertGreater(normals, 0)

    def test_obj_has_the_points_and_triangles_of_ply(self):
        for name in NAMES:
            with self.subTest(name=name):
                for output in ("o.ply", "o.obj"):
                    code, _, err = run("decode", golden(name), output, "--memory", "1", "--quiet")
                    self.assertEqual(code, 0, err)
                points, cells = read_ply_points(scratch("o.ply"))
                found, same = read_obj_points(scratch("o.obj"))
                self.assertEqual([struct.pack("<3f", *point) for point in found],
                                 [struct.pack("<3f", *point) for point in points])
                self.assertEqual(cells, same)

    def test_another_reader_of_gltf(self):
        from vtkmodules.vtkIOGeometry import vtkGLTFReader
        run("decode", golden("lossless-int16.eix"), "o.glb", "--memory", "1")
        reader = vtkGLTFReader()
        reader.SetFileName(scratch("o.glb"))
        reader.Update()
        blocks = reader.GetOutput().NewIterator()
        cells = 0
        while not blocks.IsDoneWithTraversal():
            cells += blocks.GetCurrentDataObject().GetNumberOfCells()
            blocks.GoToNextItem()
        self.assertEqual(cells, len(Glb(scratch("o.glb")).triangles()))

    def test_fewer_triangles_with_the_same_borders(self):
        for memory in ("1", "1024"):
            for ending in ("ply", "stl", "glb"):
                with self.subTest(memory=memory, ending=ending):
                    code, _, err = run("decode", golden("lossless-int16.eix"), "all." + ending)
                    self.assertEqual(code, 0, err)
                    code, _, err = run("decode", golden("lossless-int16.eix"), "few." + ending,
                                       "--memory", memory, "--triangles", "1000", "--quiet")
                    self.assertEqual((code, err), (0, ""))
                    every, few = (self.read(scratch(name + "." + ending)) for name in ("all", "few"))
                    # Borders of pieces stay, so small pieces have more.
                    self.assertLess(len(few), len(every) / 2 if memory == "1024" else len(every))
                    self.assertLess({p for one in few for p in one}, {p for one in every for p in one})
                    self.assertEqual(self.count_border_points(few), self.count_border_points(every))

    def test_fewer_triangles_are_a_manifold_with_the_same_open_sides(self):
        for name in ("lossless-int16.eix", "lossless-float32.eix"):
            for memory in ("1", "1024"):
                with self.subTest(name=name, memory=memory):
                    for options in ([], ["--triangles", "100"]):
                        output = f"{len(options)}.ply"
                        code, _, err = run("decode", golden(name), output, "--memory", memory, *options)
                        self.assertEqual(code, 0, err)
                    every, few = (self.count_sides(scratch(f"{n}.ply")) for n in (0, 2))
                    self.assertLess(len(few), 0.7 * len(every))
                    self.assertEqual(max(few.values()), 2)
                    self.assertEqual(*(list(sides.values()).count(1) for sides in (every, few)))

    def count_sides(self, path):
        """How many triangles have each side."""
        sides = collections.Counter()
        for cell in read_ply(path)[1]:
            sides.update(frozenset((cell[n - 1], cell[n])) for n in range(3))
        return sides

    def read(self, path):
        if path.endswith(".ply"):
            points, cells = read_ply_points(path)
            return [tuple(points[n] for n in cell) for cell in cells]
        return read_stl_points(path) if path.endswith(".stl") else Glb(path).triangles()

    def count_border_points(self, triangles):
        sides = collections.Counter()
        for one in triangles:
            for n in range(3):
                sides[one[n], one[(n + 1) % 3]] += 1
        return len({p for a, b in sides if a != b and (b, a) not in sides for p in (a, b)})


class ExportsAreForOtherPrograms(unittest.TestCase):
    def list_finite(self):
        """The triangles of the file whose points are numbers, by the second reader."""
        surface = EdgeIndexFile(golden(NOT_NUMBERS)).read_surface()
        points = {where: struct.unpack("<3f", struct.pack("<3f", *surface.grid.place(point)))
                  for where, point in surface.points.items()}
        every = [tuple(points[corner] for corner in triangle) for triangle in surface.triangles]
        finite = [one for one in every if are_numbers(one)]
        self.assertLess(100, len(finite))
        self.assertLess(len(finite), len(every))
        return count_triangles(finite), len(every) - len(finite)

    def test_points_that_are_not_numbers_are_left_out_and_counted(self):
        expected, dropped = self.list_finite()
        for ending in ("ply", "stl", "obj", "glb", "vtp"):
            with self.subTest(ending=ending):
                code, out, err = run("decode", golden(NOT_NUMBERS), "o." + ending)
                self.assertEqual(code, 0, err)
                self.assertIn(f" {dropped} triangles with a point that is not a number", err)
                self.assertIn(f" {sum(expected.values())} triangles", out)
                found = self.read(scratch("o." + ending))
                self.assertEqual(count_triangles(found), expected)

    def read(self, path):
        if path.endswith((".ply", ".obj")):
            points, cells = (read_ply_points if path.endswith(".ply") else read_obj_points)(path)
            self.assertEqual({n for cell in cells for n in cell}, set(range(len(points))))
            points = [struct.unpack("<3f", struct.pack("<3f", *point)) for point in points]
            return [tuple(points[n] for n in cell) for cell in cells]
        if path.endswith(".vtp"):
            from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
            reader = vtkXMLPolyDataReader()
            reader.SetFileName(path)
            reader.Update()
            surface = reader.GetOutput()
            return [tuple(surface.GetPoint(surface.GetCell(n).GetPointId(corner)) for corner in range(3))
                    for n in range(surface.GetNumberOfCells())]
        return read_stl_points(path) if path.endswith(".stl") else Glb(path).triangles()

    STRAIGHT = 1, 0, 0, 0, 1, 0, 0, 0, 1
    MIRRORED = -1, 0, 0, 0, 1, 0, 0, 0, 1

    def test_corners_of_left_handed_grids_are_turned(self):
        for name in ("lossless-int16.eix", "bounded.eix", "smallest.eix"):
            place(name, (0, 0, 0), (1, 1, 1), self.STRAIGHT, "right.eix")
            place(name, (0, 0, 0), (1, 1, 1), self.MIRRORED, "left.eix")
            place(name, (0, 0, 0), (-1, 1, 1), self.STRAIGHT, "back.eix")
            for ending in ("ply", "stl", "obj", "glb", "vtp"):
                with self.subTest(name=name, ending=ending):
                    for grid in ("right", "left", "back"):
                        code, _, err = run("decode", grid + ".eix", f"{grid}.{ending}", "--quiet")
                        self.assertEqual(code, 0, err)
                    mirrored = [tuple((-x, y, z) for x, y, z in (a, c, b))
                                for a, b, c in self.read(scratch("right." + ending))]
                    for grid in ("left", "back"):
                        found = self.read(scratch(f"{grid}.{ending}"))
                        self.assertEqual(count_triangles(found), count_triangles(mirrored))

    def test_large_coordinates_keep_places_apart(self):
        name, origin, step = "lossless-int16.eix", (448000, 6000000, -2000), 0.05
        place(name, (0, 0, 0), (1, 1, 1), self.STRAIGHT, "near.eix")
        place(name, origin, (step,) * 3, self.STRAIGHT, "far.eix")
        for ending in ("ply", "obj", "stl", "glb", "vtp"):
            with self.subTest(ending=ending):
                self.assertEqual(run("decode", "near.eix", "near." + ending)[0], 0)
                code, _, err = run("decode", "far.eix", "far." + ending, "--quiet")
                self.assertEqual((code, "count from" in err), (0, ending == "stl"), err)
                first = (0, 0, 0)
                if ending in ("stl", "glb"):
                    extent = json.loads(run("info", "far.eix", "--json")[1])["grid"]["extent"]
                    first = [o + step * low for o, low in zip(origin, extent[::2])]
                if ending == "glb":
                    node = Glb(scratch("far.glb")).json["nodes"][0]["matrix"]
                    for value, expected in zip(node[12:], (first[0], first[2], -first[1], 1000)):
                        self.assertAlmostEqual(value * 1000, expected, places=3)
                near, far = self.read_places("near." + ending), self.read_places("far." + ending)
                self.assertEqual(len(near), len(far))
                for a, b in zip(near, far):
                    for n, f, o, add in zip(a, b, origin, first):
                        self.assertAlmostEqual(f + add, o + step * n, delta=step / 1000)

    def read_places(self, name):
        """The corners of all triangles, in their order, in all digits."""
        if name.endswith((".ply", ".obj")):
            points, cells = (read_ply_points if name.endswith(".ply") else read_obj_points)(scratch(name))
            return [points[n] for cell in cells for n in cell]
        return [corner for one in self.read(scratch(name)) for corner in one]

    def test_normals_of_glb_have_unit_length(self):
        surface = EdgeIndexFile(golden(NOT_NUMBERS)).read_surface()
        normals = list(surface.attributes[0].values())
        self.assertTrue(any(not any(normal) for normal in normals))
        self.assertTrue(any(math.isnan(normal[0]) for normal in normals))
        for options in ([], ["--compress"], ["--triangles", "500"]):
            with self.subTest(options=options):
                self.assertEqual(run("decode", golden(NOT_NUMBERS), "n.glb", *options)[0], 0)
                self.assertGreater(Glb(scratch("n.glb")).count_normals(), 100)  # checks each one

    def test_glb_is_in_metres_with_y_up(self):
        from vtkmodules.vtkIOGeometry import vtkGLTFReader
        told = json.loads(run("info", golden("unit.eix"), "--json")[1])["grid"]["unit"]
        units = {"m": 1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
        for name, options, unit in (
                (NOT_NUMBERS, [], 1e-3), (NOT_NUMBERS, ["--unit", "m"], 1), (NOT_NUMBERS, ["--unit", "um"], 1e-6),
                ("unit.eix", ["--isovalue", "400"], units[told]),
                ("unit.eix", ["--isovalue", "400", "--unit", "cm"], 1e-2)):
            self.assertEqual(run("decode", golden(name), "m.glb", *options)[0], 0)
            glb = Glb(scratch("m.glb"))
            points = [point for one in glb.triangles() for point in one]
            expected = []
            for axis, sign in ((0, 1), (2, 1), (1, -1)):  # x, z, -y
                ends = sorted(sign * unit * extreme(point[axis] for point in points) for extreme in (min, max))
                expected += ends
            reader = vtkGLTFReader()
            reader.SetFileName(scratch("m.glb"))
            reader.Update()
            blocks = reader.GetOutput().NewIterator()
            for found, value in zip(blocks.GetCurrentDataObject().GetBounds(), expected):
                self.assertAlmostEqual(found / unit, value / unit, places=2)

    def test_formats_that_cannot_tell_isovalues_apart_say_so(self):
        two = golden("lossless-int16.eix")
        for ending, tells in (("stl", True), ("ply", True), ("glb", False), ("obj", False)):
            with self.subTest(ending=ending):
                code, out, err = run("decode", two, "two." + ending)
                self.assertEqual((code, "2 isovalues" in err), (0, tells), err)
        triangles = []
        for isovalue in ("150.5", "400"):
            code, out, err = run("decode", two, isovalue + ".stl", "--isovalue", isovalue)
            self.assertEqual((code, "isovalues" in err), (0, False), err)
            triangles += read_stl_points(scratch(isovalue + ".stl"))
            self.assertEqual(len(Glb(self.decode(two, isovalue)).json["meshes"]), 1)
        self.assertEqual(count_triangles(triangles), count_triangles(read_stl_points(scratch("two.stl"))))
        code, _, err = run("decode", two, "no.stl", "--isovalue", "7")
        self.assertEqual(code, 1)
        self.assertIn("no such isovalue", err)

    def decode(self, path, isovalue):
        self.assertEqual(run("decode", path, "one.glb", "--isovalue", isovalue)[0], 0)
        return scratch("one.glb")


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
        self.assertIn("--triangles", self.check(
            "decode", golden("bounded.eix"), "out.vtp", "--triangles", "9"))
        self.assertIn("--compress", self.check("decode", golden("bounded.eix"), "out.ply", "--compress"))
        self.assertIn("--unit", self.check("decode", golden("bounded.eix"), "out.glb", "--unit", "ell"))
        self.assertIn("nowhere", self.check("decode", golden("bounded.eix"), "nowhere/out.ply", "--quiet"))
        self.check()
        self.check("paint", golden("bounded.eix"))
        self.check("info")
        with open(scratch("text.eix"), "w") as file:
            file.write("not a surface" * 40)
        self.assertIn("text.eix", self.check("verify", "text.eix"))

    def test_output_that_cannot_be_written(self):
        for arguments in (["info", golden("bounded.eix")], ["verify", golden("bounded.eix")], ["--help"]):
            with self.subTest(arguments=arguments), open("/dev/full", "w") as full:
                result = subprocess.run([TOOL, *arguments], stdout=full, stderr=subprocess.PIPE, text=True,
                                        cwd=SCRATCH, timeout=WAIT_SECONDS)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr.splitlines()[-1],
                                 "^edgeindex: cannot write to standard output: .")

    def test_output_that_ends_before_its_end(self):
        for ending in ("ply", "stl", "glb", "obj", "vtp"):
            with self.subTest(ending=ending):
                output = "full." + ending
                self.assertEqual(run("decode", golden("lossless-int16.eix"), output)[0], 0)
                with open(scratch(output), "rb") as file:
                    older = file.read()
                for size in (0, 1000, len(older) // 2, len(older) - 1):
                    code, _, err = run_limited(size, "decode", golden("lossless-int16.eix"), output, "--quiet")
                    self.assertEqual((code, err.count("\n")), (1, 1), err)
                    with open(scratch(output), "rb") as file:
                        self.assertEqual(file.read(), older)
                self.assertFalse([name for name in os.listdir(SCRATCH) if ".part" in name])

    def test_output_that_is_the_input(self):
        shutil.copy(golden("bounded.eix"), scratch("same.ply"))
        os.makedirs(scratch("deep"), exist_ok=True)
        os.symlink("same.ply", scratch("link.stl"))
        os.symlink("..", scratch("deep/up"))
        os.link(scratch("same.ply"), scratch("hard.obj"))
        shutil.copy(golden("bounded.eix"), scratch("one.vtp.part"))
        shutil.copy(golden("bounded.eix"), scratch("two.ply.part.faces"))
        for source, output in (
                ("same.ply", "same.ply"), ("same.ply", "./same.ply"), ("same.ply", scratch("same.ply")),
                ("same.ply", "deep/up/same.ply"), ("same.ply", "link.stl"), ("link.stl", "same.ply"),
                ("same.ply", "hard.obj"), ("one.vtp.part", "one.vtp"),
                ("two.ply.part.faces", "two.ply")):
            with self.subTest(source=source, output=output):
                self.assertIn("is the ", self.check("decode", source, output))
                self.assertEqual(run("verify", source)[0], 0)

    def test_help(self):
        self.assertEqual(run("--help")[0], 0)
        self.assertEqual(run("decode", "--help")[0], 0)
        self.assertEqual(run("--version")[0], 0)


shutil.rmtree(SCRATCH, ignore_errors=True)
os.makedirs(SCRATCH)
unittest.main(argv=[sys.argv[0], CLAIM], verbosity=2)
