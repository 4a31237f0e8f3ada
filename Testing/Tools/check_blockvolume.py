#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs blockvolume as its users do: check_blockvolume.py TOOL MPIEXEC INPUTS SCRATCH CLAIM"""
import filecmp
import glob
import itertools
import json
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "Readers"))
from read_blocked_volume import BlockedVolume  # noqa: E402  (found beside this script)
from sample_volumes import WAIT_SECONDS, VolumeCase, get_stores, list_files, remove_volume, run_command  # noqa: E402

TOOL, MPIEXEC, INPUTS, SCRATCH, CLAIM = sys.argv[1:6]
HEAD_MRI = "/usr/share/mricron/templates/ch2.nii.gz"
SIZE = (70, 67, 150)


def run(*arguments, ranks=1):
    """Return code, standard output and standard error of a run."""
    return run_command([TOOL, *arguments], MPIEXEC, SCRATCH, ranks)


class Case(VolumeCase):
    def write(self, source, name, *arguments, ranks=1):
        """Writes a volume anew; its path."""
        path = os.path.join(SCRATCH, name)
        remove_volume(path)
        code, out, err = run(source, path, *arguments, ranks=ranks)
        self.assertEqual(code, 0, err)
        return path


class WritesWhatTheWriterWrites(Case):
    def test_every_format_on_any_ranks(self):
        for name in ("a.mhd", "a.nii.gz", "a.tif", "a.vtk", "a.vti", "a.vtr", "lines.vtk"):
            source = os.path.join(INPUTS, name)
            # vtkTIFFReader takes the resolution of printing for spacing, blockvolume does not;
            # vtkNIFTIImageReader ignores the origin of the qform, blockvolume does not.
            geometry = {"a.tif": ["--spacing", "0.5,0.7500000178813938,0.5"],
                        "a.nii.gz": ["--origin", "0,0,0"]}.get(name, [])
            for ranks in (1, 3):
                with self.subTest(name=name, ranks=ranks):
                    path = self.write(source, "o.bvol", "--stores", "3", *geometry, ranks=ranks)
                    self.assert_equal_volumes(path, source + ".bvol")

    def test_parts_and_all_at_once_and_any_threads(self):
        for source in (os.path.join(INPUTS, name) for name in ("a.vti", "a.vtr")):
            for arguments in (["--memory", "7"], ["--threads", "3"]):
                path = self.write(source, "o.bvol", "--stores", "3", *arguments)
                self.assert_equal_volumes(path, source + ".bvol")

    def test_chosen_array(self):
        for memory in ("7", "500"):
            path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3", "--arrays",
                              "height", "--memory", memory)
            self.assert_equal_volumes(path, os.path.join(INPUTS, "height.vti.bvol"))

    def test_order_of_arrays(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--arrays", "height,density")
        self.assertEqual([a["name"] for a in BlockedVolume(path).arrays], ["height", "density"])

    def test_summary_progress_and_quiet(self):
        source = os.path.join(INPUTS, "a.mhd")
        code, out, err = run(source, "s.bvol", ranks=2)
        self.assertEqual(code, 0)
        self.assertRegex(out, r"^s.bvol: 45 blocks of 32 cells a side in 2 stores, [0-9. MkB]+ "
                              r"\(1.4 MB of samples\), [0-9.]+ s, [0-9]+ MB/s\n$")
        self.assertRegex(err, r"s.bvol: [0-9]+ %\n")
        self.assertNotIn("\r", err)
        self.assertEqual(run(source, "s.bvol", "--quiet"), (0, "", ""))


class ReadsSeriesAndRawSamples(Case):
    def test_raw_in_both_byte_orders(self):
        with open(os.path.join(INPUTS, "a.raw"), "rb") as file:
            samples = file.read()
        count = len(samples) // 2
        with open(os.path.join(SCRATCH, "b.raw"), "wb") as file:
            file.write(b"header" + struct.pack(f">{count}h", *struct.unpack(f"<{count}h", samples)))
        place = ["--stores", "3", "--dimensions", ",".join(map(str, SIZE)), "--type", "int16",
                 "--name", "MetaImage", "--spacing", "0.5,0.75,2", "--origin", "-3,7,1.5"]
        expected = os.path.join(INPUTS, "a.mhd.bvol")
        path = self.write(os.path.join(INPUTS, "a.raw"), "o.bvol", *place)
        self.assert_equal_volumes(path, expected)
        path = self.write("b.raw", "o.bvol", "--header-bytes", "6", "--big-endian", *place, ranks=2)
        self.assert_equal_volumes(path, expected)

    def test_debian_scan(self):
        if not os.path.exists(HEAD_MRI):
            self.skipTest("mricron-data is not installed")
        path = self.write(HEAD_MRI, "head.bvol", ranks=2)
        self.assertEqual(BlockedVolume(path).dimensions, [181, 217, 181])

    def test_folder_and_pattern_of_slices(self):
        # Slices of one strip each, as plain as TIFF can be.
        folder = os.path.join(SCRATCH, "slices")
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        with open(os.path.join(INPUTS, "a.raw"), "rb") as file:
            samples = file.read()
        width, height, depth = SIZE
        size = 2 * width * height
        for k in range(depth):
            tags = [(256, width), (257, height), (258, 16), (259, 1), (262, 1), (273, 146),
                    (277, 1), (278, height), (279, size), (339, 2)]
            text = struct.pack("<2sHIH", b"II", 42, 8, len(tags))
            for tag, value in tags:
                text += struct.pack("<HHII", tag, 4, 1, value)
            with open(os.path.join(folder, f"slice{k}.tif"), "wb") as file:
                file.write(text.ljust(146, b"\0") + samples[k * size:(k + 1) * size])
        place = ["--spacing", "0.5,0.75,2", "--origin", "-3,7,1.5"]
        one = self.write("slices", "o.bvol", *place, "--stores", "3")
        self.assert_equal_volumes(self.write("slices/s*.tif", "p.bvol", *place, "--stores", "3",
                                             ranks=3), one)
        expected = list_files(os.path.join(INPUTS, "a.mhd.bvol"))
        for name, path in list_files(one).items():
            if name != "header":  # which has the array's name
                self.assertTrue(filecmp.cmp(path, expected[name], shallow=False), name)
        os.remove(os.path.join(folder, "slice7.tif"))
        code, out, err = run("slices", "q.bvol")
        self.assertEqual((code, out), (1, ""))
        self.assertRegex(err, r"^blockvolume: slices/slice8.tif: a slice of the series is missing")


class SettingsReachTheFile(Case):
    def test_each(self):
        source = os.path.join(INPUTS, "a.mhd")
        path = self.write(source, "o.bvol", "--block-size", "16", "--stores", "5", "--distribution",
                          "random", "--seed", "12", "--compression", "zstd:7")
        header = BlockedVolume(path).header
        self.assertEqual((header["blockSize"], header["stores"], header["distribution"],
                          header["compression"], header["compressionLevel"]),
                         (16, 5, {"method": "random", "seed": 12}, "zstd", 7))
        path = self.write(source, "o.bvol", "--compression", "none", ranks=2)
        header = BlockedVolume(path).header
        self.assertEqual((header["compression"], header["stores"]), ("none", 2))

    def test_each_value_that_completion_offers(self):
        source = os.path.join(INPUTS, "a.mhd")
        for option, number in (("block-size", 3), ("compression", 3), ("distribution", 4), ("type", 10), ("unit", 11)):
            values = run("--values-of", option)[1].split()
            self.assertEqual(len(values), number, option)
            for value in values if option != "type" else ():
                self.write(source, "o.bvol", "--" + option, value)


class WritesVectorsAndTimeSteps(Case):
    def test_vectors(self):
        source = os.path.join(INPUTS, "flow.vti")
        for arguments in ([], ["--memory", "16"]):
            path = self.write(source, "o.bvol", "--stores", "3", *arguments, ranks=2)
            self.assert_equal_volumes(path, source + ".bvol")
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))
        code, out, err = run("--info", path)
        self.assertEqual(code, 0, err)
        self.assertIn('array         "flow": float32, 3 components\n', out)
        for name in ("pressure", "flow, component 0", "flow, component 2", "flow, magnitude"):
            self.assertIn(f'  range       "{name}": ', out)

    def test_chosen_vectors_come_first(self):
        for memory in ("64", "500"):
            path = self.write(os.path.join(INPUTS, "flow.vti"), "o.bvol", "--block-size", "64",
                              "--compression", "none", "--arrays", "flow,pressure",
                              "--memory", memory)
            volume = BlockedVolume(path)
            self.assertEqual([(a["name"], a["components"]) for a in volume.arrays],
                             [("flow", 3), ("pressure", 1)])
            ranges = volume.header["timeSteps"][0]["ranges"]
            self.assertEqual(ranges[0], ranges[3])  # the first component is the pressure
            volume.overviews[0].verify()  # the trees of magnitudes, too

    def test_cells_are_refused(self):
        source = os.path.join(INPUTS, "flow_and_cells.vti")
        code, _, err = run(source, "cells.bvol", "--stores", "3")
        self.assertEqual(code, 0)
        self.assertRegex(err, r'blockvolume: .*cell arrays are not written \("cells"\)')
        self.assert_equal_volumes(os.path.join(SCRATCH, "cells.bvol"),
                                  os.path.join(INPUTS, "flow.vti.bvol"))
        self.assertEqual(run(source, "cells.bvol", "--quiet"), (0, "", ""))
        code, _, err = run(os.path.join(INPUTS, "cells.vti"), "none.bvol")
        self.assertEqual(code, 1)
        self.assertIn('has only cell arrays ("cells")', err)

    def test_cells_are_averaged_on_request(self):
        for memory in ("14", "500"):
            path = self.write(os.path.join(INPUTS, "flow_and_cells.vti"), "c.bvol", "--cells",
                              "--memory", memory)
            self.assertEqual([a["name"] for a in BlockedVolume(path).arrays][-1], "cells")
            path = self.write(os.path.join(INPUTS, "cells.vti"), "c.bvol", "--cells",
                              "--memory", memory)
            volume = BlockedVolume(path)
            self.assertEqual([a["name"] for a in volume.arrays], ["cells"])
            self.assertEqual(volume.header["timeSteps"][0]["ranges"][0], [1, 1])

    def test_time_steps_are_appended(self):
        source = os.path.join(INPUTS, "a.mhd")
        path = self.write(source, "t.bvol", "--stores", "2", "--time", "0.5")
        before = {name: os.stat(file).st_mtime_ns for name, file in list_files(path).items()}
        for time_ in ("1.5", "2.5"):
            self.assertEqual(run(source, path, "--append", "--time", time_, "--quiet", ranks=2),
                             (0, "", ""))
        self.assertEqual([step["time"] for step in BlockedVolume(path).header["timeSteps"]],
                         [0.5, 1.5, 2.5])
        after = {name: os.stat(file).st_mtime_ns for name, file in list_files(path).items()}
        self.assertTrue(all(after[name] == time_ for name, time_ in before.items()
                            if name != "header"))
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))
        for arguments, reason in ((["--time", "2.5"], "times must ascend"), ([], "has no time"),
                                  (["--time", "3", "--stores", "3"], "it has 2 stores")):
            code, _, err = run(source, path, "--append", "--quiet", *arguments)
            self.assertEqual(code, 1)
            self.assertIn(reason, err)


class VerifyFindsAnyFault(Case):
    def test_sound(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        for ranks in (1, 2):
            code, out, err = run("--verify", path, ranks=ranks)
            self.assertEqual(code, 0, err)
            self.assertRegex(out, r"^.*o.bvol: sound: 24 files, 48 blocks, ")

    def test_a_flipped_bit_in_each_kind_of_file(self):
        random.seed(5)
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        for name, file_path in list_files(path).items():
            if "store-" in name and "store-00001" not in name:
                continue
            with self.subTest(file=name):
                with open(file_path, "rb") as file:
                    good = file.read()
                bad = bytearray(good)
                bad[random.randrange(len(bad))] ^= 1 << random.randrange(8)
                with open(file_path, "wb") as file:
                    file.write(bad)
                code, out, err = run("--verify", path, "--quiet")
                self.assertEqual((code, out), (1, ""))
                self.assertIn(f"blockvolume: {file_path}: ", err)
                with open(file_path, "wb") as file:
                    file.write(good)
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))

    def test_every_fault_is_told(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        files = list_files(path)
        damaged = [files["000001/store-00000/blocks"], files["000001/store-00002/array-1.tree"]]
        for name in damaged:
            with open(name, "r+b") as file:
                file.seek(30)
                file.write(b"damage")
        os.remove(files["000001/store-00001/directory"])
        code, out, err = run("--verify", path, "--quiet")
        self.assertEqual(code, 1)
        for name in damaged + [files["000001/store-00001/directory"]]:
            self.assertIn(f"blockvolume: {name}: ", err)


class InfoTellsWhatIndependentReadersFind(Case):
    def test_json(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        volume = BlockedVolume(path)
        code, out, err = run("--info", path, "--json", "--spectrum")
        self.assertEqual((code, err), (0, ""))
        told = json.loads(out)
        header = volume.header
        for member in ("extent", "origin", "spacing", "direction"):
            self.assertEqual(told["grid"][member], header["grid"][member])
        self.assertEqual(told["grid"]["dimensions"], volume.dimensions)
        levels = sum(part.levels for part in (volume, *volume.overviews))
        self.assertEqual((told["blockSize"], told["levels"]), (volume.block_size, levels))
        self.assertEqual(told["compression"],
                         {"codec": header["compression"], "level": header["compressionLevel"]})
        self.assertEqual(told["distribution"], header["distribution"])
        self.assertEqual(told["arrays"], header["arrays"])
        step, expected = told["timeSteps"][0], header["timeSteps"][0]
        self.assertEqual(step["folder"], expected["folder"])
        self.assertEqual(step["ranges"], expected["ranges"])
        stores = [{"blocks": s["blocks"], "bytes": s["bytes"]} for s in expected["stores"]]
        self.assertEqual(step["stores"], stores)
        for member in ("blocks", "bytes"):
            values = [store[member] for store in stores]
            self.assertEqual(step[member], sum(values))
            self.assertAlmostEqual(step["balance"][member], max(values) * 3 / sum(values))
        for number, total in enumerate(volume.spectra.totals):
            spectrum = step["spectra"][number]
            self.assertEqual(spectrum["isovalue"], volume.spectra.list_isovalues(number))
            for member in ("triangles", "activeCells", "activeBlocks", "bytes"):
                self.assertEqual(spectrum[member], total[member])
            for member, unit in zip(("area", "volume"), volume.spectra.units[number]):
                self.assertEqual(spectrum[member], [count * unit for count in total[member]])
            ratios = []
            for of in zip(*(store["triangles"] for store in volume.spectra.stores[number])):
                if sum(of) >= 3000:
                    ratios.append(max(of) * 3 / sum(of))
            ratios.sort()
            balance = step["balance"]["triangles"][number]
            self.assertEqual(balance["isovalues"], len(ratios))
            self.assertAlmostEqual(balance["worst"], ratios[-1])
            self.assertAlmostEqual(balance["median"], ratios[len(ratios) // 2])

    def test_a_name_that_is_not_utf8(self):
        path = self.write(os.path.join(INPUTS, "a.mhd"), os.fsdecode(b"n\xff.bvol"), "--quiet")
        code, out, err = run("--info", path, "--json")
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(json.loads(out)["file"], path.replace(os.fsdecode(b"\xff"), "\ufffd"))

    def test_text(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        code, out, err = run("--info", path, ranks=2)
        self.assertEqual(code, 0, err)
        for line in ("dimensions    70 x 67 x 150", "spacing       0.5 0.75 2.0",
                     'array         "density": int16', "compression   lz4, level 1",
                     "distribution  greedy, seed 0"):
            self.assertIn(line + "\n", out)
        self.assertEqual(out.count("dimensions"), 1)  # rank 0 alone tells

    def test_spectrum_at_some_isovalues_and_at_all(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "3")
        spectra = BlockedVolume(path).spectra
        for arguments, largest in ((["--info", path], 16), (["--info", path, "--spectrum"], 2048)):
            told = run(*arguments)[1].split("  spectrum    ")[1:]
            self.assertEqual(len(told), len(spectra.totals))
            for number, text in enumerate(told):
                total, isovalues = spectra.totals[number], spectra.list_isovalues(number)
                lines = [line.split() for line in text.splitlines()[1:] if line.startswith("  ")]
                names, rows = lines[0], [list(map(float, line)) for line in lines[1:]]
                self.assertEqual(names, ["isovalue", *spectra.QUANTITIES])
                self.assertEqual(len(rows), min(largest, len(isovalues)))
                self.assertEqual(sorted(rows), rows)
                for row in rows:
                    b = min(range(len(isovalues)), key=lambda b: abs(isovalues[b] - row[0]))
                    self.assertAlmostEqual(row[0], isovalues[b], delta=1e-8 * abs(row[0]))
                    for name, value in zip(names[1:5], row[1:5]):
                        self.assertEqual(value, total[name][b])
                    for name, value, unit in zip(names[5:], row[5:], spectra.units[number]):
                        self.assertAlmostEqual(value, total[name][b] * unit, delta=1e-8 * value)


class RepairRestoresStores(Case):
    def read_all(self, path):
        return {name: open(file, "rb").read() for name, file in list_files(path).items()}

    def test_lost_truncated_and_damaged_stores(self):
        source = os.path.join(INPUTS, "a.vti")
        path = self.write(source, "o.bvol", "--stores", "4", "--replicas", "2", ranks=2)
        self.assertEqual(json.loads(run("--info", "--json", path)[1])["replicas"], 2)
        before = self.read_all(path)
        # A reader that knows nothing of replicas reads the stores.
        alone = self.read_all(self.write(source, "alone.bvol", "--stores", "4"))
        self.assertEqual(BlockedVolume(path).dimensions, list(SIZE))
        stores = [name for name in alone if name.startswith("000001/store-")]
        self.assertEqual(len(stores), 4 * 4)
        self.assertEqual([name for name in stores if before[name] != alone[name]], [])
        step = get_stores(path) + "/000001/"
        for spoil in (lambda: shutil.rmtree(step + "store-00001"),
                      lambda: os.truncate(step + "store-00002/blocks", 4096),
                      lambda: os.remove(step + "store-00003/replica-1/directory")):
            spoil()
            code, _, err = run("--verify", path, "--quiet")
            self.assertEqual(code, 1)
            self.assertIn("is damaged; --repair can restore it", err)
            code, out, err = run("--repair", path)
            self.assertEqual(code, 0, err)
            self.assertIn(": restored\n", out)
            self.assertEqual(self.read_all(path), before)
        self.assertEqual(run("--repair", path, "--quiet"), (0, "", ""))
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))

    def test_what_nobody_has_is_refused_by_one_line_with_the_blocks(self):
        path = self.write(os.path.join(INPUTS, "a.vti"), "o.bvol", "--stores", "4", "--replicas", "2")
        step = get_stores(path) + "/000001/"
        for name in ("store-00001/blocks", "store-00002/replica-1/blocks"):
            with open(step + name, "r+b") as file:
                file.seek(100)
                file.write(b"damage")
        code, _, err = run("--verify", path, "--quiet")
        self.assertEqual(code, 1)
        self.assertIn("--repair cannot restore all of it", err)
        code, out, err = run("--repair", path, "--quiet")
        self.assertEqual((code, out), (1, ""))
        self.assertRegex(err, r"^blockvolume: cannot be restored: .*store-00001: no replica has "
                              r"block [0-9]+\n$")


class ErrorsAreOneLine(Case):
    def check(self, expected, *arguments, ranks=1):
        code, out, err = run(*arguments, ranks=ranks)
        lines = [line for line in err.splitlines() if line.startswith("blockvolume: ")]
        self.assertEqual((code, out, len(lines)), (1, "", 1), err)
        self.assertIn(expected, lines[0])
        if ranks == 1:  # mpirun has words of its own
            self.assertEqual(err, lines[0] + "\n")
        return lines[0]

    def test_arguments(self):
        source = os.path.join(INPUTS, "a.mhd")
        self.check("IN and OUT.bvol are needed")
        self.check("IN and OUT.bvol are needed", source)
        self.check("ends in .bvol", source, "o.mhd")
        self.check("--block-size: 31", source, "o.bvol", "--block-size", "31")
        self.check("--stores", source, "o.bvol", "--stores", "-1")
        self.check("--distribution", source, "o.bvol", "--distribution", "best")
        self.check("--compression", source, "o.bvol", "--compression", "lz4:99")
        self.check("--compression", source, "o.bvol", "--compression", "none:1")
        self.check("--spacing", source, "o.bvol", "--spacing", "1,2")
        self.check("--dimensions", source, "o.bvol", "--dimensions", "3,0,3")
        self.check("--type: needs --dimensions", source, "o.bvol", "--type", "int16")
        self.check("--type: \"int17\"", source, "o.bvol", "--dimensions", "3,3,3", "--type", "int17")
        self.check("--json", source, "o.bvol", "--json")
        commands = {"--info": [], "--verify": [], "--repair": [], "--list": [], "--source": ["a.mhd"]}
        for one, other in itertools.combinations(commands, 2):
            for first, second in ((one, other), (other, one)):
                self.assertIn(other, self.check(one, "o.bvol", first, *commands[first], second, *commands[second]))
        self.check("--replicas", source, "o.bvol", "--stores", "20", "--replicas", "17")
        self.check("3 replicas take as many stores; there are 2", source, "o.bvol",
                   "--stores", "2", "--replicas", "3", ranks=2)
        self.check("--unknown", source, "o.bvol", "--unknown")
        self.check("one file at a time", "--info", "a.bvol", "b.bvol")
        self.check("--arrays", source, "o.bvol", "--arrays", "a,,b")
        self.check("--arrays", source, "o.bvol", "--arrays", "a,a")

    def test_files(self):
        source = os.path.join(INPUTS, "a.mhd")
        for ranks in (1, 3):
            self.check("none.mhd: ", "none.mhd", "o.bvol", ranks=ranks)
        self.check("none.vti: cannot open", "none.vti", "o.bvol")
        self.check('has no numeric point array "x"', source, "o.bvol",
                   "--arrays", "x")
        self.check("/proc/none/.o.bvol.stores", source, "/proc/none/o.bvol", ranks=2)
        self.check("truncated", os.path.join(INPUTS, "a.raw"), "o.bvol", "--dimensions", "70,67,1500")
        self.check("--memory", source, "o.bvol", "--memory", "0")
        for name, text in (("bad.vti", "<no xml"), ("bad.vtk", "no"), ("bad.tif", "no"),
                           ("bad.nii", "no"), ("bad.xyz", "no"), ("bad.mhd", "no"), ("bad.png", "")):
            with open(os.path.join(SCRATCH, name), "w", encoding="ascii") as file:
                file.write(text)
            self.check(f"{name}: ", name, "o.bvol")
            self.check(f"{name}: ", "--info", name)
        with open(os.path.join(SCRATCH, "notes.md"), "w", encoding="ascii") as file:
            file.write("# Notes\n")
        self.check("notes.md: no reader knows", "notes.md", "o.bvol")
        self.assertFalse(os.path.exists(os.path.join(SCRATCH, "o.bvol")))

    def test_what_may_not_be_read_is_told_and_not_missing_empty_or_of_another_kind(self):
        folder = os.path.join(SCRATCH, "private")
        os.mkdir(folder)
        shutil.copy(os.path.join(INPUTS, "a.nii.gz"), os.path.join(folder, "1"))
        for name in ("p.hdr", "p.img"):
            shutil.copy(os.path.join(folder, "1"), os.path.join(SCRATCH, name))
        # root may read everything, but for these capabilities.
        limits = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.geteuid() == 0 else []
        for locked, source in (("private", "private"), ("private/1", "private/1"), ("p.hdr", "p.hdr"), ("p.hdr", "p.img")):
            os.chmod(os.path.join(SCRATCH, locked), 0)
            for arguments in ([source, "o.bvol"], ["--in-place", source, "o.bvol"]):
                code, out, err = run_command([*limits, TOOL, *arguments], MPIEXEC, SCRATCH)
                verb = "list" if locked == "private" else "open"
                self.assertEqual((code, out, err), (1, "", f"blockvolume: {locked}: cannot {verb}: Permission denied\n"))
            os.chmod(os.path.join(SCRATCH, locked), 0o700)

    def test_output_that_is_the_input(self):
        with open(os.path.join(INPUTS, "a.raw"), "rb") as file:
            samples = file.read()
        raw = os.path.join(SCRATCH, "raw.bvol")
        with open(raw, "wb") as file:
            file.write(samples)
        os.link(raw, os.path.join(SCRATCH, "hard.bvol"))
        os.symlink("raw.bvol", os.path.join(SCRATCH, "soft.bvol"))
        with open(os.path.join(INPUTS, "a.mhd"), encoding="ascii") as header:
            text = header.read()
        self.assertIn("a.raw", text)
        with open(os.path.join(SCRATCH, "header.mhd"), "w", encoding="ascii") as header:
            header.write(text.replace("a.raw", "raw.bvol"))
        options = ["--dimensions", "70,67,150", "--type", "int16"]
        for output in ("raw.bvol", "./raw.bvol", raw, "hard.bvol", "soft.bvol"):
            for ranks in (1, 2):
                self.check(f"{output}: is the ", "raw.bvol", output, *options, ranks=ranks)
            self.check(f"{output}: is the ", "header.mhd", output)
        self.check("raw.bvol: is the ", "soft.bvol", "raw.bvol", *options)
        with open(raw, "rb") as file:
            self.assertEqual(file.read(), samples)

    def test_output_that_cannot_be_written(self):
        path = self.write(os.path.join(INPUTS, "a.mhd"), "o.bvol")
        raw = os.path.join(SCRATCH, "a_70x67x150_int16.raw")
        shutil.copy(os.path.join(INPUTS, "a.raw"), raw)
        for arguments in (["--info", path], ["--info", path, "--spectrum"], ["--list", raw], ["--help"],
                          ["--sandbox", "--verify", path]):
            with self.subTest(arguments=arguments), open("/dev/full", "w", encoding="ascii") as full:
                result = subprocess.run([TOOL, *arguments], stdout=full, stderr=subprocess.PIPE, text=True,
                                        cwd=SCRATCH, timeout=WAIT_SECONDS)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr.splitlines()[-1],
                                 "^blockvolume: cannot write to standard output: .")
        os.remove(path)

    def test_axes_and_time_steps_that_nothing_would_obey(self):
        raw = [os.path.join(INPUTS, "a.raw"), "c.bvol", "--dimensions", ",".join(map(str, SIZE)),
               "--type", "int16"]
        for name in ("a.mhd", "a.nii.gz", "a.tif", "a.vti", "a.vtr", "a.vtk"):
            source = os.path.join(INPUTS, name)
            self.check("axes", source, "c.bvol", "--axes", "xyz")
            self.check("time step", source, "c.bvol", "--step", "1")
        self.check("a.tif: cannot be read with the axes \"zyx\": those of TIFF files are given",
                   os.path.join(INPUTS, "a.tif"), "c.bvol", "--axes", "zyx", ranks=2)
        self.check("--axes: ", *raw, "--axes", "xyz")
        self.check("--step: ", *raw, "--step", "1", ranks=2)
        self.assertFalse(glob.glob(os.path.join(SCRATCH, "c.bvol*")))
        self.assertEqual(run(*raw, "--step", "0", "--quiet"), (0, "", ""))

    def test_fifos_and_devices_in_place_of_files(self):
        def pipe(name):
            path = os.path.join(SCRATCH, name)
            if os.path.lexists(path):
                os.remove(path)
            os.mkfifo(path)
            return path
        source = os.path.join(INPUTS, "a.mhd")
        for name in ("pipe.mhd", "pipe.vti", "pipe.vtk", "pipe.nii", "pipe.tif", "pipe.nrrd"):
            self.check("it is a FIFO", pipe(name), "o.bvol")
        self.check("it is a FIFO", pipe("pipe.raw"), "o.bvol", "--dimensions", "3,3,3")
        self.check("it is a FIFO", pipe("pipe.mhd"), "o.bvol", ranks=2)
        with open(source, encoding="ascii") as file:
            header = [line for line in file if not line.startswith("ElementDataFile")]
        with open(os.path.join(SCRATCH, "element.mhd"), "w", encoding="ascii") as file:
            file.writelines(header + ["ElementDataFile = pipe.raw\n"])
        self.check("pipe.raw: cannot open: it is a FIFO", "element.mhd", "o.bvol")
        self.check("pipe.bvol: cannot write: it is a FIFO", source, pipe("pipe.bvol"))
        self.check("pipe.bvol: cannot open: it is a FIFO", "--info", "pipe.bvol")
        self.check("it is a device", "/dev/zero", "o.bvol", "--dimensions", "3,3,3")
        os.remove(os.path.join(SCRATCH, "pipe.bvol"))
        path = self.write(source, "o.bvol")
        for name in ("blocks", "directory", "array-0.tree"):
            kept = os.path.join(get_stores(path) + "/000001/store-00000", name)
            os.rename(kept, kept + ".kept")
            os.mkfifo(kept)
            code, _, err = run("--verify", path, "--quiet")
            self.assertEqual(code, 1)
            self.assertIn(f"{name}: cannot open: it is a FIFO", err)
            os.rename(kept + ".kept", kept)
        os.remove(path)

    def test_work_that_no_volume_is_worth(self):
        self.check("is not from 1 to 4096", os.path.join(INPUTS, "a.mhd"), "few.bvol",
                   "--stores", "65535")
        self.assertFalse(os.path.exists(os.path.join(SCRATCH, ".few.bvol.stores")))
        with open(os.path.join(SCRATCH, "huge.vti"), "w", encoding="ascii") as file:
            extent = "0 2000000 0 2000000 0 2000000"
            file.write('<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">'
                       f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1 1 1">'
                       f'<Piece Extent="{extent}"><PointData Scalars="a"><DataArray type="UInt8" '
                       'Name="a" format="ascii">1 2 3</DataArray></PointData></Piece>'
                       "</ImageData></VTKFile>")
        self.check("huge.vti: cannot be read: a slice has", "huge.vti", "o.bvol")

    def test_grids_without_volume(self):
        for spacing in ("0,1,1", "1,nan,1", "1,1,inf"):
            self.check("pacing", os.path.join(INPUTS, "a.mhd"), "o.bvol", "--spacing", spacing)

    def test_a_grid_of_a_file_is_told_with_the_name_of_the_file(self):
        header = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 0 1 1\nencoding: raw\n\n"
        with open(os.path.join(SCRATCH, "flat.nrrd"), "wb") as file:
            file.write(header.encode() + bytes(64))
        self.check("flat.nrrd: ", "flat.nrrd", "o.bvol")

    def test_fields_of_nrrd_that_are_not_known_or_twice_there(self):
        header = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n"
        for field, code in (("spacing: 2 2 2\n", 0), ("sizes: 4 4 4\n", 1)):
            with open(os.path.join(SCRATCH, "field.nrrd"), "wb") as file:
                file.write((header + field + "\n").encode() + bytes(64))
            status, _, err = run("field.nrrd", "field.bvol")
            self.assertEqual(status, code, err)
            self.assertIn(('"spacing" is none of NRRD\'s, and is not used', 'two fields "sizes"')[code], err)

    def test_names_in_a_file_give_a_terminal_no_orders(self):
        with open(os.path.join(SCRATCH, "evil.mhd"), "wb") as file:
            file.write(b"ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n"
                       b"ElementDataFile = \x1b]0;owned\x07.raw\n")
        code, _, err = run("evil.mhd", "o.bvol")
        self.assertEqual(code, 1)
        self.assertIn("\\x1b]0;owned\\x07", err)
        self.assertNotIn("\x1b]", err)

    def test_a_limit_of_file_sizes_is_told_and_leaves_the_older_volume(self):
        path = self.write(os.path.join(INPUTS, "a.mhd"), "o.bvol")
        limited = subprocess.run(["sh", "-c", 'ulimit -f 64; exec "$@"', "sh", TOOL, os.path.join(INPUTS, "a.mhd"),
                                  path, "--quiet"], cwd=SCRATCH, capture_output=True, text=True, timeout=WAIT_SECONDS)
        self.assertEqual(limited.returncode, 1, limited.stderr)
        self.assertRegex(limited.stderr, r"\Ablockvolume: .*: File too large\n\Z")
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))
        os.remove(path)

    def test_closed_standard_streams_change_nothing(self):
        expected = self.write(os.path.join(INPUTS, "a.mhd"), "o.bvol")
        for streams in ("0", "1", "2", "0 1 2"):
            with self.subTest(streams=streams):
                remove_volume(os.path.join(SCRATCH, "closed.bvol"))
                closing = " ".join(f"{number}{'<' if number == '0' else '>'}&-" for number in streams.split())
                code = subprocess.run(
                    ["sh", "-c", f'exec "$@" {closing}', "sh", TOOL, os.path.join(INPUTS, "a.mhd"),
                     os.path.join(SCRATCH, "closed.bvol")], timeout=WAIT_SECONDS).returncode
                self.assertEqual(code, 0)
                self.assert_equal_volumes(os.path.join(SCRATCH, "closed.bvol"), expected)
        os.remove(expected)

    def test_an_older_volume_survives(self):
        path = self.write(os.path.join(INPUTS, "a.mhd"), "o.bvol")
        self.check("truncated", os.path.join(INPUTS, "a.raw"), "o.bvol", "--dimensions", "70,67,1500")
        self.assertEqual(run("--verify", path, "--quiet"), (0, "", ""))
        os.remove(path)


class StopsWithoutLeavingAnything(Case):
    def stop(self, name, ranks, expected):
        raw = os.path.join(SCRATCH, "large.raw")
        with open(raw, "wb") as file:  # sparse
            file.truncate(1 << 30)
        command = [TOOL, raw, name, "--dimensions", "1024,1024,1024", "--memory", "100",
                   "--compression", "zstd:19", "--block-size", "16", "--quiet"]
        if ranks > 1:
            command = [MPIEXEC, "--oversubscribe", "-n", str(ranks)] + command
        with subprocess.Popen(command, cwd=SCRATCH, stderr=subprocess.PIPE, text=True) as process:
            folder = os.path.join(SCRATCH, get_stores(name))
            end = time.monotonic() + WAIT_SECONDS
            while not glob.glob(folder + "/*") and time.monotonic() < end:
                time.sleep(0.02)
            time.sleep(0.1)
            process.send_signal(signal.SIGINT)
            text = process.communicate(timeout=WAIT_SECONDS)[1]
        os.remove(raw)
        self.assertIn(process.returncode, expected, text)
        self.assertFalse(os.path.exists(os.path.join(SCRATCH, name)))
        return text, glob.glob(folder + "/*")

    def test_one_rank(self):
        text, left = self.stop("stopped.bvol", 1, (130,))
        self.assertRegex(text, r"^blockvolume: [^\n]*\n$")
        self.assertEqual(left, [])

    def test_two_ranks(self):
        # mpirun may end its ranks before they are done with cleaning; the next run does it.
        self.stop("two.bvol", 2, (1, 130))
        path = self.write(os.path.join(INPUTS, "a.mhd"), "two.bvol")
        self.assertEqual(len(glob.glob(get_stores(path) + "/*")), 1)


if __name__ == "__main__":
    shutil.rmtree(SCRATCH, ignore_errors=True)
    os.makedirs(SCRATCH)
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(globals()[CLAIM])
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful())
