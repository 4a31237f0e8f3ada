# SPDX-License-Identifier: BSD-3-Clause
"""Writes arrays of Zarr 3 by the words of its specification; Debian 12 has no library that does."""
import itertools
import json
import os
import struct

import numcodecs
import numpy

COMPRESSORS = {"gzip": numcodecs.GZip(5), "zstd": numcodecs.Zstd(3),
               "blosc": numcodecs.Blosc("lz4", 5, numcodecs.Blosc.SHUFFLE)}


def crc32c(data):
    value = 0xffffffff
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x82f63b78 if value & 1 else 0)
    return struct.pack("<I", value ^ 0xffffffff)


def chunk_of(samples, place, shape, fill):
    """The chunk, filled up to its whole shape beyond the end of the array."""
    chunk = numpy.full(shape, fill, samples.dtype)
    part = samples[tuple(slice(n * size, (n + 1) * size) for n, size in zip(place, shape))]
    chunk[tuple(slice(size) for size in part.shape)] = part
    return chunk


def encode(chunk, codecs):
    """The bytes of a chunk; None if all samples are the fill value (the caller's choice)."""
    data = chunk
    for codec in codecs:
        name, settings = codec["name"], codec.get("configuration", {})
        if name == "transpose":
            data = data.transpose(settings["order"])
        elif name == "bytes":
            order = ">" if settings.get("endian") == "big" else "<"
            data = numpy.ascontiguousarray(data, data.dtype.newbyteorder(order)).tobytes()
        elif name == "crc32c":
            data += crc32c(data)
        else:
            data = bytes(COMPRESSORS[name].encode(data))
    return data


def encode_shard(shard, inner, codecs, fill, at_start):
    """The chunks of a shard one after another, and their places with a checksum."""
    counts = [size // chunk for size, chunk in zip(shard.shape, inner)]
    size = 16 * int(numpy.prod(counts)) + 4
    data, index = b"", b""
    for place in itertools.product(*(range(count) for count in counts)):
        chunk = chunk_of(shard, place, inner, fill)
        if (chunk == fill).all():
            index += struct.pack("<QQ", 2 ** 64 - 1, 2 ** 64 - 1)
            continue
        encoded = encode(chunk, codecs)
        index += struct.pack("<QQ", len(data) + (size if at_start else 0), len(encoded))
        data += encoded
    index += crc32c(index)
    return index + data if at_start else data + index


def write_array(folder, samples, chunk, codecs, fill=0, shard=None, keys="default",
                at_start=False, **more):
    """Writes samples; `chunk` is what is decoded together, `shard` what a file has."""
    outer = shard or chunk
    settings = codecs
    if shard:
        settings = [{"name": "sharding_indexed", "configuration": {
            "chunk_shape": chunk, "codecs": codecs,
            "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}},
                             {"name": "crc32c"}],
            "index_location": "start" if at_start else "end"}}]
    os.makedirs(folder)
    with open(os.path.join(folder, "zarr.json"), "w") as file:
        json.dump({"zarr_format": 3, "node_type": "array", "shape": samples.shape,
                   "data_type": samples.dtype.name, "fill_value": fill, "attributes": {},
                   "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": outer}},
                   "chunk_key_encoding": {"name": keys}, "codecs": settings, **more}, file)
    counts = [-(-size // step) for size, step in zip(samples.shape, outer)]
    for place in itertools.product(*(range(count) for count in counts)):
        part = chunk_of(samples, place, outer, fill)
        if (part == fill).all():
            continue
        numbers = [str(number) for number in place]
        path = os.path.join(folder, *(["c"] + numbers if keys == "default" else [".".join(numbers)]))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(encode_shard(part, chunk, codecs, fill, at_start) if shard
                       else encode(part, codecs))
