# SPDX-License-Identifier: BSD-3-Clause
"""Decodes compressed segments, written from Documentation/formats/block-compression.md alone."""
import array
import ctypes
import ctypes.util

from read_interval_tree import check


def decompress_lz4(code, size):
    """A block of the LZ4 format, byte by byte."""
    result, position = bytearray(), 0

    def read_length(length):
        nonlocal position
        if length == 15:
            while code[position] == 255:
                length, position = length + 255, position + 1
            length, position = length + code[position], position + 1
        return length

    while position < len(code):
        token, position = code[position], position + 1
        literals = read_length(token >> 4)
        result += code[position:position + literals]
        position += literals
        if position < len(code):
            distance, position = code[position] + 256 * code[position + 1], position + 2
            for _ in range(4 + read_length(token & 15)):
                result.append(result[-distance])
    check(len(result) == size, "an LZ4 block of another size")
    return bytes(result)


def decompress_zstd(code, size):
    library = ctypes.CDLL(ctypes.util.find_library("zstd"))
    library.ZSTD_decompress.restype = ctypes.c_size_t
    result = ctypes.create_string_buffer(size)
    found = library.ZSTD_decompress(result, ctypes.c_size_t(size), code,
                                    ctypes.c_size_t(len(code)))
    check(found == size, "a Zstandard frame of another size")
    return result.raw


DECOMPRESS = {1: decompress_lz4, 2: decompress_zstd}


def gather_codes(data, count, size):
    """z of each sample, out of its byte planes."""
    return [sum(data[byte * count + index] << 8 * byte for byte in range(size))
            for index in range(count)]


def order(bits, kind, size):
    """u of a sample's bits; kind is "u", "i" or "f"."""
    sign = 1 << 8 * size - 1
    if kind == "f" and bits & sign:
        return bits ^ (2 * sign - 1)
    return bits if kind == "u" else bits ^ sign


def restore(ordered, kind, size):
    sign = 1 << 8 * size - 1
    if kind == "f" and not ordered & sign:
        return ordered ^ (2 * sign - 1)
    return ordered if kind == "u" else ordered ^ sign


def predict(coarse, box, vertex):
    """The mean of u at the eight coarser vertices around, equal ones among them."""
    def read(x, y, z):
        i, j, k = (min((v + up) // 2, high - 1) - low
                   for v, up, (low, high) in zip(vertex, (x, y, z), box))
        return coarse[i + (box[0][1] - box[0][0]) * (j + (box[1][1] - box[1][0]) * k)]

    def mean(a, b):
        return (a + b + 1) // 2

    x0, x1 = (mean(mean(read(x, 0, 0), read(x, 1, 0)), mean(read(x, 0, 1), read(x, 1, 1)))
              for x in (0, 1))
    return mean(x0, x1)


def decode_segment(payload, codec, predictor, typecode, kind, vertices, coarser):
    """The samples at `vertices`; coarser() gives those of the next coarser level and their box."""
    size = array.array(typecode).itemsize
    count = len(vertices)
    check(codec in DECOMPRESS and predictor <= 2, "unknown codec or predictor")
    codes = gather_codes(DECOMPRESS[codec](payload, count * size), count, size)
    if predictor:
        mask, previous = (1 << 8 * size) - 1, 1 << 8 * size - 1
        if predictor == 2:
            samples, box = coarser()
            data = samples.tobytes()
            coarse = [order(int.from_bytes(data[at:at + size], "little"), kind, size)
                      for at in range(0, len(data), size)]
        for index, code in enumerate(codes):
            prediction = previous if predictor == 1 else predict(coarse, box, vertices[index])
            residual = -(code + 1) // 2 if code & 1 else code // 2
            previous = prediction + residual & mask
            codes[index] = restore(previous, kind, size)
    result = array.array(typecode)
    result.frombytes(b"".join(code.to_bytes(size, "little") for code in codes))
    return result
