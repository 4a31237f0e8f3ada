# SPDX-License-Identifier: BSD-3-Clause
"""Decodes the values at the ends of crossed edges: edge-index.md, section "Values"."""
import bisect
import math
import struct

from edge_index_coding import (PRIORS, clamp, decode_on_both_sides, decode_signed, divide, measure)
from read_blocked_volume import TYPES, make_threshold_key

HEIGHT_LIMIT = 4095
GREATEST_FLOAT32 = (2 - 2**-23) * 2.0**127


def find_threshold(isovalue, type_name):
    """The least value of the type that is >= isovalue; there is one where there are blocks."""
    key = make_threshold_key(isovalue, type_name)
    _, signed, bits = TYPES[type_name]
    if signed is not None:
        return key - 1 - (1 << (bits - 1) if signed else 0)
    return code_to_float(key - (1 << (bits - 1)), bits)


def code_to_float(code, bits):
    """The float of a signed code, by which floats are in their order."""
    raw = code if code >= 0 else code ^ ((1 << (bits - 1)) - 1)
    if bits == 32:
        return struct.unpack("<f", struct.pack("<i", raw))[0]
    return struct.unpack("<d", struct.pack("<q", raw))[0]


def float_to_code(value, bits):
    packed = struct.pack("<f" if bits == 32 else "<d", value)
    raw = struct.unpack("<i" if bits == 32 else "<q", packed)[0]
    return raw if raw >= 0 else raw ^ ((1 << (bits - 1)) - 1)


def round_to_float32(value):
    """To the nearest; a Python float is a float64."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def wrap(number, bits):
    """A number modulo 2^bits, as a signed one."""
    half = 1 << (bits - 1)
    return (number + half) % (1 << bits) - half


class Offsets:
    """Codes that count from the threshold: integers of up to 32 bits."""

    def __init__(self, type_name, isovalue, scale):
        _, signed, bits = TYPES[type_name]
        self.threshold = find_threshold(isovalue, type_name)
        least = -(1 << (bits - 1)) if signed else 0
        self.set_bounds(least - self.threshold, least + (1 << bits) - 1 - self.threshold, scale)

    def set_bounds(self, least, greatest, scale):
        self.bounds = ((least, -1), (0, greatest))
        self.scale = scale

    def find_height(self, code):
        height = 2 * code + 1
        if self.scale >= 1:
            height <<= self.scale - 1
        else:
            height >>= 1 - self.scale
        return clamp(height, -HEIGHT_LIMIT, HEIGHT_LIMIT)

    def guess(self, height, inside):
        """The code of a predicted height, its quarter, and the room of twice the lesser side."""
        code = height >> self.scale if self.scale >= 0 else height << -self.scale
        if self.scale >= 2:
            quarter = height >> (self.scale - 2) & 3
        else:
            quarter = 2 * height & 3 if self.scale == 1 else 0
        least, greatest = self.bounds[inside]
        code = clamp(code, least, greatest)
        return code, quarter, 2 * min(code - least, greatest - code)

    def decode(self, magnitude, code, quarter, inside):
        return decode_on_both_sides(magnitude, code, *self.bounds[inside], quarter < 2)

    def find_value(self, code):
        return code + self.threshold


class QuantizedOffsets(Offsets):
    """Codes that count quantization steps from the first one that is inside."""

    def __init__(self, header, isovalue, scale):
        self.threshold = find_threshold(isovalue, "float32")
        self.minimum = header.quantization_minimum
        steps = 2**header.quantization_bits - 1
        self.step = (header.quantization_maximum - self.minimum) / steps
        self.first = bisect.bisect_left(range(steps + 1), self.threshold, key=self.find_level)
        least = min(-1, -self.first)
        self.nan = least - 1 if TYPES[header.type_name][1] is None else None
        self.set_bounds(least if self.nan is None else self.nan, max(0, steps - self.first), scale)

    def find_level(self, q):
        value = self.minimum + q * self.step
        return round_to_float32(clamp(value, -GREATEST_FLOAT32, GREATEST_FLOAT32))

    def find_value(self, code):
        if code == self.nan:
            return math.nan
        value = self.find_level(self.first + code)
        if code >= 0:
            return max(value, self.threshold)
        below = code_to_float(float_to_code(self.threshold, 32) - 1, 32)
        return min(value, below)


class Bits:
    """Codes that are the bits of a value: floats, and integers of 64 bits."""

    def __init__(self, type_name, isovalue, scale):
        self.type_name = type_name
        _, self.signed, self.bits = TYPES[type_name]
        exponent = 1025 if math.isinf(isovalue) else math.frexp(isovalue)[1]
        self.fraction = min(8, 60 - exponent - scale) if isovalue != 0 else 8
        self.scale = scale
        self.isovalue = self.find_fixed(isovalue)

    def find_fixed(self, value):
        """In units of 2^-(scale + fraction), rounded towards zero."""
        if isinstance(value, float) and math.isinf(value):
            infinity = 2**(128 if self.bits == 32 else 1024)
            value = infinity if value > 0 else -infinity
        numerator, denominator = value.as_integer_ratio()
        shift = self.scale + self.fraction
        if shift >= 0:
            fixed = divide(numerator << shift, denominator)
        else:
            fixed = divide(numerator, denominator << -shift)
        return clamp(fixed, -2**62, 2**62)

    def find_height(self, code):
        value = self.find_value(code)
        if isinstance(value, float) and math.isnan(value):
            return 0
        height = self.find_fixed(value) - self.isovalue
        if self.fraction >= 0:
            height >>= self.fraction
        else:
            height <<= min(-self.fraction, 12)
        return clamp(height, -HEIGHT_LIMIT, HEIGHT_LIMIT)

    def guess(self, height, inside):
        if self.fraction >= 1:
            fixed = self.isovalue + ((2 * height + 1) << (self.fraction - 1))
        else:
            fixed = self.isovalue + ((2 * height + 1) >> (1 - self.fraction))
        shift = self.scale + self.fraction
        numerator, denominator = (fixed, 1 << shift) if shift >= 0 else (fixed << -shift, 1)
        if self.signed is None:
            value = round_towards_zero(numerator, denominator, self.bits)
            return float_to_code(value, self.bits), 0, 2**64 - 1
        least, greatest = (1 - 2**63, 2**63 - 1) if self.signed else (0, 2**64 - 1)
        return clamp(divide(numerator, denominator), least, greatest), 0, 2**64 - 1

    def decode(self, magnitude, code, quarter, inside):
        return wrap(code + decode_signed(magnitude), self.bits)

    def find_value(self, code):
        if self.signed is None:
            return code_to_float(code, self.bits)
        return code if self.signed else code % 2**64


def round_towards_zero(numerator, denominator, bits):
    """A fraction as a float32 or float64 not further from zero, at most the greatest."""
    digits, least_exponent, infinite = (24, -149, 128) if bits == 32 else (53, -1074, 1024)
    magnitude = abs(numerator)
    exponent = max(magnitude.bit_length() - denominator.bit_length() - digits - 1, least_exponent)
    shifted = (magnitude << -exponent) // denominator if exponent < 0 else magnitude // (
        denominator << exponent)
    excess = max(0, shifted.bit_length() - digits)
    shifted, exponent = shifted >> excess, exponent + excess
    if shifted.bit_length() + exponent > infinite:
        shifted, exponent = 2**digits - 1, infinite - digits
    value = math.ldexp(shifted, exponent)
    return -value if numerator < 0 else value


def make_domain(header, isovalue, scale):
    if header.mode == "quantized":
        return QuantizedOffsets(header, isovalue, scale)
    _, signed, bits = TYPES[header.type_name]
    kind = Offsets if signed is not None and bits <= 32 else Bits
    return kind(header.type_name, isovalue, scale)


def begin_heights(block, z, height):
    """The heights of a slice, two more on each side included: (x, y) is at [y + 2][x + 2]."""
    return [[height if block.is_inside(x, y, z) else -height
             for x in range(-2, block.nx + 2)] for y in range(-2, block.ny + 2)]


# Neighbours whose heights are inputs of a prediction: the steps back in z, and those in y and x.
INPUT_STEPS = ((0, 0, -1), (0, -1, 0), (1, 0, 0), (0, -1, -1), (0, -1, 1), (1, 0, -1), (1, 0, 1),
               (1, -1, 0), (1, 1, 0), (1, -1, 1), (1, 1, -1), (0, 0, -2), (0, -2, 0), (2, 0, 0))


class FilterPrediction:
    """One linear function that learns by least mean squares."""

    def __init__(self):
        self.weights = list(PRIORS.weights)

    def begin_slice(self, mean):
        least = max(mean >> 6, 8)
        self.rate = (16777 << 16) // (3 * least * least // 2)

    def begin_row(self):
        self.weights = [clamp(w, -2**27, 2**27) for w in self.weights]

    def predict(self, inputs):
        total = sum(x * clamp(w >> 12, -2**15, 2**15 - 1) for x, w in zip(inputs, self.weights))
        return total >> 13

    def learn(self, inputs, prediction, height):
        error = clamp(height - prediction, -8191, 8191)
        update = clamp(error * self.rate >> 8, -32767, 32767)
        self.weights = [w + (x * update >> 8) for x, w in zip(inputs, self.weights)]

    def find_inputs(self, block, heights, x, y, z, mean):
        """The 16 inputs; `heights` are the slice's, the one's before and of the one before that."""
        inputs = [heights[dz][y + dy + 2][x + dx + 2] for dz, dy, dx in INPUT_STEPS]
        inputs.append(mean >> 6 if block.is_inside(x, y, z) else -(mean >> 6))
        crossed = block.begin_bits(x, y, z).bit_count()
        inputs.append(divide(-3 * crossed * inputs[-1], 10))
        return inputs


class Measures:
    """The measure that came last at each place (x, y) of any slice, `begin` where none came."""

    def __init__(self, begin):
        self.begin = begin
        self.last = {}

    def at(self, x, y):
        return self.last.get((x, y), self.begin)

    def expect(self, x, y):
        return (4 * (self.at(x - 1, y) + self.at(x, y - 1) + self.at(x, y))
                + 2 * (self.at(x - 1, y - 1) + self.at(x + 1, y - 1)) + 8) >> 4

    def add(self, x, y, found):
        self.last[x, y] = found


class Values:
    """Decodes the values of a block."""

    def __init__(self, domain, magnitudes):
        self.domain, self.magnitudes, self.prediction = domain, magnitudes, FilterPrediction()
        self.mean = 700 * 64  # M of the text
        self.measures = Measures(24)
        self.heights = []  # of this slice, the one before and the one before that

    def decode_slice(self, decoder, block, z):
        """The values of the relevant vertices of slice z, by (x, y)."""
        zeros = [[0] * (block.nx + 4)] * (block.ny + 4)
        before = self.heights[:2] if z > 0 else [zeros, zeros]
        begin = min(3 * (self.mean >> 6) // 2, HEIGHT_LIMIT)
        self.heights = [begin_heights(block, z, begin)] + before
        self.prediction.begin_slice(self.mean)
        visited = self._find_visited(block, z)
        values = {}
        for y in range(block.ny):
            self.prediction.begin_row()
            for x in range(block.nx):
                if block.is_relevant(x, y, z):
                    values[x, y] = self._decode_value(decoder, block, x, y, z)
                elif (x, y) in visited:
                    self._visit(block, x, y, z)
        return values

    def _find_visited(self, block, z):
        """The vertices that get a predicted height, some of them a value too."""
        places = [(x, y) for y in range(block.ny) for x in range(block.nx)]
        near = {(x, y) for x, y in places if block.is_relevant(x, y, z)}
        if not near:
            return ()
        near.update((x, y) for x, y in places if block.is_relevant_within(x, y, z + 1))
        return {(x + dx, y + dy) for x, y in near for dx in (-1, 0, 1) for dy in (-1, 0, 1)}

    def _visit(self, block, x, y, z):
        inputs = self.prediction.find_inputs(block, self.heights, x, y, z, self.mean)
        height, t = self.prediction.predict(inputs), self.mean >> 6
        if block.is_inside(x, y, z):
            height = clamp(height, 3 * t // 10, min(6 * t, HEIGHT_LIMIT))
        else:
            height = -clamp(-height, 3 * t // 10, min(6 * t, HEIGHT_LIMIT))
        self.heights[0][y + 2][x + 2] = height

    def _decode_value(self, decoder, block, x, y, z):
        inside = block.is_inside(x, y, z)
        inputs = self.prediction.find_inputs(block, self.heights, x, y, z, self.mean)
        predicted = self.prediction.predict(inputs)
        guess, quarter, room = self.domain.guess(predicted, inside)
        expected = self.measures.expect(x, y)
        nearness = clamp(divide(measure(room) - expected + 12, 6), 0, 7)
        sides = [nearness | quarter << 3] + self._find_sides(block, x, y, z, expected, predicted)
        if inside:
            sides = [side + 64 for side in sides]
        magnitude = self.magnitudes.decode(decoder, expected, sides)
        code = self.domain.decode(magnitude, guess, quarter, inside)
        self.measures.add(x, y, measure(magnitude))
        height = self.domain.find_height(code)
        self.heights[0][y + 2][x + 2] = height
        self.prediction.learn(inputs, predicted, height)
        self.mean += 64 * abs(height) - self.mean >> 10
        return self.domain.find_value(code)

    def _find_sides(self, block, x, y, z, expected, predicted):
        own, before = self.heights[0], self.heights[1]
        left, above, behind = own[y + 2][x + 1], own[y + 1][x + 2], before[y + 2][x + 2]
        begins = block.begin_bits(x, y, z)
        last = [clamp(self.measures.at(*place) - expected + 12 >> 3, 0, 3)
                for place in ((x - 1, y), (x, y - 1), (x, y))]
        change = measure(abs(left - before[y + 2][x + 1]) + abs(above - before[y + 1][x + 2]))
        steepness = clamp(divide(change - measure(self.mean >> 6) + 36, 6), 0, 15)
        unit = max(self.mean >> 8, 1)
        slopes = [clamp(divide(height - predicted, unit) + 2, 0, 3)
                  for height in (left, above, behind)]
        return [(begins | block.end_bits(x, y, z) << 3),
                (last[0] | last[1] << 2 | last[2] << 4),
                (steepness | begins.bit_count() << 4),
                (slopes[0] | slopes[1] << 2 | slopes[2] << 4)]
