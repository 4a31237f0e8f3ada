// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMIsovalueDomain.h"

#include "Tissues.h"

#include "vtkClientServerStream.h"
#include "vtkObjectFactory.h"
#include "vtkPVDataInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"
#include "vtkSmartPointer.h"

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <vector>

vtkStandardNewMacro(vtkSMIsovalueDomain);

namespace
{

constexpr double None = std::numeric_limits<double>::quiet_NaN();
constexpr unsigned int NameElement = 4; ///< of SelectInputScalars: the array's name
constexpr std::size_t RowLength =
  7; ///< of the property Spectrum, whose rows begin with the isovalue

/// Those tell the spectrum without samples, so that scripts may ask them before they have executed.
bool IsReaderOfBlocks(vtkSMProxy* input)
{
  const char* name = input->GetXMLName();
  return name &&
    (std::strcmp(name, "BlockedVolumeReader") == 0 ||
      std::strcmp(name, "AnySizeVolumeReader") == 0 ||
      std::strcmp(name, "InPlaceVolumeReader") == 0);
}

void CallOnServer(vtkSMProxy* proxy, const char* method, int argument)
{
  vtkClientServerStream stream;
  stream << vtkClientServerStream::Invoke << VTKOBJECT(proxy) << method << argument
         << vtkClientServerStream::End;
  proxy->GetSession()->ExecuteStream(proxy->GetLocation(), stream);
}

} // namespace

int vtkSMIsovalueDomain::SetDefaultValues(vtkSMProperty* property, bool useUnchecked)
{
  const double isovalue = this->Propose();
  if (std::isnan(isovalue))
  {
    return this->Superclass::SetDefaultValues(property, useUnchecked);
  }
  vtkSMPropertyHelper helper(property);
  helper.SetUseUnchecked(useUnchecked);
  helper.Set(&isovalue, 1);
  return 1;
}

double vtkSMIsovalueDomain::Propose()
{
  vtkSMUncheckedPropertyHelper chosen(this->GetRequiredProperty("Input"));
  auto* input = chosen.GetNumberOfElements() > 0
    ? vtkSMSourceProxy::SafeDownCast(chosen.GetAsProxy())
    : nullptr;
  if (!input || !(this->GetMinimumExists(0) || IsReaderOfBlocks(input)))
  {
    return None;
  }
  const auto port = chosen.GetOutputPort();
  vtkSMSessionProxyManager* manager = input->GetSessionProxyManager();
  const auto spectrum = vtkSmartPointer<vtkSMSourceProxy>::Take(
    vtkSMSourceProxy::SafeDownCast(manager->NewProxy("filters", "ContourSpectrum")));
  if (!spectrum)
  {
    return None;
  }
  spectrum->PrototypeOn(); // not for undo and redo
  vtkSMPropertyHelper(spectrum, "Input").Set(input, port);
  vtkSMUncheckedPropertyHelper array(this->GetRequiredProperty("ArraySelection"));
  const bool isChosen = array.GetNumberOfElements() > NameElement &&
    array.GetAsString(NameElement) && *array.GetAsString(NameElement) != '\0';
  vtkSMPropertyHelper measured(spectrum, "SelectInputScalars");
  for (unsigned int element = 0; isChosen && element < array.GetNumberOfElements(); ++element)
  {
    measured.Set(element, array.GetAsString(element));
  }
  vtkSMPropertyHelper(spectrum, "Component")
    .Set(vtkSMUncheckedPropertyHelper(this->GetRequiredProperty("ComponentSelection")).GetAsInt());
  spectrum->UpdateVTKObjects();
  CallOnServer(spectrum, "ProposeAlone", 1);
  // The time that the input has, so that it is not executed anew.
  vtkPVDataInformation* shown = input->GetDataInformation(port);
  if (shown->GetHasTime())
  {
    spectrum->UpdatePipeline(shown->GetTime());
  }
  else
  {
    spectrum->UpdatePipeline();
  }
  spectrum->UpdatePropertyInformation();
  const bool isCT = isosurface::AreTissuesIn(vtkSMPropertyHelper(spectrum, "Unit").GetAsString());
  const std::array<double, 2> range = this->FindRange(spectrum);
  const double bone = isosurface::Bone.Isovalue;
  return isCT && range[0] < bone && bone <= range[1]
    ? bone
    : vtkSMPropertyHelper(spectrum, "Proposal").GetAsDouble();
}

std::array<double, 2> vtkSMIsovalueDomain::FindRange(vtkSMProxy* spectrum)
{
  if (this->GetMinimumExists(0) && this->GetMaximumExists(0))
  {
    return { this->GetMinimum(0), this->GetMaximum(0) };
  }
  const std::vector<double> rows = vtkSMPropertyHelper(spectrum, "Spectrum").GetDoubleArray();
  return rows.size() >= RowLength
    ? std::array<double, 2>{ rows.front(), rows[rows.size() - RowLength] }
    : std::array<double, 2>{ None, None };
}

void vtkSMIsovalueDomain::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}
