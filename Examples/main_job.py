# SPDX-License-Identifier: BSD-3-Clause
"""The main job: two scans become blocked volumes; their isosurfaces become an image and a table.

    mpirun -n 2 pvbatch main_job.py --plugin .../ScalableIsosurface.so [--output FOLDER]

Any number of ranks will do. Writes into FOLDER (default: the current one):
    head.bvol, cranium.bvol   the blocked volumes, of 4 stores each
    main_job.png              the head's skin from the MRI; skin and bone from the CT
    main_job.csv              what each query cost each rank
Where Debian has no package with the CT (invesalius-examples, up to Debian 13), a macaque's brain MRI
takes its place (macaque.bvol).
"""
import argparse
import csv
import os
import sys

from paraview import simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)

STORES = 4

SKIN = (0.93, 0.76, 0.65)
BONE = (0.92, 0.90, 0.82)
BRAIN = (0.88, 0.66, 0.63)

# blocked volume, array, isovalue, what it is, colour, where it stands in the image (mm)
HEAD = [("head.bvol", "T1", 40.5, "skin (MRI)", SKIN, (220, 0, 0))]
CRANIUM = [
    ("cranium.bvol", "HU", -300.5, "skin (CT)", SKIN, (-40, 0, 15)),
    ("cranium.bvol", "HU", 250.5, "bone (CT)", BONE, (-290, 0, 15)),
]
MACAQUE = [("macaque.bvol", "T1", 60.5, "brain (MRI)", BRAIN, (-90, 70, 60))]


def read_costs(contour, folder):
    """The contour's field data: a row (a dictionary of strings) for each rank."""
    path = os.path.join(folder, "query.csv")
    simple.SaveData(path, proxy=contour, FieldAssociation="Field Data")
    with open(path, newline="") as table:
        rows = list(csv.DictReader(table))
    os.remove(path)
    return rows


def extract(surfaces, folder, view):
    """Shows the surfaces in the view; returns the rows of the table."""
    readers = {}
    table = []
    for file_name, array, isovalue, name, color, position in surfaces:
        if file_name not in readers:
            readers[file_name] = simple.OpenDataFile(os.path.join(folder, file_name))
        contour = simple.Isosurface(
            Input=readers[file_name], ContourBy=["POINTS", array], Isosurfaces=[isovalue]
        )
        display = simple.Show(contour, view)
        simple.ColorBy(display, None)
        display.DiffuseColor = color
        display.AmbientColor = color
        if hasattr(display, "Translation"):
            display.Translation = position
        else:  # before ParaView 5.13
            display.Position = position
        for row in read_costs(contour, folder):
            table.append({"Surface": name, "Volume": file_name, "Isovalue": isovalue, **row})
    return table


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))

    settings = {"NumberOfStores": STORES, "Distribution": "Greedy"}
    head = os.path.join(arguments.output, "head.bvol")
    debian_scans.write_blocked_volume(debian_scans.head_mri(), head, **settings)
    if os.path.exists(debian_scans.CRANIUM_CT):
        other, path, surfaces = debian_scans.cranium_ct(), "cranium.bvol", HEAD + CRANIUM
    else:
        print(f"{debian_scans.CRANIUM_CT} is missing (package invesalius-examples, up to Debian 13)")
        print("A macaque's brain MRI (package mricron-data) takes the place of the head CT")
        other, path, surfaces = debian_scans.macaque_mri(), "macaque.bvol", HEAD + MACAQUE
    debian_scans.write_blocked_volume(other, os.path.join(arguments.output, path), **settings)

    view = simple.CreateRenderView(ViewSize=[1200, 480], OrientationAxesVisibility=0)
    view.UseColorPaletteForBackground = 0
    view.Background = [0.16, 0.18, 0.22]
    table = extract(surfaces, arguments.output, view)
    with open(os.path.join(arguments.output, "main_job.csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(table[0]))
        writer.writeheader()
        writer.writerows(table)

    # Both patients look along +y, heads up along +z.
    view.CameraFocalPoint = [75, 120, 88]
    view.CameraPosition = [175, 1120, 238]
    view.CameraViewUp = [0, 0, 1]
    view.CameraParallelProjection = 1
    view.CameraParallelScale = 145
    simple.SaveScreenshot(os.path.join(arguments.output, "main_job.png"), view)
    for row in table:
        print(
            f"{row['Surface']}, rank {row['Rank']}: {row['Triangles']} triangles from "
            f"{row['ActiveBlocks']} blocks, {row['BytesRead']} bytes and "
            f"{row['TreePagesRead']} tree pages read"
        )


main()
