// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
#include "vtkContourSpectrum.h"

#include "ChosenScalars.h"
#include "ImagePieces.h"
#include "SpectrumTable.h"
#include "vtkBlockedVolumeHandle.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkInformationBlockedVolumeKey.h"
#include "vtkInformationStabbingRequestKey.h"
#include "vtkStabbingRequest.h"

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
  if (vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(inInfo))
  {
    // No samples are needed.
    vtkNew<vtkStabbingRequest> request;
    request->SetHandleOnly(true);
    vtkBlockedVolumeReader::STABBING_REQUEST()->Set(inInfo, request);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkContourSpectrum::RequestData(
  vtkInformation*, vtkInformationVector** input, vtkInformationVector* output)
{
  vtkInformation* inInfo = input[0]->GetInformationObject(0);
  vtkTable* table = vtkTable::GetData(output, 0);
  vtkBlockedVolumeReader::STABBING_REQUEST()->Withdraw(inInfo);

  isosurface::ControllerCommunicator ranks(this->Controller);
  Status status = vtkBlockedVolumeReader::BLOCKED_VOLUME()->Has(inInfo)
    ? this->ReadFromVolume(inInfo, ranks.GetRank(), table)
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
Status vtkContourSpectrum::ReadFromVolume(vtkInformation* inInfo, int rank, vtkTable* table)
{
  if (rank != 0)
  {
    return Status::Ok();
  }
  auto* handle =
    static_cast<vtkBlockedVolumeHandle*>(vtkBlockedVolumeReader::BLOCKED_VOLUME()->Get(inInfo));
  isosurface::BlockedVolume& volume = *handle->GetVolume();
  const std::size_t step = handle->FindTimeStep(inInfo);
  const std::string name = this->GetArrayName();
  // Without a choice: the first array, which the reader makes the active scalars.
  const auto array =
    name.empty() ? std::optional<std::size_t>(0) : volume.GetHeader().FindArray(name);
  if (!array)
  {
    return Status(
      StatusCode::NotFound, volume.GetPath() + ": has no array \"" + name + "\" to contour");
  }
  const auto variable = volume.GetVariables().FindChoice(*array, this->Component);
  if (!variable)
  {
    const isosurface::ArrayDescription& description = volume.GetHeader().Arrays[*array];
    return isosurface::MakeComponentError(
      description.Name, description.Components, this->Component);
  }
  const auto total = volume.GetSpectrum(step, *variable);
  if (!total.IsOk())
  {
    return total.GetStatus();
  }
  isosurface::AddSpectrumColumns({ **total }, table);
  const std::uint32_t stores = this->StoreQuantity < 0 ? 0 : volume.GetHeader().NumberOfStores;
  for (std::uint32_t store = 0; store < stores; ++store)
  {
    const auto spectrum = volume.GetStoreSpectrum(step, *variable, store);
    if (!spectrum.IsOk())
    {
      return spectrum.GetStatus();
    }
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
    if (!spectrum.IsOk())
    {
      return spectrum.GetStatus();
    }
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
