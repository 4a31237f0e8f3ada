// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeDamage.h"

#include "ScratchFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

namespace isosurface
{
namespace
{

using Damage = std::function<void(const std::string&)>;

// The same for a file of the first store.
Damage InStore(const std::string& name, const Damage& damage)
{
  return [=](const std::string& path) { damage(GetFirstStore(path) + "/" + name); };
}

Damage Flip(std::int64_t offset)
{
  return [=](const std::string& path) { FlipBit(path, offset); };
}

Damage CutTo(std::uint64_t size)
{
  return [=](const std::string& path) { Truncate(path, size); };
}

Damage Replace(const std::string& text, const std::string& with)
{
  return [=](const std::string& path)
  {
    std::string bytes = ReadBytes(path);
    const std::size_t at = bytes.find(text);
    ASSERT_NE(at, std::string::npos) << path << " has no " << text;
    WriteBytes(path, bytes.replace(at, text.size(), with));
  };
}

void Remove(const std::string& path)
{
  EXPECT_GT(std::filesystem::remove_all(path), 0u) << path;
}

} // namespace

std::ostream& operator<<(std::ostream& stream, const VolumeDamage& damage)
{
  return stream << damage.Name;
}

std::vector<VolumeDamage> MakeDamages()
{
  const std::string bvol = ".bvol";
  const std::string store = "store-00000";
  const std::string incomplete = "was cut off, or is not a";
  const std::string checksum = "checksum";
  return {
    { "HeaderMissing", Remove, bvol, "No such file" },
    { "HeaderEmpty", CutTo(0), bvol, incomplete },
    { "HeaderTruncated", CutTo(500), bvol, incomplete },
    { "HeaderAltered", Replace("density", "dEnsity"), bvol, checksum },
    { "HeaderOfOtherFormat", Replace("blocked volume", "clocked volume"), bvol, "format" },
    { "HeaderNewer", Replace("\"formatVersion\": 1", "\"formatVersion\": 2"), bvol,
      "format version 2" },
    { "StoreMissing", InStore("", Remove), store, "missing" },
    { "DirectoryMissing", InStore("directory", Remove), store + "/directory", "No such file" },
    { "DirectoryEmpty", InStore("directory", CutTo(0)), store + "/directory", "truncated" },
    { "DirectoryTruncated", InStore("directory", CutTo(4096)), store + "/directory", "" },
    { "DirectoryHeaderAltered", InStore("directory", Flip(33)), store + "/directory", checksum },
    { "DirectoryPageAltered", InStore("directory", Flip(4096 + 20)), store + "/directory",
      checksum },
    { "DirectoryNewer", InStore("directory", Flip(9)), store + "/directory", "newer version" },
    { "TreeMissing", InStore("array-0.tree", Remove), store + "/array-0.tree", "No such file",
      true },
    { "TreeEmpty", InStore("array-0.tree", CutTo(0)), store + "/array-0.tree", "truncated", true },
    { "TreeTruncated", InStore("array-0.tree", CutTo(4096)), store + "/array-0.tree", "", true },
    { "TreeHeaderAltered", InStore("array-0.tree", Flip(40)), store + "/array-0.tree", checksum,
      true },
    { "TreePageAltered", InStore("array-0.tree", Flip(-100)), store + "/array-0.tree", checksum,
      true },
    { "TreeNewer", InStore("array-0.tree", Flip(9)), store + "/array-0.tree", "newer version",
      true },
    { "BlocksMissing", InStore("blocks", Remove), store + "/blocks", "No such file" },
    { "BlocksTruncated", InStore("blocks", CutTo(1000)), store + "/blocks", "1000 bytes" },
    { "BlockAltered", InStore("blocks", Flip(2000)), store + "/blocks", checksum },
  };
}

bool IsOneMessageAbout(const std::vector<std::string>& messages, const VolumeDamage& damage)
{
  return messages.size() == 1 && messages[0].find(damage.File) != std::string::npos &&
    messages[0].find(damage.Reason) != std::string::npos;
}

} // namespace isosurface
