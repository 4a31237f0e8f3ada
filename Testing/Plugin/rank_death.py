# SPDX-License-Identifier: BSD-3-Clause
"""A rank that is killed while all draw ends the job: nobody waits for its pixels.

    rank_death.py ... --pvbatch PVBATCH --mpiexec "MPIEXEC -n"
"""
import os
import shutil
import signal
import subprocess
import time

import plugin_testing as testing


class RankDeath(testing.TestCase):
    def check(self, view, ranks, victim):
        folder = testing.output(f"{view}-{ranks}-{victim}")
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        job = testing.run_on_ranks(
            "draw_forever.py",
            testing.volume("wave.bvol"),
            view,
            folder,
            ranks=ranks,
            stdout=subprocess.DEVNULL,
        )
        try:
            deadline = time.monotonic() + testing.WAIT_SECONDS
            while not os.path.exists(os.path.join(folder, "drawn")):
                self.assertIsNone(job.poll(), "the job has ended by itself")
                self.assertLess(time.monotonic(), deadline, "nothing is drawn")
                time.sleep(0.05)
            with open(os.path.join(folder, str(victim))) as file:
                os.kill(int(file.read()), signal.SIGKILL)
            # Those that wait for the dead rank would do so for ever.
            self.assertNotEqual(job.wait(timeout=testing.WAIT_SECONDS), 0)
        finally:
            job.kill()
            job.wait()

    def test_metabuffer_view(self):
        for ranks, victim in ((2, 0), (3, 1)):
            with self.subTest(ranks=ranks, victim=victim):
                self.check("MetabufferRenderView", ranks, victim)


testing.run(with_plugin=False)
