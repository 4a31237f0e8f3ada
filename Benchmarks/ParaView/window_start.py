#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the plugin adds to the start of ParaView's window.

    xvfb-run -a python3 window_start.py [--rounds N] .../ScalableIsosurface.so...

Starts and ends the window without the plugin and with each of these builds of it, in turns. Prints the
medians, in seconds of the clock and of processor time.
"""
import argparse
import os
import resource
import statistics
import subprocess
import tempfile
import time


def start(plugin, script):
    """Seconds and processor seconds of a window that ends as soon as it has started."""
    options = []
    if plugin:
        options = [f"--plugin-search-paths={os.path.dirname(plugin)}", "--plugins=ScalableIsosurface"]
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.monotonic()
    subprocess.run(
        ["paraview", "--dr", *options, f"--test-script={script}", "--exit"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=True,
    )
    seconds = time.monotonic() - began
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("plugins", nargs="+")
    arguments = parser.parse_args()

    plugins = [None, *map(os.path.abspath, arguments.plugins)]
    times = {plugin: [] for plugin in plugins}
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as script:
        script.write('<?xml version="1.0" ?>\n<pqevents></pqevents>\n')
        script.flush()
        start(None, script.name)  # reads the libraries from the disk
        for _ in range(arguments.rounds):
            for plugin in plugins:
                times[plugin].append(start(plugin, script.name))
    for plugin, measured in times.items():
        seconds, processor = (statistics.median(values) for values in zip(*measured))
        print(f"{seconds:5.2f} s, {processor:5.2f} s of processor time: {plugin or 'without the plugin'}")


if __name__ == "__main__":
    main()
