// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkContourSpectrum.h"

#include "ImagePieces.h"
#include "VolumeInput.h"

#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
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
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkContourSpectrum);
vtkCxxSetObjectMacro(vtkContourSpectrum, Controller, vtkMultiProcessController);

using namespace isosurface;

namespace
{

constexpr const char* NoSpectrum = "the spectrum cannot be made";
constexpr const char* IsovalueName = "Isovalue";
constexpr const char* Names[WorkloadSpectrum::NumberOfQuantities] = { "Triangles", "ActiveCells",
  "ActiveBlocks", "Bytes", "Area", "Volume" };
constexpr std::size_t Area = 4; // it and what follows are no whole numbers
constexpr double None = std::numeric_limits<double>::quiet_NaN();

/// Adds the sum of a quantity over spectra of equal bins, whose units may differ; nothing if one of them does
/// not know it.
void AddQuantity(const std::vector<WorkloadSpectrum>& spectra, std::size_t quantity,
  const std::string& suffix, vtkTable* table)
{
  std::vector<double> sums(spectra.front().Bins.Count);
  for (const WorkloadSpectrum& spectrum : spectra)
  {
    const std::vector<double> values = spectrum.Scale(*spectrum.GetQuantities()[quantity]);
    if (values.size() != sums.size())
    {
      return;
    }
    std::transform(values.begin(), values.end(), sums.begin(), sums.begin(), std::plus<>());
  }
  table->AddColumn(
    MakeColumn(Names[quantity] + suffix, quantity < Area ? VTK_ID_TYPE : VTK_DOUBLE, sums));
}

/// Adds the column of isovalues and one column for each quantity.
void AddSpectrumColumns(const std::vector<WorkloadSpectrum>& spectra, vtkTable* table)
{
  if (spectra.empty())
  {
    return;
  }
  table->AddColumn(MakeColumn(IsovalueName, VTK_DOUBLE, spectra.front().Bins.GetEdges()));
  for (std::size_t quantity = 0; quantity < WorkloadSpectrum::NumberOfQuantities; ++quantity)
  {
    AddQuantity(spectra, quantity, "", table);
  }
}

} // namespace

struct vtkContourSpectrum::Work
{
  vtkContourSpectrum& Filter;
  MemorySpectrum Spectra{}; ///< of images
  FieldRefinement Levels{};

  /// What decides about the way that all ranks go, and about the spectrum.
  std::vector<CommonValue> MakeCommonValues(const VolumeInput& input) const;
  /// Fills the table of the first rank with the spectra that the volume has.
  Status ReadFromVolume(const Communicator& ranks, const VolumeInput& input, vtkTable* table);
  /// Fills it with the spectra of images that all ranks have pieces of, or begins to count these beside
  /// this thread. Collective.
  Status CountInImages(Communicator& ranks, vtkInformation* inInfo, vtkTable* table);
};

vtkContourSpectrum::vtkContourSpectrum()
  : Refinement(isosurface::Refinement().ToValues())
  , Proposal(None)
  , Internals(new Work{ *this })
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
  constexpr int columns = 1 + static_cast<int>(WorkloadSpectrum::NumberOfQuantities);
  vtkTable* table = this->GetOutput();
  this->Spectrum->SetNumberOfComponents(columns);
  this->Spectrum->SetNumberOfTuples(table->GetNumberOfRows());
  this->Spectrum->Fill(None);
  for (int column = 0; column < columns; ++column)
  {
    const char* name = column == 0 ? IsovalueName : Names[column - 1];
    if (auto* values = vtkDataArray::SafeDownCast(table->GetColumnByName(name)))
    {
      this->Spectrum->CopyComponent(column, values, 0);
    }
  }
  return this->Spectrum;
}

int vtkContourSpectrum::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  // Averages of cells at the border of a piece need one cell beyond it. The spectrum of a volume is stored.
  AskVolume(
    *this, inInfo, output->GetInformationObject(0), IsCellArrayChosen(*this, inInfo) ? 1 : 0);
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
  const VolumeInput volume(inInfo);
  ReleaseVolume(*this, inInfo);
  this->Share = volume ? volume.GetHandle().GetSampleShare() : 1;

  Work& work = *this->Internals;
  this->Proposal = None;
  this->Refinement = isosurface::Refinement().ToValues();
  work.Levels.SetShown(false, 0, 0);
  ControllerCommunicator ranks(this->Controller);
  // All go one way, that of volumes or that of images.
  Status status = ranks.Agree(volume.GetStatus(), work.MakeCommonValues(volume));
  if (status.IsOk())
  {
    status = RunCollective(NoSpectrum,
      [&]
      {
        return volume
          ? Attempt(NoSpectrum, [&] { return work.ReadFromVolume(ranks, volume, table); })
          : work.CountInImages(ranks, inInfo, table);
      });
  }
  return EndExecution(this, output, AgreeOnEnd(*this, ranks, status));
}

std::vector<CommonValue> vtkContourSpectrum::Work::MakeCommonValues(const VolumeInput& input) const
{
  Fingerprint properties;
  properties.AddText(FindContouredName(this->Filter));
  for (const int number : { this->Filter.Component, this->Filter.StoreQuantity,
         this->Filter.GetInputArrayInformation(0)->Get(vtkDataObject::FIELD_ASSOCIATION()) })
  {
    properties.AddNumber(static_cast<std::uint64_t>(number));
  }
  std::vector<CommonValue> values = input.MakeCommonValues();
  values.push_back(
    { properties.Get(), "the properties of the spectrum filter are not the same on all ranks" });
  return values;
}

Status vtkContourSpectrum::Work::ReadFromVolume(
  const Communicator& ranks, const VolumeInput& input, vtkTable* table)
{
  this->Levels.DropPrepared();
  if (ranks.GetRank() != 0)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto variable,
    input.FindVariable(FindContouredName(this->Filter), this->Filter.Component));
  BlockedVolume& volume = *input.GetVolume();
  const std::size_t step = input.GetTimeStep();
  ISOSURFACE_ASSIGN_OR_RETURN(const auto total, volume.GetSpectrum(step, variable));
  this->Filter.Proposal = ProposeIsovalue(*total).value_or(None);
  AddSpectrumColumns({ *total }, table);
  const int quantity = this->Filter.StoreQuantity;
  const std::uint32_t stores = quantity < 0 ? 0 : volume.GetHeader().NumberOfStores;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto spectrum, volume.GetStoreSpectrum(step, variable, store));
    AddQuantity(
      { *spectrum }, static_cast<std::size_t>(quantity), "[" + std::to_string(store) + "]", table);
  }
  return Status::Ok();
}

Status vtkContourSpectrum::Work::CountInImages(
  Communicator& ranks, vtkInformation* inInfo, vtkTable* table)
{
  const int threads = ranks.ChooseThreads(this->Filter.NumberOfThreads);
  CellAverages averages;
  auto pieces =
    CollectContouredPieces(ranks, this->Filter, inInfo, this->Filter.Component, averages, threads);
  if (pieces.IsOk())
  {
    this->Spectra.Ask(std::move(*pieces), this->Filter.Component, threads,
      static_cast<std::uint64_t>(this->Filter.SamplesAtOnce));
  }
  if (this->Filter.ProposesAlone)
  {
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(pieces.GetStatus()));
    ISOSURFACE_ASSIGN_OR_RETURN(this->Filter.Proposal, this->Spectra.Propose(ranks));
    return Status::Ok();
  }
  const RefinementRequest wanted = { 0, false, this->Filter.SamplesAtOnce < VTK_INT_MAX, false,
    this->Filter.GetMTime() };
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto choice, this->Levels.Begin(ranks, this->Spectra, wanted, pieces.GetStatus()));
  const Status counted =
    choice.IsFinal ? this->Spectra.Count(ranks, MakeProgress(this->Filter)) : Status::Ok();
  this->Levels.SetShown(counted.IsOk(), choice.Level, 0);
  ISOSURFACE_RETURN_IF_ERROR(counted);
  const auto tell = [&]
  {
    if (!choice.IsFinal)
    {
      isosurface::Refinement begins;
      begins.Stage = RefinementStage::Working;
      this->Filter.Refinement = begins.ToValues();
    }
    else if (ranks.GetRank() == 0)
    {
      AddSpectrumColumns(this->Spectra.GetSpectra(), table);
    }
    return Status::Ok();
  };
  return Attempt(NoSpectrum, tell);
}

void vtkContourSpectrum::AdvanceCounting(int milliseconds)
{
  ControllerCommunicator ranks(this->Controller);
  this->Refinement =
    this->Internals->Levels.Prepare(ranks, milliseconds / 1000.0, this->GetMTime()).ToValues();
}

void vtkContourSpectrum::TakeCounting()
{
  if (this->Internals->Levels.Refine(this->GetMTime()))
  {
    this->Modified();
    this->Internals->Levels.KeepChange(this->GetMTime());
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
  this->Unit = FindContouredUnit(*this);
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
