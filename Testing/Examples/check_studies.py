# SPDX-License-Identifier: BSD-3-Clause
"""Checks what the studies wrote: check_studies.py load_balance|scaling_study FOLDER NAME

load_balance: in the table of the volume NAME every greatest load is at least the mean and the least
possible one; all distributions have the same totals; by the median of all isovalues the balanced
one is the most even, slab the least. scaling_study: predictions fall with the number of ranks, by
at most as much as there are ranks; the measured shares add up to the same surface, however many
ranks there are. Both: the plots are there if matplotlib is.
"""
import csv
import os
import re
import statistics
import sys

study, folder, name = sys.argv[1:4]
failures = []


def expect(condition, message):
    if not condition:
        failures.append(message)


def read_tables(path):
    """Markdown -> the rows of all tables, a dictionary each."""
    tables = []
    columns = None
    for line in open(path):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            columns = None
        elif columns is None:
            columns = cells
        elif not set(line.strip()) <= set("|-"):
            tables.append(dict(zip(columns, cells)))
    return tables


def check_load_balance():
    with open(os.path.join(folder, name + ".csv"), newline="") as table:
        rows = list(csv.DictReader(table))
    totals = {}
    ratios = {}
    for row in rows:
        stores = int(row["stores"])
        for kind in ("triangles", "activeBlocks", "bytes"):
            total = int(row[kind])
            greatest = int(row["greatest" + kind[0].upper() + kind[1:]])
            expect(total <= greatest * stores, f"greatest below the mean: {row}")
            expect(greatest <= total, f"greatest beyond the total: {row}")
            expect(
                totals.setdefault((row["isovalue"], kind), total) == total,
                f"totals differ: {row}",
            )
        greatest = int(row["greatestTriangles"])
        expect(greatest >= int(row["leastGreatestTriangles"]), f"better than possible: {row}")
        ratios.setdefault((stores, row["distribution"]), []).append(
            greatest * stores / int(row["triangles"])
        )
    expect(len({stores for stores, _ in ratios}) == 2, "there should be two numbers of stores")
    for stores in {stores for stores, _ in ratios}:
        median = {
            method: statistics.median(ratios[stores, method])
            for method in ("slab", "random", "greedy", "balanced")
        }
        expect(
            median["balanced"] < median["greedy"] < median["random"] < median["slab"],
            f"{stores} stores: {median}",
        )


def check_scaling_study():
    tables = read_tables(os.path.join(folder, "scaling_study.md"))
    checked = [row for row in tables if "measured s" in row]
    expect({row["ranks"] for row in checked} >= {"1", "2"}, "1 and 2 ranks should be measured")
    for isovalue in {row["isovalue"] for row in checked}:
        own = {row["triangles"] for row in checked if row["isovalue"] == isovalue}
        expect(len(own) == 1, f"isovalue {isovalue}: triangles depend on ranks: {own}")
    for row in checked:
        expect(float(row["predicted s"]) > 0, f"nothing predicted: {row}")
    predicted = [row for row in tables if "4096" in row]
    expect(len(predicted) == 12, "3 isovalues, 2 distributions, cold and warm should be predicted")
    for row in predicted:
        speedups = {
            int(ranks): float(cell.split(",")[1])
            for ranks, cell in row.items()
            if re.fullmatch("[0-9]+", ranks)
        }
        expect(speedups[1] == 1, f"one rank is the reference: {row}")
        for ranks, speedup in speedups.items():
            expect(0 < speedup <= 1.01 * ranks, f"impossible: {row}")
        # Whatever a block costs here: each of two ranks has fewer of them.
        expect(speedups[2] > 1, f"two ranks should speed up: {row}")


try:
    import matplotlib  # noqa: F401

    plots = {"load_balance": ("balance", "stores"), "scaling_study": ("scaling",)}[study]
    for plot in plots:
        path = os.path.join(folder, f"{name}_{plot}.png")
        expect(os.path.exists(path) and os.path.getsize(path) > 5000, f"{path} is missing")
except ImportError:
    print("without matplotlib: no plots to check")
{"load_balance": check_load_balance, "scaling_study": check_scaling_study}[study]()
sys.exit("\n".join(failures[:20]) or 0)
