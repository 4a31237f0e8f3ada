// SPDX-License-Identifier: BSD-3-Clause
#include "PipelineSource.h"

#include "vtkAlgorithm.h"
#include "vtkAlgorithmOutput.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "ImageSamples.h"
#include "LocalVolume.h"
#include "WriterInput.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using Pipeline = vtkStreamingDemandDrivenPipeline;

/// Every rank asks for an extent of the whole, not for a piece.
void AskForExtent(vtkInformation* information, const int extent[6])
{
  information->Set(Pipeline::UPDATE_EXTENT(), extent, 6);
  information->Set(Pipeline::UPDATE_PIECE_NUMBER(), 0);
  information->Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), 1);
  information->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
}

} // namespace

PipelineSource::PipelineSource(vtkAlgorithmOutput* input, vtkInformation* information,
  const GridGeometry& grid, const std::vector<ArrayDescription>& arrays, bool withCells)
  : Input(input)
  , Information(information)
  , Grid(grid)
  , Arrays(arrays)
  , Box{ { 0, 0, 0 }, grid.GetDimensions() }
  , WithCells(withCells)
{
}

void PipelineSource::AskForFirstSlice(vtkInformation* information, bool withCells)
{
  if (information->Has(Pipeline::WHOLE_EXTENT()))
  {
    int extent[6];
    information->Get(Pipeline::WHOLE_EXTENT(), extent);
    // A slice of cells has two of vertices.
    extent[5] = std::min(extent[5], extent[4] + (withCells ? 1 : 0));
    AskForExtent(information, extent);
  }
}

std::uint64_t PipelineSource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const ArrayDescription& array : this->Arrays)
  {
    bytes += GetValueSize(array.Type) * static_cast<std::uint64_t>(array.Components);
  }
  return bytes * static_cast<std::uint64_t>(box.GetNumberOfVertices());
}

vtkDataObject* PipelineSource::UpdateInput(const VertexBox& box)
{
  int extent[6];
  const std::int64_t layers = this->WithCells ? 1 : 0;
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto index = static_cast<std::size_t>(axis);
    const std::int64_t first = this->Grid.Extent[2 * index];
    const std::int64_t low = std::max<std::int64_t>(0, box.Low[index] - layers);
    const std::int64_t high = std::min(this->Box.High[index], box.High[index] + layers);
    extent[2 * axis] = static_cast<int>(first + low);
    extent[2 * axis + 1] = static_cast<int>(first + high - 1);
  }
  return Update(this->Input, this->Information, extent);
}

vtkDataObject* PipelineSource::Update(
  vtkAlgorithmOutput* input, vtkInformation* information, const int extent[6])
{
  vtkNew<vtkInformationVector> requests;
  requests->SetNumberOfInformationObjects(input->GetIndex() + 1);
  vtkInformation* request = requests->GetInformationObject(input->GetIndex());
  AskForExtent(request, extent);
  if (information->Has(Pipeline::UPDATE_TIME_STEP()))
  {
    request->Set(Pipeline::UPDATE_TIME_STEP(), information->Get(Pipeline::UPDATE_TIME_STEP()));
  }
  vtkAlgorithm* producer = input->GetProducer();
  producer->Update(input->GetIndex(), requests);
  return producer->GetOutputDataObject(input->GetIndex());
}

bool PipelineSource::TakeArrays(
  const LocalVolume& local, const VertexBox& box, BoxSamples& samples) const
{
  for (const ArrayDescription& wanted : this->Arrays)
  {
    const auto found = std::find_if(local.Arrays.begin(), local.Arrays.end(),
      [&wanted](const ArrayDescription& any)
      {
        return any.Name == wanted.Name && any.Type == wanted.Type &&
          any.Components == wanted.Components;
      });
    if (found == local.Arrays.end())
    {
      return false;
    }
    const std::size_t first =
      ArrayVariables(local.Arrays).GetFirst(static_cast<std::size_t>(found - local.Arrays.begin()));
    for (std::size_t n = 0; n < static_cast<std::size_t>(wanted.Components); ++n)
    {
      SampleView view = local.Piece.Arrays[first + n];
      if (!(view.Available.Intersect(box) == box))
      {
        return false;
      }
      view.Box = box;
      samples.Arrays.push_back(view);
    }
  }
  return true;
}

Result<BoxSamples> PipelineSource::Read(const VertexBox& box)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto input, WriterInput::Take(this->UpdateInput(box)));
  if (!input.Image)
  {
    return Status(StatusCode::InvalidArgument, "the input is no image data any more");
  }
  auto local = std::make_shared<LocalVolume>();
  local->Grid = this->Grid;
  local->WithCells = this->WithCells;
  ISOSURFACE_RETURN_IF_ERROR(local->CollectArrays(input.Image,
    [this](const std::string& name)
    {
      return std::any_of(this->Arrays.begin(), this->Arrays.end(),
        [&name](const ArrayDescription& array) { return array.Name == name; });
    }));
  BoxSamples samples;
  if (!this->TakeArrays(*local, box, samples))
  {
    return Status(StatusCode::Unsupported,
      std::string("the input (") + this->Input->GetProducer()->GetClassName() +
        ") does not deliver the part of its extent that it is asked for, with the same arrays; "
        "without a memory limit it is asked for its piece at once");
  }
  samples.Owner = std::move(local);
  return samples;
}

} // namespace isosurface
