#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Compares blocked volumes with the samples that they were made from, through the second reader.

usage: check_blocked_volumes.py FOLDER, with volumes as WriteSampleVolumes makes them.
"""
import array
import glob
import math
import os
import random
import shutil
import sys

from read_blocked_volume import TYPES, BlockedVolume, find_stores, make_key, read_document
from read_interval_tree import FormatError, check, read_file


def check_samples(volume, sources):
    """Every sample of every block at every level; returns the own samples' key ranges."""
    strides = (1, volume.dimensions[0], volume.dimensions[0] * volume.dimensions[1])
    ranges = [[] for _ in volume.stores]
    for store, found in zip(volume.stores, ranges):
        for ordinal in range(store.count):
            block, samples = store.read_segments(ordinal)
            found.append([])
            for number, source in enumerate(sources):
                for level in range(volume.levels):
                    (x0, x1), ys, zs = volume.find_box(block, level, True)
                    expected = array.array(source.typecode)
                    for k in range(*zs):
                        for j in range(*ys):
                            row = (j << level) * strides[1] + (k << level) * strides[2]
                            expected += source[row + (x0 << level):
                                               row + (x1 - 1 << level) + 1:1 << level]
                    decoded = volume.decode(block, samples, number, level)
                    check(decoded.tobytes() == expected.tobytes(),
                          f"{store.path}: block {block}, array {number}, level {level} differs")
                keys = find_keys(volume, block, source, strides, number)
                found[-1].append((min(keys), max(keys)))
    return ranges


def find_keys(volume, block, source, strides, number):
    (x0, x1), ys, zs = volume.find_box(block, 0, False)
    type_name = volume.arrays[number]["type"]
    values = set()
    for k in range(*zs):
        for j in range(*ys):
            row = j * strides[1] + k * strides[2]
            values.update(source[row + x0:row + x1])
    return [make_key(value, type_name) for value in values]


def check_queries(volume, ranges, number):
    for store, of_store in zip(volume.stores, ranges):
        tree = store.trees[number]
        intervals = [(*pair[number], ordinal) for ordinal, pair in enumerate(of_store)]
        ends = sorted({end for interval in intervals for end in interval[:2]}) or [0]
        queries = random.sample(ends, min(len(ends), 60)) + [0, 1, 2**64 - 1]
        queries += [end + shift for end in random.sample(ends, min(len(ends), 60))
                    for shift in (-1, 1) if 0 <= end + shift < 2**64]
        pairs = [(key, key) for key in queries]
        pairs += [tuple(sorted(random.choices(queries, k=2))) for _ in range(40)] + [(0, 2**64 - 1)]
        for low, high in pairs:
            expected = [i for i in intervals if i[0] <= high and i[1] >= low]
            check(sorted(tree.find(low, high)) == sorted(expected),
                  f"{tree.file.path}: another answer for {low} to {high}")


def check_active(volume, sources, number, isovalue):
    expected = [[] for _ in volume.stores]
    strides = (1, volume.dimensions[0], volume.dimensions[0] * volume.dimensions[1])
    for store, ordinals in zip(volume.stores, expected):
        for ordinal in range(store.count):
            (x0, x1), ys, zs = volume.find_box(store.find_block(ordinal)[0], 0, False)
            inside = {value >= isovalue for k in range(*zs) for j in range(*ys)
                      for value in sources[number][j * strides[1] + k * strides[2] + x0:
                                                   j * strides[1] + k * strides[2] + x1]}
            if len(inside) == 2:
                ordinals.append(ordinal)
    check(volume.find_active(number, isovalue) == expected,
          f"array {number}: other active blocks at {isovalue}")


def check_ranges(volume, sources):
    finite = float("inf")
    for source, told, description in zip(sources, volume.header["timeSteps"][0]["ranges"],
                                         volume.arrays):
        values = [value for value in source if -finite < value < finite]
        most = 2**64 - 2 if description["type"] == "uint64" else max(values)
        check(told == [min(values), min(most, max(values))], f"range of {description['name']}")


def check_spectrum(volume, number):
    """Active blocks and bytes are what queries find and read; the volume falls to nothing."""
    spectra = volume.spectra
    isovalues = spectra.list_isovalues(number)
    for b in random.sample(range(len(isovalues)), min(len(isovalues), 40)):
        active = volume.find_active(number, isovalues[b])
        for store, ordinals, counts in zip(volume.stores, active, spectra.stores[number]):
            sizes = [sum(16 + stored for stored in store.find_block(ordinal)[2][
                volume.levels * number:volume.levels * (number + 1)]) for ordinal in ordinals]
            check((counts["activeBlocks"][b], counts["bytes"][b]) == (len(sizes), sum(sizes)),
                  f"{spectra.path}: array {number}: blocks or bytes at {isovalues[b]}")
    if isovalues and volume.arrays[number]["type"][0] != "f":  # there is no NaN or infinity
        counts, rounding = spectra.totals[number]["volume"], len(volume.stores)
        whole = (math.prod(n - 1 for n in volume.dimensions) * 8**volume.first_level
                 * abs(math.prod(volume.header["grid"]["spacing"])))
        if volume.coordinates:
            whole = math.prod(of_axis[-1] - of_axis[0] for of_axis in volume.coordinates)
        whole /= spectra.units[number][1]
        check(counts[0] <= whole + rounding
              and all(after <= before + rounding for before, after in zip(counts, counts[1:])),
              f"{spectra.path}: array {number}: volume")


def check_damage(path, flips):
    """Flips one bit after the other, some in each file; the reader must notice each."""
    copy = path + ".damaged"
    shutil.rmtree(find_stores(copy), ignore_errors=True)
    shutil.copyfile(path, copy)
    shutil.copytree(find_stores(path), find_stores(copy))
    files = [copy] + [name for name in glob.glob(find_stores(copy) + "/**", recursive=True)
                      if os.path.isfile(name)]
    for name in files:
        good = read_file(name)
        for _ in range(flips if good else 0):  # a store without blocks has an empty file of them
            damaged = bytearray(good)
            damaged[random.randrange(len(good))] ^= 1 << random.randrange(8)
            with open(name, "wb") as file:
                file.write(damaged)
            try:
                BlockedVolume(copy).verify()
            except FormatError:
                continue
            raise FormatError(f"{name}: a flipped bit goes unnoticed")
        with open(name, "wb") as file:
            file.write(good)
    BlockedVolume(copy).verify()


def subsample(source, dimensions, level):
    """Every 2^level-th sample on each axis."""
    width, height, depth = dimensions
    coarse = array.array(source.typecode)
    for k in range(0, depth, 1 << level):
        for j in range(0, height, 1 << level):
            row = width * (j + height * k)
            coarse += source[row:row + width:1 << level]
    return coarse


def check_overview(overview, finest, sources):
    coarse = [subsample(source, finest.dimensions, overview.first_level) for source in sources]
    check(all(len(source) == math.prod(overview.dimensions) for source in coarse),
          f"overview from level {overview.first_level}: dimensions")
    ranges = check_samples(overview, coarse)
    for number, source in enumerate(coarse):
        check_queries(overview, ranges, number)
        check_active(overview, coarse, number, float(random.choice(source)))
        check_spectrum(overview, number)


def check_volume(path):
    sources = []
    header = read_document(path, "ScalableIsosurface blocked volume")
    for number, description in enumerate(header["arrays"]):
        source = array.array(TYPES[description["type"]][0])
        source.frombytes(read_file(f"{path[:-5]}.array-{number}.raw"))
        sources.append(source)
    volume = BlockedVolume(path, sources=sources)
    check(volume.is_in_place == os.path.basename(path).startswith("in-place"), f"{path}: in place")
    volume.verify()
    check_ranges(volume, sources)
    check(bool(volume.coordinates) == ("rectilinear" in path), f"{path}: coordinates")
    for size, of_axis in zip(volume.dimensions, volume.coordinates or []):
        check(all(math.isclose(x, 0.3 * n + math.sin(0.2 * n) - 1e-9, abs_tol=1e-14)
                  for n, x in enumerate(of_axis)) and len(of_axis) == size, f"{path}: coordinates")
    ranges = check_samples(volume, sources)
    for number, source in enumerate(sources):
        check_queries(volume, ranges, number)
        check_spectrum(volume, number)
        for isovalue in (0.0, -1e300, 1e300, 40.5, float(random.choice(source))):
            check_active(volume, sources, number, isovalue)
    for overview in volume.overviews:
        check_overview(overview, volume, sources)
    coarsest = volume.overviews[-1] if volume.overviews else volume
    check(coarsest.block_count == 1, f"{path}: no level of a single block")
    lists = volume.stores[0].trees[0].lists_read
    print(f"{path}: {volume.block_count} blocks, {len(volume.overviews)} overviews, "
          f"tree height {volume.stores[0].trees[0].root[3]}, "
          f"lists read {lists}: as the source has it")
    return lists


def main(folder):
    random.seed(1)
    paths = sorted(glob.glob(os.path.join(folder, "*.bvol")))
    check(len(paths) == 8, f"{folder}: not the volumes that were written")
    kinds = [check_volume(path) for path in paths]
    unused = [kind for kind in kinds[0] if not any(lists[kind] for lists in kinds)]
    check(not unused, f"no tree has lists of the kinds {unused}")
    check_damage(os.path.join(folder, "empty-stores.bvol"), 8)
    check_damage(os.path.join(folder, "compressed-by-zstd.bvol"), 1)  # each takes a second or two


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except FormatError as error:
        sys.exit(str(error))
