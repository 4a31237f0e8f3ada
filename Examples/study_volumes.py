# SPDX-License-Identifier: BSD-3-Clause
"""What the studies (load_balance.py, scaling_study.py) measure: volumes as files that the programs in
Benchmarks/ read, and the pictures' style."""
import csv
import os
import subprocess

from vtkmodules.vtkIOImage import vtkMetaImageWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

import debian_scans

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot
except ImportError:
    pyplot = None
    print("matplotlib is missing (Debian: python3-matplotlib): tables only, no plots")

COLORS = {"slab": "#999999", "random": "#d1832c", "greedy": "#3b76af", "balanced": "#3a8f4d"}


def run(programs, name, *arguments):
    """Runs one of the programs in Benchmarks/; returns what it printed."""
    command = [os.path.join(programs, name), *[str(argument) for argument in arguments]]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def write_mhd(image, path):
    """Writes the scalars of an image as .mhd and .raw."""
    if image.GetPointData().GetScalars() is None:
        image.GetPointData().SetActiveScalars(image.GetPointData().GetArrayName(0))
    writer = vtkMetaImageWriter()
    writer.SetInputData(image)
    writer.SetFileName(path)
    writer.SetRAWFileName(os.path.splitext(path)[0] + ".raw")
    writer.SetCompression(False)
    writer.Write()
    return path


def prepare(paths, folder, programs, large):
    """Name -> file for each volume: those at the paths (.vti is converted), or Debian's scans; and a
    large one of `large` samples a side, if not 0."""
    volumes = {}
    for path in paths:
        name, extension = os.path.splitext(os.path.basename(path))
        volumes[name] = path
        if extension == ".vti":
            reader = vtkXMLImageDataReader()
            reader.SetFileName(path)
            reader.Update()
            volumes[name] = write_mhd(reader.GetOutput(), os.path.join(folder, name + ".mhd"))
    if not paths:
        for name, image in (
            ("head", debian_scans.head_mri()),
            ("macaque", debian_scans.macaque_mri()),
            ("cranium", debian_scans.cranium_ct()),
        ):
            volumes[name] = write_mhd(image, os.path.join(folder, name + ".mhd"))
    if large:
        name = f"head{large}"
        volumes[name] = os.path.join(folder, name + ".mhd")
        run(programs, "MakeLargeVolume", volumes[name], "--dimensions", large, large, large)
    return volumes


def remove_prepared(volumes, folder):
    """Removes the files that prepare() made."""
    for path in volumes.values():
        if os.path.dirname(path) == folder and path.endswith(".mhd"):
            os.remove(path)
            os.remove(os.path.splitext(path)[0] + ".raw")


def read_table(source):
    """The rows of a CSV file (a path) or text, numbers as such."""

    def convert(text):
        try:
            return float(text)
        except ValueError:
            return text

    lines = source.splitlines() if "\n" in source else open(source, newline="")
    return [{key: convert(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def save(figure, path):
    """Saves a figure as a small PNG (palette colours)."""
    figure.savefig(path, dpi=80, pil_kwargs={"optimize": True})
    pyplot.close(figure)
