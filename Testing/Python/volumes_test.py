# SPDX-License-Identifier: BSD-3-Clause
"""Volumes as arrays: what scalable_isosurface.open gives, beside NumPy's own copy of the samples."""

import concurrent.futures
import gc
import gzip
import multiprocessing
import os
import pickle
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy

import scalable_isosurface as si

try:
    import dask
    import dask.array
except ImportError:
    dask = None
try:
    import h5py
except ImportError:
    h5py = None
try:
    import zarr
except ImportError:
    zarr = None
try:
    import meshio
except ImportError:
    meshio = None

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


class Samples(VolumeTest):
    def test_keys_give_what_numpy_gives_of_all_types(self):
        for number, dtype in enumerate(TYPES):
            with self.subTest(dtype=dtype):
                samples = make_samples(dtype)
                with si.create(samples, self.path(f"{dtype}.bvol")) as volume:
                    self.check_keys(volume, samples, 300 if dtype == "int16" else 60, number)
                    numpy.testing.assert_array_equal(volume[...], samples)

    def test_components_are_a_last_axis(self):
        for dtype, components in (("uint8", 3), ("float32", 6)):
            samples = make_samples(dtype, (*SHAPE, components))
            volume = si.create(samples, self.path("tuples.bvol"), compression="zstd")
            self.assertEqual(volume.ndim, 4)
            self.assertEqual(volume.chunks, (32, 32, 32, components))
            self.check_keys(volume, samples, 100)
            numpy.testing.assert_array_equal(volume[..., ::-2], samples[..., ::-2])

    def test_levels_have_every_second_sample(self):
        samples = make_samples("uint16", (70, 100, 130))
        volume = si.create(samples, self.path("levels.bvol"), spacing=(1, 2, 3), block_size=16)
        self.assertGreater(volume.levels, 5)
        for level in range(volume.levels):
            step = 2**level
            coarse = volume.level(level)
            self.assertEqual(coarse.spacing, (step, 2 * step, 3 * step))
            self.check_keys(coarse, samples[::step, ::step, ::step], 40, level)
        for level in (-1, volume.levels):
            with self.assertRaisesRegex(IndexError, "levels.bvol: has .* levels, and no level"):
                volume.level(level)

    def test_time_steps_and_arrays_are_chosen(self):
        steps = [
            {"density": make_samples("int16", seed=2 * n), "speed": make_samples("float64", seed=2 * n + 1)}
            for n in range(3)
        ]
        for number, arrays in enumerate(steps):
            volume = si.create(arrays, self.path("steps.bvol"), time=0.5 * number, append=number > 0)
        self.assertEqual(volume.arrays, ("density", "speed"))
        self.assertEqual(volume.times, (0, 0.5, 1))
        for step in (0, 1, 2, -1, -3):
            at = volume.at(step)
            for name in ("density", "speed"):
                numpy.testing.assert_array_equal(at[name][30:, ::3, 5], steps[step][name][30:, ::3, 5])
                self.assertEqual(at.array(name).name, name)
            opened = si.open(self.path("steps.bvol"), step)
            numpy.testing.assert_array_equal(opened[7], steps[step]["density"][7])
        for step in (3, -4):
            self.assertRaisesRegex(IndexError, "steps.bvol: has 3 time steps, and no step", volume.at, step)
            self.assertRaises(IndexError, si.open, self.path("steps.bvol"), step)
        self.assertRaisesRegex(KeyError, "steps.bvol: has no array 'mass', but 'density'", volume.array, "mass")

    def test_a_volume_knows_its_place_and_size(self):
        samples = make_samples("uint8")
        direction = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
        volume = si.create(
            samples, self.path("v.bvol"), spacing=(0.5, 1, 2), origin=(3, 4, 5), direction=direction, name="CT"
        )
        self.assertEqual(volume.spacing, (0.5, 1, 2))
        self.assertEqual(volume.origin, (3, 4, 5))
        numpy.testing.assert_array_equal(volume.direction, direction)
        self.assertIsNone(volume.coordinates)
        self.assertEqual((volume.name, volume.arrays), ("CT", ("CT",)))
        self.assertEqual((volume.ndim, volume.size, volume.nbytes), (3, samples.size, samples.nbytes))
        self.assertEqual(len(volume), len(samples))
        self.assertIn("v.bvol', array 'CT': (37, 50, 70) uint8", repr(volume))
        numpy.testing.assert_array_equal(numpy.asarray(volume), samples)
        self.assertEqual(numpy.asarray(volume, numpy.float32).dtype, numpy.float32)
        numpy.testing.assert_array_equal(list(volume)[7], samples[7])

    def test_elements_one_by_one_are_refused_in_clear_words(self):
        volume = si.create(make_samples("uint8"), self.path("v.bvol"))
        for key in ([1, 2], (0, [1, 2]), numpy.arange(3), numpy.ones(SHAPE, bool), True, (0, False)):
            with self.assertRaisesRegex(TypeError, "indexed by integers, slices, Ellipsis"):
                volume[key]

    def test_many_threads_read_at_once(self):
        samples = make_samples("int32")
        volume = si.create(samples, self.path("v.bvol"))
        write_nrrd(self.path("v.nrrd"), samples.astype(numpy.float32))
        foreign = si.open(self.path("v.nrrd"))

        def check(seed):
            generator = random.Random(seed)
            for _ in range(30):
                key = tuple(slice(generator.randrange(size), None, generator.choice((1, 3))) for size in SHAPE)
                if not (volume[key] == samples[key]).all():
                    return False
                if not (foreign[key] == samples[key].astype(numpy.float32)).all():
                    return False
            return True

        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            self.assertTrue(all(pool.map(check, range(8))))

    def test_only_blocks_with_chosen_samples_are_read(self):
        """The block in the middle is damaged, and nobody notices who does not need it."""
        samples = make_samples("uint8", (33, 33, 96))
        samples[:, :, 36:60] = 0xAB
        si.create(samples, self.path("v.bvol"), compression="none")
        for folder, _, names in os.walk(self.path("v.bvol.stores/000001/store-00000")):
            for name in names:
                with open(os.path.join(folder, name), "r+b") as file:
                    content = file.read()
                    file.seek(0)
                    file.write(content.replace(b"\xab" * 9, b"\xba" * 9))
        volume = si.open(self.path("v.bvol"))
        for key in (slice(0, 32), slice(64, None, 3), slice(None, None, 64), slice(90, None, -70), -1):
            numpy.testing.assert_array_equal(volume[..., key], samples[..., key])
        for key in (40, slice(None), slice(0, 41, 40)):
            with self.assertRaisesRegex(OSError, "v.bvol"):
                volume[..., key]


class Files(VolumeTest):
    def test_files_of_other_formats_are_read_where_they_lie(self):
        samples = make_waves()
        for packed in (False, True):
            write_nrrd(self.path("waves.nrrd"), samples, packed)
            volume = si.open(self.path("waves.nrrd"))
            self.assertEqual((volume.levels, volume.spacing), (1, (0.5, 1, 2)))
            self.assertEqual(numpy.abs(volume.origin).tolist(), [10, 20, 30])
            self.check_keys(volume, samples, 40 if packed else 200)
        self.assertEqual(os.listdir(self.folder), ["waves.nrrd"])

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_datasets_of_hdf5_are_read_by_chunks(self):
        samples = make_samples("uint16", (3, *SHAPE))
        with h5py.File(self.path("v.h5"), "w") as file:
            file.create_dataset("a/b", data=samples, chunks=(1, 16, 20, 24), compression="gzip")
        volume = si.open(self.path("v.h5:/a/b"), axes="tzyx")
        self.assertEqual((volume.steps, volume.chunks), (3, (16, 20, 24)))
        for step in (0, 2, 1):
            self.check_keys(volume.at(step), samples[step], 60, step)
        with self.assertRaisesRegex(OSError, "v.h5"):
            si.open(self.path("v.h5:/a/c"))

    def test_an_index_is_made_once_and_then_used(self):
        samples = make_waves()
        write_nrrd(self.path("waves.nrrd"), samples)
        loose = si.open(self.path("waves.nrrd"))
        indexed = si.index(self.path("waves.nrrd"))
        self.assertGreater(indexed.levels, 3)
        written = os.stat(self.path("waves.nrrd.bvol")).st_mtime_ns
        si.index(self.path("waves.nrrd"))
        self.assertEqual(os.stat(self.path("waves.nrrd.bvol")).st_mtime_ns, written)
        again = si.open(self.path("waves.nrrd"))
        self.assertEqual(again.levels, indexed.levels)
        self.check_keys(again, samples, 100)
        self.check_keys(again.level(1), samples[::2, ::2, ::2], 50)
        for name in ("points", "triangles", "normals"):
            numpy.testing.assert_array_equal(
                getattr(loose.isosurface(0.4), name), getattr(again.isosurface(0.4), name)
            )
        numpy.testing.assert_array_equal(loose.spectrum().triangles, again.spectrum().triangles)
        write_nrrd(self.path("waves.nrrd"), samples + 1)
        os.utime(self.path("waves.nrrd"), ns=(0, 1))
        changed = si.open(self.path("waves.nrrd"))
        self.assertEqual(changed.levels, 1)
        numpy.testing.assert_array_equal(changed[3], samples[3] + 1)
        elsewhere = si.index(self.path("waves.nrrd"), index_folder=self.path("indices"))
        self.assertGreater(elsewhere.levels, 3)
        self.assertEqual(si.open(self.path("waves.nrrd"), index_folder=self.path("indices")).levels, elsewhere.levels)

    def test_errors_name_the_file(self):
        missing = self.path("missing.bvol")
        with self.assertRaisesRegex(FileNotFoundError, "missing.bvol"):
            si.open(missing)
        self.assertRaises(FileNotFoundError, si.open, self.path("missing.nrrd:/data"))
        self.assertRaises(FileNotFoundError, si.index, missing)
        self.assertRaises(FileNotFoundError, si.create, missing, self.path("v.bvol"))
        self.assertRaises(TypeError, si.open, 7)
        self.assertRaises(TypeError, si.open, b"v.bvol")
        for name, content in (("v.bvol", b"{}"), ("v.bvol", b""), ("v.nrrd", b"NRRD0005\n"), ("v.txt", b"x" * 99)):
            with open(self.path(name), "wb") as file:
                file.write(content)
            with self.assertRaisesRegex(OSError, name):
                si.open(self.path(name))
        self.assertRaisesRegex(OSError, self.folder, si.open, self.folder)

    def test_damage_is_an_error_that_names_the_file(self):
        samples = make_samples("float64")
        si.create(samples, self.path("v.bvol"), compression="none")
        for folder, _, names in os.walk(self.path("v.bvol.stores/000001/store-00000")):
            for name in names:
                path = os.path.join(folder, name)
                with open(path, "r+b") as file:
                    size = os.path.getsize(path)
                    file.seek(size // 3)
                    file.write(bytes(size // 3))
        volume = si.open(self.path("v.bvol"))
        for read in (lambda: volume[...], lambda: volume.isosurface(0), lambda: volume.active_blocks(0)):
            with self.assertRaisesRegex(OSError, "v.bvol"):
                read()

    def test_a_lost_store_is_a_warning_where_there_are_replicas(self):
        samples = make_waves()
        expected = si.create(samples, self.path("v.bvol"), stores=3, replicas=2).isosurface(0.4)
        shutil.rmtree(self.path("v.bvol.stores/000001/store-00001"))
        numpy.testing.assert_array_equal(si.open(self.path("v.bvol"))[...], samples)
        with self.assertWarnsRegex(UserWarning, "v.bvol"):
            surface = si.open(self.path("v.bvol")).isosurface(0.4)
        self.assertEqual(sorted(map(tuple, surface.points)), sorted(map(tuple, expected.points)))
        shutil.rmtree(self.path("v.bvol.stores/000001/store-00002"))
        for read in (lambda volume: volume[...], lambda volume: volume.isosurface(0.4)):
            with self.assertRaisesRegex(OSError, "v.bvol"):
                read(si.open(self.path("v.bvol")))

    def test_a_closed_volume_is_a_value_error(self):
        with si.create(make_samples("uint8"), self.path("v.bvol")) as volume:
            level = volume.level(1)
        for use in (lambda: volume[0], lambda: volume.shape, lambda: level[0], lambda: volume.isosurface(1)):
            self.assertRaisesRegex(ValueError, "v.bvol: the volume is closed", use)
        self.assertIn("closed", repr(volume))
        volume.close()

    def test_ctrl_c_stops_writing(self):
        """Whichever thread reads the slow source, the exception of the handler comes out."""

        class Slow:
            shape = (400, 8, 8)
            dtype = numpy.dtype("uint8")

            def __getitem__(self, key):
                time.sleep(1)
                return numpy.zeros([part.stop - part.start for part in key], self.dtype)

        def interrupt(*_):
            raise KeyboardInterrupt

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, interrupt))
        self.addCleanup(signal.setitimer, signal.ITIMER_REAL, 0)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        self.assertRaises(KeyboardInterrupt, si.create, Slow(), self.path("slow.bvol"))
        self.assertEqual([name for name in os.listdir(self.folder) if name == "slow.bvol"], [])


class Writing(VolumeTest):
    def check_round_trip(self, source, samples, **settings):
        volume = si.create(source, self.path("out.bvol"), **settings)
        numpy.testing.assert_array_equal(volume[...], samples)
        self.assertEqual(volume.dtype, samples.dtype)

    def test_numpy_arrays_of_any_layout_come_back(self):
        samples = make_samples("int16", (40, 50, 60))
        for array in (
            samples,
            samples[::-1, 1::2, :],
            samples.transpose(2, 0, 1),
            numpy.asfortranarray(samples),
            samples.astype(">i2"),
            samples[:1, :1, :1],
        ):
            self.check_round_trip(array, array.astype("<i2"))
        record = numpy.zeros(samples.shape, [("a", "u1"), ("b", "i2")])
        record["b"] = samples
        self.check_round_trip(record["b"], samples)
        self.check_round_trip(samples[..., None], samples)  # of one component
        self.check_round_trip(samples[:4, :5, :6].tolist(), samples[:4, :5, :6].astype("int64"))

    @unittest.skipUnless(zarr, "there is no Zarr")
    def test_zarr_arrays_come_back(self):
        samples = make_samples("uint16")
        path = self.path("v.zarr")
        array = zarr.open(path, mode="w", shape=SHAPE, chunks=(16, 16, 16), dtype="u2")
        array[:] = samples
        self.check_round_trip(array, samples)
        self.check_round_trip(path, samples)

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_datasets_of_h5py_come_back(self):
        samples = make_samples("float64", (*SHAPE, 2))
        with h5py.File(self.path("v.h5"), "w") as file:
            dataset = file.create_dataset("v", data=samples, chunks=(8, 8, 8, 2))
            self.check_round_trip(dataset, samples, stores=3, replicas=2, compression="zstd:5")

    @unittest.skipUnless(dask, "there is no Dask")
    def test_dask_arrays_come_back_and_a_volume_is_one(self):
        samples = make_samples("uint8", (100, 100, 100))
        lazy = dask.array.from_array(samples, chunks=(40, 30, 100)) // 2
        volume = si.create(lazy, self.path("half.bvol"))
        numpy.testing.assert_array_equal(volume[...], samples // 2)
        for options in ({"chunks": volume.chunks}, {}):
            array = dask.array.from_array(volume, **options)
            self.assertEqual(array.sum().compute(scheduler="threads"), (samples // 2).sum())
            numpy.testing.assert_array_equal(array[10:90:7, 5].compute(), samples[10:90:7, 5] // 2)
        self.assertEqual(dask.array.from_array(volume, chunks=volume.chunks).numblocks, (4, 4, 4))
        array = dask.array.from_array(volume, chunks=64)
        with multiprocessing.get_context("spawn").Pool(2) as pool:
            self.assertEqual(
                array.max(axis=0).sum().compute(scheduler="processes", pool=pool), (samples // 2).max(axis=0).sum()
            )

    def test_files_are_written_with_all_steps(self):
        write_nrrd(self.path("waves.nrrd"), make_waves())
        volume = si.create(self.path("waves.nrrd"), self.path("waves.bvol"))
        self.assertEqual((volume.spacing, volume.name), ((0.5, 1, 2), si.open(self.path("waves.nrrd")).name))
        numpy.testing.assert_array_equal(volume[...], make_waves())
        for number in range(3):
            si.create(make_samples("int8", seed=number), self.path("a.bvol"), time=number, append=number > 0)
        again = si.create(self.path("a.bvol"), self.path("b.bvol"), compression="zstd", spacing=(3, 2, 1))
        self.assertEqual((again.times, again.spacing), ((0, 1, 2), (3, 2, 1)))
        numpy.testing.assert_array_equal(again.at(1)[...], make_samples("int8", seed=1))
        coarse = si.create(again.level(1), self.path("coarse.bvol"))
        self.assertEqual(coarse.spacing, (6, 4, 2))
        numpy.testing.assert_array_equal(coarse[...], make_samples("int8", seed=2)[::2, ::2, ::2])

    def test_a_file_of_several_steps_is_not_replaced_by_its_first_one(self):
        for number in range(2):
            si.create(make_samples("int8", seed=number), self.path("a.bvol"), time=number, append=number > 0)
        with self.assertRaisesRegex(ValueError, "a.bvol: is its own source"):
            si.create(self.path("a.bvol"), self.path("a.bvol"), compression="zstd")
        numpy.testing.assert_array_equal(si.open(self.path("a.bvol"), 1)[...], make_samples("int8", seed=1))

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_a_rectilinear_grid_lies_where_its_coordinates_are(self):
        with h5py.File(self.path("lined.nc"), "w") as file:
            for name, size in (("x", 6), ("y", 5), ("z", 4)):
                file[name] = numpy.arange(size, dtype=float) ** 2
                file[name].make_scale(name)
            file["v"] = make_samples("float32", (4, 5, 6))
            for axis, name in enumerate("zyx"):
                file["v"].dims[axis].attach_scale(file[name])
        lined = si.open(self.path("lined.nc"))
        numpy.testing.assert_array_equal(lined.coordinates[0], [0, 1, 4, 9, 16, 25])
        for place in ({"origin": (1, 2, 3)}, {"direction": numpy.diag([-1, 1, 1])}):
            self.assertRaisesRegex(ValueError, "rectilinear", si.create, lined, self.path("a.bvol"), **place)
        even = si.create(lined, self.path("a.bvol"), spacing=(1, 1, 1), origin=(1, 2, 3))
        self.assertEqual((even.coordinates, even.origin), (None, (1, 2, 3)))

    def test_what_a_slice_raises_is_raised(self):
        class Broken:
            shape = SHAPE
            dtype = numpy.dtype("uint8")

            def __getitem__(self, key):
                raise LookupError("no such slice")

        class Wrong(Broken):
            def __getitem__(self, key):
                return numpy.zeros((1, 2, 3), "uint8")

        samples = make_samples("uint8")
        si.create(samples, self.path("v.bvol"))
        self.assertRaisesRegex(LookupError, "no such slice", si.create, Broken(), self.path("v.bvol"))
        self.assertRaisesRegex(ValueError, "shape", si.create, Wrong(), self.path("v.bvol"))
        numpy.testing.assert_array_equal(si.open(self.path("v.bvol"))[...], samples)  # is as it was

    def test_what_makes_no_sense_is_refused(self):
        samples = make_samples("uint8", (4, 4, 4))
        target = self.path("v.bvol")
        for source, settings in (
            (samples[0], {}),
            (samples[:0], {}),
            ({}, {}),
            ({"a": samples, "b": samples[1:]}, {}),
            ({"a": samples}, {"name": "b"}),
            (samples, {"block_size": 17}),
            (samples, {"compression": "gzip"}),
            (samples, {"compression": "zstd:99"}),
            (samples, {"compression": "zstd:x"}),
            (samples, {"replicas": 2}),
            (samples, {"spacing": (0, 1, 1)}),
            (samples, {"spacing": 1}),
            (samples, {"origin": (1, 2)}),
            (samples, {"direction": numpy.zeros((3, 3))}),
            (samples, {"direction": numpy.eye(2)}),
        ):
            with self.subTest(settings=settings), self.assertRaises(ValueError):
                si.create(source, target, **settings)
        self.assertRaisesRegex(ValueError, "ends with .bvol", si.create, samples, self.path("v.vti"))
        for dtype in ("bool", "float16", "complex64", "U3", "O"):
            self.assertRaisesRegex(TypeError, "samples are of int8", si.create, samples.astype(dtype), target)
        self.assertEqual(os.listdir(self.folder), [])
        with open(self.path("file"), "w"):
            pass
        self.assertRaises(OSError, si.create, samples, self.path("file/v.bvol"))

    def test_volumes_are_pickled_by_their_path(self):
        samples = {"scalars": make_samples("int8"), "b": make_samples("uint8")}
        volume = si.create(samples, self.path("v.bvol"))
        chosen = pickle.loads(pickle.dumps(volume["b"].level(1)))
        numpy.testing.assert_array_equal(chosen[...], samples["b"][::2, ::2, ::2])
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            self.assertEqual(pool.apply(numpy.sum, (volume["b"],)), samples["b"].sum())
        pickled = [pickle.dumps(volume["b"]), pickle.dumps(volume.level(5))]
        si.create(samples["scalars"][:2, :2, :2], self.path("v.bvol"), block_size=16)
        for content, error in zip(pickled, (KeyError, IndexError)):
            self.assertRaises(error, pickle.loads, content)


class Surfaces(VolumeTest):
    def setUp(self):
        super().setUp()
        self.samples = make_waves()
        self.volume = si.create(self.samples, self.path("waves.bvol"), spacing=(0.5, 1, 2), name="waves")

    def check_closed(self, surface):
        """Corners are points, and normals have length 1."""
        self.assertEqual(surface.triangles.min(), 0)
        self.assertEqual(surface.triangles.max(), len(surface.points) - 1)
        numpy.testing.assert_allclose(numpy.linalg.norm(surface.normals, axis=1), 1, rtol=1e-5)

    def test_points_lie_on_edges_where_samples_cross_the_isovalue(self):
        surface = self.volume.isosurface(0.4)
        self.check_closed(surface)
        grid = surface.points / numpy.float32([0.5, 1, 2])
        low = numpy.floor(grid).astype(int)
        part = grid - low
        self.assertTrue(((part > 1e-4).sum(axis=1) <= 1).all())
        high = numpy.minimum(low + (part > 1e-4), numpy.array(SHAPE[::-1]) - 1)
        ends = [self.samples[tuple(corner.T[::-1])] for corner in (low, high)]
        weight = part.max(axis=1)
        numpy.testing.assert_allclose(ends[0] * (1 - weight) + ends[1] * weight, 0.4, atol=2e-3)

    def test_several_isovalues_are_parts_of_one_surface(self):
        surface = self.volume.isosurface([0.7, -0.2, 99])
        self.assertEqual(surface.isovalues.tolist(), [0.7, -0.2, 99])
        for number, isovalue in enumerate((0.7, -0.2)):
            alone = self.volume.isosurface(isovalue)
            part = surface.part(number)
            for name in ("points", "triangles", "normals"):
                numpy.testing.assert_array_equal(getattr(part, name), getattr(alone, name))
        self.assertTrue(numpy.shares_memory(surface.part(1).points, surface.points))
        self.assertEqual((surface.part(2).points.shape, surface.part(2).triangles.shape), ((0, 3), (0, 3)))
        self.assertRaises(IndexError, surface.part, 3)

    def test_arrays_own_the_memory_and_outlive_the_surface(self):
        surface = self.volume.isosurface(0.4, normals=False)
        self.assertIsNone(surface.normals)
        points, copy = surface.points, surface.points.copy()
        self.assertFalse(points.flags.owndata)
        self.assertTrue(points.flags.writeable)
        del surface
        self.volume.close()
        gc.collect()
        numpy.testing.assert_array_equal(points, copy)

    def test_levels_regions_and_blocks(self):
        coarse = si.create(self.samples[::2, ::2, ::2], self.path("coarse.bvol"), spacing=(1, 2, 4))
        for surface in (self.volume.isosurface(0.4, level=1), self.volume.level(1).isosurface(0.4)):
            self.assertEqual(
                sorted(map(tuple, surface.points)), sorted(map(tuple, coarse.isosurface(0.4).points))
            )
        boxes = self.volume.active_blocks(0.4)
        crossed = 0
        for box in boxes:
            block = self.volume[tuple(slice(*ends) for ends in box)]
            crossed += block.min() < 0.4 <= block.max()
        self.assertEqual(crossed, len(boxes))
        self.assertEqual(len(self.volume.active_blocks(99)), 0)
        region = (0, 3, 0, 3, 0, 3)
        self.assertEqual(self.volume.active_blocks(0.4, region=region).tolist(), [[[0, 33], [0, 33], [0, 33]]])
        inside = self.volume.isosurface(0.4, region=region)
        self.assertTrue((inside.points.max(axis=0) <= (16, 32, 64)).all())
        self.assertGreater(len(inside.triangles), 1000)

    def test_spectrum_counts_the_triangles_of_each_isosurface(self):
        bytes_of_waves = (60 * self.samples + 120).astype(numpy.uint8)
        volume = si.create(bytes_of_waves, self.path("bytes.bvol"), spacing=(0.5, 1, 2))
        spectrum = volume.spectrum()
        for row in (40, 77, 130):
            surface = volume.isosurface(spectrum.isovalues[row], normals=False)
            self.assertEqual(len(surface.triangles), spectrum.triangles[row])
            self.assertEqual(len(volume.active_blocks(spectrum.isovalues[row])), spectrum.blocks[row])
            corners = surface.points[surface.triangles].astype(float)
            area = numpy.linalg.norm(
                numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            ).sum() / 2
            self.assertAlmostEqual(spectrum.area[row] / area, 1, delta=0.1)
        self.assertTrue((numpy.diff(spectrum.volume) <= 0).all())

    def test_components_magnitudes_and_attributes(self):
        vectors = numpy.stack([self.samples, self.samples * 2, -self.samples], axis=-1)
        volume = si.create({"v": vectors, "waves": self.samples}, self.path("v.bvol"), spacing=(0.5, 1, 2))
        alone = self.volume.isosurface(0.4)
        numpy.testing.assert_array_equal(volume.isosurface(0.4, component=0).points, alone.points)
        self.assertEqual(len(volume.isosurface(0.8, component=1).points), len(alone.points))
        magnitude = volume.isosurface(0.9, attributes=["waves", "v"])
        self.assertEqual(magnitude.attributes["v"].shape, (len(magnitude.points), 3))
        numpy.testing.assert_allclose(abs(magnitude.attributes["waves"]), 0.9 / numpy.sqrt(6), atol=0.02)
        self.assertRaisesRegex(IndexError, "'v' has 3 components, and no 3", volume.isosurface, 1, component=3)
        self.assertRaises(KeyError, volume.isosurface, 1, attributes=["mass"])

    def test_bad_arguments_are_errors(self):
        self.assertRaises(ValueError, self.volume.isosurface, [])
        self.assertRaises(ValueError, self.volume.isosurface, "high")
        self.assertRaises(ValueError, self.volume.isosurface, 1, region=(1, 2, 3))
        self.assertRaises(IndexError, self.volume.isosurface, 1, level=99)
        self.assertRaises(TypeError, self.volume.isosurface)
        self.assertEqual(len(self.volume.isosurface(float("nan")).triangles), 0)

    def test_many_threads_extract_at_once(self):
        expected = {isovalue: self.volume.isosurface(isovalue).points for isovalue in (0.1, 0.2, 0.3, 0.4)}
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for _ in range(5):
                for isovalue, surface in zip(expected, pool.map(self.volume.isosurface, expected)):
                    numpy.testing.assert_array_equal(surface.points, expected[isovalue])

    def test_other_threads_run_meanwhile(self):
        """Where Python takes the GIL from nobody, this thread goes on before the other one has ended."""
        volume = si.create(make_waves((160, 160, 160)), self.path("large.bvol"))
        write_nrrd(self.path("large.nrrd"), volume[...], packed=True)
        foreign = si.open(self.path("large.nrrd"))
        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        for work in (
            lambda: volume.isosurface(0.4),
            lambda: [volume[...] for _ in range(5)],
            lambda: foreign[...],
            lambda: foreign.spectrum(),
            lambda: si.create(foreign, self.path("again.bvol")),
        ):
            order = []
            worker = threading.Thread(target=lambda work=work: [order.append("begin"), work(), order.append("end")])
            sys.setswitchinterval(1000)
            worker.start()
            order.append("meanwhile")
            worker.join()
            sys.setswitchinterval(interval)
            self.assertEqual(order, ["begin", "meanwhile", "end"])

    @unittest.skipUnless(meshio, "there is no meshio")
    def test_meshio_writes_a_surface(self):
        surface = self.volume.isosurface([0.4, 0.6])
        surface.to_meshio().write(self.path("s.vtu"))
        read = meshio.read(self.path("s.vtu"))
        numpy.testing.assert_array_equal(read.points, surface.points)
        numpy.testing.assert_array_equal(read.cells_dict["triangle"], surface.triangles)

    def test_what_is_not_there_is_an_import_error(self):
        script = (
            "import sys\nfor name in ('vtkmodules', 'pyvista', 'meshio'): sys.modules[name] = None\n"
            "import scalable_isosurface as si\n"
            f"surface = si.open({self.path('waves.bvol')!r}).isosurface(0.4)\n"
            "for name in ('vtk', 'pyvista', 'meshio'):\n"
            "    try: getattr(surface, 'to_' + name)()\n"
            "    except ImportError as error: print(error)\n"
            "print(any(name.startswith('vtk') and module for name, module in sys.modules.items()))\n"
        )
        said = subprocess.run([sys.executable, "-B", "-c", script], capture_output=True, text=True, check=True).stdout
        lines = said.splitlines()
        self.assertRegex(lines[0], r"to_vtk\(\) needs the Python modules of VTK")
        self.assertRegex(lines[1], r"to_pyvista\(\) needs PyVista")
        self.assertRegex(lines[2], r"to_meshio\(\) needs meshio")
        self.assertEqual(lines[3], "False")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
