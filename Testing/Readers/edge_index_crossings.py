# SPDX-License-Identifier: BSD-3-Clause
"""Decodes where crossed edges are crossed: edge-index.md, section "Crossings"."""
import math

from edge_index_coding import (AdaptiveBits, clamp, decode_on_both_sides, divide, measure)
from edge_index_values import Measures

UNIT = 1 << 10  # a voxel, in the units of positions


def middle(axis):
    """Of an edge from its first vertex, doubled so that it is whole."""
    return tuple(int(a == axis) for a in range(3))


def list_neighbours(axis, reach, steps_in_z, axes, farthest):
    """Edges near one along `axis`: (dx, dy, dz, their axis, q), q being 4 squared distances."""
    own, found = middle(axis), []
    for dz in steps_in_z:
        for dy in range(-reach, reach + 1):
            for other in axes(dz):
                for dx in range(-reach, reach + 1):
                    far = middle(other)
                    q = sum((2 * d + f - o)**2 for d, f, o in zip((dx, dy, dz), far, own))
                    if q <= farthest and (q > 0 or other != axis):
                        found.append((dx, dy, dz, other, q))
    return found


def weigh_decoded(q):
    return 320 * 4096 // (16 + 20 * q * q)


class EqualIntervals:
    """An edge that is cut into intervals of one size."""

    def __init__(self, count):
        self.count = count

    def find_place(self, position):
        """A position in units of 2^-16 edges in units of 2^-16 intervals."""
        return position * self.count

    def find_position(self, interval):
        """The middle of an interval, in units of 2^-10 edges."""
        return (2 * interval + 1) * (2**40 // self.count) >> 31

    def find_interval(self, t):
        return math.floor(clamp(t * self.count, 0, self.count - 1))

    def find_parameter(self, interval):
        return (2 * interval + 1) / (2 * self.count)


class Crossings:
    """Decodes the crossings of a block; previews differ in magnitudes and prediction."""

    def __init__(self, cut, some_missing, magnitudes, prediction):
        self.cut, self.some_missing = cut, some_missing
        self.magnitudes, self.prediction = magnitudes, prediction
        self.missing = AdaptiveBits(1, 255)
        self.measures = [Measures(20) for _ in range(3)]
        self.decoded = {}  # positions of decoded crossings by (x, y, z, axis); None: no number

    def decode_slice(self, decoder, block, z):
        """The intervals of the crossed edges of slice z by (x, y, axis); None: no number."""
        found = {}
        for x, y, axis in block.list_edges(z):
            if self.some_missing and self.missing.decode(decoder, 0):
                found[x, y, axis] = self.decoded[x, y, z, axis] = None
                continue
            interval = self._decode_edge(decoder, block, (x, y, z), axis)
            found[x, y, axis] = interval
            self.decoded[x, y, z, axis] = self.cut.find_position(interval)
        return found

    def _decode_edge(self, decoder, block, vertex, axis):
        x, y, _ = vertex
        position, steepness, used = self.prediction.predict(block, self.decoded, vertex, axis)
        exact, last = self.cut.find_place(position), self.cut.count - 1
        guess = min(exact >> 16, last)
        quarter = min(exact - (guess << 16) >> 14, 3)
        around = self.measures[axis].expect(x, y)
        expected = max(around - 16, 0)
        room = 2 * min(guess, last - guess)
        nearness = clamp(divide(measure(room) - expected + 12, 6), 0, 7)
        magnitude = self.magnitudes.decode(decoder, expected, (
            nearness | quarter << 3, clamp(around // 3, 0, 15) | quarter << 4,
            steepness | axis << 3, min(position >> 12, 15) | quarter << 4,
            steepness | min(used, 7) << 3))
        interval = decode_on_both_sides(magnitude, guess, 0, last, quarter < 2)
        self.measures[axis].add(x, y, measure_error(interval, exact))
        return interval


def measure_error(interval, place):
    return measure(abs(8 * interval + 4 - (place >> 13)))


class MeanPrediction:
    """The weighted mean of crossings of the same axis: previews."""

    NEIGHBOURS = [list_neighbours(axis, 2, (0, -1), lambda dz, axis=axis: (axis,), 11)
                  for axis in range(3)]

    def predict(self, block, decoded, vertex, axis):
        x, y, z = vertex
        weights, total = 1024, 1024 * (UNIT // 2)
        for dx, dy, dz, _, q in self.NEIGHBOURS[axis]:
            position = decoded.get((x + dx, y + dy, z + dz, axis))
            if position is not None:
                weight = weigh_decoded(q)
                weights += weight
                total += weight * (position + UNIT * (dx, dy, dz)[axis])
        return clamp(divide(total * 64, weights), 0, 1 << 16), 0, 0


NEAR_EDGES = [list_neighbours(axis, 2, (-1, 0, 1), lambda dz: (0, 1) if dz > 0 else (0, 1, 2), 11)
              for axis in range(3)]
NEAR_VERTICES = [[(dx, dy, dz) for dz in range(-1 if axis != 2 else 0, 2)
                  for dy in range(-1 if axis != 1 else 0, 2)
                  for dx in range(-1 if axis != 0 else 0, 2)] for axis in range(3)]


def list_terms(block, decoded, vertex, axis):
    """What is known around an edge, to fit to: (weight, side, place, whether it is a crossing).

    The side is 0 on the surface, 1 inside, -1 outside; places are seen from the edge's middle.
    """
    x, y, z = vertex
    half = [UNIT // 2 * m for m in middle(axis)]
    for dx, dy, dz, other, q in NEAR_EDGES[axis]:
        place = [UNIT * d - h for d, h in zip((dx, dy, dz), half)]
        edge = (x + dx, y + dy, z + dz, other)
        position = decoded.get(edge)
        if position is not None:
            place[other] += position
            yield weigh_decoded(q), 0, place, True
        elif block.is_crossed(*edge[:3], other) and edge not in decoded:
            place[other] += UNIT // 2
            yield 2 * 4096 // (12 + 10 * q), 0, place, False
    for step in NEAR_VERTICES[axis]:
        q = sum((2 * d - m)**2 for d, m in zip(step, middle(axis)))
        inside = block.is_inside(*(v + d for v, d in zip(vertex, step)))
        yield (max(1, 12 * 4096 // (100 * (12 + 10 * q))), 1 if inside else -1,
               [UNIT * d - h for d, h in zip(step, half)], False)


class PlanePrediction:
    """Where a linear function vanishes that fits what is known around: default and compact."""

    def predict(self, block, decoded, vertex, axis):
        """Position in units of 2^-16, steepness, and the number of decoded crossings used."""
        A, b, used = self._add_up(block, decoded, vertex, axis)
        r = 2**40 // A[0][0]
        mean = [A[0][i] * r >> 36 for i in (1, 2, 3)]
        level = b[0] * r >> 40
        S = [[A[i + 1][j + 1] - (mean[i] * A[0][j + 1] >> 4) if i <= j else 0 for j in range(3)]
             for i in range(3)]
        beta = [b[i + 1] - (mean[i] * b[0] >> 4) for i in range(3)]
        d = max(0, (S[0][0] | S[1][1] | S[2][2]).bit_length() - 18)
        d_beta = max(0, (abs(beta[0]) | abs(beta[1]) | abs(beta[2])).bit_length() - 18)
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = [[s >> d for s in row] for row in S]
        bx, by, bz = (value >> d_beta for value in beta)

        adjugate = ((yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy),
                    (xz * yz - xy * zz, xx * zz - xz * xz, xy * xz - xx * yz),
                    (xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy))
        D = xx * adjugate[0][0] + xy * adjugate[0][1] + xz * adjugate[0][2]
        if D <= 0:
            return 1 << 15, 0, used
        G = [row[0] * bx + row[1] * by + row[2] * bz for row in adjugate]
        k = max([abs(g).bit_length() for g in G] + [D.bit_length() + d - d_beta]) - 38
        G = [shift_right(g, k) for g in G]
        D = shift_right(D, k + d_beta - d)

        sigma = -1 if block.is_inside(*vertex) else 1
        slope = max(sigma * G[axis], D // 50 + 1)
        offset = (sum(g * m for g, m in zip(G, mean)) >> 4) - level * D
        position = clamp(2**15 + divide(offset * sigma * 64, slope), 0, 1 << 16)
        own, whole = 8 * (slope >> 10)**2, 1 + sum((g >> 10)**2 for g in G)
        return position, sum(own >= j * whole for j in range(1, 8)), used

    def _add_up(self, block, decoded, vertex, axis):
        """The sums of the least squares: a matrix of 4 x 4, its upper half, and its right side."""
        A = [[0] * 4 for _ in range(4)]
        b, used = [0] * 4, 0
        for weight, side, place, is_decoded in list_terms(block, decoded, vertex, axis):
            used += is_decoded
            point = (1, *place)
            for i in range(4):
                b[i] += weight * side * 717 * point[i]
                for j in range(i, 4):
                    A[i][j] += weight * point[i] * point[j]
        A[0][0] += 4
        for i in (1, 2, 3):
            A[i][i] += 4 << 20
        return A, b, used


def shift_right(number, bits):
    return number >> bits if bits >= 0 else number << -bits
