// SPDX-License-Identifier: BSD-3-Clause
#include "Contour/SurfaceAssembler.h"

#include "Base/ParallelFor.h"
#include "Contour/HugePages.h"
#include "Contour/MarchingCubesCases.h"
#include "Contour/SlabBuilder.h"
#include "Contour/WorldTransform.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace isosurface
{
namespace
{

template <typename T>
Buffer<T> AllocateHuge(std::size_t size)
{
  Buffer<T> buffer(size);
  AdviseHugePages(buffer.GetData(), size * sizeof(T));
  return buffer;
}

IndexArray AllocateIndices(std::size_t size, bool is64Bit)
{
  IndexArray indices;
  indices.Is64Bit = is64Bit;
  if (is64Bit)
  {
    indices.Values64 = AllocateHuge<std::int64_t>(size);
  }
  else
  {
    indices.Values32 = AllocateHuge<std::int32_t>(size);
  }
  return indices;
}

std::size_t CountConnectivity(const Surface& surface, bool polygons)
{
  // A polygon of n corners is n - 2 triangles.
  return polygons ? surface.NumberOfTriangles + 2 * surface.NumberOfCells
                  : 3 * surface.NumberOfTriangles;
}

inline std::int32_t* WriteTriangles(
  const BrickKernels& kernels, const RowSlab& slab, std::int32_t* next, std::int32_t* end)
{
  return kernels.WriteTriangles32(slab, next, end);
}
inline std::int64_t* WriteTriangles(
  const BrickKernels& kernels, const RowSlab& slab, std::int64_t* next, std::int64_t* end)
{
  return kernels.WriteTriangles64(slab, next, end);
}
inline void WritePolygons(const BrickKernels& kernels, const RowSlab& slab, std::int32_t*& next,
  std::int32_t*& offsets, std::int64_t& index)
{
  kernels.WritePolygons32(slab, GetPolygonCases(), next, offsets, index);
}
inline void WritePolygons(const BrickKernels& kernels, const RowSlab& slab, std::int64_t*& next,
  std::int64_t*& offsets, std::int64_t& index)
{
  kernels.WritePolygons64(slab, GetPolygonCases(), next, offsets, index);
}

} // namespace

SurfaceAssembler::SurfaceAssembler(const GridGeometry& geometry, const BrickLattice& lattice,
  BrickScan& scan, const ContourRequest& request)
  : Geometry(geometry)
  , Lattice(lattice)
  , Scan(scan)
  , Request(request)
  , Transform(MakeWorldTransform(geometry))
{
}

bool SurfaceAssembler::Run(int threads, const Progress& progress, Surface& surface)
{
  this->Count(surface);
  this->Allocate(surface);

  std::vector<std::size_t> active;
  const std::vector<BrickPart>& parts = this->Scan.GetParts();
  for (std::size_t part = 0; part < parts.size(); ++part)
  {
    if (parts[part].Inside)
    {
      active.push_back(part);
    }
  }
  const std::size_t bricks = this->Lattice.GetBricks().size();
  return ParallelFor(
    active.size(), threads,
    [&](std::size_t n, int) { this->WriteBrick(active[n] / bricks, active[n] % bricks, surface); },
    progress);
}

void SurfaceAssembler::Count(Surface& surface)
{
  const std::size_t bricks = this->Lattice.GetBricks().size();
  std::int64_t points = 0;
  std::int64_t triangles = 0;
  std::int64_t polygons = 0;
  for (std::size_t isovalue = 0; isovalue < this->Request.Isovalues.size(); ++isovalue)
  {
    SurfacePart whole;
    whole.Isovalue = this->Request.Isovalues[isovalue];
    whole.FirstPoint = static_cast<std::size_t>(points);
    whole.FirstCell = static_cast<std::size_t>(this->Request.Polygons ? polygons : triangles);
    for (std::size_t brick = 0; brick < bricks; ++brick)
    {
      BrickPart& part = this->Scan.GetParts()[isovalue * bricks + brick];
      part.FirstPoint = points;
      part.FirstCell = this->Request.Polygons ? polygons : triangles;
      part.FirstIndex = this->Request.Polygons ? triangles + 2 * polygons : 3 * triangles;
      points += part.Counts.Points;
      triangles += part.Counts.Triangles;
      polygons += part.Counts.Polygons;
    }
    whole.NumberOfPoints = static_cast<std::size_t>(points) - whole.FirstPoint;
    whole.NumberOfCells =
      static_cast<std::size_t>(this->Request.Polygons ? polygons : triangles) - whole.FirstCell;
    surface.Parts.push_back(whole);
  }
  surface.NumberOfPoints = static_cast<std::size_t>(points);
  surface.NumberOfTriangles = static_cast<std::size_t>(triangles);
  surface.NumberOfCells = static_cast<std::size_t>(this->Request.Polygons ? polygons : triangles);
}

void SurfaceAssembler::Allocate(Surface& surface) const
{
  const std::size_t points = surface.NumberOfPoints;
  const std::size_t connectivity = CountConnectivity(surface, this->Request.Polygons);
  constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
  const bool wide = this->Request.WideIndices || points > most || connectivity > most;

  surface.Points = AllocateHuge<float>(3 * points);
  if (this->Request.Normals)
  {
    surface.Normals = AllocateHuge<float>(3 * points);
  }
  if (this->Request.GlobalIds)
  {
    surface.GlobalIds = AllocateHuge<std::int64_t>(points);
  }
  surface.Connectivity = AllocateIndices(connectivity, wide);
  surface.Offsets.Is64Bit = wide;
  if (this->Request.Offsets || this->Request.Polygons)
  {
    surface.Offsets = AllocateIndices(surface.NumberOfCells + 1, wide);
    if (wide)
    {
      surface.Offsets.Values64[surface.NumberOfCells] = static_cast<std::int64_t>(connectivity);
    }
    else
    {
      surface.Offsets.Values32[surface.NumberOfCells] = static_cast<std::int32_t>(connectivity);
    }
  }
  for (const AttributeLayout& layout : this->Request.Attributes)
  {
    SurfaceAttribute attribute;
    attribute.Layout = layout;
    attribute.Bytes = AllocateHuge<std::uint8_t>(
      points * static_cast<std::size_t>(layout.NumberOfComponents) * GetValueSize(layout.Type));
    surface.Attributes.push_back(std::move(attribute));
  }
}

void SurfaceAssembler::WriteBrick(std::size_t isovalue, std::size_t brick, Surface& surface) const
{
  const BrickPart& part =
    this->Scan.GetParts()[isovalue * this->Lattice.GetBricks().size() + brick];
  const BrickSamples position =
    MakeBrickSamples(this->Geometry, this->Lattice.GetBricks()[brick].Vertices);
  PointOutput output{};
  output.Codes = part.Codes;
  output.Coordinates = part.Coordinates;
  output.Normals = part.Normals;
  output.NumberOfPoints = part.Counts.Points;
  output.Points = surface.Points.GetData() + 3 * part.FirstPoint;
  if (this->Request.Normals)
  {
    output.WorldNormals = surface.Normals.GetData() + 3 * part.FirstPoint;
  }
  if (this->Request.GlobalIds)
  {
    output.GlobalIds = surface.GlobalIds.GetData() + part.FirstPoint;
    output.FirstGlobalId =
      static_cast<std::int64_t>(isovalue) * 3 * this->Geometry.GetNumberOfVertices();
  }
  GetBrickKernels().WritePoints(position, this->Transform, output);
  this->WriteAttributes(part, surface);
  if (surface.Connectivity.Is64Bit)
  {
    this->WriteCells(
      isovalue, brick, surface.Connectivity.Values64.GetData(), surface.Offsets.Values64.GetData());
  }
  else
  {
    this->WriteCells(
      isovalue, brick, surface.Connectivity.Values32.GetData(), surface.Offsets.Values32.GetData());
  }
}

void SurfaceAssembler::WriteAttributes(const BrickPart& part, Surface& surface) const
{
  for (std::size_t n = 0; n < surface.Attributes.size(); ++n)
  {
    SurfaceAttribute& attribute = surface.Attributes[n];
    const std::size_t tuple = static_cast<std::size_t>(attribute.Layout.NumberOfComponents) *
      GetValueSize(attribute.Layout.Type);
    if (part.Counts.Points != 0 && tuple != 0)
    {
      std::memcpy(attribute.Bytes.GetData() + static_cast<std::size_t>(part.FirstPoint) * tuple,
        part.Attributes[n], part.Counts.Points * tuple);
    }
  }
}

template <typename Id>
void SurfaceAssembler::WriteCells(
  std::size_t isovalue, std::size_t brick, Id* connectivity, Id* offsets) const
{
  const BrickKernels& kernels = GetBrickKernels();
  const std::size_t firstPart = isovalue * this->Lattice.GetBricks().size();
  const BrickPart& part = this->Scan.GetParts()[firstPart + brick];
  Id* next = connectivity + part.FirstIndex;
  Id* const end = next + 3 * static_cast<std::ptrdiff_t>(part.Counts.Triangles);
  Id* nextOffset = offsets ? offsets + part.FirstCell : nullptr;
  std::int64_t index = part.FirstIndex;
  SlabBuilder builder(this->Lattice, this->Scan, firstPart, brick);
  for (int k = 0; k < builder.GetNumberOfSlabs(); ++k)
  {
    if (!builder.IsActive(k))
    {
      continue;
    }
    const RowSlab& slab = builder.Build(k);
    if (this->Request.Polygons)
    {
      WritePolygons(kernels, slab, next, nextOffset, index);
    }
    else
    {
      next = WriteTriangles(kernels, slab, next, end);
    }
  }
  if (nextOffset && !this->Request.Polygons)
  {
    for (std::uint32_t triangle = 0; triangle < part.Counts.Triangles; ++triangle, index += 3)
    {
      *nextOffset++ = static_cast<Id>(index);
    }
  }
}

} // namespace isosurface
