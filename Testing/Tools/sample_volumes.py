# SPDX-License-Identifier: BSD-3-Clause
"""Samples that tests write into files of other formats, and what blockvolume makes of them."""
import filecmp
import glob
import json
import os
import shutil
import subprocess
import sys
import unittest

import numpy

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from time_limits import WAIT_SECONDS  # noqa: E402  (found in the folder above)

TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32",
         "float64")
SHAPE = (41, 37, 70)  # z, y, x: no multiple of a chunk or a block


def make_samples(dtype, shape=SHAPE, phase=0.0):
    """Waves from 0 to 100 that differ on every axis."""
    k, j, i = numpy.meshgrid(*(numpy.arange(size) for size in shape), indexing="ij")
    waves = numpy.sin(0.31 * i + 0.1 * k + phase) + numpy.cos(0.17 * j) * numpy.sin(0.2 * k)
    return (50 + 25 * waves).astype(dtype)


def get_stores(volume):
    """The folder of a blocked volume's stores."""
    return os.path.join(os.path.dirname(volume), f".{os.path.basename(volume)}.stores")


def list_files(volume):
    """Names within a blocked volume, with the paths."""
    files = {"header": volume}
    for path in glob.glob(get_stores(volume) + "/**", recursive=True):
        if os.path.isfile(path):
            files[os.path.relpath(path, get_stores(volume))] = path
    return files


def run_command(command, mpiexec, folder, ranks=1):
    """Return code, standard output and standard error of a run in a folder."""
    if ranks > 1:
        command = [mpiexec, "--oversubscribe", "-n", str(ranks)] + command
    result = subprocess.run(command, capture_output=True, text=True, cwd=folder,
                            timeout=WAIT_SECONDS)
    return result.returncode, result.stdout, result.stderr


def remove_volume(path):
    """Removes a blocked volume that may be there."""
    for old in (path, get_stores(path)):
        if os.path.exists(old):
            os.remove(old) if os.path.isfile(old) else shutil.rmtree(old)


class VolumeCase(unittest.TestCase):
    """A test that compares blocked volumes."""

    def assert_equal_volumes(self, path, expected):
        mine, others = list_files(path), list_files(expected)
        self.assertEqual(sorted(mine), sorted(others))
        for name in mine:
            self.assertTrue(filecmp.cmp(mine[name], others[name], shallow=False), name)


class SourceCase(VolumeCase):
    """A test of the command; the tool, mpiexec and an empty folder are set by run_claim()."""
    tool = mpiexec = scratch = None

    def run_tool(self, *arguments, ranks=1):
        """Return code, standard output and standard error."""
        return run_command([self.tool, *arguments], self.mpiexec, self.scratch, ranks)

    def path(self, name):
        return os.path.join(self.scratch, name)

    def write(self, source, name, *arguments, ranks=1):
        """Writes a volume anew; its path."""
        path = self.path(name)
        remove_volume(path)
        code, _, err = self.run_tool(source, path, "--stores", "3", *arguments, ranks=ranks)
        self.assertEqual(code, 0, err)
        return path

    def write_raw(self, samples, array, *arguments, spacing=(1, 1, 1), origin=(0, 0, 0), unit="", name="raw"):
        """The blocked volume of the samples in a raw file, which the others must equal."""
        samples.astype(samples.dtype.newbyteorder("<")).tofile(self.path(name + ".raw"))
        place = ["--dimensions", ",".join(str(size) for size in samples.shape[::-1]),
                 "--type", samples.dtype.name, "--name", array,
                 "--spacing", ",".join(repr(float(value)) for value in spacing),
                 "--origin", ",".join(repr(float(value)) for value in origin),
                 *(["--unit", unit] if unit else [])]
        return self.write(name + ".raw", name + ".bvol", *place, *arguments)

    def convert(self, source, *arguments):
        """The grid that --info tells of a volume written of the source, the names and units of its
        arrays, and what the terminal said."""
        remove_volume(self.path("o.bvol"))
        code, _, err = self.run_tool(source, "o.bvol", *arguments)
        self.assertEqual(code, 0, err)
        err = "".join(line for line in err.splitlines(True) if line.startswith("blockvolume:"))  # no progress
        info = json.loads(self.run_tool("--info", "o.bvol", "--json")[1])
        return info["grid"], {array["name"]: array.get("unit", "") for array in info["arrays"]}, err

    def assert_error(self, source, *words, arguments=(), ranks=1):
        """The command fails with one line that has all words, and writes nothing."""
        code, out, err = self.run_tool(source, "e.bvol", *arguments, ranks=ranks)
        lines = [line for line in err.splitlines() if line.startswith("blockvolume:")]
        # What a damaged file claims may not fit the disk of this machine.
        lines = [line for line in lines if "its disk has room for" not in line]
        self.assertEqual((code, out, len(lines)), (1, "", 1), err)
        for word in words:
            self.assertIn(word, lines[0])
        self.assertFalse(os.path.exists(self.path("e.bvol")))


def run_claim(argv, cases):
    """check_X.py TOOL MPIEXEC SCRATCH CLAIM: runs the case of that name."""
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    SourceCase.tool, SourceCase.mpiexec, SourceCase.scratch, claim = argv[1:5]
    shutil.rmtree(SourceCase.scratch, ignore_errors=True)
    os.makedirs(SourceCase.scratch)
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(cases[claim])
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    if result.wasSuccessful():
        shutil.rmtree(SourceCase.scratch)
    return 0 if result.wasSuccessful() else 1
