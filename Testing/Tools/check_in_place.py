#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Volumes that blockvolume indexes in place, of files that other libraries and write_zarr3.py write:
check_in_place.py TOOL MPIEXEC SCRATCH CLAIM"""
import filecmp
import json
import os
import sys
import unittest
import warnings

import h5py
import mrcfile
import netCDF4
import nibabel
import numcodecs
import numpy
import tifffile
import zarr

from sample_volumes import SHAPE, SourceCase, list_files, make_samples, run_claim
from write_zarr2 import IS_ZARR_2, create_array, write_array_2
from write_zarr3 import write_array

BIG = {"name": "bytes", "configuration": {"endian": "big"}}


class InPlaceCase(SourceCase):
    def index(self, source, name, *arguments, ranks=1):
        return self.write(source, name, "--in-place", *arguments, ranks=ranks)

    def index_raw(self, samples, name="raw", *arguments):
        """The volume in place of raw samples, which the others must equal but for the header."""
        samples.tofile(self.path(name + ".raw"))
        kind = {"int16": "MET_SHORT", "float32": "MET_FLOAT", "uint8": "MET_UCHAR"}
        with open(self.path(name + ".mhd"), "w") as file:
            file.write("ObjectType = Image\nNDims = 3\nDimSize = %d %d %d\n" % samples.shape[::-1]
                       + f"ElementType = {kind[samples.dtype.name]}\n"
                       f"ElementDataFile = {name}.raw\n")
        return self.index(name + ".mhd", name + ".bvol", *arguments)

    def assert_sound(self, path):
        code, _, err = self.run_tool("--verify", "--quiet", path)
        self.assertEqual((code, err), (0, ""))

    def assert_faulty(self, path, *words):
        code, _, err = self.run_tool("--verify", "--quiet", path)
        self.assertEqual(code, 1)
        for word in words:
            self.assertIn(word, err)

    def assert_equal_stores(self, path, expected):
        """The same checksums of samples, trees, spectra and coarser levels."""
        mine, others = list_files(path), list_files(expected)
        self.assertEqual(sorted(mine), sorted(others))
        for name in mine:
            if name != "header":
                self.assertTrue(filecmp.cmp(mine[name], others[name], shallow=False), name)

    def read_info(self, path):
        code, out, err = self.run_tool("--info", path, "--json", "--spectrum")
        self.assertEqual(code, 0, err)
        return json.loads(out)


class Samples(InPlaceCase):
    def check(self, source, samples, *arguments):
        path = self.index(source, "o.bvol", *arguments)
        self.assert_sound(path)
        self.assert_equal_stores(path, self.index_raw(samples))

    def test_images_channels_and_time_steps_of_ome_tiff(self):
        images = numpy.stack([make_samples("int16", phase=number) for number in range(4)]).reshape(2, 2, *SHAPE)
        with tifffile.TiffWriter(self.path("a.ome.tif"), ome=True) as file:
            file.write(images[0, 0], metadata={"axes": "ZYX", "Name": "other"})
            file.write(images, metadata={"axes": "TCZYX", "Name": "two: steps"}, compression="zlib")
        self.check("a.ome.tif", images[0, 0])
        self.check("a.ome.tif:two: steps", images[1, 1], "--step", "1", "--arrays", "Tiff Scalars 1")
        self.assert_sound(self.index("a.ome.tif:1", "t.bvol", ranks=2))

    def test_samples_of_hdf5_that_are_not_what_they_seem(self):
        samples = make_samples("uint8")
        padded = numpy.full((48, 48, 80), 200, "uint8")
        padded[tuple(slice(size) for size in SHAPE)] = samples
        with h5py.File(self.path("i.ims"), "w", userblock_size=1024) as file:
            group = file.create_group("DataSet/ResolutionLevel 0/TimePoint 0/Channel 0")
            file.create_group("DataSetInfo")
            group.create_dataset("Data", data=padded, chunks=(16, 16, 16), compression="gzip")
            for axis, size in zip("ZYX", SHAPE):
                group.attrs["ImageSize" + axis] = numpy.array([letter.encode() for letter in str(size)], "S1")
        with h5py.File(self.path("b.h5"), "w") as file:
            file.create_dataset("mask", data=(samples > 50)[..., None], chunks=(16, 16, 16, 1), compression="gzip")
        self.check("i.ims", samples)
        self.check("b.h5", (samples > 50).astype("uint8"))

    def test_hdf5(self):
        samples = make_samples("int16")
        layouts = [{}, {"chunks": (10, 37, 33), "compression": "gzip", "shuffle": True},
                   {"chunks": (1, 37, 70), "fletcher32": True}, {"chunks": (64, 64, 128),
                                                                "maxshape": (None, None, None)},
                   {"chunks": (7, 9, 11), "scaleoffset": 0}]
        with h5py.File(self.path("a.h5"), "w") as file:
            for number, layout in enumerate(layouts):
                file.create_dataset(f"d{number}", data=samples.astype(">i2" if number % 2 else "<i2"),
                                    **layout)
        for number, layout in enumerate(layouts):
            with self.subTest(layout=layout):
                self.check(f"a.h5:/d{number}", samples)

    def test_zarr(self):
        samples = make_samples("float32")
        for number, chunk in enumerate(((16, 16, 16), (7, 37, 31), SHAPE, (100, 20, 9))):
            with self.subTest(chunk=chunk):
                create_array(self.path(f"z{number}.zarr"), SHAPE, "<>"[number % 2] + "f4", chunk,
                             order="CF"[number % 2],
                             compressor=numcodecs.Blosc("zstd", 3, 1))[:] = samples
                self.check(f"z{number}.zarr", samples)

    def test_netcdf_mrc_and_nifti(self):
        samples = make_samples("float32")
        with netCDF4.Dataset(self.path("a.nc"), "w") as file:
            for name, size in zip("zyx", SHAPE):
                file.createDimension(name, size)
            file.createVariable("a", "f4", ("z", "y", "x"), zlib=True, chunksizes=(10, 15, 20))[:] = samples
        with mrcfile.new(self.path("a.mrc"), overwrite=True) as file:
            file.set_data(samples)
        nibabel.Nifti1Image(samples.transpose(2, 1, 0), numpy.eye(4)).to_filename(self.path("a.nii"))
        for name in ("a.nc", "a.mrc", "a.nii"):
            with self.subTest(name=name):
                self.check(name, samples)

    @unittest.skipUnless(IS_ZARR_2, "zarr 3 writes no N5")
    def test_n5(self):
        samples = make_samples("float32")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            group = zarr.group(zarr.N5Store(self.path("n.n5")))
            group.create_dataset("a", shape=SHAPE, chunks=(12, 13, 14), dtype="float32",
                                 compressor=numcodecs.GZip(3))[:] = samples
        self.check("n.n5", samples)

    def test_raw_samples_that_their_name_describes(self):
        samples = make_samples("int16")
        samples.astype(">i2").tofile(self.path("s.dat"))
        self.check("s.dat:70x37x41,int16,big-endian", samples)

    def test_shards_and_missing_chunks(self):
        samples = make_samples("int16")
        samples[:20, :20] = -3
        write_array(self.path("s.zarr"), samples, (5, 10, 7), [BIG, {"name": "gzip"}], fill=-3,
                    shard=(20, 20, 35))
        self.check("s.zarr", samples)

    def test_copied_volumes_have_the_same_spectra_and_ranges(self):
        samples = make_samples("int16")
        write_array_2(self.path("c.zarr"), samples, (9, 20, 33))
        mine = self.read_info(self.index("c.zarr", "o.bvol"))
        other = self.read_info(self.write("c.zarr", "copy.bvol", "--distribution", "slab"))
        for entry in ("blocks", "ranges"):
            self.assertEqual(mine["timeSteps"][0][entry], other["timeSteps"][0][entry])
        for name, counts in mine["timeSteps"][0]["spectra"][0].items():
            if name != "bytes":
                self.assertEqual(counts, other["timeSteps"][0]["spectra"][0][name], name)
        self.assertEqual(mine["timeSteps"][0]["source"]["chunk"], [33, 20, 9])
        self.assertEqual(mine["timeSteps"][0]["bytes"], 3 * 4096)
        self.assertNotIn("source", other["timeSteps"][0])

    def test_ranks_write_the_same_files(self):
        samples = make_samples("int16")
        write_array_2(self.path("r.zarr"), samples, (9, 20, 33))
        one = self.index("r.zarr", "one.bvol", "--block-size", "16")
        for ranks in (2, 3):
            path = self.index("r.zarr", f"o{ranks}.bvol", "--block-size", "16", ranks=ranks)
            self.assert_equal_volumes(path, one)

    def test_time_steps_and_channels(self):
        steps = numpy.stack([make_samples("int16", phase=phase) for phase in (0, 1, 2)])
        write_array_2(self.path("t.zarr"), steps, (2, 20, 20, 20))
        path = self.index("t.zarr", "o.bvol")
        self.assert_sound(path)
        self.assertEqual([step["source"]["step"] for step in self.read_info(path)["timeSteps"]],
                         [0, 1, 2])
        with h5py.File(self.path("c.h5"), "w") as file:
            file["rgb"] = numpy.stack([steps[0], steps[1], steps[2]], axis=-1)
        path = self.index("c.h5:/rgb", "o.bvol", "--axes", "zyxc")
        self.assert_sound(path)
        self.assertEqual(len(self.read_info(path)["variables"]), 4)


class ChangesAndErrors(InPlaceCase):
    def setUp(self):
        self.samples = make_samples("int16")
        with h5py.File(self.path("a.h5"), "w") as file:
            file.create_dataset("d", data=self.samples, chunks=(10, 37, 33), compression="gzip")
        self.volume = self.index("a.h5", "v.bvol")

    def test_a_source_that_moves_away_and_is_found_again(self):
        os.rename(self.path("a.h5"), self.path("b.h5"))
        self.assert_faulty(self.volume, "a.h5: has the samples of", "is missing", "--source PATH")
        code, _, err = self.run_tool("--quiet", "--source", "b.h5", self.volume)
        self.assertEqual((code, err), (0, ""))
        self.assert_sound(self.volume)

    def test_the_source_and_the_volume_move_together(self):
        os.makedirs(self.path("new/place"))
        for name in ("a.h5", "v.bvol", ".v.bvol.stores"):
            os.rename(self.path(name), self.path("new/place/" + name))
        self.assert_sound(self.path("new/place/v.bvol"))

    def test_a_changed_source(self):
        with h5py.File(self.path("a.h5"), "r+") as file:
            file["d"][3, 4, 5] += 1
        self.assert_faulty(self.volume, "a.h5: was changed since")
        with open(self.volume, "rb") as file:
            before = file.read()
        code, _, err = self.run_tool("--quiet", "--source", "a.h5", self.volume)
        self.assertEqual(code, 1)
        self.assertIn("has other samples", err)
        with open(self.volume, "rb") as file:
            self.assertEqual(file.read(), before)
        with h5py.File(self.path("a.h5"), "r+") as file:
            file["d"][3, 4, 5] -= 1
        code, _, err = self.run_tool("--quiet", "--source", "a.h5", self.volume)
        self.assertEqual((code, err), (0, ""))
        self.assert_sound(self.volume)

    def test_a_changed_file_behind_a_link_or_a_virtual_dataset(self):
        with h5py.File(self.path("master.h5"), "w") as file:
            file["link"] = h5py.ExternalLink("a.h5", "/d")
            layout = h5py.VirtualLayout(SHAPE, "int16")
            layout[...] = h5py.VirtualSource("a.h5", "d", shape=SHAPE)
            file.create_virtual_dataset("virtual", layout)
            file.create_dataset("external", SHAPE, "int16", external=[("e.raw", 0, self.samples.nbytes)])
            file["own"] = self.samples
        self.samples.tofile(self.path("e.raw"))
        volumes = [self.index(f"master.h5:/{name}", name + ".bvol") for name in ("link", "virtual", "external", "own")]
        for volume in volumes:
            self.assert_sound(volume)
            files = 1 if volume.endswith("own.bvol") else 2
            self.assertEqual(self.read_info(volume)["timeSteps"][0]["source"]["files"], files)
        volumes.pop()
        with h5py.File(self.path("a.h5"), "r+") as file:
            file["d"][3, 4, 5] += 1
        (self.samples + 1).tofile(self.path("e.raw"))
        for volume in volumes:
            self.assert_faulty(volume, "master.h5:/", "was changed since")

    def test_refusals_are_one_line(self):
        self.samples.tofile(self.path("x.raw"))
        self.assert_error("x.raw", "--in-place", ".mhd", arguments=(
            "--in-place", "--dimensions", "70,37,41", "--type", "int16"))
        code, _, err = self.run_tool("--source", "a.h5", "nothing.bvol")
        self.assertEqual((code, err.count("\n")), (1, 1), err)
        copy = self.write("a.h5", "copy.bvol")
        code, _, err = self.run_tool("--source", "a.h5", copy)
        self.assertEqual((code, err.count("\n")), (1, 1), err)
        self.assertIn("it is not in place", err)
        code, _, err = self.run_tool("--quiet", "a.h5", copy, "--append", "--time", "2",
                                     "--in-place", "--stores", "3")
        self.assertEqual(code, 1)


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, {case.__name__: case for case in (Samples, ChangesAndErrors)}))
