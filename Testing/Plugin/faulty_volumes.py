# SPDX-License-Identifier: BSD-3-Clause
"""Volumes that cannot be read: ParaView says which file and why, and goes on working.

pvpython faulty_volumes.py ... --pvbatch PVBATCH --mpiexec "MPIEXEC -n" --ranks N

damages copies of a volume, has pvbatch open them with open_volumes.py, and judges what it said.
"""
import glob
import os
import re
import subprocess

import plugin_testing as testing
from volume_damage import FAULTS


class FaultyVolumes(testing.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.paths = [damage() for damage, _ in FAULTS]
        # Each rank's errors go to a file: launchers may tear lines that they forward.
        errors = testing.output("errors")
        cls.done = testing.run_on_ranks(
            "open_volumes.py",
            *cls.paths,
            testing.volume("wave.bvol"),
            before=["sh", "-c", 'errors=$1; shift; exec "$@" 2>"$errors.$$"', "sh", errors],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        cls.stdout, told = cls.done.communicate(timeout=testing.WAIT_SECONDS)
        logs = [told]
        for path in sorted(glob.glob(glob.escape(errors) + ".*")):
            with open(path, encoding="utf-8", errors="replace") as file:
                logs.append(file.read())
            os.remove(path)
        cls.log = re.sub(r"\x1b\[[0-9;]*m", "", "\n".join(logs))  # without colours
        print(cls.stdout, cls.log)

    def test_pvbatch_goes_on_and_opens_a_good_volume_afterwards(self):
        self.assertEqual(self.done.returncode, 0)
        self.assertIn(
            f"wave.bvol: {testing.count_expected_triangles()} triangles", self.stdout
        )

    def test_no_fault_gives_a_surface(self):
        for path in self.paths:
            self.assertIn(f"{os.path.basename(path)}: 0 triangles", self.stdout)

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


testing.run(with_plugin=False)
