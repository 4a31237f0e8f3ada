# SPDX-License-Identifier: BSD-3-Clause
"""What the studies (load_balance.py, scaling_study.py) measure: volumes as files that the programs in
Benchmarks/ read, and the style of figures."""
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
    from PIL import Image
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


SCANS = {
    "head": debian_scans.head_mri,
    "macaque": debian_scans.macaque_mri,
    "cranium": debian_scans.cranium_ct,
}


def add_volume_arguments(parser):
    parser.add_argument("volumes", nargs="*", help=".bvol, .mhd, .nrrd or .vti; else Debian's scans")
    parser.add_argument("--programs", required=True, help="folder of the built programs")
    parser.add_argument("--output", default=".", help="folder to write into")
    parser.add_argument(
        "--scans", nargs="*", choices=SCANS, default=list(SCANS), help="which of Debian's scans"
    )
    parser.add_argument("--large", type=int, default=0, help="side of a large volume to be made")
    parser.add_argument("--block-size", type=int, default=32, help="16, 32 or 64 cells")


def prepare(arguments, folder):
    """Name -> file for each volume that add_volume_arguments() asks for; .vti files and Debian's
    scans are converted, the large volume is made."""
    volumes = {}
    for path in arguments.volumes:
        name, extension = os.path.splitext(os.path.basename(path))
        volumes[name] = path
        if extension == ".vti":
            reader = vtkXMLImageDataReader()
            reader.SetFileName(path)
            reader.Update()
            volumes[name] = write_mhd(reader.GetOutput(), os.path.join(folder, name + ".mhd"))
    if not arguments.volumes:
        for name in arguments.scans:
            volumes[name] = write_mhd(SCANS[name](), os.path.join(folder, name + ".mhd"))
    if arguments.large:
        name = f"head{arguments.large}"
        volumes[name] = os.path.join(folder, name + ".mhd")
        side = [arguments.large] * 3
        run(arguments.programs, "MakeLargeVolume", volumes[name], "--dimensions", *side)
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
    """Saves a figure as a small PNG (a palette of 48 colours)."""
    figure.savefig(path, dpi=80)
    pyplot.close(figure)
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(48)
    small.save(path, optimize=True)
