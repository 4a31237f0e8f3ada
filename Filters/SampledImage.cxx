// SPDX-License-Identifier: BSD-3-Clause
#include "SampledImage.h"

#include "BlockImage.h"
#include "VolumeInput.h"
#include "VolumeReading.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkAlgorithm.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkExtentTranslator.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUnsignedCharArray.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "RectilinearGrids.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

using Pipeline = vtkStreamingDemandDrivenPipeline;

// "300 x 200 points, full resolution"
std::string Describe(const ImagePlan& plan, const VolumeInput& input)
{
  const std::string& sample = input.GetHandle().GetSampleText();
  const std::string level =
    plan.Level == 0 ? "full resolution" : "level " + std::to_string(plan.Level);
  return plan.Size + ", " + (sample.empty() ? level : sample) +
    (plan.Note.empty() ? "" : "; " + plan.Note);
}

// The piece that is asked for of an image, by whichever output.
VertexBox FindPart(const ImagePlan& plan, vtkInformation* request, vtkInformationVector* output)
{
  vtkInformation* outInfo =
    output->GetInformationObject(std::max(0, request->Get(vtkExecutive::FROM_OUTPUT_PORT())));
  int whole[6];
  std::copy(plan.Grid.Extent.begin(), plan.Grid.Extent.end(), whole);
  const int pieces = std::max(1, outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  int extent[6];
  vtkNew<vtkExtentTranslator> translator;
  VertexBox part;
  if (translator->PieceToExtentThreadSafe(outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()), pieces, 0,
        whole, extent, vtkExtentTranslator::BLOCK_MODE, 0) == 0)
  {
    return part;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    part.Low[axis] = extent[2 * axis] - whole[2 * axis];
    part.High[axis] = extent[2 * axis + 1] - whole[2 * axis] + 1;
  }
  return part;
}

// Hides the points that are not within the volume from filters and from the Surface representation.
// Parts without such points have the array, too: what joins or writes parts takes arrays of all.
void HideOutside(vtkImageData* image, const std::vector<std::uint8_t>& isInside)
{
  if (isInside.empty())
  {
    return;
  }
  vtkUnsignedCharArray* ghosts = image->AllocatePointGhostArray();
  for (std::size_t point = 0; point < isInside.size(); ++point)
  {
    ghosts->SetValue(
      static_cast<vtkIdType>(point), isInside[point] != 0 ? 0 : vtkDataSetAttributes::HIDDENPOINT);
  }
}

} // namespace

void SampledImage::TellImage(vtkInformation* inInfo, vtkInformation* outInfo,
  vtkMultiProcessController* controller, const Planner& plan)
{
  const VolumeInput input(inInfo);
  if (input && input.GetHandle().IsUntried())
  {
    // The extent of an image cannot be told later.
    this->Filter.GetInputAlgorithm(0, 0)->UpdatePiece(
      controller ? controller->GetLocalProcessId() : 0,
      controller ? controller->GetNumberOfProcesses() : 1, 0);
  }
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  int extent[6] = { 0, -1, 0, -1, 0, -1 };
  ImagePlan image;
  this->Text.clear();
  if (input && input.GetVolume())
  {
    const auto planned = plan(*input.GetVolume(), input.GetHandle().GetArrays());
    if (planned.IsOk()) // else RequestData tells why not
    {
      image = *planned;
      this->Text = Describe(image, input);
      std::copy(image.Grid.Extent.begin(), image.Grid.Extent.end(), extent);
    }
  }
  outInfo->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
  outInfo->Set(vtkDataObject::ORIGIN(), image.Grid.Origin.data(), 3);
  outInfo->Set(vtkDataObject::SPACING(), image.Grid.Spacing.data(), 3);
  outInfo->Set(vtkDataObject::DIRECTION(), image.Grid.Direction.data(), 9);
  // What kind of grid it is, is known no earlier.
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  if (image.Lines && !vtkRectilinearGrid::SafeDownCast(made))
  {
    outInfo->Set(vtkDataObject::DATA_OBJECT(), vtkNew<vtkRectilinearGrid>());
  }
  else if (!image.Lines && !vtkImageData::SafeDownCast(made))
  {
    outInfo->Set(vtkDataObject::DATA_OBJECT(), vtkNew<vtkImageData>());
  }
}

bool SampledImage::Make(vtkInformation* request, vtkInformation* inInfo,
  vtkInformationVector* output, vtkMultiProcessController* controller, std::uint64_t properties,
  const Planner& plan, const Filler& fill, int& result)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkDataObject::GetData(outInfo)->Initialize();
  const VolumeInput input(inInfo);
  ControllerCommunicator ranks(controller);
  const Status status = ReadVolume(this->Filter, ranks, input, properties,
    [&](int threads) -> Status
    {
      const auto planned = plan(*input.GetVolume(), input.GetHandle().GetArrays());
      ISOSURFACE_RETURN_IF_ERROR(planned.GetStatus());
      this->Text = Describe(*planned, input);
      return this->FillPart(
        input, FindPart(*planned, request, output), outInfo, threads, *planned, fill);
    });
  if (!status.IsOk())
  {
    this->Text.clear();
    vtkDataObject::GetData(outInfo)->Initialize();
  }
  result = EndExecution(&this->Filter, output, status);
  return status.IsOk();
}

Result<std::shared_ptr<const LevelSamples>> SampledImage::OpenSamples(
  const VolumeInput& input, int level)
{
  if (!this->Samples || &this->Samples->GetVolume() != input.GetVolume().get() ||
    this->Samples->GetTimeStep() != input.GetTimeStep() || this->Samples->GetLevel() != level)
  {
    this->Samples = nullptr;
    auto opened = LevelSamples::Open(input.GetVolume(), input.GetTimeStep(), level);
    ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
    this->Samples = std::move(*opened);
  }
  return this->Samples;
}

Status SampledImage::FillPart(const VolumeInput& input, const VertexBox& part,
  vtkInformation* outInfo, int threads, const ImagePlan& plan, const Filler& fill)
{
  const auto samples = this->OpenSamples(input, plan.Level);
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  if (part.IsEmpty())
  {
    return Status::Ok();
  }
  BlockedVolume& volume = *input.GetVolume();
  const std::vector<std::size_t> arrays = input.GetHandle().GetArrays();
  vtkSmartPointer<vtkImageData> image = MakeImage(plan.Grid, part);
  std::vector<std::uint8_t> isInside(
    plan.HasOutside ? static_cast<std::size_t>(part.GetNumberOfVertices()) : 0, 1);
  QueryStatistics statistics;
  const int all = CountComponents(volume, arrays);
  int done = 0;
  for (const std::size_t array : arrays)
  {
    const ArrayDescription& description = volume.GetHeader().Arrays[array];
    vtkSmartPointer<vtkDataArray> values = AddArray(image, description);
    for (int component = 0; component < description.Components; ++component, ++done)
    {
      if (plan.HasOutside)
      {
        FillWithMinimum(volume, input.GetTimeStep(), array, component, values);
      }
      ISOSURFACE_RETURN_IF_ERROR(
        fill(**samples, *volume.GetVariables().Find(array, component), part, threads,
          values->GetVoidPointer(component), description.Components, isInside.data(), statistics,
          MakeProgress(
            this->Filter, static_cast<double>(done) / all, static_cast<double>(done + 1) / all)));
    }
    StoreVolumeRanges(volume, input.GetTimeStep(), array, values);
  }
  HideOutside(image, isInside);
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  if (plan.Lines)
  {
    made->ShallowCopy(MakeRectilinearGrid(image, plan.Lines->Cut(part)));
  }
  else
  {
    made->ShallowCopy(image);
  }
  return Status::Ok();
}

} // namespace isosurface
