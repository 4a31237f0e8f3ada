// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourProxy_h
#define isosurface_ContourProxy_h

#include "Ranks/Query/Refinement.h"

#include <vector>

class vtkSMProxy;

namespace isosurface
{

bool IsStabbingContour(vtkSMProxy* proxy);
/// Whether it is a filter that gives something coarse first: a contour or a slice.
bool IsRefined(vtkSMProxy* proxy);
/// Asks the server.
bool IsFinal(vtkSMProxy* contour);
/// Asks the server of a contour, slice, spectrum or reader that indexes how far its work is.
Refinement ReadRefinement(vtkSMProxy* proxy);

/// The level of its last surface or slice, as the window knows it.
int ReadLevel(vtkSMProxy* contour);

/// Calls a method of a proxy's object wherever it is, on all ranks, without waiting for the end.
/// Unlike vtkSMProxy::InvokeCommand this does not tell representations that data has changed.
void CallOnServer(vtkSMProxy* proxy, const char* method);
void CallOnServer(vtkSMProxy* proxy, const char* method, int argument);
void CallOnServer(vtkSMProxy* proxy, const char* method, const std::vector<double>& numbers);

} // namespace isosurface

#endif
