// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkContourSpectrum.h"

#include "ImagePieces.h"
#include "VolumeInput.h"

#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"
#include "vtkTable.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "RangedArray.h"
#include "Ranks/Query/FieldRefinement.h"
#include "Ranks/Query/MemorySpectrum.h"
#include "Storage/Spectrum/IsovalueProposal.h"
#include "Storage/Spectrum/WorkloadSpectrum.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkContourSpectrum);
vtkCxxSetObjectMacro(vtkContourSpectrum, Controller, vtkMultiProcessController);

using isosurface::MemorySpectrum;
using isosurface::SpectrumBins;
using isosurface::Status;
using isosurface::StatusCode;
using isosurface::WorkloadSpectrum;

namespace
{

constexpr const char* NoSpectrum = "the spectrum cannot be made";
constexpr const char* IsovalueName = "Isovalue";
constexpr const char* Names[WorkloadSpectrum::NumberOfQuantities] = { "Triangles", "ActiveCells",
  "ActiveBlocks", "Bytes", "Area", "Volume" };
constexpr std::size_t Area = 4;
constexpr std::size_t Volume = 5;

/// The sum of a quantity over spectra, areas and volumes in the units of the world; nothing if one of them does
/// not know it.
void AddQuantity(const std::vector<const WorkloadSpectrum*>& spectra, std::size_t quantity,
  const std::string& suffix, vtkTable* table)
{
  static_assert(Volume + 1 == WorkloadSpectrum::NumberOfQuantities, "Area and Volume are the last");
  std::vector<double> sums(spectra.front()->Bins.Count);
  for (const WorkloadSpectrum* spectrum : spectra)
  {
    const WorkloadSpectrum::Counts& counts = *spectrum->GetQuantities()[quantity];
    if (counts.size() != sums.size())
    {
      return;
    }
    const double unit = quantity == Area ? spectrum->AreaUnit
      : quantity == Volume               ? spectrum->VolumeUnit
                                         : 1;
    std::transform(counts.begin(), counts.end(), sums.begin(), sums.begin(),
      [unit](std::uint64_t count, double sum) { return sum + static_cast<double>(count) * unit; });
  }
  const auto column = vtkSmartPointer<vtkDataArray>::Take(
    vtkDataArray::CreateDataArray(quantity < Area ? VTK_ID_TYPE : VTK_DOUBLE));
  column->SetName((Names[quantity] + suffix).c_str());
  isosurface::AllocateTuples(column, static_cast<vtkIdType>(sums.size()));
  for (std::size_t bin = 0; bin < sums.size(); ++bin)
  {
    column->SetComponent(static_cast<vtkIdType>(bin), 0, sums[bin]);
  }
  table->AddColumn(column);
}

/// Adds the column of isovalues and one column for each known quantity: the sum of the spectra,
/// which have equal bins (their units may differ).
void AddSpectrumColumns(const std::vector<WorkloadSpectrum>& spectra, vtkTable* table)
{
  if (spectra.empty())
  {
    return;
  }
  const SpectrumBins& bins = spectra.front().Bins;
  vtkNew<vtkDoubleArray> isovalues;
  isovalues->SetName(IsovalueName);
  isosurface::AllocateTuples(isovalues, bins.Count);
  for (std::uint32_t bin = 0; bin < bins.Count; ++bin)
  {
    isovalues->SetValue(bin, bins.GetEdge(bin));
  }
  table->AddColumn(isovalues);
  std::vector<const WorkloadSpectrum*> all;
  for (const WorkloadSpectrum& spectrum : spectra)
  {
    all.push_back(&spectrum);
  }
  for (std::size_t quantity = 0; quantity < WorkloadSpectrum::NumberOfQuantities; ++quantity)
  {
    AddQuantity(all, quantity, "", table);
  }
}

/// Fills an array with the table's rows as tuples: the isovalue, then each quantity, NaN where the
/// table has no column of it. Columns of stores are left out.
void FillSpectrumTuples(vtkTable* table, vtkDoubleArray* tuples)
{
  constexpr int columns = 1 + static_cast<int>(WorkloadSpectrum::NumberOfQuantities);
  tuples->SetNumberOfComponents(columns);
  tuples->SetNumberOfTuples(table->GetNumberOfRows());
  tuples->Fill(std::numeric_limits<double>::quiet_NaN());
  for (int column = 0; column < columns; ++column)
  {
    const char* name = column == 0 ? IsovalueName : Names[column - 1];
    if (auto* values = vtkDataArray::SafeDownCast(table->GetColumnByName(name)))
    {
      tuples->CopyComponent(column, values, 0);
    }
  }
}

} // namespace

struct vtkContourSpectrum::Steps
{
  vtkContourSpectrum& Filter;
  isosurface::Communicator& Ranks;
  vtkTable* Table;

  /// What decides about the way that all ranks go, and about the spectrum.
  std::vector<isosurface::CommonValue> MakeCommonValues(const isosurface::VolumeInput& input) const;
  std::string GetArrayName() const;
  /// Fills the table of the first rank with the spectra that the volume has.
  Status ReadFromVolume(const isosurface::VolumeInput& input) const;
  /// Fills it with the spectra of images that all ranks have pieces of, or begins to count these beside
  /// this thread. Collective.
  Status CountInImages(vtkInformation* inInfo) const;
};

/// The spectra of images.
struct vtkContourSpectrum::OfImages
{
  MemorySpectrum Spectra;
  isosurface::FieldRefinement Levels;
};

vtkContourSpectrum::vtkContourSpectrum()
  : Refinement(isosurface::Refinement().ToValues())
  , Proposal(std::numeric_limits<double>::quiet_NaN())
  , Images(std::make_unique<OfImages>())
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS_THEN_CELLS, vtkDataSetAttributes::SCALARS);
}

vtkContourSpectrum::~vtkContourSpectrum()
{
  this->SetController(nullptr);
}

int vtkContourSpectrum::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

vtkDoubleArray* vtkContourSpectrum::GetSpectrum()
{
  FillSpectrumTuples(this->GetOutput(), this->Spectrum);
  return this->Spectrum;
}

int vtkContourSpectrum::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  // Averages of cells at the border of a piece need one cell beyond it. The spectrum of a volume is stored.
  const bool ofCells = isosurface::IsCellArrayChosen(this->GetInputArrayInformation(0), inInfo);
  isosurface::AskVolume(*this, inInfo, output->GetInformationObject(0), ofCells ? 1 : 0);
  return 1;
}

void vtkContourSpectrum::SetInputArrayToProcess(
  int index, int port, int connection, int association, const char* name)
{
  if (association != vtkDataObject::FIELD_ASSOCIATION_ROWS)
  {
    this->Superclass::SetInputArrayToProcess(index, port, connection, association, name);
  }
}

int vtkContourSpectrum::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkTable* table = vtkTable::GetData(output, 0);
  const isosurface::VolumeInput volume(inInfo);
  isosurface::ReleaseVolume(*this, inInfo);

  this->Proposal = std::numeric_limits<double>::quiet_NaN();
  this->Refinement = isosurface::Refinement().ToValues();
  this->Images->Levels.SetShown(false, 0, 0);
  isosurface::ControllerCommunicator ranks(this->Controller);
  const Steps steps = { *this, ranks, table };
  // All go one way, that of volumes or that of images.
  Status status = ranks.Agree(volume.GetStatus(), steps.MakeCommonValues(volume));
  if (status.IsOk())
  {
    status = isosurface::RunCollective(NoSpectrum,
      [&]
      {
        return volume
          ? isosurface::Attempt(NoSpectrum, [&] { return steps.ReadFromVolume(volume); })
          : steps.CountInImages(inInfo);
      });
  }
  if (isosurface::IsAborted(*this))
  {
    // Outweighs an error, such as that of a reader that was stopped before it had a volume.
    status = Status(StatusCode::Aborted, "the spectrum was aborted");
  }
  status = ranks.Agree(status);
  if (status.IsOk())
  {
    return 1;
  }
  table->Initialize();
  return isosurface::EndExecution(this, output, status);
}

std::vector<isosurface::CommonValue> vtkContourSpectrum::Steps::MakeCommonValues(
  const isosurface::VolumeInput& input) const
{
  isosurface::Fingerprint properties;
  properties.AddText(this->GetArrayName());
  properties.AddNumber(static_cast<std::uint64_t>(
    this->Filter.GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_ASSOCIATION())));
  properties.AddNumber(static_cast<std::uint64_t>(this->Filter.Component));
  properties.AddNumber(static_cast<std::uint64_t>(this->Filter.StoreQuantity));
  std::vector<isosurface::CommonValue> values = input.MakeCommonValues();
  values.push_back(
    { properties.Get(), "the properties of the spectrum filter are not the same on all ranks" });
  return values;
}

std::string vtkContourSpectrum::Steps::GetArrayName() const
{
  vtkInformation* array = this->Filter.GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
}

Status vtkContourSpectrum::Steps::ReadFromVolume(const isosurface::VolumeInput& input) const
{
  this->Filter.Images->Levels.DropPrepared();
  if (this->Ranks.GetRank() != 0)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto variable, input.FindVariable(this->GetArrayName(), this->Filter.Component));
  isosurface::BlockedVolume& volume = *input.GetVolume();
  const std::size_t step = input.GetTimeStep();
  ISOSURFACE_ASSIGN_OR_RETURN(const auto total, volume.GetSpectrum(step, variable));
  this->Filter.Proposal =
    isosurface::ProposeIsovalue(*total).value_or(std::numeric_limits<double>::quiet_NaN());
  AddSpectrumColumns({ *total }, this->Table);
  const int quantity = this->Filter.StoreQuantity;
  const std::uint32_t stores = quantity < 0 ? 0 : volume.GetHeader().NumberOfStores;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto spectrum, volume.GetStoreSpectrum(step, variable, store));
    AddQuantity({ spectrum.get() }, static_cast<std::size_t>(quantity),
      "[" + std::to_string(store) + "]", this->Table);
  }
  return Status::Ok();
}

Status vtkContourSpectrum::Steps::CountInImages(vtkInformation* inInfo) const
{
  const int threads = this->Ranks.ChooseThreads(this->Filter.NumberOfThreads);
  isosurface::CellAverages averages;
  auto pieces = isosurface::CollectContouredPieces(
    this->Ranks, inInfo,
    [this](vtkImageData* image, int& association)
    { return this->Filter.GetInputArrayToProcess(0, image, association); },
    this->GetArrayName(), this->Filter.Component, averages, threads);
  MemorySpectrum& spectra = this->Filter.Images->Spectra;
  isosurface::FieldRefinement& levels = this->Filter.Images->Levels;
  if (pieces.IsOk())
  {
    spectra.Ask(std::move(*pieces), this->Filter.Component, threads,
      static_cast<std::uint64_t>(this->Filter.SamplesAtOnce));
  }
  if (this->Filter.ProposesAlone)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Ranks.Agree(pieces.GetStatus()));
    ISOSURFACE_ASSIGN_OR_RETURN(this->Filter.Proposal, spectra.Propose(this->Ranks));
    return Status::Ok();
  }
  isosurface::RefinementRequest wanted;
  wanted.MayBeCoarse = this->Filter.SamplesAtOnce < VTK_INT_MAX;
  wanted.Change = this->Filter.GetMTime();
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto choice, levels.Begin(this->Ranks, spectra, wanted, pieces.GetStatus()));
  Status status;
  if (choice.IsFinal)
  {
    status = spectra.Count(this->Ranks, isosurface::MakeProgress(this->Filter));
  }
  levels.SetShown(status.IsOk(), choice.Level, 0);
  if (!choice.IsFinal)
  {
    isosurface::Refinement begins;
    begins.Stage = isosurface::RefinementStage::Working;
    this->Filter.Refinement = begins.ToValues();
  }
  else if (status.IsOk() && this->Ranks.GetRank() == 0)
  {
    status = isosurface::Attempt(NoSpectrum,
      [&]
      {
        AddSpectrumColumns(spectra.GetSpectra(), this->Table);
        return Status::Ok();
      });
  }
  return status;
}

void vtkContourSpectrum::CountBeside(int samplesAtOnce)
{
  this->SamplesAtOnce = samplesAtOnce;
}

void vtkContourSpectrum::AdvanceCounting(int milliseconds)
{
  isosurface::ControllerCommunicator ranks(this->Controller);
  this->Refinement =
    this->Images->Levels.Prepare(ranks, milliseconds / 1000.0, this->GetMTime()).ToValues();
}

void vtkContourSpectrum::TakeCounting()
{
  if (this->Images->Levels.Refine(this->GetMTime()))
  {
    this->Modified();
    this->Images->Levels.KeepChange(this->GetMTime());
  }
}

void vtkContourSpectrum::ProposeAlone(vtkTypeBool alone)
{
  if (this->ProposesAlone != (alone != 0))
  {
    this->ProposesAlone = alone != 0;
    this->Modified();
  }
}

const char* vtkContourSpectrum::GetUnit()
{
  this->Unit = isosurface::FindContouredUnit(
    this->GetNumberOfInputConnections(0) > 0 ? this->GetInputDataObject(0, 0) : nullptr,
    [this](vtkDataSet* data) { return this->GetInputArrayToProcess(0, data); });
  return this->Unit.c_str();
}

void vtkContourSpectrum::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Component: " << this->Component << "\n";
  os << indent << "StoreQuantity: " << this->StoreQuantity << "\n";
  os << indent << "Proposal: " << this->Proposal << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
