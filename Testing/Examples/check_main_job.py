# SPDX-License-Identifier: BSD-3-Clause
"""Checks what the main job wrote: check_main_job.py FOLDER BASELINE_PNG EXAMPLES_FOLDER

The image equals the README's, of which its left part, the head MRI, is compared where the CT is not
installed; the table has a row a rank and surface, whose triangles add up to those of vtkFlyingEdges3D on
the whole scans, and every active block was read once or found in the cache.
"""
import csv
import os
import sys

from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkImagingCore import vtkExtractVOI, vtkImageDifference
from vtkmodules.vtkIOImage import vtkPNGReader

folder, baseline, examples = sys.argv[1:4]
sys.path.insert(0, examples)
import debian_scans  # noqa: E402

has_ct = os.path.exists(debian_scans.CRANIUM_CT)
failures = []


def expect(condition, message):
    if not condition:
        failures.append(message)


def read_png(path):
    reader = vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    if has_ct:
        return reader.GetOutput()
    head = vtkExtractVOI()
    head.SetInputConnection(reader.GetOutputPort())
    head.SetVOI(0, 379, 0, 479, 0, 0)
    head.Update()
    return head.GetOutput()


image = read_png(os.path.join(folder, "main_job.png"))
expected = read_png(baseline)
expect(image.GetDimensions() == expected.GetDimensions(), "the image has another size")
if not failures:
    difference = vtkImageDifference()
    difference.SetInputData(image)
    difference.SetImageData(expected)
    difference.Update()
    # In units of whole pixels that differ: room for another version of the software renderer.
    expect(
        difference.GetThresholdedError() < 200,
        f"the image differs from the README's by {difference.GetThresholdedError():.0f} pixels",
    )

with open(os.path.join(folder, "main_job.csv"), newline="") as file:
    rows = list(csv.DictReader(file))
surfaces = 3 if has_ct else 2
expect(len(rows) == 2 * surfaces, f"{len(rows)} rows instead of {surfaces} surfaces on 2 ranks")

scans = {"head.bvol": debian_scans.head_mri()}
if has_ct:
    scans["cranium.bvol"] = debian_scans.cranium_ct()
else:
    scans["macaque.bvol"] = debian_scans.macaque_mri()
for surface in sorted({row["Surface"] for row in rows}):
    parts = [row for row in rows if row["Surface"] == surface]
    stock = vtkFlyingEdges3D()
    stock.SetInputData(scans[parts[0]["Volume"]])
    stock.SetValue(0, float(parts[0]["Isovalue"]))
    stock.Update()
    triangles = sum(int(row["Triangles"]) for row in parts)
    expect(
        triangles == stock.GetOutput().GetNumberOfPolys(),
        f"{surface}: {triangles} triangles, not {stock.GetOutput().GetNumberOfPolys()}",
    )
    shares = [int(row["Triangles"]) for row in parts]
    expect(
        max(shares) <= 1.25 * sum(shares) / len(shares), f"{surface}: unequal shares {shares}"
    )
for row in rows:
    expect(
        int(row["ActiveBlocks"]) == int(row["BlocksRead"]) + int(row["BlockCacheHits"]),
        f"{row['Surface']}, rank {row['Rank']}: blocks read are not the active blocks",
    )

for failure in failures:
    print("FAILED:", failure)
sys.exit(1 if failures else 0)
