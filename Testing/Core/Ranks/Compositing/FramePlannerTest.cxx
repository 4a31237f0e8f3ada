// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Compositing/FramePlanner.h"

#include "Fixtures/ThreadCommunicator.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

constexpr int Ranks = 3;
constexpr PixelRectangle PlannedDisplay{ 0, 0, 320, 200 };

/// Rank r draws a rectangle of its own; rank 2 nothing.
PixelRectangle GetPixels(int rank)
{
  return rank == 2 ? PixelRectangle{} : PixelRectangle{ 100 * rank, 30, 90, 120 };
}

FrameProposal MakeProposalOf(int rank, const std::vector<int>& divisors)
{
  FrameProposal proposal;
  for (const int divisor : divisors)
  {
    proposal.Choices.push_back(MakeViewport(GetPixels(rank), divisor));
  }
  proposal.Triangles = 1000 * (rank + 1);
  proposal.NearDistance = 1 + rank;
  proposal.FarDistance = 2 + rank;
  return proposal;
}

FrameProposal MakeProposalWithBudget(int rank, double budget)
{
  FrameProposal proposal = MakeProposalOf(rank, { 1, 2, 4, 8, 16 });
  proposal.Budget = budget;
  return proposal;
}

} // namespace

TEST(FramePlanner, AProposalArrivesAsItWasSent)
{
  FrameProposal sent = MakeProposalWithBudget(1, 0.25);
  sent.Triangles = std::int64_t{ 1 } << 40;
  sent.LastSeconds = 0.125;
  sent.WantsDepths = true;
  sent.CanShareDepths = true;
  sent.WantsSharedDepths = true;
  const FrameProposal received = FrameProposal::Unpack(sent.Pack());
  EXPECT_EQ(received.Choices, sent.Choices);
  EXPECT_EQ(received.Triangles, sent.Triangles);
  EXPECT_EQ(received.NearDistance, sent.NearDistance);
  EXPECT_EQ(received.FarDistance, sent.FarDistance);
  EXPECT_EQ(received.LastSeconds, sent.LastSeconds);
  EXPECT_EQ(received.Budget, sent.Budget);
  EXPECT_EQ(received.WantsDepths, sent.WantsDepths);
  EXPECT_EQ(received.CanShareDepths, sent.CanShareDepths);
  EXPECT_EQ(received.WantsSharedDepths, sent.WantsSharedDepths);
  EXPECT_FALSE(FrameProposal::Unpack(FrameProposal().Pack()).CanShareDepths);
}

TEST(FramePlanner, WithoutABudgetTheViewportsAreThoseProposed)
{
  ThreadCommunicator::Run(Ranks,
    [](Communicator& communicator)
    {
      FramePlanner planner;
      const FramePlan plan = planner.Plan(communicator,
        MakeProposalOf(communicator.GetRank(), { communicator.GetRank() + 1 }), PlannedDisplay);
      ASSERT_EQ(plan.Viewports.size(), std::size_t{ Ranks });
      for (int rank = 0; rank < Ranks; ++rank)
      {
        EXPECT_EQ(
          plan.Viewports[static_cast<std::size_t>(rank)], MakeViewport(GetPixels(rank), rank + 1));
      }
      EXPECT_FALSE(plan.WantsDepths);
    });
}

TEST(FramePlanner, DepthsAreCollectedIfOneRankWantsThem)
{
  ThreadCommunicator::Run(Ranks,
    [](Communicator& communicator)
    {
      FrameProposal mine = MakeProposalOf(communicator.GetRank(), { 1 });
      mine.WantsDepths = communicator.GetRank() == 1;
      EXPECT_TRUE(FramePlanner().Plan(communicator, mine, PlannedDisplay).WantsDepths);
    });
}

TEST(FramePlanner, DepthsAreSharedIfARankWantsThemAndAllCanInFullResolution)
{
  const auto isShared = [](const std::vector<int>& divisors, int wants, int cannot)
  {
    bool all = true;
    bool some = false;
    ThreadCommunicator::Run(Ranks,
      [&](Communicator& communicator)
      {
        const int rank = communicator.GetRank();
        FrameProposal proposal = MakeProposalOf(rank, { divisors[static_cast<std::size_t>(rank)] });
        proposal.WantsSharedDepths = rank == wants;
        proposal.CanShareDepths = rank != cannot;
        const bool mine = FramePlanner().Plan(communicator, proposal, PlannedDisplay).SharesDepths;
        const std::uint64_t votes = communicator.Sum(mine ? 1U : 0U);
        if (rank == 0)
        {
          some = votes > 0;
          all = votes == Ranks;
        }
      });
    EXPECT_EQ(some, all) << "ranks differ";
    return all;
  };
  EXPECT_TRUE(isShared({ 1, 1, 1 }, 1, -1));
  EXPECT_FALSE(isShared({ 1, 1, 1 }, -1, -1)) << "nobody wants them";
  EXPECT_FALSE(isShared({ 1, 1, 1 }, 1, 0)) << "one rank cannot";
  EXPECT_FALSE(isShared({ 1, 2, 1 }, 1, -1)) << "one rank draws coarser";
}

TEST(FramePlanner, FramesThatTakeTooLongGetCoarserOnAllRanks)
{
  ThreadCommunicator::Run(Ranks,
    [](Communicator& communicator)
    {
      const int rank = communicator.GetRank();
      FramePlanner planner;
      FramePlan plan =
        planner.Plan(communicator, MakeProposalWithBudget(rank, 1000), PlannedDisplay);
      EXPECT_EQ(plan.Viewports[0].Divisor, 1);
      EXPECT_EQ(plan.Viewports[1].Divisor, 1);
      // The slowest rank counts.
      for (int frame = 0; frame < 4; ++frame)
      {
        FrameProposal mine = MakeProposalWithBudget(rank, 1e-3);
        mine.LastSeconds = rank == 1 ? 10.0 : 1e-6;
        plan = planner.Plan(communicator, mine, PlannedDisplay);
      }
      EXPECT_EQ(plan.Viewports[0], MakeViewport(GetPixels(0), 16));
      EXPECT_EQ(plan.Viewports[1], MakeViewport(GetPixels(1), 16));
      EXPECT_TRUE(plan.Viewports[2].Blocks.IsEmpty());
    });
}

TEST(FramePlanner, ABudgetOfSomeRanksOnlyMeansFullResolution)
{
  ThreadCommunicator::Run(Ranks,
    [](Communicator& communicator)
    {
      const int rank = communicator.GetRank();
      const FrameProposal mine =
        rank == 1 ? MakeProposalOf(rank, { 2 }) : MakeProposalWithBudget(rank, 1e-9);
      const FramePlan plan = FramePlanner().Plan(communicator, mine, PlannedDisplay);
      EXPECT_EQ(plan.Viewports[0].Divisor, 1);
      EXPECT_EQ(plan.Viewports[1].Divisor, 2);
    });
}
