// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/FramePlanner.h"

#include "Ground/Base/Coding.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

constexpr std::int32_t WantsDepthsFlag = 1;
constexpr std::int32_t CanShareFlag = 2;
constexpr std::int32_t WantsSharedFlag = 4;

// The distance of a viewport's center from the display's center, relative to that of the corners.
double GetOffset(const Viewport& viewport, const PixelRectangle& display)
{
  const PixelRectangle pixels = viewport.GetPixels(display);
  const double x = pixels.X + 0.5 * pixels.Width - 0.5 * display.Width;
  const double y = pixels.Y + 0.5 * pixels.Height - 0.5 * display.Height;
  return std::hypot(x, y) / (0.5 * std::hypot(display.Width, display.Height));
}

// The work of all ranks, by rank, as ResolutionChooser counts it.
std::vector<RankWork> CountWork(
  const std::vector<FrameProposal>& proposals, const PixelRectangle& display)
{
  double nearest = HUGE_VAL;
  double farthest = -HUGE_VAL;
  for (const FrameProposal& proposal : proposals)
  {
    if (!proposal.Choices.front().Blocks.IsEmpty())
    {
      nearest = std::min(nearest, proposal.NearDistance);
      farthest = std::max(farthest, proposal.FarDistance);
    }
  }
  std::vector<RankWork> work;
  for (const FrameProposal& proposal : proposals)
  {
    RankWork mine;
    mine.Triangles = proposal.Triangles;
    for (const Viewport& choice : proposal.Choices)
    {
      mine.Samples[FindResolution(choice.Divisor)] = choice.Blocks.GetArea();
    }
    const double depth =
      farthest > nearest ? (proposal.NearDistance - nearest) / (farthest - nearest) : 0;
    mine.Importance = GetImportance(GetOffset(proposal.Choices.front(), display), depth);
    work.push_back(mine);
  }
  return work;
}

} // namespace

// The bytes of a proposal; all numbers are little-endian.
//
//   offset  size  content
//        0     8  triangles
//        8    32  near distance, far distance, seconds of the last frame, budget: f64 each
//       40     4  sum of 1 if depths are wanted, 2 if they can be shared, 4 if that is wanted
//       44     4  number of choices, n
//       48  20 n  choices: divisor, x, y, width and height in blocks, i32 each
Message FrameProposal::Pack() const
{
  Message bytes;
  AppendLittleEndian(bytes, this->Triangles);
  for (const double value :
    { this->NearDistance, this->FarDistance, this->LastSeconds, this->Budget })
  {
    AppendLittleEndian(bytes, value);
  }
  AppendLittleEndian(bytes,
    static_cast<std::int32_t>((this->WantsDepths ? WantsDepthsFlag : 0) |
      (this->CanShareDepths ? CanShareFlag : 0) | (this->WantsSharedDepths ? WantsSharedFlag : 0)));
  AppendLittleEndian(bytes, static_cast<std::int32_t>(this->Choices.size()));
  for (const Viewport& choice : this->Choices)
  {
    for (const int value : { choice.Divisor, choice.Blocks.X, choice.Blocks.Y, choice.Blocks.Width,
           choice.Blocks.Height })
    {
      AppendLittleEndian(bytes, std::int32_t{ value });
    }
  }
  return bytes;
}

FrameProposal FrameProposal::Unpack(const Message& bytes)
{
  ByteReader reader(bytes);
  FrameProposal proposal;
  proposal.Triangles = reader.Read<std::int64_t>();
  proposal.NearDistance = reader.Read<double>();
  proposal.FarDistance = reader.Read<double>();
  proposal.LastSeconds = reader.Read<double>();
  proposal.Budget = reader.Read<double>();
  const auto flags = reader.Read<std::int32_t>();
  proposal.WantsDepths = (flags & WantsDepthsFlag) != 0;
  proposal.CanShareDepths = (flags & CanShareFlag) != 0;
  proposal.WantsSharedDepths = (flags & WantsSharedFlag) != 0;
  const auto count = std::clamp<std::int32_t>(
    reader.Read<std::int32_t>(), 1, static_cast<std::int32_t>(NumberOfResolutions));
  for (std::int32_t choice = 0; choice < count; ++choice)
  {
    Viewport viewport;
    viewport.Divisor = reader.Read<std::int32_t>();
    viewport.Blocks.X = reader.Read<std::int32_t>();
    viewport.Blocks.Y = reader.Read<std::int32_t>();
    viewport.Blocks.Width = reader.Read<std::int32_t>();
    viewport.Blocks.Height = reader.Read<std::int32_t>();
    proposal.Choices.push_back(viewport);
  }
  return proposal;
}

void FramePlanner::Learn(const std::vector<FrameProposal>& proposals)
{
  double seconds = 0;
  for (const FrameProposal& proposal : proposals)
  {
    seconds = std::max(seconds, proposal.LastSeconds);
  }
  if (!this->LastWork.empty())
  {
    this->Chooser.Learn(this->LastWork, this->LastDivisors, seconds);
  }
}

FramePlan FramePlanner::Plan(
  Communicator& communicator, const FrameProposal& mine, const PixelRectangle& display)
{
  FramePlan plan;
  std::vector<FrameProposal> proposals;
  bool haveChoices = true;
  bool canShare = true;
  for (const Message& message : communicator.AllGather(mine.Pack()))
  {
    proposals.push_back(FrameProposal::Unpack(message));
    plan.WantsDepths = plan.WantsDepths || proposals.back().WantsDepths;
    plan.SharesDepths = plan.SharesDepths || proposals.back().WantsSharedDepths;
    canShare = canShare && proposals.back().CanShareDepths;
    haveChoices = haveChoices && proposals.back().Choices.size() == NumberOfResolutions;
  }
  this->Learn(proposals);
  this->LastWork = CountWork(proposals, display);
  this->LastDivisors.clear();
  if (haveChoices)
  {
    this->LastDivisors = this->Chooser.Choose(this->LastWork, proposals.front().Budget);
  }
  for (std::size_t rank = 0; rank < proposals.size(); ++rank)
  {
    const std::vector<Viewport>& choices = proposals[rank].Choices;
    plan.Viewports.push_back(
      haveChoices ? choices[FindResolution(this->LastDivisors[rank])] : choices.front());
  }
  this->LastDivisors.clear();
  for (const Viewport& viewport : plan.Viewports)
  {
    this->LastDivisors.push_back(viewport.Divisor);
    canShare = canShare && viewport.Divisor == 1;
  }
  plan.SharesDepths = plan.SharesDepths && canShare;
  return plan;
}

} // namespace isosurface
