#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads edge-index files: a second implementation of edge-index.md.

It was written from Documentation/formats alone, to prove that these texts tell all, and is meant to
be read beside them; it is slow. It checks every rule that it can see, and needs no more than
read_interval_tree.py does. The coders are in edge_index_*.py.

usage: read_edge_index.py FILE.eix ...  (decodes all of each, and tells what is there)
"""
import itertools
import math
import os
import re
import struct
import sys

from edge_index_attributes import Attribute
from edge_index_coding import PRIORS, PreviewMagnitudes, MixedMagnitudes, RangeDecoder, clamp
from edge_index_crossings import Crossings, EqualIntervals, MeanPrediction, PlanePrediction
from edge_index_planes import PlaneCrossings, Planes, PlaneSigns, PlaneValues
from edge_index_signs import MixedSigns, PreviewSigns
from edge_index_values import Values, make_domain, round_to_float32
from read_blocked_volume import TYPES
from read_interval_tree import FormatError, check, hash64, read_file

TYPE_NAMES = tuple(TYPES)
MODES = ("lossless", "bounded", "quantized", "smallest")
PROFILES = {0: "small", 3: "working"}
VERSIONS = (1, 2, 3)
UNITS = ("", "m", "dm", "cm", "mm", "um", "nm", "pm", "angstrom", "km", "inch", "foot")


class Bytes:
    """Takes one thing after the other from bytes."""

    def __init__(self, data, position=0):
        self.data, self.position = data, position

    def take(self, size):
        check(self.position + size <= len(self.data), "cut off")
        self.position += size
        return self.data[self.position - size:self.position]

    def unpack(self, layout):
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def number(self):
        value = 0
        for group in range(10):
            byte, = self.take(1)
            value |= (byte & 127) << 7 * group
            if byte < 128:
                check(value < 2**63, "a number that is too large")
                return value
        raise FormatError("a number of more than 10 bytes")

    def signed_number(self):
        value = self.number()
        return -(value >> 1) - 1 if value & 1 else value >> 1

    def text(self):
        size, = self.unpack("I")
        check(size <= 65535, "a text is too long")
        return self.take(size).decode()


class AttributeDescription:
    def __init__(self, source):
        value_type, self.components, self.normals, zero, self.maximum_error = source.unpack("BBBBd")
        check(value_type in (8, 9) and 1 <= self.components <= 64 and self.normals < 2 and zero == 0
              and self.maximum_error >= 0, "header: impossible attribute")
        self.bits = 32 if value_type == 8 else 64
        self.name = source.text()


class Header:
    def __init__(self, data):
        check(data[:8] == b"EIXcode\n", "is no edge-index file")
        source = Bytes(data, 8)
        self.version, size = source.unpack("II")
        check(self.version in VERSIONS, f"version {self.version} is unsupported")
        check(264 <= size <= min(2**26, len(data)), "header: impossible size")
        self.size = size
        self.hash = hash64(data[:size - 8])
        check(struct.unpack_from("<Q", data, size - 8)[0] == self.hash, "header: wrong checksum")
        source = Bytes(data[:size - 8], 16)
        self._read_fixed_part(source)
        self.isovalues = source.unpack(f"{self.isovalue_count}d")
        self.attributes = [AttributeDescription(source) for _ in range(self.attribute_count)]
        check(sum(attribute.components for attribute in self.attributes) <= 256,
              "header: too many components")
        self.array, self.source = source.text(), source.text()
        check(source.position == size - 8, "header: has another size")
        self.grid = Grid(self.extent, self.origin, self.spacing, self.direction)
        check(3 * math.prod(self.grid.dimensions) * max(1, len(self.isovalues)) <= 9.0e18,
              "header: too many vertices")

    def _read_fixed_part(self, source):
        type_number, mode, profile, self.quantization_bits, self.isovalue_count = \
            source.unpack("BBBBI")
        check(type_number < len(TYPE_NAMES) and mode < len(MODES) and profile in PROFILES
              and self.isovalue_count <= 65536, "header: impossible type, mode, profile or count")
        self.type_name, self.mode = TYPE_NAMES[type_number], MODES[mode]
        self.profile = PROFILES[profile]
        self.maximum_error, self.quantization_minimum, self.quantization_maximum = \
            source.unpack("3d")
        check(mode not in (1, 3) or 0 < self.maximum_error <= 0.5, "header: impossible error")
        check(mode != 2 or 2 <= self.quantization_bits <= 24
              and -math.inf < self.quantization_minimum < self.quantization_maximum < math.inf,
              "header: impossible quantization")
        self.extent = source.unpack("6q")
        check(all(-2**40 <= low <= high <= 2**40
                  for low, high in zip(self.extent[::2], self.extent[1::2])),
              "header: impossible extent")
        self.origin, self.spacing, self.direction = (source.unpack(n + "d") for n in "339")
        self.blocks, time, has_time, self.preview_level, unit, parts, self.attribute_count, \
            self.preview_error = source.unpack("QdBBBBId")
        self.closing, self.lacks_islands = parts & 3, parts >> 2 == 1
        check(unit < len(UNITS) and (unit == 0 or self.version > 1), "header: impossible unit")
        self.unit = UNITS[unit]
        check(parts <= (6 if self.version == 3 else 0) and self.closing < 3
              and (self.closing == 0 or self.attribute_count == 0
                   and (self.mode == "lossless" or not self.lacks_islands)),
              "header: impossible closing or islands")
        check(has_time < 2 and self.preview_level <= 6
              and self.attribute_count <= 256
              and (self.preview_level == 0 or 0 < self.preview_error <= 0.5),
              "header: impossible time, preview or count")
        self.time = time if has_time else None

    def make_preview_grid(self):
        step = 1 << self.preview_level
        extent = []
        for count in self.grid.dimensions:
            extent += [0, count - 1 >> self.preview_level]
        return Grid(extent, self.grid.place(self.extent[::2]),
                    [spacing * step for spacing in self.spacing], self.direction)


class Grid:
    def __init__(self, extent, origin, spacing, direction):
        self.first = extent[::2]
        self.dimensions = [high - low + 1 for low, high in zip(extent[::2], extent[1::2])]
        self.origin, self.spacing, self.direction = origin, spacing, direction
        a, b, c, d, e, f, g, h, i = direction
        self.mirrored = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0
        self.left_handed = self.mirrored != (sum(step < 0 for step in spacing) % 2 == 1)
        self.greatest_bound = max(abs(bound) for bound in extent)

    def place(self, coordinates):
        """A point in the world, of its structured coordinates."""
        point = []
        for n, origin in enumerate(self.origin):
            row = [d * s for d, s in zip(self.direction[3 * n:3 * n + 3], self.spacing)]
            point.append(row[0] * coordinates[0] + row[1] * coordinates[1]
                         + row[2] * coordinates[2] + origin)
        return point

    def find_error_left(self, maximum_error):
        """What the rounding of coordinates leaves of an error."""
        power = 1 << (1 + self.greatest_bound).bit_length()
        left = maximum_error - power * 2.0**-25 - 2.0**-20
        check(left > 0, "the maximum error is too small for the extent")
        check(math.ceil(0.5 / left) <= 2**20, "the maximum error is too small")
        return left

    def count_intervals(self, maximum_error):
        return math.ceil(0.5 / self.find_error_left(maximum_error))


class Record:
    """What the header of a record and the directory say of a block."""

    def __init__(self, source, header):
        self.isovalue = source.number()
        self.first = [source.number() for _ in range(3)]
        self.cells = source.unpack("3B")
        self.lattice = [source.signed_number() for _ in range(3)]
        self.points = source.number()
        self.coding, = source.unpack("B")
        self.codes_crossings, self.some_missing, self.preview, self.lacks_islands = (
            bool(self.coding & bit) for bit in (1, 2, 4, 8))
        self.kept = []  # of its islands, if it lacks some
        grid = header.make_preview_grid() if self.preview else header.grid
        check(self.isovalue < len(header.isovalues) and self.coding < (16 if header.lacks_islands else 8)
              and (self.points > 0 or header.closing > 0 and not self.preview)
              and all(1 <= n <= 64 for n in self.cells)
              and all(f + n < d for f, n, d in zip(self.first, self.cells, grid.dimensions))
              and all(abs(n) <= 2**34 for n in self.lattice), "record: impossible block")
        check(self.codes_crossings or not self.some_missing and not self.preview
              and header.mode != "bounded", "record: impossible coding")
        check(not self.preview or header.preview_level > 0, "record: there is no preview")
        check(self.preview or not self.codes_crossings or header.mode in ("bounded", "smallest"),
              "record: impossible coding")

    def read_kept(self, source):
        islands = source.number()
        bits = int.from_bytes(source.take(-(-islands // 8)), "little")
        self.kept = [bool(bits >> n & 1) for n in range(islands)]
        check(bits >> islands == 0 and any(self.kept) and not all(self.kept),
              "record: impossible islands")

    def list_fields(self):
        return (self.isovalue, self.first, self.cells, self.lattice, self.points, self.coding)


class Block:
    """Vertices and edges of a block, by x, y, z counted from its first vertex.

    Slices of signs come one after the other. Beyond the block signs repeat, but for rows before the
    first, which repeat the first row of the slice before.
    """

    def __init__(self, cells):
        self.nx, self.ny, self.nz = (n + 1 for n in cells)
        self.slices = []
        # Crossed edges that begin and end at a vertex: 1 along x, 2 along y, 4 along z.
        self.begins, self.ends = {}, {}

    def add_slice(self, rows):
        z = len(self.slices)
        self.slices.append(rows)
        for y, row in enumerate(rows):
            for x, sign in enumerate(row):
                if x > 0 and row[x - 1] != sign:
                    self._add_edge((x - 1, y, z), (x, y, z), 1)
                if y > 0 and rows[y - 1][x] != sign:
                    self._add_edge((x, y - 1, z), (x, y, z), 2)
                if z > 0 and self.slices[z - 1][y][x] != sign:
                    self._add_edge((x, y, z - 1), (x, y, z), 4)

    def _add_edge(self, first, last, bit):
        self.begins[first] = self.begins.get(first, 0) | bit
        self.ends[last] = self.ends.get(last, 0) | bit

    def is_inside(self, x, y, z):
        z = min(max(z, 0), self.nz - 1)
        if y < 0:
            if z == 0:
                return 0
            y, z = 0, z - 1
        return self.slices[z][min(y, self.ny - 1)][min(max(x, 0), self.nx - 1)]

    def begin_bits(self, x, y, z):
        return self.begins.get((x, y, z), 0)

    def end_bits(self, x, y, z):
        return self.ends.get((x, y, z), 0)

    def is_crossed(self, x, y, z, axis):
        """Whether the edge that begins at a vertex is there and crossed."""
        return self.begin_bits(x, y, z) >> axis & 1

    def is_relevant(self, x, y, z):
        return (x, y, z) in self.begins or (x, y, z) in self.ends

    def is_relevant_within(self, x, y, z):
        """Whether a crossed edge within slice z ends at the vertex."""
        return (self.begin_bits(x, y, z) | self.end_bits(x, y, z)) & 3

    def list_edges(self, z):
        """Crossed edges that begin in slice z, as (x, y, axis), in the order of the code."""
        return [(x, y, axis) for y in range(self.ny) for axis in range(3)
                for x in range(self.nx) if self.is_crossed(x, y, z, axis)]


def make_signs(is_preview, planes):
    if planes:
        return PlaneSigns(planes)
    return PreviewSigns() if is_preview else MixedSigns()


def make_values(domain, planes):
    return PlaneValues(planes, domain) if planes else Values(domain, MixedMagnitudes(PRIORS.values))


def make_crossings(is_preview, grid, maximum_error, some_missing, planes):
    cut = EqualIntervals(grid.count_intervals(maximum_error))
    if planes:
        return PlaneCrossings(planes, cut, some_missing)
    if is_preview:
        return Crossings(cut, some_missing, PreviewMagnitudes(PRIORS.crossings), MeanPrediction())
    return Crossings(cut, some_missing, MixedMagnitudes(PRIORS.crossings), PlanePrediction())


class DecodedBlock:
    """A block's signs, parameters of crossings by (x, y, z, axis), and attributes alike."""

    def __init__(self, header, record, scale, code):
        self.block = block = Block(record.cells)
        self.parameters = {}
        self.attributes = [{} for _ in header.attributes] if not record.preview else []
        planes = None
        if header.profile == "working" and not record.preview:
            source = Bytes(code)
            planes = Planes(source, block)
            code = code[source.position:]
        decoder = RangeDecoder(code)
        attributes = [Attribute(decoder, description) for description in header.attributes
                      ] if not record.preview else []
        signs = make_signs(record.preview, planes)
        isovalue = header.isovalues[record.isovalue]
        if record.codes_crossings:
            grid = header.make_preview_grid() if record.preview else header.grid
            error = header.preview_error if record.preview else header.maximum_error
            geometry = make_crossings(
                record.preview, grid, error, record.some_missing, planes)
        else:
            geometry = make_values(make_domain(header, isovalue, scale), planes)
        values = {}
        for z in range(block.nz):
            while len(block.slices) < min(z + 2, block.nz):
                block.add_slice(signs.decode_slice(decoder, block.nx, block.ny))
            found = geometry.decode_slice(decoder, block, z)
            if record.codes_crossings:
                self._add_crossings(found, geometry.cut, z)
            else:
                values.update({(x, y, z): value for (x, y), value in found.items()})
            for number, attribute in enumerate(attributes):
                found = attribute.decode_slice(decoder, block, z)
                self.attributes[number].update(
                    {(x, y, z, axis): value for (x, y, axis), value in found.items()})
        decoder.check_end()
        if planes:
            planes.check_end()
        if not record.codes_crossings:
            self._add_values(
                values, isovalue, "float32" if header.mode == "quantized" else header.type_name)
            if header.version > 1 and header.mode == "smallest":
                self._round_on_faces(make_crossings(
                    False, header.grid, header.maximum_error, False, None).cut)
        check(record.lacks_islands or len(self.parameters) == record.points,
              "record: another number of points")

    def _add_crossings(self, found, cut, z):
        for (x, y, axis), interval in found.items():
            self.parameters[x, y, z, axis] = math.nan if interval is None else round_to_float32(
                cut.find_parameter(interval))

    def _round_on_faces(self, cut):
        last = (self.block.nx - 1, self.block.ny - 1, self.block.nz - 1)
        for (*vertex, axis), t in self.parameters.items():
            on_face = any(n != axis and place in (0, last[n]) for n, place in enumerate(vertex))
            if on_face and not math.isnan(t):
                self.parameters[(*vertex, axis)] = round_to_float32(
                    cut.find_parameter(cut.find_interval(t)))

    def _add_values(self, values, isovalue, value_type):
        for z in range(self.block.nz):
            for x, y, axis in self.block.list_edges(z):
                self.parameters[x, y, z, axis] = find_parameter(
                    isovalue, values[x, y, z],
                    values[x + (axis == 0), y + (axis == 1), z + (axis == 2)], value_type)


def find_parameter(isovalue, v0, v1, type_name):
    """Where on the edge from v0 to v1 the isovalue is, by the rules of IEEE 754."""
    difference = float(v1 - v0)
    if type_name == "float32":
        difference = round_to_float32(difference)
    t = (isovalue - float(v0)) / difference
    return clamp(t, 0.0, 1.0) if type_name in ("int64", "uint64") else t


class EdgeIndexFile:
    def __init__(self, path):
        self.path = path
        self.bytes = read_file(path)
        self.header = Header(self.bytes)
        self.complete = self._read_directory()
        if not self.complete:
            self._find_records()

    def _read_directory(self):
        """Whether trailer and directory are right; they tell where records are."""
        data = self.bytes
        trailer = data[-32:]
        if len(data) < self.header.size + 32 or trailer[24:] != b"EIXend.\n":
            return False
        position, size, found = struct.unpack_from("<3Q", trailer)
        if (found != hash64(trailer[:16], self.header.hash) or size < 8
                or position + size != len(data) - 32):
            return False
        directory = data[position:position + size]
        found, = struct.unpack_from("<Q", directory, size - 8)
        if found != hash64(directory[:-8], self.header.hash):
            return False
        source = Bytes(directory[:-8])
        check(source.number() == 0, "directory: does not begin with 0")
        self.records, begin = [], self.header.size
        for _ in range(source.number()):
            whole = source.number()
            self.records.append((begin, begin + whole, Record(source, self.header)))
            begin += whole
        check(source.position == size - 8 and begin == position, "directory: has another size")
        return True

    def _find_records(self):
        """Of a file that was cut off: the records that are whole."""
        self.records, begin = [], self.header.size
        try:
            while True:
                source = Bytes(self.bytes, begin)
                size = source.number()
                if size < 4:
                    return
                body = Bytes(source.take(size))
                self._check_hash(body.data)
                self.records.append((begin, source.position, Record(body, self.header)))
                begin = source.position
        except FormatError:
            return

    @staticmethod
    def _check_hash(body):
        check(struct.unpack("<I", body[-4:])[0] == hash64(body[:-4]) & 0xffffffff,
              "record: wrong checksum")

    def decode(self, number):
        begin, end, told = self.records[number]
        source = Bytes(self.bytes[:end], begin)
        size = source.number()
        check(size >= 4 and source.position + size == end, "record: another size")
        body = source.take(size)
        self._check_hash(body)
        body = Bytes(body[:-4])
        record = Record(body, self.header)
        check(record.list_fields() == told.list_fields(), "record: not what the directory tells")
        scale = 0 if record.codes_crossings else body.signed_number()
        check(abs(scale) <= 1100, "record: impossible scale")
        if record.lacks_islands:
            record.read_kept(body)
        return record, DecodedBlock(self.header, record, scale, body.data[body.position:])

    def read_surface(self, preview=False):
        surface = Surface(self.header, preview)
        for number, (_, _, record) in enumerate(self.records):
            if record.preview == preview:
                block = Surface(self.header, preview)
                block.add(*self.decode(number))
                surface.append(block)
        return surface


def read_cases():
    """The 256 cases of marching cubes, as triples of a cell's edges.

    Bit x + 2 y + 4 z of a case tells whether the corner (x, y, z) is inside.
    """
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)),
                        "../../Documentation/formats/marching-cubes-cases.txt")
    lines = re.findall(r"^\d+:(.*)$", read_file(path).decode(), re.MULTILINE)
    check(len(lines) == 256, f"{path}: has other cases")
    return [[tuple(map(int, triangle.split())) for triangle in line.split(",") if triangle.strip()]
            for line in lines]


# Edges of a cell: the first vertex, and the axis; those along x first, then y, then z.
CELL_EDGES = (*(((0, y, z), 0) for z in (0, 1) for y in (0, 1)),
              *(((x, 0, z), 1) for z in (0, 1) for x in (0, 1)),
              *(((x, y, 0), 2) for y in (0, 1) for x in (0, 1)))


class Surface:
    """Points by their global ids, and triangles as triples of these."""

    CASES = read_cases()

    def __init__(self, header, preview):
        self.grid = header.make_preview_grid() if preview else header.grid
        self.vertices = math.prod(self.grid.dimensions)
        self.points = {}      # global id: the structured coordinates, rounded to float32
        self.isovalues = {}   # global id: isovalue
        self.attributes = [{} for _ in header.attributes]
        self.triangles = []
        self.header = header
        self.closing = 0 if preview else header.closing

    def add(self, record, decoded):
        (self.add_closed if self.closing else self.add_open)(record, decoded)
        if record.lacks_islands:
            self.keep_islands(record)

    def append(self, block):
        self.points.update(block.points)
        self.isovalues.update(block.isovalues)
        self.triangles += block.triangles
        for mine, other in zip(self.attributes, block.attributes):
            mine.update(other)

    def keep_islands(self, record):
        """Of a block that is here alone."""
        island_of = {}  # of each point, the set of points of its island
        for triangle in self.triangles:
            parts = {id(part): part for part in
                     (island_of.setdefault(corner, {corner}) for corner in triangle)}
            largest = max(parts.values(), key=len)
            for part in parts.values():
                if part is not largest:
                    largest |= part
                    island_of.update(dict.fromkeys(part, largest))
        islands = sorted({id(part): part for part in island_of.values()}.values(), key=min)
        check(len(islands) == len(record.kept), "record: another number of islands")
        kept = set().union(*(part for part, is_kept in zip(islands, record.kept) if is_kept))
        check(len(kept) == record.points, "record: another number of points")
        self.triangles = [triangle for triangle in self.triangles if triangle[0] in kept]
        self.points = {where: point for where, point in self.points.items() if where in kept}

    def add_closed(self, record, decoded):
        """With the layer of vertices around the grid, and points on vertices merged."""
        beyond = self.closing - 1
        sizes = [n + 2 for n in self.grid.dimensions]
        numbers, all_vertices = len(self.header.isovalues), math.prod(sizes)

        def is_within(vertex):
            return all(0 <= f + n < d for f, n, d in zip(record.first, vertex, self.grid.dimensions))

        def is_inside(vertex):
            x, y, z = vertex
            return decoded.block.slices[z][y][x] if is_within(vertex) else beyond

        def name_vertex(vertex):
            i, j, k = (f + n + 1 for f, n in zip(record.first, vertex))
            return i + sizes[0] * (j + sizes[1] * k)

        def add_point(vertex, axis):
            """The global id of the point of a crossed edge."""
            ends = [vertex, tuple(n + (a == axis) for a, n in enumerate(vertex))]
            places = [[round_to_float32(float(f + n + low)) for f, n, low in
                       zip(record.first, end, self.grid.first)] for end in ends]
            inner = [number for number in (0, 1) if is_within(ends[number])]
            place = places[inner[0]]
            if len(inner) == 2:
                place = list(places[0])
                place[axis] = round_to_float32(float(record.first[axis] + vertex[axis])
                                               + decoded.parameters[(*vertex, axis)] + self.grid.first[axis])
            where = 3 * name_vertex(vertex) + axis + record.isovalue * 3 * all_vertices
            for number in inner:
                if place == places[number]:
                    where = name_vertex(ends[number]) + (3 * numbers + record.isovalue) * all_vertices
            self.points[where] = place
            self.isovalues[where] = self.header.isovalues[record.isovalue]
            return where

        cells = [range(-1 if f == 0 else 0, n + (f + n + 1 == d)) for f, n, d in
                 zip(record.first, record.cells, self.grid.dimensions)]
        turned = self.grid.left_handed != (beyond == 1)
        for z, y, x in itertools.product(*cells[::-1]):
            case = sum(is_inside((x + (n & 1), y + (n >> 1 & 1), z + (n >> 2))) << n for n in range(8))
            for triangle in self.CASES[case]:
                edges = [CELL_EDGES[triangle[corner]] for corner in ((0, 2, 1) if turned else (0, 1, 2))]
                corners = tuple(add_point((x + i, y + j, z + k), axis) for (i, j, k), axis in edges)
                if len(set(corners)) == 3:
                    self.triangles.append(corners)

    def find_id(self, record, x, y, z, axis):
        width, height, _ = self.grid.dimensions
        i, j, k = (f + n for f, n in zip(record.first, (x, y, z)))
        return 3 * (i + width * (j + height * k)) + axis + record.isovalue * 3 * self.vertices

    def add_open(self, record, decoded):
        for (x, y, z, axis), t in decoded.parameters.items():
            where = self.find_id(record, x, y, z, axis)
            place = [float(first + n) for first, n in zip(record.first, (x, y, z))]
            place[axis] += t
            self.points[where] = [round_to_float32(p + low)
                                  for p, low in zip(place, self.grid.first)]
            self.isovalues[where] = self.header.isovalues[record.isovalue]
            for mine, found, what in zip(self.attributes, decoded.attributes, self.header.attributes):
                turned = what.normals and self.grid.mirrored
                mine[where] = [-n for n in found[x, y, z, axis]] if turned else found[x, y, z, axis]
        slices = decoded.block.slices
        for z, y, x in itertools.product(*(range(n) for n in record.cells[::-1])):
            rows = (slices[z][y], slices[z][y + 1], slices[z + 1][y], slices[z + 1][y + 1])
            case = sum((row[x] | row[x + 1] << 1) << 2 * n for n, row in enumerate(rows))
            for triangle in self.CASES[case]:
                order = (0, 2, 1) if self.grid.left_handed else (0, 1, 2)
                edges = [CELL_EDGES[triangle[corner]] for corner in order]
                self.triangles.append(tuple(self.find_id(record, x + i, y + j, z + k, axis)
                                            for (i, j, k), axis in edges))


def main(paths):
    for path in paths:
        try:
            file = EdgeIndexFile(path)
            surface, preview = file.read_surface(), file.read_surface(True)
        except FormatError as error:
            sys.exit(f"{path}: {error}")
        header = file.header
        print(f"{path}: version {header.version}, {header.type_name}, {header.mode}, "
              f"{header.profile}; {len(file.records)} records; {len(surface.points)} points, "
              f"{len(surface.triangles)} triangles; preview: {len(preview.points)} points, "
              f"{len(preview.triangles)} triangles")


if __name__ == "__main__":
    main(sys.argv[1:])
