// SPDX-License-Identifier: BSD-3-Clause
#include "DepthSharing.h"

#include "SceneProjection.h"

#include <cstdint>
#include <vector>

namespace isosurface
{

void DepthSharing::Begin(const vtkRenderState* state, const PixelRectangle& display, bool isAllowed,
  FrameProposal& proposal)
{
  const PixelRectangle& part = proposal.Choices.front().Blocks;
  this->CanShare = isAllowed &&
    Attempt("depths cannot be shared",
      [&]
      {
        this->Shared.Begin(display.Width, display.Height,
          { part.X, part.GetRight(), part.Y, part.GetTop() }, FindLastMapper(state));
        return Status::Ok();
      })
      .IsOk();
  proposal.CanShareDepths = this->CanShare;
  proposal.WantsSharedDepths = this->CanShare && this->Shared.IsWanted();
}

Status DepthSharing::Draw(
  Communicator& communicator, const FramePlan& plan, const std::function<Status()>& draw)
{
  if (plan.SharesDepths)
  {
    this->Shared.Connect(
      [&communicator](std::vector<std::uint64_t>& depths)
      {
        return RunCollective("depths cannot be shared",
          [&]
          {
            communicator.ReduceMaximum(depths);
            return Status::Ok();
          })
          .IsOk();
      });
  }
  SharedDepths::SetCurrent(this->CanShare ? &this->Shared : nullptr);
  Status drawn = draw();
  SharedDepths::SetCurrent(nullptr);
  this->Shared.End();
  return drawn;
}

} // namespace isosurface
