#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Files of h5py, read by blockvolume: check_hdf5.py TOOL MPIEXEC SCRATCH CLAIM"""
import hashlib
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import time

import h5py
import numpy

from sample_volumes import SHAPE, TYPES, SourceCase, get_stores, list_files, make_samples, remove_volume, run_claim


class Datasets(SourceCase):
    def test_all_types_and_byte_orders(self):
        with h5py.File(self.path("a.h5"), "w") as file:
            for name in TYPES:
                for order in "<>":
                    dtype = numpy.dtype(name).newbyteorder(order)
                    file[f"types/{name}{'lb'[order == '>']}/data"] = make_samples(dtype)
        for number, name in enumerate(TYPES):
            expected = self.write_raw(make_samples(name), "data")
            for order in "lb" if name == "int16" else "lb"[number % 2]:
                with self.subTest(type=name, order=order):
                    path = self.write(f"a.h5:/types/{name}{order}/data", "o.bvol")
                    self.assert_equal_volumes(path, expected)

    def test_chunks_and_filters_on_any_ranks(self):
        samples = make_samples("int16")
        layouts = {"plain": {}, "whole": {"chunks": SHAPE}, "odd": {"chunks": (7, 11, 13)},
                   "gzip": {"chunks": (16, 16, 16), "compression": "gzip", "shuffle": True},
                   "szip": {"chunks": (16, 37, 16), "compression": "szip", "fletcher32": True},
                   "scaled": {"chunks": (8, 8, 8), "scaleoffset": 0}}
        with h5py.File(self.path("c.h5"), "w") as file:
            for name, layout in layouts.items():
                file.create_dataset(name + "/data", data=samples, **layout)
        expected = self.write_raw(samples, "data")
        for name in layouts:
            for ranks, memory in ((1, "8"), (3, "1024")) if name == "odd" else ((1, "1024"),):
                with self.subTest(layout=name, ranks=ranks, memory=memory):
                    path = self.write(f"c.h5:{name}/data", "o.bvol", "--memory", memory,
                                      ranks=ranks)
                    self.assert_equal_volumes(path, expected)

    def test_half_floats_are_read_as_floats(self):
        samples = make_samples("float16")
        with h5py.File(self.path("f.h5"), "w") as file:
            file["data"] = samples
        self.assert_equal_volumes(self.write("f.h5", "o.bvol"),
                                  self.write_raw(samples.astype("float32"), "data"))

    def test_missing_chunks_have_the_fill_value(self):
        samples = numpy.full(SHAPE, 9, "uint8")
        samples[:10, :10, :10] = make_samples("uint8")[:10, :10, :10]
        with h5py.File(self.path("m.h5"), "w") as file:
            data = file.create_dataset("data", SHAPE, "uint8", chunks=(10, 10, 10), fillvalue=9)
            data[:10, :10, :10] = samples[:10, :10, :10]
        self.assert_equal_volumes(self.write("m.h5", "o.bvol"), self.write_raw(samples, "data"))

    def test_axes_of_any_order(self):
        samples = make_samples("uint16")
        with h5py.File(self.path("x.h5"), "w") as file:
            file["data"] = samples.transpose(2, 1, 0)
        path = self.write("x.h5", "o.bvol", "--axes", "xyz")
        self.assert_equal_volumes(path, self.write_raw(samples, "data"))


class TimeStepsAndChannels(SourceCase):
    def test_the_first_of_four_axes_is_time(self):
        steps = numpy.stack([make_samples("float32", phase=step) for step in range(3)])
        with h5py.File(self.path("t.h5"), "w") as file:
            file.create_dataset("data", data=steps, chunks=(1, 16, 16, 16))
        for step in range(3):
            expected = self.write_raw(steps[step], "data", "--time", str(step)) if not step else \
                self.append_raw(steps[step], expected, step)
        path = self.write("t.h5", "o.bvol", ranks=2)
        self.assert_equal_volumes(path, expected)
        path = self.write("t.h5", "o.bvol", "--step", "2")
        self.assert_equal_volumes(path, self.write_raw(steps[2], "data", "--time", "2"))
        self.assert_error("t.h5", "t.h5:/data", "3 time steps", arguments=["--step", "3"])
        self.assert_error("t.h5", "--time", "--step", arguments=["--time", "3"])

    def read_all(self, path):
        return {name: hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()
                for name, file in list_files(path).items()}

    def test_an_error_of_a_later_time_step_leaves_the_older_volume(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(3)])
        with h5py.File(self.path("damaged.h5"), "w") as file:
            data = file.create_dataset("data", data=steps, chunks=(1, 16, 16, 16), fletcher32=True)
            chunk = data.id.get_chunk_info(data.id.get_num_chunks() - 1)
            self.assertEqual(chunk.chunk_offset[0], 2)
        with open(self.path("damaged.h5"), "r+b") as file:
            file.seek(chunk.byte_offset)
            file.write(b"damage")
        with h5py.File(self.path("backward.vtkhdf"), "w") as file:
            group = file.create_group("VTKHDF")
            group.attrs["Type"] = numpy.bytes_("ImageData")
            group.attrs["WholeExtent"] = (0, 69, 0, 36, 0, 40)
            group["PointData/data"] = steps
            group["Steps/Values"] = [2.0, 1.0, 0.0]
        path = self.write_raw(steps[0], "data", "--time", "-1")
        older = self.read_all(path)
        for source in ("damaged.h5", "backward.vtkhdf"):
            for ranks, arguments in ((1, []), (2, []), (1, ["--append"]), (1, ["--sandbox"])):
                with self.subTest(source=source, ranks=ranks, arguments=arguments):
                    code, _, err = self.run_tool(source, path, "--stores", "3", *arguments, ranks=ranks)
                    self.assertEqual(code, 1, err)
                    self.assertEqual(self.read_all(path), older)
                    self.assertEqual(os.listdir(get_stores(path)), ["000001"])
        # What a journal has of a volume in place stays, too, for the next run.
        for told in (0, 2):
            code, out, err = self.run_tool("damaged.h5", path, "--stores", "3", "--in-place")
            self.assertEqual((code, out.count("was finished by an earlier run")), (1, told), err)
            self.assertEqual({name: self.read_all(path)[name] for name in older}, older)
        code, _, err = self.run_tool("damaged.h5", path, "--stores", "3", "--step", "1")
        self.assertEqual(code, 0, err)
        self.assertEqual(os.listdir(get_stores(path)), [json.loads(
            self.run_tool("--info", "--json", path)[1])["timeSteps"][0]["folder"]])

    def test_time_steps_in_place_go_on_after_a_kill(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(12)])
        with h5py.File(self.path("k.h5"), "w") as file:
            file.create_dataset("data", data=steps, chunks=(1, 16, 16, 16), compression="gzip")
        expected = self.read_all(self.write("k.h5", "o.bvol", "--in-place"))
        path = self.path("o.bvol")
        remove_volume(path)
        command = [self.tool, "k.h5", path, "--stores", "3", "--in-place", "--quiet"]
        with subprocess.Popen(command, cwd=self.scratch) as process:
            while not os.path.exists(get_stores(path) + "/000002") and process.poll() is None:
                time.sleep(0.001)
            process.kill()
        self.assertFalse(os.path.exists(path))
        code, out, err = self.run_tool("k.h5", path, "--stores", "3", "--in-place", ranks=2)
        self.assertEqual(code, 0, err)
        self.assertIn("time step 0 was finished by an earlier run", out)
        self.assertEqual(self.read_all(path), expected)

    def append_raw(self, samples, expected, step):
        samples.tofile(self.path("more.raw"))
        code, _, err = self.run_tool(
            "more.raw", expected, "--stores", "3", "--append", "--time", str(step), "--name", "data",
            "--type", samples.dtype.name, "--dimensions", "70,37,41")
        self.assertEqual(code, 0, err)
        return expected

    def test_channels_are_arrays_or_components(self):
        channels = numpy.stack([make_samples("uint8", phase=step) for step in range(3)])
        with h5py.File(self.path("c.h5"), "w") as file:
            file["first"] = channels
            file["last"] = channels.transpose(1, 2, 3, 0)
        path = self.write("c.h5:/first", "o.bvol", "--axes", "czyx", "--arrays", "first 1")
        self.assert_equal_volumes(path, self.write_raw(channels[1], "first 1"))
        self.write("c.h5:/last", "o.bvol", "--axes", "zyxc")
        code, out, _ = self.run_tool("--info", "o.bvol", "--json")
        self.assertEqual(code, 0)
        self.assertIn('"components": 3', out)


class VtkHdf(SourceCase):
    def test_grid_and_arrays(self):
        samples = make_samples("int16")
        with h5py.File(self.path("v.vtkhdf"), "w") as file:
            group = file.create_group("VTKHDF")
            group.attrs["Version"] = (1, 0)
            group.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", 9))
            group.attrs["WholeExtent"] = (0, 69, 0, 36, 0, 40)
            group.attrs["Origin"] = (-1.0, 2.5, 7.0)
            group.attrs["Spacing"] = (0.5, 0.25, 2.0)
            group.attrs["Direction"] = (1.0, 0, 0, 0, 1, 0, 0, 0, 1)
            group["PointData/density"] = samples
            group["PointData/flow"] = numpy.stack([samples, -samples, samples], axis=3)
        expected = self.write_raw(samples, "density", spacing=(0.5, 0.25, 2), origin=(-1, 2.5, 7))
        path = self.write("v.vtkhdf", "o.bvol", "--arrays", "density", ranks=2)
        self.assert_equal_volumes(path, expected)
        self.write("v.vtkhdf", "o.bvol")
        code, out, _ = self.run_tool("--info", "o.bvol", "--json")
        self.assertIn('"components": 3', out)
        with h5py.File(self.path("v.vtkhdf"), "a") as file:
            del file["VTKHDF"].attrs["Type"]
            file["VTKHDF"].attrs["Type"] = "UnstructuredGrid"
        self.assert_error("v.vtkhdf", "v.vtkhdf:/VTKHDF", "UnstructuredGrid", "ImageData alone")

    def test_time_steps(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(2)])
        with h5py.File(self.path("s.vtkhdf"), "w") as file:
            group = file.create_group("VTKHDF")
            group.attrs["Type"] = numpy.bytes_("ImageData")
            group.attrs["WholeExtent"] = (0, 69, 0, 36, 0, 40)
            group["PointData/density"] = steps
            group["Steps/Values"] = [0.25, 4.5]
        path = self.write("s.vtkhdf", "o.bvol", "--step", "1")
        self.assert_equal_volumes(path, self.write_raw(steps[1], "density", "--time", "4.5"))

    def test_time_steps_are_where_their_offsets_say(self):
        def write_steps(entries, offsets):
            with h5py.File(self.path("e.vtkhdf"), "w") as file:
                group = file.create_group("VTKHDF")
                group.attrs["Type"] = numpy.bytes_("ImageData")
                group.attrs["WholeExtent"] = (0, 69, 0, 36, 0, 40)
                group["PointData/data"] = images[:entries]
                group["Steps/Values"] = [0.5, 1, 1.5]
                if offsets:
                    group["Steps/PointDataOffsets/data"] = offsets
        images = numpy.stack([make_samples("int16", phase=entry) for entry in range(4)])
        for entries, offsets in ((2, [1, 0, 1]), (3, [2, 1, 0]), (3, None)):
            write_steps(entries, offsets)
            for step, entry in enumerate(offsets or range(3)):
                path = self.write("e.vtkhdf", "o.bvol", "--step", str(step))
                self.assert_equal_volumes(path, self.write_raw(images[entry], "data", "--time", str(0.5 + 0.5 * step)))
        self.assert_error("e.vtkhdf", "e.vtkhdf:/VTKHDF", "3 time steps, and none of number 3",
                          arguments=["--step", "3"])
        for entries in (2, 4):
            write_steps(entries, None)
            self.assert_error("e.vtkhdf", "Steps/Values has 3 time steps, the point array data has "
                              f"{entries}, and no Steps/PointDataOffsets/data")
        write_steps(3, [0, 1])
        self.assert_error("e.vtkhdf", "/Steps/PointDataOffsets/data: cannot be read: it has 2 numbers for 3 time steps")
        for offset in (-1, 3):
            write_steps(3, [0, offset, 2])
            self.write("e.vtkhdf", "o.bvol", "--step", "2")
            self.assert_error("e.vtkhdf", f"time step 1 has the number {offset}, the point array has 3",
                              arguments=["--step", "1"])
        with h5py.File(self.path("master.h5"), "w") as file:
            file["VTKHDF"] = h5py.ExternalLink("e.vtkhdf", "/VTKHDF")
        self.write("master.h5", "o.bvol", "--step", "2")


class DescribedCase(SourceCase):
    def assert_volume(self, source, samples, array, *arguments, told=(), unit=None, **place):
        """A volume of these samples; standard error has some words."""
        path = self.path("o.bvol")
        remove_volume(path)
        code, _, err = self.run_tool(source, path, "--stores", "3", *arguments)
        self.assertEqual(code, 0, err)
        for word in told:
            self.assertIn(word, err)
        self.assert_equal_volumes(path, self.write_raw(samples, array, *(["--unit", unit] if unit else []), **place))


class Descriptions(DescribedCase):
    """What files say of the axes and the place of a dataset."""

    def test_a_last_axis_of_one_sample_is_a_component(self):
        samples = make_samples("int32")
        with h5py.File(self.path("c.h5"), "w") as file:
            file["data"] = samples[..., None]
            file["steps/data"] = samples[None, ..., None]
        self.assert_volume("c.h5:/data", samples, "data")
        self.write("c.h5:/steps/data", "s.bvol")
        info = json.loads(self.run_tool("--info", "--json", "s.bvol")[1])
        self.assertEqual(info["grid"]["dimensions"], list(SHAPE[::-1]))

    def test_bool_is_uint8_and_names_of_numbers_are_told(self):
        samples = make_samples("uint8")
        kinds = h5py.enum_dtype({"air": 20, "bone": 60, "metal": -3}, basetype="i2")
        with h5py.File(self.path("b.h5"), "w") as file:
            file["mask"] = samples > 50
            file.create_dataset("packed", data=samples > 50, chunks=(8, 8, 8), compression="gzip")
            file.create_dataset("kinds", data=samples.astype("i2"), dtype=kinds)
            self.assertEqual(file["mask"].dtype, bool)
        for name in ("mask", "packed"):
            self.assert_volume("b.h5:/" + name, (samples > 50).astype("uint8"), name)
        self.assert_volume("b.h5:/kinds", samples.astype("int16"), "kinds", told=("20 air", "60 bone", "-3 metal"))
        self.assertRegex(self.run_tool("--list", "b.h5")[1], "/mask +41 x 37 x 70 +bool")

    def test_files_with_a_userblock_are_found_by_their_signature(self):
        samples = make_samples("float32")
        for size in (512, 1024, 8192):
            with h5py.File(self.path("u.bin"), "w", userblock_size=size) as file:
                file["V"] = samples
                file["V"].attrs["MATLAB_class"] = numpy.bytes_("single")
            with open(self.path("u.bin"), "r+b") as file:
                file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
            shutil.copy(self.path("u.bin"), self.path("u.mat"))
            for name in ("u.bin", "u.mat", "u.mat:/V"):
                self.assert_volume(name, samples, "V", told=("index in MATLAB",))
        with open(self.path("old.mat"), "wb") as file:
            file.write(b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x01IM" + bytes(500))
        self.assert_error("old.mat", "old.mat", "MAT-file of version 5", "-v7.3")

    def test_images_of_itk_are_where_they_say(self):
        samples = make_samples("int16")
        with h5py.File(self.path("i.h5"), "w") as file:
            for name, values in (("one", samples), ("three", numpy.stack([samples] * 3, axis=3))):
                image = file.create_group(f"{name}/ITKImage/0")
                image["VoxelData"] = values
                image["Spacing"], image["Origin"] = [0.25, 0.5, 2.0], [10.0, -5, 3]
                image["Directions"] = numpy.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])  # of x, of y, of z
        for name, components in (("one", 1), ("three", 3)):
            self.write(f"i.h5:/{name}/ITKImage/0/VoxelData", "o.bvol")
            info = json.loads(self.run_tool("--info", "--json", "o.bvol")[1])
            grid = info["grid"]
            self.assertEqual((grid["dimensions"], info["arrays"][0]["components"]), (list(SHAPE[::-1]), components))
            self.assertEqual((grid["spacing"], grid["origin"]), ([0.25, 0.5, 2], [10, -5, 3]))
            self.assertEqual(grid["direction"], [0, -1, 0, 1, 0, 0, 0, 0, 1])

    def test_minc_is_refused(self):
        with h5py.File(self.path("m.mnc"), "w") as file:
            file["minc-2.0/image/0/image"] = make_samples("int16")
        self.assert_error("m.mnc", "m.mnc:/minc-2.0/image/0/image: cannot be read: it is MINC")

    def test_cells_of_dream3d_are_where_their_geometry_says(self):
        samples = make_samples("int32")
        middle = {"spacing": (0.25, 0.5, 2), "origin": (10.125, -4.75, 4)}
        with h5py.File(self.path("d.dream3d"), "w") as file:
            geometry = file.create_group("DataContainers/Image/_SIMPL_GEOMETRY")
            geometry["DIMENSIONS"] = numpy.array(SHAPE[::-1], "u8")
            geometry["SPACING"] = numpy.array([0.25, 0.5, 2], "f4")
            geometry["ORIGIN"] = numpy.array([10, -5, 3], "f4")
            file["DataContainers/Image/CellData/FeatureIds"] = samples[..., None]
            file["DataContainers/Image/CellData/Angles"] = numpy.stack([samples] * 3, axis=3)
            geometry = file.create_group("DataStructure/Nx")
            for name, value in (("_DIMENSIONS", SHAPE[::-1]), ("_SPACING", (0.25, 0.5, 2)), ("_ORIGIN", (10, -5, 3))):
                geometry.attrs[name] = value
            geometry["Cell Data/FeatureIds"] = samples[..., None]
        for path in ("DataContainers/Image/CellData", "DataStructure/Nx/Cell Data"):
            self.assert_volume(f"d.dream3d:/{path}/FeatureIds", samples, "FeatureIds", told=("DREAM.3D",), **middle)
        self.write("d.dream3d:/DataContainers/Image/CellData/Angles", "o.bvol")
        self.assertEqual(json.loads(self.run_tool("--info", "--json", "o.bvol")[1])["arrays"][0]["components"], 3)

    def test_axes_have_the_names_coordinates_and_units_of_the_file(self):
        samples = make_samples("int16")
        place = {"spacing": (0.5, 0.25, 2), "origin": (1, -1, 10)}
        lines = {"z": 10 + 2 * numpy.arange(41.0), "y": -1 + 0.25 * numpy.arange(37.0), "x": 1 + 0.5 * numpy.arange(70.0)}

        def write_lines(group, names):
            for name, letter in names.items():
                group[name] = lines[letter]
                group[name].attrs["units"] = "mm"
        with h5py.File(self.path("a.h5"), "w") as file:
            data = file.create_dataset("scales/data", data=samples.transpose(2, 1, 0))
            write_lines(file["scales"], {"x": "x", "y": "y", "z": "z"})
            for axis, name in enumerate("xyz"):
                file["scales/" + name].make_scale(name)
                data.dims[axis].attach_scale(file["scales/" + name])
            nexus = file.create_group("nexus")
            nexus.attrs.update({"NX_class": "NXdata", "signal": "data", "axes": ["z", "rows", "x"]})
            nexus["data"] = samples
            write_lines(nexus, {"x": "x", "rows": "y", "z": "z"})
            emd = file.create_group("emd")
            emd.attrs["emd_group_type"] = 1
            emd["data"] = samples
            write_lines(emd, {"dim1": "z", "dim2": "y", "dim3": "x"})
            emd = file.create_group("array")
            emd.attrs["emd_group_type"] = "array"
            emd["data"] = samples
            write_lines(emd, {"dim0": "z", "dim1": "y", "dim2": "x"})
            file["tags/data"] = samples.transpose(1, 0, 2)
            file["tags/data"].attrs["axistags"] = json.dumps({"axes": [
                {"key": key, "typeFlags": 2, "resolution": step} for key, step in (("y", 0.25), ("z", 2), ("x", 0.5))]})
            file["size/data"] = samples
            file["size/data"].attrs["element_size_um"] = (2, 0.25, 0.5)
            file["odd/data"] = samples
            for axis, label in enumerate(("energy", "y", "x")):
                file["odd/data"].dims[axis].label = label
            uneven = file.create_dataset("uneven/data", data=samples)
            file["uneven/z"] = lines["z"] ** 2
            file["uneven/z"].make_scale("z")
            uneven.dims[0].attach_scale(file["uneven/z"])
        for name in ("scales", "emd", "array"):
            self.assert_volume(f"a.h5:/{name}/data", samples, "data", unit="mm", **place)
        self.assert_volume("a.h5:/nexus/data", samples, "data", told=("z, rows, x",), unit="mm", **place)
        self.assert_volume("a.h5:/tags/data", samples, "data", spacing=place["spacing"])
        self.assert_volume("a.h5:/size/data", samples, "data", unit="um", spacing=place["spacing"])
        self.assert_volume("a.h5:/odd/data", samples, "data", told=("energy, y, x", "--axes"))
        self.assert_volume("a.h5:/uneven/data", samples, "data", told=("equal steps",))

    def test_coordinates_of_the_time_axis_are_times(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(2)])
        with h5py.File(self.path("t.h5"), "w") as file:
            file["data"] = steps
            file["time"] = [0.5, 3.25]
            file["time"].make_scale("time")
            file["data"].dims[0].attach_scale(file["time"])
        self.write("t.h5:/data", "o.bvol")
        info = json.loads(self.run_tool("--info", "--json", "o.bvol")[1])
        self.assertEqual([step["time"] for step in info["timeSteps"]], [0.5, 3.25])

    def test_integers_of_12_bits_and_odd_floats_have_the_values_of_h5py(self):
        samples = make_samples("int16") - 60
        with h5py.File(self.path("p.h5"), "w") as file:
            for name, order, offset in (("plain", h5py.h5t.STD_I16LE, 0), ("shifted", h5py.h5t.STD_I16BE, 4)):
                kind = order.copy()
                kind.set_precision(12)
                kind.set_offset(offset)
                space = h5py.h5s.create_simple(SHAPE)
                h5py.h5d.create(file.id, name.encode(), kind, space).write(h5py.h5s.ALL, h5py.h5s.ALL, samples)
            brain = h5py.h5t.IEEE_F32LE.copy()  # bfloat16
            brain.set_fields(15, 7, 8, 0, 7)
            brain.set_precision(16)
            brain.set_size(2)
            brain.set_ebias(127)
            h5py.h5d.create(file.id, b"brain", brain, h5py.h5s.create_simple(SHAPE)).write(
                h5py.h5s.ALL, h5py.h5s.ALL, samples.astype("float32"))
            self.assertTrue((file["shifted"][...] == samples).all())
        self.assert_volume("p.h5:/plain", samples, "plain")
        self.assert_volume("p.h5:/shifted", samples, "shifted")
        self.assert_volume("p.h5:/brain", samples.astype("float32"), "brain")

    def test_cells_of_bigdataviewer_are_unsigned(self):
        samples = make_samples("uint16") + 40000
        with h5py.File(self.path("v.h5"), "w") as file:
            file.create_dataset("t00000/s00/0/cells", data=samples.view("int16"), chunks=(16, 16, 16),
                                compression="gzip")
        self.assert_volume("v.h5", samples, "cells", told=("BigDataViewer",))


class Imaris(DescribedCase):
    """A dataset is larger than the image, whose size, extents, channels and time points are attributes."""

    def write_imaris(self, name, images, extents=((10, 45), (-5, 13.5), (3, 85)), unit="um"):
        """Images by level, time point and channel."""
        def letters(text):
            return numpy.array([letter.encode() for letter in str(text)], "S1")
        with h5py.File(self.path(name), "w") as file:
            info = file.create_group("DataSetInfo/Image")
            for axis, (low, high) in enumerate(extents):
                info.attrs[f"ExtMin{axis}"], info.attrs[f"ExtMax{axis}"] = letters(low), letters(high)
            info.attrs["Unit"] = letters(unit)
            for level, points in enumerate(images):
                for point, channels in enumerate(points):
                    for channel, image in enumerate(channels):
                        group = file.create_group(
                            f"DataSet/ResolutionLevel {level}/TimePoint {point}/Channel {channel}")
                        padded = numpy.zeros([-(-size // 16) * 16 for size in image.shape], image.dtype)
                        padded[tuple(slice(size) for size in image.shape)] = image
                        group.create_dataset("Data", data=padded, chunks=(16, 16, 16), compression="gzip")
                        for axis, letter in enumerate("ZYX"):
                            group.attrs["ImageSize" + letter] = letters(image.shape[axis])
                        file.require_group(f"DataSetInfo/Channel {channel}").attrs["Name"] = letters(f"Ch{channel}")

    def test_size_place_channels_and_time_points(self):
        images = [[make_samples("uint8", phase=point + 0.5 * channel) for channel in range(2)] for point in range(3)]
        coarse = [[image[::2, ::2, ::2] for image in point] for point in images]
        self.write_imaris("i.ims", (images, coarse))
        place = {"spacing": (0.5, 0.5, 2), "origin": (10.25, -4.75, 4)}
        path = self.write("i.ims", "o.bvol", "--step", "2", "--arrays", "Ch1")
        self.assert_equal_volumes(path, self.write_raw(images[2][1], "Ch1", "--time", "2", "--unit", "um", **place))
        info = json.loads(self.run_tool("--info", "--json", self.write("i.ims", "o.bvol"))[1])
        self.assertEqual([array["name"] for array in info["arrays"]], ["Ch0", "Ch1"])
        self.assertEqual(len(info["timeSteps"]), 3)
        self.assert_volume("i.ims:/DataSet/ResolutionLevel 0/TimePoint 0/Channel 1/Data", images[0][1], "Data",
                           unit="um", **place)
        self.assert_error("i.ims", "axes", arguments=["--axes", "zyx"])

    def test_impossible_sizes_and_extents(self):
        image = make_samples("uint8")
        self.write_imaris("e.ims", [[[image]]], extents=((5, 5), (0, 1), (0, 1)))
        self.assert_volume("e.ims", image, "Ch0", told=("extents are missing or impossible",))
        with h5py.File(self.path("e.ims"), "a") as file:
            group = file["DataSet/ResolutionLevel 0/TimePoint 0/Channel 0"]
            group.attrs["ImageSizeX"] = numpy.array([b"9", b"9", b"9"], "S1")
        self.assert_error("e.ims", "e.ims:/DataSet/ResolutionLevel 0", "999")


class OtherFiles(DescribedCase):
    """Links, virtual datasets and external samples."""

    def setUp(self):
        self.samples = make_samples("int16")

    def write_part(self, name, path="data"):
        with h5py.File(self.path(name), "w") as file:
            file[path] = self.samples

    @staticmethod
    def add_virtual(file, name, other, path):
        layout = h5py.VirtualLayout(SHAPE, "int16")
        layout[...] = h5py.VirtualSource(other, path, shape=SHAPE)
        file.create_virtual_dataset(name, layout)

    def list_paths(self, name):
        code, out, err = self.run_tool("--list", name)
        self.assertEqual(code, 0, err)
        return [line.split()[0] for line in out.splitlines()]

    def test_a_master_file_with_links_and_virtual_datasets(self):
        os.makedirs(self.path("parts"))
        self.write_part("parts/a.h5", "entry/data")
        with h5py.File(self.path("master.h5"), "w") as file:
            for name, other, path in (("relative", "parts/a.h5", "/entry/data"), ("group", "parts/a.h5", "/entry"),
                                      ("absolute", self.path("parts/a.h5"), "/entry/data"),
                                      ("moved", "/where/it/was/master.h5", "/relative")):
                file[name] = h5py.ExternalLink(other, path)
            self.add_virtual(file, "virtual", "parts/a.h5", "/entry/data")
            self.add_virtual(file, "again", ".", "/virtual")
            self.add_virtual(file, "linked", ".", "/relative")
        for name in ("relative", "absolute", "moved", "group/data", "virtual", "again", "linked"):
            self.assert_volume("master.h5:/" + name, self.samples, name.split("/")[-1])

    def test_links_to_no_regular_file_are_refused_without_waiting(self):
        os.mkfifo(self.path("pipe"))
        os.mkfifo(self.path("slice-0"))
        with h5py.File(self.path("p.h5"), "w") as file:
            for name, other in (("VTKHDF", "pipe"), ("absolute", self.path("pipe")), ("device", "/dev/zero")):
                file[name] = h5py.ExternalLink(other, "/data")
            self.add_virtual(file, "outer", ".", "/VTKHDF")
            layout = h5py.VirtualLayout(SHAPE, "int16", maxshape=(None, *SHAPE[1:]))
            source = h5py.VirtualSource("slice-%b", "data", shape=(1, *SHAPE[1:]))
            layout[0:h5py.h5s.UNLIMITED:1, :, :] = source[0:1, :, :]
            file.create_virtual_dataset("slices", layout)
            file["data"] = self.samples
        for name, word in (("VTKHDF", "FIFO"), ("absolute", "FIFO"), ("device", "device"), ("outer", "FIFO"),
                           ("slices", "slice-0")):
            self.assert_error("p.h5:/" + name, f"p.h5:/{name}", f"it is a {word}" if "-" not in word else word)
        self.assertEqual(self.list_paths("p.h5"), ["/data", "/outer", "/slices"])
        with h5py.File(self.path("alone.h5"), "w") as file:
            file["VTKHDF"] = h5py.ExternalLink("pipe", "/data")
            file["data"] = self.samples
        self.assert_volume("alone.h5", self.samples, "data")

    def test_names_and_depth_of_virtual_sources(self):
        self.write_part("a%b.h5", "100%b")
        with h5py.File(self.path("v.h5"), "w") as file:
            self.add_virtual(file, "percent", "a%%b.h5", "/100%%b")
            file["0"] = self.samples
            for depth in range(1, 10):
                self.add_virtual(file, str(depth), ".", f"/{depth - 1}")
            self.add_virtual(file, "self", ".", "/self")
        self.assert_volume("v.h5:/percent", self.samples, "percent")
        self.assert_volume("v.h5:/8", self.samples, "8")
        for name in ("9", "self"):
            self.assert_error("v.h5:/" + name, "v.h5:/" + name, "virtual datasets of virtual datasets")

    def test_external_samples_are_regular_files_in_the_folder_or_below(self):
        os.makedirs(self.path("in/below"))
        for name, missing in (("in/below/a.raw", 0), ("a.raw", 0), ("in/short.raw", 1)):
            with open(self.path(name), "wb") as file:
                file.write(b"x" * 7 + self.samples.tobytes()[:self.samples.nbytes - missing])
        os.symlink(self.path("a.raw"), self.path("in/link.raw"))
        os.mkfifo(self.path("in/fifo"))
        with h5py.File(self.path("in/a.h5"), "w") as file:
            for name, other in (("relative", "below/a.raw"), ("absolute", self.path("in/below/a.raw")),
                                ("passwords", "/etc/passwd"), ("above", "../a.raw"), ("link", "link.raw"),
                                ("fifo", "fifo"), ("missing", "missing.raw"), ("short", "short.raw")):
                file.create_dataset(name, SHAPE, "int16", external=[(other, 7, self.samples.nbytes)])
            self.add_virtual(file, "virtual", ".", "/passwords")
        for name in ("relative", "absolute"):
            self.assert_volume("in/a.h5:/" + name, self.samples, name)
        outside = "outside of the folder of the file"
        for name, *words in (("passwords", "cannot be read: /etc/passwd", outside), ("above", "a.raw", outside),
                             ("link", "link.raw", outside), ("virtual", "nor through virtual datasets"),
                             ("fifo", "in/fifo", "it is a FIFO"), ("missing", "missing.raw", "No such file"),
                             ("short", "short.raw", "truncated")):
            self.assert_error("in/a.h5:/" + name, *words)

    def test_lists_have_32_groups_in_one_another_and_10000_objects(self):
        with h5py.File(self.path("g.h5"), "w") as file:
            group = file
            for depth in range(1000):
                group = group.create_group("g")
                if depth in (30, 31):
                    group["data"] = self.samples
            file["g/cycle"], file["again"] = file["/"], file["g"]
        path, = self.list_paths("g.h5")
        self.assert_volume("g.h5", self.samples, "data")
        self.assert_volume("g.h5:" + path, self.samples, "data")
        with h5py.File(self.path("many.h5"), "w") as file:
            file["a/data"] = file["c/data"] = self.samples
            for number in range(10000):
                file.create_group(f"b{number}")
        self.assertEqual(self.list_paths("many.h5"), ["/a/data"])
        self.assert_volume("many.h5:/c/data", self.samples, "data")


class ErrorsAndLists(SourceCase):
    def test_list_and_choice(self):
        with h5py.File(self.path("l.h5"), "w") as file:
            file["entry/one"] = make_samples("int16")
            file["entry/line"] = numpy.arange(4.0)
            file["name"] = "a text"
            self.assertEqual(file["entry/one"].shape, SHAPE)
        self.write("l.h5", "o.bvol")
        with h5py.File(self.path("l.h5"), "a") as file:
            file.create_dataset("entry/two", data=make_samples("float64"), chunks=(8, 8, 70),
                                compression="gzip")
        self.assert_error("l.h5", "l.h5", "/entry/one (41 x 37 x 70 int16), /entry/two")
        code, out, _ = self.run_tool("--list", "l.h5")
        self.assertEqual(code, 0)
        self.assertEqual([line.split("  ")[0].strip() for line in out.splitlines()],
                         ["/entry/line", "/entry/one", "/entry/two", "/name"])
        self.assertRegex(out, r"/entry/two +41 x 37 x 70 +float64 +chunks of 8 x 8 x 70, deflate\n")

    def test_other_files_are_regular(self):
        os.mkfifo(self.path("fifo"))
        with h5py.File(self.path("part.h5"), "w") as file:
            file["data"] = make_samples("int16")
        with h5py.File(self.path("o.h5"), "w") as file:
            for name in ("part.h5", "fifo"):
                file["link-" + name] = h5py.ExternalLink(name, "/data")
                layout = h5py.VirtualLayout(SHAPE, "int16")
                layout[...] = h5py.VirtualSource(name, "data", shape=SHAPE)
                file.create_virtual_dataset("virtual-" + name, layout)
            file.create_dataset("raw", SHAPE, "int16", external=[("fifo", 0, h5py.h5f.UNLIMITED)])
        expected = self.write_raw(make_samples("int16"), "data")
        for name in ("link", "virtual"):
            path = self.write(f"o.h5:/{name}-part.h5", "o.bvol", ranks=2)
            self.assertEqual(sorted(list_files(path)), sorted(list_files(expected)))
            self.assert_error(f"o.h5:/{name}-fifo", f"o.h5:/{name}-fifo: cannot be read",
                              "fifo: cannot read: it is a FIFO", ranks=2)
        self.assert_error("o.h5:/raw", "fifo", "it is a FIFO")
        self.assertIn("virtual, refused", self.run_tool("--list", "o.h5")[1])

    def test_errors_name_file_dataset_and_reason(self):
        with h5py.File(self.path("e.h5"), "w") as file:
            file["complex"] = make_samples("float32").astype("complex64")
            file["flat"] = numpy.zeros((4, 4))
            file.create_dataset("lzf", data=make_samples("int16"), compression="lzf")
            file.create_dataset("gzip", data=make_samples("int16"), compression="gzip",
                                chunks=(8, 8, 8))
        self.assert_error("e.h5:/complex", "e.h5:/complex: cannot be read", "compound")
        self.assert_error("e.h5:/flat", "e.h5:/flat: cannot be read", "2 axes")
        self.assert_error("e.h5:/none", "e.h5:/none: cannot be read", "no such dataset")
        self.assert_error("e.h5:/lzf", "e.h5:/lzf: cannot be read", "filter 'lzf'", ranks=2)
        self.assert_error("e.h5:/gzip", "\"zyyx\"", arguments=["--axes", "zyyx"])
        with open(self.path("e.h5"), "rb") as file:
            whole = file.read()
        for part in (9, 600, len(whole) // 2, len(whole) - 1000):
            with open(self.path("t.h5"), "wb") as file:
                file.write(whole[:part])
            self.assert_error("t.h5:/gzip", "t.h5", "truncated" if part > 96 else "")
        # Within chunks. HDF5 takes gigabytes of memory where their index is damaged.
        damaged = bytearray(whole)
        with h5py.File(self.path("e.h5"), "r") as file:
            dataset = file["gzip"].id
            for number in range(dataset.get_num_chunks()):
                chunk = dataset.get_chunk_info(number)
                damaged[chunk.byte_offset + chunk.size // 2] ^= 0x55
        with open(self.path("d.h5"), "wb") as file:
            file.write(damaged)
        self.assert_error("d.h5:/gzip", "d.h5", "cannot be read", ranks=2)

    def test_nothing_follows_the_error(self):
        with h5py.File(self.path("g.h5"), "w", libver=("earliest", "latest")) as file:
            file["group/data"] = make_samples("int16")
        with open(self.path("g.h5"), "rb") as file:
            whole = bytearray(file.read())
        # Headers of a group: version 1, one message, one reference, 24 bytes. HDF5 cannot close what it
        # has opened of a group whose header ends behind the file, and says so when the process ends.
        header = struct.pack("<BBHII", 1, 0, 1, 1, 24)
        last = whole.rfind(header)
        if last < 0:
            self.skipTest("this HDF5 writes other headers")
        whole[last + len(header) - 1] = 37
        with open(self.path("g.h5"), "wb") as file:
            file.write(whole)
        for ranks in (1, 2):
            code, out, error = self.run_tool("g.h5:/group/data", "o.bvol", ranks=ranks)
            self.assertEqual((code, out), (1, ""))
            self.assertEqual(error.count("HDF5"), 0, error)
            self.assertEqual(error.count("blockvolume: g.h5"), 1, error)


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
