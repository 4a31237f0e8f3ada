// SPDX-License-Identifier: BSD-3-Clause
#include "TiffOnDisk.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/Coding.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <sys/resource.h>

using namespace isosurface;

namespace
{

template <typename T>
void ExpectType(const ScratchFolder& folder)
{
  const auto volume = MakeRamp<T>({ 21, 18, 4 });
  for (const char* mode : { "wl", "wb", "w8b" })
  {
    WriteStack(folder / "a.tif", volume, { mode });
    ExpectStack(folder / "a.tif", volume);
    WriteStack(folder / "b.tif", volume, { mode, COMPRESSION_LZW });
    ExpectStack(folder / "b.tif", volume);
  }
}

void ExpectRefused(const std::string& path, const std::string& file, const std::string& reason)
{
  const auto volume = OpenForeignVolume(GetLocalFileSystem(), path);
  ASSERT_FALSE(volume.IsOk());
  const std::string& message = volume.GetStatus().GetMessage();
  EXPECT_EQ(message.find(file + ": "), 0u) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

/// A number in a directory of a TIFF file.
struct Entry
{
  std::uint16_t Tag;
  std::uint32_t Value;
};

/// A TIFF file with one page of unsigned integers, whose samples stand at the end.
Bytes MakeTiff(std::vector<Entry> entries, const std::string& description, const Bytes& samples)
{
  const std::string text = description + std::string(8, '\0');
  const auto count = static_cast<std::uint32_t>(entries.size() + 3);
  const std::uint32_t begin = 8 + 2 + 12 * count + 4;
  entries.push_back({ TIFFTAG_IMAGEDESCRIPTION, begin });
  entries.push_back({ TIFFTAG_STRIPOFFSETS, begin + static_cast<std::uint32_t>(text.size()) });
  entries.push_back({ TIFFTAG_STRIPBYTECOUNTS, static_cast<std::uint32_t>(samples.size()) });
  std::sort(
    entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.Tag < b.Tag; });
  Bytes bytes = { 'I', 'I', 42, 0, 8, 0, 0, 0 };
  AppendLittleEndian(bytes, static_cast<std::uint16_t>(count));
  for (const Entry& entry : entries)
  {
    const bool isText = entry.Tag == TIFFTAG_IMAGEDESCRIPTION;
    AppendLittleEndian(bytes, entry.Tag);
    AppendLittleEndian(bytes, static_cast<std::uint16_t>(isText ? TIFF_ASCII : TIFF_LONG));
    AppendLittleEndian(bytes, isText ? static_cast<std::uint32_t>(text.size()) : 1u);
    AppendLittleEndian(bytes, entry.Value);
  }
  AppendLittleEndian(bytes, std::uint32_t{ 0 });
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.insert(bytes.end(), samples.begin(), samples.end());
  return bytes;
}

/// The entries of a page.
std::vector<Entry> MakeEntries(std::uint32_t width, std::uint32_t height, std::uint32_t bits,
  std::uint32_t rowsPerStrip, std::uint32_t compression = COMPRESSION_NONE)
{
  return { { TIFFTAG_IMAGEWIDTH, width }, { TIFFTAG_IMAGELENGTH, height },
    { TIFFTAG_BITSPERSAMPLE, bits }, { TIFFTAG_COMPRESSION, compression },
    { TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK }, { TIFFTAG_ROWSPERSTRIP, rowsPerStrip } };
}

void ExpectRefused(const Bytes& bytes, StatusCode code, const std::string& reason)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a.tif", bytes);
  const auto volume = OpenForeignVolume(disk, "/data/a.tif");
  ASSERT_FALSE(volume.IsOk());
  EXPECT_EQ(volume.GetStatus().GetCode(), code);
  EXPECT_EQ(volume.GetStatus().GetMessage(), "/data/a.tif: page 1: " + reason);
}

} // namespace

TEST(TiffVolume, ReadsEveryTypeInBothByteOrders)
{
  const ScratchFolder folder;
  ExpectType<std::int8_t>(folder);
  ExpectType<std::uint8_t>(folder);
  ExpectType<std::int16_t>(folder);
  ExpectType<std::uint16_t>(folder);
  ExpectType<std::int32_t>(folder);
  ExpectType<std::uint32_t>(folder);
  ExpectType<std::int64_t>(folder);
  ExpectType<float>(folder);
  ExpectType<double>(folder);
}

TEST(TiffVolume, ReadsStripsAndTilesOfEveryCompression)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint16_t>({ 37, 29, 5 });
  for (const std::uint16_t compression :
    { COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS })
  {
    for (const TiffLayout& layout :
      { TiffLayout{ "w", compression, 1 }, TiffLayout{ "w", compression, 7 },
        TiffLayout{ "w", compression, 29 }, TiffLayout{ "w", compression, 0xffffffff },
        TiffLayout{ "w", compression, 1, 16 }, TiffLayout{ "wb", compression, 1, 48 } })
    {
      WriteStack(folder / "a.tif", volume, layout);
      ExpectStack(folder / "a.tif", volume);
    }
  }
}

TEST(TiffVolume, ChunksAreWholeStripsAndTilesOfAPage)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint16_t>({ 100, 90, 3 });
  const auto findChunk = [&](const TiffLayout& layout)
  {
    WriteStack(folder / "a.tif", volume, layout);
    return Require(OpenForeignVolume(GetLocalFileSystem(), folder / "a.tif")).Source->GetChunk();
  };
  using Chunk = std::optional<Index3>;
  EXPECT_EQ(findChunk({ "w", COMPRESSION_NONE, 90 }), (Chunk{ { 100, 32, 1 } }));
  EXPECT_EQ(findChunk({ "w", COMPRESSION_LZW, 7 }), (Chunk{ { 100, 35, 1 } }));
  EXPECT_EQ(findChunk({ "w", COMPRESSION_LZW, 90 }), (Chunk{ { 100, 90, 1 } }));
  EXPECT_EQ(findChunk({ "w", COMPRESSION_NONE, 1, 48 }), (Chunk{ { 48, 48, 1 } }));
  EXPECT_EQ(findChunk({ "w", COMPRESSION_LZW, 1, 16 }), (Chunk{ { 32, 32, 1 } }));
}

TEST(TiffVolume, ReadsASeriesInTheOrderOfTheNumbers)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint8_t>({ 12, 9, 12 });
  for (std::int64_t k = 0; k < 12; ++k)
  {
    // 8, 9, 10, ...: alphabetically, 10 would be before 8.
    const std::string name = "a b" + std::to_string(k + 8) + ".TIF";
    WriteStack(folder / name, volume, {}, k, k + 1);
  }
  std::ofstream(folder / "notes.txt") << "no slice";
  ExpectStack(folder / "", volume);
  ExpectStack(folder / "a*.TIF", volume);
  ExpectStack(folder / "*b*", volume);
  std::filesystem::rename(folder / "a b11.TIF", folder / "elsewhere");
  ExpectRefused(folder / "a*.TIF", folder / "a b12.TIF", "missing");
  ExpectRefused(folder / "c*.TIF", folder / "c*.TIF", "no files of this name");
  const auto part = MakeRamp<std::uint8_t>({ 12, 9, 2 });
  WriteStack(folder / "x1.tif", part);
  WriteStack(folder / "x2.tif", part);
  const auto both = Require(OpenForeignVolume(GetLocalFileSystem(), folder / "x?.tif"));
  EXPECT_EQ(both.Grid.GetDimensions(), (Index3{ 12, 9, 4 }));
}

TEST(TiffVolume, AStripOfFewerBytesThanItsRowsIsAnError)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint8_t>({ 12, 20, 1 });
  TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "w");
  SetFormat<std::uint8_t>(tiff, volume.GetDimensions(), {});
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
  Bytes samples(60);
  for (std::uint32_t strip = 0; strip < 4; ++strip)
  {
    TIFFWriteEncodedStrip(tiff, strip, samples.data(), strip == 2 ? 59 : 60);
  }
  TIFFClose(tiff);
  auto file = Require(OpenForeignVolume(GetLocalFileSystem(), folder / "a.tif"));
  EXPECT_TRUE(file.Source->Read({ { 0, 0, 0 }, { 12, 14, 1 } }).IsOk());
  EXPECT_TRUE(file.Source->Read({ { 0, 15, 0 }, { 12, 20, 1 } }).IsOk());
  const Status status = file.Source->Read(file.Source->GetBox()).GetStatus();
  EXPECT_EQ(status.GetCode(), StatusCode::Corrupt);
  EXPECT_EQ(status.GetMessage(),
    folder / "a.tif" + ": page 1: the strip of row 10 is truncated: it has 59 bytes");
}

TEST(TiffVolume, PagesOfDifferentFormatsAreAnError)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint8_t>({ 12, 9, 3 });
  const auto wide = MakeRamp<std::uint8_t>({ 13, 9, 3 });
  const auto deep = MakeRamp<std::uint16_t>({ 12, 9, 3 });
  TIFF* tiff = TIFFOpen((folder / "wide.tif").c_str(), "w");
  WritePage(tiff, volume, 0, {});
  TIFFWriteDirectory(tiff);
  WritePage(tiff, wide, 0, {});
  TIFFClose(tiff);
  ExpectRefused(folder / "wide.tif", folder / "wide.tif", "page 2: its size or type differs");
  tiff = TIFFOpen((folder / "order.tif").c_str(), "w");
  for (const std::uint16_t number : { 0, 2, 1 })
  {
    WritePage(tiff, volume, number, {});
    TIFFSetField(tiff, TIFFTAG_PAGENUMBER, number, std::uint16_t{ 3 });
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
  ExpectRefused(folder / "order.tif", folder / "order.tif", "page 3: its page number is 1");
  WriteStack(folder / "s1.tif", volume, {}, 0, 1);
  WriteStack(folder / "s2.tif", deep, {}, 0, 1);
  ExpectRefused(folder / "s?.tif", folder / "s2.tif", "differs");
}

TEST(TiffVolume, ErrorsNameWhatIsNotSupported)
{
  const ScratchFolder folder;
  std::ofstream(folder / "text.tif") << "not an image";
  ExpectRefused(folder / "text.tif", folder / "text.tif", "not a TIFF file");
  std::ofstream(folder / "start.tif") << std::string("II*\0directories", 15);
  ExpectRefused(
    folder / "start.tif", folder / "start.tif", "start.tif: not a TIFF file: Can not read");
  ExpectRefused(folder / "none.tif", folder / "none.tif", "cannot open");
  ExpectRefused(
    folder / "none.xyz", folder / "none.xyz", "of none of these: MetaImage, NRRD, NIfTI, ");
}

TEST(TiffVolume, AFileHasAtMostAMillionPages)
{
  const std::size_t most = std::size_t{ 1 } << 20;
  for (const std::size_t images : { most, most + 1 })
  {
    const std::string text = "ImageJ=1.53t\nimages=" + std::to_string(images) + "\n";
    const Bytes bytes = MakeTiff(MakeEntries(1, 1, 8, 1), text, Bytes(images));
    MemoryDisk disk;
    WriteFile(disk, "/data/a.tif", bytes);
    EXPECT_EQ(OpenForeignVolume(disk, "/data/a.tif").IsOk(), images == most);
  }
  ExpectRefused(
    MakeTiff(MakeEntries(1, 1, 8, 1), "ImageJ=1.53t\nimages=1048577\n", Bytes(most + 1)),
    StatusCode::Unsupported,
    "its description speaks of 1048577 images; at most 1048576 pages are supported");
}

TEST(TiffVolume, SizesThatWrapAreRefused)
{
  ExpectRefused(MakeTiff(MakeEntries(1u << 31, (1u << 30) + 1, 64, 1), "", Bytes(100)),
    StatusCode::Corrupt, "its width or height is impossible");
}

TEST(TiffVolume, AStripThatIsNotThereTakesNoMemory)
{
  const auto findPeak = []
  {
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss; // KiB
  };
  const std::uint32_t rows = 1u << 28;
  auto bytes = MakeTiff(MakeEntries(1, rows, 8, rows, COMPRESSION_PACKBITS), "", Bytes(100));
  bytes.resize(bytes.size() - 50);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.tif", bytes);
  auto volume = Require(OpenForeignVolume(disk, "/data/a.tif"));
  const auto before = findPeak();
  const auto slab = volume.Source->Read({ { 0, 0, 0 }, { 1, 1, 1 } });
  EXPECT_EQ(slab.GetStatus().GetCode(), StatusCode::Corrupt);
  EXPECT_LT(findPeak() - before, 64 << 10);
}

TEST(TiffVolume, OnlyKnownCompressionsAreRead)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint8_t>({ 37, 29, 2 });
  for (const int compression :
    { COMPRESSION_DEFLATE, COMPRESSION_ZSTD, COMPRESSION_LZMA, COMPRESSION_ADOBE_DEFLATE })
  {
    if (TIFFIsCODECConfigured(static_cast<std::uint16_t>(compression)) != 0)
    {
      WriteStack(folder / "a.tif", volume, { "w", static_cast<std::uint16_t>(compression), 7 });
      ExpectStack(folder / "a.tif", volume);
    }
  }
  const std::pair<int, const char*> refused[] = { { COMPRESSION_PIXARLOG, "32909, PixarLog" },
    { COMPRESSION_SGILOG, "34676, SGILog" }, { COMPRESSION_SGILOG24, "34677, SGILog" },
    { COMPRESSION_THUNDERSCAN, "32809, ThunderScan" }, { COMPRESSION_OJPEG, "6, old JPEG" },
    { COMPRESSION_JBIG, "34661, JBIG" }, { COMPRESSION_LERC, "34887, LERC" },
    { COMPRESSION_WEBP, "50001, WebP" }, { COMPRESSION_CCITTFAX4, "4" } };
  for (const auto& [compression, name] : refused)
  {
    ExpectRefused(
      MakeTiff(MakeEntries(8, 8, 8, 8, static_cast<std::uint32_t>(compression)), "", Bytes(100)),
      StatusCode::Unsupported, "its compression (" + std::string(name) + ") is not supported");
  }
}

TEST(TiffVolume, ReadsSamplesThatJpegCompresses)
{
  if (TIFFIsCODECConfigured(COMPRESSION_JPEG) == 0)
  {
    GTEST_SKIP();
  }
  const ScratchFolder folder;
  auto volume = MakeRamp<std::uint8_t>({ 32, 32, 2 });
  std::fill(volume.Samples.begin(), volume.Samples.end(), std::uint8_t{ 77 }); // without a loss
  WriteStack(folder / "a.tif", volume, { "w", COMPRESSION_JPEG, 16 });
  ExpectStack(folder / "a.tif", volume);
}

TEST(TiffVolume, DamagedFilesGiveErrorsOrSamples)
{
  const ScratchFolder folder;
  const auto volume = MakeRamp<std::uint16_t>({ 21, 18, 3 });
  std::mt19937 random(7);
  int refused = 0;
  for (const TiffLayout& layout : { TiffLayout{ "w", COMPRESSION_NONE, 4 },
         TiffLayout{ "w", COMPRESSION_LZW, 18 }, TiffLayout{ "w8", COMPRESSION_ADOBE_DEFLATE, 5 },
         TiffLayout{ "w", COMPRESSION_NONE, 1, 16 } })
  {
    WriteStack(folder / "a.tif", volume, layout);
    const Bytes good = ReadBytes(folder / "a.tif");
    for (int turn = 0; turn < 200; ++turn)
    {
      Bytes bad = good;
      for (int change = 0; change < 1 + turn % 3; ++change)
      {
        bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
      }
      bad.resize(turn % 4 == 3 ? random() % bad.size() : bad.size());
      MemoryDisk disk;
      WriteFile(disk, "/data/a.tif", bad);
      auto file = OpenForeignVolume(disk, "/data/a.tif");
      Status status = file.GetStatus();
      if (file.IsOk() && file->Source->GetReadBytes(file->Source->GetBox()) < 10000000)
      {
        status = file->Source->Read(file->Source->GetBox()).GetStatus();
      }
      EXPECT_TRUE(status.IsOk() || status.GetMessage().find("/data/a.tif: ") == 0)
        << status.GetMessage();
      refused += status.IsOk() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 200);
}
