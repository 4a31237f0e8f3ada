// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/BoxSource.h"

#include <cstddef>

namespace isosurface
{

bool BoxSamples::Fits(const std::vector<ValueType>& types, const VertexBox& box) const
{
  bool fits = this->Arrays.size() == types.size();
  for (std::size_t array = 0; fits && array < types.size(); ++array)
  {
    const SampleView& view = this->Arrays[array];
    fits = view.Type == types[array] && view.First && view.Available.Intersect(box) == box;
  }
  return fits;
}

} // namespace isosurface
