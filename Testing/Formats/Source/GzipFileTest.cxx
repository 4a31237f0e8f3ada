// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Formats/Source/GzipFile.h"

using namespace isosurface;

namespace
{

/// Bytes that can be compressed, but do not repeat.
Bytes MakeContent(std::size_t size)
{
  std::mt19937 random(5);
  Bytes bytes(size);
  for (std::size_t at = 0; at < size; ++at)
  {
    bytes[at] = static_cast<std::uint8_t>(at / 1000 + random() % 16);
  }
  return bytes;
}

std::unique_ptr<GzipFile> OpenGzip(
  MemoryDisk& disk, const Bytes& compressed, std::size_t size, std::uint64_t begin = 0)
{
  WriteFile(disk, "/data/a.gz", compressed);
  return std::make_unique<GzipFile>(std::move(*disk.OpenForReading("/data/a.gz")), begin, size);
}

} // namespace

TEST(GzipFile, ReadsAnyPartInAnyOrder)
{
  const Bytes content = MakeContent(18000000);
  Bytes prefixed = MakeBytes("header\n");
  const Bytes compressed = Deflate(content);
  prefixed.insert(prefixed.end(), compressed.begin(), compressed.end());
  MemoryDisk disk;
  const auto file = OpenGzip(disk, prefixed, content.size(), 7);
  EXPECT_LT(GzipFile::GetHeldBytes(content.size()), 2000000u);
  std::mt19937 random(1);
  for (int turn = 0; turn < 40; ++turn)
  {
    const std::size_t size = 1 + random() % 100000;
    const std::size_t offset =
      turn == 0 ? content.size() - size : random() % (content.size() - size);
    Bytes bytes(size);
    ASSERT_TRUE(file->Read(offset, size, bytes.data()).IsOk());
    EXPECT_TRUE(std::equal(
      bytes.begin(), bytes.end(), content.begin() + static_cast<std::ptrdiff_t>(offset)));
  }
}

TEST(GzipFile, DoesNotInflateFromTheBeginningForEveryRead)
{
  const Bytes content = MakeContent(60000000);
  const Bytes compressed = Deflate(content);
  MemoryDisk disk;
  const auto file = OpenGzip(disk, compressed, content.size());
  std::uint8_t byte = 0;
  ASSERT_TRUE(file->Read(content.size() - 1, 1, &byte).IsOk());
  const std::uint64_t once = disk.GetBytesRead(".gz");
  for (const std::size_t offset : { 55000000u, 40000000u, 58000000u, 20000000u, 50000000u })
  {
    ASSERT_TRUE(file->Read(offset, 1, &byte).IsOk());
    EXPECT_EQ(byte, content[offset]);
  }
  EXPECT_LT(disk.GetBytesRead(".gz"), 2 * once);
}

TEST(GzipFile, ReadsSeveralMembersAndZlibStreams)
{
  const Bytes content = MakeContent(12000000);
  Bytes members;
  for (std::size_t begin = 0; begin < content.size(); begin += 4000000)
  {
    const auto from = content.begin() + static_cast<std::ptrdiff_t>(begin);
    const Bytes member = Deflate(Bytes(from, from + 4000000));
    members.insert(members.end(), member.begin(), member.end());
  }
  for (const Bytes& compressed : { members, Deflate(content, 15) })
  {
    MemoryDisk disk;
    const auto file = OpenGzip(disk, compressed, content.size());
    Bytes bytes(content.size());
    ASSERT_TRUE(file->Read(0, bytes.size(), bytes.data()).IsOk());
    EXPECT_TRUE(bytes == content);
    for (const std::size_t offset : { 0u, 5000000u, 7999990u, 4300000u })
    {
      Bytes part(1000);
      ASSERT_TRUE(file->Read(offset, part.size(), part.data()).IsOk());
      EXPECT_TRUE(std::equal(
        part.begin(), part.end(), content.begin() + static_cast<std::ptrdiff_t>(offset)));
    }
  }
}

TEST(GzipFile, EmptyMembersAreReadOnce)
{
  const Bytes empty = Deflate({});
  Bytes members;
  for (int member = 0; member < 20000; ++member)
  {
    members.insert(members.end(), empty.begin(), empty.end());
  }
  const Bytes last = Deflate({ 7 });
  members.insert(members.end(), last.begin(), last.end());
  MemoryDisk disk;
  const auto file = OpenGzip(disk, members, 1);
  std::uint8_t byte = 0;
  ASSERT_TRUE(file->Read(0, 1, &byte).IsOk());
  EXPECT_EQ(byte, 7);
  EXPECT_LE(disk.GetBytesRead(".gz"), members.size());
}

TEST(GzipFile, DamagedAndTruncatedFilesAreErrorsThatNameTheFile)
{
  const Bytes content = MakeContent(3000000);
  const Bytes compressed = Deflate(content);
  Bytes bytes(content.size());
  for (std::size_t size : { std::size_t{ 0 }, std::size_t{ 5 }, compressed.size() / 2 })
  {
    MemoryDisk disk;
    const auto file = OpenGzip(disk,
      Bytes(compressed.begin(), compressed.begin() + static_cast<std::ptrdiff_t>(size)),
      content.size());
    for (int twice = 0; twice < 2; ++twice)
    {
      const Status status = file->Read(0, bytes.size(), bytes.data());
      ExpectError(status, StatusCode::Corrupt, "/data/a.gz: truncated");
    }
  }
  // A byte is changed in the middle, or in the checksum at the end.
  for (const std::size_t at : { compressed.size() / 2, compressed.size() - 6 })
  {
    Bytes damaged = compressed;
    damaged[at] ^= 0x55;
    MemoryDisk disk;
    const auto file = OpenGzip(disk, damaged, content.size());
    EXPECT_EQ(file->Read(0, bytes.size(), bytes.data()).GetCode(), StatusCode::Corrupt);
  }
  MemoryDisk plain;
  EXPECT_FALSE(OpenGzip(plain, content, 100)->Read(0, 100, bytes.data()).IsOk());
}
