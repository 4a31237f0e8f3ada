// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/FileSystem.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

using namespace isosurface;

TEST(FileSystem, KnowsTheRoomForFilesWhoseFoldersAreNotThereYet)
{
  FileSystem& files = GetLocalFileSystem();
  const std::string folder = testing::TempDir();
  const std::string path = folder + "/not/there/yet.bvol";
  const auto free = files.FindFreeBytes(path);
  ASSERT_TRUE(free.has_value());
  // Others write meanwhile.
  const auto now = static_cast<double>(std::filesystem::space(folder).available);
  EXPECT_NEAR(static_cast<double>(*free), now, 0.2 * now);
  EXPECT_EQ(DescribeLackOfRoom(files, path, 1), "");
  const std::string warning =
    DescribeLackOfRoom(files, path, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(warning.find(path + ": takes up to 17592186044416 MiB, but its disk has room for "), 0u)
    << warning;
}
