#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""From a file that nobody has indexed to a picture, beside programs that read the file first.

    first_contact.py [FOLDER] [--sides N N N] [--formats mhd nii.gz dcm zarr ome h5 tif ome.tif] [--isovalue V]
                     [--no-peers] [--warm] [--sample-only]

Writes a volume of int16 that is N[0] wide, N[1] high and N[2] deep, a ball with noise, as MetaImage, NIfTI
(gzip 1), Zarr (blosc lz4), OME-Zarr (with a pyramid of averages) and HDF5 (shuffle, gzip 1), chunks of 64,
and, if asked for, DICOM (a file a slice, not compressed) and TIFF (deflate 1, tiles of 256 x 256, without or
with smaller images of averages) into the folder. Then, each in a process of its own that has loaded its
libraries, without the file in the system's cache (that takes root; --warm leaves it there):

    picture   seconds from opening the file to the first picture of the surface, that of a sample
    part      until a part of it is exact, beside the window; --sample-only leaves such parts out, so that two
              runs tell what they cost
    index     until the file is indexed beside the window
    exact     until the picture of the whole surface
    freeze    after the first picture, the longest call for which a window would have waited until it had
              a coarse surface of the indexed file; without drawing, which windows do in portions
    processor, peak memory: of all of that

of Volume Reader (Any Size), Isosurface and Isosurface Mapper, as ParaView's window uses them, and of
VTK's own reader, zarr, h5py or tifffile with vtkFlyingEdges3D and vtkPolyDataMapper, whose first picture is exact.
Needs an X display, python3-h5py, python3-zarr (version 2), for TIFF python3-tifffile, for DICOM python3-pydicom,
and the package scalable_isosurface on PYTHONPATH.
"""
import argparse
import gzip
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time

CHUNK = 64
SLAB = 64
POLL_SECONDS = 0.1


def make_slabs(sides):
    """Numbers of first slices, and the samples from there on: distances from the centre, with noise."""
    import numpy

    random = numpy.random.default_rng(1)
    noise = random.integers(-3, 4, (SLAB, sides[1], sides[0]), "i2")
    place = [(numpy.arange(side) - side / 2) / side for side in sides]
    across = place[0][None, :] ** 2 + place[1][:, None] ** 2
    for first in range(0, sides[2], SLAB):
        deep = place[2][first:first + SLAB, None, None] ** 2
        ball = (4000 * numpy.sqrt(across[None] + deep)).astype("i2")
        yield first, ball + noise[:len(ball)]
        noise = numpy.roll(noise, 37, 2)


def write_tiff(path, sides, levels):
    """A page a slice, with so many smaller images."""
    import numpy
    import tifffile

    layout = {"tile": (256, 256), "compression": "zlib", "compressionargs": {"level": 1}, "metadata": None}
    with tifffile.TiffWriter(path, bigtiff=True) as file:
        for _, samples in make_slabs(sides):
            for page in samples:
                file.write(page, subifds=levels, **layout)
                for _ in range(levels):
                    page = numpy.pad(page, [(0, side % 2) for side in page.shape], mode="edge")
                    page = (sum(page[y::2, x::2].astype("f4") for y, x in numpy.ndindex(2, 2)) / 4).astype("i2")
                    file.write(page, subfiletype=1, **layout)


def write_dicom(folder, sides):
    """A CT series, a file a slice."""
    from pydicom.dataset import Dataset, FileMetaDataset
    from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, generate_uid

    os.mkdir(folder)
    slice_of_series = Dataset()
    slice_of_series.is_little_endian, slice_of_series.is_implicit_VR = True, False
    slice_of_series.SOPClassUID = CTImageStorage
    slice_of_series.Modality, slice_of_series.SeriesInstanceUID = "CT", generate_uid()
    slice_of_series.Rows, slice_of_series.Columns, slice_of_series.PixelSpacing = sides[1], sides[0], [1, 1]
    slice_of_series.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    slice_of_series.SamplesPerPixel, slice_of_series.PhotometricInterpretation = 1, "MONOCHROME2"
    slice_of_series.BitsAllocated, slice_of_series.BitsStored, slice_of_series.HighBit = 16, 16, 15
    slice_of_series.PixelRepresentation = 1
    slice_of_series.file_meta = FileMetaDataset()
    slice_of_series.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    for first, samples in make_slabs(sides):
        for number, pixels in enumerate(samples, first):
            slice_of_series.SOPInstanceUID, slice_of_series.InstanceNumber = generate_uid(), number + 1
            slice_of_series.ImagePositionPatient = [0, 0, number]
            slice_of_series.PixelData = pixels.astype("<i2").tobytes()
            slice_of_series.save_as(os.path.join(folder, f"{number:05}.dcm"), write_like_original=False)


def write_volume(kind, folder, sides):
    """Returns the path."""
    import h5py
    import numcodecs
    import numpy
    import zarr

    shape, chunks, codec = sides[::-1], (CHUNK,) * 3, numcodecs.Blosc("lz4", 1, 1)
    path = os.path.join(folder, "scan." + kind)
    if kind == "mhd":
        with open(path, "w") as header:
            header.write("ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementType = MET_SHORT\n"
                         "ElementDataFile = scan.raw\n".format(*sides))
        with open(os.path.join(folder, "scan.raw"), "wb") as file:
            for _, samples in make_slabs(sides):
                samples.astype("<i2").tofile(file)
    elif kind == "nii.gz":
        header = bytearray(352)
        struct.pack_into("<i", header, 0, 348)
        struct.pack_into("<8h", header, 40, 3, *sides, 1, 1, 1, 1)
        struct.pack_into("<2h", header, 70, 4, 16)
        struct.pack_into("<8f", header, 76, *[1] * 8)
        struct.pack_into("<f", header, 108, 352)
        header[344:347] = b"n+1"
        with gzip.open(path, "wb", 1) as file:
            file.write(header)
            for _, samples in make_slabs(sides):
                file.write(samples.astype("<i2").tobytes())
    elif kind == "h5":
        with h5py.File(path, "w") as file:
            dataset = file.create_dataset("scan", shape=shape, dtype="i2", chunks=chunks,
                                          compression="gzip", compression_opts=1, shuffle=True)
            for first, samples in make_slabs(sides):
                dataset[first:first + len(samples)] = samples
    elif kind == "zarr":
        array = zarr.open(path, mode="w", shape=shape, chunks=chunks, dtype="i2", compressor=codec)
        for first, samples in make_slabs(sides):
            array[first:first + len(samples)] = samples
    elif kind.endswith("tif"):
        write_tiff(path, sides, 4 if kind == "ome.tif" else 0)
    elif kind == "dcm":
        write_dicom(path, sides)
    else:
        path = os.path.join(folder, "scan-ome.zarr")
        group = zarr.open_group(path, mode="w")
        levels = [group.create_dataset(str(level), shape=[-(-side >> level) for side in shape], chunks=chunks,
                                       dtype="i2", compressor=codec) for level in range(5)]
        for first, samples in make_slabs(sides):
            for level, array in enumerate(levels):
                array[first >> level:(first >> level) + len(samples)] = samples
                samples = numpy.pad(samples, [(0, side % 2) for side in samples.shape], mode="edge")
                samples = (sum(samples[z::2, y::2, x::2].astype("f4")
                               for z, y, x in numpy.ndindex(2, 2, 2)) / 8).astype("i2")
        group.attrs["multiscales"] = [{
            "version": "0.4", "axes": [{"name": name, "type": "space"} for name in "zyx"],
            "datasets": [{"path": str(level), "coordinateTransformations": [
                {"type": "scale", "scale": [2.0 ** level] * 3},
                {"type": "translation", "translation": [2.0 ** level / 2 - 0.5] * 3}]} for level in range(5)]}]
    return path


class Picture:
    """A window that shows what a filter makes."""

    def __init__(self, contour, mapper=None):
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401: makes the classes below draw
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow

        mapper = mapper or vtkPolyDataMapper()
        mapper.ScalarVisibilityOff()
        mapper.SetInputConnection(contour.GetOutputPort())
        actor = vtkActor()
        actor.SetMapper(mapper)
        self.renderer = vtkRenderer()
        self.renderer.AddActor(actor)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(True)
        self.window.SetSize(1280, 800)
        self.window.AddRenderer(self.renderer)

    def show(self):
        self.renderer.ResetCamera()
        self.window.Render()
        self.window.WaitForCompletion()


def show_at_once(path, isovalue, begin, grows):
    """The times of ours."""
    from scalable_isosurface import vtkInPlaceVolumeReader, vtkIsosurfaceMapper, vtkStabbingContour

    reader = vtkInPlaceVolumeReader()
    reader.SetSourceName(path)
    contour = vtkStabbingContour()
    contour.SetInputConnection(reader.GetOutputPort())
    contour.SetValue(0, isovalue)
    picture = Picture(contour, vtkIsosurfaceMapper())
    reader.AllowCoarse(True)
    contour.AllowCoarse(True)
    picture.show()
    times = {"picture": time.perf_counter() - begin, "freeze": 0.0,
             "coarse": contour.GetOutput().GetNumberOfPolys(), "shown": reader.GetShownText()}
    while reader.GetRefinement()[0] == 1:
        time.sleep(POLL_SECONDS)
        call = time.perf_counter()
        refined = False
        reader.AdvanceIndex(0)
        if reader.GetRefinement()[0] == 2:  # the index, or a larger sample
            reader.TakeIndex()
            contour.Update()
        elif grows:
            contour.PrepareRefinement(0)
            refined = contour.GetRefinement()[0] == 2
            if refined:
                contour.Refine()
        times["freeze"] = max(times["freeze"], time.perf_counter() - call)
        if refined:
            picture.show()
            if contour.GetRefinement()[1] == 0:  # else it was a finer level of the sample
                times.setdefault("part", time.perf_counter() - begin)
    times["index"] = time.perf_counter() - begin
    contour.AllowCoarse(False)
    contour.Modified()
    picture.show()
    return contour, times


def read_first(path, isovalue):
    """The peers' contour, behind all samples."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    contour = vtkFlyingEdges3D()
    contour.SetValue(0, isovalue)
    if path.endswith((".mhd", ".gz", ".dcm")):
        from vtkmodules import vtkIOImage

        if path.endswith(".dcm"):
            reader = vtkIOImage.vtkDICOMImageReader()
            reader.SetDirectoryName(path)
        else:
            reader = vtkIOImage.vtkMetaImageReader() if path.endswith(".mhd") else vtkIOImage.vtkNIFTIImageReader()
            reader.SetFileName(path)
        contour.SetInputConnection(reader.GetOutputPort())
        return contour, reader
    if path.endswith(".h5"):
        import h5py

        samples = h5py.File(path)["scan"][:]
    elif path.endswith("tif"):
        import tifffile

        samples = tifffile.TiffFile(path).asarray(key=slice(None))
    else:
        import zarr

        array = zarr.open(path, mode="r")
        samples = (array if hasattr(array, "shape") else array["0"])[:]
    image = vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel()))
    contour.SetInputData(image)
    return contour, samples


def start_programs(who, is_cold):
    """Loads libraries, as those of a window that is open, and then drops the files from the cache."""
    from vtkmodules.vtkFiltersSources import vtkSphereSource

    if who == "ours":
        from scalable_isosurface import vtkInPlaceVolumeReader, vtkIsosurfaceMapper, vtkStabbingContour  # noqa: F401
    else:
        import h5py  # noqa: F401
        import zarr  # noqa: F401
    Picture(vtkSphereSource()).show()
    if is_cold:
        os.sync()
        with open("/proc/sys/vm/drop_caches", "w") as file:
            file.write("3")


def measure(who, path, isovalue, is_cold, grows):
    start_programs(who, is_cold)
    begin, processor = time.perf_counter(), time.process_time()
    if who == "ours":
        contour, times = show_at_once(path, isovalue, begin, grows)
    else:
        contour, kept = read_first(path, isovalue)
        Picture(contour).show()
        times = {}
    times["exact"] = time.perf_counter() - begin
    times["processor"] = time.process_time() - processor
    times["triangles"] = contour.GetOutput().GetNumberOfPolys()
    with open("/proc/self/status") as file:
        times["MiB"] = next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024
    print(json.dumps(times))


def run(who, path, arguments):
    done = subprocess.run([sys.executable, __file__, "--measure", who, path, str(arguments.isovalue),
                           "warm" if arguments.warm else "cold",
                           "sample" if arguments.sample_only else "parts"], stdout=subprocess.PIPE, check=True)
    times = json.loads(done.stdout.splitlines()[-1])
    print(f"  {who:6} " + "  ".join(
        f"{name} {times[name]:.2f}" for name in ("picture", "part", "index", "exact", "freeze", "processor") if name in times) +
        f"  peak {times['MiB']:.0f} MiB  {times['triangles']:,} triangles" +
        (f" ({times['coarse']:,} first: {times['shown']})" if "coarse" in times else ""), flush=True)


def main():
    if sys.argv[1:2] == ["--measure"]:
        measure(sys.argv[2], sys.argv[3], float(sys.argv[4]), sys.argv[5] == "cold", sys.argv[6] == "parts")
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--sides", type=int, nargs=3, default=[816, 816, 816])
    parser.add_argument("--formats", nargs="+", default=["mhd", "nii.gz", "zarr", "ome", "h5"])
    parser.add_argument("--isovalue", type=float, default=1500)
    parser.add_argument("--no-peers", action="store_true", help="for volumes larger than memory")
    parser.add_argument("--warm", action="store_true")
    parser.add_argument("--sample-only", action="store_true")
    arguments = parser.parse_args()
    for kind in arguments.formats:
        folder = tempfile.mkdtemp(dir=arguments.folder)
        try:
            path = write_volume(kind, folder, arguments.sides)
            print(f"{kind}, {' x '.join(map(str, arguments.sides))} int16", flush=True)
            run("ours", path, arguments)
            if not arguments.no_peers:
                run("peer", path, arguments)
        finally:
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
