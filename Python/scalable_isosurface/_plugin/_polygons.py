# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of the library as vtkPolyData."""

import numpy
from vtkmodules.util.vtkConstants import VTK_ID_TYPE
from vtkmodules.vtkCommonCore import vtkPoints

from .. import _library
from ._arrays import make_cells, to_vtk


def add_box(position, length):
    """x0 x1 y0 y1 z0 z1."""
    return [end for low, size in zip(position, length) for end in (low, low + size)]


def fill_surface(output, owner, normals, scalars):
    """Puts a surface into a vtkPolyData. What `_library.view_cells` gives of it."""
    surface, cells = _library.view_surface(owner, bool(normals)), _library.view_cells(owner)
    points = vtkPoints()
    points.SetData(to_vtk(surface["points"]))
    output.SetPoints(points)
    if len(cells["offsets"]) > 1:
        output.SetPolys(make_cells(cells["offsets"], cells["corners"]))
    data = output.GetPointData()
    for name, values in surface["attributes"].items():
        data.AddArray(to_vtk(values, name))
    if normals:
        data.SetNormals(to_vtk(surface["normals"], "Normals"))
    if scalars:
        isovalues = surface["isovalues"]
        exact = (isovalues.astype(numpy.float32) == isovalues).all()
        of_points = numpy.repeat(isovalues.astype("f4" if exact else "f8"), numpy.diff(surface["point_offsets"]))
        data.SetScalars(to_vtk(of_points, scalars))
    if cells["blocks"]:
        data.AddArray(to_vtk(cells["block_ids"], "BlockIds"))
    # The last array: vtkAdaptiveSubdivisionFilter, which drops it, mixes up those behind it.
    data.SetGlobalIds(to_vtk(cells["global_ids"], "GlobalIds", VTK_ID_TYPE))
    if cells["island_ids"] is not None:
        output.GetCellData().AddArray(to_vtk(cells["island_ids"], "IslandId", VTK_ID_TYPE))
    return cells


def summarise(islands, isovalues):
    """How many islands and triangles are left."""
    return "; ".join(
        (f"{isovalue:g}: " if len(isovalues) > 1 else "")
        + f"{kept:,} of {all_islands:,} islands, {100 * kept_triangles / max(triangles, 1):.1f} % of the triangles"
        for isovalue, (all_islands, kept, triangles, kept_triangles) in zip(isovalues, islands.tolist())
    )
