# SPDX-License-Identifier: BSD-3-Clause
"""Decodes on which side of the isovalue vertices lie: edge-index.md, section "Signs"."""
from edge_index_coding import PRIORS, AdaptiveBits, Mixers

MARGIN = 4  # vertices that rows have beyond the block, on both sides


class Neighbours:
    """The rows around row y of a slice, by the names that the text gives them; packed.

    `slices` has the slices that are decoded, the last one being that of the row.
    """

    def __init__(self, slices):
        y, present = len(slices[-1]), len(slices) - 1

        def find(z, n):
            """Row n of a slice. Rows before the first repeat the first one of the slice before."""
            if n < 0:
                return slices[z - 1][0] if z > 0 else 0
            return slices[z][min(n, len(slices[z]) - 1)]

        self.Y, self.YY = (find(present, y - n) for n in (1, 2))
        if present == 0:
            self.Z = self.ZM = self.ZP = self.ZMM = self.ZPP = self.Y
            self.ZZ = self.ZZM = self.ZZP = self.Y
            return
        self.Z, self.ZM, self.ZP, self.ZMM, self.ZPP = (
            find(present - 1, y + n) for n in (0, -1, 1, -2, 2))
        second = max(present - 2, 0)
        self.ZZ, self.ZZM, self.ZZP = (find(second, y + n) for n in (0, -1, 1))

    def are_quiet(self, x, sign):
        """Whether the bits that matter for runs all are `sign`, but for those of the row itself."""
        return not (window(self.Y, x, -2, 2, sign) or window(self.Z, x, -2, 2, sign)
                    or window(self.ZM, x, -1, 1, sign) or window(self.ZP, x, -1, 1, sign)
                    or window(self.YY, x, 0, 0, sign) or window(self.ZMM, x, 0, 0, sign)
                    or window(self.ZPP, x, 0, 0, sign) or window(self.ZZ, x, 0, 0, sign))


def pack(row):
    """A row of bits as a number: vertex x is its bit x + MARGIN; the ends are repeated."""
    bits = [row[0]] * MARGIN + row + [row[-1]] * MARGIN
    return sum(bit << n for n, bit in enumerate(bits))


def window(row, x, a, b, flip):
    """Bits x + a ... x + b of a packed row as a number, lowest first, each XORed with `flip`."""
    mask = (2 << b - a) - 1
    return (row >> x + a + MARGIN & mask) ^ (mask if flip else 0)


def find_near(rows, x, flip):
    return (window(rows.Y, x, -1, 1, flip) | window(rows.Z, x, -1, 1, flip) << 3
            | window(rows.ZM, x, -1, 1, flip) << 6 | window(rows.ZP, x, -1, 1, flip) << 9)


class Signs:
    """Decodes slices of signs; previews differ in how a vertex outside of runs is decoded."""

    def __init__(self):
        self.quiet = AdaptiveBits.from_priors(PRIORS.quiet, 10, 1023)
        self.slices = []

    def decode_slice(self, decoder, width, height):
        """The next slice, as rows of bits."""
        rows = []
        self.slices.append([])  # packed
        for y in range(height):
            rows.append(self._decode_row(
                decoder, Neighbours(self.slices), len(self.slices) == 1, width))
            self.slices[-1].append(pack(rows[-1]))
        return rows

    def _decode_row(self, decoder, rows, first, width):
        """`first`: whether the row is of the first slice."""
        own = [rows.Z >> MARGIN & 1] * MARGIN  # what lies left of it; vertices follow
        while len(own) < width + MARGIN:
            x = len(own) - MARGIN
            sign = own[-1]
            if own[-2] == sign and rows.are_quiet(x, sign):
                self._decode_run(decoder, rows, x, width, own)
            else:
                own.append(sign ^ self.decode_vertex(decoder, rows, own, x, first))
        return own[MARGIN:]

    def _decode_run(self, decoder, rows, x, width, own):
        sign, length = own[-1], 1
        while x + length < width and rows.are_quiet(x + length, sign):
            length += 1
        size = (length > 2) + (length > 8) + (length > 32)
        if self.quiet.decode(decoder, 4 * sign + size):
            own += [sign] * length
        else:
            place = min(decoder.uniform((length - 1).bit_length()), length - 1)
            own += [sign] * place + [1 - sign]


class PreviewSigns(Signs):
    """Of previews."""

    def __init__(self):
        super().__init__()
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, 255)

    def decode_vertex(self, decoder, rows, own, x, first):
        return self.near.decode(decoder, find_near(rows, x, own[-1]) | first << 12)


def find_pattern(rows, own, x, flip):
    """The numbers near, out and core of the text, and own[-2]."""
    def at(row, n):
        return (row >> x + n + MARGIN & 1) ^ flip

    own2 = own[-2] ^ flip
    out = (own2 | at(rows.YY, 0) << 1 | at(rows.ZZ, 0) << 2 | at(rows.Y, -2) << 3
           | at(rows.Y, 2) << 4 | at(rows.Z, -2) << 5 | at(rows.Z, 2) << 6)
    core = (at(rows.Y, 0) | at(rows.Y, 1) << 1 | at(rows.Z, 0) << 2 | at(rows.Z, 1) << 3
            | at(rows.ZP, 0) << 4)
    return find_near(rows, x, flip), out, core, own2


def count_pattern(rows, x, flip, near, out, core):
    far = sum(window(row, x, -2, 2, flip).bit_count()
              for row in (rows.YY, rows.ZZ, rows.ZMM, rows.ZPP))
    return near.bit_count() | out.bit_count() + far << 4 | core << 9


def scramble(k):
    k = k * 0x9E3779B1 & 0xffffffff
    return (k ^ k >> 15) >> 3


class MixedSigns(Signs):
    """Of the profile small."""

    def __init__(self):
        super().__init__()
        limit = 800
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, limit)
        self.tables = [AdaptiveBits(1 << 14, limit) for _ in range(5)]
        self.mixers = Mixers(PRIORS.sign_mixers)

    def decode_vertex(self, decoder, rows, own, x, first):
        flip = own[-1]

        def at(row, a, b):
            return window(row, x, a, b, flip)

        near, out, core, own2 = find_pattern(rows, own, x, flip)
        YY, ZZ, ZMM, ZPP = rows.YY, rows.ZZ, rows.ZMM, rows.ZPP
        h0 = scramble(near | out << 12)
        h1 = scramble((near | out << 12) ^ (
            at(ZMM, 0, 0) << 20 | at(ZPP, 0, 0) << 21 | at(YY, -1, -1) << 22 | at(YY, 1, 1) << 23
            | at(ZZ, -1, -1) << 24 | at(ZZ, 1, 1) << 25 | 1 << 30))
        h2 = count_pattern(rows, x, flip, near, out, core)
        h3 = scramble(near | at(ZZ, -1, 1) << 12 | at(rows.ZZM, 0, 0) << 15
                      | at(rows.ZZP, 0, 0) << 16 | at(YY, -1, 1) << 17 | own2 << 20 | 1 << 31)
        h4 = scramble(core | out << 5 | at(ZMM, -1, 1) << 12 | at(ZPP, -1, 1) << 15
                      | at(YY, -1, 1) << 18 | flip << 21 | 3 << 30)
        voters = [(self.near, near | first << 12)]
        voters += [(table, h & 0x3fff) for table, h in zip(self.tables, (h0, h1, h2, h3, h4))]
        return self.mixers.decode(decoder, core | own2 << 5 | first << 6, voters)
