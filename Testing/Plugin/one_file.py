# SPDX-License-Identifier: BSD-3-Clause
"""The plugin in one file of Python makes what the plugin in C++ makes, bit for bit: one_file_job.py is run with each.

    one_file.py --plugins CXX PYTHON --volumes FOLDER --output FOLDER -- PVBATCH...

Where CXX is a file of JSON, the plugin in C++ has run on another system: `--plugins CXX --save FILE` has written it.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from time_limits import WAIT_SECONDS  # noqa: E402  (found in the folder above)


#: On each rank: ParaView 5.11 in Python 3.11 cannot load plugins of Python without it.
SITE = """import inspect
inspect.getargspec = inspect.getfullargspec
"""


def run(program, plugin, volumes, output):
    """The lines of the jobs, by their names."""
    if plugin.endswith(".json"):
        with open(plugin) as file:
            return json.load(file)
    shutil.rmtree(output, ignore_errors=True)
    os.makedirs(output)
    with open(os.path.join(output, "sitecustomize.py"), "w") as file:
        file.write(SITE)
    environment = {**os.environ, "PYTHONPATH": output, "SCALABLE_ISOSURFACE_CACHE": os.path.join(output, "cache")}
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "one_file_job.py")
    server = [sys.executable, "-B", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "Python", "address_server.py")]
    with subprocess.Popen([*server, volumes], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as serving:
        environment["ISOSURFACE_TEST_ADDRESS"] = serving.stdout.readline().strip()
        done = subprocess.run([*program, script, plugin, volumes, output], capture_output=True, text=True,
                              timeout=10 * WAIT_SECONDS, env=environment)
        serving.stdin.close()
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or "ERR" in done.stderr or "Traceback" in done.stderr:
        sys.exit(f"{plugin}: {len(lines)} jobs, exit code {done.returncode}\n{done.stderr[-5000:]}")
    return {line.pop("job"): line for line in lines}


def find_kind_of_surfaces(jobs):
    """Of VTK's versions: the width of corners, and the last bits of normals, are those of the contour filters there."""
    version = jobs.get("VTK", {"version": 902})["version"]
    return (version >= 902) + (version >= 904)


def leave_out(found, names):
    """Drops members at any depth."""
    for one in found.values() if isinstance(found, dict) else found if isinstance(found, list) else ():
        leave_out(one, names)
    for name in names if isinstance(found, dict) else ():
        found.pop(name, None)


def is_same(expected, found):
    """Sizes of files may differ by the few bytes that another release of zstd packs more."""
    expected, found = dict(expected), dict(found)
    sizes = [job.pop("size", 0) for job in (expected, found)]
    return expected == found and abs(sizes[0] - sizes[1]) <= sizes[0] / 1000


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="+")
    parser.add_argument("--plugins", nargs="+", required=True)
    parser.add_argument("--volumes", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--save", metavar="FILE", help="gets what the plugin in C++ makes")
    arguments = parser.parse_args()
    expected, *others = (
        run(arguments.program, plugin, arguments.volumes, os.path.join(arguments.output, name))
        for plugin, name in zip(arguments.plugins, ("cxx", "python"))
    )
    if arguments.save:
        with open(arguments.save, "w") as file:
            json.dump(expected, file)
    found = others[0] if others else expected
    if arguments.plugins[0].endswith(".json") and find_kind_of_surfaces(expected) != find_kind_of_surfaces(found):
        leave_out([expected, found], ("Normals", "polygons", "lines"))
    if arguments.plugins[0].endswith(".json") and expected["VTK"] != found.get("VTK"):
        for jobs in (expected, found):
            jobs.pop("refined images in memory", None)  # stock's source makes others in each release
    if found.get("VTK", {}).get("version") == 900:  # ParaView 5.9 keeps the base proxy's property
        for jobs in (expected, found):
            jobs.get("properties of AddressVolume (sources)", {"found": {}})["found"].pop("FileName", None)
    for jobs in (expected, found):
        jobs.pop("VTK", None)
    different = [job for job in expected if not is_same(expected[job], found.get(job, {}))]
    for job in different:
        print(f"{job}:\n    {json.dumps(expected[job])}\n    {json.dumps(found.get(job))}")
    assert len(expected) > 30 and sorted(expected) == sorted(found)
    sys.exit(len(different))


if __name__ == "__main__":
    main()
