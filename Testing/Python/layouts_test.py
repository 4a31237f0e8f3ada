# SPDX-License-Identifier: BSD-3-Clause
"""The structures that Python hands to the C library lie as those of its header, as a C compiler sees them.

    layouts_test.py FOLDER_OF_THE_HEADER
"""

import ctypes
import os
import subprocess
import sys
import tempfile
import unittest

import scalable_isosurface._library  # noqa: F401, which makes the structures

FOLDER = sys.argv.pop()


class Layouts(unittest.TestCase):
    def test_members_lie_where_the_header_has_them(self):
        structures = [kind for kind in ctypes.Structure.__subclasses__() if kind.__name__.startswith("si_")]
        self.assertGreater(len(structures), 10)
        places, lines = [], []
        for kind in structures:
            name = kind.__name__
            places.append((name, 0, ctypes.sizeof(kind)))
            lines.append(f'printf("{name} 0 %zu\\n", sizeof({name}));')
            for member, _ in kind._fields_:
                field = getattr(kind, member)
                places.append((f"{name}.{member}", field.offset, field.size))
                lines.append(f'printf("{name}.{member} %zu %zu\\n", offsetof({name}, {member}), '
                             f'sizeof((({name}*)0)->{member}));')
        program = "#include <stdio.h>\n#include <scalable_isosurface.h>\nint main(void)\n{\n%s\n}\n" % "\n".join(lines)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "layouts")
            subprocess.run(["cc", "-x", "c", "-std=c99", "-I", FOLDER, "-o", path, "-"], input=program, text=True,
                           check=True)
            said = subprocess.run([path], check=True, capture_output=True, text=True).stdout
        self.assertEqual([" ".join(map(str, place)) for place in places], said.splitlines())


unittest.main()
