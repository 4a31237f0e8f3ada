// SPDX-License-Identifier: BSD-3-Clause
#include "CollectContourBlocks.h"

#include "ContourExecution.h"
#include "ErrorReport.h"
#include "vtkStabbingContour.h"

#include "vtkAlgorithmOutput.h"
#include "vtkDataObject.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Coding/BlockCoding/EdgeIndexProfile.h"
#include "Ranks/Query/LevelChoice.h"
#include "Ranks/Sharing/StoreRecovery.h"
#include "Storage/Store/BlockedVolume.h"

#include <algorithm>
#include <utility>

namespace isosurface
{

Status CollectContourBlocks(vtkStabbingContour* contour, int piece, int pieces,
  const std::optional<double>& time, ContourBlocks& blocks)
{
  return ContourExecution::Of(*contour).CollectBlocks(piece, pieces, time, blocks);
}

Status RunWithContourBlocks(
  vtkAlgorithm* reader, Communicator& ranks, const std::function<Status(ContourBlocks&)>& step)
{
  ContourBlocks blocks;
  std::string warning;
  const Status status = RunWithReplicas(
    ranks, [&] { return blocks.Volume.get(); }, warning,
    [&]
    {
      blocks = ContourBlocks();
      return step(blocks);
    });
  ReportWarning(reader, ranks, status, warning);
  return status;
}

int ChooseProfile(vtkObject* consumer, int number)
{
  const EdgeIndexProfile nearest = FindNearestProfile(number);
  if (number != static_cast<int>(nearest))
  {
    vtkWarningWithObjectMacro(consumer,
      "There is no profile " << number << " (1.0 had fast, 1, and compact, 2): "
                             << (nearest == EdgeIndexProfile::Small ? "small" : "working")
                             << " is used.");
  }
  return static_cast<int>(nearest);
}

Status ContourExecution::CollectBlocks(
  int piece, int pieces, const std::optional<double>& time, ContourBlocks& blocks)
{
  ControllerCommunicator ranks = this->GetRanks();
  blocks.Isovalues = this->MakeRequest().Isovalues;
  blocks.Precision = this->MakeRequest().Precision;
  blocks.ClosedSides = this->MakeRequest().ClosedSides;
  if (this->Contour.FindsIslands())
  {
    blocks.Islands = this->MakeIslandRequest(0);
  }
  // The input may be executed by all ranks together.
  const bool hasInput = this->Contour.GetNumberOfInputConnections(0) > 0;
  ISOSURFACE_RETURN_IF_ERROR(
    ranks.Agree(hasInput ? Status::Ok()
                         : Status(StatusCode::InvalidArgument, "the contour filter has no input")));
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(this->UpdateInput(piece, pieces, time)));
  vtkInformation* inInfo = this->Contour.GetInputInformation();
  const VolumeInput input(inInfo);
  SurfaceQuery query;
  query.Rank = piece;
  query.Ranks = pieces;
  ContourOutcome outcome;
  ISOSURFACE_RETURN_IF_ERROR(this->AgreeOnQuery(input, ranks, query, outcome, &blocks));
  return input ? this->CollectBlocksOfVolume(ranks, input, std::move(query), outcome, blocks)
               : this->CollectBlocksOfImages(ranks, inInfo, outcome, blocks);
}

Status ContourExecution::UpdateInput(int piece, int pieces, const std::optional<double>& time)
{
  vtkAlgorithmOutput* connection = this->Contour.GetInputConnection(0, 0);
  this->Contour.UpdateInformation();
  vtkInformation* inInfo = this->Contour.GetInputInformation();
  this->Contour.AskInput(inInfo, piece, pieces);
  if (time)
  {
    inInfo->Set(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), *time);
  }
  const bool isUpdated =
    connection->GetProducer()->GetExecutive()->Update(connection->GetIndex()) != 0;
  ReleaseVolume(this->Contour, inInfo);
  if (!isUpdated)
  {
    return { StatusCode::InvalidArgument, "the input of the contour filter failed" };
  }
  return IsInputAborted(inInfo)
    ? Status(StatusCode::Aborted, "the input of the contour filter was aborted")
    : Status::Ok();
}

Status ContourExecution::CollectBlocksOfVolume(Communicator& ranks, const VolumeInput& input,
  SurfaceQuery query, ContourOutcome& outcome, ContourBlocks& blocks)
{
  const std::shared_ptr<BlockedVolume> volume = input.GetVolume();
  // Before anything can fail, so that all ranks have it.
  blocks.Volume = volume;
  blocks.ArrayName = outcome.ArrayName;
  if (blocks.Attributes)
  {
    blocks.Arrays = outcome.Arrays;
  }
  else
  {
    query.Attributes.clear();
  }
  std::string warning;
  const auto collect = [&]() -> Status
  {
    int level = std::min(this->Contour.GetLevel(), volume->GetNumberOfLevels() - 1);
    if (this->Contour.GetMaximumTriangles() > 0)
    {
      QueryStatistics statistics;
      const auto choice = ChooseLevel(*volume, query, level,
        { 0, static_cast<std::uint64_t>(this->Contour.GetMaximumTriangles()) },
        this->Stored.GetRate(), ranks, statistics);
      ISOSURFACE_RETURN_IF_ERROR(choice.GetStatus());
      level = choice->Level;
    }
    return AttemptOnAll(
      ranks, NotExtracted, [&] { return CollectVolumeBlocks(volume, query, level, blocks); });
  };
  const Status status = RunWithReplicas(
    ranks, [&] { return volume.get(); }, warning, collect);
  ReportWarning(&this->Contour, ranks, status, warning);
  return status;
}

Status ContourExecution::CollectBlocksOfImages(
  Communicator& ranks, vtkInformation* inInfo, ContourOutcome& outcome, ContourBlocks& blocks)
{
  ImagePieces pieces;
  auto query = this->CollectImages(ranks, inInfo, blocks.Attributes, pieces, outcome);
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(query.GetStatus()));
  vtkInformation* data = vtkDataObject::GetData(inInfo)->GetInformation();
  if (data->Has(vtkDataObject::DATA_TIME_STEP()))
  {
    blocks.Time = data->Get(vtkDataObject::DATA_TIME_STEP());
  }
  blocks.ArrayName = outcome.ArrayName;
  blocks.Arrays = outcome.Arrays;
  return CollectImageBlocks(ranks, std::move(*query), blocks);
}

} // namespace isosurface
