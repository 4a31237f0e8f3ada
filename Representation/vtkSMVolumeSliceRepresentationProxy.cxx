// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMVolumeSliceRepresentationProxy.h"

#include "ImageSamples.h"
#include "LengthUnitLabels.h"

#include "vtkDataObject.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMTransferFunctionManager.h"
#include "vtkSMTransferFunctionProxy.h"

#include <array>
#include <cstring>

vtkStandardNewMacro(vtkSMVolumeSliceRepresentationProxy);

namespace
{

/// Width 400 around 40.
constexpr double SoftTissue[] = { -160, 240 };

void ShowInGrey(vtkSMProxy* map, const double* window)
{
  const std::array<double, 8> points = { window[0], 0, 0, 0, window[1], 1, 1, 1 };
  vtkSMPropertyHelper(map, "RGBPoints")
    .Set(points.data(), static_cast<unsigned int>(points.size()));
  vtkSMPropertyHelper(map, "ColorSpace").Set("RGB");
  vtkSMPropertyHelper(map, "ScalarRangeInitialized").Set(1);
  vtkSMPropertyHelper(map, "AutomaticRescaleRangeMode").Set(vtkSMTransferFunctionManager::NEVER);
  map->UpdateVTKObjects();
}

} // namespace

bool vtkSMVolumeSliceRepresentationProxy::SetRepresentationType(const char* type)
{
  // As ParaView does for its own types of samples, Slice and Volume.
  if (type && std::strcmp(type, "Three Slices") == 0 && !this->GetUsingScalarColoring())
  {
    this->GetProperty("ColorArrayName")->ResetToDomainDefaults();
    vtkSMPropertyHelper chosen(this, "ColorArrayName");
    const std::string array = chosen.GetInputArrayNameToProcess();
    if (!array.empty() && this->SetScalarColoring(array.c_str(), chosen.GetInputArrayAssociation()))
    {
      this->RescaleTransferFunctionToDataRange(true, false);
    }
  }
  return this->Superclass::SetRepresentationType(type);
}

void vtkSMVolumeSliceRepresentationProxy::ViewUpdated(vtkSMProxy* view)
{
  vtkSMProxy* map = vtkSMPropertyHelper(this, "LookupTable").GetAsProxy();
  if (vtkSMPropertyHelper(this, "Visibility").GetAsInt() != 0 && map &&
    this->GetUsingScalarColoring() &&
    vtkSMPropertyHelper(this, "ColorArrayName").GetInputArrayAssociation() == vtkDataObject::POINT)
  {
    const std::string name =
      vtkSMPropertyHelper(this, "ColorArrayName").GetInputArrayNameToProcess();
    const std::string unit = isosurface::FindFieldText(this, name + isosurface::UnitEnd);
    if (vtkSMPropertyHelper(this, "HounsfieldWindow").GetAsInt() != 0)
    {
      vtkSMPropertyHelper(this, "HounsfieldWindow").Set(0);
      this->ShowWindow(map, name, unit == "HU" || name == "HU");
    }
    vtkSMProxy* legend = vtkSMTransferFunctionProxy::FindScalarBarRepresentation(map, view);
    if (legend && !unit.empty() && vtkSMPropertyHelper(legend, "Title").GetAsString() == name)
    {
      vtkSMPropertyHelper(legend, "Title").Set((name + " (" + unit + ")").c_str());
      legend->UpdateVTKObjects();
    }
  }
  isosurface::TellLengthUnit(view);
  this->Superclass::ViewUpdated(view);
}

void vtkSMVolumeSliceRepresentationProxy::ShowWindow(
  vtkSMProxy* map, const std::string& array, bool isHounsfield)
{
  vtkPVArrayInformation* window = isosurface::FindField(this, array + isosurface::WindowEnd);
  vtkPVArrayInformation* samples = this->GetArrayInformationForColorArray();
  if (!samples || !(window || isHounsfield) ||
    vtkSMPropertyHelper(map, "AutomaticRescaleRangeMode").GetAsInt() ==
      vtkSMTransferFunctionManager::NEVER)
  {
    return;
  }
  const double* shown = window ? window->GetComponentRange(0) : SoftTissue;
  const double* range = samples->GetComponentRange(0);
  if (range[1] > shown[0] && range[0] < shown[1])
  {
    ShowInGrey(map, shown);
  }
}

void vtkSMVolumeSliceRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
