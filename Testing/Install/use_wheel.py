# SPDX-License-Identifier: BSD-3-Clause
"""Uses an installed wheel beside other packages of this Python, in one process and in both orders of import.

    use_wheel.py

Each package that is there writes a file, and reads it before and after we do."""

import hashlib
import importlib.util
import json
import os
import platform
import subprocess
import sys
import tempfile
import time

import numpy

OURS = "scalable_isosurface"
SAMPLES = (1000 * numpy.sin(numpy.arange(60 * 50 * 40) * 0.37).reshape(60, 50, 40)).astype(numpy.int16)


def write_hdf5():
    import h5py

    filters = ["gzip", *(["szip"] if h5py.h5z.filter_avail(h5py.h5z.FILTER_SZIP) else [])]
    with h5py.File("a.h5", "w") as file:
        for name in filters:
            file.create_dataset(name, data=SAMPLES, chunks=(20, 25, 40), compression=name, shuffle=name == "gzip")
    return [f"a.h5:/{name}" for name in filters]


def read_hdf5():
    import h5py

    with h5py.File("a.h5", "r") as file:
        return file["gzip"][...]


def write_netcdf():
    import netCDF4

    for name, kind in (("a4.nc", "NETCDF4"), ("a3.nc", "NETCDF3_CLASSIC")):
        with netCDF4.Dataset(name, "w", format=kind) as file:
            for axis, size in zip("zyx", SAMPLES.shape):
                file.createDimension(axis, size)
            file.createVariable("data", "i2", ("z", "y", "x"), zlib=kind == "NETCDF4")[...] = SAMPLES
    return ["a4.nc:/data", "a3.nc:/data"]


def read_netcdf():
    import netCDF4

    with netCDF4.Dataset("a4.nc") as file:
        return numpy.ma.getdata(file["data"][...])


def read_with_vtk():
    """VTK has HDF5 and NetCDF of its own."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIONetCDF import vtkNetCDFReader

    reader = vtkNetCDFReader()
    reader.SetFileName("a4.nc")
    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetArray("data")).reshape(SAMPLES.shape)


def write_dicom():
    import pydicom

    os.mkdir("series")
    series = pydicom.uid.generate_uid()
    for z, pixels in enumerate(SAMPLES):
        meta = pydicom.dataset.FileMetaDataset()
        meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
        meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"  # CT
        meta.MediaStorageSOPInstanceUID = pydicom.uid.generate_uid()
        image = pydicom.dataset.FileDataset(f"series/{z}.dcm", {}, file_meta=meta, preamble=bytes(128))
        image.is_little_endian, image.is_implicit_VR = True, False
        image.SOPClassUID, image.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
        image.Modality, image.SeriesInstanceUID, image.StudyInstanceUID = "CT", series, series
        image.Rows, image.Columns = pixels.shape
        image.PixelSpacing, image.ImageOrientationPatient = [1, 1], [1, 0, 0, 0, 1, 0]
        image.ImagePositionPatient, image.InstanceNumber = [0, 0, z], z
        image.SamplesPerPixel, image.PhotometricInterpretation = 1, "MONOCHROME2"
        image.BitsAllocated, image.BitsStored, image.HighBit, image.PixelRepresentation = 16, 16, 15, 1
        image.PixelData = pixels.tobytes()
        image.save_as(f"series/{z}.dcm", write_like_original=False)
    return ["series"]


def read_dicom():
    import pydicom

    return numpy.stack([pydicom.dcmread(f"series/{z}.dcm").pixel_array for z in range(len(SAMPLES))])


def write_tiff():
    import tifffile

    tifffile.imwrite("a.tif", SAMPLES, photometric="minisblack")
    return ["a.tif"]


def read_tiff():
    import tifffile

    return tifffile.imread("a.tif")


def write_zarr():
    import zarr

    how = {"zarr_format": 2} if int(zarr.__version__.split(".")[0]) > 2 else {}
    zarr.open("a.zarr", mode="w", shape=SAMPLES.shape, chunks=(20, 25, 40), dtype="i2", **how)[...] = SAMPLES
    with open("a.zarr/.zarray", encoding="utf-8") as file:  # chunks of Blosc, where it is the usual
        print("zarr compresses with", json.load(file)["compressor"])
    return ["a.zarr"]


def read_zarr():
    import zarr

    return zarr.open("a.zarr", mode="r")[...]


def write_volume():
    import scalable_isosurface as si

    si.create(SAMPLES, "a.bvol", spacing=(1, 2, 3), name="data")
    return ["a.bvol"]


def read_with_pyvista():
    import pyvista
    import scalable_isosurface as si

    surface = si.open("a.bvol").isosurface(250.5)
    mesh = surface.to_pyvista()
    assert isinstance(mesh, pyvista.PolyData) and mesh.n_cells == len(surface.triangles)
    grid = pyvista.read("a.bvol")
    assert grid.dimensions == (40, 50, 60) and grid.spacing == (1, 2, 3)
    return grid.point_data["data"].reshape(SAMPLES.shape)


#: What writes files, and what reads them, by packages. Before VTK there is NetCDF.
PEERS = {
    "h5py": (write_hdf5, read_hdf5),
    "netCDF4": (write_netcdf, read_netcdf),
    "vtkmodules": (None, read_with_vtk),
    "pydicom": (write_dicom, read_dicom),
    "tifffile": (write_tiff, read_tiff),
    "zarr": (write_zarr, read_zarr),
    "pyvista": (write_volume, read_with_pyvista),
}


def use(packages, paths):
    """All packages, in this order and in the other one."""
    for name in (*packages, *reversed(packages)):
        if name != OURS:
            assert (PEERS[name][1]() == SAMPLES).all(), name
            continue
        import scalable_isosurface as si

        for path in paths:
            assert (si.open(path)[...] == SAMPLES).all(), path


def run(*arguments):
    subprocess.run([sys.executable, "-B", "-W", "ignore", os.path.abspath(__file__), *arguments], check=True)


def measure_import():
    """Milliseconds of a processor beside those of NumPy, the least of five times."""
    script = (
        "import numpy, time; begin = time.process_time()\n"
        "import scalable_isosurface; scalable_isosurface.open; print(1000 * (time.process_time() - begin))"
    )
    return min(float(subprocess.check_output([sys.executable, "-c", script])) for _ in range(5))


def main():
    import scalable_isosurface as si

    there = [name for name in PEERS if importlib.util.find_spec(name)]
    paths = [path for name in there if PEERS[name][0] for path in PEERS[name][0]()]
    with open("paths.json", "w", encoding="utf-8") as file:
        json.dump(paths, file)
    orders = {tuple(order) for name in there for order in ((OURS, name), (name, OURS))}
    for order in (*sorted(orders), (OURS, *there), (*there, OURS)):
        run(*order)
    print(f"Python {platform.python_version()}, NumPy {numpy.__version__}, {', '.join(platform.libc_ver())}")
    print(f"beside {', '.join(there)}; not there: {', '.join(PEERS.keys() - set(there)) or 'none'}")
    print(f"read as it is, in both orders: {', '.join(paths)}")
    print(f"import: {measure_import():.0f} ms beside NumPy")
    if "a.h5:/gzip" in paths:
        begin = time.perf_counter()
        surface = si.open("a.h5:/gzip").isosurface(250.5)
        elapsed = 1000 * (time.perf_counter() - begin)
        digest = hashlib.sha256(surface.points.tobytes() + surface.triangles.tobytes()).hexdigest()[:12]
        print(f"surface of HDF5: {len(surface.triangles)} triangles in {elapsed:.0f} ms, {digest}")
    print(f"from {os.path.dirname(si.__file__)}")


if __name__ == "__main__":
    if sys.argv[1:]:
        with open("paths.json", encoding="utf-8") as given:
            use(sys.argv[1:], json.load(given))
    else:
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            main()
            os.chdir("/")
