# SPDX-License-Identifier: BSD-3-Clause
"""Queries in pvbatch print nothing, unless the verbosity asks for it."""
import os
import re
import subprocess
import unittest

import plugin_testing as testing


def run_queries(*options):
    """All that pvbatch prints, of all ranks."""
    here = os.path.dirname(os.path.abspath(__file__))
    done = subprocess.run(
        [
            *testing.arguments.mpiexec.split(),
            str(testing.arguments.ranks),
            testing.arguments.pvbatch,
            *options,
            os.path.join(here, "run_queries.py"),
            testing.arguments.plugin,
            testing.volume("wave.bvol"),
            testing.arguments.output,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=testing.make_mpi_environment(),
        timeout=600,  # else it hangs
        check=True,
        text=True,
        errors="replace",
    )
    return done.stdout


class Quiet(unittest.TestCase):
    def test_queries_print_nothing(self):
        self.assertEqual(run_queries(), "")

    def test_verbosity_1_prints_the_cost_of_each_rank(self):
        log = run_queries("--verbosity=1")
        for rank in range(testing.arguments.ranks):
            self.assertRegex(log, rf"Stabbing Contour: rank {rank}: [0-9]+ tree pages read")
        self.assertTrue(re.search(r"surface\.eix: [0-9]+ blocks", log))


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, required=True)
    parser.add_argument("--pvbatch", required=True)
    parser.add_argument("--mpiexec", required=True, help="up to the number of ranks")


testing.parse_arguments(add_arguments)
testing.run()
