# SPDX-License-Identifier: BSD-3-Clause
"""How evenly the distributions spread the work of all isosurfaces over stores.

    pvpython load_balance.py --programs BUILD/bin [--output FOLDER] [--large SIDE] [VOLUME ...]

Volumes: .bvol, .mhd, .nrrd or .vti files; else three scans from Debian's packages. Each is read once and
distributed in memory, for every number of stores. Writes into FOLDER (default: the current one):
    load_balance.md    tables of each volume: greatest over mean of the stores
    NAME.csv           for each isovalue with enough triangles a store: totals and greatest
    NAME_balance.png   greatest over mean by isovalue (triangles, active blocks, bytes)
    NAME_stores.png    the load of every store by isovalue, like Figs. 16 to 18 of X. Zhang, C. Bajaj,
                       "Scalable isosurface visualization of massive datasets on commodity
                       off-the-shelf clusters", 2009
"""
import argparse
import itertools
import os
import sys

import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from study_volumes import (  # noqa: E402
    COLORS, add_volume_arguments, prepare, pyplot, read_table, remove_prepared, run, save,
)  # fmt: skip

KINDS = {"triangles": "Triangles", "activeBlocks": "ActiveBlocks", "bytes": "Bytes"}
SIZES = (0, 10, 30, 100, 300)  # active blocks a store
LABELS = {"triangles": "triangles", "activeBlocks": "active blocks", "bytes": "bytes"}


def write_by_size(rows, report):
    """Greatest over mean of the triangles: median and greatest, of ever larger surfaces."""
    methods = [method for method in COLORS if any(row["distribution"] == method for row in rows)]
    report.write("| stores | active blocks a store, at least | isovalues | " + " | ".join(methods))
    report.write(" |\n" + "|---" * (3 + len(methods)) + "|\n")
    for stores, least in itertools.product(sorted({row["stores"] for row in rows}), SIZES):
        ratios = {
            method: [
                row["greatestTriangles"] * stores / row["triangles"]
                for row in rows
                if row["stores"] == stores
                and row["distribution"] == method
                and row["activeBlocks"] >= least * stores
            ]
            for method in methods
        }
        if ratios[methods[0]]:
            cells = [f"{numpy.median(own):.3f}, {max(own):.2f}" for own in ratios.values()]
            count = len(ratios[methods[0]])
            report.write(f"| {stores:g} | {least} | {count} | " + " | ".join(cells) + " |\n")
    report.write("\n")


def plot_balance(rows, name, path):
    """A column a number of stores; greatest over mean of triangles, active blocks and bytes."""
    numbers = sorted({int(row["stores"]) for row in rows})
    figure, axes = pyplot.subplots(
        len(KINDS), len(numbers), figsize=(3.2 * len(numbers), 6.4), squeeze=False, sharex=True
    )
    for column, stores in enumerate(numbers):
        own = [row for row in rows if row["stores"] == stores]
        isovalues = sorted({row["isovalue"] for row in own})
        for line, (kind, greatest) in enumerate(KINDS.items()):
            axis = axes[line][column]
            for method, color in COLORS.items():
                chosen = [row for row in own if row["distribution"] == method]
                ratio = [row["greatest" + greatest] * stores / row[kind] for row in chosen]
                axis.plot([row["isovalue"] for row in chosen], ratio, color=color, lw=0.9, label=method)
            if kind == "triangles":
                chosen = [row for row in own if row["distribution"] == own[0]["distribution"]]
                least = [row["leastGreatestTriangles"] * stores / row[kind] for row in chosen]
                axis.fill_between(isovalues, 1, least, color="#dddddd", label="unavoidable")
                axis.set_title(f"{stores} stores")
            axis.set_yscale("log")
            axis.set_ylim(0.97, 10)
            axis.set_yticks([1.1, 1.5, 2, 5, 10], labels=["1.1", "1.5", "2", "5", "10"])
            axis.minorticks_off()
            axis.axhline(1.1, color="black", lw=0.5, ls=":")
            if column == 0:
                axis.set_ylabel(LABELS[kind])
    axes[-1][0].set_xlabel("isovalue")
    figure.suptitle(f"{name}: greatest over mean of the stores")
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="lower right", ncol=5, fontsize=8)
    save(figure, path)


def plot_stores(rows, name, path):
    """A row a distribution; the curves of all stores, which should be one."""
    methods = [method for method in COLORS if any(row["distribution"] == method for row in rows)]
    figure, axes = pyplot.subplots(
        len(methods), len(KINDS), figsize=(9.6, 2 * len(methods)), squeeze=False, sharex=True
    )
    for line, method in enumerate(methods):
        own = [row for row in rows if row["distribution"] == method]
        stores = int(max(row["store"] for row in own)) + 1
        for column, kind in enumerate(KINDS):
            loads = numpy.array([row[kind] for row in own]).reshape(stores, -1)
            isovalues = numpy.array([row["isovalue"] for row in own]).reshape(stores, -1)
            # As many points as an image shows.
            step = max(1, loads.shape[1] // 512)
            axes[line][column].plot(
                isovalues[:, ::step].T, loads[:, ::step].T, color=COLORS[method], lw=0.4
            )
            if line == 0:
                axes[line][column].set_title(f"{LABELS[kind]} of a store")
        axes[line][0].set_ylabel(method)
    axes[-1][0].set_xlabel("isovalue")
    figure.suptitle(f"{name}: each of {stores} stores")
    figure.tight_layout()
    save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_volume_arguments(parser)
    parser.add_argument("--stores", type=int, nargs="+", default=[8, 32, 96, 1024])
    parser.add_argument("--plotted", type=int, default=32, help="stores in NAME_stores.png")
    parser.add_argument("--least", type=float, default=1000, help="triangles a store that count")
    arguments = parser.parse_args()
    folder = os.path.abspath(arguments.output)
    os.makedirs(folder, exist_ok=True)

    volumes = prepare(arguments, folder)
    with open(os.path.join(folder, "load_balance.md"), "w") as report:
        for name, path in volumes.items():
            table = os.path.join(folder, name + ".csv")
            curves = os.path.join(folder, name + "_stores.csv")
            text = run(
                arguments.programs, "BalanceBenchmark", path, "--scratch", folder,
                "--table", table, "--curves", curves, "--curve-stores", arguments.plotted,
                "--least", arguments.least, "--block-size", arguments.block_size,
                "--stores", *arguments.stores,
            )  # fmt: skip
            report.write(text.replace(path, name) + "\n")
            print(text)
            rows = read_table(table)
            write_by_size(rows, report)
            if pyplot and rows:
                plot_balance(rows, name, os.path.join(folder, name + "_balance.png"))
            if pyplot and arguments.plotted in arguments.stores:
                rows = read_table(curves)
                plot_stores(rows, name, os.path.join(folder, name + "_stores.png"))
            os.remove(curves)
    remove_prepared(volumes, folder)


main()
