// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMVolumeSliceRepresentationProxy.h"

#include "vtkDataObject.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMTransferFunctionManager.h"

#include <array>
#include <cstring>

vtkStandardNewMacro(vtkSMVolumeSliceRepresentationProxy);

namespace
{

/// Of soft tissue: width 400 around 40.
constexpr double Darkest = -160;
constexpr double Brightest = 240;

void ShowInGrey(vtkSMProxy* map)
{
  const std::array<double, 8> points = { Darkest, 0, 0, 0, Brightest, 1, 1, 1 };
  vtkSMPropertyHelper(map, "RGBPoints")
    .Set(points.data(), static_cast<unsigned int>(points.size()));
  vtkSMPropertyHelper(map, "ColorSpace").Set("RGB");
  vtkSMPropertyHelper(map, "ScalarRangeInitialized").Set(1);
  vtkSMPropertyHelper(map, "AutomaticRescaleRangeMode").Set(vtkSMTransferFunctionManager::NEVER);
  map->UpdateVTKObjects();
}

} // namespace

//------------------------------------------------------------------------------
void vtkSMVolumeSliceRepresentationProxy::ViewUpdated(vtkSMProxy* view)
{
  if (vtkSMPropertyHelper(this, "Visibility").GetAsInt() != 0 &&
    vtkSMPropertyHelper(this, "HounsfieldWindow").GetAsInt() != 0 && this->GetUsingScalarColoring())
  {
    vtkSMPropertyHelper(this, "HounsfieldWindow").Set(0);
    vtkSMProxy* map = vtkSMPropertyHelper(this, "LookupTable").GetAsProxy();
    if (map && this->IsOfCT() &&
      vtkSMPropertyHelper(map, "AutomaticRescaleRangeMode").GetAsInt() !=
        vtkSMTransferFunctionManager::NEVER)
    {
      ShowInGrey(map);
    }
  }
  this->Superclass::ViewUpdated(view);
}

//------------------------------------------------------------------------------
bool vtkSMVolumeSliceRepresentationProxy::IsOfCT()
{
  vtkSMProxy* slice = vtkSMPropertyHelper(this, "Input").GetAsProxy();
  vtkSMProperty* names = slice ? slice->GetProperty("HounsfieldArrays") : nullptr;
  vtkSMPropertyHelper shown(this, "ColorArrayName");
  vtkPVArrayInformation* array = this->GetArrayInformationForColorArray();
  if (!names || !array || shown.GetInputArrayAssociation() != vtkDataObject::POINT ||
    array->GetComponentRange(0)[1] <= Darkest || array->GetComponentRange(0)[0] >= Brightest)
  {
    return false;
  }
  slice->UpdatePropertyInformation(names);
  vtkSMPropertyHelper all(names);
  for (unsigned int number = 0; number < all.GetNumberOfElements(); ++number)
  {
    if (std::strcmp(all.GetAsString(number), shown.GetInputArrayNameToProcess()) == 0)
    {
      return true;
    }
  }
  return false;
}

//------------------------------------------------------------------------------
void vtkSMVolumeSliceRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
