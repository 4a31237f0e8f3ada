#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares what the second reader finds in edge-index files with what `edgeindex decode` writes.

usage: check_edge_index_files.py EDGEINDEX SCRATCH FOLDER ..., EDGEINDEX being the project's tool
"""
import base64
import glob
import math
import os
import random
import struct
import subprocess
import sys
import xml.etree.ElementTree
import zlib

from read_edge_index import EdgeIndexFile
from read_interval_tree import FormatError, check, read_file

CODES = {"Float32": "f", "Float64": "d", "Int32": "i", "Int64": "q", "UInt8": "B"}


class PolyData:
    """The point arrays and triangles of a .vtp file with appended, compressed data."""

    def __init__(self, path):
        root = xml.etree.ElementTree.fromstring(read_file(path))
        appended = root.find("AppendedData").text.strip()[1:]
        piece = root.find("PolyData/Piece")
        self.points = self._read(piece.find("Points/DataArray"), appended)
        self.arrays = {element.get("Name"): self._read(element, appended)
                       for element in piece.findall("PointData/DataArray")}
        corners = next(self._read(element, appended) for element in piece.findall("Polys/DataArray")
                       if element.get("Name") == "connectivity")
        self.triangles = [corners[n:n + 3] for n in range(0, len(corners), 3)]

    @staticmethod
    def _read(element, appended):
        text = appended[int(element.get("offset")):]
        count, = struct.unpack("<I", base64.b64decode(text[:8])[:4])
        size = 4 * (3 + count)
        end = -(-size // 3) * 4
        sizes = struct.unpack(f"<{count}I", base64.b64decode(text[:end])[12:size])
        blocks, data = base64.b64decode(text[end:end + -(-sum(sizes) // 3) * 4]), b""
        for block_size in sizes:
            data += zlib.decompress(blocks[:block_size])
            blocks = blocks[block_size:]
        code = CODES[element.get("type")]
        values = struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data)
        width = int(element.get("NumberOfComponents") or 1)
        return values if width == 1 else [values[n:n + width] for n in range(0, len(values), width)]


def pack(numbers, width=32):
    """Numbers as bits, so that -0.0 is not 0.0; every NaN is the same."""
    numbers = [math.nan if math.isnan(number) else number for number in numbers]
    return struct.pack(f"<{len(numbers)}{'f' if width == 32 else 'd'}", *numbers)


def turn(triangle):
    """The same triangle with its least corner first."""
    first = triangle.index(min(triangle))
    return triangle[first:] + triangle[:first]


def drop_not_finite(surface):
    """What `edgeindex decode` leaves out: triangles with points that are no numbers, then unused points."""
    surface.triangles = [triangle for triangle in surface.triangles
                         if all(map(math.isfinite, (n for where in triangle
                                                    for n in surface.grid.place(surface.points[where]))))]
    used = {where for triangle in surface.triangles for where in triangle}
    surface.points = {where: point for where, point in surface.points.items() if where in used}


def check_surface(name, header, surface, told):
    drop_not_finite(surface)
    ids = told.arrays["GlobalIds"]
    check(sorted(ids) == sorted(surface.points), f"{name}: other global ids")
    for where, point, isovalue in zip(ids, told.points, told.arrays[header.array]):
        mine = surface.grid.place(surface.points[where])
        check(pack(mine) == pack(point), f"{name}: point {where} is {point}, read {mine}")
        check(isovalue == surface.isovalues[where], f"{name}: isovalue of {where}")
    mine = sorted(turn(triangle) for triangle in surface.triangles)
    check(mine == sorted(turn(tuple(ids[n] for n in triangle)) for triangle in told.triangles),
          f"{name}: other triangles")
    for description, values in zip(header.attributes, surface.attributes):
        for where, value in zip(ids, told.arrays[description.name]) if values else ():
            value = value if description.components > 1 else (value,)
            check(pack(value, description.bits) == pack(values[where], description.bits),
                  f"{name}: {description.name} of {where} is {value}, read {values[where]}")


def check_file(tool, scratch, path):
    file, parts = EdgeIndexFile(path), []
    check(file.complete, f"{path}: trailer or directory")
    for preview in (False, True) if file.header.preview_level else (False,):
        output = os.path.join(scratch, os.path.basename(path)[:-4] + ".vtp")
        subprocess.run([tool, "decode", path, output, "--quiet"] + ["--preview"] * preview,
                       check=True)
        surface = file.read_surface(preview)
        name = path + (" (preview)" if preview else "")
        check_surface(name, file.header, surface, PolyData(output))
        parts.append(f"{len(surface.points)} points")
    print(f"{path}: {' and '.join(parts)}: as decoded by {os.path.basename(tool)}")


def check_damage(scratch, path):
    """A file that is cut off has the records before; a flipped bit is noticed."""
    good, whole = read_file(path), EdgeIndexFile(path)
    copy = os.path.join(scratch, "damaged.eix")

    def write(data):
        with open(copy, "wb") as file:
            file.write(data)
        return copy

    for begin, end, _ in random.sample(whole.records, min(len(whole.records), 3)):
        cut = EdgeIndexFile(write(good[:random.randrange(begin, end)]))
        check(not cut.complete, f"{copy}: a file that was cut off is taken for whole")
        check([record[:2] for record in cut.records]
              == [record[:2] for record in whole.records if record[1] <= begin], f"{copy}: records")
    for _ in range(40):
        damaged, place = bytearray(good), random.randrange(len(good))
        damaged[place] ^= 1 << random.randrange(8)
        try:
            file = EdgeIndexFile(write(damaged))
            for number, (begin, end, _) in enumerate(file.records):
                if begin <= place < end:
                    file.decode(number)
        except FormatError:
            continue
        check(not file.complete, f"{copy}: a flipped bit at {place} goes unnoticed")


def main(tool, scratch, folders):
    random.seed(1)
    os.makedirs(scratch, exist_ok=True)
    for folder in folders:
        paths = sorted(glob.glob(os.path.join(folder, "*.eix")))
        check(paths, f"{folder}: no edge-index files")
        for path in paths:
            check_file(tool, scratch, path)
        check_damage(scratch, paths[0])


if __name__ == "__main__":
    try:
        main(sys.argv[1], sys.argv[2], sys.argv[3:])
    except FormatError as error:
        sys.exit(str(error))
