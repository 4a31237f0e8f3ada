// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LengthUnitLabels_h
#define isosurface_LengthUnitLabels_h

#include <string>

class vtkPVArrayInformation;
class vtkSMProxy;

namespace isosurface
{

/// What is known of a field of the data that a representation shows; null if there is none.
vtkPVArrayInformation* FindField(vtkSMProxy* representation, const std::string& name);

/// The text in such a field; empty if there is none.
std::string FindFieldText(vtkSMProxy* representation, const std::string& name);

/// Has the labels of a view's rulers, and the titles of its axes grid, end with the unit of length of what
/// it shows, unless the user has changed them. What has several units has none.
void TellLengthUnit(vtkSMProxy* view);

} // namespace isosurface

#endif
