#!/usr/bin/env python3
"""Reads the include lines of the sources, checks that they point down, and draws the map of districts.

    Documentation/districts.py            write Documentation/images/districts.svg anew
    Documentation/districts.py --check    an error a line for each include that points up, and if the
                                          map is not that of the sources
    Documentation/districts.py --table    the arrows between districts, with the number of includes
"""
import argparse
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MAP = ROOT / "Documentation/images/districts.svg"

# A district, and the districts that it may include: as few as there can be.
GROUND, SURFACE, STORAGE = "Core/Ground", "Core/Surface", "Core/Storage"
CODING, RANKS = "Core/Coding", "Core/Ranks"
CORE = [GROUND, SURFACE, STORAGE, CODING, RANKS]
MAY_INCLUDE = {
    GROUND: [],
    SURFACE: [GROUND],
    STORAGE: [GROUND],
    CODING: [GROUND, SURFACE],
    RANKS: [GROUND, SURFACE, STORAGE, CODING],
    "Formats": CORE,  # only Files, its highest room, includes more than Ground and Storage
    "Bridge": CORE,
    "Readers": CORE + ["Bridge", "Formats"],
    "Filters": CORE + ["Bridge", "Readers"],
    "Writers": CORE + ["Formats", "Bridge", "Readers", "Filters"],
    "Rendering": CORE + ["Bridge"],
    "Surfaces": CORE + ["Bridge"],
    "Representation": CORE + ["Bridge", "Surfaces"],
    "Plugin": CORE + ["Bridge", "Surfaces", "Representation"],
    "Tools": CORE + ["Formats", "Bridge", "Writers"],
    "Interface": CORE + ["Formats"],
    "Python": [],  # it calls Interface
}
# Where the map has a district: row, first column, columns of four. Rows of Core are in its frame.
PLACES = {
    "Plugin": (0, 0, 2), "Tools": (0, 2, 2),
    "Representation": (1, 0, 1), "Rendering": (1, 1, 1), "Writers": (1, 2, 2),
    "Surfaces": (2, 0, 1), "Filters": (2, 2, 1), "Python": (2, 3, 1),
    "Readers": (3, 1.6, 1.2), "Interface": (3, 2.8, 1.2),
    "Bridge": (4, 0, 2.5), "Formats": (4, 2.5, 1.5),
    RANKS: (5, 0, 4),
    STORAGE: (6, 0, 2), CODING: (6, 2, 2),
    SURFACE: (7, 0, 4),
    GROUND: (8, 0, 4),
}


def first_sentence(folder):
    """What stands atop the CMakeLists.txt of a district or a room."""
    words = []
    for line in (ROOT / folder / "CMakeLists.txt").read_text().splitlines():
        if not line.startswith("#") or line == "#":
            break
        words.append(line[1:].strip())
    sentence = re.split(r"(?<=\.)\s", " ".join(words))[0]
    return re.sub(r" \([^)]*\)", "", sentence)


def rooms_of(district):
    """The rooms of a district, lowest first; none if it is a single room."""
    text = (ROOT / district / "CMakeLists.txt").read_text()
    rooms = re.findall(r"^\s*add_subdirectory\((\w+)\)", text, re.MULTILINE)
    return [room for room in rooms if (ROOT / district / room).is_dir()]


def list_sources(district):
    for path in sorted((ROOT / district).rglob("*")):
        if path.suffix in (".h", ".cxx", ".txx"):
            yield path


def place_of(path):
    """The district and the room of a source, by its path from the root."""
    for district in MAY_INCLUDE:
        prefix = district + "/"
        if path.startswith(prefix):
            rest = path[len(prefix):].split("/")
            return district, rest[0] if len(rest) > 1 else ""
    return None


def read_includes():
    """(source, line number, included) of every include of a header of this project; paths from the root."""
    sources = {district: list(list_sources(district)) for district in MAY_INCLUDE}
    bare = {path.name: path.relative_to(ROOT).as_posix()
            for paths in sources.values() for path in paths if path.suffix == ".h"}
    for paths in sources.values():
        for path in paths:
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = re.match(r'\s*#\s*include "([^"]+)"', line)
                if not match:
                    continue
                name = match[1]
                candidates = [path.parent / name, ROOT / "Core" / name, ROOT / name]
                found = next((c.relative_to(ROOT).as_posix() for c in candidates if c.is_file()),
                             bare.get(name))
                if found:
                    yield path.relative_to(ROOT).as_posix(), number, found


def find_errors_and_arrows():
    errors = []
    arrows = collections.Counter()
    order = {district: rooms_of(district) for district in MAY_INCLUDE}
    for source, number, included in read_includes():
        (district, room), (other, other_room) = place_of(source), place_of(included)
        if district != other:
            arrows[district, other] += 1
            if other not in MAY_INCLUDE[district]:
                errors.append(f"{source}:{number}: {district} does not include {other} ({included})")
        elif room != other_room and order[district]:
            rooms = order[district]
            for name in (room, other_room):
                if name and name not in rooms:
                    errors.append(f"{source}:{number}: {district}/CMakeLists.txt does not list {name}")
            if room in rooms and other_room in rooms and rooms.index(room) < rooms.index(other_room):
                errors.append(f"{source}:{number}: {room} stands below {other_room} ({included})")
    return errors, arrows


def without_detours(arrows):
    """Leaves out arrows between districts that others of the arrows join already."""
    below = collections.defaultdict(set)
    for source, target in arrows:
        below[source].add(target)

    def reaches(start, target):
        return any(next_one == target or reaches(next_one, target) for next_one in below[start])

    return [(a, b) for a, b in sorted(arrows)
            if not any(reaches(c, b) for c in below[a] if c != b)]


def wrap(text, width):
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


WIDTH, MARGIN, GAP, INSET = 1000, 20, 30, 16


def lay_out():
    """x, y, width, height and the lines of text of each district; top and bottom of Core's frame."""
    boxes = {}
    y = MARGIN
    for row in range(1 + max(row for row, _, _ in PLACES.values())):
        districts = [district for district in PLACES if PLACES[district][0] == row]
        in_core = districts[0] in CORE
        if districts == [RANKS]:
            core_top = y + 6
            y += 30
        left = MARGIN + (INSET if in_core else 0)
        column = (WIDTH - 2 * left + GAP) / 4
        texts = {}
        for district in districts:
            width = column * PLACES[district][2] - GAP
            sentence = first_sentence(district).split(" ", 1)[1]
            texts[district] = [("promise", line) for line in wrap(sentence, int(width / 6.9))]
            rooms = ", ".join(reversed(rooms_of(district)))
            texts[district] += [("rooms", line) for line in wrap(rooms, int(width / 7.2)) if rooms]
        height = max(30 + 16 * len(lines) for lines in texts.values())
        for district in districts:
            x = left + column * PLACES[district][1]
            boxes[district] = (x, y, column * PLACES[district][2] - GAP, height, texts[district])
        y += height + GAP
    return boxes, core_top, y - GAP + 12


def draw_box(district, box):
    x, y, width, height, lines = box
    kind = "core" if district in CORE else "above"
    yield f'<rect class="{kind}" x="{x:.0f}" y="{y}" width="{width:.0f}" height="{height}" rx="6"/>'
    name = district.replace("Core/", "")
    yield f'<text class="name" x="{x + 10:.0f}" y="{y + 20}">{name}</text>'
    for number, (style, line) in enumerate(lines):
        yield f'<text class="{style}" x="{x + 10:.0f}" y="{y + 38 + 16 * number}">{line}</text>'


def draw_arrows(arrows, boxes, core_top):
    """Arrows go straight down. All that stands above Core may use it: two arrows to its frame say so."""
    for source, target in without_detours({(a, b) for a, b in arrows if a in CORE or b not in CORE}):
        ax, ay, aw, ah, _ = boxes[source]
        bx, by, bw, _, _ = boxes[target]
        x = (max(ax, bx) + min(ax + aw, bx + bw)) / 2
        yield f'<path class="arrow" d="M{x:.0f} {ay + ah} V{by - 1}"/>'
    for source in ("Bridge", "Formats"):
        x, y, width, height, _ = boxes[source]
        yield f'<path class="arrow" d="M{x + width / 2:.0f} {y + height} V{core_top - 1}"/>'


def draw_map(arrows):
    boxes, core_top, core_bottom = lay_out()
    shapes = list(draw_arrows(arrows, boxes, core_top))
    for district, box in boxes.items():
        shapes.extend(draw_box(district, box))
    body = "\n".join(shapes)
    height = core_bottom + MARGIN
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}">
<!-- Written by Documentation/districts.py from the include lines of the sources. -->
<style>
  text {{ font-family: sans-serif; fill: #222 }}
  .name {{ font-size: 15px; font-weight: bold }}
  .promise {{ font-size: 12px; fill: #444 }}
  .rooms {{ font-size: 12px; fill: #0b5394 }}
  .core {{ fill: #eef4fb; stroke: #3d78b0 }}
  .above {{ fill: #f6f3ea; stroke: #a08a4a }}
  .frame {{ fill: none; stroke: #3d78b0; stroke-dasharray: 5 4 }}
  .arrow {{ fill: none; stroke: #555; stroke-width: 1.4; marker-end: url(#head) }}
</style>
<defs><marker id="head" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto">
<path d="M0 0 L9 4 L0 8 z" fill="#555"/></marker></defs>
<rect fill="#fff" width="{WIDTH}" height="{height}"/>
<rect class="frame" x="{MARGIN}" y="{core_top}" width="{WIDTH - 2 * MARGIN}" height="{core_bottom - core_top}" rx="8"/>
<text class="name" x="{MARGIN + INSET}" y="{core_top + 18}">Core: plain C++17, without VTK</text>
{body}
</svg>
"""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    errors, arrows = find_errors_and_arrows()
    if options.table:
        for (source, target), count in sorted(arrows.items()):
            print(f"{source:15} -> {target:15} {count:4}")
        return 0
    drawing = draw_map(arrows)
    if not options.check:
        MAP.write_text(drawing)
        return 0
    if not errors and (not MAP.is_file() or MAP.read_text() != drawing):
        errors.append(f"{MAP.relative_to(ROOT)} is out of date: run Documentation/districts.py")
    print("\n".join(errors), file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
