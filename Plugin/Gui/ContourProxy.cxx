// SPDX-License-Identifier: BSD-3-Clause
#include "ContourProxy.h"

#include "vtkClientServerStream.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkPVDataSetAttributesInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"

#include <cstring>
#include <vector>

namespace isosurface
{

bool IsStabbingContour(vtkSMProxy* proxy)
{
  return proxy && proxy->GetXMLName() &&
    (std::strcmp(proxy->GetXMLName(), "Isosurface") == 0 ||
      std::strcmp(proxy->GetXMLName(), "StabbingContour") == 0);
}

bool IsRefined(vtkSMProxy* proxy)
{
  return IsStabbingContour(proxy) ||
    (proxy && proxy->GetXMLName() && std::strcmp(proxy->GetXMLName(), "VolumeSlice") == 0);
}

bool IsFinal(vtkSMProxy* contour)
{
  contour->UpdatePropertyInformation(contour->GetProperty("Final"));
  return vtkSMPropertyHelper(contour, "Final").GetAsInt() != 0;
}

Refinement ReadRefinement(vtkSMProxy* proxy)
{
  proxy->UpdatePropertyInformation(proxy->GetProperty("Refinement"));
  const std::vector<double> values = vtkSMPropertyHelper(proxy, "Refinement").GetDoubleArray();
  return values.size() == Refinement::Values().size() ? Refinement::FromValues(values.data())
                                                      : Refinement();
}

int ReadLevel(vtkSMProxy* contour)
{
  auto* source = vtkSMSourceProxy::SafeDownCast(contour);
  vtkPVArrayInformation* level =
    source->GetDataInformation(0)->GetFieldDataInformation()->GetArrayInformation("Level");
  return level ? static_cast<int>(level->GetComponentRange(0)[1]) : 0;
}

void CallOnServer(vtkSMProxy* proxy, const char* method)
{
  vtkClientServerStream stream;
  stream << vtkClientServerStream::Invoke << VTKOBJECT(proxy) << method
         << vtkClientServerStream::End;
  proxy->GetSession()->ExecuteStream(proxy->GetLocation(), stream);
}

void CallOnServer(vtkSMProxy* proxy, const char* method, int argument)
{
  vtkClientServerStream stream;
  stream << vtkClientServerStream::Invoke << VTKOBJECT(proxy) << method << argument
         << vtkClientServerStream::End;
  proxy->GetSession()->ExecuteStream(proxy->GetLocation(), stream);
}

void CallOnServer(vtkSMProxy* proxy, const char* method, const std::vector<double>& numbers)
{
  vtkClientServerStream stream;
  stream << vtkClientServerStream::Invoke << VTKOBJECT(proxy) << method
         << vtkClientServerStream::InsertArray(numbers.data(), static_cast<int>(numbers.size()))
         << vtkClientServerStream::End;
  proxy->GetSession()->ExecuteStream(proxy->GetLocation(), stream);
}

} // namespace isosurface
