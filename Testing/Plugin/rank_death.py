# SPDX-License-Identifier: BSD-3-Clause
"""A rank that is killed while all draw ends the job: nobody waits for its pixels.

    rank_death.py ... --pvbatch PVBATCH --mpiexec "MPIEXEC -n"
"""
import os
import shutil
import signal
import subprocess
import time
import unittest

import plugin_testing as testing


class RankDeath(unittest.TestCase):
    def check(self, view, ranks, victim):
        folder = testing.output(f"{view}-{ranks}-{victim}")
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        job = subprocess.Popen(
            [
                *testing.arguments.mpiexec.split(),
                str(ranks),
                testing.arguments.pvbatch,
                os.path.join(os.path.dirname(os.path.abspath(__file__)), "draw_forever.py"),
                testing.arguments.plugin,
                testing.volume("wave.bvol"),
                view,
                folder,
            ],
            stdout=subprocess.DEVNULL,
            env=testing.make_mpi_environment(),
        )
        try:
            deadline = time.monotonic() + 600
            while not os.path.exists(os.path.join(folder, "drawn")):
                self.assertIsNone(job.poll(), "the job has ended by itself")
                self.assertLess(time.monotonic(), deadline, "nothing is drawn")
                time.sleep(0.05)
            with open(os.path.join(folder, str(victim))) as file:
                os.kill(int(file.read()), signal.SIGKILL)
            # Those that wait for the dead rank would do so for ever.
            self.assertNotEqual(job.wait(timeout=600), 0)
        finally:
            job.kill()
            job.wait()

    def test_metabuffer_view(self):
        for ranks, victim in ((2, 0), (3, 1)):
            with self.subTest(ranks=ranks, victim=victim):
                self.check("MetabufferRenderView", ranks, victim)


def add_arguments(parser):
    parser.add_argument("--pvbatch", required=True)
    parser.add_argument("--mpiexec", required=True, help="up to the number of ranks")


testing.parse_arguments(add_arguments)
testing.run()
