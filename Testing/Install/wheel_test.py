# SPDX-License-Identifier: BSD-3-Clause
"""The wheel of a build folder: what is packed, and what a damaged or foreign installation says.

    wheel_test.py BUILD PROJECT
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

BUILD, PROJECT = map(pathlib.Path, sys.argv[1:3])
LIBRARY = "libscalable_isosurface.so.1"
USE = "import scalable_isosurface as si; si.open('missing.bvol')"


def pack(folder):
    script = PROJECT / "Packaging" / "wheel" / "make_wheel.py"
    subprocess.run([sys.executable, "-B", script, BUILD, "linux_x86_64", folder], check=True, stdout=subprocess.DEVNULL)
    return next(pathlib.Path(folder).glob("*.whl"))


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.wheel = pack(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        unpacked = tempfile.TemporaryDirectory()
        self.addCleanup(unpacked.cleanup)
        with zipfile.ZipFile(self.wheel) as archive:
            archive.extractall(unpacked.name)
        self.packages = pathlib.Path(unpacked.name)
        self.package = self.packages / "scalable_isosurface"

    def run_python(self, script):
        """The result of a script in a Python that has the wheel."""
        return subprocess.run(
            [sys.executable, "-B", "-W", "ignore", "-c", script],
            env={**os.environ, "PYTHONPATH": str(self.packages)},
            cwd=self.packages,
            capture_output=True,
            text=True,
            check=False,
        )

    def find_error(self, script=USE):
        """The last line of what a script says, which ends with one traceback."""
        result = self.run_python(script)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(result.stderr.count("Traceback"), 1, result.stderr)
        error = result.stderr.strip().splitlines()[-1]
        self.assertRegex(error, r"^\w+Error: ", result.stderr)
        return error

    def write_header(self, offset, part):
        with open(self.package / LIBRARY, "r+b") as file:
            file.seek(offset)
            file.write(part)

    def test_what_is_packed_is_described_and_complete(self):
        check = PROJECT / "Testing" / "Install" / "check_wheel.py"
        command = [sys.executable, "-B", check, self.wheel, "--python-alone"]
        said = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 0, said.stderr)

    def test_the_check_finds_a_file_that_was_changed(self):
        with zipfile.ZipFile(self.wheel) as archive, zipfile.ZipFile(self.packages / self.wheel.name, "w") as changed:
            for name in archive.namelist():
                changed.writestr(name, archive.read(name) + (b"#" if name.endswith("_volume.py") else b""))
        check = PROJECT / "Testing" / "Install" / "check_wheel.py"
        command = [sys.executable, "-B", check, changed.filename, "--python-alone"]
        said = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertRegex(said.stderr, "^[^\n]*: scalable_isosurface/_volume.py is not the file of RECORD\n$")

    def test_the_same_files_make_the_same_wheel(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(pack(folder).read_bytes(), self.wheel.read_bytes())

    def test_it_writes_reads_and_contours_without_vtk(self):
        result = self.run_python(
            "import sys; sys.modules['vtkmodules'] = None\n"
            "import numpy, scalable_isosurface as si\n"
            "samples = numpy.arange(60, dtype='f4').reshape(3, 4, 5)\n"
            "volume = si.create(samples, 'a.bvol')\n"
            "assert (volume[...] == samples).all() and len(volume.isosurface(30.5).triangles) == 34\n"
            "print(si.__file__)"
        )
        self.assertEqual(result.stderr, "")
        self.assertEqual(pathlib.Path(result.stdout.strip()).parent, self.package)

    def test_a_class_of_vtk_is_said_not_to_be_there(self):
        error = self.find_error("import scalable_isosurface as si; si.vtkStabbingContour")
        self.assertEqual(
            error,
            "AttributeError: vtkStabbingContour needs VTK, without which this 'scalable_isosurface' was built",
        )

    def test_a_missing_library_is_named(self):
        (self.package / LIBRARY).unlink()
        self.assertRegex(self.find_error(), f"^ImportError: /.*/{LIBRARY} cannot be loaded: No such file or directory; ")

    def test_a_part_of_a_library_is_named_and_does_not_end_the_process(self):
        content = (self.package / LIBRARY).read_bytes()
        kept = content[: len(content) * 2 // 3]
        for damaged in (kept, kept + bytes(len(content) - len(kept)), content[:-1]):
            (self.package / LIBRARY).write_bytes(damaged)
            self.assertRegex(self.find_error(), f"{LIBRARY} cannot be loaded: it is damaged: its end is missing; ")

    def test_what_is_no_library_is_named(self):
        for content in (b"", b"<html>Not found</html>" * 10):
            (self.package / LIBRARY).write_bytes(content)
            self.assertRegex(self.find_error(), f"{LIBRARY} cannot be loaded: it is damaged, or no library; ")

    def test_a_library_for_another_processor_is_named(self):
        self.write_header(18, (183).to_bytes(2, "little"))
        self.assertRegex(self.find_error(), "cannot be loaded: it is for aarch64, and this processor is x86_64; ")

    def test_a_library_of_another_version_is_named(self):
        module = self.package / "__init__.py"
        module.write_text(module.read_text().replace('__version__ = "', '__version__ = "3.'))
        self.assertRegex(
            self.find_error(), r"cannot be loaded: the library is of version [\d.]+, and the Python files are of 3\.\d"
        )

    def test_a_system_without_glibc_is_told(self):
        error = self.find_error(
            "import ctypes, platform\n"
            "def load(path): raise OSError('Error loading shared library ld-linux-x86-64.so.2: No such file')\n"
            "ctypes.CDLL, platform.libc_ver = load, lambda: ('musl', '1.2')\n" + USE
        )
        self.assertRegex(error, "ld-linux-x86-64.so.2: No such file; it needs glibc, and the C library of this Python is")

    def test_missing_numpy_is_named(self):
        error = self.find_error("import sys; sys.modules['numpy'] = None\n" + USE)
        self.assertRegex(error, "^ImportError: scalable_isosurface needs NumPy, which cannot be loaded: ")

    def test_numpy_that_cannot_be_loaded_is_named_in_one_line(self):
        (self.packages / "numpy").mkdir()
        text = "raise ImportError('\\n\\nIMPORTANT:\\n\\nread this', name='numpy.core')\n"
        (self.packages / "numpy" / "__init__.py").write_text(text)
        self.assertEqual(
            self.find_error(),
            "ImportError: scalable_isosurface needs NumPy, which cannot be loaded: IMPORTANT: read this",
        )

    def test_a_missing_or_damaged_module_of_a_format_is_named(self):
        (self.packages / "a.tif").write_bytes(b"II*\0\x08\0\0\0")
        script = "import scalable_isosurface as si; si.open('a.tif')"
        module = self.package / "libIsosurfaceTiffFormat.so"
        size = module.stat().st_size
        for end in (size // 2, size):  # then zeros
            os.truncate(module, size // 2)
            os.truncate(module, end)
            self.assertEqual(
                self.find_error(script),
                f"OSError: a.tif: TIFF is read by the module {module.name}, which is damaged: a part of it is missing",
            )
        module.unlink()
        self.assertRegex(self.find_error(script), f"^OSError: a.tif: TIFF is .* {module.name}, which cannot be loaded: ")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
