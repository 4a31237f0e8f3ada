#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Folders of zarr (versions 2 and N5) and of write_zarr3.py, read by blockvolume:
check_zarr.py TOOL MPIEXEC SCRATCH CLAIM"""
import json
import os
import shutil
import sys
import unittest
import warnings

import numcodecs
import numpy
import zarr

from sample_volumes import SHAPE, TYPES, SourceCase, make_samples, run_claim
from write_zarr2 import IS_ZARR_2, create_array, create_group, write_array_2
from write_zarr3 import write_array

LITTLE = {"name": "bytes", "configuration": {"endian": "little"}}
BIG = {"name": "bytes", "configuration": {"endian": "big"}}


class VersionTwoAndN5(SourceCase):
    def test_types_codecs_keys_and_byte_orders(self):
        codecs = [None, numcodecs.Zlib(3), numcodecs.GZip(3), numcodecs.Zstd(3), numcodecs.LZ4(),
                  *(numcodecs.Blosc(name, 5, shuffle) for name, shuffle in (
                      ("lz4", 1), ("zstd", 2), ("blosclz", 0), ("lz4hc", 1), ("zlib", 1)))]
        for number, (dtype, codec) in enumerate(zip(TYPES, codecs)):
            with self.subTest(type=dtype, codec=codec):
                samples = make_samples(dtype)
                name = f"a{number}.zarr"
                array = create_array(self.path(name), SHAPE, numpy.dtype(dtype).newbyteorder("<>"[number % 2]),
                                     ((16, 16, 16), (7, 37, 31), SHAPE)[number % 3], separator="./"[number % 2],
                                     compressor=codec, order="CCF"[number % 3])
                array[:] = samples
                path = self.write(name, "o.bvol", *(["--memory", "8"] if number == 3 else []),
                                  ranks=3 if number == 1 else 1)
                self.assert_equal_volumes(path, self.write_raw(samples, f"a{number}"))

    def test_bools_and_half_floats(self):
        for dtype, taken in (("bool", "uint8"), ("float16", "float32"), (">f2", "float32")):
            with self.subTest(type=dtype):
                samples = make_samples("int16") % 3 == 0 if dtype == "bool" else make_samples("float16")
                array = create_array(self.path("h.zarr"), SHAPE, dtype, (16, 16, 16))
                array[:] = samples
                self.assert_equal_volumes(self.write("h.zarr", "o.bvol"), self.write_raw(samples.astype(taken), "h"))
                shutil.rmtree(self.path("h.zarr"))

    def test_a_cache_of_a_few_rows_of_chunks(self):
        # A layer of chunks has 16 MiB, a row of them 4 MiB: what a quarter of the memory has room for.
        samples = make_samples("int32", (70, 200, 200))
        write_array_2(self.path("r.zarr"), samples, (64, 64, 64))
        path = self.write("r.zarr", "o.bvol", "--memory", "24", "--distribution", "balanced")
        self.assert_equal_volumes(path, self.write_raw(samples, "r", "--distribution", "balanced"))

    def test_missing_chunks_have_the_fill_value(self):
        # zarr 3 writes infinity in a way that JSON does not have.
        for fill in (-7.5, numpy.inf):
            samples = numpy.full(SHAPE, fill, "float32")
            array = create_array(self.path("f.zarr"), SHAPE, "float32", (10, 10, 10), fill_value=fill)
            array[10:20, 5:30, :15] = samples[10:20, 5:30, :15] = \
                make_samples("float32")[10:20, 5:30, :15]
            self.assert_equal_volumes(self.write("f.zarr", "o.bvol"), self.write_raw(samples, "f"))

    def test_an_unreadable_chunk_is_no_missing_one(self):
        # As annexed files are that were not fetched, and as a loop of links.
        write_array_2(self.path("l.zarr"), make_samples("int16"), (20, 20, 20))
        chunk = self.path("l.zarr/0.1.1")
        for target in ("annex/objects/none", "0.1.1"):
            os.remove(chunk)
            os.symlink(target, chunk)
            self.assert_error("l.zarr", "l.zarr/0.1.1", "link")

    @unittest.skipUnless(IS_ZARR_2, "zarr 3 writes no N5")
    def test_n5(self):
        codecs = (None, numcodecs.GZip(3), numcodecs.Zstd(3), numcodecs.Zlib(3), numcodecs.Blosc("lz4", 5, 1))
        for number, dtype in enumerate(TYPES):
            samples, codec = make_samples(dtype), codecs[number % len(codecs)]
            with self.subTest(type=dtype, codec=codec), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                shutil.rmtree(self.path("a.n5"), ignore_errors=True)
                group = zarr.group(zarr.N5Store(self.path("a.n5")))
                group.create_dataset("volume", data=samples, chunks=(16, 20, 33), compressor=codec)
                with open(self.path("a.n5/volume/attributes.json")) as file:
                    self.assertEqual(json.load(file)["dimensions"], [70, 37, 41])
                path = self.write("a.n5:volume", "o.bvol")
                self.assert_equal_volumes(path, self.write_raw(samples, "volume"))

    def test_partial_blocks_of_n5(self):
        # As the library of N5 itself writes them: without samples beyond the end.
        samples = make_samples("int16")
        os.makedirs(self.path("p.n5/s0"))
        with open(self.path("p.n5/s0/attributes.json"), "w") as file:
            json.dump({"dimensions": [70, 37, 41], "blockSize": [32, 32, 32], "dataType": "int16",
                       "compression": {"type": "raw"}}, file)
        for z in range(2):
            for y in range(2):
                for x in range(3):
                    block = samples[32 * z:32 * z + 32, 32 * y:32 * y + 32, 32 * x:32 * x + 32]
                    os.makedirs(self.path(f"p.n5/s0/{x}/{y}"), exist_ok=True)
                    with open(self.path(f"p.n5/s0/{x}/{y}/{z}"), "wb") as file:
                        file.write(numpy.array([0, 3], ">u2").tobytes() +
                                   numpy.array(block.shape[::-1], ">u4").tobytes() +
                                   block.astype(">i2").tobytes())
        self.assert_equal_volumes(self.write("p.n5/s0", "o.bvol"), self.write_raw(samples, "s0"))


class LayoutsAndPlaces(SourceCase):
    def test_nested_chunks_are_found_without_a_separator(self):
        samples = make_samples("int16")
        write_array_2(self.path("n.zarr"), samples, (16, 20, 33), separator="/")
        with open(self.path("n.zarr/.zarray")) as file:
            metadata = json.load(file)
        del metadata["dimension_separator"]
        with open(self.path("n.zarr/.zarray"), "w") as file:
            json.dump(metadata, file)
        expected = self.write_raw(samples, "n")
        self.assert_equal_volumes(self.write("n.zarr", "o.bvol"), expected)
        # Also if the first chunk is not there.
        os.remove(self.path("n.zarr/0/0/0"))
        samples[:16, :20, :33] = 0
        self.assert_equal_volumes(self.write("n.zarr", "o.bvol"), self.write_raw(samples, "n"))

    def test_a_folder_without_a_chunk_of_the_expected_name_is_told(self):
        write_array_2(self.path("m.zarr"), make_samples("int16"), (16, 20, 33))
        self.assertEqual(self.convert("m.zarr")[2], "")
        with open(self.path("m.zarr/.zarray")) as file:
            metadata = json.load(file)
        metadata["dimension_separator"] = "/"
        with open(self.path("m.zarr/.zarray"), "w") as file:
            json.dump(metadata, file)
        told = self.convert("m.zarr")[2]
        self.assertIn("m.zarr: it has no chunk of a name as 0/0/0", told)
        self.assertIn("there are names as 0.0.0", told)
        write_array(self.path("t.zarr"), make_samples("int16"), (8, 12, 16), [LITTLE], shard=(48, 48, 96))
        self.assertEqual(self.convert("t.zarr")[2], "")
        os.rename(self.path("t.zarr/c"), self.path("t.zarr/chunks"))
        self.assertIn("no chunk of a name as c/0/0/0", self.convert("t.zarr")[2])

    def write_n5(self, name, attributes, levels):
        """A pyramid s0, s1 ... of N5, of attributes of the group and of each level."""
        samples = make_samples("uint8", (16, 12, 8))
        for number, more in enumerate(levels):
            folder = self.path(f"{name}/s{number}")
            os.makedirs(folder, exist_ok=True)
            level = samples[::1 << number, ::1 << number, ::1 << number]
            with open(folder + "/attributes.json", "w") as file:
                json.dump({"dimensions": level.shape[::-1], "blockSize": level.shape[::-1], "dataType": "uint8",
                           "compression": {"type": "raw"}, **more}, file)
            os.makedirs(folder + "/0/0", exist_ok=True)
            with open(folder + "/0/0/0", "wb") as file:
                file.write(numpy.array([0, 3], ">u2").tobytes() + numpy.array(level.shape[::-1], ">u4").tobytes() +
                           level.tobytes())
        with open(self.path(f"{name}/attributes.json"), "w") as file:
            json.dump(attributes, file)

    def test_places_of_n5(self):
        full = {"dimensions": [2, 3, 40], "unit": "um"}
        two = [2, 2, 2]
        pixels = ((full, "um"), ([2, 3, 40], None))
        cases = [({"pixelResolution": pixel, "scales": [[1, 1, 1], two]}, [{}, {}], unit) for pixel, unit in pixels]
        cases += [
            # A resolution of each level, of the full size, and of the group with factors of the levels.
            ({"pixelResolution": full}, [{"pixelResolution": full}, {
                "pixelResolution": {"dimensions": [4, 6, 80], "unit": "um"}, "downsamplingFactors": two}], "um"),
            ({}, [{"pixelResolution": full}, {"pixelResolution": full, "downsamplingFactors": two}], "um"),
            ({"resolution": [2, 3, 40], "units": ["nm"] * 3, "downsamplingFactors": [[1, 1, 1], two]}, [{}, {}], "nm"),
            # COSEM counts the axes as NumPy does.
            ({}, [{"transform": {"axes": ["z", "y", "x"], "scale": [40 * f, 3 * f, 2 * f], "units": ["nm"] * 3,
                                 "translate": [20 * f - 20, 1.5 * f - 1.5, f - 1]}} for f in (1, 2)], "nm"),
            ({"multiscales": [{"datasets": [{"path": f"s{n}", "transform": {
                "axes": ["z", "y", "x"], "scale": [40 << n, 3 << n, 2 << n], "units": ["nm"] * 3,
                "translate": [20 * n, 1.5 * n, n]}} for n in (0, 1)]}]}, [{}, {}], "nm")]
        for attributes, levels, unit in cases:
            with self.subTest(attributes=attributes, levels=levels):
                shutil.rmtree(self.path("p.n5"), ignore_errors=True)
                self.write_n5("p.n5", attributes, levels)
                for name, spacing, origin in (("p.n5", [2, 3, 40], [0, 0, 0]), ("p.n5:s0", [2, 3, 40], [0, 0, 0]),
                                              ("p.n5:s1", [4, 6, 80], [1, 1.5, 20])):
                    grid = self.convert(name)[0]
                    self.assertEqual((grid["spacing"], grid["origin"], grid.get("unit")), (spacing, origin, unit), name)

    def test_axes_of_n5_may_be_told_in_both_orders(self):
        samples = numpy.stack([make_samples("uint8", (9, 8, 7), phase=c) for c in range(2)])
        for axes in ("xyzc", "czyx"):
            folder = self.path(f"{axes}.n5/a")
            os.makedirs(folder + "/0/0/0")
            with open(folder + "/attributes.json", "w") as file:
                json.dump({"dimensions": [7, 8, 9, 2], "blockSize": [7, 8, 9, 2], "dataType": "uint8",
                           "compression": {"type": "raw"}, "axes": list(axes)}, file)
            with open(folder + "/0/0/0/0", "wb") as file:
                file.write(numpy.array([0, 4], ">u2").tobytes() + numpy.array([7, 8, 9, 2], ">u4").tobytes() +
                           samples.tobytes())
            self.assertEqual(list(self.convert(f"{axes}.n5/a")[1]), ["a 0", "a 1"])

    def test_coordinates_and_attributes_of_xarray(self):
        group = create_group(self.path("x.zarr"))
        samples = make_samples("int16", (9, 8, 7))
        lines = {"height": 10 + 2.5 * numpy.arange(9), "lat": 50 - 0.5 * numpy.arange(8),
                 "lon": 4 + 0.25 * numpy.arange(7)}
        write_array_2(self.path("x.zarr/air"), samples, (9, 8, 7))
        zarr.open(self.path("x.zarr/air")).attrs.update({
            "_ARRAY_DIMENSIONS": list(lines), "scale_factor": 0.01, "add_offset": 273.0, "units": "K"})
        for name, line in lines.items():
            write_array_2(self.path(f"x.zarr/{name}"), line, line.shape, separator=".")
            zarr.open(self.path(f"x.zarr/{name}")).attrs.update({"_ARRAY_DIMENSIONS": [name], "units": "m"})
        del group
        grid, arrays, err = self.convert("x.zarr")
        self.assertEqual((grid["spacing"], grid["origin"], grid["unit"]), ([0.25, 0.5, 2.5], [4, 50, 10], "m"))
        self.assertEqual(grid["direction"], [1, 0, 0, 0, -1, 0, 0, 0, 1])
        self.assertEqual(arrays, {"air": "K"})
        self.assertIn("not used: add_offset 273.0, scale_factor 0.01", err)
        zarr.open(self.path("x.zarr/lon"))[3] = 7
        self.assertIn('the coordinates "lon" have no equal steps', self.convert("x.zarr")[2])
        zarr.open(self.path("x.zarr/air")).attrs["_ARRAY_DIMENSIONS"] = ["this", "that", "other"]
        self.assertIn("its axes, named this, that, other, are taken as zyx; --axes", self.convert("x.zarr")[2])

    def test_coordinates_of_time_are_times(self):
        create_group(self.path("t.zarr"))
        steps = numpy.stack([make_samples("uint8", (9, 8, 7), phase=step) for step in range(2)])
        for name, values, axes in (("air", steps, ["time", "z", "y", "x"]), ("time", numpy.array([2.5, 7]), ["time"])):
            write_array_2(self.path(f"t.zarr/{name}"), values, values.shape)
            zarr.open(self.path(f"t.zarr/{name}")).attrs.update({"_ARRAY_DIMENSIONS": axes, "units": "days since 1900"})
        err = self.convert("t.zarr")[2]
        self.assertIn("the unit of times, days since 1900, is not kept", err)
        steps = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])["timeSteps"]
        self.assertEqual([step["time"] for step in steps], [2.5, 7])

    def test_attributes_of_others_that_are_not_applied_are_told(self):
        write_array_2(self.path("a.zarr"), make_samples("int16"), (16, 20, 33))
        zarr.open(self.path("a.zarr")).attrs.update(
            {"spacing": [3, 2, 1], "scale_factor": 2, "resolution": {"z": 3}, "offset": [1, 2, 3]})
        self.assertIn('not used: resolution {"z":3}, scale_factor 2, spacing [3,2,1]\n', self.convert("a.zarr")[2])

    def test_a_resolution_has_the_order_of_the_axes(self):
        samples = make_samples("int16", (9, 8, 7))
        for axes, shape, numbers in (("zyx", (9, 8, 7), [3, 2, 1]), ("xyz", (7, 8, 9), [1, 2, 3]),
                                     ("tzyx", (1, 9, 8, 7), [0, 3, 2, 1]), ("zyxc", (9, 8, 7, 1), [3, 2, 1])):
            write_array_2(self.path("r.zarr"), (samples.T if axes == "xyz" else samples).reshape(shape), shape)
            zarr.open(self.path("r.zarr")).attrs.update(
                {"_ARRAY_DIMENSIONS": list(axes), "resolution": numbers, "offset": numbers})
            grid, arrays, err = self.convert("r.zarr")
            self.assertEqual((grid["spacing"], grid["origin"], err), ([1, 2, 3], [1, 2, 3], ""), axes)
            self.assert_equal_volumes(self.write("r.zarr", "o.bvol", "--time", "0"), self.write_raw(
                samples, next(iter(arrays)), "--time", "0", spacing=(1, 2, 3), origin=(1, 2, 3)))

    def test_axes_without_names_are_told_and_short_last_ones_are_components(self):
        for shape, axes in (((9, 8, 7, 3), "zyxc"), ((2, 9, 8, 7), "tzyx"), ((9, 8, 7, 5), "tzyx"),
                            ((2, 9, 8, 7, 3), "tzyxc"), ((2, 3, 9, 8, 7), "tczyx"), ((20, 18, 3), "zyx")):
            samples = numpy.arange(numpy.prod(shape), dtype="int16").reshape(shape)
            write_array_2(self.path("n.zarr"), samples, shape)
            told = self.convert("n.zarr")[2]
            self.assertIn(f"its axes, without names, are taken as {axes}; --axes says", told)
            self.assert_equal_volumes(self.write("n.zarr", "o.bvol"), self.write("n.zarr", "p.bvol", "--axes", axes))
        write_array_2(self.path("n.zarr"), samples, shape)
        zarr.open(self.path("n.zarr")).attrs["_ARRAY_DIMENSIONS"] = ["y", "x"]
        self.assert_error("n.zarr", "do not name each axis")


class VersionThree(SourceCase):
    def test_types_codecs_keys_and_shards(self):
        crc = {"name": "crc32c"}
        forms = [dict(codecs=[LITTLE]), dict(codecs=[BIG, {"name": "gzip"}], keys="v2"),
                 dict(codecs=[LITTLE, crc, {"name": "zstd"}, crc]),
                 dict(codecs=[{"name": "transpose", "configuration": {"order": [1, 2, 0]}}, LITTLE,
                              {"name": "blosc"}]),
                 dict(codecs=[LITTLE, {"name": "zstd"}], shard=(16, 24, 32)),
                 dict(codecs=[BIG, crc], shard=(48, 48, 96), at_start=True),
                 dict(codecs=[LITTLE], shard=(8, 12, 16)),
                 dict(codecs=[BIG, {"name": "gzip"}], shard=(8, 12, 16), at_start=True)]
        for number, dtype in enumerate(TYPES):
            form = forms[number % len(forms)]
            with self.subTest(type=dtype, **form):
                samples = make_samples(dtype)
                samples[:16] = 3
                shutil.rmtree(self.path("a.zarr"), ignore_errors=True)
                write_array(self.path("a.zarr"), samples, (8, 12, 16), fill=3, **form)
                path = self.write("a.zarr", "o.bvol", ranks=2 if number == 4 else 1)
                self.assert_equal_volumes(path, self.write_raw(samples, "a"))

    def test_half_floats_and_bits_of_the_fill_value(self):
        samples = make_samples("float16")
        samples[:16] = numpy.nan
        write_array(self.path("h.zarr"), samples[16:], (8, 12, 16), [LITTLE], fill=-2.5)
        self.assert_equal_volumes(self.write("h.zarr", "o.bvol"),
                                  self.write_raw(samples[16:].astype("float32"), "h"))
        for bits, number in (("0x42280000", 42), ("0xc0200000", -2.5)):
            shutil.rmtree(self.path("b.zarr"), ignore_errors=True)
            write_array(self.path("b.zarr"), numpy.full(SHAPE, number, "float32"), (8, 37, 70),
                        [LITTLE], fill=number)
            with open(self.path("b.zarr/zarr.json")) as file:
                metadata = json.load(file)
            metadata["fill_value"] = bits
            with open(self.path("b.zarr/zarr.json"), "w") as file:
                json.dump(metadata, file)
            self.assert_equal_volumes(self.write("b.zarr", "o.bvol"),
                                      self.write_raw(numpy.full(SHAPE, number, "float32"), "b"))


class Metadata(SourceCase):
    """What metadata may cost, and what fill values say."""
    CODEC = {"name": "crc32c"}

    def write_text(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w") as file:
            file.write(text)

    def write_metadata(self, name, codecs=(CODEC,), separator="/", **members):
        """An array of 2 x 2 x 2 samples without chunks; JSON has NaN as Python writes it."""
        self.write_text(name + "/zarr.json", json.dumps({
            "zarr_format": 3, "node_type": "array", "shape": [2, 2, 2], "data_type": "uint8", "fill_value": 0,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 2, 2]}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": separator}},
            "codecs": [{"name": "bytes"}, *codecs], "attributes": {}, **members}))

    def write_image(self, axes, channels):
        self.write_text("i.zarr/zarr.json", json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {
            "multiscales": [{"datasets": [{"path": "0"}], "axes": axes}], "omero": {"channels": channels}}}}))

    def test_nested_metadata_overflow_no_stack(self):
        for depth, *words in ((100000, "it nests more than 64 objects"), (60,)):
            nested = '{"a": ' + "[" * depth + "]" * depth + "}"
            for name in ("n.zarr/zarr.json", "2.zarr/.zarray", "5.n5/attributes.json") if words else ("n.zarr/zarr.json",):
                self.write_metadata("n.zarr")
                with open(self.path("n.zarr/zarr.json")) as file:
                    text = file.read().replace('"attributes": {}', f'"attributes": {nested}')
                self.write_text(name, text if name.startswith("n") else nested)
                if words:
                    self.assert_error(name.split("/")[0], name + ": cannot be read", *words)
                else:
                    self.write("n.zarr", "o.bvol")

    def test_codecs_axes_and_channels_are_few(self):
        self.write_metadata("c.zarr", [self.CODEC] * 4)
        self.write("c.zarr", "o.bvol")
        self.write_metadata("c.zarr", [self.CODEC] * 80000)
        self.assert_error("c.zarr", "more than 4 codecs")
        self.write_metadata("i.zarr/0")
        axes = [{"name": name, "type": "space"} for name in "zyx"]
        self.write_image(axes, [{"label": "a"}])
        self.write("i.zarr", "o.bvol")
        self.write_image([{"name": "z", "unit": "u"}] * 33, [])
        self.assert_error("i.zarr", "33 axes")
        self.write_image(axes, [{"label": "a"}] * 1025)
        self.assert_error("i.zarr", "1025 channels")

    def test_separators_of_chunks_lead_nowhere_else(self):
        self.write_metadata("s.zarr", separator=".")
        self.write("s.zarr", "o.bvol")
        self.write_metadata("s.zarr", separator="/../../x/")
        self.assert_error("s.zarr", "separate")

    def test_numbers_that_json_does_not_have_are_read_as_python_writes_them(self):
        numbers = {"a": numpy.nan, "b": [-numpy.inf, numpy.inf], "c": 'a " NaN, \\', "d": {"e": numpy.nan}}
        self.write_metadata("p.zarr", attributes=numbers)
        self.write("p.zarr", "o.bvol")
        for bad in ("NaNs", "nan", "-NaN", "- Infinity", "Inf", "NaN NaN", "1NaN"):
            self.write_text("b.zarr/.zattrs", f'{{"a": {bad}}}')
            self.assert_error("b.zarr", "b.zarr/.zattrs: cannot be read: it is no JSON object; truncated?")
        for dtype, fill in (("float32", numpy.nan), ("float32", "NaN"), ("float32", -numpy.inf), ("float64", numpy.inf)):
            self.assert_fill(dtype, fill, float(fill))

    def assert_fill(self, dtype, fill, value):
        self.write_metadata("f.zarr", data_type=dtype, fill_value=fill)
        self.assert_equal_volumes(self.write("f.zarr", "o.bvol"),
                                  self.write_raw(numpy.full((2, 2, 2), value, dtype), "f"))

    def test_a_fill_value_may_be_the_maximum_of_its_type_as_a_float(self):
        for dtype in ("uint8", "int8", "uint16", "int32", "uint32"):
            self.assert_fill(dtype, float(numpy.iinfo(dtype).max), numpy.iinfo(dtype).max)
        # The maximum of 64 bits is no double: the next one stands for it.
        for dtype, fill, value in (("uint64", 2**64 - 1, 2**64 - 1), ("uint64", 2.0**64, 2**64 - 1),
                                   ("int64", 2.0**63, 2**63 - 1), ("int64", -2.0**63, -2**63)):
            self.assert_fill(dtype, fill, value)
        for dtype, fill in (("uint8", 255.5), ("uint8", 256.0), ("uint8", -1.0), ("int16", 32768.0),
                            ("uint64", 1.8446744073709556e19), ("int64", 9.223372036854778e18), ("uint8", numpy.nan)):
            self.write_metadata("f.zarr", data_type=dtype, fill_value=fill)
            self.assert_error("f.zarr", "f.zarr: cannot be read: its metadata have a fill value beyond the data type")

    def test_an_array_is_read_beside_folders_with_damaged_metadata(self):
        self.write_text("d.zarr/.zgroup", '{"zarr_format": 2}')
        self.write_text("d.zarr/a/.zattrs", '{"a": ')
        error = "d.zarr/a/.zattrs: cannot be read: it is no JSON object; truncated?"
        self.assert_error("d.zarr", error)
        self.write_metadata("d.zarr/b")
        self.write_text("d.zarr/c/zarr.json", "{")
        self.assertEqual(list(self.convert("d.zarr")[1]), ["b"])
        self.assert_error("d.zarr:a", error)
        lines = self.run_tool("--list", "d.zarr")[1].splitlines()
        self.assertEqual(len(lines), 3)
        self.assertIn(error, lines[0])
        self.assertIn("2 x 2 x 2", lines[1])


class ImagesAndErrors(SourceCase):
    def write_image(self, name, version, samples, axes, transformations, **more):
        image = {"version": "0.4", "axes": axes, "datasets": [
            {"path": "0", "coordinateTransformations": transformations}]}
        if version == 2:
            group = create_group(self.path(name))
            write_array_2(self.path(name + "/0"), samples, (1,) * (samples.ndim - 3) + (16, 16, 16), separator="/")
            group.attrs["multiscales"] = [image]
            group.attrs.update(more)
            return
        del image["version"]
        write_array(self.path(name + "/0"), samples,
                    (1,) * (samples.ndim - 3) + (16, 16, 16), [LITTLE])
        with open(self.path(name + "/zarr.json"), "w") as file:
            json.dump({"zarr_format": 3, "node_type": "group", "attributes": {
                "ome": {"version": "0.5", "multiscales": [image], **more}}}, file)

    def test_multiscales(self):
        space = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
        axes = [{"name": "t", "type": "time"}, {"name": "c", "type": "channel"}, *space]
        moves = [{"type": "scale", "scale": [0.5, 1, 2, 0.25, 0.125]},
                 {"type": "translation", "translation": [1, 0, -8, 4, 16]}]
        samples = numpy.stack([numpy.stack([make_samples("uint16", phase=t + 2 * c)
                                            for c in range(2)]) for t in range(2)])
        omero = {"channels": [{"label": "membrane"}, {"label": "nuclei"}]}
        expected = self.write_raw(samples[1, 1], "nuclei", "--time", "1.5",
                                  spacing=(0.125, 0.25, 2), origin=(16, 4, -8), unit="um")
        for version in (2, 3):
            with self.subTest(version=version):
                self.write_image(f"i{version}.zarr", version, samples, axes, moves, omero=omero)
                path = self.write(f"i{version}.zarr", "o.bvol", "--step", "1", "--arrays", "nuclei")
                self.assert_equal_volumes(path, expected)
        self.assertEqual(self.convert("i2.zarr")[2], "")
        info = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])
        self.assertEqual([array["name"] for array in info["arrays"]], ["membrane", "nuclei"])
        self.assertEqual([step["time"] for step in info["timeSteps"]], [1, 1.5])

    def test_levels_keep_their_place_and_images_their_channels(self):
        axes = [{"name": name, "type": "space", "unit": unit}
                for name, unit in zip("xyz", ("nanometer", "micrometer", "micrometer"))]
        samples = make_samples("uint8", (9, 8, 7))
        self.write_image("l.zarr", 2, samples, axes, [{"type": "scale", "scale": [500, 1, 2]}])
        for name in ("l.zarr", "l.zarr:0", "l.zarr/0"):
            grid = self.convert(name)[0]
            self.assertEqual((grid["dimensions"], grid["unit"]), ([9, 8, 7], "nm"))
            self.assertEqual(grid["spacing"], [500, 1000, 2000])

    def test_the_root_of_bioformats2raw_opens_its_first_image(self):
        axes = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
        for version in (2, 3):
            name = f"b{version}.zarr"
            layout, series = {"bioformats2raw.layout": 3}, {"series": ["7", "4"]}
            for path, attributes in ((name, layout), (name + "/OME", series)):
                if version == 2:
                    create_group(self.path(path)).attrs.update(attributes)
                else:
                    os.makedirs(self.path(path), exist_ok=True)
                    with open(self.path(path + "/zarr.json"), "w") as file:
                        json.dump({"zarr_format": 3, "node_type": "group",
                                   "attributes": {"ome": {"version": "0.5", **attributes}}}, file)
            for number, image in enumerate(("7", "4")):
                self.write_image(f"{name}/{image}", version, make_samples("uint8", (9, 8, 7 + number)), axes,
                                 [{"type": "scale", "scale": [3, 2, 1]}])
            grid, arrays, err = self.convert(name)
            self.assertEqual((grid["dimensions"], grid["spacing"], grid["unit"]), ([7, 8, 9], [1, 2, 3], "um"))
            self.assertIn("2 images (7, 4), of which the first one is read", err)
            self.assertEqual(list(arrays), [f"b{version}"])
            self.assertEqual(self.convert(name + ":4")[0]["dimensions"], [8, 8, 9])
            self.assertRegex(self.run_tool("--list", name)[1], r"\n?4 +9 x 8 x 8 +uint8 +an image of 1 levels\n")

    def test_plates_wells_and_labels_are_refused_by_name(self):
        for name, attributes, words in (
                ("plate", {"plate": {"wells": [{"path": "A/1"}, {"path": "B/2"}]}}, ("a plate", ":A/1/0", "B/2")),
                ("well", {"well": {"images": [{"path": "0"}, {"path": "1"}]}}, ("a well", ":0", "0, 1"))):
            create_group(self.path(f"{name}.zarr")).attrs.update(attributes)
            self.assert_error(f"{name}.zarr", f"{name}.zarr: cannot be read", *words)
        axes = [{"name": name, "type": "space"} for name in "zyx"]
        self.write_image("i.zarr", 2, make_samples("uint8", (9, 8, 7)), axes, [])
        create_group(self.path("i.zarr/labels")).attrs["labels"] = ["nuclei"]
        self.assertIn("labels/nuclei", self.convert("i.zarr")[2])
        self.assert_error("i.zarr:labels", "it is labels of an image", "i.zarr:labels/nuclei")

    def test_a_transformation_in_a_file_is_refused(self):
        axes = [{"name": name, "type": "space"} for name in "zyx"]
        self.write_image("t.zarr", 2, make_samples("uint8", (9, 8, 7)), axes, [{"type": "scale", "path": "s"}])
        self.assert_error("t.zarr", "its transformation, scale in a file (path)")
        self.write_image("n.zarr", 2, make_samples("uint8", (9, 8, 7)), axes, [{"type": "scale", "scale": [1, "2", 1]}])
        self.assert_error("n.zarr", "its transformation, scale, is not a scale")

    def test_errors_name_folder_and_reason(self):
        create_group(self.path("g.zarr"))
        write_array_2(self.path("g.zarr/one"), make_samples("int16"), (16, 16, 16))
        write_array_2(self.path("g.zarr/two"), make_samples("int16"), (16, 16, 16),
                      filters=[numcodecs.Delta("int16")])
        write_array_2(self.path("g.zarr/three"), make_samples("complex64"), SHAPE)
        self.write("g.zarr", "o.bvol")
        self.assert_error("g.zarr:two", "g.zarr/two: cannot be read", "filter, delta")
        self.assert_error("g.zarr/three", "g.zarr/three: cannot be read", "<c8")
        write_array_2(self.path("g.zarr/four"), make_samples("int8"), SHAPE, compressor=numcodecs.BZ2())
        self.assert_error("g.zarr:four", "g.zarr/four: cannot be read", "codec, bz2")
        write_array_2(self.path("g.zarr/five"), make_samples("int8"), SHAPE)
        self.assert_error("g.zarr", "five (41 x 37 x 70 int8), one")
        out = self.run_tool("--list", "g.zarr")[1]
        self.assertRegex(out, r"one +41 x 37 x 70 +int16 +chunks of 16 x 16 x 16, blosc\n")
        chunk = self.path("g.zarr/one/1.1.1")
        size = os.path.getsize(chunk)
        for part in (0, 10, size // 2, size - 1):
            os.truncate(chunk, part)
            self.assert_error("g.zarr:one", "one/1.1.1: cannot be read", "truncated",
                              ranks=2 if part == 10 else 1)
        for fill in (128, -129, 2**64 - 1):
            with open(self.path("g.zarr/five/.zarray")) as file:
                metadata = json.load(file)
            metadata["fill_value"] = fill
            with open(self.path("g.zarr/five/.zarray"), "w") as file:
                json.dump(metadata, file)
            self.assert_error("g.zarr:five", "five", "fill value beyond the data type")
        with open(self.path("g.zarr/five/.zarray"), "r+") as file:
            file.truncate(40)
        self.assert_error("g.zarr:five", "five/.zarray: cannot be read", "truncated")

    def test_damaged_shards(self):
        write_array(self.path("s.zarr"), make_samples("int16"), (8, 12, 16), [LITTLE],
                    shard=(48, 48, 96))
        shard = self.path("s.zarr/c/0/0/0")
        with open(shard, "r+b") as file:
            file.seek(-100, 2)
            file.write(b"\x55")
        self.assert_error("s.zarr", "s.zarr/c/0/0/0: cannot be read", "index")
        os.truncate(shard, 50)
        self.assert_error("s.zarr", "s.zarr/c/0/0/0: cannot be read", "truncated")


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
