# SPDX-License-Identifier: BSD-3-Clause
"""Whether a wheel is one that pip installs, and runs on every Linux that its name tells, as auditwheel would check.

    check_wheel.py WHEEL [--python-alone]

Needs objdump. --python-alone leaves out what libraries need, which are this system's own then."""

import base64
import email
import hashlib
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

#: What a wheel may need of any Linux.
SYSTEM = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "ld-linux-x86-64.so.2"}
#: What is linked into a library, by the names of the licences, which are those of Debian's packages.
LINKED = {
    "libscalable_isosurface.so.1": {"lz4", "xxhash", "zlib", "libzstd", "nlohmann-json3", "gcc-10"},
    "libIsosurfaceHdf5Format.so": {"hdf5", "libaec", "zlib"},
    "libIsosurfaceNetcdfFormat.so": {"netcdf", "hdf5"},
    "libIsosurfaceTiffFormat.so": {"tiff", "libjpeg-turbo", "libdeflate", "xz-utils", "pugixml"},
    "libIsosurfaceDicomFormat.so": {"gdcm", "openjpeg2"},
    "libIsosurfaceBloscCodec.so": {"c-blosc", "snappy"},
}
MOST_BYTES = 25 << 20


def find_faults_of_files(files, name, version, tag):
    """Of what describes the wheel. `files`: contents by name."""
    info = f"{name}-{version}.dist-info/"
    recorded = [line.rsplit(",", 2) for line in files[info + "RECORD"].decode().splitlines()]
    for path, digest, size in recorded:
        content = files.get(path)
        if content is None:
            yield f"{path} is in RECORD and not in the wheel"
        elif path == info + "RECORD":
            if digest or size:
                yield "RECORD has a hash of itself"
        elif (
            "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=") != digest
            or str(len(content)) != size
        ):
            yield f"{path} is not the file of RECORD"
    for path in files.keys() - {path for path, *_ in recorded}:
        yield f"{path} is not in RECORD"

    metadata = email.message_from_bytes(files[info + "METADATA"])
    if (metadata["Name"].replace("-", "_"), metadata["Version"]) != (name, version):
        yield f"METADATA is of {metadata['Name']} {metadata['Version']}"
    if not any(one.startswith("numpy") for one in metadata.get_all("Requires-Dist", [])):
        yield "METADATA does not ask for NumPy"
    for licence in metadata.get_all("License-File", []):
        if not files.get(f"{info}licenses/{licence}"):
            yield f"the licence {licence} is missing"
    wheel = email.message_from_bytes(files[info + "WHEEL"])
    if wheel["Tag"] != tag or wheel["Root-Is-Purelib"] != "false":
        yield f"WHEEL has the tag {wheel['Tag']}"
    for line in files[info + "entry_points.txt"].decode().splitlines()[1:]:
        module, function = re.fullmatch(r"\.\w+ = ([\w.]+):(\w+)", line).groups()
        source = files.get(module.replace(".", "/") + ".py", b"").decode()
        if f"\ndef {function}(" not in source:
            yield f"there is no {module}:{function}"
    for path in files:
        if "__pycache__" in path or path.split("/")[0] not in (name, info[:-1], "ScalableIsosurface.py"):
            yield f"{path} does not belong into a wheel"


def dump(path, *options):
    return subprocess.run(["objdump", *options, str(path)], check=True, capture_output=True, text=True).stdout


def find_faults_of_library(path, beside, glibc):
    """Of what a library needs and shows. `beside`: the names of the libraries in its folder."""
    header = dump(path, "-p")
    symbols = dump(path, "-T", "-C")
    for needed in set(re.findall(r"NEEDED\s+(\S+)", header)) - SYSTEM - beside:
        yield f"needs {needed}"
    for version in set(re.findall(r"GLIBC_(\d+)\.(\d+)", symbols)):
        if tuple(map(int, version)) > glibc:
            yield f"needs GLIBC_{'.'.join(version)}"
    for name in set(re.findall(r"\b(?:GLIBCXX|CXXABI|GCC)_[\d.]+|GLIBC_PRIVATE", symbols)):
        yield f"needs {name}"
    for folder in re.findall(r"R(?:UN)?PATH\s+(\S+)", header):
        if folder != "$ORIGIN":
            yield f"looks for libraries in {folder}"
    if re.search(r"STACK.*\n.*flags rwx", header):
        yield "asks for an executable stack, which later systems refuse"
    if "TEXTREL" in header:
        yield "has relocations in its code"
    if not re.search(r"file format elf64-x86-64", header):
        yield "is for another processor"
    for line in symbols.splitlines():
        shown = re.match(r"[0-9a-f]{16} ([gwu]).{6} (?!\*UND\*)\S+\s+[0-9a-f]{16}\s+(?:Base\s+)?(.*)", line)
        if shown and not re.match(r"si_\w+$|Isosurface\w+$|isosurface::Hdf5", shown.group(2)):
            yield f"shows the symbol {shown.group(2)}"


def main(path, python_alone):
    path = pathlib.Path(path)
    name, version, *tag = path.stem.split("-")
    with zipfile.ZipFile(path) as archive:
        files = {entry: archive.read(entry) for entry in archive.namelist()}
    faults = [*find_faults_of_files(files, name, version, "-".join(tag))]
    libraries = {entry.split("/")[-1]: entry for entry in files if ".so" in entry}
    faults += [f"{library} is not there" for library in LINKED.keys() - libraries.keys()]
    if path.stat().st_size > MOST_BYTES:
        faults.append(f"has {path.stat().st_size:,} bytes, and may have {MOST_BYTES:,}")
    if not python_alone:
        licences = {entry.split("/")[-1] for entry in files if "/licenses/" in entry}
        faults += [f"the licence of {one} is missing" for one in set().union(*LINKED.values()) - licences]
        glibc = tuple(map(int, re.fullmatch(r"manylinux_(\d+)_(\d+)_x86_64", tag[-1]).groups()))
        with tempfile.TemporaryDirectory() as folder:
            for library, entry in sorted(libraries.items()):
                unpacked = pathlib.Path(folder, library)
                unpacked.write_bytes(files[entry])
                faults += [f"{library} {one}" for one in find_faults_of_library(unpacked, libraries.keys(), glibc)]
                print(f"{library}: {len(files[entry]):,} bytes, packed {archive.getinfo(entry).compress_size:,}")
    if faults:
        sys.exit("\n".join(f"{path.name}: {fault}" for fault in faults))
    print(f"{path.name}: {path.stat().st_size:,} bytes; nothing is wrong with it")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1], "--python-alone" in sys.argv[2:])
