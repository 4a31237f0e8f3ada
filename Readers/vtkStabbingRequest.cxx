// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkStabbingRequest.h"

#include "vtkObjectFactory.h"

#include "Volume/BlockSelection.h"

vtkStandardNewMacro(vtkStabbingRequest);

//------------------------------------------------------------------------------
vtkStabbingRequest::vtkStabbingRequest()
  : Selection(new isosurface::BlockSelection)
{
}

//------------------------------------------------------------------------------
vtkStabbingRequest::~vtkStabbingRequest() = default;

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
void vtkStabbingRequest::SetSelection(const isosurface::BlockSelection& selection)
{
  if (!(*this->Selection == selection))
  {
    *this->Selection = selection;
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
    made->Isovalues == wanted->Isovalues && made->Level == wanted->Level &&
    *made->Selection == *wanted->Selection;
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
  os << indent << "Level: " << this->Level << "\n";
  os << indent
     << "Selection: " << (this->Selection->ClosedSides.IsEmpty() ? "open" : "closed at the border")
     << ", " << this->Selection->Region.GetHalfSpaces().size() << " half-spaces\n";
  os << indent << "HandleOnly: " << this->HandleOnly << "\n";
}
