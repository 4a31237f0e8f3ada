# SPDX-License-Identifier: BSD-3-Clause
"""A server that has told of errors goes on: every kind of damage behind every filter that reads it, then
the good volume, on the server at a port.

    errors_on_server.py ... --ranks N --port PORT
"""
import os
import shutil

from paraview import simple

import plugin_testing as testing
from volume_damage import FAULTS

CONSUMERS = {
    "contour": lambda reader: testing.contour(reader),
    "distributed": lambda reader: simple.DistributeIsosurface(Input=testing.contour(reader)),
    "slice": lambda reader: simple.Slice(Input=reader),
}


class ErrorsOnServer(testing.TestCase):
    def delete_all(self):
        for proxy in reversed(list(simple.GetSources().values())):
            simple.Delete(proxy)

    def check_good_surface(self, name):
        surface = testing.contour(testing.open_volume("wave.bvol"))
        view = testing.make_view()
        testing.show_surface(surface, view)
        self.check_image(view, "StabbingContour.png", name)
        self.check_triangles(surface)
        simple.Delete(view)

    def test_good_volumes_have_their_surface_after_every_damage_behind_every_filter(self):
        for damage, _ in FAULTS:
            path = damage()
            for name, make in CONSUMERS.items():
                with self.subTest(damage=damage.__name__, consumer=name):
                    try:
                        consumer = make(simple.BlockedVolumeReader(FileName=path))
                        consumer.UpdatePipeline()
                        self.assertEqual(testing.count_cells(consumer), 0)
                    except RuntimeError:
                        pass  # the reader of no volume has no arrays to choose from
            self.check_good_surface(f"{damage.__name__}.png")
            self.delete_all()

    def test_a_volume_that_was_mended_is_read_by_the_reader_that_could_not(self):
        path = testing.output("mended.bvol")
        reader = simple.BlockedVolumeReader(FileName=path)
        try:
            reader.UpdatePipeline()
        except RuntimeError:
            pass
        shutil.copytree(testing.get_stores(testing.volume("wave.bvol")), testing.get_stores(path))
        shutil.copy(testing.volume("wave.bvol"), path)
        simple.ReloadFiles(reader)
        surface = testing.contour(reader)
        surface.UpdatePipeline()
        self.check_triangles(surface)

    def test_edge_index_files_that_are_damaged_leave_the_server_usable(self):
        surface = testing.contour(testing.open_volume("wave.bvol"))
        good = testing.output("surface.eix")
        simple.SaveData(good, proxy=surface)
        # What is complete of a file that was cut off is shown, with a warning.
        for share, has_blocks in ((0, False), (0.001, False), (0.3, True), (0.9, True)):
            path = testing.output(f"cut{share}.eix")
            shutil.copy(good, path)
            os.truncate(path, int(share * os.path.getsize(good)))
            reader = simple.EdgeIndexReader(FileName=path)
            reader.UpdatePipeline()
            triangles = reader.GetDataInformation().GetNumberOfCells()
            self.assertEqual(triangles > 0, has_blocks)
            self.assertLess(triangles, testing.count_expected_triangles())
        reader = simple.EdgeIndexReader(FileName=good)
        reader.UpdatePipeline()
        self.assertEqual(
            reader.GetDataInformation().GetNumberOfCells(), testing.count_expected_triangles()
        )
        self.check_good_surface("after_edge_indices.png")

    def limit_memory(self, more):
        """Lets the last rank have so many bytes more than it has; any number for None."""
        most = "resource.RLIM_INFINITY" if more is None else f"has + {more}"
        source = simple.ProgrammableSource(
            Script=f"""
import resource
from vtkmodules.vtkParallelCore import vtkMultiProcessController
controller = vtkMultiProcessController.GetGlobalController()
if controller.GetLocalProcessId() == controller.GetNumberOfProcesses() - 1:
    with open("/proc/self/statm") as pages:
        has = int(pages.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, ({most}, resource.RLIM_INFINITY))
"""
        )
        source.UpdatePipeline()
        simple.Delete(source)

    def test_a_rank_that_lacks_memory_fails_a_query_and_serves_the_next_one(self):
        image = simple.Wavelet(WholeExtent=[-150, 150, -150, 150, -150, 150], Maximum=1000)
        surface = testing.contour(image, 990.0)
        few = testing.count_cells(surface)
        self.assertGreater(few, 0)
        self.addCleanup(self.limit_memory, None)
        self.limit_memory(32 << 20)
        many = [100.0 * n for n in range(2, 10)]
        surface.Isosurfaces = many
        try:
            surface.UpdatePipeline()
        except RuntimeError:
            pass
        self.assertEqual(testing.count_cells(surface), 0)
        surface.Isosurfaces = [990.0]
        self.assertEqual(testing.count_cells(surface), few)
        self.limit_memory(None)
        surface.Isosurfaces = many
        self.assertGreater(testing.count_cells(surface), 10 * few)
        self.check_good_surface("after_lack_of_memory.png")


testing.run()
