# SPDX-License-Identifier: BSD-3-Clause
"""Copies of a volume that are damaged in one way each, and what their errors must say."""
import os
import re
import shutil

import plugin_testing as testing


def copy_volume(name):
    path = testing.output(name)
    shutil.copy(testing.volume("wave.bvol"), path)
    shutil.copytree(testing.get_stores(testing.volume("wave.bvol")), testing.get_stores(path))
    return path


def edit(path, change):
    with open(path) as file:
        text = file.read()
    changed = change(text)
    assert changed != text
    with open(path, "w") as file:
        file.write(changed)


def damage_header_end():
    path = copy_volume("truncated.bvol")
    os.truncate(path, os.path.getsize(path) // 2)
    return path


def raise_version():
    path = copy_volume("newer.bvol")
    edit(path, lambda text: re.sub(r'("formatVersion": )\d+', r"\g<1>99", text))
    return path


def change_header():
    path = copy_volume("changed.bvol")
    edit(path, lambda text: text.replace('"blockSize": 16', '"blockSize": 32'))
    return path


def remove_store():
    path = copy_volume("storeless.bvol")
    (generation,) = os.listdir(testing.get_stores(path))
    shutil.rmtree(os.path.join(testing.get_stores(path), generation, "store-00002"))
    return path


def truncate_blocks():
    path = copy_volume("blockless.bvol")
    (generation,) = os.listdir(testing.get_stores(path))
    blocks = os.path.join(testing.get_stores(path), generation, "store-00001", "blocks")
    os.truncate(blocks, os.path.getsize(blocks) // 3)
    return path


# What damages a volume, and what its message must say beside the path.
FAULTS = [
    (damage_header_end, r"was cut off, or is not a .*blocked volume"),
    (raise_version, r"99"),
    (change_header, r"(?i)checksum"),
    (remove_store, r"store-00002"),
    (truncate_blocks, r"store-00001"),
]
