# SPDX-License-Identifier: BSD-3-Clause
"""Packs the Python package, the library of C and the modules of formats of a build folder as a wheel.

    make_wheel.py BUILD PLATFORM FOLDER [LICENCES]

PLATFORM is the last part of the wheel's name, as manylinux_2_31_x86_64. FOLDER gets the wheel. LICENCES is a folder with
those of all libraries that are linked in, one a file. The same files make the same wheel, byte for byte."""

import base64
import hashlib
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
    for path in sorted((build / "wheel" / PACKAGE).iterdir()):
        if path.is_file():
            yield f"{PACKAGE}/{path.name}", path.read_bytes()
    found = [*build.glob("lib/**/lib" + PACKAGE + ".so.[0-9]"), *sorted(build.glob("lib/**/libIsosurface*Format.so"))]
    for path in (*found, *build.glob("lib/**/libIsosurface*Codec.so")):
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
    build = pathlib.Path(build)
    files = dict(list_package(build))
    version = re.search(r'__version__ = "(.*)"', files[f"{PACKAGE}/__init__.py"].decode()).group(1)
    texts = {"LICENSE": PROJECT / "LICENSE"}
    texts.update({path.name: path for path in sorted(pathlib.Path(licences).iterdir())} if licences else {})
    info = f"{PACKAGE}-{version}.dist-info"
    files.update({f"{info}/{name}": text.encode() for name, text in write_metadata(version, platform, texts)})
    files.update({f"{info}/licenses/{name}": path.read_bytes() for name, path in texts.items()})
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()

    wheel = pathlib.Path(folder) / f"{PACKAGE}-{version}-py3-none-{platform}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if ".so" in name else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    print(f"{wheel}: {wheel.stat().st_size:,} bytes")


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:])
