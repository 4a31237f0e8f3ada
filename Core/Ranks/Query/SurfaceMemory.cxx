// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/SurfaceMemory.h"

#include <algorithm>
#include <cstdint>

namespace isosurface
{

double EstimateBytesPerTriangle(const ContourRequest& request)
{
  constexpr double pointsPerTriangle = 0.5;
  const double cell = (3 + 1) * (request.WideIndices ? sizeof(std::int64_t) : sizeof(std::int32_t));
  constexpr double drawn = 3 * sizeof(std::int32_t) + pointsPerTriangle * 6 * sizeof(float);
  // Position, global id, scalar, and the index that joins the pieces.
  double point = 3 * sizeof(float) + sizeof(std::int64_t) + sizeof(float) + sizeof(std::uint32_t);
  constexpr double copies = 2; // the pieces, and what is joined
  if (request.Normals)
  {
    point += copies * 3 * sizeof(float);
  }
  for (const AttributeLayout& layout : request.Attributes)
  {
    point += copies * layout.NumberOfComponents *
      static_cast<double>(GetValueSize(GetInterpolatedType(layout.Type)));
  }
  return cell + drawn + pointsPerTriangle * point;
}

std::size_t FindFittingSurface(const std::vector<double>& bytes, double freeBytes)
{
  if (freeBytes <= 0)
  {
    return 0;
  }
  const auto fits = std::find_if(bytes.begin(), bytes.end() - 1,
    [freeBytes](double needed) { return needed <= UsableMemoryShare * freeBytes; });
  return static_cast<std::size_t>(fits - bytes.begin());
}

} // namespace isosurface
