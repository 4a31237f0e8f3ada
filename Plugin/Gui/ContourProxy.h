// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ContourProxy_h
#define isosurface_ContourProxy_h

class vtkSMProxy;

namespace isosurface
{

/// The Refinement of vtkStabbingContour and vtkVolumeSlice, as their documentation says.
struct RefinementReport
{
  enum Stages
  {
    Nothing,
    Working,
    Ready,
    TooLarge,
    Growing
  };
  int Stage = Nothing;
  int ShownLevel = 0;
  int NextLevel = 0;
  int FinalLevel = 0;
  int FittingLevel = 0;
  double Share = 0;
  double Triangles = 0;
  double Bytes = 0;
  double FreeBytes = 0;
};

bool IsStabbingContour(vtkSMProxy* proxy);
/// Whether it is a filter that gives something coarse first: a contour or a slice.
bool IsRefined(vtkSMProxy* proxy);
/// Asks the server.
bool IsFinal(vtkSMProxy* contour);
/// Asks the server: what its last PrepareRefinement found.
RefinementReport ReadRefinement(vtkSMProxy* contour);

/// The level of its last surface or slice, as the window knows it.
int ReadLevel(vtkSMProxy* contour);

/// Calls a method of a proxy's object wherever it is, on all ranks, without waiting for the end.
/// Unlike vtkSMProxy::InvokeCommand this does not tell representations that data has changed.
void CallOnServer(vtkSMProxy* proxy, const char* method);
void CallOnServer(vtkSMProxy* proxy, const char* method, int argument);

} // namespace isosurface

#endif
