# SPDX-License-Identifier: BSD-3-Clause
"""A pvserver of N ranks with other tests in pvpython as its clients; the server's log.

    client_and_server.py ... --ranks N --pvserver PATH --pvpython PATH --paraview PATH --mpiexec "mpiexec -n"
        --window-python-path FOLDER [--in-window]
"""
import os
import re
import subprocess

import plugin_testing as testing


class ClientAndServer(testing.TestCase):
    def setUp(self):
        if ("test_gui" in self.id()) != testing.arguments.in_window:
            self.skipTest("in a run of its own")

    def read_log(self):
        return testing.read_log(testing.output("server.log"))

    def start_server(self, *options):
        return testing.start_server(testing.output("server.log"), *options)

    def run_client(self, port, script, output="client", options=()):
        here = os.path.dirname(os.path.abspath(__file__))
        return subprocess.run(
            [
                testing.arguments.pvpython,
                os.path.join(here, script),
                f"--plugin={testing.arguments.plugin}",
                f"--volumes={testing.arguments.volumes}",
                f"--output={testing.output(output)}",
                f"--baselines={testing.arguments.baselines}",
                f"--ranks={testing.arguments.ranks}",
                f"--port={port}",
                *options,
            ],
            env=testing.make_mpi_environment(),
            timeout=testing.WAIT_SECONDS,
            check=False,
        )

    def run_client_and_server(self, script, server_options=(), output="client", options=()):
        server, port = self.start_server(*server_options)
        try:
            self.assertEqual(self.run_client(port, script, output, options).returncode, 0)
            # A server ends with its client.
            self.assertEqual(server.wait(timeout=testing.WAIT_SECONDS), 0)
        finally:
            server.kill()
            server.wait()

    def run_gui(self, script, baseline="StabbingContour.png"):
        """The GUI as client, which plays the script and compares its view with the baseline, if any."""
        folder = os.path.dirname(testing.arguments.plugin)
        plugin = [f"--plugin-search-paths={folder}", "--plugins=ScalableIsosurface"]
        window_environment = {
            "PYTHONPATH": testing.arguments.window_python_path,
            "LD_PRELOAD": testing.arguments.preloaded,
        }
        os.makedirs(testing.output("gui"), exist_ok=True)
        compared = []
        if baseline:
            compared = [f"--test-baseline={testing.baseline(baseline)}", "--test-threshold=3"]
        server, port = self.start_server(*plugin)
        try:
            gui = subprocess.run(
                [
                    testing.arguments.paraview,
                    "--dr",
                    *plugin,
                    f"--server-url=cs://localhost:{port}",
                    f"--data-directory={testing.arguments.volumes}",
                    f"--test-directory={testing.output('gui')}",
                    f"--test-script={os.path.join(testing.arguments.played, script)}",
                    *compared,
                    "--exit",
                ],
                env={**testing.make_mpi_environment(), **window_environment},
                timeout=testing.WAIT_SECONDS,
                check=False,
            )
            self.assertEqual(gui.returncode, 0)
            server.wait(timeout=testing.WAIT_SECONDS)
        finally:
            server.kill()
            server.wait()

    def test_gui_shows_the_distributed_surface(self):
        if not testing.arguments.long:
            self.skipTest("distribute.py is a client as well")
        self.run_gui("GuiDistribute.xml")
        self.assertEqual(
            len(re.findall(r"Distribute Isosurface: rank 0: [1-9]", self.read_log())), 1
        )

    def test_gui_is_coarse_first(self):
        self.run_gui("GuiProgressive.xml")
        log = self.read_log()
        # mpiexec mixes lines of ranks, but no rank begins a surface before all have the last one.
        triangles = [int(count) for count in re.findall(r"cache hits, (\d+) triangles;", log)]
        ranks = testing.arguments.ranks
        surfaces = [sum(triangles[n : n + ranks]) for n in range(0, len(triangles), ranks)]
        # Nobody extracts what another one does not.
        for rank in range(ranks):
            self.assertEqual(log.count(f"Stabbing Contour: rank {rank}: "), len(surfaces))
        full = testing.count_expected_triangles()
        self.assertEqual(surfaces[-1], full)
        self.assertEqual(surfaces.count(full), 2, "applied and redone")
        self.assertLess(20 * surfaces[0], full)

    def test_gui_chooses_isovalues_on_the_spectrum(self):
        self.run_gui("GuiIsovalues.xml")

    def test_gui_is_the_same_as_without_a_server(self):
        if not testing.arguments.long:
            self.skipTest("a long test")
        self.run_gui("GuiLoaded.xml", baseline=None)

    def test_images_and_surfaces_are_those_without_a_server(self):
        self.run_client_and_server("metabuffer_view.py", options=["--also", "distribute"])
        self.assertEqual(
            len(re.findall(r"Distribute Isosurface: rank 0: [1-9]", self.read_log())), 2
        )
        if testing.arguments.long:  # progressive surfaces are seen in windows
            self.run_client_and_server(
                "progressive.py", options=["--also", "surface_representation", "isosurface_colors"]
            )

    def test_wall_shows_the_one_big_image_of_the_stock_view(self):
        import numpy

        ranks = testing.arguments.ranks
        self.run_client_and_server("wall_image.py", output="image")
        # Without it tiles are as large as the screen.
        os.environ["PV_ICET_WINDOW_BORDERS"] = "1"
        self.addCleanup(os.environ.pop, "PV_ICET_WINDOW_BORDERS")
        self.run_client_and_server(
            "wall_image.py", [f"--tdx={ranks}", "--tdy=1"], "tiles", ["--wall"]
        )
        image = testing.read_image(testing.output("image/wall.png"))[:, :, :3]
        tiles = [numpy.load(testing.output(f"tiles/tile-{rank}.npy")) for rank in range(ranks)]
        self.assertTrue((numpy.hstack(tiles) == image).all())
        self.assertGreater(int((image != image[0, 0]).any(axis=2).sum()), 10000)

    def test_server_stays_usable_after_errors(self):
        self.run_client_and_server("errors_on_server.py")
        last = testing.arguments.ranks - 1
        self.assertIn(f"rank {last} failed: There is not enough memory for the isosurface.", self.read_log())

    def test_client_sees_the_same_and_the_log_has_a_line_a_rank(self):
        self.run_client_and_server("surface_images.py")
        log = self.read_log()
        for rank in range(testing.arguments.ranks):
            lines = re.findall(rf"Stabbing Contour: rank {rank}: .*", log)
            self.assertEqual(len(lines), 2, f"two isovalues, but lines {lines}")
            for part in ("tree pages read", "active blocks", "bytes read", "triangles", "query"):
                self.assertIn(part, lines[0])


testing.run(with_plugin=False)
