// SPDX-License-Identifier: BSD-3-Clause
// Input: the text of a header, which is read as it is and with the right checksum.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Storage/Store/BlockedVolume.h"

#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/volume.bvol";

/// What a header's reader does before it reads anything else.
void Use(const std::string& text, const BlockedVolumeHeader& header)
{
  const auto again = BlockedVolumeHeader::Parse(header.Format(), Path);
  Require(again.IsOk(), "what was read can be written and read");
  Require(again->Format() == header.Format(), "what was read is written as it was");
  MemoryDisk disk;
  PutFile(disk, Path, SealedBytes(text.begin(), text.end()));
  PutFile(disk, GetStoresFolder(disk, Path) + "/journal", {});
  const auto volume = BlockedVolume::Open(Path, disk);
  Require(volume.IsOk(), "a header and a folder are enough to open a volume");
  for (int level = 0; level < (*volume)->GetNumberOfLevels(); ++level)
  {
    Require((*volume)->EstimateBytes(0, level) > 0, "a volume has samples at each level");
  }
}

void ParseAndUse(const std::string& text)
{
  // The document in memory: the smallest elements have two bytes of text and sixteen in an array
  // that grows by doubling.
  const MemoryLimit limit(64 * text.size() + std::size_t{ 64 } * 1024);
  const auto header = BlockedVolumeHeader::Parse(text, Path);
  if (header.IsOk())
  {
    Use(text, *header);
    return;
  }
  Require(header.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
  Require(header.GetStatus().GetCode() == StatusCode::Corrupt ||
      header.GetStatus().GetCode() == StatusCode::Unsupported,
    "a bad header is Corrupt or Unsupported");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  const std::string text(bytes, bytes + size);
  ParseAndUse(text);
  ParseAndUse(SealJson(text));
  return 0;
}
