// SPDX-License-Identifier: BSD-3-Clause
#include "PieceSource.h"

#include "RankGroup.h"
#include "TestImages.h"

#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>

namespace isosurface
{

vtkStandardNewMacro(PieceSource);

PieceSource::PieceSource()
  : Layout(SUB_EXTENTS)
{
  this->SetNumberOfInputPorts(0);
}

void PieceSource::SetImage(vtkImageData* image)
{
  this->Image = image;
  this->Modified();
}

int PieceSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* info = output->GetInformationObject(0);
  info->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), this->Image->GetExtent(), 6);
  // With neither of these the pipeline executes a source on the first rank alone.
  info->Set(vtkAlgorithm::CAN_PRODUCE_SUB_EXTENT(), this->Layout == SUB_EXTENTS ? 1 : 0);
  info->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(),
    this->Layout == SUB_EXTENTS || this->Layout == FIRST_RANK ? 0 : 1);
  return 1;
}

int PieceSource::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* info = output->GetInformationObject(0);
  vtkImageData* piece = vtkImageData::GetData(output, 0);
  Extent extent;
  std::copy_n(this->Image->GetExtent(), 6, extent.begin());
  const int layers = extent[5] - extent[4] + 1;
  switch (this->Layout)
  {
    case SUB_EXTENTS:
      info->Get(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent.data());
      break;
    case FIRST_RANK:
      if (GetRank() != 0)
      {
        extent = { 0, -1, 0, -1, 0, -1 };
      }
      break;
    case OVERLAPPING:
    case GAP:
    {
      const int low = extent[4];
      const int high = extent[5] - (this->Layout == GAP ? 1 : 0);
      extent[4] = std::max(low, low + layers * GetRank() / GetNumberOfRanks() - 3);
      extent[5] = std::min(high, low + layers * (GetRank() + 1) / GetNumberOfRanks() + 3);
      break;
    }
    case EVERYWHERE:
    default:
      break;
  }
  const bool isEmpty = extent[0] > extent[1] || extent[2] > extent[3] || extent[4] > extent[5];
  if (std::equal(extent.begin(), extent.end(), this->Image->GetExtent()))
  {
    piece->ShallowCopy(this->Image); // with all its arrays
  }
  else if (!isEmpty)
  {
    piece->ShallowCopy(CutImage(this->Image, extent));
  }
  return 1;
}

} // namespace isosurface
