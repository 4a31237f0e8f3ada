// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/IsovalueJoin.h"

#include "Coding/EdgeIndex/PointAttributes.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

template <typename T>
void AppendBuffer(Buffer<T>& to, const Buffer<T>& from)
{
  Buffer<T> joined(to.GetSize() + from.GetSize());
  std::copy(to.begin(), to.end(), joined.begin());
  std::copy(from.begin(), from.end(), joined.begin() + to.GetSize());
  to = std::move(joined);
}

// Blocks share points; if their signs differ at shared vertices, cells may name points that no block
// made.
bool HasAllPoints(const Surface& surface)
{
  const auto areBelow = [points = surface.NumberOfPoints](const auto& values)
  {
    using Id = std::make_unsigned_t<std::decay_t<decltype(values[0])>>;
    const auto last = static_cast<Id>(points - 1);
    Id beyond = 0; // The highest bit: of an id below 0, or of what is left above it.
    for (const auto value : values)
    {
      beyond |= static_cast<Id>(value) | (last - static_cast<Id>(value));
    }
    return beyond >> (8 * sizeof(Id) - 1) == 0;
  };
  return surface.Connectivity.Is64Bit ? areBelow(surface.Connectivity.Values64)
                                      : areBelow(surface.Connectivity.Values32);
}

// Appends the entries of `from`, each plus `raise`, to `to` without its last `drop` entries.
void AppendIndices(
  IndexArray& to, const IndexArray& from, std::int64_t raise, std::size_t drop, bool isWide)
{
  const std::size_t kept = to.GetSize() - std::min(drop, to.GetSize());
  const std::size_t size = kept + from.GetSize();
  IndexArray joined;
  joined.Is64Bit = isWide;
  const auto fill = [&](auto& values)
  {
    using Id = std::decay_t<decltype(values[0])>;
    values = std::decay_t<decltype(values)>(size);
    for (std::size_t n = 0; n < kept; ++n)
    {
      values[n] = static_cast<Id>(to[n]);
    }
    for (std::size_t n = 0; n < from.GetSize(); ++n)
    {
      values[kept + n] = static_cast<Id>(from[n] + raise);
    }
  };
  if (joined.Is64Bit)
  {
    fill(joined.Values64);
  }
  else
  {
    fill(joined.Values32);
  }
  to = std::move(joined);
}

// Moves the normals from the attributes to where a surface has them; drops them if not wanted.
void TakeNormals(const EdgeIndexHeader& header, bool wanted, Surface& surface)
{
  std::vector<SurfaceAttribute> others;
  for (std::size_t n = 0; n < surface.Attributes.size(); ++n)
  {
    if (!header.Attributes[n].IsNormals)
    {
      others.push_back(std::move(surface.Attributes[n]));
    }
    else if (wanted)
    {
      surface.Normals = Buffer<float>(3 * surface.NumberOfPoints);
      if (surface.NumberOfPoints > 0)
      {
        std::memcpy(surface.Normals.GetData(), surface.Attributes[n].Bytes.GetData(),
          3 * sizeof(float) * surface.NumberOfPoints);
        TurnStoredNormals(header.Geometry, surface.Normals);
      }
    }
  }
  surface.Attributes = std::move(others);
}

// Appends the surface of the next isovalue.
void AppendSurface(Surface& surface, Surface&& next)
{
  if (surface.Parts.empty())
  {
    surface = std::move(next);
    return;
  }
  SurfacePart part = next.Parts.front();
  part.FirstPoint = surface.NumberOfPoints;
  part.FirstCell = surface.NumberOfCells;
  surface.Parts.push_back(part);
  AppendBuffer(surface.Points, next.Points);
  AppendBuffer(surface.DoublePoints, next.DoublePoints);
  AppendBuffer(surface.GlobalIds, next.GlobalIds);
  AppendBuffer(surface.Normals, next.Normals);
  for (std::size_t n = 0; n < std::min(surface.Attributes.size(), next.Attributes.size()); ++n)
  {
    AppendBuffer(surface.Attributes[n].Bytes, next.Attributes[n].Bytes);
  }
  const std::size_t corners = surface.Connectivity.GetSize();
  const bool isWide = surface.Connectivity.Is64Bit || next.Connectivity.Is64Bit ||
    NeedsWideIndices(
      surface.NumberOfPoints + next.NumberOfPoints, corners + next.Connectivity.GetSize());
  AppendIndices(surface.Offsets, next.Offsets, static_cast<std::int64_t>(corners), 1, isWide);
  AppendIndices(surface.Connectivity, next.Connectivity,
    static_cast<std::int64_t>(surface.NumberOfPoints), 0, isWide);
  surface.NumberOfPoints += next.NumberOfPoints;
  surface.NumberOfCells += next.NumberOfCells;
  surface.NumberOfTriangles += next.NumberOfTriangles;
  surface.NumberOfBlocks += next.NumberOfBlocks;
  surface.AcquireSeconds += next.AcquireSeconds;
  surface.TotalSeconds += next.TotalSeconds;
}

} // namespace

Result<Surface> JoinIsovalues(const EdgeIndexHeader& header,
  const std::vector<IsovalueSource>& sources, const ContourRequest& request, int threads,
  const Progress& progress)
{
  const bool hasNormals = std::any_of(header.Attributes.begin(), header.Attributes.end(),
    [](const EdgeIndexAttribute& attribute) { return attribute.IsNormals; });
  if (request.Normals && !hasNormals)
  {
    return Status(StatusCode::InvalidArgument,
      "The edge-index stream has no normals; they can be computed from the triangles.");
  }
  if (!header.Attributes.empty() && !request.ClosedSides.IsEmpty())
  {
    return Status(StatusCode::InvalidArgument,
      "The edge-index stream has point arrays, which caps on closed sides of the grid cannot "
      "have.");
  }
  Surface surface;
  surface.HasDoublePoints = HasDoublePoints(header.Geometry, request);
  const auto count = static_cast<double>(sources.size());
  for (std::size_t n = 0; n < sources.size(); ++n)
  {
    const std::size_t isovalue = sources[n].Isovalue;
    ContourRequest one = request;
    one.Isovalues.assign(1, header.Isovalues[isovalue]);
    one.Normals = false;
    one.Attributes = GetAttributeLayouts(header);
    one.GlobalIds = request.GlobalIds || header.LacksIslands;
    if (!header.ClosedSides.IsEmpty())
    {
      one.ClosedSides = header.ClosedSides;
      one.DropDegenerateTriangles = true;
    }
    Progress part;
    if (progress)
    {
      part = [&progress, n, count](double share)
      { return progress((static_cast<double>(n) + share) / count); };
    }
    Result<Surface> next = ExtractSurface(header.Geometry, *sources[n].Blocks, one, threads, part);
    if (!next.IsOk())
    {
      // Blocks at impossible places come from corrupt bytes.
      const Status& status = next.GetStatus();
      return status.GetCode() == StatusCode::InvalidArgument
        ? Status(StatusCode::Corrupt, "The edge-index stream is corrupt: " + status.GetMessage())
        : status;
    }
    if (!HasAllPoints(*next))
    {
      return Status(
        StatusCode::Corrupt, "The edge-index stream is corrupt: its blocks do not fit together.");
    }
    TakeNormals(header, request.Normals, *next);
    ShiftIds(header, isovalue, next->GlobalIds);
    ISOSURFACE_RETURN_IF_ERROR(
      KeepBlockIslands(sources[n].Blocks->GetDecoder().GetIslands(), threads, *next));
    if (!request.GlobalIds)
    {
      next->GlobalIds = {};
    }
    AppendSurface(surface, std::move(*next));
  }
  return surface;
}

} // namespace isosurface
