# SPDX-License-Identifier: BSD-3-Clause
"""Volumes as arrays: what scalable_isosurface.open gives, beside NumPy's own copy of the samples."""

import concurrent.futures
import glob
import os
import pickle
import random
import shutil
import signal
import sys
import threading
import time
import unittest
import warnings

import numpy

import scalable_isosurface as si
from volume_fixtures import make_samples, make_waves, SHAPE, TYPES, VolumeTest, write_nrrd

try:
    import h5py
except ImportError:
    h5py = None
try:
    import zarr
except ImportError:
    zarr = None


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
            volume = si.create(samples, self.path("tuples.bvol"), compression="zstd", overwrite=True)
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

    def test_a_file_is_opened_at_another_place(self):
        samples = make_waves()
        write_nrrd(self.path("waves.nrrd"), samples)
        place = {"spacing": (1, 2, 4), "origin": (0, -10, 5), "length_unit": "um"}
        volume = si.open(self.path("waves.nrrd"), **place)
        for opened in (volume, pickle.loads(pickle.dumps(volume))):
            found = opened.spacing, opened.origin, opened.length_unit
            self.assertEqual(found, ((1, 2, 4), (0, -10, 5), "um"))
        file = si.open(self.path("waves.nrrd"))
        self.assertEqual((file.spacing, file.origin), ((0.5, 1, 2), (10, 20, 30)))
        points = (file.isosurface(0.3).points - file.origin) * 2 + volume.origin
        numpy.testing.assert_allclose(volume.isosurface(0.3).points, points, atol=1e-4)
        si.index(self.path("waves.nrrd"))
        numpy.testing.assert_allclose(si.open(self.path("waves.nrrd"), **place).isosurface(0.3).points, points, atol=1e-4)
        for error, wrong in (
            ("spacing is x, y, z, and not 1", {"spacing": 1}),
            ("Spacing is set to 1, 0, 1: distances are finite and above 0", {"spacing": (1, 0, 1)}),
            ("origin has a number that is not finite", {"origin": (0, 0, float("inf"))}),
            ("furlong is no unit of length", {"length_unit": "furlong"}),
        ):
            with self.assertRaisesRegex(ValueError, error):
                si.open(self.path("waves.nrrd"), **wrong)

    def test_units_are_told_and_kept(self):
        samples = make_samples("uint8")
        plain = si.create(samples, self.path("plain.bvol"))
        self.assertEqual((plain.length_unit, plain.unit), ("", ""))
        volume = si.create(samples, self.path("v.bvol"), spacing=(0.5, 1, 2), length_unit="micrometer")
        self.assertEqual(volume.length_unit, "um")
        self.assertEqual(si.create(volume, self.path("copy.bvol")).length_unit, "um")
        # Another spacing may be in another unit.
        self.assertEqual(si.create(volume, self.path("even.bvol"), spacing=(1, 1, 1)).length_unit, "")
        with self.assertRaisesRegex(ValueError, "length_unit: furlong is no unit of length"):
            si.create(samples, self.path("none.bvol"), length_unit="furlong")

    def test_an_array_along_one_axis_chooses_what_it_chooses_in_numpy(self):
        samples = make_samples("int16", (*SHAPE, 3))
        volume = si.create(samples, self.path("v.bvol"))
        mask = numpy.arange(SHAPE[1]) % 5 < 2
        keys = [
            [1, 5, 9], [], (..., [2, 0]), numpy.array([7, 3, 3, -1], numpy.int8), (slice(None), mask),
            (slice(3, 1, -1), slice(None, None, 7), [40, 1, 2]), (2, slice(None), [1, 5]), ([4, 2], 3),
            (None, [0, 30], ..., 1), (slice(0, 0), [1]), (slice(None), numpy.zeros(SHAPE[1], bool)),
            numpy.array([8], numpy.uint64), [numpy.int32(3)], [True] + [False] * (SHAPE[0] - 1),
        ]  # fmt: skip
        for key in keys:
            with self.subTest(key=key):
                numpy.testing.assert_array_equal(volume[key], samples[key])
                self.assertEqual(volume[key].dtype, samples.dtype)
        for key in ([SHAPE[0]], [-SHAPE[0] - 1], (slice(None), mask[1:])):
            with self.subTest(key=key):
                self.assertRaises(IndexError, lambda: samples[key])
                self.assertRaises(IndexError, lambda: volume[key])

    def test_elements_one_by_one_are_refused_in_clear_words(self):
        volume = si.create(make_samples("uint8"), self.path("v.bvol"))
        keys = ([1, 2], [1, 2]), [[1, 2]], numpy.ones(SHAPE, bool), True, (0, False)
        for key in keys:
            with self.assertRaisesRegex(TypeError, "indexed by integers, slices, Ellipsis"):
                volume[key]

    def test_arrays_that_are_no_indices_are_index_errors_in_the_words_of_numpy(self):
        samples = make_samples("uint8")
        volume = si.create(samples, self.path("v.bvol"))
        for key in ([1.5], ["a"], numpy.zeros((2, 2)), (0, numpy.array([0.0]))):
            with self.subTest(key=key):
                with self.assertRaises(IndexError) as expected:
                    samples[key]
                with self.assertRaises(IndexError) as raised:
                    volume[key]
                self.assertEqual(str(raised.exception), str(expected.exception))

    def test_arguments_of_wrong_types_and_values_are_told_by_name(self):
        volume = si.create(make_waves(), self.path("v.bvol"))
        path = self.path("v.bvol")
        for name, error, call in (
            ("step", TypeError, lambda: si.open(path, "1")),
            ("step", TypeError, lambda: volume.at(0.5)),
            ("axes", TypeError, lambda: si.open(self.path(".v.bvol.stores"), axes=3)),
            ("index_folder", TypeError, lambda: si.open(path, index_folder=3)),
            ("threads", TypeError, lambda: si.open(path, threads="many")),
            ("threads", ValueError, lambda: si.open(path, threads=-1)),
            ("path", TypeError, lambda: si.index(None)),
            ("path", ValueError, lambda: si.open("v\0.bvol")),
            ("level", TypeError, lambda: volume.level(None)),
            ("component", TypeError, lambda: volume.spectrum("x")),
            ("isovalue", TypeError, lambda: volume.isosurface(None)),
            ("isovalue", TypeError, lambda: volume.isosurface("skin")),
            ("isovalue", TypeError, lambda: volume.isosurface(b"5")),
            ("isovalue", TypeError, lambda: volume.isosurface(10**400)),
            ("name", ValueError, lambda: si.create(make_waves(), self.path("w.bvol"), name="\udcff")),
            ("isovalue", TypeError, lambda: volume.isosurface(1j)),
            ("isovalue", ValueError, lambda: volume.isosurface(numpy.nan)),
            ("isovalue", ValueError, lambda: volume.active_blocks([0, numpy.inf])),
            ("region", TypeError, lambda: volume.isosurface(0, region="all")),
            ("region", ValueError, lambda: volume.isosurface(0, region=(0, 1))),
            ("region", ValueError, lambda: volume.isosurface(0, region=[0, 1, 0, 1, 0, numpy.nan])),
            ("path", TypeError, lambda: si.create(make_waves(), 3)),
            ("spacing", TypeError, lambda: si.create(make_waves(), self.path("w.bvol"), spacing="mm")),
            ("origin", ValueError, lambda: si.create(make_waves(), self.path("w.bvol"), origin=(0, 0, numpy.inf))),
            ("time", TypeError, lambda: si.create(make_waves(), self.path("w.bvol"), time="now")),
            ("name", TypeError, lambda: si.create(make_waves(), self.path("w.bvol"), name=3)),
            ("block_size", TypeError, lambda: si.create(make_waves(), self.path("w.bvol"), block_size=16.0)),
            ("memory", ValueError, lambda: si.create(make_waves(), self.path("w.bvol"), memory=-1)),
            ("compression", TypeError, lambda: si.create(make_waves(), self.path("w.bvol"), compression=None)),
        ):
            with self.subTest(name=name), self.assertRaisesRegex(error, rf"\b{name}\b") as raised:
                call()
            self.assertNotIn("incompatible function arguments", str(raised.exception))

    def test_names_that_are_not_utf8_open_and_are_told(self):
        path = os.fsdecode(os.fsencode(self.folder) + b"/caf\xe9.bvol")
        samples = make_samples("uint8")
        volume = si.create(samples, path)
        numpy.testing.assert_array_equal(si.open(path)[...], samples)
        self.assertEqual(volume.path, path)
        shutil.rmtree(os.path.join(self.folder, "." + os.path.basename(path) + ".stores"))
        with self.assertRaisesRegex(OSError, r"caf\\xe9.bvol") as raised:
            volume.level(1)[...]
        str(raised.exception).encode()
        write_nrrd(path[:-4] + "nrrd", make_waves())
        self.assertEqual(si.open(path[:-4] + "nrrd").shape, SHAPE)
        with self.assertRaisesRegex(ValueError, "not UTF-8"):  # the header of an index names the file
            si.index(path[:-4] + "nrrd")

    def test_ctrl_c_stops_a_gzip_stream(self):
        """The last slice alone, whose bytes come after all others."""
        samples = numpy.zeros((600, 512, 512), numpy.float32)
        write_nrrd(self.path("v.nrrd"), samples, packed=True)
        volume = si.open(self.path("v.nrrd"))

        def interrupt(*_):
            raise KeyboardInterrupt

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, interrupt))
        self.addCleanup(signal.setitimer, signal.ITIMER_REAL, 0)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with self.assertRaises(KeyboardInterrupt):
            for _ in range(50):  # each takes longer than that
                si.open(self.path("v.nrrd"))[-1]
        numpy.testing.assert_array_equal(volume[-1], samples[-1])

    def test_a_child_that_is_forked_while_a_thread_reads_is_told(self):
        samples = make_samples("float64", (200, 200, 200))
        volume = si.create(samples, self.path("v.bvol"), compression="zstd:9")
        ends = threading.Event()

        def read():
            while not ends.is_set():
                volume[...]

        thread = threading.Thread(target=read)
        thread.start()
        answers = set()
        try:
            for _ in range(20):
                time.sleep(0.01)
                child = os.fork()
                if child == 0:
                    code = 9
                    try:
                        code = 0 if volume[3, 4, 5] == samples[3, 4, 5] else 8
                    except RuntimeError as error:
                        code = 1 if "forked while another thread" in str(error) else 7
                    finally:
                        os._exit(code)
                answers.add(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        finally:
            ends.set()
            thread.join()
        self.assertLessEqual(answers, {0, 1})
        self.assertIn(1, answers)
        child = os.fork()  # nobody reads now
        if child == 0:
            os._exit(0 if volume[3, 4, 5] == samples[3, 4, 5] else 8)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)

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
        for folder, _, names in os.walk(self.path(".v.bvol.stores/000001/store-00000")):
            for name in names:
                with open(os.path.join(folder, name), "r+b") as file:
                    content = file.read()
                    file.seek(0)
                    file.write(content.replace(b"\xab" * 9, b"\xba" * 9))
        volume = si.open(self.path("v.bvol"))
        for key in (slice(0, 32), slice(64, None, 3), slice(None, None, 64), slice(90, None, -70), -1, [64, 0, 31]):
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
        with self.assertRaisesRegex(ValueError, "waves.nrrd: cannot be read with the axes"):
            si.open(self.path("waves.nrrd"), axes="xyz")
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

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_a_loop_over_steps_without_an_index_keeps_one_step_in_memory(self):
        shape = (200, 200, 200)
        with h5py.File(self.path("v.h5"), "w") as file:
            data = file.create_dataset("v", (10, *shape), "u1", chunks=(1, 20, 200, 200))
            for step in range(len(data)):
                data[step] = make_samples("uint8", shape, step)
        volume = si.open(self.path("v.h5:/v"), axes="tzyx")
        resident = []
        for step in range(volume.steps):
            self.assertEqual(len(volume.at(step).isosurface(1000).triangles), 0)
            with open("/proc/self/statm") as file:
                resident.append(int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE"))
        self.assertLess(resident[-1] - resident[1], 4 * volume.nbytes)
        self.assertGreater(len(volume.at(0).active_blocks(100)), 300)  # read once more

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_what_of_a_file_is_not_used_is_a_warning(self):
        with h5py.File(self.path("run.h5"), "w") as file:
            file["data"] = make_samples("int8")
            file["data"].attrs["weather"] = "fair"
        name = self.path("run.h5:/data")
        told = "run.h5:/data: attributes that are not used: weather"
        for work in (si.open, si.index, lambda source: si.create(source, self.path("out.bvol"), overwrite=True)):
            for index in glob.glob(self.path("*-data.bvol")):
                os.remove(index)
            with self.assertWarnsRegex(UserWarning, told) as caught:
                work(name)
            self.assertEqual(os.path.basename(caught.filename), os.path.basename(__file__))

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_attributes_are_those_that_h5py_reads(self):
        attributes = {
            "units": "counts", "names": ["a", "bü"], "gain": 1.5, "count": -3, "large": numpy.uint64(2**64 - 1),
            "list": numpy.float32([1.5, 2.5]), "matrix": numpy.arange(6).reshape(2, 3), "one": numpy.int8([7]),
            "yes": True, "none": h5py.Empty("f4"), "pair": numpy.zeros(1, [("a", "u1"), ("b", "i2")]),
        }
        with h5py.File(self.path("run.h5"), "w") as file:
            file["data"] = make_samples("int8")
            for key, value in attributes.items():
                file["data"].attrs[key] = value
            file["other"] = make_samples("uint8")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            volumes = [open_it(self.path("run.h5:/data")) for open_it in (si.open, si.index)]
        expected = {**attributes, "matrix": [0, 1, 2, 3, 4, 5], "none": None, "pair": None}
        for volume in volumes:
            found = volume.attributes
            self.assertEqual(set(found), set(expected))
            for key, value in expected.items():
                self.assertEqual(found[key], value.tolist() if isinstance(value, numpy.ndarray) else value, key)
            self.assertEqual(volume.datasets, ("/data", "/other"))
        self.assertEqual((si.open(self.path("run.h5:/other")).attributes, volume.unit), ({}, "counts"))
        copy = si.create(volume, self.path("copy.bvol"))
        self.assertEqual((copy.attributes, copy.datasets), ({}, ()))

    @unittest.skipUnless(zarr, "there is no Zarr")
    def test_levels_of_ome_zarr_are_datasets_and_attributes_those_of_the_image(self):
        samples = make_samples("uint8")
        group = zarr.open_group(self.path("image.zarr"), mode="w")
        group["0"], group["1"] = samples, samples[::2, ::2, ::2] // 2
        group["1"].attrs["made"] = "by averages"
        group.attrs["who"] = "me"
        group.attrs["multiscales"] = [{
            "version": "0.4", "axes": [{"name": axis, "type": "space"} for axis in "zyx"],
            "datasets": [
                {"path": str(level), "coordinateTransformations": [{"type": "scale", "scale": [2**level] * 3}]}
                for level in range(2)
            ],
        }]
        volume = si.open(self.path("image.zarr"))
        self.assertEqual((volume.levels, volume.datasets), (1, ("0", "1")))
        self.assertEqual(volume.attributes, dict(group.attrs))
        coarse = si.open(self.path("image.zarr:1"))
        numpy.testing.assert_array_equal(coarse[...], group["1"][...])
        self.assertEqual((coarse.spacing, coarse.attributes["made"], coarse.attributes["who"]),
                         ((2, 2, 2), "by averages", "me"))

    def test_arrays_of_numpy_are_read_where_they_lie(self):
        for dtype in ("uint8", "<f4", ">i2", "float64"):
            samples = make_samples(numpy.dtype(dtype).name).astype(dtype)
            numpy.save(self.path("a.npy"), samples)
            volume = si.open(self.path("a.npy"))
            self.assertEqual(volume.path, self.path("a.npy"))
            for opened in (volume, pickle.loads(pickle.dumps(volume))):
                numpy.testing.assert_array_equal(opened[...], samples)
        indexed = si.index(self.path("a.npy"))
        self.assertGreater(indexed.levels, 1)
        numpy.testing.assert_array_equal(indexed[3], samples[3])
        numpy.testing.assert_array_equal(si.create(self.path("a.npy"), self.path("a.bvol"))[...], samples)
        for array in (samples[0], numpy.asfortranarray(samples), samples > 0, samples.astype("f2"), samples[:0],
                      numpy.zeros((2, 2, 2), object)):
            numpy.save(self.path("b.npy"), array)
            self.assertRaisesRegex(OSError, "b.npy: cannot be read: ", si.open, self.path("b.npy"))
        os.truncate(self.path("a.npy"), 1000)
        self.assertRaisesRegex(OSError, "a.npy: cannot be read: ", si.open, self.path("a.npy"))
        for text in (b"", b"no array at all"):
            with open(self.path("c.npy"), "wb") as file:
                file.write(text)
            self.assertRaisesRegex(OSError, "c.npy: cannot be read: ", si.open, self.path("c.npy"))

    def test_what_cannot_be_read_is_told_what_can(self):
        with open(self.path("a.vti"), "w", encoding="ascii") as file:
            file.write("<VTKFile/>")
        with self.assertRaisesRegex(OSError, "a.vti: .* MetaImage, NRRD, .*, raw. What VTK reads .*: blockvolume "):
            si.open(self.path("a.vti"))

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

    def test_a_pickled_volume_finds_its_index_from_another_folder(self):
        write_nrrd(self.path("waves.nrrd"), make_waves())
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        pickled = pickle.dumps(si.index("waves.nrrd", index_folder="indices").level(2))
        os.chdir("/")
        self.assertEqual(pickle.loads(pickled).shape, (10, 13, 18))

    def test_as_many_threads_as_are_wanted_index_a_file_and_read_it_into_memory(self):
        write_nrrd(self.path("noise.nrrd"), make_samples("float32", (160, 160, 160)))

        def count_threads(work):
            """The most threads that the process has meanwhile, besides those that it has now."""
            before = len(os.listdir("/proc/self/task"))
            most = 0
            with concurrent.futures.ThreadPoolExecutor(1) as pool:
                done = pool.submit(work)
                while not done.done():
                    most = max(most, len(os.listdir("/proc/self/task")))
            return most - before

        # One core, so one thread if none are wanted; two or three others read ahead and write.
        self.addCleanup(os.sched_setaffinity, 0, os.sched_getaffinity(0))
        os.sched_setaffinity(0, list(os.sched_getaffinity(0))[:1])
        volume = si.open(self.path("noise.nrrd"), threads=9)
        for work in (
            lambda: si.index(self.path("noise.nrrd"), index_folder=self.folder, threads=9),
            lambda: volume.isosurface(1e9),
        ):
            self.assertGreaterEqual(count_threads(work), 9)

    def test_a_file_that_is_rewritten_while_it_is_open_is_an_error(self):
        samples = make_waves()
        for has_index in (False, True):
            write_nrrd(self.path("waves.nrrd"), samples)
            volume = si.index(self.path("waves.nrrd")) if has_index else si.open(self.path("waves.nrrd"))
            numpy.testing.assert_array_equal(volume[3], samples[3])
            volume.isosurface(0.4)
            write_nrrd(self.path("waves.nrrd"), samples + 1)
            os.utime(self.path("waves.nrrd"), ns=(0, 1))
            for read in (lambda: volume[3], lambda: volume[4], lambda: volume.isosurface(0.4)):
                with self.assertRaisesRegex(OSError, "waves.nrrd: was changed since"):
                    read()
            numpy.testing.assert_array_equal(si.open(self.path("waves.nrrd"))[3], samples[3] + 1)

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
        for folder, _, names in os.walk(self.path(".v.bvol.stores/000001/store-00000")):
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
        shutil.rmtree(self.path(".v.bvol.stores/000001/store-00001"))
        numpy.testing.assert_array_equal(si.open(self.path("v.bvol"))[...], samples)
        with self.assertWarnsRegex(UserWarning, "v.bvol"):
            surface = si.open(self.path("v.bvol")).isosurface(0.4)
        self.assertEqual(sorted(map(tuple, surface.points)), sorted(map(tuple, expected.points)))
        shutil.rmtree(self.path(".v.bvol.stores/000001/store-00002"))
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
