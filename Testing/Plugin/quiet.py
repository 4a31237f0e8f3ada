# SPDX-License-Identifier: BSD-3-Clause
"""Queries in pvbatch print nothing, unless the verbosity asks for it."""
import re
import subprocess

import plugin_testing as testing


def run_queries(*options):
    """All that pvbatch prints, of all ranks."""
    with testing.run_on_ranks(
        "run_queries.py",
        testing.volume("wave.bvol"),
        testing.arguments.output,
        options=options,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as job:
        printed, _ = job.communicate(timeout=testing.WAIT_SECONDS)
    assert job.returncode == 0
    return printed


class Quiet(testing.TestCase):
    def test_queries_print_nothing(self):
        self.assertEqual(run_queries(), "")

    def test_verbosity_1_prints_the_cost_of_each_rank(self):
        log = run_queries("--verbosity=1")
        for rank in range(testing.arguments.ranks):
            self.assertRegex(log, rf"Stabbing Contour: rank {rank}: [0-9]+ tree pages read")
        self.assertTrue(re.search(r"surface\.eix: [0-9]+ blocks", log))


testing.run(with_plugin=False)
