// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkContourSpectrum.h"

#include "ChosenScalars.h"
#include "ContouredArray.h"
#include "ImagePieces.h"
#include "SpectrumTable.h"
#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"

#include "vtkDataArray.h"
#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTable.h"

#include "ControllerCommunicator.h"
#include "ErrorReport.h"
#include "Ground/Base/Fingerprint.h"
#include "Storage/Store/BlockedVolume.h"
#include "Surface/Spectrum/GridSpectrum.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkContourSpectrum);
vtkCxxSetObjectMacro(vtkContourSpectrum, Controller, vtkMultiProcessController);

using isosurface::GridSpectrum;
using isosurface::KeyRange;
using isosurface::Result;
using isosurface::Status;
using isosurface::StatusCode;
using isosurface::ValueType;
using isosurface::WorkloadSpectrum;

namespace
{

constexpr const char* NoSpectrum = "the spectrum cannot be made";

// The type of the scalars of all ranks; nothing if there are none, an error if there are several.
Result<std::optional<ValueType>> FindType(
  isosurface::Communicator& ranks, const std::vector<isosurface::SampleView>& scalars)
{
  constexpr std::uint64_t none = 1000;
  std::vector<std::uint64_t> minimum = { none };
  std::vector<std::uint64_t> maximum = { 0 };
  for (const isosurface::SampleView& view : scalars)
  {
    const auto type = static_cast<std::uint64_t>(view.Type);
    minimum[0] = std::min(minimum[0], type);
    maximum[0] = std::max(maximum[0], type);
  }
  ranks.ReduceMinimum(minimum);
  ranks.ReduceMaximum(maximum);
  if (minimum[0] == none)
  {
    return std::optional<ValueType>();
  }
  if (minimum[0] != maximum[0])
  {
    return Status(StatusCode::InvalidArgument,
      "the input's images have arrays of several types; their values cannot share bins");
  }
  return std::optional<ValueType>(static_cast<ValueType>(minimum[0]));
}

// scalars: those of each piece.
std::vector<GridSpectrum> MakeGridSpectra(const isosurface::ImagePieces& pieces,
  const std::vector<isosurface::SampleView>& scalars, ValueType type, int threads)
{
  std::vector<GridSpectrum> spectra;
  for (std::size_t grid = 0; grid < pieces.Grids.size(); ++grid)
  {
    std::vector<isosurface::SampleView> views;
    for (std::size_t piece = 0; piece < pieces.Pieces.size(); ++piece)
    {
      if (pieces.Pieces[piece].Grid == grid)
      {
        views.push_back(scalars[piece]);
      }
    }
    isosurface::MeasuredGrid measured{ pieces.Grids[grid] };
    if (const auto& lines = pieces.Lines[grid])
    {
      measured.Lines = &*lines;
      measured.Geometry =
        lines->MakeFrame(measured.Geometry, { { 0, 0, 0 }, measured.Geometry.GetDimensions() });
    }
    spectra.emplace_back(measured, type, std::move(views), threads);
  }
  return spectra;
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
  /// Fills it with the spectra of images that all ranks have pieces of. Collective.
  Status CountInImages(vtkInformation* inInfo) const;
  /// The spectra of the grids, in equal bins. Collective.
  Result<std::vector<WorkloadSpectrum>> Count(
    ValueType type, std::vector<GridSpectrum> grids) const;
};

//------------------------------------------------------------------------------
vtkContourSpectrum::vtkContourSpectrum()
  : Component(0)
  , StoreQuantity(-1)
  , NumberOfThreads(0)
  , Controller(nullptr)
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS_THEN_CELLS, vtkDataSetAttributes::SCALARS);
}

//------------------------------------------------------------------------------
vtkContourSpectrum::~vtkContourSpectrum()
{
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
int vtkContourSpectrum::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

//------------------------------------------------------------------------------
vtkDoubleArray* vtkContourSpectrum::GetSpectrum()
{
  isosurface::FillSpectrumTuples(this->GetOutput(), this->Spectrum);
  return this->Spectrum;
}

//------------------------------------------------------------------------------
int vtkContourSpectrum::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkInformation* outInfo = output->GetInformationObject(0);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  inInfo->Set(Pipeline::UPDATE_PIECE_NUMBER(), outInfo->Get(Pipeline::UPDATE_PIECE_NUMBER()));
  inInfo->Set(
    Pipeline::UPDATE_NUMBER_OF_PIECES(), outInfo->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  // Averages of cells at the border of a piece need one cell beyond it.
  const bool ofCells = isosurface::IsCellArrayChosen(this->GetInputArrayInformation(0), inInfo);
  inInfo->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), ofCells ? 1 : 0);
  if (vtkBlockedVolumeHandle* handle = vtkBlockedVolumeReader::BLOCKED_VOLUME()->GetHandle(inInfo))
  {
    // The spectrum is stored: no samples are needed.
    handle->BeginTaking(this);
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkContourSpectrum::SetInputArrayToProcess(
  int index, int port, int connection, int association, const char* name)
{
  if (association != vtkDataObject::FIELD_ASSOCIATION_ROWS)
  {
    this->Superclass::SetInputArrayToProcess(index, port, connection, association, name);
  }
}

//------------------------------------------------------------------------------
int vtkContourSpectrum::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkTable* table = vtkTable::GetData(output, 0);
  const isosurface::VolumeInput volume(inInfo);
  if (volume)
  {
    volume.GetHandle().EndTaking(this);
  }

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

//------------------------------------------------------------------------------
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

//------------------------------------------------------------------------------
std::string vtkContourSpectrum::Steps::GetArrayName() const
{
  vtkInformation* array = this->Filter.GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
}

//------------------------------------------------------------------------------
Status vtkContourSpectrum::Steps::ReadFromVolume(const isosurface::VolumeInput& input) const
{
  if (this->Ranks.GetRank() != 0)
  {
    return Status::Ok();
  }
  const auto variable = input.FindVariable(this->GetArrayName(), this->Filter.Component);
  ISOSURFACE_RETURN_IF_ERROR(variable.GetStatus());
  isosurface::BlockedVolume& volume = *input.GetVolume();
  const std::size_t step = input.GetTimeStep();
  const auto total = volume.GetSpectrum(step, *variable);
  ISOSURFACE_RETURN_IF_ERROR(total.GetStatus());
  isosurface::AddSpectrumColumns({ **total }, this->Table);
  const int quantity = this->Filter.StoreQuantity;
  const std::uint32_t stores = quantity < 0 ? 0 : volume.GetHeader().NumberOfStores;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    const auto spectrum = volume.GetStoreSpectrum(step, *variable, store);
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    isosurface::AddQuantityColumn(**spectrum, static_cast<std::size_t>(quantity),
      "[" + std::to_string(store) + "]", this->Table);
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
Status vtkContourSpectrum::Steps::CountInImages(vtkInformation* inInfo) const
{
  const int threads = this->Ranks.ChooseThreads(this->Filter.NumberOfThreads);
  isosurface::CellAverages averages;
  const auto pieces = isosurface::CollectContouredPieces(
    this->Ranks, inInfo,
    [this](vtkImageData* image, int& association)
    { return this->Filter.GetInputArrayToProcess(0, image, association); },
    this->GetArrayName(), this->Filter.Component, averages, threads);
  ISOSURFACE_RETURN_IF_ERROR(pieces.GetStatus());
  std::vector<isosurface::ChosenScalars> chosen;
  std::vector<isosurface::SampleView> scalars;
  const auto choose = [&]
  {
    for (const isosurface::ImagePiece& piece : pieces->Pieces)
    {
      const int component = *isosurface::FindChosenComponent(
        static_cast<int>(piece.Samples.Components.size()), this->Filter.Component);
      chosen.emplace_back(piece.Samples, component, threads);
      scalars.push_back(chosen.back().GetView(piece.Samples));
    }
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(isosurface::AttemptOnAll(this->Ranks, NoSpectrum, choose));
  const auto type = FindType(this->Ranks, scalars);
  if (!type.IsOk() || !*type)
  {
    return type.GetStatus();
  }
  std::vector<GridSpectrum> grids;
  const auto make = [&]
  {
    grids = MakeGridSpectra(*pieces, scalars, **type, threads);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(isosurface::AttemptOnAll(this->Ranks, NoSpectrum, make));
  const auto spectra = this->Count(**type, std::move(grids));
  ISOSURFACE_RETURN_IF_ERROR(spectra.GetStatus());
  const auto fill = [&]
  {
    if (this->Ranks.GetRank() == 0)
    {
      isosurface::AddSpectrumColumns(*spectra, this->Table);
    }
    return Status::Ok();
  };
  return isosurface::Attempt(NoSpectrum, fill);
}

//------------------------------------------------------------------------------
Result<std::vector<WorkloadSpectrum>> vtkContourSpectrum::Steps::Count(
  ValueType type, std::vector<GridSpectrum> grids) const
{
  // Ranges, then counts, of each grid.
  double begin = 0;
  const double part = 0.5 / static_cast<double>(grids.size());
  const auto makeProgress = [&]
  {
    begin += part;
    return isosurface::MakeProgress(this->Filter, begin - part, begin);
  };
  KeyRange finite;
  for (GridSpectrum& grid : grids)
  {
    ISOSURFACE_RETURN_IF_ERROR(grid.FindRanges(this->Ranks, makeProgress()));
    finite.Add(grid.GetFiniteRange());
  }
  const auto bins = isosurface::SpectrumBins::Choose(type, finite);
  std::vector<WorkloadSpectrum> spectra;
  for (const GridSpectrum& grid : grids)
  {
    auto spectrum = grid.Count(this->Ranks, bins, makeProgress());
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    spectra.push_back(std::move(*spectrum));
  }
  return spectra;
}

//------------------------------------------------------------------------------
void vtkContourSpectrum::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Component: " << this->Component << "\n";
  os << indent << "StoreQuantity: " << this->StoreQuantity << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Controller: " << this->Controller << "\n";
}
