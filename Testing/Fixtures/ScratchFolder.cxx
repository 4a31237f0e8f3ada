// SPDX-License-Identifier: BSD-3-Clause
#include "ScratchFolder.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/FileSystem.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace isosurface
{
namespace
{

std::string NameOfTest()
{
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::replace(name.begin(), name.end(), '/', '-');
  return name;
}

} // namespace

ScratchFolder::ScratchFolder()
  : ScratchFolder(NameOfTest())
{
}

ScratchFolder::ScratchFolder(const std::string& name)
  : Path(std::filesystem::absolute("scratch/" + name).string())
{
  std::filesystem::remove_all(this->Path);
  std::filesystem::create_directories(this->Path);
}

ScratchFolder::~ScratchFolder()
{
  std::error_code ignored;
  std::filesystem::remove_all(this->Path, ignored);
}

void WriteBytes(const std::string& path, const std::string& bytes)
{
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(file.good()) << path;
}

std::string ReadBytes(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

void FlipBit(const std::string& path, std::int64_t offset, int bit)
{
  std::string bytes = ReadBytes(path);
  const std::int64_t size = static_cast<std::int64_t>(bytes.size());
  const std::int64_t at = offset < 0 ? size + offset : offset;
  ASSERT_TRUE(at >= 0 && at < size) << path << " has " << size << " bytes";
  bytes[static_cast<std::size_t>(at)] ^= static_cast<char>(1 << bit);
  WriteBytes(path, bytes);
}

void Truncate(const std::string& path, std::uint64_t size)
{
  ASSERT_LT(size, std::filesystem::file_size(path)) << path;
  std::filesystem::resize_file(path, size);
}

std::string GetFirstStore(const std::string& volumePath, int store)
{
  const std::string stores = GetStoresFolder(GetLocalFileSystem(), volumePath);
  std::vector<std::string> generations;
  for (const auto& entry : std::filesystem::directory_iterator(stores))
  {
    generations.push_back(entry.path().filename().string());
  }
  EXPECT_EQ(generations.size(), 1u) << stores;
  return GetStoreFolder(
    GetLocalFileSystem(), volumePath, generations.at(0), static_cast<std::uint32_t>(store));
}

std::vector<std::string> ListVolumeFiles(const std::string& volumePath)
{
  const std::filesystem::path header(volumePath);
  std::vector<std::string> names;
  const std::string stores = GetStoresFolder(GetLocalFileSystem(), volumePath);
  if (std::filesystem::exists(stores))
  {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(stores))
    {
      if (entry.is_regular_file())
      {
        names.push_back(entry.path().lexically_relative(header.parent_path()).string());
      }
    }
  }
  std::sort(names.begin(), names.end());
  names.insert(names.begin(), header.filename().string());
  return names;
}

std::uint64_t ComputeFingerprint(const std::string& volumePath)
{
  const std::string folder = std::filesystem::path(volumePath).parent_path().string();
  std::uint64_t hash = 0;
  for (const std::string& name : ListVolumeFiles(volumePath))
  {
    const std::string bytes = ReadBytes(folder + "/" + name);
    hash = ComputeChecksum(name.data(), name.size(), hash);
    hash = ComputeChecksum(bytes.data(), bytes.size(), hash);
  }
  return hash;
}

void CopyVolume(const std::string& from, const std::string& to)
{
  std::filesystem::copy_file(from, to);
  const std::string stores = GetStoresFolder(GetLocalFileSystem(), from);
  const std::string copy = to + ".stores";
  std::filesystem::copy(stores, stores == from + ".stores" ? copy : HidePath(copy),
    std::filesystem::copy_options::recursive);
}

} // namespace isosurface
