// SPDX-License-Identifier: BSD-3-Clause
// Input: the uncompressed size (3 bytes), a number of reads (1 byte, modulo 8), offset and size of each
// (3 bytes each), then a gzip or zlib stream. What is read, in any order, is what zlib inflates from front
// to back.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Formats/Source/GzipFile.h"

#include <zlib.h>

#include <algorithm>
#include <utility>
#include <vector>

using namespace isosurface;

namespace
{

using Bytes = std::vector<std::uint8_t>;

/// Takes up to three bytes, the low one first.
std::size_t TakeNumber(const std::uint8_t*& begin, const std::uint8_t* end)
{
  std::size_t number = 0;
  for (int shift = 0; shift < 24 && begin != end; shift += 8)
  {
    number |= static_cast<std::size_t>(*begin++) << shift;
  }
  return number;
}

/// What zlib inflates of a stream, member after member, up to the first fault or so many bytes. `isSound`:
/// whether it is gzip members, or one zlib stream, that end without a fault.
Bytes Inflate(Bytes stream, std::size_t most, bool& isSound)
{
  Bytes inflated(most);
  z_stream state = {};
  state.next_in = stream.data();
  state.avail_in = static_cast<uInt>(stream.size());
  state.next_out = inflated.data();
  state.avail_out = static_cast<uInt>(most);
  int result = Z_STREAM_END;
  std::size_t members = 0;
  bool isGzip = true;
  while (result == Z_STREAM_END && state.avail_in > 0 && state.avail_out > 0)
  {
    Require(::inflateInit2(&state, 15 + 32) == Z_OK, "zlib has memory");
    isGzip = isGzip && *state.next_in == 0x1f;
    ++members;
    result = ::inflate(&state, Z_FINISH);
    ::inflateEnd(&state);
  }
  isSound = result == Z_STREAM_END && members > 0 && (isGzip || members == 1);
  inflated.resize(most - state.avail_out);
  return inflated;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  const std::uint8_t* const end = bytes + size;
  const std::size_t most = TakeNumber(bytes, end);
  const std::size_t reads = bytes == end ? 0 : *bytes++ % 8;
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  for (std::size_t read = 0; read < reads; ++read)
  {
    const std::size_t offset = TakeNumber(bytes, end);
    ranges.emplace_back(offset, TakeNumber(bytes, end));
  }
  const Bytes stream(bytes, end);
  bool isSound = false;
  const Bytes expected = Inflate(stream, most, isSound);
  MemoryDisk disk;
  PutFile(disk, "/data/a.gz", stream);
  const MemoryLimit limit(
    static_cast<std::size_t>(GzipFile::GetHeldBytes(most)) + (std::size_t{ 17 } << 20));
  const GzipFile file(std::move(*disk.OpenForReading("/data/a.gz")), 0, most);
  for (const auto& [offset, length] : ranges)
  {
    Bytes read(length);
    const Status status = file.Read(offset, length, read.data());
    if (!status.IsOk())
    {
      Require(status.GetMessage().find("/data/a.gz") == 0, "an error names the file");
      Require(!isSound || offset + length > expected.size(), "all of a sound stream can be read");
      continue;
    }
    Require(length <= most && offset <= most - length, "nothing is read beyond the end");
    const std::size_t last = std::min(expected.size(), offset + length);
    Require(offset >= last ||
        std::equal(expected.begin() + static_cast<std::ptrdiff_t>(offset),
          expected.begin() + static_cast<std::ptrdiff_t>(last), read.begin()),
      "what is read in any order is what is inflated in order");
  }
  return 0;
}
