// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/RelayedCommunicator.h"
#include "Fixtures/ThreadCommunicator.h"
#include "Ground/Base/BackgroundTask.h"

#include <gtest/gtest.h>

#include <string>

using namespace isosurface;

namespace
{

/// What a rank learns from each kind of collective.
std::string Talk(Communicator& ranks)
{
  const auto mine = static_cast<std::uint8_t>(ranks.GetRank());
  std::vector<std::uint64_t> lowest = { mine };
  std::vector<std::uint64_t> highest = { mine };
  std::vector<std::uint64_t> sum = { mine };
  ranks.ReduceMinimum(lowest);
  ranks.ReduceMaximum(highest);
  ranks.ReduceSum(sum);
  std::string text = std::to_string(lowest[0]) + " " + std::to_string(highest[0]) + " " +
    std::to_string(sum[0]) + " " + std::to_string(ranks.GetRanksOnNode());
  for (const Message& message : ranks.AllGather({ mine }))
  {
    text += " " + std::to_string(message.at(0));
  }
  const auto size = static_cast<std::size_t>(ranks.GetSize());
  for (const Message& message : ranks.Exchange(std::vector<Message>(size, { mine })))
  {
    text += " " + std::to_string(message.at(0));
  }
  return text;
}

} // namespace

TEST(RelayedCommunicator, GivesTheBackgroundThreadsWhatTheRanksSay)
{
  for (const int size : { 1, 2, 5 })
  {
    const auto expected = ThreadCommunicator::Collect(size, Talk);
    const auto relayed = ThreadCommunicator::Collect(size,
      [](Communicator& ranks)
      {
        RelayedCommunicator relay(ranks);
        std::string text;
        BackgroundTask task("talk",
          [&](const Progress&)
          {
            text = Talk(relay);
            return Status::Ok();
          });
        while (!relay.Serve(ranks, 0.001, [&] { return task.Wait(0); }))
        {
        }
        return text;
      });
    EXPECT_EQ(relayed, expected) << size << " ranks";
  }
}

TEST(RelayedCommunicator, EndsCollectivesThatNobodyServesAnyMore)
{
  const auto endings = ThreadCommunicator::Collect(3,
    [](Communicator& ranks)
    {
      RelayedCommunicator relay(ranks);
      BackgroundTask task("talk",
        [&](const Progress&)
        {
          static_cast<void>(Talk(relay));
          static_cast<void>(Talk(relay));
          return Status::Ok();
        });
      relay.Serve(ranks, 0, [] { return false; }); // one collective at most
      relay.Close();
      EXPECT_TRUE(task.Wait(60));
      return task.GetStatus().GetMessage();
    });
  for (const std::string& ending : endings)
  {
    EXPECT_EQ(ending, "talk: the ranks no longer work together");
  }
}
