# SPDX-License-Identifier: BSD-3-Clause
"""From a new isovalue to the picture: Isosurface beside ParaView's Contour, in one run.

    pvpython first_picture.py --plugin ScalableIsosurface.so [--volume FILE --array NAME]
        [--isovalues V V ...] [--size 1280 800] [--view RenderView] [--ours-only]
        [--processor-time]

FILE is what ParaView opens: .vti, .bvol ...; without it a volume is generated. For each isovalue but
the first one, which warms up, it times:

    surface      the filter's update
    first        the first picture of the new surface
    again        the same picture once more
    first drag   the first frame while the camera moves
    second drag  the one after it

and prints the median of each, with what counts: first / (surface + again) is what it takes to bring a
surface to the screen, beside drawing it; first drag / second drag what its level of detail takes.
Run it where nothing else runs. Where that cannot be, --processor-time counts the seconds of all threads of
this process instead of those of the clock, and a first run tells how far they are from each other.
"""
import argparse
import statistics
import time

from paraview import simple

PHASES = ("surface", "first", "again", "first drag", "second drag")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--volume")
    parser.add_argument("--array")
    parser.add_argument("--isovalues", type=float, nargs="+", default=[130.0, 131.0, 132.0, 133.0])
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 800])
    parser.add_argument("--view", default="RenderView")
    parser.add_argument("--ours-only", action="store_true", help="for volumes larger than memory")
    parser.add_argument("--processor-time", action="store_true", help="where other programs run")
    return parser.parse_args()


def open_volume(arguments):
    if arguments.volume:
        source = simple.OpenDataFile(arguments.volume)
    else:
        source = simple.Wavelet(WholeExtent=[-128, 127, -128, 127, -128, 127])
    source.UpdatePipeline()
    arrays = source.PointData.keys()
    return source, arguments.array or list(arrays)[0]


def measure(kind, source, array, arguments):
    """By phase the seconds for each isovalue but the first, and the triangles of the last one."""
    contour = getattr(simple, kind)(Input=source)
    contour.ContourBy = ["POINTS", array]
    contour.Isosurfaces = arguments.isovalues[:1]
    view = simple.CreateView(arguments.view)
    view.ViewSize = arguments.size
    simple.Show(contour, view)
    simple.ResetCamera(view)
    simple.Render(view)
    seconds = {phase: [] for phase in PHASES}
    clock = time.process_time if arguments.processor_time else time.perf_counter

    def run(phase, step):
        begin = clock()
        step()
        window = view.GetRenderWindow()
        if window:
            window.WaitForCompletion()
        seconds[phase].append(clock() - begin)

    for isovalue in arguments.isovalues[1:]:
        contour.Isosurfaces = [isovalue]
        run("surface", contour.UpdatePipeline)
        run("first", lambda: simple.Render(view))
        run("again", lambda: simple.Render(view))
        run("first drag", view.SMProxy.InteractiveRender)
        run("second drag", view.SMProxy.InteractiveRender)
    triangles = contour.GetDataInformation().GetNumberOfCells()
    simple.Delete(view)
    simple.Delete(contour)
    return seconds, triangles


def report(kind, seconds, triangles):
    median = {phase: statistics.median(values) for phase, values in seconds.items()}
    line = "  ".join(f"{phase} {median[phase]:.3f} s" for phase in PHASES)
    print(f"{kind}: {triangles:,} triangles; {line}")
    total = median["surface"] + median["first"]
    shown = total / (median["surface"] + median["again"])
    drag = median["first drag"] / median["second drag"]
    print(f"  new isovalue to picture {total:.3f} s, {shown:.2f} x (surface + again); "
          f"first / second frame of a drag {drag:.2f}", flush=True)
    return total


def main():
    arguments = parse_arguments()
    simple.LoadPlugin(arguments.plugin, remote=True, ns=vars(simple))
    source, array = open_volume(arguments)
    totals = {}
    for kind in ("Isosurface",) if arguments.ours_only else ("Contour", "Isosurface"):
        totals[kind] = report(kind, *measure(kind, source, array, arguments))
    if len(totals) == 2:
        ratio = totals["Contour"] / totals["Isosurface"]
        print(f"new isovalue to picture: {ratio:.1f} times as fast as Contour")


main()
