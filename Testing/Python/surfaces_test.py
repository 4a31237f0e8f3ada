# SPDX-License-Identifier: BSD-3-Clause
"""Isosurfaces of scalable_isosurface.open, without VTK."""

import concurrent.futures
import gc
import subprocess
import sys
import threading
import unittest

import numpy

import scalable_isosurface as si
from volume_fixtures import make_waves, SHAPE, VolumeTest, write_nrrd

try:
    import meshio
except ImportError:
    meshio = None


class Surfaces(VolumeTest):
    def setUp(self):
        super().setUp()
        self.samples = make_waves()
        self.volume = si.create(self.samples, self.path("waves.bvol"), spacing=(0.5, 1, 2), name="waves")

    def check_closed(self, surface):
        """Corners are points, and normals have length 1."""
        self.assertEqual(surface.triangles.min(), 0)
        self.assertEqual(surface.triangles.max(), len(surface.points) - 1)
        numpy.testing.assert_allclose(numpy.linalg.norm(surface.normals, axis=1), 1, rtol=1e-5)

    def test_points_lie_on_edges_where_samples_cross_the_isovalue(self):
        surface = self.volume.isosurface(0.4)
        self.check_closed(surface)
        grid = surface.points / numpy.float32([0.5, 1, 2])
        low = numpy.floor(grid).astype(int)
        part = grid - low
        self.assertTrue(((part > 1e-4).sum(axis=1) <= 1).all())
        high = numpy.minimum(low + (part > 1e-4), numpy.array(SHAPE[::-1]) - 1)
        ends = [self.samples[tuple(corner.T[::-1])] for corner in (low, high)]
        weight = part.max(axis=1)
        numpy.testing.assert_allclose(ends[0] * (1 - weight) + ends[1] * weight, 0.4, atol=2e-3)

    def test_several_isovalues_are_parts_of_one_surface(self):
        surface = self.volume.isosurface([0.7, -0.2, 99])
        self.assertEqual(surface.isovalues.tolist(), [0.7, -0.2, 99])
        for number, isovalue in enumerate((0.7, -0.2)):
            alone = self.volume.isosurface(isovalue)
            part = surface.part(number)
            for name in ("points", "triangles", "normals"):
                numpy.testing.assert_array_equal(getattr(part, name), getattr(alone, name))
        self.assertTrue(numpy.shares_memory(surface.part(1).points, surface.points))
        self.assertEqual((surface.part(2).points.shape, surface.part(2).triangles.shape), ((0, 3), (0, 3)))
        self.assertRaises(IndexError, surface.part, 3)

    def test_arrays_own_the_memory_and_outlive_the_surface(self):
        surface = self.volume.isosurface(0.4, normals=False)
        self.assertIsNone(surface.normals)
        points, copy = surface.points, surface.points.copy()
        self.assertFalse(points.flags.owndata)
        self.assertTrue(points.flags.writeable)
        del surface
        self.volume.close()
        gc.collect()
        numpy.testing.assert_array_equal(points, copy)

    def test_levels_regions_and_blocks(self):
        coarse = si.create(self.samples[::2, ::2, ::2], self.path("coarse.bvol"), spacing=(1, 2, 4))
        for surface in (self.volume.isosurface(0.4, level=1), self.volume.level(1).isosurface(0.4)):
            self.assertEqual(
                sorted(map(tuple, surface.points)), sorted(map(tuple, coarse.isosurface(0.4).points))
            )
        boxes = self.volume.active_blocks(0.4)
        crossed = 0
        for box in boxes:
            block = self.volume[tuple(slice(*ends) for ends in box)]
            crossed += block.min() < 0.4 <= block.max()
        self.assertEqual(crossed, len(boxes))
        self.assertEqual(len(self.volume.active_blocks(99)), 0)
        region = (0, 3, 0, 3, 0, 3)
        self.assertEqual(self.volume.active_blocks(0.4, region=region).tolist(), [[[0, 33], [0, 33], [0, 33]]])
        inside = self.volume.isosurface(0.4, region=region)
        self.assertTrue((inside.points.max(axis=0) <= (16, 32, 64)).all())
        self.assertGreater(len(inside.triangles), 1000)

    def test_spectrum_counts_the_triangles_of_each_isosurface(self):
        bytes_of_waves = (60 * self.samples + 120).astype(numpy.uint8)
        volume = si.create(bytes_of_waves, self.path("bytes.bvol"), spacing=(0.5, 1, 2))
        spectrum = volume.spectrum()
        for row in (40, 77, 130):
            surface = volume.isosurface(spectrum.isovalues[row], normals=False)
            self.assertEqual(len(surface.triangles), spectrum.triangles[row])
            self.assertEqual(len(volume.active_blocks(spectrum.isovalues[row])), spectrum.blocks[row])
            corners = surface.points[surface.triangles].astype(float)
            area = numpy.linalg.norm(
                numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            ).sum() / 2
            self.assertAlmostEqual(spectrum.area[row] / area, 1, delta=0.1)
        self.assertTrue((numpy.diff(spectrum.volume) <= 0).all())

    def test_components_magnitudes_and_attributes(self):
        vectors = numpy.stack([self.samples, self.samples * 2, -self.samples], axis=-1)
        volume = si.create({"v": vectors, "waves": self.samples}, self.path("v.bvol"), spacing=(0.5, 1, 2))
        alone = self.volume.isosurface(0.4)
        numpy.testing.assert_array_equal(volume.isosurface(0.4, component=0).points, alone.points)
        self.assertEqual(len(volume.isosurface(0.8, component=1).points), len(alone.points))
        magnitude = volume.isosurface(0.9, attributes=["waves", "v"])
        self.assertEqual(magnitude.attributes["v"].shape, (len(magnitude.points), 3))
        numpy.testing.assert_allclose(abs(magnitude.attributes["waves"]), 0.9 / numpy.sqrt(6), atol=0.02)
        self.assertRaisesRegex(IndexError, "'v' has 3 components, and no 3", volume.isosurface, 1, component=3)
        self.assertRaises(KeyError, volume.isosurface, 1, attributes=["mass"])

    def make_ball(self, name, spacing, **place):
        z, y, x = numpy.mgrid[:20, :21, :22] - 10.0
        ball = (7.3 - numpy.sqrt(x * x + y * y + z * z)).astype(numpy.float32)
        return si.create(ball, self.path(name), spacing=(spacing,) * 3, **place)

    def test_enclosed_volumes_are_positive_and_normals_point_out_in_any_direction(self):
        for number, direction in enumerate(
            ([-1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 1, 0, 1, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, -1, 1, 0, 0])
        ):
            volume = self.make_ball(f"ball{number}.bvol", 1, direction=numpy.reshape(direction, (3, 3)))
            surface = volume.isosurface(0)
            a, b, c = (surface.points[surface.triangles[:, n]].astype(float) for n in range(3))
            enclosed = (a * numpy.cross(b, c)).sum() / 6
            self.assertAlmostEqual(enclosed / (4 / 3 * numpy.pi * 7.3**3), 1, delta=0.02)
            middle = surface.points.mean(axis=0)
            self.assertTrue((((surface.points - middle) * surface.normals).sum(axis=1) > 0).all())

    def count_edges(self, triangles):
        """How many triangles meet at each edge; opposite directions are told apart by their sign."""
        edges = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(int)
        ways = numpy.where(edges[:, 0] < edges[:, 1], 1, -1)
        _, number = numpy.unique(numpy.sort(edges, axis=1), axis=0, return_inverse=True)
        return numpy.bincount(number.ravel()), numpy.bincount(number.ravel(), ways)

    def test_closed_surfaces_enclose_what_is_above_or_below(self):
        whole = numpy.prod((numpy.array(SHAPE[::-1]) - 1) * (0.5, 1, 2))
        above, below = (self.volume.isosurface(0.4, close_boundary=True, inside=side) for side in ("above", "below"))
        for surface in (above, below):
            meeting, turns = self.count_edges(surface.triangles)
            self.assertTrue((meeting % 2 == 0).all())
            self.assertFalse(turns.any())
            self.assertTrue((numpy.diff(numpy.sort(surface.triangles, axis=1), axis=1) > 0).all())
            self.assertGreater(surface.volume, 0.1 * whole)
        self.assertAlmostEqual((above.volume + below.volume) / whole, 1, places=5)
        self.assertTrue((self.count_edges(self.volume.isosurface(0.4).triangles)[0] == 1).any())
        with self.assertRaisesRegex(ValueError, "inside='below' is of closed surfaces"):
            self.volume.isosurface(0.4, inside="below")

    def test_degenerate_triangles_are_dropped_on_request(self):
        volume = si.create((self.samples > 0.4).astype(numpy.uint8), self.path("mask.bvol"))
        for drop in (False, True):
            surface = volume.isosurface(1, drop_degenerate_triangles=drop)
            corners = surface.points[surface.triangles].astype(float)
            areas = numpy.linalg.norm(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
            self.assertEqual((areas > 0).all(), drop)

    def test_islands_are_the_largest_by_the_measure_that_is_chosen(self):
        """A flat plate has the largest area, a ball the largest volume, a tiny ball is the smallest."""
        z, y, x = numpy.mgrid[:40, :60, :60].astype(numpy.float32)
        ball = 8.2 - numpy.sqrt((x - 12) ** 2 + (y - 12) ** 2 + (z - 12) ** 2)
        plate = 1.3 - numpy.maximum.reduce([abs(z - 30) + 0 * x, abs(x - 30) - 25, abs(y - 30) - 25])
        tiny = 1.7 - numpy.sqrt((x - 45) ** 2 + (y - 45) ** 2 + (z - 12) ** 2)
        volume = si.create(numpy.maximum.reduce([ball, plate, tiny]), self.path("islands.bvol"), spacing=(1, 1, 1))
        parts = {
            name: si.create(samples, self.path(name + ".bvol")).isosurface(0)
            for name, samples in (("ball", ball), ("plate", plate), ("tiny", tiny))
        }
        counts = {name: len(part.triangles) for name, part in parts.items()}
        self.assertEqual(len(volume.isosurface(0).triangles), sum(counts.values()))
        for keeping, kept in (
            ({"maximum_islands": 1}, ["plate"]),
            ({"maximum_islands": 1, "island_size": "area"}, ["plate"]),
            ({"maximum_islands": 1, "island_size": "volume"}, ["plate"]),
            ({"maximum_islands": 2, "island_size": "volume"}, ["ball", "plate"]),
            ({"minimum_island_size": counts["tiny"] + 1}, ["ball", "plate"]),
            ({"minimum_island_size": parts["ball"].area * 1.01, "island_size": "area"}, ["plate"]),
            ({"minimum_island_size": parts["ball"].volume * 0.99, "island_size": "volume"}, ["ball", "plate"]),
            ({"minimum_island_size": 1e9}, []),
        ):
            surface = volume.isosurface(0, **keeping)
            self.assertEqual(len(surface.triangles), sum(counts[name] for name in kept), keeping)
            points = numpy.concatenate([numpy.empty((0, 3)), *(parts[name].points for name in kept)])
            self.assertEqual(sorted(map(tuple, surface.points)), sorted(map(tuple, points.astype("f4"))))
        several = volume.isosurface([0, 1], maximum_islands=1)
        self.assertEqual(several.part(0).triangles.tolist(), volume.isosurface(0, maximum_islands=1).triangles.tolist())
        self.assertEqual(len(several.part(1).points), len(volume.isosurface(1, maximum_islands=1).points))
        for wrong in ({"island_size": "mass"}, {"maximum_islands": -1}, {"minimum_island_size": numpy.nan}):
            self.assertRaisesRegex(ValueError, next(iter(wrong)), volume.isosurface, 0, **wrong)

    def test_points_are_float64_where_float32_does_not_suffice(self):
        origin = numpy.array([448000, 6000000, -2000.0])
        for name, spacing, dtype in (("fine", 0.05, numpy.float64), ("coarse", 12.5, numpy.float32)):
            volume = self.make_ball(name + ".bvol", spacing, origin=tuple(origin))
            surface = volume.isosurface(0)
            self.assertEqual(surface.points.dtype, dtype)
            for asked in (numpy.float32, "float64"):
                self.assertEqual(volume.isosurface(0, dtype=asked).points.dtype, asked)
            exact = volume.isosurface(0, dtype=float)
            radii = numpy.linalg.norm((exact.points - origin) / spacing - 10, axis=1)
            numpy.testing.assert_allclose(radii, 7.3, atol=0.06)
            self.assertEqual(len(numpy.unique(exact.points, axis=0)), len(exact.points))
            numpy.testing.assert_array_equal(exact.triangles, surface.triangles)
        self.assertRaisesRegex(ValueError, "float32 or float64", volume.isosurface, 0, dtype="int32")

    def test_bad_arguments_are_errors(self):
        self.assertRaises(ValueError, self.volume.isosurface, [])
        self.assertRaises(TypeError, self.volume.isosurface, "high")
        self.assertRaises(ValueError, self.volume.isosurface, 1, region=(1, 2, 3))
        self.assertRaises(IndexError, self.volume.isosurface, 1, level=99)
        self.assertRaises(TypeError, self.volume.isosurface)
        self.assertRaises(ValueError, self.volume.isosurface, float("nan"))

    def test_normals_of_no_points_are_an_empty_array(self):
        surface = self.volume.isosurface(99)
        for array in (surface.points, surface.normals, surface.part(0).normals):
            self.assertEqual((array.shape, array.dtype), ((0, 3), numpy.float32))
        self.assertIsNone(self.volume.isosurface(99, normals=False).normals)

    def test_many_threads_extract_at_once(self):
        expected = {isovalue: self.volume.isosurface(isovalue).points for isovalue in (0.1, 0.2, 0.3, 0.4)}
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for _ in range(5):
                for isovalue, surface in zip(expected, pool.map(self.volume.isosurface, expected)):
                    numpy.testing.assert_array_equal(surface.points, expected[isovalue])

    def test_other_threads_run_meanwhile(self):
        """Where Python takes the GIL from nobody, this thread goes on before the other one has ended."""
        volume = si.create(make_waves((160, 160, 160)), self.path("large.bvol"))
        write_nrrd(self.path("large.nrrd"), volume[...], packed=True)
        foreign = si.open(self.path("large.nrrd"))
        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        for work in (
            lambda: volume.isosurface(0.4),
            lambda: [volume[...] for _ in range(5)],
            lambda: foreign[...],
            lambda: foreign.spectrum(),
            lambda: si.create(foreign, self.path("again.bvol")),
        ):
            order = []
            worker = threading.Thread(target=lambda work=work: [order.append("begin"), work(), order.append("end")])
            sys.setswitchinterval(1000)
            worker.start()
            order.append("meanwhile")
            worker.join()
            sys.setswitchinterval(interval)
            self.assertEqual(order, ["begin", "meanwhile", "end"])

    @unittest.skipUnless(meshio, "there is no meshio")
    def test_meshio_writes_a_surface(self):
        surface = self.volume.isosurface([0.4, 0.6])
        surface.to_meshio().write(self.path("s.vtu"))
        read = meshio.read(self.path("s.vtu"))
        numpy.testing.assert_array_equal(read.points, surface.points)
        numpy.testing.assert_array_equal(read.cells_dict["triangle"], surface.triangles)

    def test_what_is_not_there_is_an_import_error(self):
        script = (
            "import sys\nfor name in ('vtkmodules', 'pyvista', 'meshio'): sys.modules[name] = None\n"
            "import scalable_isosurface as si\n"
            f"surface = si.open({self.path('waves.bvol')!r}).isosurface(0.4)\n"
            "for name in ('vtk', 'pyvista', 'meshio'):\n"
            "    try: getattr(surface, 'to_' + name)()\n"
            "    except ImportError as error: print(error)\n"
            "print(any(name.startswith('vtk') and module for name, module in sys.modules.items()))\n"
        )
        said = subprocess.run([sys.executable, "-B", "-c", script], capture_output=True, text=True, check=True).stdout
        lines = said.splitlines()
        self.assertRegex(lines[0], r"to_vtk\(\) needs the Python modules of VTK")
        self.assertRegex(lines[1], r"to_pyvista\(\) needs PyVista")
        self.assertRegex(lines[2], r"to_meshio\(\) needs meshio")
        self.assertEqual(lines[3], "False")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
