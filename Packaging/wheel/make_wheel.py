# SPDX-License-Identifier: BSD-3-Clause
"""Packs what CMake has written to BUILD/wheel, the library of C and the modules of formats as a wheel.

    make_wheel.py BUILD PLATFORM FOLDER [LICENCES]

PLATFORM is the last part of the wheel's name, as manylinux_2_31_x86_64. FOLDER gets the wheel, and, where BUILD/wheel has
the plugin for ParaView in Python, a .zip with that plugin and the same package. LICENCES is a folder with those of all
libraries that are linked in, one a file. The same files make the same archives, byte for byte."""

import base64
import hashlib
import os
import pathlib
import re
import sys
import zipfile

PACKAGE = "scalable_isosurface"
PROJECT = pathlib.Path(__file__).resolve().parents[2]
#: What pyvista.read() takes by our reader: formats of ours, and those that PyVista does not read itself.
PYVISTA = (".bvol", ".eix", ".mrc", ".n5", ".zarr")
DESCRIPTION = """\
    import scalable_isosurface as si

    volume = si.open("scan.nii.gz")  # or .bvol, DICOM, HDF5, NetCDF, Zarr, N5, TIFF, NRRD, MetaImage, MRC, raw, .npy
    volume[150]                      # a slice; only what is needed is read
    volume.isosurface(300).save("bone.stl")

`help(scalable_isosurface)` says more. It needs Linux with glibc and NumPy, and neither VTK nor ParaView.
"""


def list_package(build):
    """Name in the wheel and content of each file of the package."""
    tree = build / "wheel"
    for path in sorted(tree.rglob("*")):
        if path.is_file() and path.parent.name != "__pycache__":
            yield str(path.relative_to(tree)), path.read_bytes()
    for pattern in (f"lib{PACKAGE}.so.[0-9]", "libIsosurface*Format.so", "libIsosurface*Codec.so"):
        for path in sorted(build.glob(f"lib/**/{pattern}")):
            yield f"{PACKAGE}/{path.name}", path.read_bytes()


def write_metadata(version, platform, licences):
    """Name below the folder .dist-info and text of each file that describes the wheel."""
    citation = (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8")
    summary = re.search(r'DESCRIPTION "(.*)"', citation).group(1)
    yield "METADATA", "\n".join([
        "Metadata-Version: 2.4", f"Name: {PACKAGE.replace('_', '-')}", f"Version: {version}", f"Summary: {summary}",
        "License-Expression: BSD-3-Clause", *(f"License-File: {name}" for name in licences),
        "Requires-Python: >=3.8", "Requires-Dist: numpy>=1.17", "Description-Content-Type: text/markdown", "", DESCRIPTION,
    ])  # fmt: skip
    yield "WHEEL", (
        "Wheel-Version: 1.0\nGenerator: make_wheel\nRoot-Is-Purelib: false\n" f"Tag: py3-none-{platform}\n"
    )
    lines = "".join(f"{extension} = {PACKAGE}._pyvista:read\n" for extension in PYVISTA)
    yield "entry_points.txt", "[pyvista.readers]\n" + lines


def main(build, platform, folder, licences=None):
    package = dict(list_package(pathlib.Path(build)))
    version = re.search(r'__version__ = "(.*)"', package[f"{PACKAGE}/__init__.py"].decode()).group(1)
    paths = [PROJECT / "LICENSE", *(sorted(pathlib.Path(licences).iterdir()) if licences else ())]
    texts = {f"licenses/{path.name}": path.read_bytes() for path in paths}
    metadata = {name: text.encode() for name, text in write_metadata(version, platform, [path.name for path in paths])}
    info = f"{PACKAGE}-{version}.dist-info"
    files = {**package, **{f"{info}/{name}": content for name, content in {**metadata, **texts}.items()}}
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    write_archive(f"{folder}/{PACKAGE}-{version}-py3-none-{platform}.whl", files)
    if "ScalableIsosurface.py" in package:
        unpacked = {f"ScalableIsosurface/{name}": content for name, content in {**package, **texts}.items()}
        write_archive(f"{folder}/ScalableIsosurface-{version}-paraview-linux-{os.uname().machine}.zip", unpacked)


def write_archive(path, files):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if ".so" in name else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    print(f"{path}: {os.path.getsize(path):,} bytes")


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:])
