# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of volumes as arrays share."""

import gzip
import os
import random
import tempfile
import unittest

import numpy

TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64")
SHAPE = (37, 50, 70)  # two blocks on each axis, and not of whole blocks


def make_samples(dtype, shape=SHAPE, seed=1):
    """Noise over the whole range of a type."""
    generator = numpy.random.default_rng(seed)
    if numpy.dtype(dtype).kind == "f":
        return generator.normal(0, 1e6, shape).astype(dtype)
    limits = numpy.iinfo(dtype)
    return generator.integers(limits.min, limits.max, shape, dtype, endpoint=True)


def make_waves(shape=SHAPE):
    z, y, x = (axis * 0.3 for axis in numpy.meshgrid(*map(numpy.arange, shape), indexing="ij"))
    return (numpy.sin(x) * numpy.cos(y) + numpy.sin(0.5 * z)).astype(numpy.float32)


def write_nrrd(path, samples, packed=False):
    """A NRRD file of float32 at spacings 0.5, 1, 2, from (10, 20, 30) on."""
    z, y, x = samples.shape
    header = (
        f"NRRD0005\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: {x} {y} {z}\n"
        "space directions: (0.5,0,0) (0,1,0) (0,0,2)\nspace origin: (10,20,30)\n"
        f"endian: little\nencoding: {'gzip' if packed else 'raw'}\n\n"
    )
    data = samples.astype("<f4").tobytes()
    with open(path, "wb") as file:
        file.write(header.encode() + (gzip.compress(data, 1) if packed else data))


def take(array, key):
    """What a key gives, or the type and the words of the error."""
    try:
        result = array[key]
    except Exception as error:  # noqa: BLE001 - any error is compared
        return type(error), str(error)
    return type(result), result.dtype, result.shape, numpy.asarray(result).tobytes()


class RandomKeys:
    """Keys of integers, slices, Ellipsis and newaxis, of which about one in four is an error."""

    def __init__(self, shape, seed):
        self.shape = shape
        self.random = random.Random(seed)

    def make_item(self, size):
        kind = self.random.random()
        if kind < 0.35:
            index = self.random.randint(-size, size - 1)
            return self.random.choice((index, index, numpy.int16(index), numpy.array(index)))
        if kind < 0.4:
            return self.random.choice((size, -size - 1, 1.0, "1", numpy.float32(2), 2**70, b"x", {}))
        if kind < 0.44:
            return self.random.choice((slice(None, None, 0), slice("a", None), slice(0, 1.5)))
        ends = [None, *range(-size - 3, size + 4)]
        steps = [None, None, 1, -1, 2, -2, 3, 7, -size, size + 2]
        return slice(self.random.choice(ends), self.random.choice(ends), self.random.choice(steps))

    def make(self):
        length = self.random.choice([0, 1, 2, *[len(self.shape)] * 4, len(self.shape) + 1])
        sizes = [*self.shape, 1]
        items = [self.make_item(sizes[axis]) for axis in range(length)]
        for special in (Ellipsis, None):
            for _ in range(self.random.choice((0, 0, 0, 0, 1, 1, 2))):
                items.insert(self.random.randint(0, len(items)), special)
        # A text alone is the name of an array.
        if len(items) == 1 and not isinstance(items[0], str) and self.random.random() < 0.5:
            return items[0]
        return tuple(items)


class VolumeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def check_keys(self, volume, samples, count, seed=0):
        self.assertEqual(volume.shape, samples.shape)
        self.assertEqual(volume.dtype, samples.dtype)
        keys = RandomKeys(samples.shape, seed)
        errors = 0
        for _ in range(count):
            key = keys.make()
            expected = take(samples, key)
            self.assertEqual(take(volume, key), expected, key)
            errors += isinstance(expected[1], str)
        self.assertGreater(errors, count // 20)
        self.assertLess(errors, count // 2)
