#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The memory that blockvolume takes for a volume of each format, beside its limit.

    source_memory.py BLOCKVOLUME [FOLDER] [--side 1600] [--memory 512] [--copied-only] [--only NAME ...]

Makes a cube of uint16 in each format, one after the other, in a folder of its own, writes it as a
blocked volume with lz4 and, where that is possible, indexes it in place, each by one rank of two
threads. Prints the peak of the process's memory (ru_maxrss) and seconds, and deletes all. Files are
sparse where samples are contiguous, and have one chunk many times where they are chunked, so that a
volume of 8 GB takes little of the disk. Exit status: 1 if a peak is above the limit. Needs
python3-h5py, -netcdf4, -numcodecs and -pydicom.
"""
import argparse
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib


def make_sparse(path, size, header=b""):
    with open(path, "wb") as file:
        file.write(header)
        file.truncate(len(header) + size)


def make_pattern(shape):
    import numpy

    z, y, x = numpy.ogrid[tuple(slice(count) for count in shape)]
    waves = 3000 + 2000 * numpy.sin(0.05 * x + 0.03 * z) * numpy.cos(0.04 * y)
    return (waves.astype("<u2") & 0xfff0).astype("<u2")


def write_mhd(folder, side):
    make_sparse(os.path.join(folder, "v.raw"), 2 * side**3)
    with open(os.path.join(folder, "v.mhd"), "w") as file:
        file.write(f"ObjectType = Image\nNDims = 3\nDimSize = {side} {side} {side}\nElementType = MET_USHORT\n"
                   "ElementDataFile = v.raw\n")
    return "v.mhd"


def write_nrrd(folder, side):
    make_sparse(os.path.join(folder, "v.nrrd"), 2 * side**3,
                f"NRRD0004\ntype: uint16\ndimension: 3\nsizes: {side} {side} {side}\nendian: little\n"
                "encoding: raw\n\n".encode())
    return "v.nrrd"


def make_nifti_header(side):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, side, side, side, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 512, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    header[344:348] = b"n+1\0"
    return bytes(header)


def write_nii(folder, side):
    make_sparse(os.path.join(folder, "v.nii"), 2 * side**3, make_nifti_header(side))
    return "v.nii"


def write_nii_gz(folder, side):
    pattern = make_pattern((4, side, side)).tobytes()
    coder = zlib.compressobj(1, zlib.DEFLATED, 31)
    with open(os.path.join(folder, "v.nii.gz"), "wb") as file:
        file.write(coder.compress(make_nifti_header(side)))
        for _ in range(0, side, 4):
            file.write(coder.compress(pattern))
        file.write(coder.flush())
    return "v.nii.gz"


def write_mrc(folder, side):
    header = bytearray(1024)
    struct.pack_into("<4i", header, 0, side, side, side, 6)
    struct.pack_into("<3i3f3f3i", header, 28, side, side, side, side, side, side, 90, 90, 90, 1, 2, 3)
    header[208:212] = b"MAP "
    header[212:216] = b"\x44\x44\0\0"
    make_sparse(os.path.join(folder, "v.mrc"), 2 * side**3, bytes(header))
    return "v.mrc"


def write_bigtiff(folder, side):
    page = 2 * side**2
    directory = 8 + 20 * 9 + 8
    with open(os.path.join(folder, "v.tif"), "wb") as file:
        file.write(struct.pack("<2sHHHQ", b"II", 43, 8, 0, 16))
        for number in range(side):
            begin = 16 + number * directory
            samples = 16 + side * directory + number * page
            entries = [(256, 4, side), (257, 4, side), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 16, samples),
                       (277, 3, 1), (278, 4, side), (279, 16, page)]
            file.write(struct.pack("<Q", len(entries)))
            for tag, kind, value in entries:
                file.write(struct.pack("<HHQQ", tag, kind, 1, value))
            file.write(struct.pack("<Q", begin + directory if number + 1 < side else 0))
        file.truncate(16 + side * directory + side * page)
    return "v.tif"


def write_hdf5(folder, side, chunk=None):
    import h5py

    with h5py.File(os.path.join(folder, "v.h5"), "w") as file:
        if not chunk:
            dataset = file.create_dataset("d", (side,) * 3, "<u2")
            dataset[-1, -1] = 1  # all of it is allocated then, and sparse
            return "v.h5"
        dataset = file.create_dataset("d", (side,) * 3, "<u2", chunks=(chunk,) * 3, compression="gzip",
                                      compression_opts=1)
        stored = zlib.compress(make_pattern((chunk,) * 3).tobytes(), 1)
        for z in range(0, side, chunk):
            for y in range(0, side, chunk):
                for x in range(0, side, chunk):
                    dataset.id.write_direct_chunk((z, y, x), stored)
    return "v.h5"


def write_netcdf_3(folder, side):
    import netCDF4

    with netCDF4.Dataset(os.path.join(folder, "v.nc"), "w", format="NETCDF3_64BIT_DATA") as file:
        file.set_fill_off()
        for axis in "zyx":
            file.createDimension(axis, side)
        variable = file.createVariable("d", "i2", ("z", "y", "x"))
        variable[-1, -1] = 1
    return "v.nc"


def write_netcdf_4(folder, side):
    import netCDF4
    import numpy

    chunk = 64
    with netCDF4.Dataset(os.path.join(folder, "v.nc"), "w") as file:
        for axis in "zyx":
            file.createDimension(axis, side)
        variable = file.createVariable("d", "i2", ("z", "y", "x"), zlib=True, complevel=1, chunksizes=(chunk,) * 3)
        pattern = numpy.tile(make_pattern((chunk,) * 3).astype("i2"), (1, 1, -(-side // chunk)))[:, :, :side]
        for z in range(0, side, chunk):
            for y in range(0, side, chunk):
                variable[z:z + chunk, y:y + chunk] = pattern[:side - z, :side - y]
    return "v.nc"


def write_chunks(folder, side, chunk, stored, name):
    """A file for each chunk."""
    count = -(-side // chunk)
    for number in range(count**3):
        path = os.path.join(folder, name(number // count**2, number // count % count, number % count))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(stored)


def write_zarr_2(folder, side, chunk=128):
    import numcodecs

    codec = numcodecs.Blosc("lz4", 1, 1)
    root = os.path.join(folder, "v.zarr")
    os.makedirs(root)
    with open(os.path.join(root, ".zarray"), "w") as file:
        json.dump({"zarr_format": 2, "shape": [side] * 3, "chunks": [chunk] * 3, "dtype": "<u2", "order": "C",
                   "compressor": codec.get_config(), "fill_value": 0, "filters": None}, file)
    write_chunks(root, side, chunk, codec.encode(make_pattern((chunk,) * 3)), "{}.{}.{}".format)
    return "v.zarr"


def write_zarr_3(folder, side, chunk=128):
    import numcodecs

    root = os.path.join(folder, "v.zarr")
    os.makedirs(root)
    with open(os.path.join(root, "zarr.json"), "w") as file:
        json.dump({"zarr_format": 3, "node_type": "array", "shape": [side] * 3, "data_type": "uint16", "fill_value": 0,
                   "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [chunk] * 3}},
                   "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
                   "codecs": [{"name": "bytes", "configuration": {"endian": "little"}},
                              {"name": "zstd", "configuration": {"level": 1, "checksum": False}}]}, file)
    write_chunks(root, side, chunk, numcodecs.Zstd(1).encode(make_pattern((chunk,) * 3)), "c/{}/{}/{}".format)
    return "v.zarr"


def write_n5(folder, side, chunk=128):
    import gzip

    root = os.path.join(folder, "v.n5")
    os.makedirs(root)
    with open(os.path.join(root, "attributes.json"), "w") as file:
        json.dump({"n5": "2.0.0", "dimensions": [side] * 3, "blockSize": [chunk] * 3, "dataType": "uint16",
                   "compression": {"type": "gzip", "level": 1}}, file)
    stored = struct.pack(">HHIII", 0, 3, chunk, chunk, chunk)
    stored += gzip.compress(make_pattern((chunk,) * 3).astype(">u2").tobytes(), 1)
    write_chunks(root, side, chunk, stored, "{}/{}/{}".format)
    return "v.n5"


def write_dicom(folder, side):
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

    root = os.path.join(folder, "series")
    os.makedirs(root)
    series, study, frame = generate_uid(), generate_uid(), generate_uid()
    for number in range(side):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid()
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        path = os.path.join(root, f"{number:05}.dcm")
        slice_ = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128, is_little_endian=True,
                             is_implicit_VR=False)
        slice_.SOPClassUID, slice_.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
        slice_.SeriesInstanceUID, slice_.StudyInstanceUID, slice_.FrameOfReferenceUID = series, study, frame
        slice_.Modality, slice_.PatientID = "CT", "generated"
        slice_.InstanceNumber = number + 1
        slice_.ImagePositionPatient, slice_.ImageOrientationPatient = [0, 0, number], [1, 0, 0, 0, 1, 0]
        slice_.PixelSpacing, slice_.SliceThickness = [1, 1], 1
        slice_.Rows = slice_.Columns = side
        slice_.SamplesPerPixel, slice_.PhotometricInterpretation = 1, "MONOCHROME2"
        slice_.BitsAllocated = slice_.BitsStored = 16
        slice_.HighBit, slice_.PixelRepresentation = 15, 0
        slice_.save_as(path)
        with open(path, "ab") as file:
            size = 2 * side**2
            file.write(struct.pack("<HH2sHI", 0x7FE0, 0x0010, b"OW", 0, size))
            file.truncate(file.tell() + size)
    return "series"


SOURCES = {  # name: (writer, whether it can be indexed in place)
    "MetaImage, raw": (write_mhd, True),
    "NRRD, raw": (write_nrrd, True),
    "BigTIFF": (write_bigtiff, False),
    "HDF5, contiguous": (write_hdf5, True),
    "HDF5, chunks of 64^3, gzip": (lambda folder, side: write_hdf5(folder, side, 64), True),
    "Zarr 2, chunks of 128^3, blosc": (write_zarr_2, True),
    "Zarr 3, chunks of 128^3, zstd": (write_zarr_3, True),
    "N5, chunks of 128^3, gzip": (write_n5, True),
    "NetCDF, classic": (write_netcdf_3, True),
    "NetCDF 4, chunks of 64^3, zlib": (write_netcdf_4, True),
    "NIfTI": (write_nii, True),
    "NIfTI, gzip": (write_nii_gz, False),
    "MRC": (write_mrc, True),
    "DICOM": (write_dicom, False),
}


def run(tool, folder, name, memory, *options):
    command = [tool, os.path.join(folder, name), os.path.join(folder, "out.bvol"), "--quiet", "--threads", "2",
               "--memory", str(memory), *options]
    clock = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - clock
    shutil.rmtree(os.path.join(folder, ".out.bvol.stores"), ignore_errors=True)
    return process.returncode, used.ru_maxrss / 1024, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("blockvolume")
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--side", type=int, default=1600)
    parser.add_argument("--memory", type=int, default=512)
    parser.add_argument("--copied-only", action="store_true", help="index nothing in place")
    parser.add_argument("--only", nargs="+", default=list(SOURCES), metavar="NAME")
    arguments = parser.parse_args()
    exceeds = False
    print("| source | copied: peak MiB | seconds | in place: peak MiB | seconds |\n|---|---|---|---|---|", flush=True)
    for title in arguments.only:
        write, goes_in_place = SOURCES[title]
        folder = tempfile.mkdtemp(dir=arguments.folder)
        row = [title]
        try:
            name = write(folder, arguments.side)
            for options in [[]] + [["--in-place"]] * (goes_in_place and not arguments.copied_only):
                code, peak, seconds = run(arguments.blockvolume, folder, name, arguments.memory, *options)
                row += [f"{peak:.0f}" if code == 0 else "failed", f"{seconds:.0f}"]
                exceeds = exceeds or code != 0 or peak > arguments.memory
        finally:
            shutil.rmtree(folder)
        print("| " + " | ".join(row) + " |", flush=True)
    sys.exit(1 if exceeds else 0)


main()
