# SPDX-License-Identifier: BSD-3-Clause
"""Decodes on which side of the isovalue vertices lie: edge-index.md, section "Signs"."""
from operator import mul

from edge_index_coding import (PRIORS, SQUASH, STRETCH, AdaptiveBits, Mixers, clamp,
                               read_tables)
from read_interval_tree import check

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

        self.Y, self.YY, self.YYY = (find(present, y - n) for n in (1, 2, 3))
        if present == 0:
            self.Z = self.ZM = self.ZP = self.ZMM = self.ZPP = self.ZMMM = self.ZPPP = self.Y
            self.ZZ = self.ZZM = self.ZZP = self.ZZMM = self.ZZPP = self.Y
            return
        self.Z, self.ZM, self.ZP, self.ZMM, self.ZPP, self.ZMMM, self.ZPPP = (
            find(present - 1, y + n) for n in (0, -1, 1, -2, 2, -3, 3))
        second = max(present - 2, 0)
        self.ZZ, self.ZZM, self.ZZP, self.ZZMM, self.ZZPP = (
            find(second, y + n) for n in (0, -1, 1, -2, 2))

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
    """Decodes slices of signs; profiles differ in how a vertex outside of runs is decoded."""

    def __init__(self):
        self.quiet = AdaptiveBits.from_priors(PRIORS.quiet, 10, 1023)
        self.slices = []

    def decode_slice(self, decoder, width, height):
        """The next slice, as rows of bits."""
        rows = []
        self.slices.append([])  # packed
        for y in range(height):
            rows.append(self._decode_row(
                decoder, Neighbours(self.slices), (len(self.slices) - 1, y), (width, height)))
            self.slices[-1].append(pack(rows[-1]))
        return rows

    def _decode_row(self, decoder, rows, place, size):
        """`place` is (z, y) of the row, `size` (width, height) of the slice."""
        width = size[0]
        own = [rows.Z >> MARGIN & 1] * MARGIN  # what lies left of it; vertices follow
        while len(own) < width + MARGIN:
            x = len(own) - MARGIN
            sign = own[-1]
            if own[-2] == sign and rows.are_quiet(x, sign):
                self._decode_run(decoder, rows, x, width, own)
            else:
                own.append(sign ^ self.decode_vertex(decoder, rows, own, (x, *place), size))
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


class FastSigns(Signs):
    """Of the profile fast, and of previews."""

    def __init__(self):
        super().__init__()
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, 255)

    def decode_vertex(self, decoder, rows, own, place, size):
        x, z, _ = place
        return self.near.decode(decoder, find_near(rows, x, own[-1]) | (z == 0) << 12)


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
    """Of the profile default."""

    def __init__(self):
        super().__init__()
        limit = 800
        self.near = AdaptiveBits.from_priors(PRIORS.near, 10, limit)
        self.tables = [AdaptiveBits(1 << 14, limit) for _ in range(5)]
        self.mixers = Mixers(PRIORS.sign_mixers)

    def decode_vertex(self, decoder, rows, own, place, size):
        x, z, _ = place
        flip, first = own[-1], int(z == 0)

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


class Network:
    """The network: 91 bits become 16 numbers, and those a stretched probability."""

    def __init__(self):
        tables = read_tables("sign-network.txt")

        def cut(table, width):
            numbers = tables["SignNetwork" + table]
            return [numbers[n:n + width] for n in range(0, len(numbers), width)]

        *self.A, self.A_always = cut("First", 64)
        self.B = cut("Second", 64)
        (self.b,), (self.C,), ((self.c,),) = (
            cut("SecondAdded", 16), cut("Third", 16), cut("ThirdAdded", 1))
        check(len(self.A) == 91 and len(self.B) == 16, "sign-network.txt: other tables")

    def apply(self, bits):
        """h and o of the text."""
        active = [row for row, bit in zip(self.A, bits) if bit]
        a = [clamp(total, 0, 2047) for total in map(sum, zip(self.A_always, *active))]
        h = [clamp(b + sum(map(mul, a, row)) >> 10, 0, 2047) for b, row in zip(self.b, self.B)]
        return h, clamp(self.c + sum(map(mul, h, self.C)) >> 10, -2047, 2047)


NETWORK = Network()


def scramble_two(low, high):
    k = (low * 0x9E3779B1 ^ high) * 0x85EBCA6B & 0xffffffff
    return ((k ^ k >> 15) >> 3) & 0x3fff


class WideMixers:
    """Mixers of 32 inputs, in the order: h, d, o and constants."""

    def __init__(self, count):
        self.weights = [[0] * 16 + [1638] * 8 + [1 << 14] + [0] * 7 for _ in range(count)]

    def vote(self, mixer, inputs):
        return clamp(sum(map(mul, inputs, self.weights[mixer])) >> 14, -2047, 2047)

    def learn(self, mixer, inputs, vote, bit):
        error = ((65535 if bit else 0) - SQUASH[vote + 2048]) >> 1
        self.weights[mixer] = [clamp(w + (v * error + 2**14 >> 15), -32767, 32767)
                               for v, w in zip(inputs, self.weights[mixer])]


class NetworkSigns(Signs):
    """Of the profile compact."""

    def __init__(self):
        super().__init__()
        self.tables = [AdaptiveBits(1 << 14, 200) for _ in range(8)]
        self.mixers = [WideMixers(count) for count in (256, 32, 32, 64)]
        self.cost = 1 << 20  # M of the text

    def decode_vertex(self, decoder, rows, own, place, size):
        h, o = NETWORK.apply(self._list_bits(rows, own, place, size))
        core, indices = self._find_contexts(rows, own, place[0], o)
        differences = []
        for table, index in zip(self.tables, indices):
            k = table.counts[index]
            if k == 0:
                table.probabilities[index] = 64 * SQUASH[o + 2048]
                differences.append(0)
            else:
                stretched = STRETCH[table.probabilities[index] >> 10]
                differences.append(
                    clamp((stretched - o) * (8192 * k // (2 * k + 3)) >> 12, -2047, 2047))
        inputs = [n >> 1 for n in h] + differences + [o, 64] + [0] * 6
        x, flip = place[0], own[-1]
        far = (window(rows.ZZ, x, -2, 2, flip),
               window(rows.ZZM, x, -1, 1, flip) | window(rows.ZZP, x, -1, 1, flip) << 3)
        used = list(zip(self.mixers, (min(self.cost >> 18, 7) << 5 | core, o + 2048 >> 7, *far)))
        votes = [mixers.vote(mixer, inputs) for mixers, mixer in used]
        probability = SQUASH[(sum(votes) >> 2) + 2048]
        bit = decoder.bit(probability)
        for (mixers, mixer), vote in zip(used, votes):
            mixers.learn(mixer, inputs, vote, bit)
        for table, index in zip(self.tables, indices):
            table.learn(index, bit)
        self.cost += (65536 - probability if bit else probability) - (self.cost >> 7)
        return bit

    @staticmethod
    def _list_bits(rows, own, place, size):
        """The 91 inputs of the network."""
        (x, z, y), (width, height) = place, size
        flip = own[-1]
        bits = [own[-4] ^ flip, own[-3] ^ flip, own[-2] ^ flip, flip]
        bits += [x == 0, x == 1, x == width - 1]
        for reach, names in ((3, (rows.Y, rows.YY, rows.Z, rows.ZM, rows.ZP, rows.ZZ)),
                             (2, (rows.YYY, rows.ZMM, rows.ZPP, rows.ZZM, rows.ZZP)),
                             (1, (rows.ZMMM, rows.ZPPP, rows.ZZMM, rows.ZZPP))):
            for row in names:
                number = window(row, x, -reach, reach, flip)
                bits += [number >> n & 1 for n in range(2 * reach + 1)]
        return bits + [z == 0, z == 1, y == 0, y == 1, y == height - 1]

    @staticmethod
    def _find_contexts(rows, own, x, o):
        """core, and an index for each table."""
        flip = own[-1]

        def at(row, a, b):
            return window(row, x, a, b, flip)

        near, out, core, own2 = find_pattern(rows, own, x, flip)
        YY, ZZ, ZMM, ZPP = rows.YY, rows.ZZ, rows.ZMM, rows.ZPP
        step = o + 2048 >> 7
        return core, (
            near,
            scramble_two(near, out),
            scramble_two(near | out << 12,
                         at(ZMM, 0, 0) | at(ZPP, 0, 0) << 1 | at(YY, -1, -1) << 2
                         | at(YY, 1, 1) << 3 | at(ZZ, -1, -1) << 4 | at(ZZ, 1, 1) << 5 | 1 << 6),
            count_pattern(rows, x, flip, near, out, core),
            scramble_two(near, at(ZZ, -1, 1) | at(rows.ZZM, 0, 0) << 3 | at(rows.ZZP, 0, 0) << 4
                         | at(YY, -1, 1) << 5 | own2 << 8 | 1 << 9),
            scramble_two(core | out << 5, at(ZMM, -1, 1) | at(ZPP, -1, 1) << 3 | at(YY, -1, 1) << 6
                         | flip << 9 | 1 << 10),
            step << 5 | core,
            step << 4 | near.bit_count())
