# SPDX-License-Identifier: BSD-3-Clause
"""mypy accepts the package, the examples of its page and docstrings, and refuses what it has not."""

import doctest
import importlib
import os
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest

import scalable_isosurface

MODULES = ("_arguments", "_edge_index", "_functions", "_indexing", "_library", "_opening", "_pyvista", "_surface",
           "_volume", "_writing")
PAGE = sys.argv[1]
WRONG = (
    "volume.nothing",
    "volume.isosurface(1, maximum_islands='two')",
    "si.open_surface('a.eix').shape",
    "si.open(1)",
)


def collect_examples():
    """Each example as a function of its own."""
    with open(PAGE, encoding="utf-8") as page:
        examples = [code for code in re.findall("```python\n(.*?)```", page.read(), re.S) if " as si" in code]
    for name in MODULES:
        for test in doctest.DocTestFinder().find(importlib.import_module(f"scalable_isosurface.{name}")):
            if test.examples:
                examples.append("".join(example.source for example in test.examples))
    examples += [f'volume = si.open("a.bvol")\n{code}' for code in WRONG]
    head = "import numpy as np\nimport scalable_isosurface as si\n"
    return head + "".join(
        f"\n\ndef example_{number}() -> None:\n{textwrap.indent(code, '    ')}" for number, code in enumerate(examples)
    )


class Types(unittest.TestCase):
    def test_mypy_accepts_examples_and_refuses_what_is_not_there(self):
        package = os.path.dirname(scalable_isosurface.__file__)
        with tempfile.TemporaryDirectory() as folder:
            examples = os.path.join(folder, "examples.py")
            with open(examples, "w", encoding="utf-8") as file:
                file.write(collect_examples())
            modules = [os.path.join(package, f"{name}.py") for name in MODULES]
            # The stubs of VTK's classes are VTK's own work.
            said = subprocess.run(
                [sys.executable, "-m", "mypy", "--follow-imports=silent", "--ignore-missing-imports",
                 "--cache-dir", os.path.join(folder, "cache"), "--no-error-summary", examples, *modules],
                capture_output=True, text=True, check=False,
                env={**os.environ, "MYPYPATH": os.path.dirname(package)},
            )  # fmt: skip
            with open(examples, encoding="utf-8") as file:
                lines = file.read().splitlines()
        numbers = [int(line.split(":")[1]) for line in said.stdout.splitlines() if ": error:" in line]
        found = tuple(lines[number - 1].strip() for number in numbers)
        self.assertEqual(found, WRONG, said.stdout + said.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
