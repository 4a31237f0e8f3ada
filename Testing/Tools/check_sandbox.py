#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""blockvolume --sandbox, with a libtiff that has faults: check_sandbox.py TOOL MPIEXEC SCRATCH CLAIM FAULTY_TIFF"""
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib

from sample_volumes import WAIT_SECONDS, SourceCase, list_files, make_samples, remove_volume, run_claim

FAULTY_TIFF = sys.argv.pop()


def write_tiff(path, samples):
    """A page a slice, of deflated strips of one row each."""
    with open(path, "wb") as file:
        file.write(struct.pack("<2sHI", b"II", 42, 8))
        depth, height, width = samples.shape
        for page in range(depth):
            rows = [zlib.compress(row.tobytes()) for row in samples[page]]
            tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 4, 1, 8 * samples.itemsize),
                    (259, 4, 1, 8), (262, 4, 1, 1), (273, 4, height, 0), (277, 4, 1, 1), (278, 4, 1, 1),
                    (279, 4, height, 0)]
            lists = file.tell() + 2 + 12 * len(tags) + 4
            data = lists + 8 * height
            ends = [data + sum(len(row) for row in rows[:count]) for count in range(height + 1)]
            tags[5], tags[8] = (273, 4, height, lists), (279, 4, height, lists + 4 * height)
            file.write(struct.pack("<H", len(tags)))
            for tag in tags:
                file.write(struct.pack("<HHII", *tag))
            file.write(struct.pack("<I", ends[-1] if page + 1 < depth else 0))
            file.write(struct.pack(f"<{height}I", *ends[:-1]))
            file.write(struct.pack(f"<{height}I", *(len(row) for row in rows)) + b"".join(rows))


class TheSameBytes(SourceCase):
    def test_of_each_way_to_read(self):
        samples = make_samples("uint16")
        write_tiff(self.path("a.tif"), samples)
        raw = self.write_raw(samples, "Tiff Scalars")
        for arguments in ((), ("--in-place",), ("--threads", "3", "--compression", "zstd:3")):
            expected = self.write("a.tif", "a.bvol", *arguments)
            if not arguments:
                self.assert_equal_volumes(expected, raw)
            self.assert_equal_volumes(self.write("a.tif", "b.bvol", "--sandbox", *arguments), expected)
        self.assert_equal_volumes(
            self.write_raw(samples, "Tiff Scalars", "--sandbox", name="sandbox"), raw)

    def test_of_time_steps_that_are_appended(self):
        for name, option in (("a.bvol", ()), ("b.bvol", ("--sandbox",))):
            remove_volume(self.path(name))
            for step, phase in enumerate((0.0, 0.4)):
                write_tiff(self.path("a.tif"), make_samples("uint8", phase=phase))
                code, _, err = self.run_tool("a.tif", name, "--append", "--time", str(step), *option)
                self.assertEqual(code, 0, err)
        self.assert_equal_volumes(self.path("b.bvol"), self.path("a.bvol"))

    def test_of_what_other_commands_tell(self):
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        path = self.write("a.tif", "a.bvol", "--in-place")
        for arguments in (("--info", path), ("--info", path, "--json"), ("--verify", path, "--quiet"),
                          ("--version",)):
            with self.subTest(arguments=arguments):
                plain = self.run_tool(*arguments)
                self.assertEqual(plain[0], 0)
                self.assertEqual(self.run_tool("--sandbox", *arguments), plain)

    def test_within_bubblewrap(self):
        os.makedirs(self.path("out"), exist_ok=True)
        wrapped = ["bwrap", "--ro-bind", "/", "/", "--dev", "/dev", "--bind", self.path("out"), self.path("out"),
                   "--chdir", self.scratch, "--unshare-all", "--die-with-parent"]
        if not shutil.which("bwrap") or subprocess.run([*wrapped, "true"], check=False).returncode != 0:
            self.skipTest("no bwrap, or no user namespaces")
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        for path, code in (("out/b.bvol", 0), ("b.bvol", 1)):
            done = subprocess.run([*wrapped, self.tool, "--sandbox", "--quiet", "a.tif", path], cwd=self.scratch,
                                  capture_output=True, text=True, timeout=WAIT_SECONDS)
            self.assertEqual(done.returncode, code, done.stderr)
        self.assertRegex(done.stderr, r"^blockvolume: [^\n]*[Rr]ead-only[^\n]*\n$")
        remove_volume(self.path("a.bvol"))
        self.assertEqual(self.run_tool("--quiet", "a.tif", "a.bvol"), (0, "", ""))
        self.assert_equal_volumes(self.path("out/b.bvol"), self.path("a.bvol"))


class FaultsOfALibraryAreErrors(SourceCase):
    FAULTS = (("crash", "the process that read it crashed (Segmentation fault)"),
              ("abort", "the process that read it crashed (Aborted)"),
              ("memory", "the process that read it crashed (Segmentation fault)"),
              ("loop", "took 1 s of processor time without progress"),
              ("exit", "a library that read it ended the process"))

    def run_faulty(self, fault, *arguments):
        environment = dict(os.environ, LD_PRELOAD=FAULTY_TIFF, FAULT=fault)
        seconds = "1" if fault == "loop" else "60"  # on a busy machine others take more than one, too
        return subprocess.run([self.tool, *arguments, "--sandbox", "--sandbox-memory", "500",
                               "--sandbox-seconds", seconds], env=environment, cwd=self.scratch,
                              capture_output=True, text=True, timeout=WAIT_SECONDS)

    def check(self, fault, reason, *arguments):
        done = self.run_faulty(fault, "a.tif", "e.bvol", *arguments)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stdout, "")
        lines = [line for line in done.stderr.splitlines() if not line.startswith("e.bvol: ")]
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertTrue(lines[0].startswith(f"blockvolume: a.tif: {reason}"), lines[0])

    def test_that_leave_nothing(self):
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        before = sorted(os.listdir(self.scratch))
        for fault, reason in self.FAULTS:
            for arguments in ((), ("--in-place",)):
                with self.subTest(fault=fault, arguments=arguments):
                    self.check(fault, reason, *arguments)
                    self.assertEqual(sorted(os.listdir(self.scratch)), before)

    def test_that_leave_the_volume_that_was_there(self):
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        path = self.write("a.tif", "e.bvol", "--time", "0")

        def read_all():
            files = {}
            for name, file in list_files(path).items():
                with open(file, "rb") as opened:
                    files[name] = opened.read()
            return files

        whole = read_all()
        for fault, reason in self.FAULTS:
            for arguments in ((), ("--append", "--time", "1")):
                with self.subTest(fault=fault, arguments=arguments):
                    self.check(fault, reason, "--stores", "3", *arguments)
                    self.assertEqual(read_all(), whole)
        self.assert_equal_volumes(self.write("a.tif", "e.bvol", "--time", "0"), path)

    def test_that_read_a_volume_in_place(self):
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        path = self.write("a.tif", "e.bvol", "--in-place")
        done = self.run_faulty("crash", "--verify", path)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"blockvolume: {path}: the process that read it crashed", done.stderr)
        self.assertEqual(self.run_tool("--verify", path, "--quiet"), (0, "", ""))

    def test_that_come_before_the_file_is_there(self):
        self.assert_error("none.tif", "none.tif: ", arguments=["--sandbox"])


class EndsWithTheProcessThatWaits(SourceCase):
    def start(self):
        """A run, the number of its process that reads, and the folder that it fills."""
        folder = self.path(".s.bvol.stores")
        shutil.rmtree(folder, ignore_errors=True)
        with open(self.path("large.raw"), "wb") as file:  # sparse
            file.truncate(1 << 30)
        run = subprocess.Popen(
            [self.tool, "large.raw", "s.bvol", "--dimensions", "1024,1024,1024", "--memory", "100",
             "--compression", "zstd:19", "--block-size", "16", "--quiet", "--sandbox"],
            cwd=self.scratch, stderr=subprocess.PIPE, text=True)
        end = time.monotonic() + WAIT_SECONDS
        while not (os.path.isdir(folder) and os.listdir(folder)) and time.monotonic() < end:
            time.sleep(0.02)
        with open(f"/proc/{run.pid}/task/{run.pid}/children", encoding="ascii") as file:
            return run, int(file.read()), folder

    def test_that_is_told_to_stop(self):
        for name in (signal.SIGINT, signal.SIGTERM):
            run, _, folder = self.start()
            run.send_signal(name)
            told = run.communicate(timeout=WAIT_SECONDS)[1]
            self.assertEqual(run.returncode, 130, told)
            self.assertRegex(told, r"^blockvolume: [^\n]*\n$")
            self.assertFalse(os.path.exists(folder))

    def test_that_is_killed(self):
        run, reader, _ = self.start()
        run.kill()
        run.communicate(timeout=WAIT_SECONDS)
        end = time.monotonic() + WAIT_SECONDS
        while os.path.exists(f"/proc/{reader}") and time.monotonic() < end:
            time.sleep(0.02)
        self.assertFalse(os.path.exists(f"/proc/{reader}"))

    def test_and_is_cleaned_behind_if_it_is_killed(self):
        run, reader, folder = self.start()
        os.kill(reader, signal.SIGKILL)
        told = run.communicate(timeout=WAIT_SECONDS)[1]
        self.assertEqual(run.returncode, 1, told)
        self.assertRegex(told, r"^blockvolume: large.raw: the process that read it was killed[^\n]*\n$")
        self.assertFalse(os.path.exists(folder))

    def test_or_is_refused_on_several_ranks(self):
        write_tiff(self.path("a.tif"), make_samples("uint16"))
        self.assert_error("a.tif", "--sandbox: ranks share one job", arguments=["--sandbox"], ranks=2)
        self.assertEqual(self.run_tool("a.tif", "o.bvol", "--sandbox", "--quiet"), (0, "", ""))


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
