# SPDX-License-Identifier: BSD-3-Clause
"""Range decoder, adaptive probabilities and magnitudes of edge-index files.

A second implementation of edge-index.md, sections "Range coder", "Probabilities" and "Magnitudes".
Tables are read from the data files that this text names.
"""
import math
import os
import re
from operator import mul

from read_interval_tree import check

_TABLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../Core/Coding/TrainedModels")


def clamp(x, a, b):
    return a if x < a else b if x > b else x


def divide(a, b):
    """a / b, rounded towards zero; b > 0."""
    return a // b if a >= 0 else -(-a // b)


def read_tables(name):
    """The tables of a data file by name."""
    with open(os.path.join(_TABLES, name), encoding="utf-8") as file:
        words = iter(re.sub(r"#[^\n]*", "", file.read()).split())
    tables = {}
    for table in words:
        next(words)  # the type, which C++ needs
        tables[table] = [int(next(words)) for _ in range(int(next(words)))]
    return tables


class RangeDecoder:
    """Keeps (code - low) of the encoder's interval [low, low + range)."""

    def __init__(self, data):
        self.data = data
        self.position = 8
        self.offset = int.from_bytes(data[:8].ljust(8, b"\0"), "big")
        self.range = 2**64 - 1

    def _narrow(self, begin, width):
        self.offset -= begin
        self.range = width
        if width < 2**32:
            piece = self.data[self.position:self.position + 4].ljust(4, b"\0")
            self.offset = (self.offset << 32 | int.from_bytes(piece, "big")) & (2**64 - 1)
            self.range = width << 32
            self.position += 4

    def bit(self, probability):
        """A decision whose probability of 1 is probability / 2^16."""
        bound = (self.range >> 16) * probability
        if self.offset < bound:
            self._narrow(0, bound)
            return 1
        self._narrow(bound, self.range - bound)
        return 0

    def uniform(self, bits):
        """At most 16 bits, each as likely as the other."""
        width = self.range >> bits
        value = min(self.offset // width, (1 << bits) - 1)
        self._narrow(width * value, width)
        return value

    def digits(self, count):
        """Any number of binary digits, highest first."""
        value = 0
        while count > 0:
            taken = min(count, 16)
            value = value << taken | self.uniform(taken)
            count -= taken
        return value

    def symbol(self, shares):
        """A symbol of 16, whose cumulative shares are 17 numbers from 0 to 2^15."""
        unit = self.range >> 15
        symbol = 15
        while unit * shares[symbol] > self.offset:
            symbol -= 1
        self._narrow(unit * shares[symbol], unit * (shares[symbol + 1] - shares[symbol]))
        return symbol

    def check_end(self):
        """The data must end where the code does: an encoder ends with 1 to 8 bytes."""
        check(len(self.data) <= self.position <= len(self.data) + 8, "the code has another length")


def _make_squash():
    curve = [round(32768 / (1 + math.exp(8 - n / 4))) for n in range(65)]
    return [(curve[n // 64] * (64 - n % 64) + curve[n // 64 + 1] * (n % 64)) // 32
            for n in range(4096)]


def _make_stretch():
    x, table = -2047, []
    for n in range(4096):
        while x < 2047 and SQUASH[x + 2048] < 16 * n + 8:
            x += 1
        table.append(x)
    return table


SQUASH = _make_squash()    # S(x) at x + 2048
STRETCH = _make_stretch()  # T(n)
RATES = [655360 // (10 * k + 16) for k in range(1024)]


class AdaptiveBits:
    """A table of adaptive bits: probabilities of 22 bits, and counts."""

    def __init__(self, size, limit):
        self.probabilities = [1 << 21] * size
        self.counts = [0] * size
        self.limit = limit

    @classmethod
    def from_priors(cls, probabilities, count, limit):
        bits = cls(0, limit)
        bits.probabilities = list(probabilities)
        bits.counts = [count] * len(probabilities)
        return bits

    def learn(self, index, bit):
        probability, count = self.probabilities[index], self.counts[index]
        target = 2**22 - 1 if bit else 0
        self.probabilities[index] = probability + ((target - probability) * RATES[count] >> 16)
        if count < self.limit:
            self.counts[index] = count + 1

    def decode(self, decoder, index):
        bit = decoder.bit(clamp(self.probabilities[index] >> 6, 24, 65512))
        self.learn(index, bit)
        return bit


class Mixers:
    """Mixed bits: several adaptive bits vote, with weights that are learnt."""

    def __init__(self, weights):
        self.weights = [list(weights[n:n + 8]) for n in range(0, len(weights), 8)]

    def decode(self, decoder, mixer, voters):
        """`voters` are pairs of a table of adaptive bits and an index."""
        weights = self.weights[mixer]
        inputs = [STRETCH[table.probabilities[index] >> 10] for table, index in voters]
        inputs += [0] * (7 - len(inputs)) + [256]
        vote = sum(map(mul, inputs, weights)) >> 14
        probability = SQUASH[clamp(vote, -2047, 2047) + 2048]
        bit = decoder.bit(probability)
        error = ((65535 if bit else 0) - probability) >> 1
        self.weights[mixer] = [clamp(w + (x * error + 2**15 >> 16), -2**15, 2**15 - 1)
                               for x, w in zip(inputs, weights)]
        for table, index in voters:
            table.learn(index, bit)
        return bit


class AdaptiveSymbols:
    """A table of adaptive symbols of 16, by their cumulative shares."""

    def __init__(self, priors):
        self.shares = [list(priors[n:n + 16]) + [2**15] for n in range(0, len(priors), 16)]

    def decode(self, decoder, index):
        shares = self.shares[index]
        symbol = decoder.symbol(shares)
        for n in range(1, 16):
            target = 8 * n + (2**15 - 128 if n > symbol else 0)
            shares[n] += target - shares[n] >> 5
        return symbol


def find_probabilities(stretched):
    """Of priors, which are stored stretched."""
    return [SQUASH[16 * q + 2048] * 64 for q in stretched]


class MagnitudePriors:
    """What magnitudes begin with; values have no symbols, since previews have no values."""

    def __init__(self, tables, kind):
        levels = tables[kind + "Levels"]
        check(len(levels) == 512, f"{kind}Levels: another size")
        self.by_level = find_probabilities(levels)
        self.symbols = tables.get(kind + "Symbols")
        self.mixers = tables[kind + "Mixers"]
        # By class / 2 and side: those of the even class.
        self.by_side = [probability for level in range(0, 32, 2) for _ in range(128)
                        for probability in self.by_level[16 * level:16 * level + 16]]


class Priors:
    """What all blocks begin with."""

    def __init__(self):
        tables = read_tables("priors.txt")
        self.near = find_probabilities(tables["NearSignPriors"])
        self.quiet = find_probabilities(tables["QuietSignPriors"])
        self.sign_mixers = tables["SignMixers"]
        self.values = MagnitudePriors(tables, "Value")
        self.crossings = MagnitudePriors(tables, "Crossing")
        self.weights = tables["ValueWeights"]


PRIORS = Priors()


def measure(magnitude):
    """Eight times the binary logarithm of magnitude + 1, about."""
    n = min(magnitude, 2**62 - 1) + 1
    k = n.bit_length() - 1
    return 8 * k + ((n << 3 >> k) & 7)


# The ranges that a symbol tells: where they begin, and how many lower bits follow.
_RANGE_BEGINS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 28, 44, 76)
_RANGE_BITS = (0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 3, 4, 5)


class Magnitudes:
    """What both profiles share; they differ in how a symbol is decoded."""

    def __init__(self):
        self.escape = AdaptiveBits(64, 255)

    def decode(self, decoder, expected, sides):
        low = max(0, (expected >> 3) - 2)
        if low == 0:
            level = min(expected // 2, 11)
        else:
            level = 12 + expected % 8 // 2 + 4 * min(low - 1, 4)
        symbol = self.decode_symbol(decoder, level, sides)
        if symbol < 15:
            return (_RANGE_BEGINS[symbol] << low) + decoder.digits(_RANGE_BITS[symbol] + low)
        digits = 0
        while digits < 63 and self.escape.decode(decoder, digits):
            digits += 1
        rest = (1 << digits | decoder.digits(digits)) - 1 + _RANGE_BEGINS[15]
        return rest << low | decoder.digits(low)


class PreviewMagnitudes(Magnitudes):
    """Of previews, and of attributes."""

    def __init__(self, priors):
        super().__init__()
        self.symbols = AdaptiveSymbols(priors.symbols)

    def decode_symbol(self, decoder, level, sides):
        return self.symbols.decode(decoder, 8 * level + sides[0] % 8)


class MixedMagnitudes(Magnitudes):
    """Of the profile small."""

    def __init__(self, priors):
        super().__init__()
        limit = 250
        self.by_level = AdaptiveBits.from_priors(priors.by_level, 8, limit)
        self.by_side = [AdaptiveBits.from_priors(priors.by_side, 2, limit) for _ in range(5)]
        self.mixers = Mixers(priors.mixers)

    def decode_symbol(self, decoder, level, sides):
        begins = [(128 * (level // 2) + side) * 16 for side in sides]
        node = 1
        while node < 16:
            voters = [(self.by_level, 16 * level + node)]
            voters += [(table, begin + node) for table, begin in zip(self.by_side, begins)]
            node = 2 * node + self.mixers.decode(decoder, 16 * min(level // 5, 3) + node, voters)
        return node - 16


def decode_on_both_sides(magnitude, guess, least, greatest, below_first):
    """The number whose difference from `guess`, within its bounds, a magnitude tells."""
    room = min(guess - least, greatest - guess)
    if magnitude > 2 * room:
        distance = magnitude - room
        return guess + (distance if guess - least < greatest - guess else -distance)
    distance = (magnitude + 1) // 2
    return guess - distance if (magnitude % 2 == 1) == below_first else guess + distance


def decode_signed(magnitude):
    """The number d that is stored as 2 d, or as -2 d - 1 if negative."""
    return -(magnitude >> 1) - 1 if magnitude & 1 else magnitude >> 1
