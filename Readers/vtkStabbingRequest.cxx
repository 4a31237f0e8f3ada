// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkStabbingRequest.h"

#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkStabbingRequest);

//------------------------------------------------------------------------------
void vtkStabbingRequest::SetArrayName(const std::string& name)
{
  if (this->ArrayName != name)
  {
    this->ArrayName = name;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkStabbingRequest::SetIsovalues(const std::vector<double>& isovalues)
{
  if (this->Isovalues != isovalues)
  {
    this->Isovalues = isovalues;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
bool vtkStabbingRequest::Serves(const vtkStabbingRequest* made, const vtkStabbingRequest* wanted)
{
  if (wanted && wanted->HandleOnly)
  {
    return true;
  }
  if (made && made->HandleOnly)
  {
    return false;
  }
  const bool madeForAll = !made || made->Isovalues.empty();
  const bool wantedForAll = !wanted || wanted->Isovalues.empty();
  if (madeForAll || wantedForAll)
  {
    return madeForAll == wantedForAll;
  }
  return made->ArrayName == wanted->ArrayName && made->Component == wanted->Component &&
    made->Isovalues == wanted->Isovalues;
}

//------------------------------------------------------------------------------
void vtkStabbingRequest::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ArrayName: " << this->ArrayName << "\n";
  os << indent << "Component: " << this->Component << "\n";
  os << indent << "Isovalues:";
  for (const double isovalue : this->Isovalues)
  {
    os << ' ' << isovalue;
  }
  os << "\n";
  os << indent << "HandleOnly: " << this->HandleOnly << "\n";
}
