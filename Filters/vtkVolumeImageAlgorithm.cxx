// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkVolumeImageAlgorithm.h"

#include "BlockImage.h"
#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkDataSetAttributes.h"
#include "vtkExecutive.h"
#include "vtkExtentTranslator.h"
#include "vtkFieldData.h"
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
#include "Ground/Base/Fingerprint.h"
#include "RangedArray.h"
#include "Ranks/Query/FieldRefinement.h"
#include "Ranks/Query/ImageField.h"
#include "RectilinearGrids.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <string>
#include <utility>

vtkCxxSetObjectMacro(vtkVolumeImageAlgorithm, Controller, vtkMultiProcessController);

using namespace isosurface;

namespace
{

using Pipeline = vtkStreamingDemandDrivenPipeline;

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
  const bool hasPart =
    translator->PieceToExtentThreadSafe(outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()), pieces, 0,
      whole, extent, vtkExtentTranslator::BLOCK_MODE, 0) != 0;
  return hasPart ? MakeVertexBox(plan.Grid, extent) : VertexBox();
}

// Hides the points that are not within the volume from filters and from the Surface representation.
// Parts without such points have the array, too: what joins or writes parts takes arrays of all.
void HideOutside(vtkImageData* image, const std::vector<std::uint8_t>& isInside)
{
  if (isInside.empty())
  {
    return;
  }
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  AllocateTuples(ghosts, image->GetNumberOfPoints());
  image->GetPointData()->AddArray(ghosts);
  std::transform(isInside.begin(), isInside.end(), ghosts->GetPointer(0),
    [](std::uint8_t is)
    { return static_cast<unsigned char>(is != 0 ? 0 : vtkDataSetAttributes::HIDDENPOINT); });
}

// Gives a dataset of the pipeline what was filled in of an image.
void FillDataSet(SampledBox& part, vtkDataObject* made)
{
  if (part.Box.IsEmpty())
  {
    return;
  }
  const auto image = MakeImage(part.Plan.Grid, part.Box);
  for (std::size_t number = 0; number < part.Arrays.size(); ++number)
  {
    const std::size_t array = part.Arrays[number];
    StoreVolumeRanges(*part.Volume, part.TimeStep, array,
      AddArray(image, part.Volume->GetHeader().Arrays[array], std::move(part.Values[number])));
  }
  HideOutside(image, part.IsInside);
  AddToFieldData(image, "Level", part.Plan.Level);
  if (part.Plan.Lines)
  {
    made->ShallowCopy(MakeRectilinearGrid(image, part.Plan.Lines->Cut(part.Box)));
  }
  else
  {
    made->ShallowCopy(image);
  }
}

/// The image in words.
std::string Describe(const ImagePlan& plan, const VolumeInput& input)
{
  const std::string& sample = input.GetHandle().GetSampleText();
  const std::string level = !sample.empty() ? sample
    : plan.Level == 0                       ? "full resolution"
                                            : "level " + std::to_string(plan.Level);
  return plan.Size + ", " + level + plan.Note;
}

void TellGrid(const GridGeometry& grid, vtkInformation* outInfo)
{
  int extent[6];
  std::copy(grid.Extent.begin(), grid.Extent.end(), extent);
  outInfo->Set(Pipeline::WHOLE_EXTENT(), extent, 6);
  // What was asked for of another image may be outside of this one, which VTK refuses.
  outInfo->Set(Pipeline::UPDATE_EXTENT(), extent, 6);
  outInfo->Remove(Pipeline::COMBINED_UPDATE_EXTENT());
  outInfo->Set(vtkDataObject::ORIGIN(), grid.Origin.data(), 3);
  outInfo->Set(vtkDataObject::SPACING(), grid.Spacing.data(), 3);
  outInfo->Set(vtkDataObject::DIRECTION(), grid.Direction.data(), 9);
}

} // namespace

struct vtkVolumeImageAlgorithm::Work
{
  /// What an image is made of; the filter's properties aside, the same on all ranks.
  std::uint64_t SumSource(const VolumeInput& input) const;
  /// Plans the exact image and the coarse one, and the parts that are asked for of them. Not collective.
  Status Ask(
    const VolumeInput& input, vtkInformation* request, vtkInformationVector* output, int threads);
  Status FillOutput(
    const VolumeInput& input, int level, vtkInformation* inInfo, vtkInformation* outInfo);

  vtkVolumeImageAlgorithm& Filter;
  bool CoarseAllowed = false;
  bool IsOnlyTold = false;  ///< whether the pipeline was told of an image that is not made yet
  std::uint64_t Source = 0; ///< of the last image
  ImageField Image{};
  FieldRefinement Levels{};
};

vtkVolumeImageAlgorithm::vtkVolumeImageAlgorithm()
  : Refinement(isosurface::Refinement().ToValues())
  , Internals(new Work{ *this })
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkVolumeImageAlgorithm::~vtkVolumeImageAlgorithm()
{
  this->SetController(nullptr);
}

int vtkVolumeImageAlgorithm::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObject");
  return 1;
}

int vtkVolumeImageAlgorithm::RequestDataObject(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  if (!vtkDataObject::GetData(outInfo))
  {
    outInfo->Set(vtkDataObject::DATA_OBJECT(), vtkNew<vtkImageData>());
  }
  return 1;
}

int vtkVolumeImageAlgorithm::RequestInformation(
  vtkInformation*, vtkInformationVector** inputs, vtkInformationVector* output)
{
  Work& work = *this->Internals;
  vtkInformation* outInfo = output->GetInformationObject(0);
  const VolumeInput input(inputs[0]->GetInformationObject(0));
  const ControllerCommunicator ranks(this->Controller);
  // The extent of an image cannot be told later.
  if (input && input.GetHandle().IsUntried() &&
    !this->GetInputAlgorithm(0, 0)->UpdatePiece(ranks.GetRank(), ranks.GetSize(), 0))
  {
    // On all ranks. To go on would execute the input again, which would tell its error twice.
    vtkDataObject::GetData(outInfo)->Initialize();
    MarkFailure(output);
    outInfo->Remove(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()); // nothing is being generated
    return 0;
  }
  for (int port = 0; port < output->GetNumberOfInformationObjects(); ++port)
  {
    output->GetInformationObject(port)->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  }
  ImagePlan image;
  image.Grid.Extent = { 0, -1, 0, -1, 0, -1 };
  this->ShownText.clear();
  work.IsOnlyTold = false;
  if (input.GetVolume())
  {
    work.IsOnlyTold = work.SumSource(input) != work.Source;
    const auto plan = [&]() -> Status
    {
      ImagePlan planned;
      ISOSURFACE_RETURN_IF_ERROR(this->Plan(*input.GetVolume(), input.GetHandle().GetArrays(),
        work.IsOnlyTold ? work.CoarseAllowed : !work.Levels.IsNextFinest(), planned));
      this->ShownText = Describe(planned, input);
      image = std::move(planned);
      return Status::Ok();
    };
    // RequestData tells why not.
    static_cast<void>(Attempt("", plan));
  }
  TellGrid(image.Grid, outInfo);
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
  return 1;
}

int vtkVolumeImageAlgorithm::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  const int port = std::max(0, request->Get(vtkExecutive::FROM_OUTPUT_PORT()));
  AskVolume(*this, input[0]->GetInformationObject(0), output->GetInformationObject(port));
  return 1;
}

int vtkVolumeImageAlgorithm::RequestData(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  return EndExecution(
    this, output, this->MakeImage(request, input[0]->GetInformationObject(0), output));
}

Status vtkVolumeImageAlgorithm::MakeImage(
  vtkInformation* request, vtkInformation* inInfo, vtkInformationVector* output)
{
  Work& work = *this->Internals;
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkDataObject::GetData(outInfo)->Initialize();
  const VolumeInput input(inInfo);
  ControllerCommunicator ranks(this->Controller);
  work.Source = work.SumSource(input);
  work.IsOnlyTold = false;
  int level = 0;
  Status status = AgreeOnVolume(*this, ranks, input, this->SumProperties());
  if (status.IsOk())
  {
    const int threads = ranks.ChooseThreads(0);
    const RefinementRequest wanted = { 0, false, work.CoarseAllowed, false, work.Source };
    const auto choice =
      work.Levels.Begin(ranks, work.Image, wanted, work.Ask(input, request, output, threads));
    status = choice.GetStatus();
    level = choice.IsOk() ? choice->Level : 0;
  }
  if (status.IsOk())
  {
    status = ReadVolume(
      *this, ranks, input, [&] { return work.FillOutput(input, level, inInfo, outInfo); });
  }
  work.Levels.SetShown(status.IsOk(), level, 0);
  this->Final = !status.IsOk() || work.Levels.IsFinal() ? 1 : 0;
  if (!status.IsOk())
  {
    work.Levels.KeepChange(work.Source = 0); // begins anew
    this->ShownText.clear();
  }
  return status;
}

std::uint64_t vtkVolumeImageAlgorithm::Work::SumSource(const VolumeInput& input) const
{
  Fingerprint source;
  source.AddNumber(this->Filter.SumProperties());
  if (input.GetVolume())
  {
    source.AddNumber(reinterpret_cast<std::uintptr_t>(input.GetVolume().get()));
    source.AddNumber(input.GetTimeStep());
    for (const std::size_t array : input.GetHandle().GetArrays())
    {
      source.AddNumber(array);
    }
  }
  return source.Get();
}

Status vtkVolumeImageAlgorithm::Work::Ask(
  const VolumeInput& input, vtkInformation* request, vtkInformationVector* output, int threads)
{
  const auto plan = [&](bool isCoarse, SampledBox& part) -> Status
  {
    part.Volume = input.GetVolume();
    part.TimeStep = input.GetTimeStep();
    part.Arrays = input.GetHandle().GetArrays();
    part.Beyond = ValueBeyond::Minimum;
    part.Threads = threads;
    ISOSURFACE_RETURN_IF_ERROR(this->Filter.Plan(*part.Volume, part.Arrays, isCoarse, part.Plan));
    part.Box = FindPart(part.Plan, request, output);
    return Status::Ok();
  };
  const auto ask = [&]() -> Status
  {
    SampledBox exact;
    SampledBox coarse;
    ISOSURFACE_RETURN_IF_ERROR(plan(false, exact));
    ISOSURFACE_RETURN_IF_ERROR(plan(true, coarse));
    this->Image.Ask(this->Source, std::move(exact), std::move(coarse));
    return Status::Ok();
  };
  return Attempt("the samples cannot be read", ask);
}

Status vtkVolumeImageAlgorithm::Work::FillOutput(
  const VolumeInput& input, int level, vtkInformation* inInfo, vtkInformation* outInfo)
{
  SampledBox& part = this->Image.GetBox(level);
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  // The reader of a file series tells filters of the first file alone, which RequestInformation goes by.
  const bool isRectilinear = vtkRectilinearGrid::SafeDownCast(made) != nullptr;
  if (part.Plan.Lines.has_value() != isRectilinear)
  {
    return { StatusCode::Unsupported,
      part.Volume->GetPath() + ": its grid is " + (isRectilinear ? "regular" : "rectilinear") +
        ", that of the file before in this series is not; open it by itself" };
  }
  // Coarse images may have been allowed, or not any longer, since the pipeline was told.
  TellGrid(part.Plan.Grid, outInfo);
  this->Filter.ShownText = Describe(part.Plan, input);
  ISOSURFACE_RETURN_IF_ERROR(this->Image.Fill(level, MakeProgress(this->Filter)));
  FillDataSet(part, made);
  made->GetFieldData()->PassData(vtkDataObject::GetData(inInfo)->GetFieldData());
  return Status::Ok();
}

void vtkVolumeImageAlgorithm::AllowCoarse(vtkTypeBool allowed)
{
  Work& work = *this->Internals;
  if (work.IsOnlyTold && (allowed != 0) != work.CoarseAllowed)
  {
    // The pipeline is told again: what asks for the image knows its extent from there.
    this->Modified();
  }
  work.CoarseAllowed = allowed != 0;
}

void vtkVolumeImageAlgorithm::Refine()
{
  if (this->Internals->Levels.Refine(this->Internals->Source))
  {
    this->Modified();
  }
}

void vtkVolumeImageAlgorithm::PrepareRefinement(int milliseconds)
{
  ControllerCommunicator ranks(this->Controller);
  this->Refinement = this->Internals->Levels
                       .Prepare(ranks, std::max(0, milliseconds) / 1000.0, this->Internals->Source)
                       .ToValues();
}

void vtkVolumeImageAlgorithm::DropRefinement()
{
  this->Internals->Levels.DropPrepared();
}

void vtkVolumeImageAlgorithm::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Controller: " << this->Controller << "\n";
}
