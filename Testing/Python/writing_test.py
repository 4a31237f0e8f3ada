# SPDX-License-Identifier: BSD-3-Clause
"""What scalable_isosurface.create writes of arrays and files comes back."""

import multiprocessing
import os
import pickle
import sys
import unittest
import warnings

import numpy

import scalable_isosurface as si
from volume_fixtures import make_samples, make_waves, SHAPE, VolumeTest, write_nrrd

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


class Writing(VolumeTest):
    def check_round_trip(self, source, samples, **settings):
        volume = si.create(source, self.path("out.bvol"), overwrite=True, **settings)
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
        self.assertEqual((coarse.spacing, coarse.times), ((6, 4, 2), (2,)))
        numpy.testing.assert_array_equal(coarse[...], make_samples("int8", seed=2)[::2, ::2, ::2])

    def test_a_file_of_several_steps_is_not_replaced_by_its_first_one(self):
        for number in range(2):
            si.create(make_samples("int8", seed=number), self.path("a.bvol"), time=number, append=number > 0)
        with self.assertRaisesRegex(ValueError, "a.bvol: is its own source"):
            si.create(self.path("a.bvol"), self.path("a.bvol"), compression="zstd", overwrite=True)
        numpy.testing.assert_array_equal(si.open(self.path("a.bvol"), 1)[...], make_samples("int8", seed=1))

    def test_a_file_is_not_replaced_by_one_step_or_array_of_it(self):
        for number in range(2):
            si.create(make_samples("int8", seed=number), self.path("a.bvol"), time=number, append=number > 0)
        arrays = {"density": make_samples("int8"), "speed": make_samples("float32")}
        volume = si.create(arrays, self.path("b.bvol"))
        for name, source in (
            ("a.bvol", si.open(self.path("a.bvol"), 1)),
            ("b.bvol", volume),
            ("b.bvol", {"density": volume["density"], "other": make_samples("int8")}),
        ):
            with self.assertRaisesRegex(ValueError, f"{name}: is its own source"):
                si.create(source, self.path(name), overwrite=True)
        numpy.testing.assert_array_equal(si.open(self.path("a.bvol"), 0)[...], make_samples("int8", seed=0))
        again = si.create({name: volume[name] for name in arrays}, self.path("b.bvol"), overwrite=True)
        for name, samples in arrays.items():
            numpy.testing.assert_array_equal(again[name][...], samples)
        longer = si.create(si.open(self.path("a.bvol")), self.path("a.bvol"), time=2, append=True)
        self.assertEqual(longer.times, (0, 1, 2))
        numpy.testing.assert_array_equal(longer[...], make_samples("int8", seed=0))

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_datasets_of_several_steps_replace_what_is_there(self):
        samples = make_samples("int8", (2, *SHAPE))
        with h5py.File(self.path("run.h5"), "w") as file:
            file["data"] = samples
        for _ in range(2):
            volume = si.create(self.path("run.h5:/data"), self.path("out.bvol"), axes="tzyx", overwrite=True)
            numpy.testing.assert_array_equal(volume.at(0)[...], samples[0])
            self.assertEqual(volume.steps, 2)

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_a_file_of_another_format_is_not_replaced(self):
        samples = make_samples("int8")
        with h5py.File(self.path("run.h5"), "w") as file:
            file["data"], file["other"] = samples, samples
        os.link(self.path("run.h5"), self.path("hard.bvol"))
        os.symlink("run.h5", self.path("soft.bvol"))
        samples.tofile(self.path("raw.bvol"))
        with open(self.path("waves.mhd"), "w", encoding="ascii") as header:
            header.write(f"NDims = 3\nDimSize = {SHAPE[2]} {SHAPE[1]} {SHAPE[0]}\nElementType = MET_CHAR\n")
            header.write("ElementDataFile = raw.bvol\n")
        for source, output in (
            (self.path("run.h5:/data"), "hard.bvol"),
            (self.path("run.h5:/data"), "soft.bvol"),
            (si.open(self.path("run.h5:/other")), "hard.bvol"),
            (self.path("hard.bvol:/data"), "hard.bvol"),
            (self.path("waves.mhd"), "raw.bvol"),
        ):
            with self.assertRaisesRegex(ValueError, f"{output}: is "):
                si.create(source, self.path(output), overwrite=True)
        numpy.testing.assert_array_equal(si.open(self.path("run.h5:/other"))[...], samples)
        numpy.testing.assert_array_equal(si.open(self.path("waves.mhd"))[...], samples)

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_an_index_of_several_steps_is_not_replaced_by_its_first_one(self):
        samples = make_samples("int8", (2, *SHAPE))
        with h5py.File(self.path("run.h5"), "w") as file:
            file["data"] = samples
        si.index(self.path("run.h5:/data"), axes="tzyx")
        with self.assertRaisesRegex(ValueError, "run.h5-data.bvol: is its own source"):
            si.create(self.path("run.h5:/data"), self.path("run.h5-data.bvol"), axes="tzyx", overwrite=True)
        numpy.testing.assert_array_equal(si.open(self.path("run.h5:/data"), 1, axes="tzyx")[...], samples[1])

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_arrays_of_several_types_and_chunks_come_back(self):
        arrays = {
            "mask": make_samples("uint8"),
            "density": make_samples("float64"),
            "flow": make_samples("int16", (*SHAPE, 3)),
        }
        with h5py.File(self.path("scan.vtkhdf"), "w") as file:
            group = file.create_group("VTKHDF")
            group.attrs["Type"] = numpy.bytes_("ImageData")
            group.attrs["WholeExtent"] = (0, SHAPE[2] - 1, 0, SHAPE[1] - 1, 0, SHAPE[0] - 1)
            for chunk, (name, samples) in zip(((7, 11, 13), (16, 16, 16), (37, 5, 70, 3)), arrays.items()):
                group.create_dataset(
                    f"PointData/{name}", data=samples, chunks=chunk, compression="gzip", shuffle=True
                )
        for settings in ({}, {"threads": 1}, {"threads": 5}, {"memory": 2**25}):
            volume = si.create(self.path("scan.vtkhdf"), self.path("out.bvol"), overwrite=True, **settings)
            for name, samples in arrays.items():
                numpy.testing.assert_array_equal(volume[name][...], samples)

    @unittest.skipUnless(h5py, "there is no h5py")
    def test_an_error_of_a_later_time_step_leaves_the_older_volume(self):
        older = make_samples("int16")
        si.create(older, self.path("v.bvol"), name="data", time=-1)
        with h5py.File(self.path("damaged.h5"), "w") as file:
            steps = numpy.stack([older, older + 1])
            data = file.create_dataset("data", data=steps, chunks=(1, 16, 16, 16), fletcher32=True)
            chunk = data.id.get_chunk_info(data.id.get_num_chunks() - 1)
            self.assertEqual(chunk.chunk_offset[0], 1)
        with open(self.path("damaged.h5"), "r+b") as file:
            file.seek(chunk.byte_offset)
            file.write(b"damage")
        for append in (False, True):
            with self.assertRaisesRegex(OSError, "damaged.h5"):
                si.create(self.path("damaged.h5"), self.path("v.bvol"), append=append, overwrite=True)
            kept = si.open(self.path("v.bvol"))
            self.assertEqual(kept.times, (-1,))
            numpy.testing.assert_array_equal(kept[...], older)
            self.assertEqual(os.listdir(self.path(".v.bvol.stores")), ["000001"])

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
        for source, error, words in ((Broken(), LookupError, "no such slice"), (Wrong(), ValueError, "shape")):
            self.assertRaisesRegex(error, words, si.create, source, self.path("v.bvol"), overwrite=True)
        numpy.testing.assert_array_equal(si.open(self.path("v.bvol"))[...], samples)  # is as it was

    def test_a_disk_without_room_is_told_before_anything_is_read(self):
        free = os.statvfs(self.path("")).f_bavail * os.statvfs(self.path("")).f_frsize

        class Huge:
            shape = (free // 2**20 // 8 + 1, 1024, 1024)  # of 8 bytes each
            dtype = numpy.dtype("float64")

            def __getitem__(self, key):
                raise RuntimeError("is read")

        if free > 2**41:
            self.skipTest("the disk is too large for a header")
        with self.assertWarnsRegex(UserWarning, "out.bvol: takes up to .* MiB, but its disk has room for") as told:
            with self.assertRaisesRegex(RuntimeError, "is read"):
                si.create(Huge(), self.path("out.bvol"), block_size=64)
        self.assertEqual(told.filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with self.assertRaisesRegex(UserWarning, "its disk has room for"):
                si.create(Huge(), self.path("out.bvol"), block_size=64)
        self.assertFalse(os.path.exists(self.path("out.bvol")))

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
            (samples, {"block_size": 2**32 + 32}),
            (samples, {"stores": 2**32}),
            (samples, {"name": "a\0b"}),
            (samples, {"compression": "lz4\0"}),
            (samples, {"spacing": (0, 0, 0)}),
            (samples, {"compression": "gzip"}),
            (samples, {"compression": "zstd:99"}),
            (samples, {"compression": "zstd:x"}),
            (samples, {"replicas": 2}),
            (samples, {"spacing": (0, 1, 1)}),
            (samples, {"spacing": 1}),
            (samples, {"axes": "zyxc"}),
            (samples, {"axes": "zyt"}),
            (samples, {"axes": "zzyx"[1:] + "x"}),
            (samples, {"time": (0, 1)}),
            (samples, {"origin": (1, 2)}),
            (samples, {"direction": numpy.zeros((3, 3))}),
            (samples, {"direction": numpy.eye(2)}),
        ):
            with self.subTest(settings=settings), self.assertRaises(ValueError):
                si.create(source, target, **settings)
        self.assertRaisesRegex(ValueError, "ends with .bvol", si.create, samples, self.path("v.vti"))
        for dtype in ("complex64", "U3", "O"):
            self.assertRaisesRegex(TypeError, "samples are of int8", si.create, samples.astype(dtype), target)
        self.assertEqual(os.listdir(self.folder), [])
        self.assertRaisesRegex(FileNotFoundError, "folder", si.create, samples, self.path("none/v.bvol"))
        self.assertEqual(os.listdir(self.folder), [])
        with open(self.path("file"), "w"):
            pass
        self.assertRaises(OSError, si.create, samples, self.path("file/v.bvol"))

    def test_a_volume_that_is_there_is_replaced_on_request_alone(self):
        older, newer = make_samples("uint8", (4, 5, 6)), make_samples("uint8", (4, 5, 6), seed=2)
        si.create(older, self.path("v.bvol"))
        with self.assertRaisesRegex(FileExistsError, "v.bvol"):
            si.create(newer, self.path("v.bvol"))
        numpy.testing.assert_array_equal(si.open(self.path("v.bvol"))[...], older)
        numpy.testing.assert_array_equal(si.create(newer, self.path("v.bvol"), overwrite=True)[...], newer)

    def test_axes_name_the_axes_of_an_array(self):
        samples = make_samples("int16", (5, 6, 7, 2))
        for axes in ("zyxc", "cxyz", "xcyz"):
            given = samples.transpose(["zyxc".index(axis) for axis in axes])
            self.check_round_trip(given, samples, axes=axes)
        self.check_round_trip(samples[..., 0].transpose(2, 1, 0), samples[..., 0], axes="xyz")
        steps = make_samples("float32", (3, 5, 6, 7))
        for time, times in ((None, (0, 1, 2)), ((5, 7, 9), (5, 7, 9))):
            volume = si.create(
                steps.transpose(1, 2, 0, 3), self.path("t.bvol"), axes="zytx", time=time, overwrite=True
            )
            self.assertEqual(volume.times, times)
            for step in range(3):
                numpy.testing.assert_array_equal(volume.at(step)[...], steps[step])

    def test_truth_values_are_uint8_and_halves_are_float32(self):
        samples = make_samples("float32", (5, 6, 7))
        self.check_round_trip(samples > 0, (samples > 0).astype("uint8"))
        halves = (samples / 100).astype("float16")
        self.check_round_trip(halves, halves.astype("float32"))

    def test_masked_floats_are_nan_and_masked_integers_an_error(self):
        samples = make_samples("float32", (5, 6, 7))
        masked = numpy.ma.array(samples, mask=samples > 0, fill_value=1e20)
        self.check_round_trip(masked, numpy.where(samples > 0, numpy.nan, samples))
        whole = numpy.ma.array(make_samples("int16", (5, 6, 7)))
        self.check_round_trip(whole, whole.data)
        whole[2, 3, 4] = numpy.ma.masked
        with self.assertRaisesRegex(ValueError, r"'ct' has masked samples, .* array.filled\(VALUE\)"):
            si.create({"ct": whole}, self.path("masked.bvol"))
        self.assertFalse(os.path.exists(self.path("masked.bvol")))

    def test_slices_of_another_type_than_the_array_says_are_an_error(self):
        class Scaled:  # as a variable of NetCDF with a scale_factor
            shape, dtype = (4, 5, 6), numpy.dtype("int16")

            def __getitem__(self, key):
                return numpy.full(self.shape, 0.5)[key]

        with self.assertRaisesRegex(TypeError, "'scalars' has the type int16, but slices of float64"):
            si.create(Scaled(), self.path("scaled.bvol"))

    def test_volumes_are_pickled_by_their_path(self):
        samples = {"scalars": make_samples("int8"), "b": make_samples("uint8")}
        volume = si.create(samples, self.path("v.bvol"))
        chosen = pickle.loads(pickle.dumps(volume["b"].level(1)))
        numpy.testing.assert_array_equal(chosen[...], samples["b"][::2, ::2, ::2])
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            self.assertEqual(pool.apply(numpy.sum, (volume["b"],)), samples["b"].sum())
        pickled = [pickle.dumps(volume["b"]), pickle.dumps(volume.level(5))]
        si.create(samples["scalars"][:2, :2, :2], self.path("v.bvol"), block_size=16, overwrite=True)
        for content, error in zip(pickled, (KeyError, IndexError)):
            self.assertRaises(error, pickle.loads, content)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
