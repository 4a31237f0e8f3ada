# SPDX-License-Identifier: BSD-3-Clause
"""An isosurface as edge-index files: how small in each mode, and back again.

    mpirun -n 2 pvbatch edge_index.py --plugin .../ScalableIsosurface.so [--output FOLDER]
        [--volume VOLUME.bvol --array NAME] [--isovalue VALUE]

Any number of ranks will do. By default the skin of a head MRI (see debian_scans.py). Writes
FOLDER/edge_index_MODE.eix, and tells size, bits a point and seconds of each. The contour makes no
triangles: the writer takes its blocks.
"""
import argparse
import os
import sys
import time

from paraview import servermanager, simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)

MODES = [
    ("lossless", {"Mode": "Lossless"}),
    ("working", {"Mode": "Lossless", "Profile": "Working"}),
    ("bounded", {"Mode": "Bounded", "MaximumError": 0.01}),
    ("smallest", {"Mode": "Smallest", "MaximumError": 0.01}),
    ("quantized", {"Mode": "Quantized", "QuantizationBits": 8}),
]


def write_head(folder):
    path = os.path.join(folder, "edge_index.bvol")
    debian_scans.write_blocked_volume(debian_scans.head_mri(), path, BlockSize=64, NumberOfStores=4)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    parser.add_argument("--volume", help="a blocked volume; default: a head MRI")
    parser.add_argument("--array", default="T1", help="the point array to contour")
    parser.add_argument("--isovalue", type=float, default=40.5)
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))

    contour = simple.Isosurface(
        Input=simple.OpenDataFile(arguments.volume or write_head(arguments.output)),
        ContourBy=["POINTS", arguments.array],
        Isosurfaces=[arguments.isovalue],
    )
    for name, properties in MODES:
        path = os.path.join(arguments.output, "edge_index_%s.eix" % name)
        start = time.time()
        writer = servermanager.writers.EdgeIndexWriter(Input=contour, FileName=path, **properties)
        writer.UpdatePipeline()
        written = time.time()
        surface = simple.OpenDataFile(path)
        surface.UpdatePipeline()
        read = time.time()
        information = surface.GetDataInformation()
        size = os.path.getsize(path)
        if servermanager.vtkProcessModule.GetProcessModule().GetPartitionId() == 0:
            print(
                "%s: %d triangles, %d bytes, %.2f bits a point, written in %.2f s, read in %.2f s"
                % (
                    name,
                    information.GetNumberOfCells(),
                    size,
                    8.0 * size / information.GetNumberOfPoints(),
                    written - start,
                    read - written,
                ),
                flush=True,
            )
        simple.Delete(surface)


main()
