# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of triangles as NumPy arrays."""

from __future__ import annotations

import builtins
import contextlib
import os
import warnings
from typing import Any, Dict, IO, Iterator, Optional, Tuple, Union

import numpy

from ._arguments import take_path


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

    def _cross(self) -> Iterator[Tuple[numpy.ndarray, numpy.ndarray]]:
        """First corners, seen from the first point that is finite, and normals whose length is twice the area; of some of the
        triangles at a time. Those with a point that is not finite are left out."""
        at_once = 1 << 20
        finite = numpy.isfinite(self.points).all(1)
        for begin in range(0, len(self.triangles), at_once):
            triangles = self.triangles[begin : begin + at_once]
            triangles = triangles[finite[triangles].all(1)]
            corners = self.points[triangles].astype(float) - self.points[finite.argmax()]
            yield corners[:, 0], numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    @property
    def area(self) -> float:
        """Of all triangles, in the square of the unit of `Volume.spacing`."""
        return sum(float(numpy.linalg.norm(cross, axis=1).sum()) for _, cross in self._cross()) / 2

    @property
    def volume(self) -> float:
        """What a closed surface encloses, as its triangles have it: positive where samples are above the
        isovalue inside, or if ``isosurface(..., inside="below")`` has closed it. Without meaning for an open
        surface.

        Raises
        ------
        ValueError
            It has several isovalues; a `part` has one.
        """
        if len(self.isovalues) > 1:
            raise ValueError("volume: the surface has several isovalues; that of part(0) is of the first one")
        return sum(float((first * cross).sum()) for first, cross in self._cross()) / 6

    def save(self, path: Union[str, os.PathLike]) -> None:
        """Writes the triangles as .ply (with normals) or .stl, both binary. A file that is there is replaced when
        the new one is complete. Triangles with a point that is not finite are left out, with a warning. Other
        formats: `to_meshio`, `to_vtk`.
        """
        target = take_path("path", path)
        write = {".ply": self._write_ply, ".stl": self._write_stl}.get(os.path.splitext(target)[1].lower())
        if write is None:
            raise ValueError(f"{target}: a surface is saved as .ply or .stl; to_meshio() and to_vtk() write others")
        triangles = self.triangles
        finite = numpy.isfinite(self.points).all(1)
        if not finite.all():
            triangles = triangles[finite[triangles].all(1)]
            left_out = len(self.triangles) - len(triangles)
            warnings.warn(f"{target}: {left_out} triangles with points that are not finite are left out", stacklevel=2)
        partial = f"{target}.{os.getpid()}.part"
        try:
            with builtins.open(partial, "xb") as file:
                write(file, triangles)
                file.flush()
                os.fsync(file.fileno())
            os.replace(partial, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.remove(partial)
            raise

    def _write_ply(self, file: IO[bytes], triangles: numpy.ndarray) -> None:
        used, corners = numpy.unique(triangles, return_inverse=True)
        columns = {"xyz": self.points[used]}
        if self.normals is not None:
            columns["nx ny nz"] = self.normals[used]
        kinds = {4: "float", 8: "double"}
        header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(used)}"]
        fields = []
        for names, values in columns.items():
            for name in names.split() if " " in names else names:
                header.append(f"property {kinds[values.dtype.itemsize]} {name}")
            fields.append((names, values.dtype.newbyteorder("<"), 3))
        header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
        vertices = numpy.empty(len(used), fields)
        for names, values in columns.items():
            vertices[names] = values
        faces = numpy.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
        faces["count"] = 3
        faces["corners"] = corners.reshape(-1, 3)
        file.write("\n".join(header).encode())
        file.write(vertices.tobytes())
        file.write(faces.tobytes())

    def _write_stl(self, file: IO[bytes], triangles: numpy.ndarray) -> None:
        corners = self.points[triangles].astype("<f4")
        normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = numpy.linalg.norm(normals, axis=1, keepdims=True)
        facets = numpy.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("none", "<u2")])
        facets["normal"] = numpy.divide(normals, lengths, out=numpy.zeros_like(normals), where=lengths > 0)
        facets["corners"] = corners
        file.write(b"scalable_isosurface".ljust(80))
        file.write(len(triangles).to_bytes(4, "little"))
        file.write(facets.tobytes())

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
