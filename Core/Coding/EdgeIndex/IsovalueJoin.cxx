// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/IsovalueJoin.h"

#include "Coding/EdgeIndex/PointAttributes.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/SurfaceMerge.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace isosurface
{
namespace
{

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
  if (sources.empty())
  {
    Surface none;
    none.HasDoublePoints = HasDoublePoints(header.Geometry, request);
    return none;
  }
  std::vector<SurfacePart> parts; ///< of no points
  for (const IsovalueSource& source : sources)
  {
    parts.push_back({ header.Isovalues[source.Isovalue] });
  }
  std::vector<Surface> surfaces;
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
    std::vector<SurfacePart> own = parts;
    own[n] = next->Parts.front();
    next->Parts = std::move(own);
    surfaces.push_back(std::move(*next));
  }
  return JoinSurfaces(std::move(surfaces));
}

} // namespace isosurface
