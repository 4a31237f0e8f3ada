// SPDX-License-Identifier: BSD-3-Clause
#include "LengthUnitLabels.h"

#include "vtkDataObject.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMStringVectorProperty.h"

#include "Ground/Volume/LengthUnit.h"
#include "ImageSamples.h"

#include <cstring>
#include <set>

namespace isosurface
{
namespace
{

std::string MakeLabel(const std::string& standard, const std::string& unit, bool isTitle)
{
  return unit.empty() ? standard : standard + (isTitle ? " (" + unit + ")" : " " + unit);
}

void SetUnit(vtkSMProxy* proxy, const char* name, const std::string& unit, bool isTitle)
{
  auto* property =
    proxy ? vtkSMStringVectorProperty::SafeDownCast(proxy->GetProperty(name)) : nullptr;
  if (!property)
  {
    return;
  }
  const std::string standard = property->GetDefaultValue(0);
  const std::string text = property->GetElement(0);
  const std::string wanted = MakeLabel(standard, unit, isTitle);
  for (int number = 0; const char* other = GetLengthUnitName(static_cast<LengthUnit>(number));
       ++number)
  {
    if (text != wanted && text == MakeLabel(standard, other, isTitle))
    {
      property->SetElement(0, wanted.c_str());
      proxy->UpdateVTKObjects();
      return;
    }
  }
}

} // namespace

vtkPVArrayInformation* FindField(vtkSMProxy* representation, const std::string& name)
{
  if (!representation->GetProperty("Input"))
  {
    return nullptr;
  }
  vtkSMPropertyHelper input(representation, "Input");
  auto* source = vtkSMSourceProxy::SafeDownCast(input.GetAsProxy());
  return source ? source->GetDataInformation(input.GetOutputPort())
                    ->GetAttributeInformation(vtkDataObject::FIELD)
                    ->GetArrayInformation(name.c_str())
                : nullptr;
}

std::string FindFieldText(vtkSMProxy* representation, const std::string& name)
{
  vtkPVArrayInformation* field = FindField(representation, name);
  return field && field->GetNumberOfStringValues() > 0 ? field->GetStringValue(0) : "";
}

void TellLengthUnit(vtkSMProxy* view)
{
  vtkSMPropertyHelper all(view, "Representations");
  std::set<std::string> units;
  for (unsigned int number = 0; number < all.GetNumberOfElements(); ++number)
  {
    vtkSMProxy* shown = all.GetAsProxy(number);
    if (vtkSMPropertyHelper(shown, "Visibility", true).GetAsInt() != 0)
    {
      units.insert(GetLengthUnitName(FindLengthUnit(FindFieldText(shown, LengthUnitName))));
    }
  }
  units.erase("");
  const std::string unit = units.size() == 1 ? *units.begin() : "";
  vtkSMProxy* axes = vtkSMPropertyHelper(view, "AxesGrid", true).GetAsProxy();
  for (const char* title : { "XTitle", "YTitle", "ZTitle" })
  {
    SetUnit(axes, title, unit, true);
  }
  for (unsigned int number = 0; number < all.GetNumberOfElements(); ++number)
  {
    vtkSMProxy* shown = all.GetAsProxy(number);
    if (std::strcmp(shown->GetXMLName(), "RulerSourceRepresentation") == 0)
    {
      SetUnit(shown, "LabelFormat", unit, false);
    }
  }
}

} // namespace isosurface
