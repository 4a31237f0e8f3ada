// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/GatheringFile.h"

#include "Fixtures/MemoryDisk.h"

#include <gtest/gtest.h>

using namespace isosurface;

TEST(GatheringFile, WritesTheSameBytesInFewerWrites)
{
  MemoryDisk disk;
  ASSERT_TRUE(disk.MakeDirectories("/data").IsOk());
  std::vector<std::uint8_t> expected;
  GatheringFile file(std::move(*disk.CreateForWriting("/data/gathered")));
  for (std::size_t size = 0; size < 2000; ++size)
  {
    // One of them is larger than what may wait.
    const std::vector<std::uint8_t> bytes(
      size == 1000 ? GatheringFile::Capacity + 5 : size, static_cast<std::uint8_t>(size));
    ASSERT_TRUE(file.Append(bytes.data(), bytes.size()).IsOk());
    expected.insert(expected.end(), bytes.begin(), bytes.end());
    ASSERT_EQ(file.GetSize(), expected.size());
  }
  expected[3] = 77;
  ASSERT_TRUE(file.WriteAt(3, &expected[3], 1).IsOk());
  ASSERT_TRUE(file.SyncAndClose().IsOk());
  EXPECT_TRUE(disk.GetFile("/data/gathered") == expected);
  EXPECT_LT(disk.GetWrites(), 20u);
}
