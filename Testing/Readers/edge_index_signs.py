# SPDX-License-Identifier: BSD-3-Clause
"""Decodes on which side of the isovalue vertices lie: edge-index.md, section "Signs"."""
from edge_index_coding import PRIORS, AdaptiveBits, Mixers


class Neighbours:
    """The rows around row y of a slice, in which vertices repeat those at the ends.

    A row here is a list in which vertex x stands at x + 2. `slices` has the slices that are decoded,
    `rows` what is decoded of the present one.
    """

    def __init__(self, slices, rows, width):
        y, before = len(rows), len(slices) - 1

        def find(z, n):
            """Row n of a decoded slice. Rows before the first repeat the first of the slice before."""
            if n < 0:
                return pad(slices[z - 1][0] if z > 0 else [0] * width)
            return pad(slices[z][min(n, len(slices[z]) - 1)])

        self.Y = pad(rows[y - 1]) if y > 0 else find(before + 1, -1)
        self.YY = pad(rows[y - 2]) if y > 1 else find(before + 1, -1)
        if not slices:
            self.Z = self.ZM = self.ZP = self.ZMM = self.ZPP = self.Y
            self.ZZ = self.ZZM = self.ZZP = self.Y
            return
        self.Z, self.ZM, self.ZP, self.ZMM, self.ZPP = (
            find(before, y + n) for n in (0, -1, 1, -2, 2))
        second = max(before - 1, 0)
        self.ZZ, self.ZZM, self.ZZP = (find(second, y + n) for n in (0, -1, 1))

    def are_quiet(self, x, sign):
        """Whether the bits that matter for runs all are `sign`, but for those of the row itself."""
        five = [sign] * 5
        return (self.Y[x:x + 5] == five and self.Z[x:x + 5] == five
                and self.ZM[x + 1:x + 4] == five[:3] and self.ZP[x + 1:x + 4] == five[:3]
                and self.YY[x + 2] == self.ZMM[x + 2] == self.ZPP[x + 2] == self.ZZ[x + 2] == sign)


def pad(row):
    return [row[0]] * 2 + row + [row[-1]] * 2


def window(row, x, a, b, flip):
    """Bits x + a ... x + b of a row as a number, lowest first, each XORed with `flip`."""
    bits = 0
    for n in range(b, a - 1, -1):
        bits = bits << 1 | (row[x + n + 2] ^ flip)
    return bits


def find_near(rows, x, flip):
    return (window(rows.Y, x, -1, 1, flip) | window(rows.Z, x, -1, 1, flip) << 3
            | window(rows.ZM, x, -1, 1, flip) << 6 | window(rows.ZP, x, -1, 1, flip) << 9)


class Signs:
    """Decodes slices of signs; profiles differ in how a vertex outside of runs is decoded."""

    def __init__(self):
        self.quiet = AdaptiveBits.from_priors(PRIORS.quiet, 10, 1023)

    def decode_slice(self, decoder, slices, width, height):
        """The next slice, as rows of bits, behind the `slices` that there are."""
        rows = []
        for _ in range(height):
            rows.append(self._decode_row(decoder, Neighbours(slices, rows, width), not slices, width))
        return rows

    def _decode_row(self, decoder, rows, first, width):
        own = [rows.Z[2]] * 2  # like the padded rows
        while len(own) < width + 2:
            x = len(own) - 2
            sign = own[-1]
            if own[-2] == sign and rows.are_quiet(x, sign):
                self._decode_run(decoder, rows, x, width, own)
            else:
                own.append(sign ^ self.decode_vertex(decoder, rows, own, x, sign, first))
        return own[2:]

    def _decode_run(self, decoder, rows, x, width, own):
        sign, length = own[-1], 1
        while x + length < width and rows.are_quiet(x + length, sign):
            length += 1
        size = (length > 2) + (length > 8) + (length > 32)
        if self.quiet.decode(decoder, 4 * sign + size):
            own += [sign] * length
        else:
            place = decoder.uniform((length - 1).bit_length())
            own += [sign] * place + [1 - sign]


class FastSigns(Signs):
    """Of the profile fast, and of previews."""

    def __init__(self):
        super().__init__()
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, 255)

    def decode_vertex(self, decoder, rows, own, x, flip, first):
        return self.near.decode(decoder, find_near(rows, x, flip) | first << 12)


def scramble(k):
    k = k * 0x9E3779B1 & 0xffffffff
    return (k ^ k >> 15) >> 3


class MixedSigns(Signs):
    """Of the profiles default and compact."""

    def __init__(self):
        super().__init__()
        limit = 800
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, limit)
        self.tables = [AdaptiveBits(1 << 14, limit) for _ in range(5)]
        self.mixers = Mixers(PRIORS.sign_mixers)

    def decode_vertex(self, decoder, rows, own, x, flip, first):
        def at(row, a, b):
            return window(row, x, a, b, flip)

        near = find_near(rows, x, flip)
        own2 = own[x] ^ flip  # the one at x - 2
        YY, ZZ, ZMM, ZPP = rows.YY, rows.ZZ, rows.ZMM, rows.ZPP
        out = (own2 | at(YY, 0, 0) << 1 | at(ZZ, 0, 0) << 2 | at(rows.Y, -2, -2) << 3
               | at(rows.Y, 2, 2) << 4 | at(rows.Z, -2, -2) << 5 | at(rows.Z, 2, 2) << 6)
        core = at(rows.Y, 0, 1) | at(rows.Z, 0, 1) << 2 | at(rows.ZP, 0, 0) << 4
        h0 = scramble(near | out << 12)
        h1 = scramble((near | out << 12) ^ (
            at(ZMM, 0, 0) << 20 | at(ZPP, 0, 0) << 21 | at(YY, -1, -1) << 22 | at(YY, 1, 1) << 23
            | at(ZZ, -1, -1) << 24 | at(ZZ, 1, 1) << 25 | 1 << 30))
        far = sum(at(row, -2, 2).bit_count() for row in (YY, ZZ, ZMM, ZPP))
        h2 = near.bit_count() | out.bit_count() + far << 4 | core << 9
        h3 = scramble(near | at(ZZ, -1, 1) << 12 | at(rows.ZZM, 0, 0) << 15
                      | at(rows.ZZP, 0, 0) << 16 | at(YY, -1, 1) << 17 | own2 << 20 | 1 << 31)
        h4 = scramble(core | out << 5 | at(ZMM, -1, 1) << 12 | at(ZPP, -1, 1) << 15
                      | at(YY, -1, 1) << 18 | flip << 21 | 3 << 30)
        voters = [(self.near, near | first << 12)]
        voters += [(table, h & 0x3fff) for table, h in zip(self.tables, (h0, h1, h2, h3, h4))]
        return self.mixers.decode(decoder, core | own2 << 5 | first << 6, voters)
