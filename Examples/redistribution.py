# SPDX-License-Identifier: BSD-3-Clause
"""From an isovalue to the image on several ranks, and what it costs to bring each rank its part.

    mpirun -n 4 pvbatch redistribution.py --plugin .../ScalableIsosurface.so [--output FOLDER]
        [--volume VOLUME.bvol --array NAME] [--isovalues VALUE ...] [--without-images]

Each rank extracts the blocks in its stores; Distribute Isosurface sends them, compressed, to the
ranks that draw them, each a compact part; the Metabuffer render view draws each part into a
viewport of its own, and merges them. By default the skin and the brain of a head MRI (see
debian_scans.py), first coarse, then in full.

Writes FOLDER/redistribution_ISOVALUE_levelL.png, with the ranks' viewports outlined, and prints
what the frames took, and what the ways to send the full surface did, by turns. Bytes are those of
all ranks together:

raw      points (3 float32), GlobalIds (int64), normals (3 float32), three int32 corners a triangle:
         the surface as the ranks get it, each point once on each rank that has it
sent     from rank to rank, including the descriptions of blocks that all ranks exchange
per link seconds in which a link of that many Mb/s passes what its rank sends, or gets, the greatest
         of all: computed of the bytes
"""
import argparse
import csv
import os
import statistics
import sys
import time

from paraview import simple

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import debian_scans  # noqa: E402  (found beside this script)

# Properties of Distribute Isosurface, and whether Isosurface computes normals.
MODES = {
    "Lossless, exact normals": ({"Mode": "Lossless", "NormalError": 0}, True),
    "Lossless": ({"Mode": "Lossless", "NormalError": 0.01}, True),
    "Bounded": ({"Mode": "Bounded", "NormalError": 0.02}, True),
    "Lossless, without normals": ({"Mode": "Lossless"}, False),
    "Bounded, without normals": ({"Mode": "Bounded"}, False),
}
SECONDS = ("QuerySeconds", "EncodeSeconds", "ChooseSeconds", "ExchangeSeconds", "DecodeSeconds")
LINKS = (100, 1000)  # Mb/s


def write_head(folder, block_size):
    """The default volume; its stores are dealt out to the ranks."""
    path = os.path.join(folder, "redistribution.bvol")
    debian_scans.write_blocked_volume(debian_scans.head_mri(), path, BlockSize=block_size, NumberOfStores=8)
    return path


def read_costs(surface, folder):
    """The field data of all ranks: a list of dictionaries."""
    path = os.path.join(folder, "costs.csv")
    simple.SaveData(path, proxy=surface, FieldAssociation="Field Data")
    with open(path, newline="") as table:
        rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(table)]
    os.remove(path)
    return rows


def make_view():
    view = simple.CreateView("MetabufferRenderView")
    view.ViewSize = [800, 800]
    view.OrientationAxesVisibility = 0
    view.ShowViewports = 1
    return view


def show_frames(contour, surface, isovalues, folder):
    """Draws each surface coarse, then in full; prints a table."""
    print("| isovalue | level | triangles | most on a rank | sent, kB | seconds to the image |")
    print("|---|---|---|---|---|---|")
    view = make_view()
    for isovalue in isovalues:
        for level in (2, 0):
            contour.Isosurfaces = [isovalue]
            contour.Level = level
            start = time.time()
            display = simple.Show(surface, view)
            simple.ColorBy(display, None)
            if isovalue == isovalues[0] and level == 2:
                camera = view.GetActiveCamera()
                camera.SetPosition(0.4, 1, 0.2)
                camera.SetFocalPoint(0, 0, 0)
                camera.SetViewUp(0, 0, 1)
                simple.ResetCamera(view)
            simple.Render(view)
            seconds = time.time() - start
            costs = read_costs(surface, folder)
            triangles = [int(row["Triangles"]) for row in costs]
            sent = sum(row["SentBytes"] for row in costs)
            print(
                f"| {isovalue:g} | {level} | {sum(triangles)} | {max(triangles)} "
                f"| {sent / 1e3:.1f} | {seconds:.2f} |"
            )
            name = f"redistribution_{isovalue:g}_level{level}.png"
            simple.SaveScreenshot(os.path.join(folder, name), view)


def measure(contour, surface, mode, folder):
    settings, contour.ComputeNormals = MODES[mode]
    for name, value in settings.items():
        setattr(surface, name, value)
    start = time.time()
    surface.UpdatePipeline()
    return time.time() - start, read_costs(surface, folder)


def find_link_bytes(costs):
    """The most that a rank sends, or gets if all get alike, beside what stays."""
    sent = [row["SentBytes"] for row in costs]
    return max(max(sent), sum(sent) / len(sent))


def print_row(mode, runs):
    costs = runs[-1][1]
    raw = sum(row["RawBytes"] for row in costs)
    sent = sum(row["SentBytes"] for row in costs)
    encoded = sum(row["EncodedBytes"] for row in costs)
    triangles = sum(row["Triangles"] for row in costs)
    # The slowest rank of each step, the median of the runs.
    seconds = [
        statistics.median(max(row[name] for row in run) for _, run in runs) for name in SECONDS
    ]
    wall = statistics.median(seconds for seconds, _ in runs)
    links = [8 * find_link_bytes(costs) / (rate * 1e6) for rate in LINKS]
    steps = " | ".join(f"{value:.3f}" for value in seconds)
    linked = " | ".join(f"{value:.3f}" for value in links)
    print(
        f"| {mode} | {raw / 1e6:.2f} | {encoded / 1e6:.2f} | {sent / 1e6:.3f} "
        f"| {raw / encoded:.1f} | {8 * encoded / triangles:.1f} | {steps} | {wall:.3f} | {linked} |"
    )


def compare_modes(contour, surface, isovalues, repeats, folder):
    """Sends each surface in each way, by turns; prints a table."""
    contour.Level = 0
    for isovalue in isovalues:
        contour.Isosurfaces = [isovalue]
        runs = {mode: [] for mode in MODES}
        for _ in range(repeats + 1):
            for mode in MODES:
                runs[mode].append(measure(contour, surface, mode, folder))
        costs = runs["Lossless"][-1][1]
        triangles = [int(row["Triangles"]) for row in costs]
        points = [int(row["ExtractedPoints"]) for row in costs]
        print(
            f"\nIsovalue {isovalue:g}: {sum(triangles)} triangles; on each of {len(costs)} ranks "
            f"{min(triangles)} to {max(triangles)}; points before {min(points)} to {max(points)}\n"
        )
        print(
            "| mode | raw MB | encoded MB | sent MB | raw / encoded | bits a triangle "
            "| query s | encode s | choose s | exchange s | decode s | all s "
            + "".join(f"| s at {rate} Mb/s per link " for rate in LINKS)
            + "|"
        )
        print("|---" * (12 + len(LINKS)) + "|")
        for mode in MODES:
            # The first turn also reads the blocks.
            print_row(mode, runs[mode][1:] or runs[mode])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--output", default=".", help="folder to write into")
    parser.add_argument("--volume", help="a blocked volume; default: a head MRI")
    parser.add_argument("--array", default="T1", help="the point array to contour")
    parser.add_argument("--block-size", type=int, default=32, help="of the head MRI's blocks")
    parser.add_argument("--isovalues", type=float, nargs="+", default=[40.5, 80.5])
    parser.add_argument("--repeats", type=int, default=1, help="turns of each mode after a first one")
    parser.add_argument("--without-images", action="store_true")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))

    path = arguments.volume or write_head(arguments.output, arguments.block_size)
    reader = simple.OpenDataFile(path)
    contour = simple.Isosurface(Input=reader, ContourBy=["POINTS", arguments.array])
    surface = simple.DistributeIsosurface(Input=contour)
    if not arguments.without_images:
        show_frames(contour, surface, arguments.isovalues, arguments.output)
    compare_modes(contour, surface, arguments.isovalues, arguments.repeats, arguments.output)


main()
