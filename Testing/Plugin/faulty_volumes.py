# SPDX-License-Identifier: BSD-3-Clause
"""Volumes that cannot be read: ParaView says which file and why, and goes on working.

pvpython faulty_volumes.py ... --pvbatch PVBATCH --mpiexec "MPIEXEC -n" --ranks N

damages copies of a volume, has pvbatch open them with open_volumes.py, and judges what it said.
"""
import glob
import os
import re
import subprocess
import unittest

import plugin_testing as testing
from volume_damage import FAULTS


class FaultyVolumes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.paths = [damage() for damage, _ in FAULTS]
        ranks = testing.arguments.ranks
        # Each rank's errors go to a file: launchers may tear lines that they forward.
        errors = testing.output("errors")
        cls.done = subprocess.run(
            [
                *testing.arguments.mpiexec.split(),
                str(ranks),
                "sh",
                "-c",
                'errors=$1; shift; exec "$@" 2>"$errors.$$"',
                "sh",
                errors,
                testing.arguments.pvbatch,
                os.path.join(os.path.dirname(os.path.abspath(__file__)), "open_volumes.py"),
                testing.arguments.plugin,
                *cls.paths,
                testing.volume("wave.bvol"),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=testing.make_mpi_environment(),
            timeout=600,  # else it hangs
            text=True,
            errors="replace",
        )
        logs = [cls.done.stderr]
        for path in sorted(glob.glob(glob.escape(errors) + ".*")):
            with open(path, encoding="utf-8", errors="replace") as file:
                logs.append(file.read())
            os.remove(path)
        cls.log = re.sub(r"\x1b\[[0-9;]*m", "", "\n".join(logs))  # without colours
        print(cls.done.stdout, cls.log)

    def test_pvbatch_goes_on_and_opens_a_good_volume_afterwards(self):
        self.assertEqual(self.done.returncode, 0)
        self.assertIn(
            f"wave.bvol: {testing.count_expected_triangles()} triangles", self.done.stdout
        )

    def test_no_fault_gives_a_surface(self):
        for path in self.paths:
            self.assertIn(f"{os.path.basename(path)}: 0 triangles", self.done.stdout)

    def test_each_fault_is_told_with_file_and_reason_by_one_message_a_rank(self):
        errors = [line for line in self.log.splitlines() if "ERR|" in line]
        for path, (_, reason) in zip(self.paths, FAULTS):
            with self.subTest(path=os.path.basename(path)):
                told = [line for line in errors if os.path.basename(path) in line]
                for line in told:
                    self.assertRegex(line.split(os.path.basename(path), 1)[1], reason)
                # Once with the contour and once without, by every rank.
                self.assertEqual(len(told), 2 * testing.arguments.ranks, "\n".join(told))

    def test_the_pipeline_adds_no_words_of_its_own(self):
        self.assertNotIn("returned failure", self.log)
        self.assertNotIn("vtkInformation", self.log)


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, required=True)
    parser.add_argument("--pvbatch", required=True)
    parser.add_argument("--mpiexec", required=True, help="up to the number of ranks")


testing.parse_arguments(add_arguments)
testing.run()
