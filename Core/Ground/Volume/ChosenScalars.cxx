// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/ChosenScalars.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/Magnitude.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

ChosenScalars::ChosenScalars(const std::vector<SampleView>& components, int choice, int threads)
  : Component(*FindChosenComponent(static_cast<int>(components.size()), choice))
{
  if (this->Component != Variable::Magnitude)
  {
    return;
  }
  const VertexBox& all = components.front().Available;
  const Index3 size = all.GetSize();
  this->Magnitudes.resize(static_cast<std::size_t>(all.GetNumberOfVertices()));
  ParallelFor(static_cast<std::size_t>(size[2]), threads,
    [&](std::size_t slice, int)
    {
      VertexBox box = all;
      box.Low[2] += static_cast<std::int64_t>(slice);
      box.High[2] = box.Low[2] + 1;
      ComputeMagnitudes(components, box,
        this->Magnitudes.data() + static_cast<std::int64_t>(slice) * size[0] * size[1]);
    });
}

SampleView ChosenScalars::GetView(const std::vector<SampleView>& components) const
{
  if (this->Component != Variable::Magnitude)
  {
    return components[static_cast<std::size_t>(this->Component)];
  }
  SampleView view = MakeMagnitudeView(components.front().Available, this->Magnitudes.data());
  view.Box = components.front().Box;
  return view;
}

Status MakeComponentError(const std::string& array, int components, int choice)
{
  return Status(StatusCode::InvalidArgument,
    "array \"" + array + "\" has " + std::to_string(components) +
      " components, and after them the magnitude; there is no component " + std::to_string(choice) +
      " to contour");
}

} // namespace isosurface
