# SPDX-License-Identifier: BSD-3-Clause
"""Decodes crossings of the profile compact: edge-index.md, "Crossings of the profile compact"."""
import math

from edge_index_coding import (SQUASH, STRETCH, MagnitudePriors, MixedMagnitudes, clamp,
                               decode_on_both_sides, divide, measure, read_tables)
from edge_index_crossings import (UNIT, Crossings, PlanePrediction, list_terms, measure_error)
from edge_index_values import Measures, factor, substitute_back

PRIORS = MagnitudePriors(read_tables("curved-crossings.txt"), "CurvedCrossing")
TARGET = 2868  # of vertices: of those inside; of those outside negative
MIDDLE = 1 << 15


class WideIntervals:
    """An edge that is cut into intervals of a width, the last of which ends with the edge."""

    def __init__(self, width):
        self.width = width  # in units of 2^-30
        self.count = -(-2**30 // width)

    def find_place(self, position):
        return position * (2**46 // self.width) >> 16

    def _sum_ends(self, interval):
        return interval * self.width + min((interval + 1) * self.width, 2**30)

    def find_position(self, interval):
        return self._sum_ends(interval) >> 21

    def find_interval(self, t):
        return math.floor(clamp(t * 2.0**30 / self.width, 0, self.count - 1))

    def find_parameter(self, interval):
        return self._sum_ends(interval) / 2**31


def step_to_zero(q, height, slope):
    """N of the text: a step of Newton's method."""
    return clamp(q - divide(height << 16, slope), -MIDDLE, MIDDLE)


def fit(block, decoded, vertex, axis):
    """The predictions linear and quadratic, steepness, and the number of crossings used."""
    sums = [[0] * (i + 1) for i in range(11)]
    used = 0
    for weight, side, (x, y, z), is_decoded in list_terms(block, decoded, vertex, axis):
        used += is_decoded
        row = (1024, x, y, z, x * x >> 10, y * y >> 10, z * z >> 10,
               x * y >> 10, x * z >> 10, y * z >> 10, side * TARGET)
        for i, a in enumerate(row):
            a *= weight
            for j in range(i + 1):
                sums[i][j] += a * row[j]
    for i in range(10):
        sums[i][i] += (4 if i < 4 else 41) << 20
    factors = factor(sums)
    if not factors:
        return MIDDLE, MIDDLE, 0, used
    flat, c = substitute_back(*factors, 4), substitute_back(*factors, 10)
    sigma = -1 if block.is_inside(*vertex) else 1
    linear = MIDDLE + step_to_zero(0, sigma * flat[0], max(sigma * flat[1 + axis], 5243))
    height, m, n = sigma * c[0], sigma * c[1 + axis], sigma * c[4 + axis]
    q = step_to_zero(0, height, max(m, 5243))
    for _ in range(3):
        q = step_to_zero(q, height + (q * (m + (n * q >> 16)) >> 16),
                         max(m + (2 * n * q >> 16), 13107))
    own, whole = 8 * max(m, 5243)**2, 1 + sum(slope * slope for slope in c[1:4])
    return linear, MIDDLE + q, sum(own >= j * whole for j in range(1, 8)), used


def list_cycles(axis):
    """Paths from an edge's first vertex to its second: lists of (edge, whether walked forward)."""
    if axis == 0:
        between = [((0, -1, 0), (1, -1, 0)), ((0, 0, -1), (1, 0, -1)),
                   ((0, -1, 0), (0, -1, -1), (1, -1, -1), (1, 0, -1)),
                   ((0, 0, -1), (0, -1, -1), (1, -1, -1), (1, -1, 0))]
    elif axis == 1:
        between = [((0, 0, -1), (0, 1, -1))]
        between += [((s, 0, 0), (s, 0, -1), (s, 1, -1), (0, 1, -1)) for s in (-1, 1)]
    else:
        between = []
    paths = []
    for inner in between:
        vertices = ((0, 0, 0), *inner, tuple(int(n == axis) for n in range(3)))
        paths.append([])
        for first, last in zip(vertices, vertices[1:]):
            along = next(n for n in range(3) if first[n] != last[n])
            forward = last[along] > first[along]
            paths[-1].append(((*(first if forward else last), along), forward))
    return paths


CYCLES = [list_cycles(axis) for axis in range(3)]


def spread(t):
    return t * (1024 - t) >> 10


def follow_cycles(decoded, vertex, axis):
    """The sums of weight and of weight times crossing over the paths whose edges are decoded."""
    weights = total = 0
    for path in CYCLES[axis]:
        g = V = 0
        for (dx, dy, dz, along), forward in path:
            t = decoded.get((vertex[0] + dx, vertex[1] + dy, vertex[2] + dz, along))
            if t is None:
                break
            stretched = STRETCH[4 * t + 2]
            g += stretched if forward else -stretched
            V += 2**24 // max(spread(t), 20)**2
        else:
            crossing = SQUASH[clamp(g, -2047, 2047) + 2048]
            weight = 2**24 // ((V * spread(crossing >> 6)**2 >> 16) + 153)
            weights += weight
            total += weight * crossing
    return weights, total


class CurvedCrossings(Crossings):
    """Of the profile compact."""

    def __init__(self, cut, some_missing):
        super().__init__(cut, some_missing, MixedMagnitudes(PRIORS), None)
        # Of the errors of what is fitted, and of the two fits; of each by axis.
        self.measures = [[Measures(20) for _ in range(3)] for _ in range(3)]
        self.difference = 512  # D of the text

    def _decode_edge(self, decoder, block, vertex, axis):
        x, y, _ = vertex
        linear, quadratic, steepness, used = fit(block, self.decoded, vertex, axis)
        fitted_measure, *others = (kind[axis].expect(x, y) for kind in self.measures)
        v = 30 + 40 * (others[0] - others[1]) + (90 * self.difference >> 8)
        fitted = linear + ((quadratic - linear) * SQUASH[clamp(v, -2047, 2047) + 2048] >> 16)
        position, around, has_cycles = self._mix(vertex, axis, fitted, fitted_measure)

        place, last = self.cut.find_place(position), self.cut.count - 1
        guess = min(place >> 16, last)
        quarter = min(place - (guess << 16) >> 14, 3)
        expected = max(around - 16, 0)
        room = 2 * min(guess, last - guess)
        nearness = clamp(divide(measure(room) - expected + 12, 6), 0, 7)
        magnitude = self.magnitudes.decode(decoder, expected, (
            nearness | quarter << 3 | min(last - guess, 3) << 5,
            clamp(around // 3, 0, 15) | quarter << 4,
            steepness | axis << 3, min(position >> 12, 15) | quarter << 4,
            steepness | min(used, 7) << 3 | has_cycles << 6))
        interval = decode_on_both_sides(magnitude, guess, 0, last, quarter < 2)
        found = [measure_error(interval, self.cut.find_place(prediction))
                 for prediction in (fitted, linear, quadratic)]
        for kind, value in zip(self.measures, found):
            kind[axis].add(x, y, value)
        self.difference += divide(256 * (found[1] - found[2]) - self.difference, 128)
        return interval

    def _mix(self, vertex, axis, fitted, fitted_measure):
        """The position, its expected measure, and whether cycles tell of it."""
        weights, total = follow_cycles(self.decoded, vertex, axis)
        if weights == 0:
            return fitted, fitted_measure, False
        error = 61 + (128 + 32 * (fitted_measure % 4) << min(fitted_measure // 4, 30))
        own = max(2**30 // error, 1)
        whole = own + 64 * weights
        position = (fitted * own + 64 * weights * (total // weights)) // whole
        gain = measure(whole) - measure(own)
        return position, max(0, fitted_measure - gain // 2), True
