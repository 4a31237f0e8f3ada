// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/FileSystem.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

const std::string Precious = "what somebody else has";

std::string ReadText(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return { std::istreambuf_iterator<char>(file), {} };
}

/// A folder with a file of somebody else, and links to it where this program is about to write.
class LinkedFilesTest : public testing::Test
{
protected:
  LinkedFilesTest()
  {
    std::filesystem::remove_all(this->Folder);
    std::filesystem::create_directories(this->Folder + "/theirs");
    std::ofstream(this->Theirs) << Precious;
    std::filesystem::create_symlink(this->Theirs, this->Symbolic);
    std::filesystem::create_hard_link(this->Theirs, this->Hard);
  }
  ~LinkedFilesTest() override
  {
    EXPECT_EQ(ReadText(this->Theirs), Precious);
    std::filesystem::remove_all(this->Folder);
  }

  const std::string Folder = testing::TempDir() + "linked-files-" + std::to_string(::getpid());
  const std::string Theirs = this->Folder + "/theirs/file";
  const std::string Symbolic = this->Folder + "/scan.bvol.partial";
  const std::string Hard = this->Folder + "/scan.bvol.try";
  FileSystem& Files = GetLocalFileSystem();
};

} // namespace

TEST_F(LinkedFilesTest, AreReplacedByFilesThatAreCreatedOrLocked)
{
  for (const std::string& path : { this->Symbolic, this->Hard })
  {
    auto file = this->Files.CreateForWriting(path);
    ASSERT_TRUE(file.IsOk()) << file.GetStatus().GetMessage();
    EXPECT_TRUE((*file)->Append("mine", 4).IsOk());
    EXPECT_TRUE((*file)->SyncAndClose().IsOk());
    EXPECT_EQ(ReadText(path), "mine");
    EXPECT_FALSE(std::filesystem::is_symlink(path));
  }
  const std::string dangling = this->Folder + "/part.eix";
  std::filesystem::create_symlink(this->Folder + "/theirs/new", dangling);
  EXPECT_TRUE(this->Files.LockFile(dangling).IsOk());
  EXPECT_FALSE(std::filesystem::exists(this->Folder + "/theirs/new"));
}

TEST_F(LinkedFilesTest, AreErrorsWhereAFileIsWrittenOnOrAFolderIsLocked)
{
  const auto update = this->Files.OpenForUpdate(this->Symbolic);
  EXPECT_NE(update.GetStatus().GetMessage().find("it is a link"), std::string::npos);
  const auto append = this->Files.OpenForAppending(this->Symbolic, 0);
  EXPECT_NE(append.GetStatus().GetMessage().find("it is a link"), std::string::npos);
  const std::string stores = this->Folder + "/scan.bvol.stores";
  std::filesystem::create_symlink(this->Folder + "/theirs", stores);
  const auto lock = this->Files.LockFolder(stores);
  EXPECT_NE(lock.GetStatus().GetMessage().find("it is a link"), std::string::npos);
}

TEST(FileSystem, GivesNoFileTheNumberOfAStandardStreamThatIsClosed)
{
  const std::string path = testing::TempDir() + "closed-streams-" + std::to_string(::getpid());
  const pid_t child = ::fork();
  if (child == 0)
  {
    ::close(STDIN_FILENO);
    ::close(STDOUT_FILENO);
    ::close(STDERR_FILENO);
    FileSystem& files = GetLocalFileSystem();
    auto file = files.CreateForWriting(path);
    auto lock = files.LockFile(path + ".lock");
    bool isRight = file.IsOk() && lock.IsOk() && (*file)->Append("samples", 7).IsOk();
    for (const int number : { STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO })
    {
      isRight = isRight && ::write(number, "told", 4) < 0;
    }
    ::_exit(isRight ? 0 : 1);
  }
  ASSERT_GT(child, 0);
  int ended = 0;
  ASSERT_EQ(::waitpid(child, &ended, 0), child);
  EXPECT_TRUE(WIFEXITED(ended) && WEXITSTATUS(ended) == 0);
  EXPECT_EQ(ReadText(path), "samples");
  std::filesystem::remove(path);
  std::filesystem::remove(path + ".lock");
}

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
