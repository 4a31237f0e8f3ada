// SPDX-License-Identifier: BSD-3-Clause
// Blocks of a round are written in their order, whatever the order in which they are finished.
#include "Storage/Writing/BlockRounds.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

using namespace isosurface;

namespace
{

const BlockGrid Grid({ 40, 40, 40 }, 16);

std::vector<PendingBlock> MakeBlocks(std::int64_t begin, std::int64_t end, RecordBuffers& records)
{
  std::vector<PendingBlock> blocks;
  for (std::int64_t block = begin; block < end; ++block)
  {
    blocks.emplace_back(Grid, block, 0, std::vector<ValueType>{ ValueType::UInt8 }, records.Take());
  }
  return blocks;
}

} // namespace

TEST(RoundWriting, WritesInOrderAndRoundAfterRound)
{
  RecordBuffers records(64);
  std::vector<std::int64_t> written;
  const auto write = [&](const PendingBlock& block)
  {
    written.push_back(block.Block);
    return Status::Ok();
  };
  auto first = std::make_shared<RoundWriting>(MakeBlocks(0, 3, records), write, records, nullptr);
  auto second = std::make_shared<RoundWriting>(MakeBlocks(3, 6, records), write, records, first);
  for (const std::size_t index : { 2u, 0u, 1u })
  {
    second->MarkFinished(index);
  }
  for (const std::size_t index : { 1u, 2u, 0u })
  {
    first->MarkFinished(index);
  }
  EXPECT_TRUE(second->Wait().IsOk());
  EXPECT_EQ(written, (std::vector<std::int64_t>{ 0, 1, 2, 3, 4, 5 }));
}

TEST(RoundWriting, AnErrorEndsTheRoundsAfterIt)
{
  RecordBuffers records(64);
  std::atomic<int> calls{ 0 };
  const auto write = [&](const PendingBlock&)
  {
    ++calls;
    return Status(StatusCode::DiskFull, "no room");
  };
  auto first = std::make_shared<RoundWriting>(MakeBlocks(0, 2, records), write, records, nullptr);
  auto second = std::make_shared<RoundWriting>(MakeBlocks(2, 4, records), write, records, first);
  for (const std::size_t index : { 0u, 1u })
  {
    first->MarkFinished(index);
    second->MarkFinished(index);
  }
  EXPECT_EQ(second->Wait().GetCode(), StatusCode::DiskFull);
  EXPECT_EQ(calls, 1);
}

TEST(RoundWriting, IsGivenUpWithoutItsBlocks)
{
  RecordBuffers records(64);
  std::atomic<int> calls{ 0 };
  const auto write = [&](const PendingBlock&)
  {
    ++calls;
    return Status::Ok();
  };
  {
    RoundWriting writing(MakeBlocks(0, 3, records), write, records, nullptr);
    writing.MarkFinished(1);
  }
  EXPECT_EQ(calls, 0);
}
