# SPDX-License-Identifier: BSD-3-Clause
"""What GuiFirstContact.xml did: a file without an index was shown at once, and exactly at the end; so was one at an
address, which is in the state and the trace."""
import os
import subprocess
import sys

from paraview import simple

import plugin_testing as testing

ADDRESS = "http://volumes.example/large.zarr"
SERVER = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Python", "address_server.py")


class FirstContactWindow(testing.TestCase):
    def test_a_sample_is_shown_before_the_index_is_there(self):
        lines = [line for line in testing.read_window_log().split("\n") if "large.zarr.bvol: " in line]
        for is_at_address in (False, True):
            told = [line for line in lines if ("/indexes/" in line) == is_at_address]
            states = [line.rpartition("bvol: ")[2].split(":")[0] for line in told]
            ready = states.index("up to date")
            self.assertIn("is being written", states[:ready])
            self.assertNotIn("is being written", states[ready:])

    def test_the_last_surface_is_that_of_the_whole_file(self):
        surfaces = testing.find_triangles(testing.read_window_log())
        self.assertEqual(surfaces[-1], self.count_triangles())
        self.assertGreater(surfaces.count(surfaces[-1]), 1, "of the file, too")

    def count_triangles(self):
        from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

        image = testing.make_large_image()
        contour = vtkFlyingEdges3D()
        contour.SetInputConnection(image.GetClientSideObject().GetOutputPort())
        contour.SetValue(0, testing.ISOVALUE)
        contour.Update()
        return contour.GetOutput().GetNumberOfPolys()

    def test_state_and_trace_have_the_address_and_no_key(self):
        sys.path.append(os.path.dirname(SERVER))
        from address_server import SECRET

        for name in ("address.pvsm", "trace.py", "window.log"):
            with open(testing.state(name), encoding="utf-8") as file:
                text = file.read()
            self.assertNotIn(SECRET, text)
            if name != "window.log":
                self.assertIn(ADDRESS, text)
        expected = self.count_triangles()
        server = subprocess.Popen(
            [testing.arguments.python, SERVER, testing.arguments.volumes],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.addCleanup(server.communicate)
        os.environ["http_proxy"] = server.stdout.readline().strip()
        simple.ResetSession()
        self.load_state(testing.state("address.pvsm"))
        readers = [proxy for proxy in simple.GetSources().values() if proxy.GetXMLName() == "AddressVolume"]
        self.assertEqual([str(reader.Address) for reader in readers], [ADDRESS])
        contours = [proxy for proxy in simple.GetSources().values() if proxy.GetXMLName() == "Isosurface"]
        counts = [testing.count_cells(contour) for contour in contours if contour.Input.GetXMLName() == "AddressVolume"]
        self.assertEqual(counts, [expected])


testing.run()
