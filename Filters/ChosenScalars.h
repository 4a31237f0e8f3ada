// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChosenScalars_h
#define isosurface_ChosenScalars_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/SampleView.h"
#include "ImageSamples.h"

#include <string>
#include <vector>

namespace isosurface
{

/// What is contoured of an image's array: a component, or the magnitude, which is computed.
class ChosenScalars
{
public:
  ChosenScalars() = default;

  /// component: one of the array's, or Variable::Magnitude. Cost of a magnitude: 8 bytes a sample,
  /// and a pass over the samples.
  ChosenScalars(const ImageSamples& samples, int component, int threads);

  int GetComponent() const { return this->Component; }

  /// Of the samples that this was made from. The view must not outlive them, nor this object.
  SampleView GetView(const ImageSamples& samples) const;

private:
  int Component = 0;
  std::vector<double> Magnitudes; ///< of all samples, x fastest
};

/// There is no such component, nor is it the choice that means the magnitude.
Status MakeComponentError(const std::string& array, int components, int choice);

} // namespace isosurface

#endif
