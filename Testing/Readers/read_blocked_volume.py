#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads blocked volumes: a second implementation of blocked-volume.md.

It was written from Documentation/formats alone, to prove that these texts tell all. It checks every
rule that it can see, and needs no more than read_interval_tree.py does.
"""
import argparse
import array
import json
import math
import os
import struct
import sys

from read_interval_tree import FormatError, IntervalTree, PagedFile, check, hash64, read_file
from read_segment import decode_segment


# By name of the type: code of array and struct, signed integer, bits.
TYPES = {"int8": ("b", True, 8), "uint8": ("B", False, 8), "int16": ("h", True, 16),
         "uint16": ("H", False, 16), "int32": ("i", True, 32), "uint32": ("I", False, 32),
         "int64": ("q", True, 64), "uint64": ("Q", False, 64),
         "float32": ("f", None, 32), "float64": ("d", None, 64)}


def find_stores(path):
    """The folder of a volume's stores."""
    shown = path + ".stores"
    return shown if os.path.exists(shown) else os.path.join(os.path.dirname(path), f".{os.path.basename(shown)}")


def make_key(value, type_name):
    code, signed, bits = TYPES[type_name]
    if signed is not None:
        least = -(1 << (bits - 1)) if signed else 0
        return min(value - least + 1, 2**64 - 1)
    if math.isnan(value):
        return 0
    raw = struct.unpack("<" + {32: "I", 64: "Q"}[bits], struct.pack("<" + code, value + 0.0))[0]
    sign = 1 << (bits - 1)
    return raw ^ (2 * sign - 1) if raw & sign else raw | sign


def make_threshold_key(isovalue, type_name):
    """The key of the least value of the type that is >= isovalue, or None."""
    _, signed, bits = TYPES[type_name]
    if math.isnan(isovalue):
        return None
    if signed is not None:
        least = -(1 << (bits - 1)) if signed else 0
        end = least + (1 << bits)
        if isovalue >= end or math.isinf(isovalue):
            return make_key(least, type_name) if isovalue < 0 else None
        ceiling = max(least, math.ceil(isovalue))
        return make_key(ceiling, type_name) if ceiling < end else None
    if bits == 64 or math.isinf(isovalue):
        return make_key(isovalue, type_name)
    try:
        nearest = struct.unpack("<f", struct.pack("<f", isovalue))[0]
    except OverflowError:  # beyond the range of float32
        nearest = math.copysign(math.inf, isovalue)
    # Keys of successive floats are successive, -0.0 and 0.0 apart, which are one value.
    key = make_key(nearest, type_name)
    negative_zero = 0x7fffffff
    return key + (2 if key + 1 == negative_zero else 1) if nearest < isovalue else key


def read_document(path, format_name):
    content = read_file(path)
    try:
        document = json.loads(content.decode(),
                              parse_constant=lambda name: check(False, f"{path}: {name}"))
    except ValueError as error:
        raise FormatError(f"{path}: {error}") from error
    check(isinstance(document, dict) and document.get("format") == format_name,
          f"{path}: is no {format_name}")
    check(document.get("formatVersion") == 1, f"{path}: another version")
    covered = content[:content.rfind(b'"checksum"')]
    found = f"{hash64(covered):016x}"
    check(document.get("checksum") == found, f"{path}: the checksum is {found}")
    return document


def find_magnitude(values):
    total = 0.0
    for value in values:
        total += float(value) * float(value)
    return math.sqrt(total)


def list_variables(arrays):
    """The type and the tree's name of each variable: all components, then all magnitudes."""
    components, magnitudes = [], []
    for number, description in enumerate(arrays):
        name, count = f"array-{number}", description["components"]
        ends = [".tree"] if count == 1 else [f"-component-{n}.tree" for n in range(count)]
        components += [(description["type"], name + end) for end in ends]
        if count > 1:
            magnitudes.append(("float64", name + "-magnitude.tree"))
    return components + magnitudes


class Store:
    def __init__(self, volume, folder, description):
        self.volume = volume
        self.path = os.path.join(folder, "blocks")
        self.records = read_file(self.path)
        check(len(self.records) == description["bytes"], f"{self.path}: wrong size")
        self.checksum = description["checksum"]
        self.directory = PagedFile(os.path.join(folder, "directory"), b"BLOCKDIR")
        self.segments = len(volume.components) * volume.levels
        area = self.directory.client_area
        self.count, segments, zero, identity = struct.unpack_from("<QIIQ", area)
        self.per_page = (self.directory.page_size - 8) // (16 + 4 * self.segments)
        check(self.count == description["blocks"] and segments == self.segments
              and zero == 0 and identity == int(self.checksum, 16) and not any(area[24:])
              and self.directory.page_count == 1 + -(-self.count // self.per_page),
              f"{self.directory.path}: does not fit the header")
        self.trees = [IntervalTree(os.path.join(folder, name)) for _, name in volume.variables]
        check(all(tree.count == self.count for tree in self.trees), f"{folder}: a tree's count")
        sum_of_store = struct.pack("<Q", int(self.checksum, 16))
        check(all(tree.identity == hash64(sum_of_store, variable)
                  for variable, tree in enumerate(self.trees)), f"{folder}: another store's tree")

        if "seals" in description:
            seals = description["seals"]
            files = [self.directory] + [tree.file for tree in self.trees]
            check(len(seals) == 16 * len(files), f"{folder}: another number of seals")
            for number, file in enumerate(files):
                file.check_seal(int(seals[16 * number:16 * (number + 1)], 16))

    def find_block(self, ordinal):
        """Index, offset, and the segments' lengths of a block."""
        page, entry = divmod(ordinal, self.per_page)
        values = struct.unpack_from(f"<QQ{self.segments}I", self.directory.read(1 + page),
                                    entry * (16 + 4 * self.segments))
        block, offset, lengths = values[0], values[1], values[2:]
        stored = 16 * self.segments + (0 if self.volume.is_in_place else sum(lengths))
        check(block < self.volume.block_count
              and offset % (16 if self.volume.is_in_place else 4096) == 0
              and offset + stored <= len(self.records),
              f"{self.directory.path}: impossible entry {ordinal}")
        return block, offset, lengths

    def read_source(self, ordinal):
        """The same as read_segments() if the samples are in the source."""
        block, offset, lengths = self.find_block(ordinal)
        samples = {}
        for where, stored in enumerate(lengths):
            name = f"{self.path}: block {block}, component {where}"
            header = self.records[offset + 16 * where:offset + 16 * where + 16]
            checksum, own, codec, predictor, _ = struct.unpack("<QIBBH", header)
            check((own, codec, predictor) == (stored, 0, 0), f"{name}: length or codec")
            samples[where, 0] = self.volume.cut_source(where, block)
            payload = samples[where, 0].tobytes()
            seed = hash64(struct.pack("<QII", block, where, 0))
            check(len(payload) == stored and checksum == hash64(header[8:] + payload, seed),
                  f"{name}: the source has other samples")
        return block, samples

    def read_segments(self, ordinal):
        """The block's index, and checked samples by component and level."""
        if self.volume.is_in_place:
            return self.read_source(ordinal)
        block, offset, lengths = self.find_block(ordinal)
        samples = {}
        for number, stored in enumerate(lengths):
            where, level = divmod(number, self.volume.levels)
            level = self.volume.levels - 1 - level
            name = f"{self.path}: block {block}, component {where}, level {level}"
            checksum, own, codec, predictor, _ = struct.unpack_from("<QIBBH", self.records, offset)
            seed = hash64(struct.pack("<QII", block, where, level))
            check(checksum == hash64(self.records[offset + 8:offset + 16 + stored], seed),
                  f"{name}: wrong checksum")
            check(own == stored and (codec != 0 or predictor == 0), f"{name}: length or codec")
            payload = self.records[offset + 16:offset + 16 + stored]
            type_name = self.volume.components[where]
            typecode = TYPES[type_name][0]
            if codec == 0:
                samples[where, level] = array.array(typecode)
                samples[where, level].frombytes(payload)
            else:
                samples[where, level] = decode_segment(
                    payload, codec, predictor, typecode, type_name[0],
                    self.volume.list_vertices(block, level),
                    lambda: (self.volume.decode(block, samples, where, level + 1),
                             self.volume.find_box(block, level + 1, True)))
            offset += 16 + stored
        check(not any(self.records[offset:-(-offset // 4096) * 4096]), f"{name}: no zeros behind")
        return block, samples

    def verify_magnitudes(self, ordinal, block, samples):
        """Checks the trees' intervals of magnitudes, which are not stored themselves."""
        volume, first = self.volume, 0
        trees = iter(self.trees[len(volume.components):])
        for description in volume.arrays:
            count = description["components"]
            if count > 1:
                keys = [make_key(find_magnitude(values), "float64") for values in zip(*(
                    volume.list_own(block, samples, first + n) for n in range(count)))]
                tree = next(trees)
                check((min(keys), max(keys), ordinal) in tree.find(min(keys), min(keys)),
                      f"{tree.file.path}: the interval of block {block}")
            first += count

    def verify(self):
        """Checks everything; returns the block indices by ordinal."""
        for file in [self.directory] + [tree.file for tree in self.trees]:
            for page in range(file.page_count):
                file.read(page)
        for tree in self.trees:
            payloads = sorted(r[2] for r in tree.find(0, 2**64 - 1))
            check(payloads == list(range(self.count)), f"{tree.file.path}: not all ordinals once")
        blocks, checksum, used = [], 0, 0
        for ordinal in range(self.count):
            block, samples = self.read_segments(ordinal)
            self.verify_magnitudes(ordinal, block, samples)
            blocks.append(block)
            _, offset, lengths = self.find_block(ordinal)
            sums = [checksum]
            for stored in lengths:
                sums += struct.unpack_from("<Q", self.records, offset)
                offset += 16 if self.volume.is_in_place else 16 + stored
            checksum = hash64(struct.pack(f"<{len(sums)}Q", *sums))
            used += 16 * self.segments if self.volume.is_in_place else \
                -(-(sum(lengths) + 16 * self.segments) // 4096) * 4096
        if self.volume.is_in_place:
            check(not any(self.records[used:]), f"{self.path}: no zeros behind its records")
            used = -(-used // 4096) * 4096
        check(f"{checksum:016x}" == self.checksum, f"{self.path}: wrong checksum of the store")
        check(used == len(self.records), f"{self.path}: holds more than its records")
        return blocks


class Spectra:
    """What isosurfaces are and cost: of each variable as a whole, and in each store."""

    QUANTITIES = ("triangles", "activeCells", "activeBlocks", "bytes", "area", "volume")

    def __init__(self, folder, arrays, stores):
        self.path = os.path.join(folder, "spectra")
        self.read(arrays, len(stores))
        sums = b"".join(struct.pack("<Q", int(store["checksum"], 16)) for store in stores)
        check(self.identity == hash64(sums), f"{self.path}: is that of another time step")
        for array in range(arrays):
            for name, total in self.totals[array].items():
                sums = [sum(of) for of in zip(*(store[name] for store in self.stores[array]))]
                check(total == sums, f"{self.path}: array {array}: {name} of the stores")

    def read(self, arrays, stores):
        content = read_file(self.path)
        check(content[:8] == b"ISOSPECT", f"{self.path}: is no file of spectra")
        check(struct.unpack_from("<IIQ", content, 8) == (1, arrays, stores),
              f"{self.path}: another version, or does not fit the header")
        self.identity, = struct.unpack_from("<Q", content, 24)
        where = 32 + 32 * arrays
        count = arrays * (stores + 1)
        header = content[:where + 8 * count]
        ends = [len(header) + 8, *struct.unpack_from(f"<{count}Q", header, where)]
        check(content[len(header):ends[0]] == struct.pack("<Q", hash64(header)),
              f"{self.path}: wrong checksum")
        check(ends == sorted(ends) and ends[-1] == len(content), f"{self.path}: wrong size")
        # (first, exponent, count) and units by array.
        fields = [struct.unpack_from("<qiIdd", header, 32 + 32 * array) for array in range(arrays)]
        check(all(-1100 <= e <= 1100 and n <= 2048 and area >= 0 and volume >= 0
                  for _, e, n, area, volume in fields), f"{self.path}: impossible bins")
        self.bins = [of_array[:3] for of_array in fields]
        self.units = [of_array[3:] for of_array in fields]
        sections = [self.read_section(content[ends[s]:ends[s + 1]], s, self.bins[s % arrays][2])
                    for s in range(count)]
        self.totals = sections[:arrays]
        self.stores = [sections[arrays + array::arrays] for array in range(arrays)]

    def read_section(self, section, number, bins):
        name = f"{self.path}: section {number}"
        check(section[:8] == struct.pack("<Q", hash64(section[8:], number)),
              f"{name}: wrong checksum")
        counts, position = {}, 8
        for quantity in self.QUANTITIES:
            counts[quantity], position = self.unpack(section, position, bins, name)
        check(position == len(section), f"{name}: has bytes behind its counts")
        return counts

    @staticmethod
    def unpack(section, position, bins, name):
        """So many packed counts; also the position behind them."""
        def take():
            nonlocal position
            number, shift = 0, 0
            while True:
                check(position < len(section), f"{name}: truncated")
                byte = section[position]
                position += 1
                number |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    check(number < 2**64 and shift <= 70, f"{name}: impossible number")
                    return number
        counts, count = [], 0
        while len(counts) < bins:
            zigzag = take()
            count = (count + (-(zigzag + 1 >> 1) if zigzag & 1 else zigzag >> 1)) % 2**64
            repeats = 1 + (take() if zigzag == 0 else 0)
            check(len(counts) + repeats <= bins, f"{name}: impossible number of zeros")
            counts += [count] * repeats
        return counts, position

    def list_isovalues(self, array):
        first, exponent, count = self.bins[array]
        # In halves: beyond the doubles it becomes infinite, which ldexp alone refuses to.
        scales = 2.0**(exponent // 2), 2.0**(exponent - exponent // 2)
        return [(first + b) * scales[0] * scales[1] for b in range(count)]


class BlockedVolume:
    """A volume, or, with number > 0, one of its overviews, which are blocked volumes like it.

    `sources`: if the volume is in place, the samples of its source, an array a component.
    """

    def __init__(self, path, time_step=0, number=0, sources=None):
        self.header = read_document(path, "ScalableIsosurface blocked volume")
        self.arrays = self.header["arrays"]
        self.block_size = self.header["blockSize"]
        check(self.block_size in (16, 32, 64), f"{path}: block size")
        max_levels = self.block_size.bit_length()
        overviews = self.header["overviews"]
        parts = [self.header, *overviews]
        levels = [part["numberOfLevels"] for part in parts]
        check(all(1 <= n <= max_levels for n in levels)
              and self.header["ghostLayers"] == 1
              and self.header["compression"] in ("none", "lz4", "zstd")
              and all(a["components"] >= 1 and a["type"] in TYPES for a in self.arrays),
              f"{path}: needs a newer reader")
        self.variables = list_variables(self.arrays)
        self.components = [type_name for type_name, name in self.variables
                           if "magnitude" not in name]
        extent = self.header["grid"]["extent"]
        self.first_level = sum(levels[:number])
        self.coordinates = self.read_coordinates(path)
        self.levels = levels[number]
        self.dimensions = [(extent[2 * axis + 1] - extent[2 * axis] >> self.first_level) + 1
                           for axis in range(3)]
        self.blocks = [max(1, -(-(n - 1) // self.block_size)) for n in self.dimensions]
        self.block_count = math.prod(self.blocks)
        check(number == len(overviews) or self.block_count > 1,
              f"{path}: an overview of a single block")
        step = self.header["timeSteps"][time_step]
        check(len(step["ranges"]) == len(self.variables), f"{path}: number of ranges")
        check(len(step["overviews"]) == len(overviews), f"{path}: number of overviews")
        check(all(("source" in one) == ("source" in step) for one in self.header["timeSteps"]),
              f"{path}: time steps in place, and others")
        self.is_in_place = "source" in step and number == 0
        check(not self.is_in_place or self.levels == 1, f"{path}: levels in place")
        check(not self.is_in_place or sources, f"{path}: the samples are in the source: "
              f"{step.get('source', {}).get('path')}")
        self.sources = sources
        folder = os.path.join(find_stores(path), step["folder"])
        if number > 0:
            folder = os.path.join(folder, f"overview-{number}")
            step = step["overviews"][number - 1]
        check(len(step["stores"]) == parts[number]["stores"]
              and sum(store["blocks"] for store in step["stores"]) == self.block_count,
              f"{path}: numbers of stores or blocks")
        self.stores = [Store(self, os.path.join(folder, f"store-{index:05d}"), store)
                       for index, store in enumerate(step["stores"])]
        self.spectra = Spectra(folder, len(self.variables), step["stores"])
        self.overviews = [BlockedVolume(path, time_step, 1 + index)
                          for index in range(len(overviews))] if number == 0 else []

    def read_coordinates(self, path):
        """Of level 0 of this volume or overview, by axis; none of a regular grid."""
        grid = self.header["grid"]
        if "coordinates" not in grid:
            return None
        lists, extent = grid["coordinates"], grid["extent"]
        check(len(lists) == 3 and all(
            len(lists[axis]) == extent[2 * axis + 1] - extent[2 * axis] + 1
            and all(isinstance(x, (int, float)) and math.isfinite(x) for x in lists[axis])
            and all(a < b for a, b in zip(lists[axis], lists[axis][1:])) for axis in range(3)),
              f"{path}: coordinates")
        check(grid["direction"] == [1, 0, 0, 0, 1, 0, 0, 0, 1], f"{path}: turns coordinates")
        return [of_axis[::1 << self.first_level] for of_axis in lists]

    def find_box(self, block, level, ghosted):
        """Per axis [low, high) in the level's coordinates."""
        box = []
        for axis in range(3):
            block, index = divmod(block, self.blocks[axis])
            first = index * self.block_size
            last = min(first + self.block_size, self.dimensions[axis] - 1)
            low, high = first >> level, last >> level
            if ghosted:
                low, high = max(0, low - 1), min((self.dimensions[axis] - 1) >> level, high + 1)
            box.append((low, high + 1))
        return box

    def cut_source(self, component, block):
        """The samples of the source in a block's ghosted box, x fastest."""
        source = self.sources[component]
        (x0, x1), ys, zs = self.find_box(block, 0, True)
        result = array.array(source.typecode)
        for k in range(*zs):
            for j in range(*ys):
                row = self.dimensions[0] * (j + self.dimensions[1] * k)
                result += source[row + x0:row + x1]
        return result

    def list_vertices(self, block, level):
        """The vertices of a level's segment, in its order."""
        xs, ys, zs = (range(*of_axis) for of_axis in self.find_box(block, level, True))
        return [(i, j, k) for k in zs for j in ys for i in xs
                if level == self.levels - 1 or (i | j | k) % 2 == 1]

    def decode(self, block, samples, number, level):
        """The samples of a component on the block's ghosted box at a level, x fastest."""
        (x0, x1), (y0, y1), (z0, z1) = self.find_box(block, level, True)
        width, height = x1 - x0, y1 - y0
        result = array.array(samples[number, level].typecode)
        result.frombytes(bytes(result.itemsize * width * height * (z1 - z0)))
        for source in range(self.levels - 1, level - 1, -1):
            segment, position, shift = samples[number, source], 0, source - level
            ghosted = self.find_box(block, source, True)
            own = ghosted if shift == 0 else self.find_box(block, source, False)
            for k in range(*ghosted[2]):
                for j in range(*ghosted[1]):
                    is_whole = source == self.levels - 1 or (j | k) % 2 == 1
                    step = 1 if is_whole else 2
                    begin = ghosted[0][0] if is_whole else ghosted[0][0] | 1
                    row = range(begin, ghosted[0][1], step)
                    if own[2][0] <= k < own[2][1] and own[1][0] <= j < own[1][1] and row:
                        skip = int(row[0] < own[0][0])
                        end = len(row) - int(row[-1] >= own[0][1])
                        to = ((row[0] + step * skip << shift) - x0 + width *
                              ((j << shift) - y0 + height * ((k << shift) - z0)))
                        stride = step << shift
                        if skip < end:
                            result[to:to + stride * (end - skip - 1) + 1:stride] = \
                                segment[position + skip:position + end]
                    position += len(row)
            check(position == len(segment), f"block {block}: impossible length at level {source}")
        return result

    def list_own(self, block, samples, number):
        """The samples of a component on the block's own vertices at level 0."""
        values = self.decode(block, samples, number, 0)
        ghosted, own = self.find_box(block, 0, True), self.find_box(block, 0, False)
        (x0, x1), (y0, y1), (z0, _) = ghosted
        return [values[i - x0 + (x1 - x0) * (j - y0 + (y1 - y0) * (k - z0))]
                for k in range(*own[2]) for j in range(*own[1]) for i in range(*own[0])]

    def find_active(self, number, isovalue):
        """Per store the ordinals of the blocks that the isosurface passes."""
        key = make_threshold_key(isovalue, self.variables[number][0])
        return [sorted(r[2] for r in store.trees[number].find(key, key) if r[0] != key)
                if key is not None else [] for store in self.stores]

    def verify(self):
        blocks = sorted(block for store in self.stores for block in store.verify())
        check(blocks == list(range(self.block_count)), "the stores do not have each block once")
        for overview in self.overviews:
            overview.verify()


def main():
    parser = argparse.ArgumentParser(description="Checks a blocked volume; tells what is in it.")
    parser.add_argument("volume", help="the .bvol file")
    parser.add_argument("--blocks", action="store_true", help="list the blocks of all stores")
    parser.add_argument("--array", type=int, default=0, help="number of a variable")
    parser.add_argument("--isovalue", type=float, help="list the active blocks")
    parser.add_argument("--overview", type=int, default=0,
                        help="number of an overview, whose blocks are meant then; 0: none")
    parser.add_argument("--samples", nargs=3, type=int, metavar=("STORE", "ORDINAL", "LEVEL"),
                        help="print the samples of a block, ghost layer included")
    options = parser.parse_args()
    volume = BlockedVolume(options.volume)
    volume.verify()
    print(f"{options.volume}: {volume.dimensions} vertices, {volume.block_count} blocks, "
          f"{len(volume.stores)} stores, arrays {[a['name'] for a in volume.arrays]}, "
          f"overviews of {[overview.dimensions for overview in volume.overviews]}: sound")
    if options.overview:
        volume = volume.overviews[options.overview - 1]
    active = None if options.isovalue is None else volume.find_active(options.array,
                                                                      options.isovalue)
    for number, store in enumerate(volume.stores):
        for ordinal in range(store.count) if active is None else active[number]:
            if options.blocks or active is not None:
                print("store", number, "ordinal", ordinal, "block", store.find_block(ordinal)[0])
    if options.samples:
        store, ordinal, level = options.samples
        block, samples = volume.stores[store].read_segments(ordinal)
        print(volume.find_box(block, level, True))
        print(*volume.decode(block, samples, options.array, level))


if __name__ == "__main__":
    try:
        main()
    except (FormatError, OSError) as error:
        sys.exit(str(error))
