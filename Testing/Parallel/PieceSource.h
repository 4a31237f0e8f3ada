// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_PieceSource_h
#define isosurface_PieceSource_h

#include "vtkImageAlgorithm.h"
#include "vtkSmartPointer.h"

class vtkImageData;

namespace isosurface
{

/// Gives each rank a part of an image that all have, as readers of various kinds do.
class PieceSource : public vtkImageAlgorithm
{
public:
  enum LayoutType
  {
    SUB_EXTENTS, ///< what the pipeline asks for: pieces that share a face of vertices
    FIRST_RANK,  ///< all on rank 0, nothing elsewhere
    OVERLAPPING, ///< slabs that overlap by several layers
    EVERYWHERE,  ///< all on every rank
    GAP          ///< as OVERLAPPING, but without the last layer of vertices
  };

  static PieceSource* New();
  vtkTypeMacro(PieceSource, vtkImageAlgorithm);

  void SetImage(vtkImageData* image);
  vtkSetMacro(Layout, int);

protected:
  PieceSource();

  int RequestInformation(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;
  int RequestData(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

private:
  vtkSmartPointer<vtkImageData> Image;
  int Layout;
};

} // namespace isosurface

#endif
