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

PointPlan PlanPoints(const std::vector<Surface>& surfaces, std::vector<SurfacePart>& parts)
{
  PointPlan plan;
  std::size_t total = 0;
  for (const Surface& surface : surfaces)
  {
    plan.NewNumbers.emplace_back(surface.NumberOfPoints);
    total += surface.NumberOfPoints;
  }
  std::unordered_map<std::int64_t, std::int64_t> numbers;
  numbers.reserve(total);
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
          numbers.emplace(surfaces[piece].GlobalIds[point], next).first->second;
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

/// Where the corners of a cell begin, or those of the last one end.
std::size_t GetCorner(const Surface& surface, std::size_t cell)
{
  return surface.Offsets.GetSize() == 0 ? 3 * cell
                                        : static_cast<std::size_t>(surface.Offsets[cell]);
}

/// `renumber(surface, part, point)`: the new number of a point.
template <typename T, typename Renumber>
void CopyCells(const std::vector<Surface>& surfaces, const Renumber& renumber, Surface& merged,
  Buffer<T>& connectivity, Buffer<T>& offsets)
{
  std::size_t cell = 0;
  std::size_t entry = 0;
  for (std::size_t number = 0; number < merged.Parts.size(); ++number)
  {
    SurfacePart& part = merged.Parts[number];
    part.FirstCell = cell;
    for (std::size_t piece = 0; piece < surfaces.size(); ++piece)
    {
      const Surface& from = surfaces[piece];
      const SurfacePart& old = from.Parts[number];
      std::size_t at = GetCorner(from, old.FirstCell);
      for (std::size_t index = old.FirstCell; index < old.FirstCell + old.NumberOfCells; ++index)
      {
        if (!offsets.IsEmpty())
        {
          offsets[cell] = static_cast<T>(entry);
        }
        for (const std::size_t end = GetCorner(from, index + 1); at < end; ++at)
        {
          connectivity[entry++] = static_cast<T>(renumber(piece, number, from.Connectivity[at]));
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

/// Adds the cells of all surfaces to one that has their points already.
template <typename Renumber>
void AddCells(const std::vector<Surface>& surfaces, const Renumber& renumber, Surface& merged)
{
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
    CopyCells(surfaces, renumber, merged, merged.Connectivity.Values64, merged.Offsets.Values64);
  }
  else
  {
    merged.Connectivity.Values32 = Buffer<std::int32_t>(entries);
    merged.Offsets.Values32 = Buffer<std::int32_t>(offsetCount);
    CopyCells(surfaces, renumber, merged, merged.Connectivity.Values32, merged.Offsets.Values32);
  }
}

/// Joins an array of the points, which `get` finds in a surface, with `width` values for each.
template <typename Get>
void JoinArrays(
  const std::vector<Surface>& surfaces, std::size_t width, const Get& get, Surface& joined)
{
  std::size_t size = 0;
  for (const Surface& surface : surfaces)
  {
    size += get(surface).GetSize();
  }
  std::decay_t<decltype(get(joined))> array(size);
  auto* to = array.GetData();
  for (std::size_t number = 0; number < joined.Parts.size(); ++number)
  {
    for (const Surface& surface : surfaces)
    {
      const SurfacePart& part = surface.Parts[number];
      if (!get(surface).IsEmpty())
      {
        to = std::copy_n(
          get(surface).GetData() + width * part.FirstPoint, width * part.NumberOfPoints, to);
      }
    }
  }
  get(joined) = std::move(array);
}

} // namespace

Surface MergeSurfaces(const std::vector<Surface>& surfaces)
{
  Surface merged;
  if (surfaces.empty())
  {
    return merged;
  }
  merged.Parts = surfaces.front().Parts;
  const PointPlan plan = PlanPoints(surfaces, merged.Parts);
  CopyPoints(surfaces, plan, merged);
  AddCells(
    surfaces,
    [&plan](std::size_t piece, std::size_t, std::int64_t point)
    { return plan.NewNumbers[piece][static_cast<std::size_t>(point)]; },
    merged);
  return merged;
}

Surface JoinSurfaces(std::vector<Surface> surfaces)
{
  if (surfaces.size() == 1)
  {
    return std::move(surfaces.front());
  }
  Surface joined;
  joined.Parts = surfaces.front().Parts;
  joined.HasDoublePoints = surfaces.front().HasDoublePoints;
  const std::size_t parts = joined.Parts.size();
  std::vector<std::int64_t> raises; ///< of the numbers of points, by part and surface
  for (std::size_t number = 0; number < parts; ++number)
  {
    joined.Parts[number].FirstPoint = joined.NumberOfPoints;
    for (const Surface& surface : surfaces)
    {
      const SurfacePart& part = surface.Parts[number];
      raises.push_back(static_cast<std::int64_t>(joined.NumberOfPoints) -
        static_cast<std::int64_t>(part.FirstPoint));
      joined.NumberOfPoints += part.NumberOfPoints;
    }
    joined.Parts[number].NumberOfPoints = joined.NumberOfPoints - joined.Parts[number].FirstPoint;
  }
  const auto join = [&](std::size_t width, const auto& get)
  { JoinArrays(surfaces, width, get, joined); };
  join(
    3, [](auto& surface) -> auto& { return surface.Points; });
  join(
    3, [](auto& surface) -> auto& { return surface.DoublePoints; });
  join(
    3, [](auto& surface) -> auto& { return surface.Normals; });
  join(
    1, [](auto& surface) -> auto& { return surface.GlobalIds; });
  for (const SurfaceAttribute& attribute : surfaces.front().Attributes)
  {
    const std::size_t index = joined.Attributes.size();
    joined.Attributes.push_back({ attribute.Layout, {} });
    join(
      GetValueSize(attribute.Layout.Type) *
        static_cast<std::size_t>(attribute.Layout.NumberOfComponents),
      [index](auto& surface) -> auto& { return surface.Attributes[index].Bytes; });
  }
  AddCells(
    surfaces,
    [&raises, pieces = surfaces.size()](std::size_t piece, std::size_t part, std::int64_t point)
    { return point + raises[part * pieces + piece]; },
    joined);
  return joined;
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
