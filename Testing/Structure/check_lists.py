#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What one list has is in the other places that list it, which no compiler compares: names of types, codecs,
distributions, formats, quantities and options of commands, properties of the contour filter.
check_lists.py FOLDER"""
import pathlib
import re
import sys

# Where the names are, how they are found there, and which other files have each of them as a word.
NAMES = (
    ("Core/Ground/Volume/ValueType.cxx", r'return "(\w+)"', (
        "Documentation/formats/blocked-volume.md", "Testing/Readers/read_blocked_volume.py")),
    ("Core/Storage/Record/BlockCompression.cxx", r'return \{ "(\w+)"', (
        "Documentation/formats/block-compression.md", "Documentation/formats/blocked-volume.md",
        "Documentation/reference/writing.md", "Plugin/XML/BlockedVolumeWriter.xml",
        "Interface/WriteCalls.cxx", "Python/scalable_isosurface/_writing.py",
        "Testing/Readers/read_blocked_volume.py", "Tools/BlockVolumeOptions.cxx",
        "Writers/vtkBlockedVolumeWriter.h")),
    ("Core/Storage/Record/BlockCompression.cxx", r'return \{ "(?!none)(\w+)"', (
        "Testing/Fuzz/WriteFuzzCorpus.cxx", "Testing/Readers/WriteSampleVolumes.cxx")),
    ("Core/Storage/Distribution/BlockDistribution.cxx", r'return "(\w+)"', (
        "Documentation/formats/blocked-volume.md", "Documentation/reference/writing.md",
        "Plugin/XML/BlockedVolumeWriter.xml", "Tools/BlockVolumeOptions.cxx", "Writers/vtkBlockedVolumeWriter.h")),
    ("Formats/Opener/VolumeFormat.cxx", r'^    \{ "(\w+)"', (
        "Documentation/dev/sources.md", "Documentation/reference/command-line.md",
        "Documentation/reference/in-place.md", "Documentation/user-guide.md", "Plugin/XML/InPlaceVolumeReader.xml",
        "Python/scalable_isosurface/_opening.py", "Tools/BlockVolumeOptions.cxx")),
    ("Core/Storage/Spectrum/WorkloadSpectrum.h", r"^  Counts (\w+);", (
        "Filters/vtkContourSpectrum.cxx", "Filters/vtkContourSpectrum.h", "Plugin/Gui/SpectrumCurve.h",
        "Interface/VolumeCalls.cxx", "Testing/Readers/read_blocked_volume.py",
        "Tools/InfoCommand.cxx")),
    ("Tools/BlockVolumeOptions.cxx", r'add_(?:option|flag)\(\s*"(--[\w-]+)"', (
        "Documentation/reference/command-line.md",)),
    ("Tools/EdgeIndexOptions.cxx", r'add_(?:option|flag)\(\s*"(--[\w-]+)"', (
        "Documentation/reference/command-line.md",)),
)
CONTOUR = "Filters/vtkStabbingContour.h"
# What each property of the filter has in other files.
PROPERTY = (
    ("Filters/vtkStabbingContour.h Filters/vtkStabbingContour.cxx", r'"{}(?:: |")'),
    ("Filters/ContourExecution.cxx", r"Get{}\(\)"),
    ("Plugin/XML/StabbingContour.xml", r'"Set{}"'),
    ("Documentation/reference/isosurfaces.md Documentation/reference/many-ranks.md", r"\b{}\b"),
)
NOT_IN_THE_WINDOW = {"NumberOfThreads"}
# The region is agreed on as a whole; each rank has threads of its own.
NOT_AGREED_ON = {"NumberOfThreads", "RegionLength", "RegionPosition", "UseRegion"}


def main():
    root = pathlib.Path(sys.argv[1])
    faults = []

    def read(paths):
        return "\n".join((root / path).read_text() for path in paths.split())

    def find_all(pattern, path):
        found = re.findall(pattern, read(path), re.M)
        if not found:
            faults.append(f"{path}: has no list that {pattern!r} finds")
        return found

    def expect(pattern, paths, name):
        if not re.search(pattern, read(paths), re.I):
            faults.append(f"{paths}: lacks {name}")

    for path, pattern, places in NAMES:
        for name in find_all(pattern, path):
            for place in places:
                expect(rf"(?<!\w){name}\b", place, f"{name} of {path}")
    # A clamp turns what is beyond its last number into that one.
    for member, (path, pattern, _), place in (
            ("Compression", NAMES[1], "Writers/vtkBlockedVolumeWriter.h"),
            ("Distribution", NAMES[3], "Writers/vtkBlockedVolumeWriter.h"),
            ("StoreQuantity", NAMES[5], "Filters/vtkContourSpectrum.h")):
        last = find_all(pattern, path)[-1]
        expect(rf"vtkSetClampMacro\({member}, int, -?\w+, {last}\)", place, f"{last} as the last {member}")
    agreed = find_all(r'visit\("(\w+)"', CONTOUR)
    fingerprint = find_all(r"(?s)::ComputeFingerprint\(.*?^}", "Filters/ContourExecution.cxx")[0]
    for name in find_all(r"vtkSet(?:Clamp|Vector3)?Macro\((\w+)", CONTOUR):
        for place, pattern in PROPERTY:
            if name not in NOT_IN_THE_WINDOW or not place.startswith("Plugin"):
                expect(pattern.format(name), place, f"the property {name} of {CONTOUR}")
        if name not in NOT_AGREED_ON and name not in agreed and f"Get{name}()" not in fingerprint:
            faults.append(f"{CONTOUR}: VisitProperties lacks the property {name}")
    print("\n".join(faults) or "Each list is complete.")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
