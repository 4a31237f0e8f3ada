#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the cells of a notebook one after another, without Jupyter: run_notebook.py NOTEBOOK PICTURES

Fails unless it makes so many pictures, each with something on it.
"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plot  # noqa: E402
import numpy  # noqa: E402

with open(sys.argv[1], encoding="utf-8") as file:
    cells = [cell for cell in json.load(file)["cells"] if cell["cell_type"] == "code"]
names = {}
for number, cell in enumerate(cells):
    assert not cell["outputs"], "the notebook is kept without outputs"
    exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
for number in plot.get_fignums():
    canvas = plot.figure(number).canvas
    canvas.draw()
    assert numpy.ptp(numpy.asarray(canvas.buffer_rgba())[..., :3]) > 100, f"picture {number} is empty"
assert len(plot.get_fignums()) == int(sys.argv[2]), plot.get_fignums()
print(f"{len(cells)} cells")
