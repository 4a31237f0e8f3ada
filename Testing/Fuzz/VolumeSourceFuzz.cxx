// SPDX-License-Identifier: BSD-3-Clause
// Input: a letter (M: MetaImage, N: NRRD, T: TIFF, I: NIfTI, R: MRC; Z, 3, 5: Zarr 2 and 3 and N5,
// whose metadata end with a zero byte, before a chunk; P, O: OME-Zarr of both versions, whose metadata
// of the image come first), then the file, with or without samples behind its header. What it names is
// the file itself or is missing. Samples are read if they are few; a small letter asks for the second
// time step, without a cache.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Formats/Opener/ForeignVolume.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr std::uint64_t MostSamples = std::uint64_t{ 1 } << 20;
constexpr std::uint64_t MostHeld = std::uint64_t{ 16 } << 20;

/// A type for each component.
std::vector<ValueType> FindTypes(const OpenedVolume& volume)
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
    case 'P':
    case 'O':
      return ".zarr";
    default:
      return ".tif";
  }
}

/// Takes what is before the next zero byte.
SealedBytes TakeText(const std::uint8_t*& begin, const std::uint8_t* end)
{
  const std::uint8_t* const zero = std::find(begin, end, std::uint8_t{ 0 });
  const SealedBytes text(begin, zero);
  begin = zero == end ? end : zero + 1;
  return text;
}

/// A folder with metadata and the first chunk, of arrays of any number of axes.
void PutZarr(MemoryDisk& disk, const std::string& folder, char version, const std::uint8_t* begin,
  const std::uint8_t* end)
{
  const bool isSecond = version == 'Z' || version == 'P';
  const bool isThird = version == '3' || version == 'O';
  std::string array = folder;
  if (version == 'P' || version == 'O')
  {
    PutFile(disk, folder + (isSecond ? "/.zattrs" : "/zarr.json"), TakeText(begin, end));
    array += "/0";
  }
  PutFile(disk,
    array +
      (isSecond     ? "/.zarray"
          : isThird ? "/zarr.json"
                    : "/attributes.json"),
    TakeText(begin, end));
  const SealedBytes chunk(begin, end);
  const std::string separator = isSecond ? "." : "/";
  std::string key = isThird ? "/c/0" : "/0";
  for (int axis = 1; axis < 5; ++axis)
  {
    key += separator + "0";
    if (axis >= 2)
    {
      PutFile(disk, array + key, chunk);
    }
  }
}

void OpenAndRead(MemoryDisk& disk, const std::string& path, const VolumeChoice& choice)
{
  const auto volume = OpenForeignVolume(disk, path, choice);
  if (!volume.IsOk())
  {
    // It may be another file, which the header names.
    Require(volume.GetStatus().GetMessage().find('/') == 0, "an error names the file");
    return;
  }
  BoxSource& source = *volume->Source;
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
  const char letter = static_cast<char>(std::toupper(bytes[0]));
  VolumeChoice choice;
  if (letter != static_cast<char>(bytes[0]))
  {
    choice.Step = 1;
    choice.CacheBytes = 0;
  }
  const std::string path = std::string("/data/a") + FindExtension(letter);
  MemoryDisk disk;
  if (path == "/data/a.zarr")
  {
    PutZarr(disk, path, letter, bytes + 1, bytes + size);
  }
  else
  {
    PutFile(disk, path, SealedBytes(bytes + 1, bytes + size));
  }
  // Series of as many names as a header may make, and the tables of libtiff's codecs.
  const MemoryLimit limit(std::size_t{ 512 } << 20);
  OpenAndRead(disk, path, choice);
  return 0;
}
