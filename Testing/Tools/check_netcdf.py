#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Files of netCDF4, read by blockvolume: check_netcdf.py TOOL MPIEXEC SCRATCH CLAIM"""
import json
import os
import sys

import h5py
import netCDF4
import numpy

from sample_volumes import SHAPE, SourceCase, make_samples, run_claim

CLASSIC = ("int8", "int16", "int32", "float32", "float64")
NEW = ("uint8", "uint16", "uint32", "int64", "uint64")


class Files(SourceCase):
    def create(self, name, format="NETCDF4", steps=None, sizes=SHAPE):
        """A new file with the dimensions z, y and x, and perhaps time."""
        file = netCDF4.Dataset(self.path(name), "w", format=format)
        if steps is not None:
            file.createDimension("time", steps)
        for axis, size in zip("zyx", sizes):
            file.createDimension(axis, size)
        return file


class Samples(Files):
    def test_formats_and_types(self):
        formats = ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4")
        for number, dtype in enumerate(CLASSIC + NEW):
            format = formats[number % 4] if dtype in CLASSIC else formats[2 + number % 2]
            with self.subTest(type=dtype, format=format):
                samples = make_samples(dtype)
                with self.create("a.nc", format) as file:
                    options = {"zlib": True, "chunksizes": (7, 16, 31)} if number == 8 else {}
                    if format == "NETCDF4" and number % 4 == 3:
                        options["endian"] = "big"  # the classic formats have no other
                    file.createVariable("data", dtype, ("z", "y", "x"), **options)[:] = samples
                path = self.write("a.nc:data", "o.bvol", ranks=2 if number == 8 else 1)
                self.assert_equal_volumes(path, self.write_raw(samples, "data"))

    def test_packed_samples(self):
        samples = make_samples("int16")
        with self.create("p.nc") as file:
            packed = file.createVariable("data", "int16", ("z", "y", "x"))
            packed.set_auto_scale(False)
            packed[:] = samples
            packed.scale_factor = numpy.float32(0.25)
            packed.add_offset = numpy.float32(-3)
        values = (samples * 0.25 - 3).astype("float32")
        self.assert_equal_volumes(self.write("p.nc", "o.bvol"), self.write_raw(values, "data"))

    def test_unsigned_bytes_of_the_classic_format(self):
        samples = make_samples("uint8") + 100
        with self.create("u.nc", "NETCDF3_CLASSIC") as file:
            data = file.createVariable("data", "int8", ("z", "y", "x"))
            data._Unsigned = "true"
            data.set_auto_maskandscale(False)
            data[:] = samples.view("int8")
        self.assert_equal_volumes(self.write("u.nc", "o.bvol"), self.write_raw(samples, "data"))


class CoordinatesAndErrors(Files):
    def add_coordinates(self, file, **coordinates):
        for name, (numbers, attributes) in coordinates.items():
            variable = file.createVariable(name, "float32", (name,))
            variable[:] = numbers
            variable.setncatts(attributes)

    def test_grid_and_times(self):
        steps = numpy.stack([make_samples("int16", phase=step) for step in range(2)])
        with self.create("c.nc", "NETCDF3_CLASSIC", steps=0) as file:
            self.add_coordinates(file, time=([0, 6], {"units": "hours since 2000-01-01"}),
                                 z=(7 + 2.0 * numpy.arange(41), {"positive": "up"}),
                                 y=(-3 + 0.5 * numpy.arange(37), {"units": "degrees_north"}),
                                 x=(0.1 * numpy.arange(70), {"units": "degrees_east"}))
            file.createVariable("data", "int16", ("time", "z", "y", "x"))[:] = steps
        path = self.write("c.nc", "o.bvol", "--step", "1", "--origin", "0,-3,7",
                          "--spacing", "0.1,0.5,2")
        expected = self.write_raw(steps[1], "data", "--time", "6", spacing=(0.1, 0.5, 2),
                                  origin=(0, -3, 7))
        self.assert_equal_volumes(path, expected)
        self.write("c.nc", "o.bvol")
        info = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])
        self.assertEqual([step["time"] for step in info["timeSteps"]], [0, 6])
        numpy.testing.assert_allclose(info["grid"]["spacing"], (0.1, 0.5, 2), rtol=1e-6)
        numpy.testing.assert_allclose(info["grid"]["origin"], (0, -3, 7), rtol=1e-6)

    def test_packed_coordinates_and_times_are_unpacked(self):
        # y with a negative scale, as GOES-R has it, x unsigned, time with an offset alone.
        lines = {"time": ("i4", [1, 3], {"add_offset": 100.0}),
                 "y": ("i2", [-2, 0, 2, 4, 6], {"scale_factor": -0.25, "add_offset": 8.0}),
                 "x": ("i1", numpy.arange(126, 132).astype("u1").view("i1"),
                       {"scale_factor": 0.5, "_Unsigned": "true"})}
        for format in ("NETCDF3_CLASSIC", "NETCDF3_64BIT_DATA", "NETCDF4"):
            with self.create("q.nc", format, steps=2, sizes=(2, 5, 6)) as file:
                file.set_auto_maskandscale(False)
                for name, (dtype, numbers, attributes) in lines.items():
                    variable = file.createVariable(name, dtype, (name,))
                    variable.setncatts(attributes)
                    variable.set_auto_maskandscale(False)
                    variable[:] = numbers
                file.createVariable("data", "i2", ("time", "z", "y", "x"))[:] = numpy.arange(120).reshape(2, 2, 5, 6)
            grid = self.convert("q.nc")[0]
            self.assertEqual((grid["origin"], grid["spacing"]), ([63, 8.5, 0], [0.5, 0.5, 1]))
            self.assertEqual(grid["direction"], [1, 0, 0, 0, -1, 0, 0, 0, 1])
            steps = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["timeSteps"]
            self.assertEqual([step["time"] for step in steps], [101, 103])

    def test_coordinates_and_times_that_were_cut_off(self):
        for format in ("NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA"):
            for last in ("time", "y"):
                with self.create("t.nc", format, steps=2, sizes=(2, 5, 6)) as file:
                    data = file.createVariable("data", "i2", ("time", "z", "y", "x"))
                    line = file.createVariable(last, "f8", (last,))
                    data[:] = numpy.arange(120).reshape(2, 2, 5, 6)
                    line[:] = numpy.arange(len(line))
                self.write("t.nc", "o.bvol")
                os.truncate(self.path("t.nc"), os.path.getsize(self.path("t.nc")) - 8)
                self.assert_error("t.nc", "t.nc:" + last, "truncated")

    def test_links_and_groups_of_version_4(self):
        samples = make_samples("int16")
        os.mkfifo(self.path("fifo"))
        with h5py.File(self.path("part.nc"), "w") as file:
            file["data"] = samples
        for other in ("part.nc", "fifo"):
            layout = h5py.VirtualLayout(SHAPE, "int16")
            layout[...] = h5py.VirtualSource(other, "data", shape=SHAPE)
            with h5py.File(self.path(f"link-{other}.nc"), "w") as file:
                file["link"] = h5py.ExternalLink(other, "/data")
            with h5py.File(self.path(f"virtual-{other}.nc"), "w") as file:
                file.create_virtual_dataset("virtual", layout)
        for name in ("link", "virtual"):
            self.assert_equal_volumes(self.write(f"{name}-part.nc.nc", "o.bvol"), self.write_raw(samples, name))
            self.refuse(f"{name}-fifo.nc", f"{name}-fifo.nc:/{name}: cannot be read", "it is a FIFO")
        with h5py.File(self.path("external.nc"), "w") as file:
            file.create_dataset("external", SHAPE, "int16", external=[("fifo", 0, samples.nbytes)])
        self.refuse("external.nc", "external.nc:/external", "not read of NetCDF")
        with h5py.File(self.path("deep.nc"), "w") as file:
            file["g/" * 40 + "data"] = samples
        with h5py.File(self.path("cycle.nc"), "w") as file:
            file["a/data"], file["a/a"] = samples, h5py.SoftLink("/a")
        self.refuse("deep.nc", "deep.nc:/g/g", "deeper than 32")
        self.refuse("cycle.nc", "cycle.nc:/a/a", "deeper than 32")

    def refuse(self, name, *words):
        """One error, of opening and of listing."""
        self.assert_error(name, *words)
        code, _, err = self.run_tool("--list", name)
        self.assertEqual(code, 1, err)
        for word in words:
            self.assertIn(word, err)

    def test_axes_by_attributes_and_descending_coordinates(self):
        samples = make_samples("float32")
        with self.create("d.nc") as file:
            self.add_coordinates(file, y=(90 - numpy.arange(37), {"standard_name": "latitude"}),
                                 x=(numpy.arange(70), {"axis": "X"}))
            file.createVariable("data", "float32", ("x", "y", "z"))[:] = samples.T
        self.write("d.nc", "o.bvol")
        info = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])
        self.assertEqual(info["grid"]["direction"], [1, 0, 0, 0, -1, 0, 0, 0, 1])
        self.assertEqual(info["grid"]["origin"], [0, 90, 0])
        path = self.write("d.nc", "o.bvol", "--spacing", "1,1,1", "--origin", "0,0,0")
        self.assert_equal_volumes(path, self.write_raw(samples, "data"))

    def test_a_last_axis_of_one_sample_is_a_component(self):
        samples = make_samples("float32")
        with self.create("o.nc") as file:
            file.createDimension("component", 1)
            file.createVariable("data", "float32", ("z", "y", "x", "component"))[:] = samples[..., None]
        self.assert_equal_volumes(self.write("o.nc", "o.bvol"), self.write_raw(samples, "data"))

    def test_names_of_dimensions_say_what_axes_are_or_the_axes_are_told(self):
        for names, axes, told in (("xyz", "xyz", ""), ("czyx", "czyx", ""), ("azfx", "tzyx", "named a, z, f, x, are"),
                                  ("abd", "zyx", "taken as zyx; --axes")):
            shape = (2, 9, 8, 7)[-len(names):]
            with netCDF4.Dataset(self.path("n.nc"), "w") as file:
                for name, size in zip(names, shape):
                    file.createDimension(name, size)
                file.createVariable("v", "i2", tuple(names))[:] = numpy.arange(numpy.prod(shape)).reshape(shape)
            err = self.convert("n.nc")[2]
            self.assertEqual((told in err, bool(err)), (True, bool(told)))
            self.assert_equal_volumes(self.write("n.nc", "o.bvol"), self.write("n.nc", "p.bvol", "--axes", axes))

    def test_minc_is_refused(self):
        with self.create("m.mnc", "NETCDF3_CLASSIC") as file:
            self.add_coordinates(file, z=(numpy.arange(41), {}))
            file.createVariable("image", "int16", ("z", "y", "x")).varid = "MINC standard variable"
        self.assert_error("m.mnc", "m.mnc:image: cannot be read: it is MINC")

    def test_what_is_not_obeyed_is_told(self):
        samples = make_samples("int16")
        with self.create("t.nc") as file:
            self.add_coordinates(file, z=(numpy.arange(41), {"positive": "down", "units": "m"}))
            data = file.createVariable("data", "int16", ("z", "y", "x"))
            data.set_auto_maskandscale(False)
            data[:] = samples
            data.setncatts({"units": "K", "valid_range": numpy.array([0, 50], "int16"), "missing_value": numpy.int16(7)})
        code, _, err = self.run_tool("t.nc", "t.bvol")
        self.assertEqual(code, 0)
        for words in ("increase downwards", "whatever valid_range says", "missing_value, 7"):
            self.assertIn(words, err)
        with open(self.path("t.bvol"), "rb") as file:
            self.assertRegex(file.read(), rb'"unit": ?"K"')

    def test_uneven_coordinates_are_those_of_a_rectilinear_grid(self):
        samples, steps = make_samples("int16"), numpy.arange(41.0) ** 2
        with self.create("u.nc") as file:
            self.add_coordinates(file, z=(steps, {}), y=(0.5 * numpy.arange(37), {}))
            file.createVariable("data", "int16", ("z", "y", "x"))[:] = samples
        path = self.write("u.nc", "o.bvol", ranks=2)
        grid = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["grid"]
        expected = [list(range(70)), list(0.5 * numpy.arange(37)), list(steps)]
        self.assertEqual(grid["coordinates"], expected)
        self.assertIn("z: 0.0 to 1600.0", self.run_tool("--info", "o.bvol")[1])
        self.assert_error("u.nc", "--origin: u.nc is a rectilinear grid",
                          arguments=("--origin", "0,0,0"))
        path = self.write("u.nc", "o.bvol", "--spacing", "1,1,1", "--origin", "0,0,0")
        self.assert_equal_volumes(path, self.write_raw(samples, "data"))

    def test_errors_name_file_variable_and_reason(self):
        with self.create("e.nc") as file:
            self.add_coordinates(file, z=(-numpy.arange(41.0) ** 2, {}))
            file.createVariable("data", "int16", ("z", "y", "x"))[:] = make_samples("int16")
            file.createVariable("names", str, ("z", "y", "x"))
        self.assert_error("e.nc", "e.nc:z: cannot be read", "no equal steps", "ascend", ranks=2)
        self.assert_error("e.nc:names", "e.nc:names: cannot be read", "string")
        self.assert_error("e.nc:other", "e.nc:other", "no such variable")
        with self.create("g.nc") as file:
            group = file.createGroup("inner")
            for name in ("one", "two"):
                group.createVariable(name, "int16", ("z", "y", "x"))[:] = make_samples("int16")
        self.assert_error("g.nc", "inner/one (41 x 37 x 70 int16), inner/two")
        self.write("g.nc:/inner/two", "o.bvol")
        self.assertEqual(self.run_tool("--list", "g.nc")[1].split()[::8][0], "inner/one")

    def test_truncated_files(self):
        for format, steps in (("NETCDF3_CLASSIC", None), ("NETCDF3_64BIT_DATA", 0),
                              ("NETCDF4", None)):
            with self.create("t.nc", format, steps) as file:
                axes = ("z", "y", "x") if steps is None else ("time", "z", "y", "x")
                data = file.createVariable("data", "int16", axes)
                data[:] = make_samples("int16") if steps is None else \
                    numpy.stack([make_samples("int16")] * 2)
            size = os.path.getsize(self.path("t.nc"))
            for part in (20, size // 2, size - 8):
                os.truncate(self.path("t.nc"), size)
                with open(self.path("t.nc"), "rb") as file:
                    whole = file.read(part)
                with open(self.path("u.nc"), "wb") as file:
                    file.write(whole)
                with self.subTest(format=format, part=part):
                    self.assert_error("u.nc", "u.nc", "truncated")


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
