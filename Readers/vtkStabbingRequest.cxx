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
bool vtkStabbingRequest::AreEqual(const vtkStabbingRequest* a, const vtkStabbingRequest* b)
{
  const bool emptyA = !a || a->Isovalues.empty();
  const bool emptyB = !b || b->Isovalues.empty();
  if (emptyA || emptyB)
  {
    return emptyA == emptyB;
  }
  return a->ArrayName == b->ArrayName && a->Isovalues == b->Isovalues;
}

//------------------------------------------------------------------------------
void vtkStabbingRequest::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ArrayName: " << this->ArrayName << "\n";
  os << indent << "Isovalues:";
  for (const double isovalue : this->Isovalues)
  {
    os << ' ' << isovalue;
  }
  os << "\n";
}
