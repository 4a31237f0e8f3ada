# SPDX-License-Identifier: BSD-3-Clause
"""What of the plugin in one file of Python is deleted is freed: volumes, surfaces, and all else that the library gave.

    one_file_memory.py --plugins CXX PYTHON --volumes FOLDER
"""
import argparse
import gc
import inspect
import os

inspect.getargspec = inspect.getfullargspec  # for ParaView 5.11 in Python 3.11

from paraview import simple  # noqa: E402

ROUNDS = 20
#: What VTK frees of a deleted object when it makes the next one.
LATE = 5

parser = argparse.ArgumentParser()
parser.add_argument("--plugins", nargs=2, required=True)
parser.add_argument("--volumes", required=True)
arguments = parser.parse_args()
simple.LoadPlugin(arguments.plugins[1], remote=True, ns=vars(simple))
from scalable_isosurface import _library  # noqa: E402  (the plugin has found it)


def count_handles():
    gc.collect()
    return sum(isinstance(one, _library._Owned) for one in gc.get_objects())


def find_memory():
    """Of this process, in MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1000000


def make_and_delete():
    volume = simple.OpenDataFile(os.path.join(arguments.volumes, "wave.bvol"))
    surfaces = simple.OpenDataFile(os.path.join(arguments.volumes, "wave.eix"))
    made = [
        volume,
        surfaces,
        simple.Isosurface(Input=volume, Isosurfaces=[150.0]),
        simple.VolumeSlice(Input=volume),
        simple.VolumeRegion(Input=volume),
        simple.ContourSpectrum(Input=volume),
        simple.VolumeProbe(Input=volume, Source=simple.Sphere()),
    ]
    for one in made:
        one.UpdatePipeline()
    missing = simple.BlockedVolumeReader(FileName=["missing.bvol"])
    missing.UpdatePipeline()
    for one in reversed([missing, *made]):
        simple.Delete(one)
    return count_handles()


make_and_delete()
counts, memory = [], find_memory()
for _ in range(ROUNDS):
    counts.append(make_and_delete())
grown = find_memory() - memory
print(f"handles {counts}, {grown} MB more")
assert max(counts) <= LATE and grown < 50
