// SPDX-License-Identifier: BSD-3-Clause
#include "MatchVTK.h"

#include "vtkFloatArray.h"
#include "vtkImageTransform.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkVersionMacros.h"

#include "Surface/Contour/Surface.h"

#include <cmath>

namespace isosurface
{
namespace
{

/// Whether normals are rounded once, when they are transformed to world coordinates.
bool AskVTK()
{
  constexpr int count = 64;
  double spacing[3] = { 0.3, 0.7, 1.1 };
  vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  normals->SetNumberOfTuples(count);
  vtkNew<vtkFloatArray> expected;
  expected->DeepCopy(normals);
  for (int n = 0; n < count; ++n)
  {
    double length = 0;
    for (int axis = 0; axis < 3; ++axis)
    {
      const float component = std::sin(static_cast<float>(1 + 3 * n + axis));
      normals->SetTypedComponent(n, axis, component);
      length += component / spacing[axis] * (component / spacing[axis]);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      const double rounded =
        normals->GetTypedComponent(n, axis) / spacing[axis] / std::sqrt(length);
      expected->SetTypedComponent(n, axis, static_cast<float>(rounded));
    }
  }
  vtkNew<vtkMatrix3x3> identity;
  vtkImageTransform::TransformNormals(identity, spacing, normals);
  for (vtkIdType value = 0; value < normals->GetNumberOfValues(); ++value)
  {
    if (normals->GetValue(value) != expected->GetValue(value))
    {
      return false;
    }
  }
  return true;
}

} // namespace

void MatchVTK(ContourRequest& request)
{
  static const bool once = AskVTK();
  request.NormalsRoundedOnce = once;
  request.WideIndices = VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 4, 0);
  request.NormalsByDirection = VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 2, 0);
}

} // namespace isosurface
