#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""BigTIFF beyond 4 GiB, read by blockvolume: check_tiff.py TOOL MPIEXEC SCRATCH CLAIM"""
import os
import struct
import sys

from sample_volumes import SourceCase, make_samples, run_claim


class BigTiff(SourceCase):
    def test_pages_beyond_4_gib_of_a_sparse_file(self):
        samples = make_samples("uint16", (5, 37, 70))
        for order in "<>":
            with self.subTest(order=order), open(self.path("big.tif"), "wb") as file:
                # Directory and samples of each page 2 GiB after those of the page before.
                places = [16 + (2 << 30) * page for page in range(len(samples))]
                mark = b"II" if order == "<" else b"MM"
                file.write(mark + struct.pack(order + "HHHQ", 43, 8, 0, places[0]))
                for page, place in enumerate(places):
                    data = samples[page].astype(samples.dtype.newbyteorder(order)).tobytes()
                    tags = [(256, 70), (257, 37), (258, 16), (259, 1), (262, 1), (273, place + 4096),
                            (277, 1), (278, 37), (279, len(data)), (339, 1)]
                    text = struct.pack(order + "Q", len(tags))
                    for tag, value in tags:
                        text += struct.pack(order + "HHQQ", tag, 16, 1, value)
                    text += struct.pack(order + "Q", (places + [0])[page + 1])
                    file.seek(place)
                    file.write(text)
                    file.seek(place + 4096)
                    file.write(data)
                file.flush()
                self.assertGreater(os.path.getsize(file.name), 8 << 30)
                self.assert_equal_volumes(
                    self.write("big.tif", "o.bvol", ranks=2 if order == "<" else 1),
                    self.write_raw(samples, "Tiff Scalars"))


if __name__ == "__main__":
    sys.exit(run_claim(sys.argv, globals()))
