# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of triangles as NumPy arrays."""

from __future__ import annotations

from typing import Any, Dict, Optional

import numpy


class Surface:
    """One or more isosurfaces: triangles that share their points.

    The arrays own the memory in which the surface was made; nothing is copied.

    Attributes
    ----------
    points : ndarray of float32 or float64, shape (points, 3)
        x, y, z in the world, as in VTK. float64 where float32 has fewer than 16 places between neighbouring
        samples, as at map coordinates.
    triangles : ndarray of int32 or int64, shape (triangles, 3)
        Numbers of points, counter-clockwise seen from low values, in grids of any direction. int64 if int32
        does not suffice.
    normals : ndarray of float32, shape (points, 3), or None
        Of unit length, from high to low values; (0, 0, 0) where there is no gradient. None if they were not
        asked for.
    isovalues : ndarray of float64
        In the order in which they were asked for.
    point_offsets, triangle_offsets : ndarray of int64, shape (isovalues + 1,)
        Points and triangles of isovalue n are those from offset n to offset n + 1.
    attributes : dict of str to ndarray
        Other arrays, interpolated at the points: float64 of float64, else float32.

    Examples
    --------
    >>> surface = si.open("waves.bvol").isosurface([0.2, 0.5])
    >>> surface.points.shape, surface.triangles.shape
    ((9822, 3), (18296, 3))
    >>> surface.part(1)
    <Surface of 0.5: 8398 triangles, 4510 points>
    """

    __slots__ = (
        "points",
        "triangles",
        "normals",
        "isovalues",
        "point_offsets",
        "triangle_offsets",
        "attributes",
    )

    def __init__(
        self,
        points: numpy.ndarray,
        triangles: numpy.ndarray,
        normals: Optional[numpy.ndarray],
        isovalues: numpy.ndarray,
        point_offsets: numpy.ndarray,
        triangle_offsets: numpy.ndarray,
        attributes: Dict[str, numpy.ndarray],
    ) -> None:
        self.points = points
        self.triangles = triangles
        self.normals = normals
        self.isovalues = isovalues
        self.point_offsets = point_offsets
        self.triangle_offsets = triangle_offsets
        self.attributes = attributes

    def __repr__(self) -> str:
        isovalues = ", ".join(f"{isovalue:.6g}" for isovalue in self.isovalues)
        return f"<Surface of {isovalues}: {len(self.triangles)} triangles, {len(self.points)} points>"

    def part(self, number: int) -> Surface:
        """The surface of one isovalue.

        Its arrays are views of this one's, but for the triangles after the first isovalue, which count
        points from 0 again.
        """
        number = range(len(self.isovalues))[number]
        points = slice(*self.point_offsets[number : number + 2])
        triangles = self.triangles[slice(*self.triangle_offsets[number : number + 2])]
        first = self.triangles.dtype.type(self.point_offsets[number])
        return Surface(
            self.points[points],
            triangles - first if number else triangles,
            None if self.normals is None else self.normals[points],
            self.isovalues[number : number + 1],
            self.point_offsets[number : number + 2] - self.point_offsets[number],
            self.triangle_offsets[number : number + 2] - self.triangle_offsets[number],
            {name: values[points] for name, values in self.attributes.items()},
        )

    def _make_point_data(self, name_of_normals: str) -> Dict[str, numpy.ndarray]:
        """All arrays on the points; the isovalue of each if there are several."""
        data = dict(self.attributes)
        if self.normals is not None:
            data[name_of_normals] = self.normals
        if len(self.isovalues) > 1:
            data["isovalue"] = numpy.repeat(self.isovalues, numpy.diff(self.point_offsets))
        return data

    def to_vtk(self) -> Any:
        """The surface as a vtkPolyData, which shares the memory of the arrays.

        Before VTK 9.4, of which some filters fail on cells with ids of 32 bits, int32 triangles are copied.

        Raises
        ------
        ImportError
            There is no VTK (package ``vtk``; Debian: ``python3-vtk9`` or ``python3-paraview``).
        """
        try:
            from vtkmodules.util.numpy_support import numpy_to_vtk
            from vtkmodules.vtkCommonCore import vtkPoints, vtkVersion
            from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        except ImportError as error:
            raise ImportError(f"Surface.to_vtk() needs the Python modules of VTK: {error}") from error
        points = vtkPoints()
        points.SetData(numpy_to_vtk(self.points))
        cells = vtkCellArray()
        corners = self.triangles.reshape(-1)
        if (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) < (9, 4):
            # Some filters of these versions fail on cells with ids of 32 bits.
            corners = corners.astype(numpy.int64, copy=False)
        cells.SetData(3, numpy_to_vtk(corners))
        # The cells may have another array of this memory (VTK 9.2), which does not keep it alive.
        cells.GetConnectivityArray()._corners = corners
        surface = vtkPolyData()
        surface.SetPoints(points)
        surface.SetPolys(cells)
        for name, values in self._make_point_data("Normals").items():
            array = numpy_to_vtk(values)
            array.SetName(name)
            if values is self.normals:
                surface.GetPointData().SetNormals(array)
            else:
                surface.GetPointData().AddArray(array)
        return surface

    def to_pyvista(self) -> Any:
        """The surface as a pyvista.PolyData, which shares the memory of the arrays.

        Raises
        ------
        ImportError
            There is no PyVista.
        """
        try:
            import pyvista
        except ImportError as error:
            raise ImportError(f"Surface.to_pyvista() needs PyVista: {error}") from error
        return pyvista.wrap(self.to_vtk())

    def to_meshio(self) -> Any:
        """The surface as a meshio.Mesh, which meshio writes in many formats.

        Raises
        ------
        ImportError
            There is no meshio.
        """
        try:
            import meshio
        except ImportError as error:
            raise ImportError(f"Surface.to_meshio() needs meshio: {error}") from error
        data = self._make_point_data("normals")
        return meshio.Mesh(self.points, [("triangle", self.triangles)], point_data=data)
