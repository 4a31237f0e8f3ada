// SPDX-License-Identifier: BSD-3-Clause
#include "WriterInput.h"

#include "vtkAlgorithm.h"
#include "vtkAlgorithmOutput.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkImageData.h"
#include "vtkPartitionedDataSet.h"
#include "vtkRectilinearGrid.h"

#include "ImageSamples.h"
#include "PipelineSource.h"
#include "RectilinearGrids.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace isosurface
{

Result<WriterInput> WriterInput::Take(vtkDataObject* data)
{
  WriterInput taken;
  taken.Image = vtkImageData::SafeDownCast(data);
  auto* grid = vtkRectilinearGrid::SafeDownCast(data);
  if (grid && grid->GetNumberOfPoints() > 0)
  {
    taken.Image = MakeStructuredImage(grid);
    taken.Lines = MakeGridLines(grid);
    ISOSURFACE_RETURN_IF_ERROR(
      taken.Lines->Check(MakeGridGeometry(taken.Image, grid->GetExtent()).GetDimensions()));
  }
  return taken;
}

Result<WriterInput> WriterInput::Find(vtkDataObject* input)
{
  auto* composite = vtkCompositeDataSet::SafeDownCast(input);
  if (!composite)
  {
    return Take(input);
  }
  // Ranks have partitions of their own; of all other composites they have the same parts, some of
  // which are on other ranks.
  vtkSmartPointer<vtkCompositeDataIterator> part;
  part.TakeReference(composite->NewIterator());
  part->SetSkipEmptyNodes(vtkPartitionedDataSet::SafeDownCast(input) != nullptr);
  int count = 0;
  vtkDataObject* only = nullptr;
  for (part->InitTraversal(); !part->IsDoneWithTraversal(); part->GoToNextItem(), ++count)
  {
    only = part->GetCurrentDataObject();
  }
  if (count > 1)
  {
    return Status(StatusCode::Unsupported,
      "the input has " + std::to_string(count) +
        " parts, but a blocked volume is one grid; extract one of them");
  }
  return Take(only);
}

Result<GridLines> WriterInput::FindWholeLines(
  vtkAlgorithmOutput* input, vtkInformation* information, const int whole[6]) const
{
  GridLines lines;
  std::array<int, 6> column;
  std::copy(whole, whole + 6, column.begin());
  column[1] = column[0];
  column[3] = column[2];
  // The lines on x and y before the pipeline is updated: the slice may be its output.
  const std::array<int, 6> slice = { whole[0], whole[1], whole[2], whole[3], whole[4], whole[4] };
  const auto cut = [&lines](const WriterInput& from, const std::array<int, 6>& extent, int axis)
  {
    const int* has = from.Image->GetExtent();
    if (!from.Lines || has[2 * axis] > extent[2 * axis] || has[2 * axis + 1] < extent[2 * axis + 1])
    {
      return false;
    }
    const std::vector<double>& all = from.Lines->Coordinates[static_cast<std::size_t>(axis)];
    const auto first = all.begin() + (extent[2 * axis] - has[2 * axis]);
    lines.Coordinates[static_cast<std::size_t>(axis)].assign(
      first, first + (extent[2 * axis + 1] - extent[2 * axis] + 1));
    return true;
  };
  const Status incomplete(StatusCode::Unsupported,
    std::string("the input (") + input->GetProducer()->GetClassName() +
      ") does not deliver the coordinates of its extent");
  if (!cut(*this, slice, 0) || !cut(*this, slice, 1))
  {
    return incomplete;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto taken, Take(PipelineSource::Update(input, information, column.data())));
  if (!taken.Image || !cut(taken, column, 2))
  {
    return incomplete;
  }
  return lines;
}

} // namespace isosurface
