#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Links in all .md files lead to files, folders and headings that exist, and so do the pages that sources name."""
import pathlib
import re
import sys

# An inline link or image, without a title.
LINK = re.compile(r"\[(?:[^\]\[]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?\s*\)")
NAMED_PAGE = re.compile(r"\bDocumentation/[\w./-]+\.(?:md|txt)\b")
SOURCES = {".cmake", ".cxx", ".h", ".in", ".ini", ".py", ".sh", ".txt", ".xml", ".yml"}


def list_files(folder):
    for path in sorted(folder.iterdir()):
        if path.name.startswith((".", "build")):
            continue
        if path.is_dir():
            yield from list_files(path)
        else:
            yield path


def remove_code(text):
    """Replaces code by as many lines of nothing, so that lines keep their numbers."""
    text = re.sub(r"^( *)```.*?^ *```", lambda block: "\n" * block[0].count("\n"), text, flags=re.S | re.M)
    return re.sub(r"(?<!`)`[^`\n]+`(?!`)", "", text)


def find_anchors(text):
    """The names of the headings, as GitHub makes them."""
    anchors = set()
    text = re.sub(r"^( *)```.*?^ *```", "", text, flags=re.S | re.M)
    for heading in re.findall(r"^#{1,6} +(.+?) *#*$", text, flags=re.M):
        heading = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        number = 0
        while (anchor := name if number == 0 else f"{name}-{number}") in anchors:
            number += 1
        anchors.add(anchor)
    return anchors | set(re.findall(r'<a (?:id|name)="([^"]+)"', text))


def check(root):
    """The number of links, and a line for each one that leads nowhere."""
    number, faults, anchors = 0, [], {}
    for path in list_files(root):
        if path.suffix == ".md":
            text = remove_code(path.read_text(encoding="utf-8"))
            for link in LINK.finditer(text):
                target = link[1]
                if re.match(r"[a-z]+:", target):
                    continue
                number += 1
                at = text.count("\n", 0, link.end()) + 1
                name, _, anchor = target.partition("#")
                page = (path.parent / name).resolve() if name else path
                if not page.exists():
                    faults.append(f"{path.relative_to(root)}:{at}: {target}: there is no such file")
                elif anchor and page.suffix == ".md":
                    if page not in anchors:
                        anchors[page] = find_anchors(page.read_text(encoding="utf-8"))
                    if anchor not in anchors[page]:
                        faults.append(f"{path.relative_to(root)}:{at}: {target}: there is no such heading")
        elif path.suffix in SOURCES:
            for name in NAMED_PAGE.findall(path.read_text(encoding="utf-8", errors="replace")):
                number += 1
                if not (root / name).exists():
                    faults.append(f"{path.relative_to(root)}: {name}: there is no such file")
    return number, faults


if __name__ == "__main__":
    count, found = check(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(found) or f"{count} links lead where they should")
    sys.exit(1 if found or count == 0 else 0)
