# SPDX-License-Identifier: BSD-3-Clause
"""The main job: two scans become blocked volumes; their isosurfaces a picture and a table.

    mpirun -n 2 pvbatch main_job.py --plugin .../ScalableIsosurface.so [--output FOLDER]

Any number of ranks will do. Writes into FOLDER (default: the current one):
    head.bvol, cranium.bvol   the blocked volumes, of 4 stores each
    main_job.png              the head's skin from the MRI; skin and bone from the CT
    main_job.csv              what each query cost each rank
"""
import argparse
import csv
import os
import sys

from paraview import servermanager, simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)

STORES = 4

# file, array, isovalue, what it is, colour, where it stands in the picture (mm)
SURFACES = [
    ("head.bvol", "T1", 40.5, "skin (MRI)", (0.93, 0.76, 0.65), (0, 0, 0)),
    ("cranium.bvol", "HU", -300.5, "skin (CT)", (0.93, 0.76, 0.65), (220, -10, 20)),
    ("cranium.bvol", "HU", 250.5, "bone (CT)", (0.92, 0.90, 0.82), (460, -10, 20)),
]


def write_blocked_volume(image, path):
    """Image -> .vti -> (read in pieces by all ranks) -> .bvol."""
    vti = path[: -len("bvol")] + "vti"
    debian_scans.write(image, vti)
    source = simple.XMLImageDataReader(FileName=[vti])
    simple.SaveData(path, proxy=source, NumberOfStores=STORES, Distribution="Greedy")
    simple.Delete(source)
    os.remove(vti)


def query_costs(contour):
    """The contour's field data: one dictionary a rank."""
    table = simple.AttributeDatatoTable(Input=contour) if hasattr(
        simple, "AttributeDatatoTable") else None
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadDistributedPlugin(arguments.plugin, remote=True, ns=globals())
    print(dir(servermanager.filters)[:5])


main()
