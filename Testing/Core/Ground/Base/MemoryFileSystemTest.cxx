// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/MemoryFileSystem.h"
#include "Fixtures/MemoryDisk.h"
#include "Fixtures/Require.h"

#include <gtest/gtest.h>

using namespace isosurface;

namespace
{

const std::string Prefix = "/read-only/index";

class MemoryFileSystemTest : public testing::Test
{
protected:
  void Write(const std::string& path, const std::string& text)
  {
    const auto file = Require(this->Files.CreateForWriting(path));
    ASSERT_TRUE(file->Append(text.data(), text.size()).IsOk());
    ASSERT_TRUE(file->SyncAndClose().IsOk());
  }

  std::string Read(const std::string& path)
  {
    const auto file = Require(this->Files.OpenForReading(path));
    std::string text(file->GetSize(), '\0');
    EXPECT_TRUE(file->Read(0, text.size(), text.data()).IsOk());
    return text;
  }

  MemoryDisk Others;
  MemoryFileSystem Files{ Others, Prefix, 16 };
};

} // namespace

TEST_F(MemoryFileSystemTest, KeepsFilesUnderItsPrefixAndReadsOthers)
{
  this->Others.SetFile("/read-only/source", { 'a' });
  this->Write(HidePath(Prefix + ".stores") + "/1/block", "samples");
  this->Write(Prefix + ".partial", "header");
  ASSERT_TRUE(this->Files.Rename(Prefix + ".partial", Prefix).IsOk());
  EXPECT_EQ(this->Read(Prefix), "header");
  EXPECT_EQ(this->Read(HidePath(Prefix + ".stores") + "/1/block"), "samples");
  EXPECT_EQ(this->Read("/read-only/source"), "a");
  EXPECT_EQ(
    Require(this->Files.List(HidePath(Prefix + ".stores"))), std::vector<std::string>{ "1" });
  EXPECT_TRUE(this->Files.Exists(HidePath(Prefix + ".stores")));
  EXPECT_TRUE(this->Files.Exists("/read-only/source"));
  EXPECT_FALSE(this->Files.Exists(Prefix + ".partial"));
  EXPECT_EQ(this->Others.GetFiles().size(), 1u) << "something was written beside it";
}

TEST_F(MemoryFileSystemTest, WritesNoOtherFiles)
{
  this->Others.SetFile("/read-only/source", { 'a' });
  ExpectError(this->Files.CreateForWriting("/read-only/source").GetStatus(), StatusCode::IoError,
    "/read-only/source");
  ExpectError(this->Files.RemoveAll("/read-only"), StatusCode::IoError, "/read-only");
  EXPECT_EQ(this->Read("/read-only/source"), "a");
}

TEST_F(MemoryFileSystemTest, IsFullAtItsLimitUntilFilesAreRemoved)
{
  this->Write(Prefix, "0123456789");
  const auto file = Require(this->Files.CreateForWriting(Prefix + "-2"));
  ExpectError(file->Append("0123456789", 10), StatusCode::DiskFull, Prefix + "-2");
  EXPECT_EQ(file->GetSize(), 0u);
  ASSERT_TRUE(this->Files.RemoveAll(Prefix).IsOk());
  EXPECT_TRUE(file->Append("0123456789", 10).IsOk());
}

TEST_F(MemoryFileSystemTest, TellsWhatIsTruncatedOrMissing)
{
  this->Write(Prefix, "0123");
  char bytes[8];
  const auto file = Require(this->Files.OpenForReading(Prefix));
  ExpectError(file->Read(2, 3, bytes), StatusCode::Corrupt, Prefix + ": truncated");
  ExpectError(
    this->Files.Rename(Prefix + "-2", Prefix), StatusCode::NotFound, Prefix + "-2: cannot be");
}
