#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The version of the project is in CMakeLists.txt; these files, which CMake does not write, have the same.
check_versions.py FOLDER"""
import pathlib
import re
import sys

PLACES = (
    ("CHANGELOG.md", r"^## ([0-9.]+)"),
    ("CITATION.cff", r"^version: ([0-9.]+)"),
    ("debian/changelog", r"\Ascalable-isosurface \(([0-9.]+)-"),
    ("debian/rules", r"libscalable-isosurface1 \(>= ([0-9]+)\.0\.0\)"),
    ("debian/control", r"^Package: libscalable-isosurface([0-9]+)$"),
    ("Packaging/conda/recipe.yaml", r'^  version: "([0-9.]+)"'),
    ("Testing/Install/VTK/CMakeLists.txt", r"find_package\(ScalableIsosurface ([0-9]+)\."),
)


def main():
    root = pathlib.Path(sys.argv[1])
    version = re.search(r"^project\(\w+ VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text(), re.M).group(1)
    faults = []
    for path, pattern in PLACES:
        found = re.search(pattern, (root / path).read_text(), re.M)
        # One number stands for all versions of which it is the first.
        if not found or found.group(1) not in (version, version.partition(".")[0]):
            faults.append(f"{path}: has the version {found and found.group(1)}, not {version}")
    print("\n".join(faults) or f"All have the version {version}.")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
