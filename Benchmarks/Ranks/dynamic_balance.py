# SPDX-License-Identifier: BSD-3-Clause
"""Seconds of a query on ranks of which one is slow, with fixed shares and with dynamic ones.

    mpirun -n 4 pvbatch --sym dynamic_balance.py VOLUME.bvol --plugin .../ScalableIsosurface.so
        [--isovalues V ...] [--repeats N] [--processor SHARE] [--slowness N] [--cache MEBIBYTES] [--stops]

Each rank gets a share of a processor (0.4), by a cgroup of its own (version 1, controller cpu; as root),
without a block cache (0). Then the last rank gets one N-th (4) of that. With --stops there are no such
shares: the last rank is stopped and continued, every 10 ms, so that it runs for one N-th of the time; not
more ranks than processors then. Fixed and dynamic shares take turns; the figures are medians of the time from
one barrier to the next, of all repeats but the first.

The ideal time with a slow rank: the best time without one, times the ranks, by the sum of speeds, that of a
whole rank being 1. Prints that, both times beside it, and how many blocks each rank had.
"""
import argparse
import multiprocessing
import os
import signal
import statistics
import time

from paraview import simple
from vtkmodules.vtkParallelCore import vtkMultiProcessController

CGROUPS = "/sys/fs/cgroup/cpu"
PERIOD = 10_000  # microseconds


class ProcessorShare:
    """A cgroup with this process alone."""

    def __init__(self, rank):
        self.folder = os.path.join(CGROUPS, f"isosurface-{os.getppid()}-{rank}")
        os.makedirs(self.folder, exist_ok=True)
        self.write("cpu.cfs_period_us", PERIOD)
        self.write("cpu.shares", 100 * 1024)  # other work on the machine must not matter
        with open(os.path.join(self.folder, "cgroup.procs"), "w") as file:
            file.write(str(os.getpid()))

    def write(self, name, value):
        with open(os.path.join(self.folder, name), "w") as file:
            file.write(str(value))

    def limit(self, share):
        self.write("cpu.cfs_quota_us", int(share * PERIOD))

    def close(self):
        self.write("cpu.cfs_quota_us", -1)
        with open(os.path.join(CGROUPS, "cgroup.procs"), "w") as file:
            file.write(str(os.getpid()))
        os.rmdir(self.folder)


def interrupt(process, runs):
    """Lets a process run for a share of each 10 ms, for ever."""
    while True:
        os.kill(process, signal.SIGSTOP)
        time.sleep(0.01 * (1 - runs.value))
        os.kill(process, signal.SIGCONT)
        time.sleep(0.01 * runs.value)


class Interruptions:
    """In place of a ProcessorShare: nothing at first, then stops."""

    def __init__(self):
        self.runs = multiprocessing.Value("d", 1)
        self.other = multiprocessing.Process(target=interrupt, args=(os.getpid(), self.runs), daemon=True)

    def limit(self, share):
        self.runs.value = share
        if share < 1 and not self.other.is_alive():
            self.other.start()

    def close(self):
        if self.other.is_alive():
            self.other.kill()  # ParaView would report a signal that can be caught
            self.other.join()
            os.kill(os.getpid(), signal.SIGCONT)


def measure(controller, contour, isovalues, is_dynamic):
    """Seconds until all ranks have the surface, and this rank's blocks."""
    contour.DynamicBalance = int(is_dynamic)
    # A change on all ranks, so that the filter is executed again.
    contour.Isosurfaces = [isovalues[0] + 1]
    contour.Isosurfaces = isovalues
    controller.Barrier()
    begin = time.perf_counter()
    contour.UpdatePipeline()
    controller.Barrier()
    seconds = time.perf_counter() - begin
    output = contour.GetClientSideObject().GetOutputDataObject(0)
    return seconds, int(output.GetFieldData().GetArray("ActiveBlocks").GetTuple1(0))


def compare(controller, contour, arguments):
    """Medians of the seconds with fixed and with dynamic shares, and the last blocks of this rank."""
    seconds = {False: [], True: []}
    blocks = {}
    for _ in range(1 + arguments.repeats):
        for is_dynamic in (False, True):
            one, blocks[is_dynamic] = measure(controller, contour, arguments.isovalues, is_dynamic)
            seconds[is_dynamic].append(one)
    return {way: statistics.median(all[1:]) for way, all in seconds.items()}, blocks


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume")
    parser.add_argument("--plugin", required=True)
    parser.add_argument("--isovalues", type=float, nargs="+", default=[40.5])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--processor", type=float, default=0.4)
    parser.add_argument("--slowness", type=float, default=4)
    parser.add_argument("--cache", type=int, default=0)
    parser.add_argument("--stops", action="store_true")
    arguments = parser.parse_args()
    simple.LoadPlugin(arguments.plugin, remote=False, ns=vars(simple))
    controller = vtkMultiProcessController.GetGlobalController()
    rank, ranks = controller.GetLocalProcessId(), controller.GetNumberOfProcesses()
    reader = simple.BlockedVolumeReader(FileName=arguments.volume, CacheSize=arguments.cache)
    contour = simple.Isosurface(Input=reader)
    share = Interruptions() if arguments.stops else ProcessorShare(rank)
    whole = 1 if arguments.stops else arguments.processor
    try:
        share.limit(whole)
        even, even_blocks = compare(controller, contour, arguments)
        share.limit(whole / (arguments.slowness if rank == ranks - 1 else 1))
        slow, slow_blocks = compare(controller, contour, arguments)
    finally:
        share.close()
    ideal = min(even.values()) * ranks / (ranks - 1 + 1 / arguments.slowness)
    print(f"rank {rank}: blocks, equally fast, {even_blocks[False]} fixed, {even_blocks[True]} dynamic; "
          f"last one slow, {slow_blocks[False]} fixed, {slow_blocks[True]} dynamic", flush=True)
    controller.Barrier()
    if rank == 0:
        print(f"equally fast: {even[False]:.3f} s fixed, {even[True]:.3f} s dynamic")
        print(f"one rank slow: {slow[False]:.3f} s fixed, {slow[True]:.3f} s dynamic, {ideal:.3f} s ideal")
        print(f"by the ideal: {slow[False] / ideal:.2f} fixed, {slow[True] / ideal:.2f} dynamic", flush=True)


main()
