// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/SurfaceAssembler.h"

#include "Ground/Base/HugePages.h"
#include "Ground/Base/ParallelFor.h"
#include "Surface/Contour/LinePlacement.h"
#include "Surface/Contour/PointRestriction.h"
#include "Surface/Contour/SlabBuilder.h"
#include "Surface/Contour/WorldTransform.h"

#include <algorithm>
#include <cstring>

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

inline void WritePolygons(const BrickKernels& kernels, const RowSlab& slab, std::int32_t*& next,
  std::int32_t*& offsets, std::int64_t& index)
{
  kernels.WritePolygons32(slab, next, offsets, index);
}
inline void WritePolygons(const BrickKernels& kernels, const RowSlab& slab, std::int64_t*& next,
  std::int64_t*& offsets, std::int64_t& index)
{
  kernels.WritePolygons64(slab, next, offsets, index);
}

} // namespace

SurfaceAssembler::SurfaceAssembler(const GridGeometry& geometry, const BrickLattice& lattice,
  BrickScan& scan, const ContourRequest& request)
  : NumberedGrid(GetNumberedGrid(geometry, request))
  , FirstVertex(geometry.Extent[0] - NumberedGrid.Extent[0])
  , Lattice(lattice)
  , Scan(scan)
  , Request(request)
  // On lines, points and normals are those of the world already.
  , Transform(
      MakeWorldTransform(request.Lines ? GridGeometry() : geometry, request.NormalsByDirection))
{
  this->Transform.NormalsRoundedOnce = request.NormalsRoundedOnce;
}

bool SurfaceAssembler::Run(int threads, const Progress& progress, Surface& surface)
{
  this->NumberPoints();
  double done = 0;
  if ((this->Request.DropDegenerateTriangles && !this->Request.Polygons) ||
    this->Scan.HasHiddenCells())
  {
    constexpr double mergeEnd = 0.4; // of the progress, as measured
    this->Merge = std::make_unique<VertexMerge>(this->Lattice, this->Scan);
    if (!this->Merge->Run(threads, MakePartOfProgress(progress, 0.0, mergeEnd)))
    {
      return false;
    }
    done = mergeEnd;
  }
  this->Count(surface);
  this->Allocate(surface);

  std::vector<std::size_t> active;
  std::size_t triangles = 0;
  const std::vector<BrickSurface>& parts = this->Scan.GetSurfaces();
  for (std::size_t part = 0; part < parts.size(); ++part)
  {
    if (parts[part].Inside)
    {
      active.push_back(part);
      triangles += parts[part].Counts.Triangles;
    }
  }
  constexpr std::size_t trianglesOfThread = 8192;
  const int writers = LimitThreads(threads, triangles, trianglesOfThread);
  std::vector<Corners> corners(static_cast<std::size_t>(writers));
  return ParallelFor(
    active.size(), writers,
    [&](std::size_t n, int thread)
    { this->WriteBrick(active[n], surface, corners[static_cast<std::size_t>(thread)]); },
    MakePartOfProgress(progress, done, 1.0));
}

void SurfaceAssembler::NumberPoints()
{
  std::int64_t points = 0;
  for (BrickSurface& part : this->Scan.GetSurfaces())
  {
    part.FirstPoint = points;
    part.Kept = part.Counts;
    points += part.Counts.Points;
  }
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
      BrickSurface& part = this->Scan.GetSurfaces()[isovalue * bricks + brick];
      part.FirstKeptPoint = points;
      part.FirstCell = this->Request.Polygons ? polygons : triangles;
      part.FirstIndex = this->Request.Polygons ? triangles + 2 * polygons : 3 * triangles;
      points += part.Kept.Points;
      triangles += part.Kept.Triangles;
      polygons += part.Kept.Polygons;
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
  const bool wide = this->Request.WideIndices || NeedsWideIndices(points, connectivity);

  surface.HasDoublePoints = this->Scan.HasDoublePoints();
  if (surface.HasDoublePoints)
  {
    surface.DoublePoints = AllocateHuge<double>(3 * points);
  }
  else
  {
    surface.Points = AllocateHuge<float>(3 * points);
  }
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
    attribute.Layout = { GetInterpolatedType(layout.Type), layout.NumberOfComponents };
    attribute.Bytes = AllocateHuge<std::uint8_t>(points * GetTupleSize(layout));
    surface.Attributes.push_back(std::move(attribute));
  }
}

void SurfaceAssembler::WriteBrick(std::size_t number, Surface& surface, Corners& corners) const
{
  if (this->Merge)
  {
    this->DropPoints(this->Scan.GetSurfaces()[number]);
  }
  this->WritePoints(number, surface);
  this->WriteAttributes(this->Scan.GetSurfaces()[number], surface);
  if (surface.Connectivity.Is64Bit)
  {
    this->WriteCells(
      number, surface.Connectivity.Values64.GetData(), surface.Offsets.Values64.GetData(), corners);
  }
  else
  {
    this->WriteCells(
      number, surface.Connectivity.Values32.GetData(), surface.Offsets.Values32.GetData(), corners);
  }
}

// Moves the points of the part that are kept together, in their order.
void SurfaceAssembler::DropPoints(const BrickSurface& part) const
{
  if (part.Kept.Points == part.Counts.Points)
  {
    return;
  }
  std::size_t to = 0;
  for (std::size_t from = 0; from < part.Counts.Points; ++from)
  {
    // A merged point has the number of an earlier point.
    if (this->Merge->GetNumber(part.FirstPoint + static_cast<std::int64_t>(from)) !=
      part.FirstKeptPoint + static_cast<std::int64_t>(to))
    {
      continue;
    }
    MovePoints(part, this->Request.Attributes, from, to++, 1);
  }
}

void SurfaceAssembler::WritePoints(std::size_t number, Surface& surface) const
{
  const BrickSurface& part = this->Scan.GetSurfaces()[number];
  const std::size_t bricks = this->Lattice.GetBricks().size();
  const auto isovalue = static_cast<std::int64_t>(number / bricks);
  const VertexBox vertices = this->Lattice.GetBricks()[number % bricks].Vertices.Translate(
    { this->FirstVertex, this->FirstVertex, this->FirstVertex });
  const BrickSamples position = MakeBrickSamples(this->NumberedGrid, vertices);
  PointOutput output{};
  output.Codes = part.Codes;
  output.Coordinates = part.Coordinates;
  output.Normals = part.Normals;
  output.NumberOfPoints = part.Kept.Points;
  output.Parameters = part.Parameters;
  if (surface.HasDoublePoints)
  {
    output.DoublePoints = surface.DoublePoints.GetData() + 3 * part.FirstKeptPoint;
  }
  else
  {
    output.Points = surface.Points.GetData() + 3 * part.FirstKeptPoint;
  }
  if (this->Request.Normals)
  {
    output.WorldNormals = surface.Normals.GetData() + 3 * part.FirstKeptPoint;
  }
  const std::int64_t idsPerIsovalue = 3 * this->NumberedGrid.GetNumberOfVertices();
  if (this->Request.GlobalIds)
  {
    output.GlobalIds = surface.GlobalIds.GetData() + part.FirstKeptPoint;
    output.FirstGlobalId = isovalue * idsPerIsovalue;
  }
  GetBrickKernels().WritePoints(position, this->Transform, output);
  if (this->Request.Lines)
  {
    const Index3& low = this->Lattice.GetBricks()[number % bricks].Vertices.Low;
    const LinedBrick lined{ *this->Request.Lines, low, part.Codes, part.Kept.Points };
    if (surface.HasDoublePoints)
    {
      WriteDoublePointsOnLines(lined, part.Parameters, output.DoublePoints);
    }
    else
    {
      WritePointsOnLines(lined, part.Coordinates, output.Points);
    }
  }
  if (!this->Merge || !this->Request.GlobalIds)
  {
    return;
  }
  // The ids of vertices follow those of all edges. The kernel has treated a vertex as an edge along
  // axis VertexAxis.
  const auto isovalues = static_cast<std::int64_t>(this->Request.Isovalues.size());
  const std::int64_t firstId =
    isovalues * idsPerIsovalue + isovalue * this->NumberedGrid.GetNumberOfVertices();
  for (std::uint32_t n = 0; n < part.Kept.Points; ++n)
  {
    if (part.Codes[n] >> 18 == VertexAxis)
    {
      std::int64_t& id = output.GlobalIds[n];
      id = firstId + (id - output.FirstGlobalId - static_cast<std::int64_t>(VertexAxis)) / 3;
    }
  }
}

void SurfaceAssembler::WriteAttributes(const BrickSurface& part, Surface& surface) const
{
  for (std::size_t n = 0; n < surface.Attributes.size(); ++n)
  {
    SurfaceAttribute& attribute = surface.Attributes[n];
    const std::size_t tuple = GetTupleSize(attribute.Layout);
    if (part.Kept.Points != 0)
    {
      std::memcpy(attribute.Bytes.GetData() + static_cast<std::size_t>(part.FirstKeptPoint) * tuple,
        part.Attributes[n], part.Kept.Points * tuple);
    }
  }
}

template <typename Id>
void SurfaceAssembler::WriteCells(
  std::size_t number, Id* connectivity, Id* offsets, Corners& corners) const
{
  const std::size_t bricks = this->Lattice.GetBricks().size();
  const BrickSurface& part = this->Scan.GetSurfaces()[number];
  Id* next = connectivity + part.FirstIndex;
  Id* nextOffset = offsets ? offsets + part.FirstCell : nullptr;
  std::int64_t index = part.FirstIndex;
  if (this->Merge && !this->Request.Polygons)
  {
    this->WriteKeptTriangles(number, next, corners);
  }
  else
  {
    SlabBuilder builder(this->Lattice, this->Scan, number / bricks * bricks, number % bricks);
    if (!this->Request.Polygons)
    {
      builder.WriteTriangles(next, next + 3 * static_cast<std::ptrdiff_t>(part.Kept.Triangles));
    }
    for (int k = 0; this->Request.Polygons && k < builder.GetNumberOfSlabs(); ++k)
    {
      if (builder.IsActive(k))
      {
        WritePolygons(GetBrickKernels(), builder.Build(k), next, nextOffset, index);
      }
    }
    for (Id* corner = connectivity + part.FirstIndex; this->Merge && corner != next; ++corner)
    {
      *corner = static_cast<Id>(this->Merge->GetNumber(*corner));
    }
  }
  if (nextOffset && !this->Request.Polygons)
  {
    for (std::uint32_t triangle = 0; triangle < part.Kept.Triangles; ++triangle, index += 3)
    {
      *nextOffset++ = static_cast<Id>(index);
    }
  }
}

template <typename Id>
void SurfaceAssembler::WriteKeptTriangles(
  std::size_t number, Id* connectivity, Corners& corners) const
{
  const std::int64_t* corner = this->Merge->MakeTriangles(number, corners);
  const std::int64_t* const end =
    corner + 3 * static_cast<std::ptrdiff_t>(this->Scan.GetSurfaces()[number].Counts.Triangles);
  for (; corner != end; corner += 3)
  {
    const std::int64_t a = this->Merge->GetNumber(corner[0]);
    const std::int64_t b = this->Merge->GetNumber(corner[1]);
    const std::int64_t c = this->Merge->GetNumber(corner[2]);
    if (a != b && b != c && c != a)
    {
      *connectivity++ = static_cast<Id>(a);
      *connectivity++ = static_cast<Id>(b);
      *connectivity++ = static_cast<Id>(c);
    }
  }
}

} // namespace isosurface
