// SPDX-License-Identifier: BSD-3-Clause
// What ranks agree on before a branch that leads to a collective.
#include "Ground/Base/Communicator.h"
#include "Fixtures/ThreadCommunicator.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// The statuses of all ranks, each of which calls `agree` with its number.
std::vector<Status> AgreeOnRanks(
  int ranks, const std::function<Status(Communicator& communicator, int rank)>& agree)
{
  return ThreadCommunicator::Collect(
    ranks, [&](Communicator& communicator) { return agree(communicator, communicator.GetRank()); });
}

/// The values that rank `odd` has beside the others' ones.
std::vector<CommonValue> MakeValues(int rank, int odd, std::size_t oddValue)
{
  std::vector<CommonValue> values = { { 0, "zeros differ" }, { ~std::uint64_t{ 0 }, "ones differ" },
    { 7, "sevens differ" } };
  if (rank == odd)
  {
    values[oddValue].Value ^= std::uint64_t{ 1 } << 40;
  }
  return values;
}

} // namespace

TEST(Communicator, AgreesOnEqualValues)
{
  for (const int ranks : { 1, 2, 3, 7 })
  {
    for (const Status& status : AgreeOnRanks(ranks,
           [](Communicator&communicator, int)
           { return communicator.Agree(Status::Ok(), MakeValues(0, -1, 0)); }))
    {
      EXPECT_TRUE(status.IsOk()) << status.GetMessage();
    }
  }
}

TEST(Communicator, TellsAllRanksWhichValueDiffersAndWhere)
{
  const char* const names[] = { "zeros differ", "ones differ", "sevens differ" };
  for (const int ranks : { 2, 3, 7 })
  {
    for (int odd = 1; odd < ranks; ++odd)
    {
      for (std::size_t value = 0; value < 3; ++value)
      {
        for (const Status& status : AgreeOnRanks(ranks,
               [&](Communicator&communicator, int rank)
               { return communicator.Agree(Status::Ok(), MakeValues(rank, odd, value)); }))
        {
          EXPECT_EQ(status.GetCode(), StatusCode::InvalidArgument);
          EXPECT_EQ(status.GetMessage(),
            names[value] + std::string(" (rank ") + std::to_string(odd) + " differs from rank 0)");
        }
      }
    }
  }
}

TEST(Communicator, TellsTheErrorOfOneRankBeforeDifferences)
{
  const int failing = 1;
  const std::vector<Status> statuses = AgreeOnRanks(3,
    [&](Communicator& communicator, int rank)
    {
      const Status mine =
        rank == failing ? Status(StatusCode::Corrupt, "a/file: is broken") : Status::Ok();
      return communicator.Agree(mine, MakeValues(rank, failing, 2));
    });
  EXPECT_EQ(statuses[0].GetMessage(), "rank 1 failed: a/file: is broken");
  EXPECT_EQ(statuses[1].GetMessage(), "a/file: is broken");
  EXPECT_EQ(statuses[2].GetCode(), StatusCode::RemoteFailure);
}

// Otherwise VTK would go on behind the stopped rank alone.
TEST(Communicator, AStopOfOneRankStopsAllWhateverFailsOnOthers)
{
  for (const int ranks : { 2, 3, 7 })
  {
    for (int stopped = 0; stopped < ranks; ++stopped)
    {
      const std::vector<Status> statuses = AgreeOnRanks(ranks,
        [&](Communicator& communicator, int rank)
        {
          const Status mine = rank == stopped ? Status(StatusCode::Aborted, "was stopped")
            : rank == 0 || rank == ranks - 1  ? Status(StatusCode::Corrupt, "a/file: is broken")
                                              : Status::Ok();
          return communicator.Agree(mine);
        });
      for (const Status& status : statuses)
      {
        EXPECT_EQ(status.GetCode(), StatusCode::Aborted);
        EXPECT_EQ(status.GetMessage(), "was stopped");
      }
    }
  }
}

TEST(Communicator, ReducesAndAgreesAtOnce)
{
  for (const int failing : { -1, 0, 2 })
  {
    const auto statuses = AgreeOnRanks(3,
      [failing](Communicator& communicator, int rank)
      {
        std::vector<std::uint64_t> maxima = { 5U - static_cast<unsigned>(rank), 7 };
        const Status status = communicator.ReduceAgreed(
          rank == failing ? Status(StatusCode::IoError, "fails") : Status::Ok(), maxima);
        EXPECT_EQ(maxima, (std::vector<std::uint64_t>{ 5, 7 }));
        return status;
      });
    for (int rank = 0; rank < 3; ++rank)
    {
      EXPECT_EQ(statuses[static_cast<std::size_t>(rank)].GetCode(),
        failing < 0         ? StatusCode::Ok
          : rank == failing ? StatusCode::IoError
                            : StatusCode::RemoteFailure);
    }
  }
}
