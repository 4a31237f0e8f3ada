# SPDX-License-Identifier: BSD-3-Clause
"""How an isovalue slider feels on a large blocked volume: seconds, bytes and cache hits.

    pvpython interactive_study.py --plugin .../ScalableIsosurface.so --volume VOLUME.bvol
        [--study cold slider budgets] [--cache MIB] [--most-triangles N] [--drop-caches]

cold     surfaces from --most-triangles down to a tenth of it, each by a fresh reader; with
         --drop-caches (as root, Linux) from a disk of which nothing is in memory
slider   50 isovalues, there and back in steps of 1/400 of the range
budgets  TimeBudget of 0.1, 0.3 and 1 s at 10 isovalues each: the seconds that it took

Tables of Markdown on standard output. The seconds are those of the contour's update in ParaView's
pipeline, the finished vtkPolyData included.
"""
import argparse
import resource
import statistics
import sys
import time

from paraview import simple
from paraview.servermanager import Fetch


def print_row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def print_header(*names):
    print()
    print_row(*names)
    print_row(*["---"] * len(names))


def drop_caches(arguments):
    if arguments.drop_caches:
        with open("/proc/sys/vm/drop_caches", "w") as file:
            file.write("3")


class Volume:
    """The blocked volume, opened, and the spectrum of the array that is contoured."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.open()
        information = self.reader.GetPointDataInformation()
        self.array = arguments.array or information.GetArray(0).Name
        spectrum = simple.ContourSpectrum(Input=self.reader, ContourBy=["POINTS", self.array])
        table = Fetch(spectrum)
        columns = {table.GetColumnName(n): table.GetColumn(n) for n in range(table.GetNumberOfColumns())}
        self.isovalues, self.triangles, self.bytes = (
            [columns[name].GetValue(row) for row in range(table.GetNumberOfRows())]
            for name in ("Isovalue", "Triangles", "Bytes")
        )
        simple.Delete(spectrum)

    def open(self):
        """A reader with nothing in the cache, which it shares with all that were before."""
        self.reader = simple.BlockedVolumeReader(FileName=self.arguments.volume, CacheSize=1)
        self.reader.UpdatePipelineInformation()
        self.reader.CacheSize = self.arguments.cache
        self.reader.UpdatePipelineInformation()

    def close(self):
        simple.Delete(self.reader)

    def make_contour(self, **properties):
        return simple.Isosurface(
            Input=self.reader, ContourBy=["POINTS", self.array], **properties
        )

    def find_isovalues(self, count, most, least):
        """Isovalues above the fullest one, with `most` to `least` triangles, equally far apart."""
        rows = range(self.triangles.index(max(self.triangles)), len(self.triangles))
        fitting = [row for row in rows if least <= self.triangles[row] <= most]
        if not fitting:
            sys.exit(f"no isovalue has {least} to {most} triangles")
        picked = [fitting[(len(fitting) - 1) * n // max(1, count - 1)] for n in range(count)]
        return [self.isovalues[row] for row in picked]

    def find_bytes(self, isovalue):
        return self.bytes[self.isovalues.index(isovalue)]


def update(contour):
    """Seconds of an update, and what the field data tell."""
    start = time.time()
    contour.UpdatePipeline()
    seconds = time.time() - start
    fields = contour.GetDataInformation().DataInformation.GetFieldDataInformation()
    cost = {
        name: fields.GetArrayInformation(name).GetComponentRange(0)[0]
        for name in ("Level", "Triangles", "ActiveBlocks", "BlocksRead", "BytesRead", "BlockCacheHits")
    }
    return seconds, cost


def study_cold(volume):
    most = volume.arguments.most_triangles
    print_header("isovalue", "triangles", "active blocks", "s", "M triangles/s", "MB read",
                 "read / active bytes", "peak MiB")
    for isovalue in volume.find_isovalues(6, most, most // 10):
        volume.close()
        volume.open()
        drop_caches(volume.arguments)
        contour = volume.make_contour(Isosurfaces=[isovalue])
        seconds, cost = update(contour)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print_row(f"{isovalue:g}", f"{cost['Triangles']:,.0f}", f"{cost['ActiveBlocks']:,.0f}",
                  f"{seconds:.2f}", f"{cost['Triangles'] / seconds / 1e6:.1f}",
                  f"{cost['BytesRead'] / 1e6:.0f}",
                  f"{cost['BytesRead'] / volume.find_bytes(isovalue):.3f}", f"{peak:.0f}")
        simple.Delete(contour)


def study_slider(volume):
    """The slider goes down 25 steps, ever new blocks, and comes back half a step beside them."""
    step = (volume.isovalues[-1] - volume.isovalues[0]) / 400
    print_header("from", "to", "triangles, median", "s: first", "median", "worst", "blocks from the cache")
    most = volume.arguments.most_triangles
    for begin in volume.find_isovalues(3, most // 2, most // 20):
        volume.close()
        volume.open()
        drop_caches(volume.arguments)
        contour = volume.make_contour()
        down = [begin + step * (12 - n) for n in range(25)]
        seconds, costs = [], []
        for isovalue in down + [isovalue + step / 2 for isovalue in reversed(down)]:
            contour.Isosurfaces = [isovalue]
            one, cost = update(contour)
            seconds.append(one)
            costs.append(cost)
        hits = sum(cost["BlockCacheHits"] for cost in costs[1:])
        reads = sum(cost["BlocksRead"] for cost in costs[1:])
        print_row(f"{down[0]:g}", f"{down[-1]:g}",
                  f"{statistics.median(cost['Triangles'] for cost in costs):,.0f}",
                  f"{seconds[0]:.2f}", f"{statistics.median(seconds[1:]):.3f}",
                  f"{max(seconds[1:]):.3f}", f"{100 * hits / max(1, hits + reads):.0f} %")
        simple.Delete(contour)


def study_budgets(volume):
    isovalues = volume.find_isovalues(10, max(volume.triangles), 1000)
    contour = volume.make_contour()
    print_header("budget, s", "levels", "s: least", "median", "most", "within 1.2 x the budget")
    for budget in (0.1, 0.3, 1):
        contour.TimeBudget = budget
        results = []
        for isovalue in isovalues:
            contour.Isosurfaces = [isovalue]
            results.append(update(contour))
        seconds = [one for one, _ in results]
        levels = " ".join(f"{cost['Level']:.0f}" for _, cost in results)
        kept = sum(one <= 1.2 * budget for one in seconds)
        print_row(f"{budget:g}", levels, f"{min(seconds):.3f}", f"{statistics.median(seconds):.3f}",
                  f"{max(seconds):.3f}", f"{kept} of {len(seconds)}")
    simple.Delete(contour)


STUDIES = {"cold": study_cold, "slider": study_slider, "budgets": study_budgets}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--plugin", help="path of ScalableIsosurface.so, unless loaded already")
    parser.add_argument("--volume", required=True, help="a blocked volume")
    parser.add_argument("--array", help="the point array to contour; else the first one")
    parser.add_argument("--study", nargs="+", choices=STUDIES, default=list(STUDIES))
    parser.add_argument("--cache", type=int, default=512, help="MiB of decoded blocks kept")
    parser.add_argument("--most-triangles", type=int, default=20000000)
    parser.add_argument("--drop-caches", action="store_true",
                        help="the system forgets all files before each cold surface; as root")
    arguments = parser.parse_args()
    if arguments.plugin:
        simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))
    volume = Volume(arguments)
    for study in arguments.study:
        STUDIES[study](volume)


main()
