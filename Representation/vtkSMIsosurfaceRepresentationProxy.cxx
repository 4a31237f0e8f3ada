// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMIsosurfaceRepresentationProxy.h"

#include "IsovalueCategories.h"
#include "LengthUnitLabels.h"

#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkObjectFactory.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkPVGeneralSettings.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMTransferFunctionManager.h"
#include "vtkSMTransferFunctionProxy.h"
#include "vtkSMViewProxy.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using isosurface::IsovalueCategory;

vtkStandardNewMacro(vtkSMIsosurfaceRepresentationProxy);

namespace
{

std::vector<IsovalueCategory> ReadCategories(vtkSMProxy* map)
{
  vtkSMPropertyHelper texts(map, "Annotations");
  const std::vector<double> colors = vtkSMPropertyHelper(map, "IndexedColors").GetDoubleArray();
  const std::vector<double> opacities =
    vtkSMPropertyHelper(map, "IndexedOpacities").GetDoubleArray();
  std::vector<IsovalueCategory> categories(texts.GetNumberOfElements() / 2);
  for (std::size_t n = 0; n < categories.size(); ++n)
  {
    const auto index = static_cast<unsigned int>(2 * n);
    categories[n].Isovalue = std::strtod(texts.GetAsString(index), nullptr);
    categories[n].Text = texts.GetAsString(index + 1);
    if (3 * n + 2 < colors.size())
    {
      std::copy_n(&colors[3 * n], 3, categories[n].Color.begin());
    }
    if (n < opacities.size())
    {
      categories[n].Opacity = opacities[n];
    }
  }
  return categories;
}

void WriteCategories(vtkSMProxy* map, const std::vector<IsovalueCategory>& categories)
{
  vtkSMPropertyHelper texts(map, "Annotations");
  vtkSMPropertyHelper colors(map, "IndexedColors");
  vtkSMPropertyHelper opacities(map, "IndexedOpacities");
  const auto count = static_cast<unsigned int>(categories.size());
  texts.SetNumberOfElements(2 * count);
  colors.SetNumberOfElements(3 * count);
  opacities.SetNumberOfElements(count);
  bool isTranslucent = false;
  for (unsigned int n = 0; n < count; ++n)
  {
    const IsovalueCategory& category = categories[n];
    texts.Set(2 * n, isosurface::FormatIsovalue(category.Isovalue).c_str());
    texts.Set(2 * n + 1, category.Text.c_str());
    for (unsigned int channel = 0; channel < 3; ++channel)
    {
      colors.Set(3 * n + channel, category.Color[channel]);
    }
    opacities.Set(n, category.Opacity);
    isTranslucent = isTranslucent || category.Opacity < 1;
  }
  // Nothing shows through a surface that is alone.
  vtkSMPropertyHelper(map, "EnableOpacityMapping").Set(count > 1 && isTranslucent ? 1 : 0);
  // Else the color map's panel looks for values itself as soon as they are categories, and asks the user for
  // them where it finds none, as on ranks without triangles.
  vtkSMPropertyHelper(map, "AnnotationsInitialized").Set(1);
  vtkSMPropertyHelper(map, "IndexedLookup").Set(1);
  vtkSMPropertyHelper(map, "AutomaticRescaleRangeMode").Set(vtkSMTransferFunctionManager::NEVER);
  map->UpdateVTKObjects();
}

bool IsNamed(vtkSMProxy* proxy, const char* name)
{
  return proxy && proxy->GetXMLName() && std::strcmp(proxy->GetXMLName(), name) == 0;
}

bool IsContour(vtkSMProxy* proxy)
{
  return IsNamed(proxy, "Isosurface") || IsNamed(proxy, "StabbingContour");
}

// The isovalues of a filter, or of the file that a reader has open.
std::vector<double> ReadIsovalues(vtkSMProxy* contour)
{
  vtkSMProperty* isovalues = contour->GetProperty("ContourValues");
  if (isovalues->GetInformationOnly())
  {
    isovalues->GetParent()->UpdatePropertyInformation(isovalues);
  }
  return vtkSMPropertyHelper(isovalues).GetDoubleArray();
}

bool LegendsComeByThemselves()
{
  return vtkPVGeneralSettings::GetInstance()->GetScalarBarMode() ==
    vtkPVGeneralSettings::AUTOMATICALLY_SHOW_AND_HIDE_SCALAR_BARS;
}

} // namespace

void vtkSMIsosurfaceRepresentationProxy::ViewUpdated(vtkSMProxy* view)
{
  if (vtkSMPropertyHelper(this, "Visibility").GetAsInt() != 0)
  {
    vtkSMProxy* contour = this->FindColoringContour();
    if (contour)
    {
      this->UpdateColors(view, contour);
    }
    else if (this->HasOwnMap)
    {
      this->ChangeColorMap(view, false);
    }
    this->HasOwnMap = contour != nullptr;
  }
  isosurface::TellLengthUnit(view);
  this->Superclass::ViewUpdated(view);
}

vtkSMProxy* vtkSMIsosurfaceRepresentationProxy::FindColoringContour()
{
  vtkSMProxy* contour = vtkSMPropertyHelper(this, "Input").GetAsProxy();
  if (IsNamed(contour, "DistributeIsosurface"))
  {
    contour = vtkSMPropertyHelper(contour, "Input").GetAsProxy();
  }
  vtkSMPropertyHelper shown(this, "ColorArrayName");
  if (vtkSMPropertyHelper(this, "IsosurfaceColors").GetAsInt() == 0 ||
    !(IsContour(contour) || IsNamed(contour, "EdgeIndexReader")) || !this->GetUsingScalarColoring() || shown.GetInputArrayAssociation() != vtkDataObject::POINT ||
    vtkSMPropertyHelper(contour, "ComputeScalars").GetAsInt() == 0)
  {
    return nullptr;
  }
  return ShowsIsovalues(this, contour) ? contour : nullptr;
}

bool vtkSMIsosurfaceRepresentationProxy::ShowsIsovalues(
  vtkSMProxy* representation, vtkSMProxy* contour)
{
  const char* shown =
    vtkSMPropertyHelper(representation, "ColorArrayName").GetInputArrayNameToProcess();
  const char* contoured = IsContour(contour)
    ? vtkSMPropertyHelper(contour, "SelectInputScalars").GetInputArrayNameToProcess()
    : nullptr;
  vtkSMPropertyHelper input(representation, "Input");
  auto* surface = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy());
  if (surface && (!contoured || *contoured == '\0'))
  {
    const vtkPVArrayInformation* scalars =
      surface->GetDataInformation(input.GetOutputPort())
        ->GetPointDataInformation()
        ->GetAttributeInformation(vtkDataSetAttributes::SCALARS);
    contoured = scalars ? scalars->GetName() : nullptr;
  }
  return shown && contoured && std::strcmp(contoured, shown) == 0;
}

void vtkSMIsosurfaceRepresentationProxy::ChangeColorMap(vtkSMProxy* view, bool separate)
{
  const bool hasLegend = this->IsScalarBarVisible(view);
  vtkSMPropertyHelper(this, "UseSeparateColorMap").Set(separate ? 1 : 0);
  if (this->GetUsingScalarColoring())
  {
    vtkSMPropertyHelper shown(this, "ColorArrayName");
    this->SetScalarColoring(shown.GetInputArrayNameToProcess(), shown.GetInputArrayAssociation());
    vtkNew<vtkSMTransferFunctionManager> maps;
    maps->UpdateScalarBars(view, vtkSMTransferFunctionManager::HIDE_UNUSED_SCALAR_BARS);
    this->SetScalarBarVisibility(view, hasLegend);
  }
}

void vtkSMIsosurfaceRepresentationProxy::NameLegend(vtkSMProxy* view, vtkSMProxy* map)
{
  vtkSMProxy* legend = vtkSMTransferFunctionProxy::FindScalarBarRepresentation(map, view);
  vtkSMPropertyHelper shown(this, "ColorArrayName");
  if (legend &&
    std::strcmp(
      vtkSMPropertyHelper(legend, "Title").GetAsString(), shown.GetInputArrayNameToProcess()) == 0)
  {
    vtkSMPropertyHelper(legend, "Title").Set("Isosurfaces");
    legend->UpdateVTKObjects();
  }
}

void vtkSMIsosurfaceRepresentationProxy::UpdateColors(vtkSMProxy* view, vtkSMProxy* contour)
{
  if (vtkSMPropertyHelper(this, "UseSeparateColorMap").GetAsInt() == 0)
  {
    this->ChangeColorMap(view, true);
  }
  vtkSMProxy* map = vtkSMPropertyHelper(this, "LookupTable").GetAsProxy();
  if (!map)
  {
    return;
  }
  this->NameLegend(view, map);
  std::array<double, 3> plain{};
  vtkSMPropertyHelper(this, "DiffuseColor").Get(plain.data(), 3);
  const std::vector<IsovalueCategory> old = ReadCategories(map);
  const std::vector<double> isovalues = ReadIsovalues(contour);
  // The server is asked for the unit only if something is new.
  if (isosurface::FollowIsovalues(old, isovalues, "", plain) == old)
  {
    return;
  }
  std::string unit; // which an edge-index file does not know
  if (IsContour(contour))
  {
    contour->UpdatePropertyInformation(contour->GetProperty("Unit"));
    unit = vtkSMPropertyHelper(contour, "Unit").GetAsString();
  }
  const std::vector<IsovalueCategory> categories =
    isosurface::FollowIsovalues(old, isovalues, unit, plain);
  const int wasTranslucent = vtkSMPropertyHelper(map, "EnableOpacityMapping").GetAsInt();
  WriteCategories(map, categories);
  if (vtkSMPropertyHelper(map, "EnableOpacityMapping").GetAsInt() != wasTranslucent)
  {
    // Representations tell the view in an update whether they are translucent, which decides how ranks
    // composite. This update is not over yet, and the next one would come after the image.
    vtkSMViewProxy::SafeDownCast(view)->Update();
  }
  // Of one surface there is nothing to tell.
  if (categories.size() == 1)
  {
    this->SetScalarBarVisibility(view, false);
  }
  else if (old.size() == 1 && LegendsComeByThemselves())
  {
    this->SetScalarBarVisibility(view, true);
  }
}

void vtkSMIsosurfaceRepresentationProxy::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
