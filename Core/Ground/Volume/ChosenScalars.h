// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ChosenScalars_h
#define isosurface_ChosenScalars_h

#include "Ground/Base/Status.h"
#include "Ground/Volume/SampleView.h"

#include <string>
#include <vector>

namespace isosurface
{

/// What is contoured of an array's components: one of them, or the magnitude, which is computed.
class ChosenScalars
{
public:
  ChosenScalars() = default;

  /// choice: as FindChosenComponent takes it, and there is one. Cost of a magnitude: 8 bytes a sample, and
  /// a pass over the samples.
  ChosenScalars(const std::vector<SampleView>& components, int choice, int threads);

  int GetComponent() const { return this->Component; }

  /// Of the components that this was made from. The view must not outlive their samples, nor this object.
  SampleView GetView(const std::vector<SampleView>& components) const;

private:
  int Component = 0;
  std::vector<double> Magnitudes; ///< of all samples, x fastest
};

/// There is no such component, nor is it the choice that means the magnitude.
Status MakeComponentError(const std::string& array, int components, int choice);

} // namespace isosurface

#endif
