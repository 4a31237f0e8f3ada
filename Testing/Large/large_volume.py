# SPDX-License-Identifier: BSD-3-Clause
"""A volume beyond 2^32 bytes, a gyroid with noise: raw, and as files of other formats that hold it in place."""
import json
import os
import shutil
import struct
import sys

import numpy

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "Tools"))
from write_zarr3 import crc32c

SHAPE = (1104, 1024, 1024)  # z, y, x


def write_volume(folder):
    random = numpy.random.default_rng(18)
    x, y = (numpy.arange(SHAPE[2]) * 0.131), (numpy.arange(SHAPE[1]) * 0.135)
    with open(os.path.join(folder, "v.raw"), "wb") as file:
        for z in 0.127 * numpy.arange(SHAPE[0]):
            samples = numpy.outer(numpy.cos(y), numpy.sin(x)).astype("<f4")
            samples += (numpy.sin(y) * numpy.cos(z)).astype("<f4")[:, None]
            samples += (numpy.sin(z) * numpy.cos(x)).astype("<f4")
            samples += numpy.float32(1e-3) * random.random(samples.shape, dtype="f4")
            samples.tofile(file)
    with open(os.path.join(folder, "v.mhd"), "w") as file:
        file.write("ObjectType = Image\nNDims = 3\nDimSize = %d %d %d\n" % SHAPE[::-1]
                   + "ElementType = MET_FLOAT\nElementDataFile = v.raw\n")


def open_samples(folder):
    return numpy.memmap(os.path.join(folder, "v.raw"), "<f4", "r", shape=SHAPE)


def write_hdf5(folder):
    import h5py

    samples = open_samples(folder)
    with h5py.File(os.path.join(folder, "v.h5"), "w") as file:
        dataset = file.create_dataset("d", SHAPE, "<f4", chunks=(48, 64, 128))
        for begin in range(0, SHAPE[0], 48):
            dataset[begin:begin + 48] = samples[begin:begin + 48]


def write_shard(folder):
    """A Zarr 3 of one shard: its chunks are slabs of 16 whole slices, as the raw file has them."""
    chunk = 16 * SHAPE[1] * SHAPE[2] * 4
    root = os.path.join(folder, "v.zarr")
    os.makedirs(os.path.join(root, "c/0/0"))
    endian = {"name": "bytes", "configuration": {"endian": "little"}}
    sharding = {"name": "sharding_indexed", "configuration": {
        "chunk_shape": [16, *SHAPE[1:]], "codecs": [endian], "index_codecs": [endian, {"name": "crc32c"}],
        "index_location": "end"}}
    with open(os.path.join(root, "zarr.json"), "w") as file:
        json.dump({"zarr_format": 3, "node_type": "array", "shape": SHAPE, "data_type": "float32", "fill_value": 0,
                   "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": SHAPE}},
                   "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
                   "codecs": [sharding]}, file)
    shutil.copyfile(os.path.join(folder, "v.raw"), os.path.join(root, "c/0/0/0"))
    index = b"".join(struct.pack("<QQ", number * chunk, chunk) for number in range(SHAPE[0] // 16))
    with open(os.path.join(root, "c/0/0/0"), "ab") as file:
        file.write(index + crc32c(index))
