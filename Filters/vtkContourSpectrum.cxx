// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkContourSpectrum.h"

#include "ChosenScalars.h"
#include "ImagePieces.h"
#include "SpectrumTable.h"
#include "VolumeInput.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"

#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMultiProcessController.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTable.h"

#include "Base/ParallelFor.h"
#include "ControllerCommunicator.h"
#include "Partition/GridSpectrum.h"
#include "Store/BlockedVolume.h"

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

// The type of the scalars of all ranks; nothing if there are none, an error if there are several.
Result<std::optional<ValueType>> FindType(
  isosurface::Communicator& ranks, const std::vector<isosurface::SampleView>& scalars)
{
  constexpr std::uint64_t none = 1000;
  std::vector<std::uint64_t> least = { none };
  std::vector<std::uint64_t> greatest = { 0 };
  for (const isosurface::SampleView& view : scalars)
  {
    const auto type = static_cast<std::uint64_t>(view.Type);
    least[0] = std::min(least[0], type);
    greatest[0] = std::max(greatest[0], type);
  }
  ranks.ReduceMinimum(least);
  ranks.ReduceMaximum(greatest);
  if (least[0] == none)
  {
    return std::optional<ValueType>();
  }
  if (least[0] != greatest[0])
  {
    return Status(StatusCode::InvalidArgument,
      "the input's images have arrays of several types; their values cannot share bins");
  }
  return std::optional<ValueType>(static_cast<ValueType>(least[0]));
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
    spectra.emplace_back(pieces.Grids[grid], type, std::move(views), threads);
  }
  return spectra;
}

} // namespace

//------------------------------------------------------------------------------
vtkContourSpectrum::vtkContourSpectrum()
  : Component(0)
  , StoreQuantity(-1)
  , NumberOfThreads(0)
  , Controller(nullptr)
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
  this->SetInputArrayToProcess(
    0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

//------------------------------------------------------------------------------
vtkContourSpectrum::~vtkContourSpectrum()
{
  this->SetController(nullptr);
}

//------------------------------------------------------------------------------
int vtkContourSpectrum::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  return 1;
}

//------------------------------------------------------------------------------
std::string vtkContourSpectrum::GetArrayName()
{
  vtkInformation* array = this->GetInputArrayInformation(0);
  return array->Has(vtkDataObject::FIELD_NAME()) ? array->Get(vtkDataObject::FIELD_NAME()) : "";
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
  inInfo->Set(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  if (vtkBlockedVolumeHandle* handle = vtkBlockedVolumeReader::BLOCKED_VOLUME()->GetHandle(inInfo))
  {
    // The spectrum is stored: no samples are needed.
    handle->BeginTaking(this);
  }
  return 1;
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
  Status status = volume ? this->ReadFromVolume(volume, ranks.GetRank(), table)
                         : this->CountInImages(ranks, inInfo, table);
  status = ranks.Agree(status);
  if (!status.IsOk())
  {
    table->Initialize();
  }
  if (!status.IsOk() && status.GetCode() != StatusCode::Aborted)
  {
    vtkErrorMacro(<< status.GetMessage());
    return 0;
  }
  return 1;
}

//------------------------------------------------------------------------------
Status vtkContourSpectrum::ReadFromVolume(
  const isosurface::VolumeInput& input, int rank, vtkTable* table)
{
  if (rank != 0)
  {
    return Status::Ok();
  }
  const auto variable = input.FindVariable(this->GetArrayName(), this->Component);
  ISOSURFACE_RETURN_IF_ERROR(variable.GetStatus());
  isosurface::BlockedVolume& volume = *input.GetVolume();
  const std::size_t step = input.GetTimeStep();
  const auto total = volume.GetSpectrum(step, *variable);
  ISOSURFACE_RETURN_IF_ERROR(total.GetStatus());
  isosurface::AddSpectrumColumns({ **total }, table);
  const std::uint32_t stores = this->StoreQuantity < 0 ? 0 : volume.GetHeader().NumberOfStores;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    const auto spectrum = volume.GetStoreSpectrum(step, *variable, store);
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    isosurface::AddQuantityColumn(**spectrum, static_cast<std::size_t>(this->StoreQuantity),
      "[" + std::to_string(store) + "]", table);
  }
  return Status::Ok();
}

//------------------------------------------------------------------------------
Status vtkContourSpectrum::CountInImages(
  isosurface::Communicator& ranks, vtkInformation* inInfo, vtkTable* table)
{
  auto findArray = [&](vtkImageData* image) -> Result<vtkDataArray*>
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* array = this->GetInputArrayToProcess(0, image, association);
    if (array && association != vtkDataObject::FIELD_ASSOCIATION_POINTS)
    {
      return Status(StatusCode::InvalidArgument,
        "the array is not a point array; convert it to point data first");
    }
    if (array && !isosurface::FindChosenComponent(array->GetNumberOfComponents(), this->Component))
    {
      return isosurface::MakeComponentError(
        this->GetArrayName(), array->GetNumberOfComponents(), this->Component);
    }
    return array;
  };
  const auto pieces =
    isosurface::CollectImagePieces(ranks, vtkDataObject::GetData(inInfo), inInfo, findArray);
  if (!pieces.IsOk())
  {
    return pieces.GetStatus().GetCode() == StatusCode::NotFound
      ? Status(StatusCode::NotFound,
          "the input has no point array \"" + this->GetArrayName() + "\" to contour")
      : pieces.GetStatus();
  }
  const int ranksOnNode = ranks.GetRanksOnNode();
  const int threads =
    this->NumberOfThreads > 0 ? this->NumberOfThreads : isosurface::ChooseThreadCount(ranksOnNode);
  std::vector<isosurface::ChosenScalars> chosen;
  std::vector<isosurface::SampleView> scalars;
  for (const isosurface::ImagePiece& piece : pieces->Pieces)
  {
    const int component = *isosurface::FindChosenComponent(
      static_cast<int>(piece.Samples.Components.size()), this->Component);
    chosen.emplace_back(piece.Samples, component, threads);
    scalars.push_back(chosen.back().GetView(piece.Samples));
  }
  const auto type = FindType(ranks, scalars);
  if (!type.IsOk() || !*type)
  {
    return type.GetStatus();
  }

  std::vector<GridSpectrum> grids = MakeGridSpectra(*pieces, scalars, **type, threads);
  // Ranges, then counts, of each grid.
  std::size_t done = 0;
  const auto progress = [&](double share)
  {
    this->UpdateProgress(
      (static_cast<double>(done) + share) / static_cast<double>(2 * grids.size()));
    return !this->CheckAbort();
  };
  KeyRange finite;
  for (GridSpectrum& grid : grids)
  {
    ISOSURFACE_RETURN_IF_ERROR(grid.FindRanges(ranks, progress));
    finite.Minimum = std::min(finite.Minimum, grid.GetFiniteRange().Minimum);
    finite.Maximum = std::max(finite.Maximum, grid.GetFiniteRange().Maximum);
    ++done;
  }
  const auto bins = isosurface::SpectrumBins::Choose(**type, finite);
  std::vector<WorkloadSpectrum> spectra;
  for (const GridSpectrum& grid : grids)
  {
    auto spectrum = grid.Count(ranks, bins, progress);
    ISOSURFACE_RETURN_IF_ERROR(spectrum.GetStatus());
    spectra.push_back(std::move(*spectrum));
    ++done;
  }
  if (ranks.GetRank() == 0)
  {
    isosurface::AddSpectrumColumns(spectra, table);
  }
  return Status::Ok();
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
