// SPDX-License-Identifier: BSD-3-Clause
#include "SampledImage.h"

#include "BlockImage.h"
#include "SurfaceFieldData.h"
#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"

#include "vtkAlgorithm.h"
#include "vtkDataSet.h"
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
#include "Ground/Base/CollectiveTask.h"
#include "Ground/Base/Fingerprint.h"
#include "RangedArray.h"
#include "RectilinearGrids.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <utility>

namespace isosurface
{
namespace
{

using Pipeline = vtkStreamingDemandDrivenPipeline;

constexpr const char* NotRead = "the samples cannot be read";

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

// Whether two plans of one plane or box have the same vertices.
bool IsSame(const ImagePlan& a, const ImagePlan& b)
{
  return a.Level == b.Level && a.Grid.Extent == b.Grid.Extent;
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
  for (std::size_t point = 0; point < isInside.size(); ++point)
  {
    ghosts->SetValue(
      static_cast<vtkIdType>(point), isInside[point] != 0 ? 0 : vtkDataSetAttributes::HIDDENPOINT);
  }
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

//------------------------------------------------------------------------------
/// A part of an image, on its way. Fill, which may run beside the main thread, leaves VTK alone.
struct SampledImage::Part
{
  ImagePlan Plan;
  VertexBox Box;
  std::uint64_t Source = 0; ///< of the image (SumSource)
  std::shared_ptr<BlockedVolume> Volume;
  std::size_t TimeStep = 0;
  std::vector<std::size_t> Arrays;
  int Threads = 1;
  std::shared_ptr<const LevelSamples> Samples; ///< if null, Fill opens them

  vtkSmartPointer<vtkImageData> Image;
  std::vector<vtkSmartPointer<vtkDataArray>> Values; ///< of Arrays
  std::vector<std::uint8_t> IsInside;

  void Allocate();
  Status Fill(const Progress& progress);
  void Finish(vtkInformation* outInfo);
  /// Whether it is the part that another one is to be.
  bool IsOf(const Part& other) const;
};

void SampledImage::Part::Allocate()
{
  this->Values.clear(); // of a beginning that failed on another rank
  if (this->Box.IsEmpty())
  {
    return;
  }
  this->Image = MakeImage(this->Plan.Grid, this->Box);
  this->IsInside.assign(
    this->Plan.HasOutside ? static_cast<std::size_t>(this->Box.GetNumberOfVertices()) : 0, 1);
  for (const std::size_t array : this->Arrays)
  {
    const ArrayDescription& description = this->Volume->GetHeader().Arrays[array];
    this->Values.push_back(AddArray(this->Image, description));
    for (int component = 0; this->Plan.HasOutside && component < description.Components;
         ++component)
    {
      FillWithMinimum(*this->Volume, this->TimeStep, array, component, this->Values.back());
    }
  }
}

Status SampledImage::Part::Fill(const Progress& progress)
{
  if (!this->Samples)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      this->Samples, LevelSamples::Open(this->Volume, this->TimeStep, this->Plan.Level));
  }
  if (this->Box.IsEmpty())
  {
    return Status::Ok();
  }
  QueryStatistics statistics;
  const int all = CountComponents(*this->Volume, this->Arrays);
  int done = 0;
  for (std::size_t number = 0; number < this->Arrays.size(); ++number)
  {
    const std::size_t array = this->Arrays[number];
    const int components = this->Volume->GetHeader().Arrays[array].Components;
    for (int component = 0; component < components; ++component, ++done)
    {
      ISOSURFACE_RETURN_IF_ERROR(
        this->Plan.Fill(*this->Samples, *this->Volume->GetVariables().Find(array, component),
          this->Box, this->Threads, this->Values[number]->GetVoidPointer(component), components,
          this->IsInside.empty() ? nullptr : this->IsInside.data(), statistics,
          [&](double part) { return !progress || progress((done + part) / all); }));
    }
  }
  return Status::Ok();
}

void SampledImage::Part::Finish(vtkInformation* outInfo)
{
  if (this->Box.IsEmpty())
  {
    return;
  }
  for (std::size_t number = 0; number < this->Arrays.size(); ++number)
  {
    StoreVolumeRanges(*this->Volume, this->TimeStep, this->Arrays[number], this->Values[number]);
  }
  HideOutside(this->Image, this->IsInside);
  AddToFieldData(this->Image, "Level", this->Plan.Level);
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  if (this->Plan.Lines)
  {
    made->ShallowCopy(MakeRectilinearGrid(this->Image, this->Plan.Lines->Cut(this->Box)));
  }
  else
  {
    made->ShallowCopy(this->Image);
  }
  this->Values.clear();
  this->Image = nullptr;
}

bool SampledImage::Part::IsOf(const Part& other) const
{
  return this->Source == other.Source && this->Box.Low == other.Box.Low &&
    this->Box.High == other.Box.High;
}

//------------------------------------------------------------------------------
/// This rank's part of an image, and of a coarse one that is there sooner, as a field of two levels.
class SampledImage::Parts : public Field
{
public:
  /// `coarse` is null if the exact image is there as soon.
  void Ask(std::unique_ptr<Part> exact, std::unique_ptr<Part> coarse);
  Part& GetPart(int level)
  {
    return this->Coarse && level > this->Exact->Plan.Level ? *this->Coarse : *this->Exact;
  }
  /// Fills the part of a level, or waits for the thread that does.
  Status Fill(int level, const Progress& progress);

  std::string GetName() const override { return this->Exact ? this->Exact->Volume->GetPath() : ""; }
  bool IsSame() const override { return true; } // else the caller names another change
  int FindFinestLevel(int) const override { return this->Exact ? this->Exact->Plan.Level : 0; }
  Result<First> FindFirst(Communicator&, int finest) override
  {
    return First{ this->Coarse ? this->Coarse->Plan.Level : finest, true };
  }
  Status Prepare(Communicator&, int) override;
  CollectiveTask* GetPrepared() override { return this->Work.get(); }
  void DropPrepared() override;

private:
  std::unique_ptr<Part> Exact;
  std::unique_ptr<Part> Coarse;
  std::unique_ptr<CollectiveTask> Work; ///< the last member: it fills Exact, by this rank alone
};

void SampledImage::Parts::Ask(std::unique_ptr<Part> exact, std::unique_ptr<Part> coarse)
{
  if (!this->Exact || !this->Exact->IsOf(*exact))
  {
    this->DropPrepared();
    this->Exact = std::move(exact);
  }
  this->Coarse = std::move(coarse);
}

Status SampledImage::Parts::Prepare(Communicator&, int)
{
  return Attempt(NotRead,
    [this]
    {
      this->DropPrepared();
      this->Exact->Allocate();
      SerialCommunicator alone;
      this->Work = std::make_unique<CollectiveTask>(alone, NotRead,
        [part = this->Exact.get()](Communicator&, const Progress& progress)
        { return part->Fill(progress); });
      return Status::Ok();
    });
}

void SampledImage::Parts::DropPrepared()
{
  this->Work.reset();
  if (this->Exact)
  {
    this->Exact->Values.clear();
    this->Exact->Image = nullptr;
  }
}

Status SampledImage::Parts::Fill(int level, const Progress& progress)
{
  Part& part = this->GetPart(level);
  if (&part == this->Exact.get() && this->Work)
  {
    SerialCommunicator alone;
    const std::unique_ptr<CollectiveTask> work = std::move(this->Work);
    return work->Finish(alone, progress);
  }
  part.Allocate();
  return part.Fill(progress);
}

//------------------------------------------------------------------------------
SampledImage::SampledImage(vtkAlgorithm& filter)
  : Filter(filter)
  , Image(std::make_unique<Parts>())
  , Levels([] { return std::uint64_t{ 0 }; })
{
}

SampledImage::~SampledImage() = default;

void SampledImage::AllowCoarse(bool isAllowed)
{
  if (this->IsOnlyTold && isAllowed != this->CoarseAllowed)
  {
    this->Filter.Modified();
  }
  this->CoarseAllowed = isAllowed;
}

int SampledImage::TellImage(vtkInformation* inInfo, vtkInformationVector* output)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  const VolumeInput input(inInfo);
  const ControllerCommunicator ranks(this->GetController());
  // The extent of an image cannot be told later.
  if (input && input.GetHandle().IsUntried() &&
    !this->Filter.GetInputAlgorithm(0, 0)->UpdatePiece(ranks.GetRank(), ranks.GetSize(), 0))
  {
    // On all ranks. To go on would execute the input again, which would tell its error twice.
    vtkDataObject::GetData(outInfo)->Initialize();
    MarkFailure(output);
    outInfo->Remove(vtkDemandDrivenPipeline::DATA_NOT_GENERATED()); // nothing is being generated
    return 0;
  }
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  ImagePlan image;
  image.Grid.Extent = { 0, -1, 0, -1, 0, -1 };
  this->Text.clear();
  this->IsOnlyTold = false;
  if (input.GetVolume())
  {
    const bool isNew = this->SumSource(input) != this->Source;
    this->IsOnlyTold = isNew;
    const auto make = [&]() -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto planned,
        this->Plan(*input.GetVolume(), input.GetHandle().GetArrays(),
          isNew ? this->CoarseAllowed : !this->Levels.IsNextFinest()));
      this->Text = Describe(planned, input);
      image = std::move(planned);
      return Status::Ok();
    };
    // RequestData tells why not.
    static_cast<void>(Attempt("", make));
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

bool SampledImage::Make(
  vtkInformation* request, vtkInformation* inInfo, vtkInformationVector* output, int& result)
{
  vtkInformation* outInfo = output->GetInformationObject(0);
  vtkDataObject::GetData(outInfo)->Initialize();
  const VolumeInput input(inInfo);
  ControllerCommunicator ranks(this->GetController());
  this->Source = this->SumSource(input);
  this->IsOnlyTold = false;
  int level = 0;
  Status status = AgreeOnVolume(this->Filter, ranks, input, this->SumProperties());
  if (status.IsOk())
  {
    const int threads = ranks.ChooseThreads(0);
    RefinementRequest wanted;
    wanted.MayBeCoarse = this->CoarseAllowed;
    wanted.Change = this->Source;
    const auto choice =
      this->Levels.Begin(ranks, *this->Image, wanted, this->Ask(input, request, output, threads));
    status = choice.GetStatus();
    level = choice.IsOk() ? choice->Level : 0;
  }
  if (status.IsOk())
  {
    status = ReadVolume(
      this->Filter, ranks, input, [&] { return this->FillOutput(input, level, inInfo, outInfo); });
  }
  this->Levels.SetShown(status.IsOk(), level, 0);
  this->Final = !status.IsOk() || this->Levels.IsFinal();
  if (!status.IsOk())
  {
    this->Levels.KeepChange(this->Source = 0); // begins anew
    this->Text.clear();
    vtkDataObject::GetData(outInfo)->Initialize();
  }
  result = EndExecution(&this->Filter, output, status);
  return status.IsOk();
}

Status SampledImage::Ask(
  const VolumeInput& input, vtkInformation* request, vtkInformationVector* output, int threads)
{
  const auto ask = [&]() -> Status
  {
    const BlockedVolume& volume = *input.GetVolume();
    const std::vector<std::size_t> arrays = input.GetHandle().GetArrays();
    const auto describe = [&](const ImagePlan& image)
    { return this->DescribePart(input, FindPart(image, request, output), threads, image); };
    ISOSURFACE_ASSIGN_OR_RETURN(const auto exact, this->Plan(volume, arrays, false));
    ISOSURFACE_ASSIGN_OR_RETURN(const auto coarse, this->Plan(volume, arrays, true));
    this->Image->Ask(describe(exact), IsSame(exact, coarse) ? nullptr : describe(coarse));
    return Status::Ok();
  };
  return Attempt(NotRead, ask);
}

std::uint64_t SampledImage::SumSource(const VolumeInput& input) const
{
  Fingerprint source;
  source.AddNumber(this->SumProperties());
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

std::unique_ptr<SampledImage::Part> SampledImage::DescribePart(
  const VolumeInput& input, const VertexBox& box, int threads, const ImagePlan& plan) const
{
  auto part = std::make_unique<Part>();
  part->Plan = plan;
  part->Box = box;
  part->Source = this->Source;
  part->Volume = input.GetVolume();
  part->TimeStep = input.GetTimeStep();
  part->Arrays = input.GetHandle().GetArrays();
  part->Threads = threads;
  const auto known = this->Samples.find(plan.Level);
  if (known != this->Samples.end() && &known->second->GetVolume() == part->Volume.get() &&
    known->second->GetTimeStep() == part->TimeStep)
  {
    part->Samples = known->second;
  }
  return part;
}

void SampledImage::KeepSamples(const std::shared_ptr<const LevelSamples>& samples)
{
  const auto isOther = [&](const auto& known)
  {
    return &known.second->GetVolume() != &samples->GetVolume() ||
      known.second->GetTimeStep() != samples->GetTimeStep();
  };
  if (std::any_of(this->Samples.begin(), this->Samples.end(), isOther))
  {
    this->Samples.clear();
  }
  this->Samples[samples->GetLevel()] = samples;
}

Status SampledImage::FillOutput(
  const VolumeInput& input, int level, vtkInformation* inInfo, vtkInformation* outInfo)
{
  Part& part = this->Image->GetPart(level);
  vtkDataObject* made = vtkDataObject::GetData(outInfo);
  // The reader of a file series tells filters of the first file alone, which TellImage goes by.
  const bool isRectilinear = vtkRectilinearGrid::SafeDownCast(made) != nullptr;
  if (part.Plan.Lines.has_value() != isRectilinear)
  {
    return { StatusCode::Unsupported,
      part.Volume->GetPath() + ": its grid is " + (isRectilinear ? "regular" : "rectilinear") +
        ", that of the file before in this series is not; open it by itself" };
  }
  // Coarse images may have been allowed, or not any longer, since the pipeline was told.
  TellGrid(part.Plan.Grid, outInfo);
  this->Text = Describe(part.Plan, input);
  ISOSURFACE_RETURN_IF_ERROR(this->Image->Fill(level, MakeProgress(this->Filter)));
  this->KeepSamples(part.Samples);
  part.Finish(outInfo);
  made->GetFieldData()->PassData(vtkDataObject::GetData(inInfo)->GetFieldData());
  return Status::Ok();
}

//------------------------------------------------------------------------------
// Refinement

bool SampledImage::Refine()
{
  return this->Levels.Refine(this->Source);
}

void SampledImage::DropRefinement()
{
  this->Levels.DropPrepared();
}

Refinement SampledImage::PrepareRefinement(double seconds)
{
  ControllerCommunicator ranks(this->GetController());
  return this->Levels.Prepare(ranks, seconds, this->Source);
}

} // namespace isosurface
