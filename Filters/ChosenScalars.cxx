// SPDX-License-Identifier: BSD-3-Clause
#include "ChosenScalars.h"

#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/Magnitude.h"

#include <cstddef>
#include <cstdint>

namespace isosurface
{

ChosenScalars::ChosenScalars(const ImageSamples& samples, int component, int threads)
  : Component(component)
{
  if (component != Variable::Magnitude)
  {
    return;
  }
  const VertexBox& all = samples.Components.front().Available;
  const Index3 size = all.GetSize();
  this->Magnitudes.resize(static_cast<std::size_t>(all.GetNumberOfVertices()));
  ParallelFor(static_cast<std::size_t>(size[2]), threads,
    [&](std::size_t slice, int)
    {
      VertexBox box = all;
      box.Low[2] += static_cast<std::int64_t>(slice);
      box.High[2] = box.Low[2] + 1;
      ComputeMagnitudes(samples.Components, box,
        this->Magnitudes.data() + static_cast<std::int64_t>(slice) * size[0] * size[1]);
    });
}

SampleView ChosenScalars::GetView(const ImageSamples& samples) const
{
  if (this->Component != Variable::Magnitude)
  {
    return samples.Components[static_cast<std::size_t>(this->Component)];
  }
  SampleView view =
    MakeMagnitudeView(samples.Components.front().Available, this->Magnitudes.data());
  view.Box = samples.Components.front().Box;
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
