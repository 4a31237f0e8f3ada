// SPDX-License-Identifier: BSD-3-Clause
// Input: a letter (M: MetaImage, N: NRRD, T: TIFF, I: NIfTI, R: MRC; Z, 3, 5: Zarr 2 and 3 and N5,
// whose metadata end with a zero byte, before a chunk), then the file, with or without samples behind
// its header. What it names is the file itself or is missing. Samples are read if they are few.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "VolumeFile/VolumeFile.h"

#include <algorithm>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr std::uint64_t MostSamples = std::uint64_t{ 1 } << 20;
constexpr std::uint64_t MostHeld = std::uint64_t{ 16 } << 20;

/// A type for each component.
std::vector<ValueType> FindTypes(const VolumeFile& volume)
{
  std::vector<ValueType> types;
  for (const ArrayDescription& array : volume.Arrays)
  {
    types.insert(types.end(), static_cast<std::size_t>(array.Components), array.Type);
  }
  return types;
}

const char* FindExtension(char letter)
{
  switch (letter)
  {
    case 'M':
      return ".mha";
    case 'N':
      return ".nrrd";
    case 'I':
      return ".nii";
    case 'R':
      return ".mrc";
    case 'Z':
    case '3':
    case '5':
      return ".zarr";
    default:
      return ".tif";
  }
}

/// A folder with metadata and the first chunk.
void PutZarr(MemoryDisk& disk, const std::string& folder, char version, const std::uint8_t* begin,
  const std::uint8_t* end)
{
  const std::uint8_t* const zero = std::find(begin, end, std::uint8_t{ 0 });
  const SealedBytes metadata(begin, zero);
  const SealedBytes chunk(zero == end ? end : zero + 1, end);
  const bool isSecond = version == 'Z';
  const bool isThird = version == '3';
  PutFile(disk,
    folder +
      (isSecond     ? "/.zarray"
          : isThird ? "/zarr.json"
                    : "/attributes.json"),
    metadata);
  PutFile(disk, folder + (isSecond ? "/0.0.0" : isThird ? "/c/0/0/0" : "/0/0/0"), chunk);
}

void OpenAndRead(MemoryDisk& disk, const std::string& path)
{
  const auto volume = VolumeFile::Open(disk, path);
  if (!volume.IsOk())
  {
    // It may be another file, which the header names.
    Require(volume.GetStatus().GetMessage().find('/') == 0, "an error names the file");
    return;
  }
  SlabSource& source = *volume->Source;
  const VertexBox& box = source.GetBox();
  Require(box.GetSize() == volume->Grid.GetDimensions(), "a source has the samples of its grid");
  Require(!box.IsEmpty(), "a volume has samples");
  // A product of three may wrap.
  const Index3 size = box.GetSize();
  if (size[0] <= 256 && size[1] <= 256 && source.GetHeldBytes() <= MostHeld)
  {
    VertexBox slice = box;
    slice.High[2] = slice.Low[2] + 1;
    if (source.GetReadBytes(slice) > 8 * MostSamples)
    {
      return;
    }
    const auto slab = source.Read(slice);
    Require(!slab.IsOk() || slab->Fits(FindTypes(*volume), slice), "a slab has what was asked for");
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < 1)
  {
    return 0;
  }
  const std::string path = std::string("/data/a") + FindExtension(static_cast<char>(bytes[0]));
  MemoryDisk disk;
  if (path == "/data/a.zarr")
  {
    PutZarr(disk, path, static_cast<char>(bytes[0]), bytes + 1, bytes + size);
  }
  else
  {
    PutFile(disk, path, SealedBytes(bytes + 1, bytes + size));
  }
  // Series of as many names as a header may make, and the tables of libtiff's codecs.
  const MemoryLimit limit(std::size_t{ 512 } << 20);
  OpenAndRead(disk, path);
  return 0;
}
