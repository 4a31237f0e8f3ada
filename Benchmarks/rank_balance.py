#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How evenly ranks share the active blocks of isosurfaces: counted, for 2 to 16 ranks.

usage: rank_balance.py FILE.vti[:CELLS] ...    CELLS a side of a block: 16, or what is given

A model of Core/Ranks/Sharing/BlockDealing and ActiveBlockWork in NumPy, with the constants of these. Counts
the cells that four isosurfaces pass in every block, deals the blocks to ranks, and prints the maximum
over the mean of the ranks' cells, which have about two triangles each, wherever a rank has at least
100 active blocks: by the lattice alone, and with the work evened out. With --fit it also fits the
weights of the prediction anew.
"""
import sys

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

FACES = [[370, 300, 450, 610], [530, 710, 1120, 1120], [1480] + [1580] * 3, [2050] * 4]
EDGE, CORNER, LEAST = 15, -116, 20
STEPS = [-1, 0, 1]


def find_lattice(ranks, radius=3):
    best, found = (0, 0), (1, 1)
    for y in range(1, min(ranks - 1, 24) + 1):
        for z in range(y, min(ranks - 1, 24) + 1):
            squares = [i * i + j * j + k * k for k in range(radius + 1)
                       for j in range(-radius, radius + 1) for i in range(-radius, radius + 1)
                       if (i + y * j + z * k) % ranks == 0 and (i, j, k) != (0, 0, 0)]
            nearest = min(squares)
            if (nearest, -squares.count(nearest)) > best:
                best, found = (nearest, -squares.count(nearest)), (y, z)
    return found


def load(path):
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    samples = vtk_to_numpy(image.GetPointData().GetArray(0))
    samples = samples if samples.ndim == 1 else samples[:, 0]
    return samples.reshape(image.GetDimensions()[::-1]).astype(numpy.float32)


def over_corners(samples, function):
    for axis in range(3):
        below = [slice(None)] * 3
        above = [slice(None)] * 3
        below[axis], above[axis] = slice(None, -1), slice(1, None)
        samples = function(samples[tuple(below)], samples[tuple(above)])
    return samples


def over_blocks(cells, side, empty, function):
    counts = [-(-size // side) for size in cells.shape]
    whole = numpy.full([side * count for count in counts], empty, cells.dtype)
    whole[tuple(slice(size) for size in cells.shape)] = cells
    nx, ny, nz = counts
    return function(whole.reshape(nx, side, ny, side, nz, side), axis=(1, 3, 5))


def list_surfaces(path, side):
    """Of each isosurface the active blocks (z, y, x), their crossed cells, and all of their cells."""
    samples = load(path)
    low, high = over_corners(samples, numpy.minimum), over_corners(samples, numpy.maximum)
    minima = over_blocks(low, side, numpy.inf, numpy.min)
    maxima = over_blocks(high, side, -numpy.inf, numpy.max)
    cells = over_blocks(numpy.ones(low.shape, numpy.int64), side, 0, numpy.sum)
    first, last = numpy.percentile(samples, 2), numpy.percentile(samples, 99.5)
    for part in (0.25, 0.4, 0.55, 0.7):
        isovalue = first + part * (last - first)
        active = (minima < isovalue) & (maxima >= isovalue)
        crossed = ((low < isovalue) & (high >= isovalue)).astype(numpy.int64)
        crossed = over_blocks(crossed, side, 0, numpy.sum)
        yield numpy.argwhere(active), crossed[active], cells[active] / side**3


def count_neighbours(blocks):
    """Axes with active neighbours on both sides, on one side; neighbours across edges, corners."""
    active = numpy.zeros(blocks.max(0) + 3, numpy.int64)
    active[tuple((blocks + 1).T)] = 1

    def at(*step):
        return active[tuple((blocks + 1 + numpy.array(step)).T)]
    sides = [at(*step) + at(*(-n for n in step)) for step in ((0, 0, 1), (0, 1, 0), (1, 0, 0))]
    across = {axes: sum(at(i, j, k) for i in STEPS for j in STEPS for k in STEPS
                        if abs(i) + abs(j) + abs(k) == axes) for axes in (2, 3)}
    return (sum(side == 2 for side in sides), sum(side == 1 for side in sides), across[2],
            across[3])


def predict(blocks, sizes):
    both, one, edges, corners = count_neighbours(blocks)
    work = numpy.array(FACES)[both, one] + EDGE * edges + CORNER * corners
    return numpy.maximum(work, LEAST) * sizes


def even_out(work, owners, ranks):
    owners, loads = owners.copy(), numpy.bincount(owners, work, ranks)
    moves = 0
    while moves < len(work) // 8:
        most, least = loads.argmax(), loads.argmin()
        gap, mine = loads[most] - loads[least], numpy.flatnonzero(owners == most)
        block = mine[numpy.abs(2 * work[mine] - gap).argmin()] if len(mine) else None
        if gap <= loads.mean() / 100 or block is None or work[block] >= gap:
            break
        owners[block] = least
        loads[most] -= work[block]
        loads[least] += work[block]
        moves += 1
    return owners, moves


def fit(surfaces):
    """Least squares, each surface with the same weight."""
    rows, values = [], []
    for blocks, crossed, sizes in surfaces:
        both, one, edges, corners = count_neighbours(blocks)
        kinds = [(both == a) & (one == b) for a in range(4) for b in range(4 - a)]
        features = numpy.array(kinds + [edges, corners]).T * sizes[:, None]
        rows.append(features / len(blocks)**0.5)
        values.append(crossed / crossed.mean() / len(blocks)**0.5)
    found = numpy.linalg.lstsq(numpy.vstack(rows), numpy.concatenate(values), rcond=None)[0]
    names = [f"{a} both, {b} one" for a in range(4) for b in range(4 - a)] + ["edge", "corner"]
    for name, weight in zip(names, found):
        print(f"{name:14s} {1000 * weight:6.0f}")


def main(arguments):
    everything, surfaces = [], []
    for name in (name for name in arguments if name != "--fit"):
        path, _, side = name.partition(":")
        results = []
        for blocks, crossed, sizes in list_surfaces(path, int(side or 16)):
            surfaces.append((blocks, crossed, sizes))
            work = predict(blocks, sizes)
            for ranks in range(2, min(16, len(blocks) // 100) + 1):
                y, z = find_lattice(ranks)
                lattice = (blocks[:, 2] + y * blocks[:, 1] + z * blocks[:, 0]) % ranks
                owners, moves = even_out(work, lattice, ranks)
                results.append([numpy.bincount(of, crossed, ranks).max() * ranks / crossed.sum()
                                for of in (lattice, owners)] + [moves / len(blocks)])
        if results:
            tell(name.rpartition("/")[2], results)
        everything += results
    tell("all", everything)
    if "--fit" in arguments:
        fit(surfaces)


def tell(name, results):
    lattice, evened, moved = numpy.array(results).T
    print(f"{name:36s} {len(results):4d} cases; mean, max, above 1.10: lattice {lattice.mean():.3f} "
          f"{lattice.max():.3f} {(lattice > 1.10).sum():3d}; evened out {evened.mean():.3f} "
          f"{evened.max():.3f} {(evened > 1.10).sum():3d}; moved {100 * moved.mean():.2f} % "
          f"{100 * moved.max():.1f} %")


if __name__ == "__main__":
    main(sys.argv[1:])
