# SPDX-License-Identifier: BSD-3-Clause
"""The window shows a sample of a file, and then all of it, with the plugin in one file of Python; what is saved while a
coarse surface is shown is the exact one: one_file_window.py.

    one_file_first_contact.py --plugins CXX PYTHON --volumes FOLDER --output FOLDER -- PARAVIEW...
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

from one_file import SITE

parser = argparse.ArgumentParser()
parser.add_argument("program", nargs="+")
parser.add_argument("--plugins", nargs=2, required=True)
parser.add_argument("--volumes", required=True)
parser.add_argument("--output", required=True)
arguments = parser.parse_args()
shutil.rmtree(arguments.output, ignore_errors=True)
volume = os.path.join(arguments.output, "large.zarr")
shutil.copytree(os.path.join(arguments.volumes, "large.zarr"), volume)
with open(os.path.join(arguments.output, "sitecustomize.py"), "w") as file:
    file.write(SITE)
script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "one_file_window.py")
environment = {**os.environ, "PYTHONPATH": arguments.output, "ONE_FILE_PLUGIN": arguments.plugins[1],
               "ONE_FILE_VOLUME": volume, "ONE_FILE_OUTPUT": arguments.output}
done = subprocess.run([*arguments.program, "--dr", "--script=" + script], capture_output=True, text=True, env=environment)
print(done.stdout, done.stderr)
with open(os.path.join(arguments.output, "shown.json")) as file:
    shown = json.load(file)
assert done.returncode == 0 and "Traceback" not in done.stderr
assert shown[0]["index"] == "is being written" and "samples" in shown[0]["shown"], shown[0]
assert shown[-1] == {"index": "up to date", "shown": "all of it, 161 x 131 x 111", "triangles": 286604, "final": 1}
with open(os.path.join(arguments.output, "saving.json")) as file:
    saving = json.load(file)
print(saving)
assert saving["final"] == 0 and 0 < saving["coarse"] < saving["saved"] == saving["shown"], saving
sys.exit(0)
