# SPDX-License-Identifier: BSD-3-Clause
"""What the plugin in one file of Python says where something is wrong: one line, and no traceback.

    one_file_errors.py --plugins CXX PYTHON --volumes FOLDER --output FOLDER --library FILE -- PVBATCH...
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from one_file import SITE

arguments = None

#: Run by pvbatch: each line of its input names a script, which a copy of the process runs. Nothing is loaded twice.
SESSION = """import os, sys, traceback
from paraview import simple
for script in map(str.rstrip, iter(sys.stdin.readline, "")):
    child = os.fork()
    if child == 0:
        for descriptor, kind in (1, ".out"), (2, ".err"):
            os.dup2(os.open(script + kind, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), descriptor)
        try:
            exec(open(script).read(), {})
        except Exception:
            traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)
    print(os.waitpid(child, 0)[1], flush=True)
"""


def start(site):
    """pvbatch with the session above."""
    script = os.path.join(arguments.output, "session.py")
    with open(script, "w") as file:
        file.write(SESSION)
    return subprocess.Popen([*arguments.program, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                            env={**os.environ, "PYTHONPATH": site})


def run(lines, session=None):
    """What a session of pvbatch says of a script, its lines without ParaView's own decoration."""
    session = session or arguments.session
    script = os.path.join(arguments.output, "script.py")
    with open(script, "w") as file:
        file.write("import sys\nfrom paraview import simple\n" + "\n".join(lines) + "\nprint('the end')\n")
    session.stdin.write(script + "\n")
    session.stdin.flush()
    assert session.stdout.readline() == "0\n"
    said = "".join(pathlib.Path(script + kind).read_text() for kind in (".err", ".out"))
    return [line for line in re.sub(r"\x1b\[[0-9;]*m", "", said).splitlines() if line.strip()]


def load(path):
    return f"simple.LoadPlugin({path!r}, remote=True, ns=vars(simple))"


class Errors(unittest.TestCase):
    def copy(self, name, library=None):
        """A copy of the plugin and its package, with a library of its own."""
        folder = os.path.join(arguments.output, name)
        beside = os.path.dirname(arguments.plugins[1])
        package = os.path.join(folder, "scalable_isosurface")
        shutil.copytree(os.path.join(beside, "scalable_isosurface"), package,
                        ignore=shutil.ignore_patterns("*.so", "*.pyi", "__pycache__"))
        shutil.copy(arguments.plugins[1], folder)
        shutil.copy(library or arguments.library, os.path.join(package, "libscalable_isosurface.so.1"))
        return os.path.join(folder, "ScalableIsosurface.py")

    def check(self, said, *words):
        """One line has the words, and there is no other but the end."""
        self.assertEqual(len(said), 2, "\n".join(said))
        for word in words:
            self.assertIn(word, said[0])
        self.assertEqual(said[1], "the end")

    def test_another_folder_works(self):
        said = run([load(self.copy("whole")), "print(simple.Isosurface is not None)"])
        self.assertEqual(said, ["True", "the end"])

    def test_a_library_of_another_version_is_refused(self):
        plugin = self.copy("version")
        path = os.path.join(os.path.dirname(plugin), "scalable_isosurface", "__init__.py")
        with open(path) as file:
            text = file.read()
        with open(path, "w") as file:
            file.write(re.sub(r'__version__ = "[0-9.]+"', '__version__ = "7.8.9"', text))
        self.check(run([load(plugin)]), "is not loaded", "libscalable_isosurface.so.1", "7.8.9")

    def test_a_damaged_library_is_refused(self):
        plugin = self.copy("damaged")
        with open(os.path.join(os.path.dirname(plugin), "scalable_isosurface", "libscalable_isosurface.so.1"), "r+b") as file:
            file.truncate(100000)
        self.check(run([load(plugin)]), "is not loaded", "damaged")

    def test_a_missing_library_is_told(self):
        plugin = self.copy("no_library")
        os.remove(os.path.join(os.path.dirname(plugin), "scalable_isosurface", "libscalable_isosurface.so.1"))
        self.check(run([load(plugin)]), "is not loaded", "libscalable_isosurface.so", "No such file")

    def test_a_library_for_another_processor_is_told(self):
        plugin = self.copy("processor")
        with open(os.path.join(os.path.dirname(plugin), "scalable_isosurface", "libscalable_isosurface.so.1"), "r+b") as file:
            file.seek(18)  # of the header of an ELF: what it is for
            file.write((183).to_bytes(2, "little"))
        self.check(run([load(plugin)]), "is not loaded", "aarch64", "x86_64")

    def test_a_paraview_that_is_too_old_is_told(self):
        plugin = self.copy("old")
        with open(plugin) as file:
            text = file.read()
        with open(plugin, "w") as file:
            file.write(text.replace("GetVTKMajorVersion() < 9:", "GetVTKMajorVersion() < 99:"))
        self.check(run([load(plugin)]), "is not loaded", "needs ParaView 5.9 or newer")

    def test_nothing_of_before_is_shown_behind_an_error(self):
        said = run([load(arguments.plugins[1]), "surface = simple.Isosurface(Input=simple.Wavelet(), Isosurfaces=[150.0])",
                    "surface.UpdatePipeline()", "surface.ContourBy = ['POINTS', 'Density']", "surface.UpdatePipeline()",
                    "print(surface.GetDataInformation().GetNumberOfPoints())"])
        self.assertEqual(said[1:], ["0", "the end"], "\n".join(said))
        self.assertIn('"Density" to contour', said[0])

    def test_a_missing_package_is_told(self):
        plugin = self.copy("missing")
        shutil.rmtree(os.path.join(os.path.dirname(plugin), "scalable_isosurface"))
        self.check(run([load(plugin)]), "is not loaded", "scalable_isosurface")

    def test_a_missing_document_of_proxies_is_told(self):
        plugin = self.copy("no_xml")
        os.remove(os.path.join(os.path.dirname(plugin), "scalable_isosurface", "ScalableIsosurface.xml"))
        self.check(run([load(plugin)]), "is not loaded", "ScalableIsosurface.xml")

    def test_missing_numpy_is_told(self):
        hidden = os.path.join(arguments.output, "hidden")
        os.makedirs(hidden)
        with open(os.path.join(hidden, "sitecustomize.py"), "w") as file:
            file.write(SITE + "import sys\nsys.modules['numpy'] = None\n")
        with start(hidden) as session:
            said = run([load(self.copy("bare"))], session)
            session.stdin.close()
        self.check([line for line in said if "ScalableIsosurface" in line or line == "the end"], "NumPy")

    def test_the_plugin_in_cxx_that_is_loaded_first_wins(self):
        cxx, python = arguments.plugins
        self.check(run([load(cxx), load(python)]), python, cxx, "is loaded already")

    def test_the_plugin_in_cxx_that_is_loaded_second_is_told(self):
        cxx, python = arguments.plugins
        self.check(run([load(python), load(cxx)]), python, "is loaded already", "the plugin in C++ is used")

    def test_damaged_files_are_told_in_one_line(self):
        path = os.path.join(arguments.output, "damaged.bvol")
        with open(path, "w") as file:
            file.write('{"format": "ScalableIsosurface blocked volume", ')
        said = run([load(arguments.plugins[1]), f"reader = simple.BlockedVolumeReader(FileName=[{path!r}])",
                    "surface = simple.Isosurface(Input=reader, Isosurfaces=[1.0])", "surface.UpdatePipeline()"])
        self.check(said, path)

    def test_what_it_cannot_contour_is_told_by_name(self):
        said = run([load(arguments.plugins[1]), "tetrahedra = simple.Tetrahedralize(Input=simple.Wavelet())",
                    "surface = simple.Isosurface(Input=tetrahedra, Isosurfaces=[100.0])", "surface.UpdatePipeline()"])
        self.check(said, "the input has a vtkUnstructuredGrid")

    def test_what_images_do_not_have_here_is_told(self):
        path = os.path.join(arguments.output, "image.eix")
        said = run([load(arguments.plugins[1]), "surface = simple.Isosurface(Input=simple.Wavelet(), Isosurfaces=[150.0])",
                    "surface.UpdatePipeline()", f"simple.SaveData({path!r}, proxy=surface)",
                    "simple.ContourSpectrum(Input=simple.Wavelet()).UpdatePipeline()"])
        self.assertEqual(len(said), 3, "\n".join(said))
        self.assertIn("the plugin in C++ alone writes", said[0])
        self.assertIn("use the plugin in C++", said[1])

    def test_an_array_that_is_missing_is_told_with_those_that_are_there(self):
        said = run([load(arguments.plugins[1]), "cells = simple.PointDatatoCellData(Input=simple.Wavelet())",
                    "surface = simple.Isosurface(Input=cells, Isosurfaces=[100.0], ContourBy=['POINTS', 'Density'])",
                    "surface.UpdatePipeline()"])
        self.check(said, 'no point array "Density" to contour', 'cell arrays "RTData"')


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="+")
    parser.add_argument("--plugins", nargs=2, required=True)
    parser.add_argument("--volumes", required=True)
    parser.add_argument("--output", required=True)
    parser.add_argument("--library", required=True)
    arguments = parser.parse_args()
    shutil.rmtree(arguments.output, ignore_errors=True)
    arguments.site = os.path.join(arguments.output, "site")
    os.makedirs(arguments.site)
    with open(os.path.join(arguments.site, "sitecustomize.py"), "w") as file:
        file.write(SITE)
    with start(arguments.site) as arguments.session:
        done = unittest.main(argv=sys.argv[:1], exit=False)
        arguments.session.stdin.close()
    sys.exit(not done.result.wasSuccessful())
