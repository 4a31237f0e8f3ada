# SPDX-License-Identifier: BSD-3-Clause
"""Arrays of version 2 of Zarr, written by version 2 or 3 of its package."""
import numcodecs
import zarr

IS_ZARR_2 = zarr.__version__.startswith("2.")


def create_array(folder, shape, dtype, chunks, separator=".", compressor=numcodecs.Blosc(), filters=None, **options):
    """A new array."""
    if IS_ZARR_2:
        return zarr.open(folder, mode="w", shape=shape, dtype=dtype, chunks=chunks, dimension_separator=separator,
                         compressor=compressor, filters=filters, **options)
    return zarr.create_array(folder, shape=shape, dtype=dtype, chunks=chunks, compressors=compressor, filters=filters,
                             chunk_key_encoding={"name": "v2", "separator": separator}, zarr_format=2,
                             overwrite=True, **options)


def write_array_2(folder, samples, chunks, **options):
    create_array(folder, samples.shape, samples.dtype, chunks, **options)[:] = samples


def create_group(folder):
    """A new group."""
    return zarr.open_group(folder, mode="w", **({} if IS_ZARR_2 else {"zarr_format": 2}))
