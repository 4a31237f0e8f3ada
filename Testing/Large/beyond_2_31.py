#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""One real run beyond 2^31 bytes on each path: stores, surfaces, edge-index files, meshes, ranks, sources.

    beyond_2_31.py BUILD FOLDER [--only NAME ...]

Makes a volume of 4.6 GB (1024 x 1024 x 1104 float32, a gyroid with noise) and compares what comes of it
with vtkFlyingEdges3D of the same samples, slab by slab: triangles, points, area, and each triangle of the
first and the last slices, bit for bit. Files are read back by numpy. Prints a row for each claim with
bytes, peak of memory and seconds; exit status 1 if one does not hold. Takes half an hour on two cores,
25 GB of FOLDER's disk (all is deleted) and 12 GB of memory. BUILD is the folder of a whole build. Needs
python3-h5py, python3-mpi4py, mpiexec, and the Python of the VTK of the build.
"""
import argparse
import filecmp
import json
import os
import shutil
import struct
import subprocess
import sys
import time

import numpy

from large_volume import SHAPE, open_samples, write_hdf5, write_shard, write_volume

SLAB = 46                   # cells; the oracle contours so many layers at a time
SLICES = 6                  # at both ends, whose triangles are compared one by one
LARGE, SMALL = 0.0, 1.28125  # isovalues of about 230 and 125 million triangles
TRIANGLE = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
FACE = numpy.dtype([("count", "u1"), ("points", "<u4", 3)])


class Summary:
    """What is compared of a surface that comes in parts: counts, area, and the triangles at both ends."""

    def __init__(self):
        self.triangles, self.points, self.area, self.ends = 0, 0, 0.0, {"first": [], "last": []}

    def add(self, corners):
        """Triangles, as an array of n x 3 x 3."""
        for begin in range(0, len(corners), 4_000_000):
            part = corners[begin:begin + 4_000_000]
            (ax, ay, az), (bx, by, bz) = (part[:, 1] - part[:, 0]).T, (part[:, 2] - part[:, 0]).T
            squares = (ay * bz - az * by)**2 + (az * bx - ax * bz)**2 + (ax * by - ay * bx)**2
            self.area += numpy.sqrt(squares).sum(dtype="f8") / 2
            self.triangles += len(part)
            self.ends["first"].append(part[(part[:, :, 2] <= SLICES).all(1)])
            self.ends["last"].append(part[(part[:, :, 2] >= SHAPE[0] - 1 - SLICES).all(1)])

    def get_end(self, name):
        """Its triangles as a sorted array, which depends on no order of points or cells."""
        corners = numpy.concatenate(self.ends[name])
        # Which corner is the first one is the writer's choice.
        first = numpy.lexsort(corners.transpose(2, 0, 1), axis=1)[:, 0]
        corners = corners[numpy.arange(len(corners))[:, None], (first[:, None] + numpy.arange(3)) % 3].reshape(-1, 9)
        return corners[numpy.lexsort(corners.T)]

    def save(self, path):
        numpy.savez(path, triangles=self.triangles, points=self.points, area=self.area,
                    first=self.get_end("first"), last=self.get_end("last"))


def count_crossings(samples, isovalue):
    """Of a slice's edges: the points that the slabs on both sides of it have."""
    inside = samples >= isovalue
    return int((inside[1:] != inside[:-1]).sum() + (inside[:, 1:] != inside[:, :-1]).sum())


def get_corners(surface):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    points = vtk_to_numpy(surface.GetPoints().GetData())
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    for begin in range(0, len(triangles), 4_000_000):
        yield points[triangles[begin:begin + 4_000_000]]


def contour_slabs(folder, isovalue, path):
    """The oracle."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    samples, summary = open_samples(folder), Summary()
    for begin in range(0, SHAPE[0] - 1, SLAB):
        end = min(begin + SLAB, SHAPE[0] - 1)
        slab = numpy.array(samples[begin:end + 1])
        image = vtkImageData()
        image.SetExtent(0, SHAPE[2] - 1, 0, SHAPE[1] - 1, begin, end)
        image.GetPointData().SetScalars(numpy_to_vtk(slab.ravel()))
        contour = vtkFlyingEdges3D()
        contour.SetInputData(image)
        contour.ComputeNormalsOff()
        contour.ComputeScalarsOff()
        contour.SetValue(0, isovalue)
        contour.Update()
        for corners in get_corners(contour.GetOutput()):
            summary.add(corners)
        summary.points += contour.GetOutput().GetNumberOfPoints()
        summary.points -= count_crossings(slab[0], isovalue) if begin > 0 else 0
    summary.save(path)


def make_contour(volume, isovalues, slices=None):
    from scalable_isosurface import vtkBlockedVolumeReader, vtkStabbingContour

    reader = vtkBlockedVolumeReader()
    reader.SetFileName(volume)
    contour = vtkStabbingContour()
    contour.SetInputConnection(reader.GetOutputPort())
    contour.ComputeScalarsOff()
    for number, isovalue in enumerate(isovalues):
        contour.SetValue(number, isovalue)
    if slices:
        contour.UseRegionOn()
        contour.SetRegionPosition(0, 0, slices[0])
        contour.SetRegionLength(SHAPE[2], SHAPE[1], slices[1] - slices[0])
    return contour, reader


def summarise(surface, path):
    summary = Summary()
    for corners in get_corners(surface):
        summary.add(corners)
    summary.points = surface.GetNumberOfPoints()
    summary.save(path)


def describe_arrays(surface):
    arrays = {"points": surface.GetPoints().GetData(), "connectivity": surface.GetPolys().GetConnectivityArray()}
    for number in range(surface.GetPointData().GetNumberOfArrays()):
        array = surface.GetPointData().GetArray(number)
        arrays[array.GetName()] = array
    return ", ".join(f"{name} {array.GetNumberOfValues() * array.GetDataTypeSize():,} bytes"
                     for name, array in arrays.items())


def contour_whole(volume, isovalue, path):
    contour, reader = make_contour(volume, [isovalue])
    contour.Update()
    print(describe_arrays(contour.GetOutput()))
    summarise(contour.GetOutput(), path)


def contour_ends(volume, isovalue, path):
    """The blocks at both ends only."""
    summary = Summary()
    for slices in ((0, SLICES), (SHAPE[0] - 1 - SLICES, SHAPE[0] - 1)):
        contour, reader = make_contour(volume, [isovalue], slices)
        contour.Update()
        for corners in get_corners(contour.GetOutput()):
            summary.add(corners)
    summary.save(path)


def write_edge_index(volume, path, *isovalues):
    from scalable_isosurface import vtkEdgeIndexWriter

    contour, reader = make_contour(volume, isovalues)
    writer = vtkEdgeIndexWriter()
    writer.SetInputConnection(contour.GetOutputPort())
    writer.SetFileName(path)
    writer.SetProfile(1)  # Fast
    writer.SetWriteNormals(len(isovalues) > 1)
    writer.SetNormalError(0)
    if not writer.Write():
        sys.exit(1)
    print(f"{os.path.getsize(path):,} bytes")


def read_edge_index_ends(file, isovalue, path):
    """The triangles at both ends of one of the isovalues of an edge-index file."""
    from scalable_isosurface import vtkEdgeIndexReader
    from vtkmodules.util.numpy_support import vtk_to_numpy

    summary = Summary()
    for begin in (0, SHAPE[0] - 1 - SLICES):
        reader = vtkEdgeIndexReader()
        reader.SetFileName(file)
        reader.UseRegionOn()
        reader.SetRegionPosition(0, 0, begin)
        reader.SetRegionLength(SHAPE[2], SHAPE[1], SLICES)
        reader.Update()
        surface = reader.GetOutput()
        values = next(vtk_to_numpy(surface.GetPointData().GetArray(n))
                      for n in range(surface.GetPointData().GetNumberOfArrays())
                      if surface.GetPointData().GetArray(n).GetName() not in ("GlobalIds", "Normals"))
        triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        triangles = triangles[values[triangles[:, 0]] == isovalue]
        summary.add(vtk_to_numpy(surface.GetPoints().GetData())[triangles])
    summary.save(path)


def distribute(volume, isovalue, path, round_bytes):
    """On several ranks, of which the first one gets the surface."""
    from scalable_isosurface import vtkDistributeIsosurface
    from mpi4py import MPI  # starts MPI, which vtkMPIController alone does not in Python
    from vtkmodules.vtkParallelCore import vtkMultiProcessController
    from vtkmodules.vtkParallelMPI import vtkMPIController

    assert MPI.Is_initialized()
    ranks = vtkMPIController()
    ranks.Initialize()
    vtkMultiProcessController.SetGlobalController(ranks)
    contour, reader = make_contour(volume, [isovalue])
    pieces = vtkDistributeIsosurface()
    pieces.SetInputConnection(contour.GetOutputPort())
    pieces.SetDrawingRanks(1)
    pieces.SetRoundBytes(int(round_bytes))
    pieces.UpdatePiece(ranks.GetLocalProcessId(), ranks.GetNumberOfProcesses(), 0)
    if ranks.GetLocalProcessId() == 0:
        rounds = pieces.GetOutput().GetFieldData().GetArray("Rounds").GetTuple1(0)
        print(f"{describe_arrays(pieces.GetOutput())}; {int(rounds)} rounds")
        summarise(pieces.GetOutput(), path)


def read_stl(file, path):
    summary = Summary()
    with open(file, "rb") as bytes_:
        bytes_.seek(80)
        left = int(numpy.fromfile(bytes_, "<u4", 1)[0])
        while left > 0:
            part = numpy.fromfile(bytes_, TRIANGLE, min(left, 2_000_000))
            summary.add(part["corners"])
            left -= len(part)
        assert not bytes_.read(1), "bytes behind the last triangle"
    summary.save(path)


def read_ply(file, path):
    summary = Summary()
    with open(file, "rb") as bytes_:
        text = bytes_.read(512).decode()
    counts = {line.split()[1]: int(line.split()[2]) for line in text.splitlines() if line.startswith("element")}
    assert text.endswith("end_header\n") and "property list uchar int vertex_indices" in text
    points = numpy.memmap(file, "<f4", "r", 512, (counts["vertex"], 3))
    faces = numpy.memmap(file, FACE, "r", 512 + 12 * counts["vertex"])
    assert len(faces) == counts["face"]
    for begin in range(0, len(faces), 2_000_000):
        part = faces[begin:begin + 2_000_000]
        assert (part["count"] == 3).all()
        summary.add(points[part["points"]])
    summary.points = counts["vertex"]
    summary.save(path)


def read_glb(file, path):
    summary = Summary()
    with open(file, "rb") as bytes_:
        _, _, size, length = struct.unpack("<4sIII", bytes_.read(16))
        assert size == os.path.getsize(file)
        bytes_.read(4)
        scene = json.loads(bytes_.read(length))
    binary = numpy.memmap(file, "u1", "r", 28 + length)
    assert len(binary) == scene["buffers"][0]["byteLength"]

    def read(number, kind):
        accessor = scene["accessors"][number]
        view = scene["bufferViews"][accessor["bufferView"]]
        return binary[view["byteOffset"]:view["byteOffset"] + view["byteLength"]].view(kind)

    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            points = read(primitive["attributes"]["POSITION"], "<f4").reshape(-1, 3)
            summary.add(points[read(primitive["indices"], "<u4").reshape(-1, 3)])
    summary.save(path)


class Runs:
    """The claims, each of which is a method."""

    def __init__(self, build, folder):
        self.build, self.folder, self.failures = build, folder, 0
        packages = os.path.join(build, "lib/python3/dist-packages")
        self.environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                            "PYTHONPATH": packages + ":" + os.environ.get("PYTHONPATH", "")}

    def path(self, name):
        return os.path.join(self.folder, name)

    def remove(self, *names):
        for name in names:
            path = self.path(name)
            for any_ in (path, self.path(f".{name}.stores")):
                shutil.rmtree(any_, ignore_errors=True) if os.path.isdir(any_) else \
                    os.path.exists(any_) and os.remove(any_)

    def tell(self, title, holds, *details):
        self.failures += not holds
        print(f"| {title} | {'; '.join(detail for detail in details if detail)} | {'holds' if holds else 'FAILS'} |",
              flush=True)

    def run(self, *command):
        """Its exit status, what it prints, and the peak of memory of its largest process, and seconds."""
        clock = time.perf_counter()
        with open(self.path("printed"), "w+") as printed:
            process = subprocess.Popen(command, stdout=printed, stderr=subprocess.STDOUT, env=self.environment)
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            printed.seek(0)
            text = printed.read().strip().replace("\n", " ")
        return process.returncode, text, f"{used.ru_maxrss / 2**20:.1f} GiB, {time.perf_counter() - clock:.0f} s"

    def call(self, function, *arguments, ranks=1):
        mpi = ["mpiexec", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        return self.run(*mpi, sys.executable, __file__, "--call", function, *map(str, arguments))

    def run_tool(self, name, *arguments, ranks=1):
        mpi = ["mpiexec", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        return self.run(*mpi, os.path.join(self.build, "bin", name), *arguments)

    def find_expected(self, isovalue):
        path = self.path(f"expected-{isovalue}.npz")
        if not os.path.exists(path):
            code, text, cost = self.call("contour_slabs", self.folder, isovalue, path)
            self.tell(f"vtkFlyingEdges3D at {isovalue}", code == 0, text, cost)
        return numpy.load(path)

    def compare(self, title, outcome, isovalue, keys=("triangles", "points", "area", "first", "last")):
        """What a call saved as found.npz with what the oracle did."""
        code, text, cost = outcome
        expected, differences = self.find_expected(isovalue), []
        if code == 0:
            found = numpy.load(self.path("found.npz"))
            differences = [key for key in keys if not (
                abs(found[key] / expected[key] - 1) < 1e-6 if key == "area" else
                numpy.array_equal(found[key], expected[key]))]
            os.remove(self.path("found.npz"))
            text += f" {int(found['triangles']):,} triangles"
        self.tell(title, code == 0 and not differences, text.strip(), cost, *differences)

    def store(self):
        code, text, cost = self.run_tool("blockvolume", self.path("v.mhd"), self.path("v.bvol"), "--stores", "1",
                                         "--compression", "none", "--memory", "2048", "--quiet")
        size = sum(os.path.getsize(os.path.join(folder, name))
                   for folder, _, names in os.walk(self.path(".v.bvol.stores")) for name in names if name == "blocks")
        self.tell("a store is written", code == 0 and size > 2**32, text, f"{size:,} bytes", cost)
        code, text, cost = self.run_tool("blockvolume", "--verify", "--quiet", self.path("v.bvol"))
        self.tell("it is verified", code == 0, text, cost)
        self.compare("its ends are queried", self.call("contour_ends", self.path("v.bvol"), LARGE,
                                                       self.path("found.npz")), LARGE, ("first", "last"))

    def surface(self):
        self.compare("a surface on one rank", self.call("contour_whole", self.path("v.bvol"), LARGE,
                                                        self.path("found.npz")), LARGE)

    def edgeindex(self):
        code, text, cost = self.call("write_edge_index", self.path("v.bvol"), self.path("large.eix"), LARGE, SMALL)
        self.tell("an .eix with normals is written", code == 0 and os.path.getsize(self.path("large.eix")) > 2**31,
                  text, cost)
        code, text, cost = self.run_tool("edgeindex", "verify", "--quiet", self.path("large.eix"))
        self.tell("it is verified", code == 0, text, cost)
        for isovalue in (LARGE, SMALL):
            self.compare(f"its ends are read, {isovalue}", self.call(
                "read_edge_index_ends", self.path("large.eix"), isovalue, self.path("found.npz")), isovalue,
                ("first", "last"))
        code, text, cost = self.run_tool("edgeindex", "decode", "--quiet", self.path("large.eix"),
                                         self.path("large.glb"))
        self.tell("a .glb beyond 2^32 is refused", code == 1 and "4 GiB" in text
                  and not [name for name in os.listdir(self.folder) if name.endswith(".glb")], text, cost)
        self.remove("large.eix", "large.glb")

    def mesh(self):
        code, text, cost = self.call("write_edge_index", self.path("v.bvol"), self.path("small.eix"), SMALL)
        self.tell("an .eix for meshes", code == 0, text, cost)
        for kind, least in (("stl", 2**32), ("ply", 2**31), ("glb", 2**31)):
            name = self.path("small." + kind)
            code, text, cost = self.run_tool("edgeindex", "decode", "--quiet", self.path("small.eix"), name)
            size = os.path.getsize(name) if code == 0 else 0
            self.tell(f"it is decoded to .{kind}", code == 0 and size > least, text, f"{size:,} bytes", cost)
            keys = ("triangles", "area", "first", "last") + ("points",) * (kind == "ply")
            self.compare(f"the .{kind} is read by numpy", self.call("read_" + kind, name, self.path("found.npz")),
                         SMALL, keys)
            self.remove("small." + kind)
        self.remove("small.eix")

    def ranks(self):
        code, text, cost = self.run(
            "mpiexec", "--oversubscribe", "-n", "2", os.path.join(self.build, "bin/TestParallel"),
            "--gtest_filter=*DISABLED_SendsMessagesBeyondTwoGibibytes", "--gtest_also_run_disabled_tests")
        self.tell("messages of more than 2^31 bytes", code == 0, cost)
        for round_bytes in (2**22, 2**34):
            self.compare(f"2 ranks give one a surface, rounds of up to {round_bytes:,} bytes",
                         self.call("distribute", self.path("v.bvol"), SMALL, self.path("found.npz"), round_bytes,
                                   ranks=2), SMALL)
        code, text, cost = self.run_tool("blockvolume", self.path("v.mhd"), self.path("w.bvol"), "--stores", "1",
                                         "--compression", "none", "--memory", "2048", "--quiet", ranks=2)
        same = code == 0
        for folder, _, names in os.walk(self.path(".v.bvol.stores")):
            other = folder.replace(".v.bvol.stores", ".w.bvol.stores")
            same = same and all(filecmp.cmp(os.path.join(folder, name), os.path.join(other, name), shallow=False)
                                for name in names)
        self.tell("2 ranks write one store: the bytes of one rank", same, text, cost)
        self.remove("w.bvol")

    def source(self):
        self.remove("v.bvol")
        for title, source, make in (("raw", "v.mhd", None), ("HDF5, chunked", "v.h5:/d", "write_hdf5"),
                                    ("Zarr 3, one shard", "v.zarr", "write_shard")):
            if make:  # in another process: the memory of this one would count as that of the next
                self.call(make, self.folder)
            code, text, cost = self.run_tool("blockvolume", "--in-place", self.path(source), self.path("p.bvol"),
                                             "--memory", "2048", "--quiet")
            self.tell(f"in place: {title}", code == 0, text, cost)
            self.compare(f"in place, {title}: both ends are queried", self.call(
                "contour_ends", self.path("p.bvol"), LARGE, self.path("found.npz")), LARGE, ("first", "last"))
            self.remove("p.bvol", "v.h5", "v.zarr")


CALLS = {function.__name__: (function, kinds) for function, kinds in (
    (contour_slabs, (str, float, str)), (contour_whole, (str, float, str)), (contour_ends, (str, float, str)),
    (write_edge_index, (str, str, float, float)), (read_edge_index_ends, (str, float, str)),
    (distribute, (str, float, str, int)), (read_stl, (str, str)), (read_ply, (str, str)), (read_glb, (str, str)),
    (write_volume, (str,)), (write_hdf5, (str,)), (write_shard, (str,)))}
NAMES = ("store", "surface", "edgeindex", "mesh", "ranks", "source")


def main():
    if sys.argv[1:2] == ["--call"]:
        function, kinds = CALLS[sys.argv[2]]
        function(*(kind(text) for kind, text in zip(kinds, sys.argv[3:])))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("folder")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--keep", action="store_true", help="keep the volume, and use the one that is there")
    arguments = parser.parse_args()
    os.makedirs(arguments.folder, exist_ok=True)
    runs = Runs(arguments.build, arguments.folder)
    print("| run | measured | |\n|---|---|---|", flush=True)
    try:
        if not os.path.exists(runs.path("v.mhd")):
            runs.call("write_volume", arguments.folder)
        if "store" not in arguments.only and set(arguments.only) - {"source"} and \
                not os.path.exists(runs.path("v.bvol")):
            runs.store()
        for name in NAMES:
            if name in arguments.only:
                getattr(runs, name)()
    finally:
        if not arguments.keep:
            runs.remove("v.bvol", "v.mhd", "v.raw", "v.h5", "v.zarr", "p.bvol", "w.bvol", "printed", "found.npz",
                        "small.eix", "large.eix", *(f"expected-{value}.npz" for value in (LARGE, SMALL)))
    sys.exit(1 if runs.failures else 0)


main()
