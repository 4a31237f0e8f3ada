// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/KeptMemory.h"

#include "Ground/Base/Buffer.h"
#include "Ground/Base/ParallelFor.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace isosurface
{
namespace
{

constexpr std::size_t MiB = std::size_t(1) << 20;

class KeptMemory : public ::testing::Test
{
protected:
  KeptMemory() { FreeKeptMemory(); }
  ~KeptMemory() override { FreeKeptMemory(); }
};

TEST_F(KeptMemory, IsThatOfTheNextBufferOfAboutItsSize)
{
  Buffer<std::uint8_t> first(8 * MiB);
  const void* const memory = first.GetData();
  EXPECT_EQ(GetKeptBytes(), 0u);
  first = Buffer<std::uint8_t>();
  EXPECT_GE(GetKeptBytes(), 8 * MiB);
  const Buffer<std::uint8_t> larger(9 * MiB);
  const Buffer<std::uint8_t> smaller(6 * MiB);
  EXPECT_GE(GetKeptBytes(), 8 * MiB) << "too small, and a waste";
  Buffer<std::uint32_t> next(7 * MiB / sizeof(std::uint32_t));
  EXPECT_EQ(next.GetData(), memory);
  EXPECT_EQ(GetKeptBytes(), 0u);
  std::memset(next.GetData(), 1, 7 * MiB);
}

TEST_F(KeptMemory, IsTheSmallestThatFits)
{
  void* const blocks[] = { TakeMemory(20 * MiB), TakeMemory(17 * MiB), TakeMemory(18 * MiB) };
  for (void* block : blocks)
  {
    ReleaseMemory(block);
  }
  EXPECT_EQ(TakeMemory(17 * MiB + MiB / 2), blocks[2]);
  EXPECT_EQ(TakeMemory(16 * MiB), blocks[1]);
  EXPECT_EQ(TakeMemory(17 * MiB), blocks[0]);
  EXPECT_EQ(GetKeptBytes(), 0u);
  for (void* block : blocks)
  {
    ReleaseMemory(block);
  }
}

TEST_F(KeptMemory, IsNoneOfSmallBuffers)
{
  ReleaseMemory(nullptr);
  ReleaseMemory(TakeMemory(1000));
  ReleaseMemory(TakeMemory(MiB / 2));
  EXPECT_EQ(GetKeptBytes(), 0u);
}

TEST_F(KeptMemory, IsBoundedAndThatWhichWasReleasedLast)
{
  std::vector<Buffer<std::uint8_t>> buffers; // not written, so the system gives no page
  for (std::uint64_t bytes = 0; bytes < LargestKept + 128 * MiB; bytes += 64 * MiB)
  {
    buffers.emplace_back(64 * MiB);
  }
  const void* const last = buffers.back().GetData();
  while (!buffers.empty())
  {
    buffers.erase(buffers.begin());
  }
  EXPECT_GE(GetKeptBytes(), 64 * MiB);
  EXPECT_LE(GetKeptBytes(), LargestKept);
  EXPECT_EQ(Buffer<std::uint8_t>(64 * MiB).GetData(), last);
}

TEST_F(KeptMemory, IsOfOneOwnerAtATime)
{
  ParallelFor(4, 4,
    [](std::size_t index, int)
    {
      for (int round = 0; round < 50; ++round)
      {
        Buffer<std::uint8_t> buffer((1 + index % 2) * MiB);
        std::memset(buffer.GetData(), static_cast<int>(index), buffer.GetSize());
        EXPECT_EQ(buffer[0], index);
        EXPECT_EQ(buffer[buffer.GetSize() - 1], index);
      }
    });
}

} // namespace
} // namespace isosurface
