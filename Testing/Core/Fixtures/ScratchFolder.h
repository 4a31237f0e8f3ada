// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_Core_ScratchFolder_h
#define isosurface_Testing_Core_ScratchFolder_h

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

namespace isosurface
{

/// An empty folder for a test. It ends with it.
class ScratchFolder
{
public:
  ScratchFolder()
    : Path(testing::TempDir() + "isosurface-" +
        testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() + "-" +
        testing::UnitTest::GetInstance()->current_test_info()->name() + "-" +
        std::to_string(::getpid()) + "/")
  {
    std::filesystem::remove_all(this->Path);
    std::filesystem::create_directories(this->Path);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { std::filesystem::remove_all(this->Path); }

  std::string operator/(const std::string& name) const { return this->Path + name; }
  /// The path of a new FIFO: who opens it for reading waits for ever.
  std::string MakeFifo(const std::string& name) const
  {
    EXPECT_EQ(::mkfifo((*this / name).c_str(), 0600), 0);
    return *this / name;
  }

private:
  std::string Path;
};

} // namespace isosurface

#endif
