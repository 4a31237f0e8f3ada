#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""An OME-Zarr behind a server far away: to a picture, to a part of the exact surface, to all of it.

    address.py [FOLDER] [--side N] [--latency MS] [--rate MBIT] [--isovalue V] [--jobs NAME ...] [--timeline]

Writes an OME-Zarr of N^3 int16 (2048: 17 GB; chunks of 64, blosc lz4, levels down to 128 or less) into the folder,
unless it is there. nginx (package nginx-light) serves it, behind a proxy of this script that delays each request and
limits the rate of all connections together. Then, each in a process of its own with an empty cache:

    picture   a sample of all of it, contoured
    finer     the same, and the finer sample that follows (ours)
    part      the exact surface in a box of 1 % of the volume
    all       the exact surface

of ours (Volume Reader and Isosurface; scalable_isosurface), and of zarr with fsspec and aiohttp (python3-zarr, -fsspec,
-aiohttp) with vtkFlyingEdges3D, which reads the coarsest level, the box, all. Counts bytes and requests at the proxy; --timeline tells when each request
came there.
"""
import argparse
import asyncio
import json
import multiprocessing
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from first_contact import make_slabs

CHUNK = 64
PIPE = 1 << 16


def write(path, side):
    import numcodecs
    import numpy
    import zarr

    levels = max(1, (side // 128).bit_length())
    store = zarr.open_group(path, mode="w")
    arrays = [store.create_dataset(str(level), shape=[side >> level] * 3, chunks=[CHUNK] * 3, dtype="i2",
                                   compressor=numcodecs.Blosc("lz4"), dimension_separator="/") for level in range(levels)]
    for first, samples in make_slabs([side] * 3):
        for level, array in enumerate(arrays):
            array[first >> level:(first >> level) + len(samples)] = samples
            samples = (sum(samples[z::2, y::2, x::2].astype("f4") for z, y, x in numpy.ndindex(2, 2, 2)) / 8).astype("i2")
    store.attrs["multiscales"] = [{
        "version": "0.4", "axes": [{"name": name, "type": "space"} for name in "zyx"],
        "datasets": [{"path": str(level), "coordinateTransformations": [
            {"type": "scale", "scale": [2.0 ** level] * 3},
            {"type": "translation", "translation": [2.0 ** level / 2 - 0.5] * 3}]} for level in range(levels)]}]


class Proxy:
    """Passes connections on: what clients send later, what the server sends no faster than the rate."""

    def __init__(self, port, server, latency, rate, counts, tells):
        self.port, self.server, self.latency, self.rate, self.counts = port, server, latency, rate, counts
        self.tells = tells
        self.free = self.last = 0.0

    async def delay(self, reader, writer):
        waiting = asyncio.Queue()

        async def send():
            while True:
                due, data = await waiting.get()
                await asyncio.sleep(due - time.monotonic())
                if not data:
                    return writer.close()
                writer.write(data)

        sender = asyncio.ensure_future(send())
        while data := await reader.read(PIPE):
            self.counts[0] += data.count(b"GET /")
            if self.tells:
                self.tell(data)
            waiting.put_nowait((time.monotonic() + self.latency, data))
        waiting.put_nowait((time.monotonic(), b""))
        await sender

    def tell(self, data):
        now = time.monotonic()
        if now - self.last > 2:
            self.begin = now
        self.last = now
        for line in (line for line in data.split(b"\r\n") if line.startswith((b"GET /", b"Range"))):
            told = f"{now - self.begin:7.3f} {self.counts[1] / 1e6:7.2f} MB {line.decode()[:100]}"
            print(told, file=sys.stderr, flush=True)

    async def limit(self, reader, writer):
        while data := await reader.read(PIPE):
            self.counts[1] += len(data)
            self.free = max(self.free, time.monotonic()) + len(data) / self.rate
            await asyncio.sleep(self.free - time.monotonic())
            writer.write(data)
            await writer.drain()
        writer.close()

    async def connect(self, reader, writer):
        try:
            far = await asyncio.open_connection("127.0.0.1", self.server)
            await asyncio.gather(self.delay(reader, far[1]), self.limit(far[0], writer))
        except OSError:
            writer.close()

    def run(self):
        async def serve():
            await (await asyncio.start_server(self.connect, "127.0.0.1", self.port)).serve_forever()

        asyncio.run(serve())


def find_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def start_nginx(folder, work, port):
    with open(os.path.join(work, "nginx.conf"), "w") as file:
        file.write(f"""daemon off; pid {work}/pid; error_log {work}/log; worker_processes 1; events {{}}
http {{ access_log off; client_body_temp_path {work}/a; proxy_temp_path {work}/b; fastcgi_temp_path {work}/c;
uwsgi_temp_path {work}/d; scgi_temp_path {work}/e; keepalive_requests 1000000;
server {{ listen 127.0.0.1:{port}; root {folder}; default_type application/octet-stream; }} }}
""")
    os.chmod(work, 0o755)
    nginx = shutil.which("nginx") or "/usr/sbin/nginx"
    # It ends with this process, however that ends.
    user = ["-g", "user root;"] if os.geteuid() == 0 else []
    return subprocess.Popen(["setpriv", "--pdeathsig", "TERM", nginx, "-p", work, "-c", f"{work}/nginx.conf", *user])


def find_box(side):
    """The first and the behind-last vertex of a cube of 1 % on each axis, where the ball's surface is."""
    length = round(side * 0.01 ** (1 / 3))
    low = (side // 2 + side // 4 - length // 2, side // 2 - length // 2, side // 2 - length // 2)
    return [(begin, begin + length) for begin in low]


def run_ours(job, address, side, isovalue):
    import scalable_isosurface as si

    if job in ("picture", "finer"):
        reader = si.vtkInPlaceVolumeReader()
        reader.SetSourceName(address)
        reader.AllowCoarse(True)
        contour = si.vtkStabbingContour()
        contour.SetInputConnection(reader.GetOutputPort())
        contour.SetValue(0, isovalue)
        contour.Update()
        if job == "finer":
            while reader.GetRefinement()[0] == 1:
                reader.AdvanceIndex(20)
            reader.TakeIndex()
            contour.Update()
        return contour.GetOutput().GetNumberOfPolys()
    if job == "part":
        region = [float(end - number) for low, high in find_box(side) for number, end in enumerate((low, high))]
        return len(si.open(address).isosurface(isovalue, region=region, normals=False).triangles)
    return len(si.index(address).isosurface(isovalue, normals=False).triangles)


def run_peer(job, address, side, isovalue):
    import zarr
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    group = zarr.open_group(address, mode="r")
    paths = [level["path"] for level in group.attrs["multiscales"][0]["datasets"]]
    box = tuple(slice(*ends) for ends in reversed(find_box(side))) if job == "part" else ...
    samples = group[paths[-1 if job == "picture" else 0]][box]
    image = vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel()))
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, isovalue)
    contour.ComputeNormalsOff()
    contour.Update()
    return contour.GetOutput().GetNumberOfPolys()


def run_job(who, job, address, side, isovalue):
    run = {"ours": run_ours, "zarr": run_peer}[who]
    __import__("scalable_isosurface" if who == "ours" else "zarr")
    begin = time.perf_counter()
    triangles = run(job, address, side, isovalue)
    with open("/proc/self/status") as status:  # getrusage has the parent's, too
        peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1e3
    print(json.dumps([time.perf_counter() - begin, triangles, peak]), flush=True)
    os._exit(0)  # an index that grows beside the picture is not waited for


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="/var/tmp/address")
    parser.add_argument("--side", type=int, default=2048)
    parser.add_argument("--latency", type=float, default=60)
    parser.add_argument("--rate", type=float, default=200)
    parser.add_argument("--isovalue", type=float, default=1000)
    parser.add_argument("--jobs", nargs="+", default=["picture", "finer", "part", "all"])
    parser.add_argument("--timeline", action="store_true")
    parser.add_argument("--who", nargs="+", default=["ours", "zarr"])
    parser.add_argument("--job", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--address", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.job:
        return run_job(*given.job, given.address, given.side, given.isovalue)
    name = f"ball-{given.side}.zarr"
    path = os.path.join(given.folder, name)
    if not os.path.exists(path):
        write(path + ".part", given.side)
        os.rename(path + ".part", path)
    counts = multiprocessing.Array("q", 2, lock=False)
    near, far = find_port(), find_port()
    with tempfile.TemporaryDirectory() as work:
        nginx = start_nginx(os.path.abspath(given.folder), work, near)
        proxy = Proxy(far, near, given.latency / 1e3, given.rate * 1e6 / 8, counts, given.timeline)
        multiprocessing.Process(target=proxy.run, daemon=True).start()
        time.sleep(1)
        print(f"{'':14} {'seconds':>9} {'MB':>8} {'requests':>9} {'peak MB':>8} {'triangles':>11}")
        try:
            for job in given.jobs:
                for who in given.who if job != "finer" else ["ours"]:
                    counts[:] = [0, 0]
                    environment = {**os.environ, "SCALABLE_ISOSURFACE_CACHE": os.path.join(work, f"cache-{who}-{job}")}
                    command = [sys.executable, __file__, "--side", str(given.side), "--isovalue", str(given.isovalue),
                               "--job", who, job, "--address", f"http://127.0.0.1:{far}/{name}"]
                    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
                    told = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else [0, 0, 0]
                    print(f"{who:5} {job:8} {told[0]:9.2f} {counts[1] / 1e6:8.1f} {counts[0]:9} {told[2]:8.0f}"
                          f" {told[1]:11}", flush=True)
        finally:
            nginx.terminate()
            nginx.wait()


if __name__ == "__main__":
    main()
