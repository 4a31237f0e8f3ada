# SPDX-License-Identifier: BSD-3-Clause
"""Reads paged files and interval trees: a second implementation of interval-tree.md.

It was written from Documentation/formats alone. Python 3 with its standard library, and the shared
library of xxHash.
"""
import ctypes
import ctypes.util
import math
import struct


class FormatError(Exception):
    """A file breaks a rule of the specification, or needs a newer reader."""


def check(condition, message):
    if not condition:
        raise FormatError(message)


_xxhash = ctypes.CDLL(ctypes.util.find_library("xxhash") or "libxxhash.so.0")
_xxhash.XXH3_64bits_withSeed.restype = ctypes.c_uint64
_xxhash.XXH3_64bits_withSeed.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_uint64]


def hash64(data, seed=0):
    return _xxhash.XXH3_64bits_withSeed(data, len(data), seed)


def read_file(path):
    with open(path, "rb") as file:
        return file.read()


class PagedFile:
    def __init__(self, path, kind):
        self.path = path
        self.bytes = read_file(path)
        check(len(self.bytes) >= 288 and self.bytes[:8] == b"ISOPAGED", f"{path}: is not paged")
        version, self.page_size, self.page_count = struct.unpack_from("<IIQ", self.bytes, 8)
        check(version == 1, f"{path}: paged file version {version}")
        check(self.page_size in (4096, 8192, 16384), f"{path}: impossible page size")
        check(len(self.bytes) == self.page_size * self.page_count, f"{path}: truncated")
        self.page_reads = 0
        first = self.read(0)
        check(first[24:32] == kind, f"{path}: is not of kind {kind}")
        self.seal, = struct.unpack_from("<Q", self.bytes, self.page_size - 8)
        self.check_sums(first)
        self.client_area = first[32:288]

    def check_sums(self, first):
        self.group, = struct.unpack_from("<Q", first, 288)
        if self.group == 0:
            check(not any(first[288:]), f"{self.path}: page 0 does not end with zeros")
            return
        pages = range(1, self.page_count)
        limit = (self.page_size - 304) // 8
        check(self.group & (self.group - 1) == 0 and -(-len(pages) // self.group) <= limit
              and (self.group == 1 or -(-len(pages) // (self.group // 2)) > limit),
              f"{self.path}: impossible groups of pages")
        sums = [0] * limit
        for page in pages:
            checksum, = struct.unpack_from("<Q", self.bytes, (page + 1) * self.page_size - 8)
            sums[(page - 1) // self.group] += checksum
        check(first[296:] == struct.pack(f"<{limit}Q", *(of % 2**64 for of in sums)),
              f"{self.path}: wrong sums of checksums")

    def check_seal(self, seal):
        check(self.group > 0 and self.seal == seal, f"{self.path}: another file's seal")

    def read(self, page):
        """The payload of a page."""
        check(page < self.page_count, f"{self.path}: no page {page}")
        begin, end = page * self.page_size, (page + 1) * self.page_size - 8
        payload = self.bytes[begin:end]
        check(struct.unpack_from("<Q", self.bytes, end)[0] == hash64(payload, page),
              f"{self.path}: page {page}: wrong checksum")
        self.page_reads += 1
        return payload


class IntervalTree:
    """Lists and subtrees are tuples as they stand in the file: (page, record, count[, height])."""

    def __init__(self, path):
        self.file = PagedFile(path, b"INTVTREE")
        area = self.file.client_area
        version, zero, self.count, self.least, self.greatest = struct.unpack_from("<IIQQQ", area)
        check(version == 1, f"{path}: interval tree version {version}")
        self.root = struct.unpack_from("<IHIH", area, 32)
        self.identity, = struct.unpack_from("<Q", area, 48)
        check(zero == 0 and not any(area[44:48]) and not any(area[56:]),
              f"{path}: the client area does not end with zeros")
        check(self.count == self.root[2] and self.root[3] < 32, f"{path}: impossible root")
        self.capacity = (self.file.page_size - 16) // 20
        self.lists_read = {"leaf": 0, "left": 0, "right": 0, "multislab": 0, "window": 0}

    def find(self, low, high):
        """All (minimum, maximum, payload) that overlap [low, high]."""
        if low > high or low > self.greatest or high < self.least:
            return []
        found, pending = [], [(self.root, self.file.page_count)]
        while pending:
            (*records, height), end = pending.pop()
            if records[2] == 0:
                continue
            if height > 0:
                check(records[0] < end and records[1] == 0, f"{self.file.path}: impossible child")
                pending += self._visit_node(records[0], height, low, high, found)
            else:
                check(records[2] <= self.capacity, f"{self.file.path}: a leaf of several pages")
                found += [r for r in self._records(records, end, "leaf")
                          if r[0] <= high and r[1] >= low]
        return found

    def _visit_node(self, page, height, low, high, found):
        node = self.file.read(page)
        tag, own_height, s, m, w, zero = struct.unpack_from("<4sHHHHI", node)
        check(tag == b"NODE" and own_height == height and zero == 0
              and 2 <= s <= 2 * math.isqrt(self.capacity)
              and 8 + 58 * s + 14 * m + 10 * w <= len(node), f"{self.file.path}: impossible node")
        inner = struct.unpack_from(f"<{s - 1}Q", node, 16)
        check(list(inner) == sorted(set(inner)), f"{self.file.path}: boundaries do not ascend")
        bounds = (-1,) + inner + (2**64,)  # slab i: bounds[i] < key <= bounds[i + 1]
        slabs = [struct.unpack_from("<IHIQIHIQIHIHH", node, 8 + 8 * s + 50 * i) for i in range(s)]
        first = next(i for i in range(s) if low <= bounds[i + 1])
        last = next(i for i in range(s) if high <= bounds[i + 1])

        for i in range(first, last + 1):
            left, least = slabs[i][0:3], slabs[i][3]
            if left[2] > 0 and least <= high:
                records = self._records(left, page, "left")
                check([r[0] for r in records] == sorted(r[0] for r in records)
                      and records[0][0] == least, f"{self.file.path}: left list out of order")
                found += [r for r in records if r[0] <= high]
        right, greatest = slabs[first][4:7], slabs[first][7]
        if right[2] > 0 and greatest >= low:
            records = self._records(right, page, "right")
            check([r[1] for r in records] == sorted((r[1] for r in records), reverse=True)
                  and records[0][1] == greatest, f"{self.file.path}: right list out of order")
            found += [r for r in records if r[1] >= low]
        for i in range(m):
            begin, end, *records = struct.unpack_from("<HHIHI", node, 8 + 58 * s + 14 * i)
            check(1 <= begin <= end <= s - 2, f"{self.file.path}: impossible multislab")
            if begin <= first <= end:
                found += self._records(records, page, "multislab")
        window = slabs[first][12]
        if window != 65535:
            check(window < w, f"{self.file.path}: no such window")
            records = struct.unpack_from("<IHI", node, 8 + 58 * s + 14 * m + 10 * window)
            found += [r for r in self._records(records, page, "window")
                      if r[0] <= bounds[first] and r[1] >= bounds[first + 1]]
        children = [(slabs[i][8:12], page) for i in range(first, last + 1)
                    if low != bounds[i + 1]]
        check(all(child[3] < height for child, _ in children), f"{self.file.path}: child too high")
        return children

    def _records(self, place, end_page, kind):
        page, record, count = place
        self.lists_read[kind] += 1
        pages = -(-(record + count) // self.capacity)
        check(1 <= page and page + pages <= end_page and record < self.capacity
              and (pages == 1 or record == 0), f"{self.file.path}: impossible list")
        records = []
        for number in range(page, page + pages):
            payload = self.file.read(number)
            check(payload[:8] == b"RECS\0\0\0\0", f"{self.file.path}: {number} has no records")
            records += struct.iter_unpack("<QQI", payload[8:8 + 20 * self.capacity])
        records = records[record:record + count]
        check(all(r[0] <= r[1] for r in records), f"{self.file.path}: impossible interval")
        return records
