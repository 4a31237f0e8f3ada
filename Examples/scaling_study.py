# SPDX-License-Identifier: BSD-3-Clause
"""How extraction would speed up on thousands of ranks: a prediction, from measured costs.

    pvpython scaling_study.py --programs BUILD/bin [--output FOLDER] [--large SIDE] [VOLUME ...]

The model is BSP-Disk (X. Zhang, C. Bajaj, "Scalable isosurface visualization of massive datasets on
commodity off-the-shelf clusters", 2009, section 4 there): P ranks with a disk and a store each take

    T <= max Tw + max Tio + max Tc

for computation, disk and messages. Extraction sends none, so Tc = 0. Tw and Tio follow from the
store's active blocks, their bytes and its triangles, of which the greatest of all stores are known
for every isovalue and any number of stores (BalanceBenchmark); and from the seconds that a block, a
byte and a triangle cost, fitted to runs on this machine (QueryCostBenchmark). Runs at other
isovalues check that: of 1 and 2 ranks at once, and of the shares of more ranks, one after another.

Volumes: .bvol, .mhd, .nrrd or .vti files; else Debian's scans. Writes into FOLDER (default: the
current one):
    scaling_study.md   costs, check and prediction
    NAME_scaling.png   seconds and speed-up by ranks, like Figs. 14 and 18a of the paper
"""
import argparse
import itertools
import os
import sys

import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from study_volumes import (  # noqa: E402
    add_volume_arguments, prepare, pyplot, read_table, remove_prepared, run, save,
)  # fmt: skip

CACHES = ("cold", "warm")
# The parts of a rank's seconds, and what they are in proportion to. Computation is what the processor
# takes, decoding and system calls included; disk is the rest: waiting.
KINDS = ("rank", "store", "block", "byte", "triangle")
PARTS = {
    "computation, warm": KINDS,
    "computation, cold": KINDS,
    "disk, cold": ("store", "block", "byte"),
}


def fit(amounts, parts, seconds):
    """Least squares of errors relative to the whole seconds; no cost is negative. amounts: a column
    a kind."""
    scaled = amounts / seconds[:, None]
    best, least = numpy.zeros(amounts.shape[1]), numpy.inf
    for count in range(1, amounts.shape[1] + 1):
        for kinds in itertools.combinations(range(amounts.shape[1]), count):
            costs = numpy.linalg.lstsq(scaled[:, kinds], parts / seconds, rcond=None)[0]
            error = numpy.sum((scaled[:, kinds] @ costs - parts / seconds) ** 2)
            if costs.min() >= 0 and error < least:
                best, least = numpy.zeros(amounts.shape[1]), error
                best[list(kinds)] = costs
    return best


class CostModel:
    """Seconds of a rank's share."""

    def __init__(self, shares):
        self.costs = {}
        for name, kinds in PARTS.items():
            part, cache = name.split(", ")
            own = [share for share in shares if share["cache"] == cache and share["triangle"] > 0]
            costs = fit(
                numpy.array([[share[kind] for kind in kinds] for share in own]),
                numpy.array([share[part] for share in own]),
                numpy.array([share["seconds"] for share in own]),
            )
            self.costs[name] = dict(zip(kinds, costs))

    def predict_part(self, share, part):
        return sum(cost * share[kind] for kind, cost in self.costs[part].items())

    def predict(self, share, cache):
        parts = [part for part in PARTS if part.endswith(cache)]
        return sum(self.predict_part(share, part) for part in parts)

    def predict_one_disk(self, shares):
        """Cold, of ranks that wait for each other at one disk."""
        return max(self.predict_part(share, "computation, cold") for share in shares) + sum(
            self.predict_part(share, "disk, cold") for share in shares
        )


def read_shares(text):
    """The rows of QueryCostBenchmark, of repeated runs the fastest."""
    shares = {}
    for row in read_table(text):
        row["ranks"] = int(row["ranks"])
        row["rank number"] = row["rank"]
        row["rank"] = 1
        row["store"] = max(1, row["stores"] / row["ranks"])
        row["block"] = row["activeBlocks"]
        row["byte"] = row["bytes"]
        row["triangle"] = row["triangles"]
        row["computation"] = min(row["cpuSeconds"], row["seconds"])
        row["disk"] = row["seconds"] - row["computation"]
        key = tuple(row[kind] for kind in ("mode", "cache", "isovalue", "ranks", "rank number"))
        if key not in shares or shares[key]["seconds"] > row["seconds"]:
            shares[key] = row
    return list(shares.values())


def group_runs(shares):
    """(mode, cache, isovalue, ranks) -> the shares of that run."""
    runs = {}
    for share in shares:
        key = tuple(share[name] for name in ("mode", "cache", "isovalue", "ranks"))
        runs.setdefault(key, []).append(share)
    return runs


def choose_isovalues(loads, count, most):
    """Isovalues of the spectrum, from few triangles to at most `most`, sorted by triangles: every
    other one, the first and last too, is to fit; the `count` between them are to check."""
    least = min(load["stores"] for load in loads)
    rows = [load for load in loads if load["stores"] == least and load["triangles"] <= most]
    rows.sort(key=lambda row: row["triangles"])
    if not rows:
        raise SystemExit("no isosurface is as small as --most")
    wanted = numpy.geomspace(rows[-1]["triangles"] / 50, rows[-1]["triangles"], 2 * count + 1)
    chosen = numpy.searchsorted([row["triangles"] for row in rows], wanted)
    return [rows[min(n, len(rows) - 1)]["isovalue"] for n in chosen]


def predict(model, loads, method, isovalue, cache):
    """Ranks -> seconds, by the greatest load of a store of each kind."""
    return {
        int(load["stores"]): model.predict(
            {"rank": 1, "store": 1, "block": load["greatestActiveBlocks"],
             "byte": load["greatestBytes"], "triangle": load["greatestTriangles"]}, cache,
        )
        for load in loads
        if load["distribution"] == method and load["isovalue"] == isovalue
    }  # fmt: skip


def write_costs(model, report):
    report.write("| costs | " + " | ".join("ns a " + kind for kind in KINDS) + " |\n")
    report.write("|---" * (len(KINDS) + 1) + "|\n")
    for part, costs in model.costs.items():
        cells = [f"{1e9 * costs[kind]:.4g}" if kind in costs else "" for kind in KINDS]
        report.write(f"| {part} | " + " | ".join(cells) + " |\n")
    report.write("\n")


def write_check(model, runs, report):
    report.write(
        "| isovalue | triangles | ranks | run | cache | measured s | predicted s | predicted s, "
        "one disk for all | predicted / measured |\n|---|---|---|---|---|---|---|---|---|\n"
    )
    for (mode, cache, isovalue, ranks), shares in sorted(
        runs.items(), key=lambda item: (item[0][2], item[0][3], item[0][0], item[0][1])
    ):
        measured = max(share["seconds"] for share in shares)
        predicted = max(model.predict(share, cache) for share in shares)
        one_disk = ""
        if cache == "cold" and mode == "together" and ranks > 1:
            one_disk = f"{model.predict_one_disk(shares):.4f}"
        triangles = int(sum(share["triangles"] for share in shares))
        report.write(
            f"| {isovalue:g} | {triangles:,} | {ranks} | {mode} | {cache} | {measured:.4f} "
            f"| {predicted:.4f} | {one_disk} | {predicted / measured:.2f} |\n"
        )
    report.write("\n")


def write_prediction(model, loads, isovalues, report):
    numbers = sorted({int(load["stores"]) for load in loads})
    triangles = {load["isovalue"]: int(load["triangles"]) for load in loads}
    report.write("Predicted, a disk and a store a rank: seconds, speed-up\n\n")
    report.write("| isovalue | triangles | distribution | cache | ")
    report.write(" | ".join(str(number) for number in numbers) + " |\n")
    report.write("|---" * (4 + len(numbers)) + "|\n")
    methods = sorted({load["distribution"] for load in loads})
    for isovalue, method, cache in itertools.product(isovalues, methods, CACHES):
        seconds = predict(model, loads, method, isovalue, cache)
        cells = [f"{seconds[n]:.3g}, {seconds[1] / seconds[n]:.3g}" for n in numbers]
        report.write(f"| {isovalue:g} | {triangles[isovalue]:,} | {method} | {cache} | ")
        report.write(" | ".join(cells) + " |\n")
    report.write("\n")


def plot_scaling(model, loads, runs, isovalues, name, path):
    figure, (time, speed) = pyplot.subplots(1, 2, figsize=(9.6, 4.2))
    ranks = sorted({int(load["stores"]) for load in loads})
    speed.plot(ranks, ranks, color="black", lw=0.6, label="ideal")
    for isovalue, color in zip(isovalues, ("#3b76af", "#d1832c", "#3a8f4d")):
        for cache, style in zip(CACHES, ("-", "--")):
            seconds = predict(model, loads, "balanced", isovalue, cache)
            label = f"isovalue {isovalue:g}, {cache}"
            time.plot(ranks, [seconds[n] for n in ranks], style, color=color, lw=1, label=label)
            speedup = [seconds[ranks[0]] / seconds[n] for n in ranks]
            speed.plot(ranks, speedup, style, color=color, lw=1, label=label)
            for mode, marker in (("in turn", "o"), ("together", "x")):
                measured = {
                    key[3]: max(share["seconds"] for share in shares)
                    for key, shares in runs.items()
                    if key[:3] == (mode, cache, isovalue)
                }
                if not measured:
                    continue
                filled = {"color": color, "mfc": color if cache == "cold" else "white"}
                time.plot(*zip(*sorted(measured.items())), marker, ms=5, **filled)
                if 1 in measured:
                    ratios = [(n, measured[1] / own) for n, own in sorted(measured.items())]
                    speed.plot(*zip(*ratios), marker, ms=5, **filled)
    random = predict(model, loads, "random", isovalues[-1], "cold")
    speed.plot(ranks, [random[ranks[0]] / random[n] for n in ranks], ":", color="#777777",
               label=f"isovalue {isovalues[-1]:g}, cold, random")  # fmt: skip
    for axis, label in ((time, "seconds"), (speed, "speed-up")):
        axis.set_xscale("log", base=2)
        axis.set_yscale("log")
        axis.set_xlabel("ranks")
        axis.set_ylabel(label)
        axis.legend(fontsize=7)
    time.set_title("lines: predicted; measured: o in turn, x at once, filled cold", fontsize=9)
    speed.set_title("balanced distribution, but for the dotted line", fontsize=9)
    figure.suptitle(f"{name}: a prediction, from costs measured on one machine")
    figure.tight_layout()
    save(figure, path)


def study(name, path, arguments, folder, report):
    table = os.path.join(folder, name + "_loads.csv")
    ranks = [2**n for n in range(13)]
    common = ("--scratch", folder, "--block-size", arguments.block_size)
    run(
        arguments.programs, "BalanceBenchmark", path, *common, "--table", table, "--least", 0,
        "--distributions", "random", "balanced", "--stores", *ranks,
    )  # fmt: skip
    loads = read_table(table)
    os.remove(table)
    isovalues = choose_isovalues(loads, arguments.isovalues, arguments.most)
    text = run(
        arguments.programs, "QueryCostBenchmark", path, *common, "--stores", arguments.stores,
        "--repeats", arguments.repeats, "--together", 1, 2, "--in-turn", *arguments.in_turn,
        "--isovalues", *[repr(isovalue) for isovalue in isovalues],
    )  # fmt: skip
    shares = read_shares(text)
    fitted, checked = isovalues[0::2], isovalues[1::2]
    model = CostModel(
        [row for row in shares if row["mode"] == "in turn" and row["isovalue"] in fitted]
    )
    runs = group_runs(row for row in shares if row["isovalue"] in checked)
    largest = max(loads, key=lambda load: load["triangles"])["isovalue"]
    shown = [checked[0], checked[-1], largest]
    report.write(f"## {name}\n\n")
    write_costs(model, report)
    write_check(model, runs, report)
    write_prediction(model, loads, shown, report)
    if pyplot:
        plot_scaling(
            model, loads, runs, shown, name, os.path.join(folder, name + "_scaling.png")
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_volume_arguments(parser)
    parser.add_argument("--stores", type=int, default=32, help="of volumes that are not .bvol")
    parser.add_argument("--in-turn", type=int, nargs="+", default=[1, 8, 32],
                        help="numbers of ranks whose shares are measured one after another")  # fmt: skip
    parser.add_argument("--isovalues", type=int, default=3, help="how many to check by; one more to fit")
    parser.add_argument("--most", type=float, default=2e7, help="triangles of a measured surface")
    parser.add_argument("--repeats", type=int, default=3, help="runs, of which the fastest counts")
    arguments = parser.parse_args()
    folder = os.path.abspath(arguments.output)
    os.makedirs(folder, exist_ok=True)

    volumes = prepare(arguments, folder)
    with open(os.path.join(folder, "scaling_study.md"), "w") as report:
        report.write("Predictions, from costs measured on one machine.\n\n")
        for name, path in volumes.items():
            study(name, path, arguments, folder, report)
    remove_prepared(volumes, folder)


main()
