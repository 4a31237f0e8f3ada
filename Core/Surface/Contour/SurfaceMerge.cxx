// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/SurfaceMerge.h"

#include "Ground/Volume/ValueType.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace isosurface
{
namespace
{

// The new numbers of the surfaces' points, and the origin of the merged ones.
struct PointPlan
{
  std::vector<std::vector<std::int64_t>> NewNumbers;           ///< by surface and old number
  std::vector<std::pair<std::size_t, std::size_t>> OldNumbers; ///< (surface, point) by new number
};

/// `areApart`: whether all points stay.
PointPlan PlanPoints(
  const std::vector<Surface>& surfaces, std::vector<SurfacePart>& parts, bool areApart)
{
  PointPlan plan;
  std::size_t total = 0;
  for (const Surface& surface : surfaces)
  {
    plan.NewNumbers.emplace_back(surface.NumberOfPoints);
    total += surface.NumberOfPoints;
  }
  std::unordered_map<std::int64_t, std::int64_t> numbers;
  numbers.reserve(areApart ? 0 : total);
  plan.OldNumbers.reserve(total);
  for (std::size_t part = 0; part < parts.size(); ++part)
  {
    parts[part].FirstPoint = plan.OldNumbers.size();
    for (std::size_t piece = 0; piece < surfaces.size(); ++piece)
    {
      const SurfacePart& old = surfaces[piece].Parts[part];
      for (std::size_t point = old.FirstPoint; point < old.FirstPoint + old.NumberOfPoints; ++point)
      {
        const auto next = static_cast<std::int64_t>(plan.OldNumbers.size());
        const std::int64_t number =
          areApart ? next : numbers.emplace(surfaces[piece].GlobalIds[point], next).first->second;
        if (number == next)
        {
          plan.OldNumbers.emplace_back(piece, point);
        }
        plan.NewNumbers[piece][point] = number;
      }
    }
    parts[part].NumberOfPoints = plan.OldNumbers.size() - parts[part].FirstPoint;
  }
  return plan;
}

void CopyPoints(const std::vector<Surface>& surfaces, const PointPlan& plan, Surface& merged)
{
  const std::size_t count = plan.OldNumbers.size();
  const Surface& model = surfaces.front();
  const bool normals = !model.Normals.IsEmpty() || model.NumberOfPoints == 0;
  bool anyNormals = false;
  for (const Surface& surface : surfaces)
  {
    anyNormals = anyNormals || !surface.Normals.IsEmpty();
  }
  merged.NumberOfPoints = count;
  merged.HasDoublePoints = std::any_of(surfaces.begin(), surfaces.end(),
    [](const Surface& surface) { return surface.HasDoublePoints; });
  merged.Points = Buffer<float>(merged.HasDoublePoints ? 0 : 3 * count);
  merged.DoublePoints = Buffer<double>(merged.HasDoublePoints ? 3 * count : 0);
  merged.Normals = Buffer<float>(normals && anyNormals ? 3 * count : 0);
  merged.GlobalIds = Buffer<std::int64_t>(count);
  for (const SurfaceAttribute& attribute : model.Attributes)
  {
    const std::size_t tuple = GetValueSize(attribute.Layout.Type) *
      static_cast<std::size_t>(attribute.Layout.NumberOfComponents);
    merged.Attributes.push_back({ attribute.Layout, Buffer<std::uint8_t>(tuple * count) });
  }
  for (std::size_t point = 0; point < count; ++point)
  {
    const auto [piece, old] = plan.OldNumbers[point];
    const Surface& from = surfaces[piece];
    if (merged.HasDoublePoints)
    {
      const Vector3 place = from.GetPoint(old);
      std::copy(place.begin(), place.end(), &merged.DoublePoints[3 * point]);
    }
    else
    {
      std::memcpy(&merged.Points[3 * point], &from.Points[3 * old], 3 * sizeof(float));
    }
    merged.GlobalIds[point] = from.GlobalIds[old];
    if (!merged.Normals.IsEmpty())
    {
      std::memcpy(&merged.Normals[3 * point], &from.Normals[3 * old], 3 * sizeof(float));
    }
    for (std::size_t index = 0; index < merged.Attributes.size(); ++index)
    {
      const AttributeLayout& layout = merged.Attributes[index].Layout;
      const std::size_t tuple =
        GetValueSize(layout.Type) * static_cast<std::size_t>(layout.NumberOfComponents);
      std::memcpy(&merged.Attributes[index].Bytes[tuple * point],
        &from.Attributes[index].Bytes[tuple * old], tuple);
    }
  }
}

std::size_t GetCellEnd(const Surface& surface, std::size_t cell)
{
  return surface.Offsets.GetSize() == 0 ? 3 * (cell + 1)
                                        : static_cast<std::size_t>(surface.Offsets[cell + 1]);
}

template <typename T>
void CopyCells(const std::vector<Surface>& surfaces, const PointPlan& plan, Surface& merged,
  Buffer<T>& connectivity, Buffer<T>& offsets)
{
  std::size_t cell = 0;
  std::size_t entry = 0;
  for (SurfacePart& part : merged.Parts)
  {
    part.FirstCell = cell;
    const auto number = static_cast<std::size_t>(&part - merged.Parts.data());
    for (std::size_t piece = 0; piece < surfaces.size(); ++piece)
    {
      const Surface& from = surfaces[piece];
      const SurfacePart& old = from.Parts[number];
      std::size_t at = old.FirstCell == 0 ? 0 : GetCellEnd(from, old.FirstCell - 1);
      for (std::size_t index = old.FirstCell; index < old.FirstCell + old.NumberOfCells; ++index)
      {
        if (!offsets.IsEmpty())
        {
          offsets[cell] = static_cast<T>(entry);
        }
        for (const std::size_t end = GetCellEnd(from, index); at < end; ++at)
        {
          connectivity[entry++] =
            static_cast<T>(plan.NewNumbers[piece][static_cast<std::size_t>(from.Connectivity[at])]);
        }
        ++cell;
      }
    }
    part.NumberOfCells = cell - part.FirstCell;
  }
  if (!offsets.IsEmpty())
  {
    offsets[cell] = static_cast<T>(entry);
  }
}

Surface Merge(const std::vector<Surface>& surfaces, bool areApart)
{
  Surface merged;
  if (surfaces.empty())
  {
    return merged;
  }
  merged.Parts = surfaces.front().Parts;
  const PointPlan plan = PlanPoints(surfaces, merged.Parts, areApart);
  CopyPoints(surfaces, plan, merged);

  std::size_t entries = 0;
  bool offsets = true;
  bool wide = false;
  for (const Surface& surface : surfaces)
  {
    wide = wide || surface.Connectivity.Is64Bit;
    entries += surface.Connectivity.GetSize();
    offsets = offsets && surface.Offsets.GetSize() > 0;
    merged.NumberOfCells += surface.NumberOfCells;
    merged.NumberOfTriangles += surface.NumberOfTriangles;
    merged.NumberOfBlocks += surface.NumberOfBlocks;
    merged.AcquireSeconds += surface.AcquireSeconds;
    merged.TotalSeconds += surface.TotalSeconds;
  }
  wide = wide || NeedsWideIndices(merged.NumberOfPoints, entries);
  const std::size_t offsetCount = offsets ? merged.NumberOfCells + 1 : 0;
  merged.Connectivity.Is64Bit = merged.Offsets.Is64Bit = wide;
  if (wide)
  {
    merged.Connectivity.Values64 = Buffer<std::int64_t>(entries);
    merged.Offsets.Values64 = Buffer<std::int64_t>(offsetCount);
    CopyCells(surfaces, plan, merged, merged.Connectivity.Values64, merged.Offsets.Values64);
  }
  else
  {
    merged.Connectivity.Values32 = Buffer<std::int32_t>(entries);
    merged.Offsets.Values32 = Buffer<std::int32_t>(offsetCount);
    CopyCells(surfaces, plan, merged, merged.Connectivity.Values32, merged.Offsets.Values32);
  }
  return merged;
}

} // namespace

Surface MergeSurfaces(const std::vector<Surface>& surfaces)
{
  return Merge(surfaces, false);
}

Surface JoinSurfaces(const std::vector<Surface>& surfaces)
{
  return Merge(surfaces, true);
}

void ShiftGlobalIds(std::int64_t shift, Surface& surface)
{
  if (shift != 0)
  {
    for (std::int64_t& id : surface.GlobalIds)
    {
      id += shift;
    }
  }
}

} // namespace isosurface
