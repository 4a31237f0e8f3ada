// SPDX-License-Identifier: BSD-3-Clause
// Input: a letter (D: as it is; Z: bytes that are deflated first, behind the header that says so), then
// a DICOM file, or its elements behind that header.
#include "Fixtures/DicomBytes.h"
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Formats/Dicom/DicomCompression.h"
#include "Formats/Dicom/DicomDataSet.h"

#include <zlib.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

constexpr const char* Path = "/data/a.dcm";
constexpr std::uint64_t MostPixels = std::uint64_t{ 1 } << 20;
constexpr double MostCoded = 1 << 16;

SealedBytes DeflateElements(const std::uint8_t* bytes, std::size_t size)
{
  SealedBytes file = DicomBytes().PutStart("1.2.840.10008.1.2.1.99").Get();
  z_stream stream = {};
  Require(deflateInit2(&stream, 1, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) == Z_OK, "zlib works");
  const std::size_t before = file.size();
  const std::size_t most = deflateBound(&stream, size) + 64;
  file.resize(before + most);
  stream.next_in = const_cast<std::uint8_t*>(bytes);
  stream.avail_in = static_cast<uInt>(size);
  stream.next_out = file.data() + before;
  stream.avail_out = static_cast<uInt>(most);
  Require(deflate(&stream, Z_FINISH) == Z_STREAM_END, "zlib works");
  file.resize(file.size() - stream.avail_out);
  deflateEnd(&stream);
  return file;
}

void RequireNamed(const Status& status)
{
  Require(status.IsOk() || status.GetMessage().find(std::string(Path) + ": ") == 0,
    "an error names the file");
}

/// What is done to compressed images before GDCM gets them.
void Decompress(const DicomDataSet& tags, const std::vector<std::uint8_t>& pixels)
{
  static_cast<void>(FindCompressedForm(pixels.data(), pixels.size()));
  const double count = tags.GetNumber(0x00280010, 0) * tags.GetNumber(0x00280011, 0);
  const double bits = tags.GetNumber(0x00280100, 0);
  if (count >= 1 && count <= MostCoded && (bits == 8 || bits == 16 || bits == 32))
  {
    std::vector<std::uint8_t> samples;
    const auto size = static_cast<std::size_t>(bits) / 8;
    const bool isDecoded = DecodeRunLengths(pixels, static_cast<std::size_t>(count), size, samples);
    Require(!isDecoded || samples.size() == static_cast<std::size_t>(count) * size,
      "run lengths are all samples");
  }
}

void ReadAll(DicomDataSet& tags, std::uint64_t size)
{
  const Status header = tags.ReadHeader();
  RequireNamed(header);
  for (const DicomTag tag : { 0x00020010u, 0x0008103eu, 0x00280010u, 0x00281052u })
  {
    // A number of two bytes takes up to eight characters.
    Require(tags.GetText(tag).size() <= 8192, "a value is short");
    static_cast<void>(tags.GetNumber(tag, 0));
    static_cast<void>(tags.GetNumbers(tag, 3));
  }
  if (header.IsOk())
  {
    std::vector<std::uint8_t> pixels;
    RequireNamed(tags.AppendPixels(std::min(tags.GetPixelSize(), MostPixels), pixels));
    Require(pixels.size() <= std::max(size, MostPixels), "pixels are in the file");
    Decompress(tags, pixels);
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  if (size < 1)
  {
    return 0;
  }
  MemoryDisk disk;
  PutFile(disk, Path,
    bytes[0] == 'Z' ? DeflateElements(bytes + 1, size - 1) : SealedBytes(bytes + 1, bytes + size));
  const auto file = disk.OpenForReading(Path);
  Require(file.IsOk(), "a file is there");
  // Values, windows, and the pixels of a vector that grows.
  const MemoryLimit limit((std::size_t{ 4 } << 20) + 3 * size);
  DicomDataSet tags(**file);
  ReadAll(tags, size);
  return 0;
}
