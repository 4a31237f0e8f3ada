# SPDX-License-Identifier: BSD-3-Clause
"""The surface as a picture and as a table, on any number of ranks: --ranks N [--server PVSERVER]

With --server, a pvserver of N ranks is started, and this is its client.
"""
import re
import socket
import subprocess
import unittest

from paraview import simple

import plugin_testing as testing


class Server:
    """A pvserver on this machine, its output in a file."""

    def __init__(self, command, ranks, log):
        with socket.socket() as probe:
            probe.bind(("localhost", 0))
            port = probe.getsockname()[1]
        self.log = log
        with open(log, "wb") as file:
            self.process = subprocess.Popen(
                [*testing.arguments.mpiexec.split(), str(ranks), command, f"--server-port={port}"],
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        # The client waits for the server by itself.
        simple.Connect("localhost", port)

    def stop(self):
        simple.Disconnect()
        self.process.wait(timeout=20)

    def read_log(self):
        with open(self.log, errors="replace") as file:
            return file.read()


class SurfacePictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = None
        if testing.arguments.server:
            cls.server = Server(
                testing.arguments.server, testing.arguments.ranks, testing.output("server.log")
            )
            testing.load_plugin(remote=True)
        testing.load_plugin()

    def test_surface_looks_as_in_the_gui_and_costs_a_row_and_a_line_a_rank(self):
        ranks = testing.arguments.ranks
        view = testing.make_view()
        surface = testing.contour(testing.open_volume("wave.bvol"))
        testing.show_surface(surface, view)
        self.assertLess(
            testing.compare_picture(view, "StabbingContour.png", "surface.png"),
            testing.LARGEST_DIFFERENCE,
        )

        rows = testing.read_costs(surface)
        self.assertEqual([row["Rank"] for row in rows], [str(rank) for rank in range(ranks)])
        triangles = sum(int(row["Triangles"]) for row in rows)
        self.assertEqual(triangles, testing.count_cells(surface))
        for row in rows:
            self.assertEqual(
                int(row["ActiveBlocks"]), int(row["BlocksRead"]) + int(row["BlockCacheHits"])
            )

        # The comparison would see another surface.
        surface.Isosurfaces = [testing.OTHER_ISOVALUE]
        self.assertGreater(
            testing.compare_picture(view, "StabbingContour.png", "another.png"),
            10 * testing.LARGEST_DIFFERENCE,
        )
        self.assertEqual(
            testing.count_cells(surface), testing.count_stock_triangles(testing.OTHER_ISOVALUE)
        )

        if self.server:
            self.server.stop()
            log = self.server.read_log()
            for rank in range(ranks):
                lines = re.findall(rf"Stabbing Contour: rank {rank}: .*", log)
                self.assertEqual(len(lines), 2, f"lines of rank {rank}, one an execution: {log}")
                for part in ("tree pages read", "active blocks", "triangles", "query"):
                    self.assertIn(part, lines[0])


def add_arguments(parser):
    parser.add_argument("--ranks", type=int, required=True)
    parser.add_argument("--server", help="the pvserver program")
    parser.add_argument("--mpiexec", help="how to start it, up to the number of ranks")


testing.run(add_arguments)
