# SPDX-License-Identifier: BSD-3-Clause
"""Decodes blocks of the profile working: edge-index.md, section "Profile working"."""
from edge_index_coding import decode_signed
from edge_index_values import Bits, wrap
from read_interval_tree import check
from read_segment import decompress_zstd


class Planes:
    """The planes at the front of a code; `source` takes numbers and bytes from it."""

    def __init__(self, source, block):
        width, rows = (block.nx + 7) // 8, block.ny * block.nz
        columns = self._read_plane(source, width * rows)
        self.rows = [int.from_bytes(columns[row::rows], "little") for row in range(rows)]
        count = source.number()
        check(count <= 3 * block.nx * rows, "planes: too many numbers")
        number_of_planes, = source.take(1)
        check(number_of_planes <= 8, "planes: too many planes")
        planes = [self._read_plane(source, count) for _ in range(number_of_planes)]
        self.numbers = [sum(plane[n] << 8 * k for k, plane in enumerate(planes))
                        for n in range(count)]
        self.rows.reverse()
        self.numbers.reverse()

    @staticmethod
    def _read_plane(source, size):
        stored = source.number()
        check(stored <= size, "planes: a plane is too large")
        plane = source.take(stored)
        return plane if stored == size else decompress_zstd(plane, size)

    def take(self, greatest):
        check(self.numbers and self.numbers[-1] <= greatest, "planes: impossible number")
        return self.numbers.pop()

    def check_end(self):
        check(not self.numbers, "planes: numbers are left over")


class PlaneSigns:
    def __init__(self, planes):
        self.planes = planes
        self.below = None

    def decode_slice(self, _, width, height):
        rows = []
        for y in range(height):
            bits = self.planes.rows.pop()
            rows.append([(bits >> x & 1) ^ self._predict(rows, x, y) for x in range(width)])
        self.below = rows
        return rows

    def _predict(self, rows, x, y):
        if y == 0:
            return self.below[0][x] if self.below else 0
        if not self.below:
            return rows[y - 1][x]
        before, under = rows[y - 1][x], self.below[y][x]
        return before if before == under else 1 - self.below[y - 1][x]


class PlaneValues:
    def __init__(self, planes, domain):
        self.planes, self.domain = planes, domain

    def decode_slice(self, _, block, z):
        """The values at the relevant vertices of slice z by (x, y)."""
        return {(x, y): self.domain.find_value(self._take(block.is_inside(x, y, z)))
                for y in range(block.ny) for x in range(block.nx) if block.is_relevant(x, y, z)}

    def _take(self, inside):
        if isinstance(self.domain, Bits):
            difference = decode_signed(self.planes.take(2**64 - 1))
            return wrap(self.domain.guess(0, inside)[0] + difference, self.domain.bits)
        least, greatest = self.domain.bounds[inside]
        return self.planes.take(greatest) if inside else -1 - self.planes.take(-1 - least)


class PlaneCrossings:
    def __init__(self, planes, cut, some_missing):
        self.planes, self.cut = planes, cut
        self.greatest = cut.count if some_missing else cut.count - 1

    def decode_slice(self, _, block, z):
        """The intervals of the crossed edges of slice z by (x, y, axis); None: no number."""
        intervals = {edge: self.planes.take(self.greatest) for edge in block.list_edges(z)}
        return {edge: None if interval == self.cut.count else interval
                for edge, interval in intervals.items()}
