# SPDX-License-Identifier: BSD-3-Clause
"""Decodes arrays of the points: edge-index.md, section "Attributes"."""
import struct

from edge_index_coding import (PRIORS, AdaptiveBits, PreviewMagnitudes, clamp, decode_signed, divide,
                               measure)
from edge_index_crossings import list_neighbours
from edge_index_values import GREATEST_FLOAT32, Measures, code_to_float, round_to_float32, wrap


class Component:
    """What each component of an attribute learns for itself."""

    def __init__(self, has_exceptions):
        self.exceptions = AdaptiveBits(1, 255) if has_exceptions else None
        self.magnitudes = PreviewMagnitudes(PRIORS.crossings)
        self.measures = [Measures(0) for _ in range(3)]
        self.codes = {}  # by (x, y, z, axis)
        self.last = 0


class Attribute:
    """Decodes an attribute of a block. `description` has bits, components and maximum_error."""

    NEIGHBOURS = [list_neighbours(axis, 1, (0, -1), lambda dz: (0, 1, 2), 6) for axis in range(3)]

    def __init__(self, decoder, description):
        self.description = description
        has_exceptions = decoder.uniform(1)
        self.components = [Component(has_exceptions) for _ in range(description.components)]

    def decode_slice(self, decoder, block, z):
        """Tuples at the crossed edges that begin in slice z, by (x, y, axis)."""
        return {(x, y, axis): [self._decode(decoder, component, x, y, z, axis)
                               for component in self.components]
                for x, y, axis in block.list_edges(z)}

    def _decode(self, decoder, component, x, y, z, axis):
        bits, error = self.description.bits, self.description.maximum_error
        modulus = 32 if bits == 32 and error == 0 else 64
        predicted = wrap(self._predict(component, x, y, z, axis), modulus)
        if component.exceptions and component.exceptions.decode(decoder, 0):
            component.codes[x, y, z, axis] = predicted
            raw = bytes(decoder.uniform(8) for _ in range(bits // 8))
            return struct.unpack("<f" if bits == 32 else "<d", raw)[0]
        expected = component.measures[axis].expect(x, y)
        magnitude = component.magnitudes.decode(decoder, expected, (axis,))
        component.measures[axis].add(x, y, measure(magnitude))
        code = wrap(predicted + decode_signed(magnitude), modulus)
        component.codes[x, y, z, axis] = component.last = code
        if error == 0:
            return code_to_float(code, bits)
        value = code * (2 * error * (1 - 1 / 1024))
        return value if bits == 64 else round_to_float32(
            clamp(value, -GREATEST_FLOAT32, GREATEST_FLOAT32))

    def _predict(self, component, x, y, z, axis):
        first, weights, total = None, 0, 0
        for dx, dy, dz, other, q in self.NEIGHBOURS[axis]:
            code = component.codes.get((x + dx, y + dy, z + dz, other))
            if code is not None:
                if first is None:
                    first = code
                weight = 4096 // q**2
                weights += weight
                total += weight * clamp(wrap(code - first, 64), -2**44, 2**44)
        return component.last if first is None else first + divide(total, weights)
