// SPDX-License-Identifier: BSD-3-Clause
#include "RankGroup.h"

#include "ControllerCommunicator.h"

#include "vtkMultiProcessController.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

// A message that tells who sent it to whom; some are empty, some longer than MPI sends eagerly.
Message MakeMessage(int from, int to)
{
  const std::size_t sizes[] = { 0, 1, 300000, 17 };
  return Message(sizes[(from + 2 * to) % 4], static_cast<std::uint8_t>(16 * from + to));
}

TEST(ControllerCommunicator, KnowsItsRanks)
{
  ControllerCommunicator ranks(GetRanks());
  EXPECT_EQ(ranks.GetRank(), GetRank());
  EXPECT_EQ(ranks.GetSize(), GetNumberOfRanks());
  EXPECT_EQ(ranks.GetRanksOnNode(), GetNumberOfRanks()) << "these tests run on one machine";
}

TEST(ControllerCommunicator, WithoutControllerIsOneRank)
{
  ControllerCommunicator one(nullptr);
  EXPECT_EQ(one.GetRank(), 0);
  EXPECT_EQ(one.GetSize(), 1);
  EXPECT_EQ(one.GetRanksOnNode(), 1);
  std::vector<std::uint64_t> values{ 3, 5 };
  one.ReduceSum(values);
  EXPECT_EQ(values, (std::vector<std::uint64_t>{ 3, 5 }));
  EXPECT_EQ(one.AllGather({ 1, 2 }), std::vector<Message>(1, { 1, 2 }));
  EXPECT_EQ(one.Exchange({ { 4 } }), std::vector<Message>(1, { 4 }));
}

TEST(ControllerCommunicator, ReducesEachElement)
{
  ControllerCommunicator ranks(GetRanks());
  const auto me = static_cast<std::uint64_t>(GetRank());
  const auto size = static_cast<std::uint64_t>(GetNumberOfRanks());
  const std::uint64_t large = UINT64_MAX - 100;
  const std::vector<std::uint64_t> mine{ me, large - me, 7 };
  std::vector<std::uint64_t> values = mine;
  ranks.ReduceMinimum(values);
  EXPECT_EQ(values, (std::vector<std::uint64_t>{ 0, large - (size - 1), 7 }));
  values = mine;
  ranks.ReduceMaximum(values);
  EXPECT_EQ(values, (std::vector<std::uint64_t>{ size - 1, large, 7 }));
  values = { me, 7 };
  ranks.ReduceSum(values);
  EXPECT_EQ(values, (std::vector<std::uint64_t>{ size * (size - 1) / 2, 7 * size }));
  values.clear();
  ranks.ReduceSum(values);
  EXPECT_TRUE(values.empty());
}

TEST(ControllerCommunicator, GathersMessagesOfAnyLength)
{
  ControllerCommunicator ranks(GetRanks());
  const std::vector<Message> all = ranks.AllGather(MakeMessage(GetRank(), 1));
  EXPECT_EQ(all.size(), static_cast<std::size_t>(GetNumberOfRanks()));
  for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
  {
    EXPECT_EQ(all.at(static_cast<std::size_t>(rank)), MakeMessage(rank, 1)) << rank;
  }
  EXPECT_EQ(ranks.AllGather({}), std::vector<Message>(all.size()));
}

TEST(ControllerCommunicator, DeliversMessagesOfKnownLengthsAndTellsOfEachOnce)
{
  ControllerCommunicator ranks(GetRanks());
  const int size = GetNumberOfRanks();
  for (int turn = 0; turn < 3; ++turn)
  {
    std::vector<Message> outgoing;
    std::vector<Message> incoming;
    std::vector<Message> expected;
    for (int rank = 0; rank < size; ++rank)
    {
      outgoing.push_back(MakeMessage(GetRank(), rank + turn));
      expected.push_back(MakeMessage(rank, GetRank() + turn));
      incoming.emplace_back(rank == GetRank() ? 0 : expected.back().size());
    }
    std::vector<int> told(static_cast<std::size_t>(size), 0);
    ranks.Deliver(std::move(outgoing), incoming,
      [&](int rank)
      {
        const auto from = static_cast<std::size_t>(rank);
        ++told[from];
        EXPECT_TRUE(incoming[from] == expected[from]) << rank;
      });
    for (std::size_t rank = 0; rank < expected.size(); ++rank)
    {
      EXPECT_EQ(told[rank], expected[rank].empty() ? 0 : 1) << rank;
    }
  }
}

TEST(ControllerCommunicator, ExchangesMessagesOfAnyLength)
{
  ControllerCommunicator ranks(GetRanks());
  for (int turn = 0; turn < 3; ++turn)
  {
    std::vector<Message> outgoing;
    for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
    {
      outgoing.push_back(MakeMessage(GetRank() + turn, rank));
    }
    const std::vector<Message> incoming = ranks.Exchange(outgoing);
    EXPECT_EQ(incoming.size(), outgoing.size());
    for (int rank = 0; rank < GetNumberOfRanks(); ++rank)
    {
      EXPECT_EQ(incoming.at(static_cast<std::size_t>(rank)), MakeMessage(rank + turn, GetRank()))
        << "from " << rank;
    }
  }
}

// What MPI cannot count in one call goes in parts, which here are short.
TEST(ControllerCommunicator, SendsLongMessagesInParts)
{
  const int size = GetNumberOfRanks();
  for (const std::size_t largestPart : { 1000u, 70u })
  {
    ControllerCommunicator ranks(GetRanks(), largestPart);
    const auto make = [](int from, int to)
    {
      Message message(static_cast<std::size_t>(3 * from + to) * 100 + 1);
      for (std::size_t n = 0; n < message.size(); ++n)
      {
        message[n] = static_cast<std::uint8_t>(n % 251 + 3 * static_cast<std::size_t>(from + to));
      }
      return message;
    };
    std::vector<Message> outgoing;
    std::vector<Message> expected;
    std::vector<Message> incoming;
    std::vector<Message> gathered;
    for (int rank = 0; rank < size; ++rank)
    {
      outgoing.push_back(make(GetRank(), rank));
      expected.push_back(make(rank, GetRank()));
      incoming.emplace_back(rank == GetRank() ? 0 : expected.back().size());
      gathered.push_back(make(rank, 1));
    }
    EXPECT_TRUE(ranks.AllGather(make(GetRank(), 1)) == gathered) << largestPart;
    EXPECT_TRUE(ranks.Exchange(outgoing) == expected) << largestPart;
    ranks.Deliver(outgoing, incoming, [](int) {});
    EXPECT_TRUE(incoming == expected) << largestPart;
  }
}

TEST(ControllerCommunicator, AgreesOnTheFailureOfOneRank)
{
  ControllerCommunicator ranks(GetRanks());
  EXPECT_TRUE(ranks.Agree(Status::Ok()).IsOk());
  for (int failing = 0; failing < GetNumberOfRanks(); ++failing)
  {
    const bool isMine = failing == GetRank();
    const Status status =
      ranks.Agree(isMine ? Status(StatusCode::Corrupt, "a/file: is broken") : Status::Ok());
    EXPECT_EQ(status.GetCode(), isMine ? StatusCode::Corrupt : StatusCode::RemoteFailure);
    EXPECT_NE(status.GetMessage().find("a/file: is broken"), std::string::npos);
    EXPECT_EQ(
      status.GetMessage().find("rank " + std::to_string(failing)) == std::string::npos, isMine);
  }
}

// Takes 14 GB of memory on two ranks: Testing/Large runs it.
TEST(ControllerCommunicator, DISABLED_SendsMessagesBeyondTwoGibibytes)
{
  constexpr std::size_t length = (std::size_t{ 1 } << 31) + 1234567;
  // Another byte wherever a count of 31 or 32 bits would read or write.
  const auto find = [](std::size_t place)
  { return static_cast<std::uint8_t>(place * 0x9e3779b97f4a7c15u >> 56); };
  const auto isWhole = [&](const Message& message)
  {
    bool isSame = message.size() == length;
    for (std::size_t place = 0; isSame && place < length; ++place)
    {
      isSame = message[place] == find(place);
    }
    return isSame;
  };
  const auto size = static_cast<std::size_t>(GetNumberOfRanks());
  ControllerCommunicator ranks(GetRanks());
  // The last rank has something for the first one.
  const bool sends = GetRank() + 1 == GetNumberOfRanks();
  const auto make = [&]
  {
    std::vector<Message> outgoing(size);
    outgoing[0].resize(sends ? length : 0);
    for (std::size_t place = 0; place < outgoing[0].size(); ++place)
    {
      outgoing[0][place] = find(place);
    }
    return outgoing;
  };
  std::vector<Message> incoming = ranks.Exchange(make());
  EXPECT_TRUE(GetRank() != 0 || isWhole(incoming[size - 1]));
  incoming = std::vector<Message>(size);
  incoming[size - 1].resize(GetRank() == 0 ? length : 0);
  ranks.Deliver(make(), incoming, [](int) {});
  EXPECT_TRUE(GetRank() != 0 || isWhole(incoming[size - 1]));
  incoming = {};
  EXPECT_TRUE(isWhole(ranks.AllGather(make()[0])[size - 1]));
}

} // namespace
