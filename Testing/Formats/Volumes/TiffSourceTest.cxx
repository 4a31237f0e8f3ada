// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Tiff/TiffSource.h"
#include "Ground/Base/Coding.h"

#include <tiffio.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

struct TiffLayout
{
  const char* Mode = "w"; ///< of TIFFOpen: byte order, BigTIFF
  std::uint16_t Compression = COMPRESSION_NONE;
  std::uint32_t RowsPerStrip = 3;
  std::uint32_t Tile = 0; ///< instead of strips
};

/// A folder that is removed at the end of the test.
class Folder
{
public:
  Folder()
    : Path(testing::TempDir() + "TiffSource-" +
        testing::UnitTest::GetInstance()->current_test_info()->name() + "-" +
        std::to_string(::getpid()))
  {
    std::filesystem::remove_all(this->Path);
    std::filesystem::create_directories(this->Path);
  }
  ~Folder() { std::filesystem::remove_all(this->Path); }
  std::string operator/(const std::string& name) const { return this->Path + "/" + name; }

private:
  std::string Path;
};

template <typename T>
void SetFormat(TIFF* tiff, const Index3& size, const TiffLayout& layout)
{
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(size[0]));
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(size[1]));
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(T)));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, static_cast<int>(layout.Compression));
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
    std::is_floating_point_v<T> ? SAMPLEFORMAT_IEEEFP
      : std::is_signed_v<T>     ? SAMPLEFORMAT_INT
                                : SAMPLEFORMAT_UINT);
}

/// Writes a page: slice k of a volume.
template <typename T>
void WritePage(TIFF* tiff, const SampleVolume<T>& volume, std::int64_t k, const TiffLayout& layout)
{
  SetFormat<T>(tiff, volume.GetDimensions(), layout);
  const auto width = static_cast<std::size_t>(volume.GetDimensions()[0]);
  if (layout.Tile == 0)
  {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, layout.RowsPerStrip);
    std::vector<T> row(width);
    for (std::int64_t j = 0; j < volume.GetDimensions()[1]; ++j)
    {
      for (std::int64_t i = 0; i < volume.GetDimensions()[0]; ++i)
      {
        row[static_cast<std::size_t>(i)] = volume.At(i, j, k);
      }
      ASSERT_EQ(TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(j), 0), 1);
    }
  }
  else
  {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, layout.Tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, layout.Tile);
    const std::int64_t edge = layout.Tile;
    for (std::int64_t y = 0; y < volume.GetDimensions()[1]; y += edge)
    {
      for (std::int64_t x = 0; x < volume.GetDimensions()[0]; x += edge)
      {
        std::vector<T> tile(static_cast<std::size_t>(edge * edge));
        for (std::int64_t j = y; j < std::min(y + edge, volume.GetDimensions()[1]); ++j)
        {
          for (std::int64_t i = x; i < std::min(x + edge, volume.GetDimensions()[0]); ++i)
          {
            tile[static_cast<std::size_t>((j - y) * edge + i - x)] = volume.At(i, j, k);
          }
        }
        ASSERT_GT(TIFFWriteTile(tiff, tile.data(), static_cast<std::uint32_t>(x),
                    static_cast<std::uint32_t>(y), 0, 0),
          0);
      }
    }
  }
}

template <typename T>
void WriteStack(const std::string& path, const SampleVolume<T>& volume, const TiffLayout& layout,
  std::int64_t first, std::int64_t end)
{
  TIFF* tiff = TIFFOpen(path.c_str(), layout.Mode);
  ASSERT_NE(tiff, nullptr);
  for (std::int64_t k = first; k < end; ++k)
  {
    WritePage(tiff, volume, k, layout);
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
}

template <typename T>
void WriteStack(
  const std::string& path, const SampleVolume<T>& volume, const TiffLayout& layout = {})
{
  WriteStack(path, volume, layout, 0, volume.GetDimensions()[2]);
}

template <typename T>
void ExpectStack(const std::string& path, const SampleVolume<T>& volume)
{
  auto file = Require(OpenForeignVolume(GetLocalFileSystem(), path));
  EXPECT_EQ(file.Grid.GetDimensions(), volume.GetDimensions());
  EXPECT_EQ(file.Arrays[0].Type, ValueTypeOf<T>::Value);
  ExpectSamples(*file.Source, volume);
}

template <typename T>
void ExpectType(const Folder& folder)
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

Bytes ReadBytes(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return Bytes{ std::istreambuf_iterator<char>(file), {} };
}

} // namespace

TEST(TiffSource, ReadsEveryTypeInBothByteOrders)
{
  const Folder folder;
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

TEST(TiffSource, ReadsStripsAndTilesOfEveryCompression)
{
  const Folder folder;
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

TEST(TiffSource, ChunksAreWholeStripsAndTilesOfAPage)
{
  const Folder folder;
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

TEST(TiffSource, ReadsASeriesInTheOrderOfTheNumbers)
{
  const Folder folder;
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
  ExpectRefused(folder / "c*.TIF", folder / "c*.TIF", "no TIFF files");
  const auto part = MakeRamp<std::uint8_t>({ 12, 9, 2 });
  WriteStack(folder / "x1.tif", part);
  WriteStack(folder / "x2.tif", part);
  const auto both = Require(OpenForeignVolume(GetLocalFileSystem(), folder / "x?.tif"));
  EXPECT_EQ(both.Grid.GetDimensions(), (Index3{ 12, 9, 4 }));
}

TEST(TiffSource, ReadsTheFormatOfImageJBeyondFourGibibytes)
{
  const Folder folder;
  const auto volume = MakeRamp<std::uint16_t>({ 12, 9, 6 });
  TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "wb");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, "ImageJ=1.53t\nimages=6\nslices=6\nloop=false\n");
  WritePage(tiff, volume, 0, { "wb", COMPRESSION_NONE, 9 });
  TIFFWriteDirectory(tiff);
  TIFFClose(tiff);
  // Moves the samples of the first page, which are before the directory, to the end, with all
  // others.
  Bytes bytes = ReadBytes(folder / "a.tif");
  const Bytes samples = MakeBytes(volume, true);
  const auto begin = bytes.size();
  tiff = TIFFOpen((folder / "a.tif").c_str(), "r");
  const auto old = static_cast<std::uint32_t>(TIFFGetStrileOffset(tiff, 0));
  TIFFClose(tiff);
  const auto put = [&](std::uint32_t from, std::uint32_t to)
  {
    const auto bigEndian = [](std::uint32_t n)
    {
      return Bytes{ static_cast<std::uint8_t>(n >> 24), static_cast<std::uint8_t>(n >> 16),
        static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n) };
    };
    const Bytes pattern = { 0x01, 0x11, 0, 4, 0, 0, 0, 1 }; // StripOffsets, LONG, one
    auto entry = std::search(bytes.begin(), bytes.end(), pattern.begin(), pattern.end());
    ASSERT_NE(entry, bytes.end());
    entry += 8;
    const Bytes expected = bigEndian(from);
    ASSERT_TRUE(std::equal(expected.begin(), expected.end(), entry));
    const Bytes changed = bigEndian(to);
    std::copy(changed.begin(), changed.end(), entry);
  };
  put(old, static_cast<std::uint32_t>(begin));
  bytes.insert(bytes.end(), samples.begin(), samples.end());
  std::ofstream(folder / "b.tif", std::ios::binary)
    .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  ExpectStack(folder / "b.tif", volume);
  std::filesystem::resize_file(folder / "b.tif", bytes.size() - 1);
  ExpectRefused(folder / "b.tif", folder / "b.tif", "truncated");
}

TEST(TiffSource, PagesOfDifferentFormatsAreAnError)
{
  const Folder folder;
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

/// Pages, all of which or the first alone have smaller images. Every second page has a slice of the first
/// smaller volume, every fourth one of the second; the smaller images of other pages are not read.
void WritePyramid(const std::string& path, const SampleVolume<std::int16_t>& volume,
  const std::vector<SampleVolume<std::int16_t>>& smaller, const TiffLayout& layout,
  bool isOnAllPages = true)
{
  TIFF* tiff = TIFFOpen(path.c_str(), layout.Mode);
  ASSERT_NE(tiff, nullptr);
  for (std::int64_t page = 0; page < volume.GetDimensions()[2]; ++page)
  {
    std::vector<std::uint64_t> places(smaller.size());
    if (isOnAllPages || page == 0)
    {
      TIFFSetField(tiff, TIFFTAG_SUBIFD, static_cast<int>(places.size()), places.data());
    }
    WritePage(tiff, volume, page, layout);
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
    for (std::size_t level = 0; (isOnAllPages || page == 0) && level < smaller.size(); ++level)
    {
      TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
      const std::int64_t step = std::int64_t{ 2 } << level;
      WritePage(tiff, smaller[level], page % step == 0 ? page / step : 0, layout);
      ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
    }
  }
  TIFFClose(tiff);
}

OpenedVolume OpenLevel(const std::string& path, std::int64_t vertices)
{
  VolumeChoice choice;
  choice.Vertices = vertices;
  return Require(OpenForeignVolume(GetLocalFileSystem(), path, choice));
}

TEST(TiffSource, SmallerImagesOfPagesAreLevelsOfAPyramid)
{
  const Folder folder;
  const auto volume = MakeRamp<std::int16_t>({ 40, 36, 128 });
  const std::vector smaller = { MakeRamp<std::int16_t>({ 20, 18, 64 }),
    MakeRamp<std::int16_t>({ 10, 9, 32 }) };
  const std::string path = folder / "a.tif";
  for (const TiffLayout& layout : { TiffLayout{}, TiffLayout{ "w8b", COMPRESSION_LZW, 0, 16 } })
  {
    WritePyramid(path, volume, smaller, layout);
    ExpectStack(path, volume);
    const OpenedVolume whole = OpenLevel(path, 40 * 36 * 128);
    EXPECT_EQ(whole.Level, 0);
    ExpectSamples(*whole.Source, volume);
    const OpenedVolume first = OpenLevel(path, 40 * 36 * 128 - 1);
    EXPECT_EQ(first.Level, 1);
    EXPECT_EQ(first.Grid.Spacing, (std::array<double, 3>{ 2, 2, 2 }));
    EXPECT_EQ(first.Grid.Origin, (std::array<double, 3>{ 0.5, 0.5, 0 }));
    ExpectSamples(*first.Source, smaller[0]);
    for (const std::int64_t vertices : { 20 * 18 * 64 - 1, 1 })
    {
      const OpenedVolume second = OpenLevel(path, vertices);
      EXPECT_EQ(second.Level, 2);
      EXPECT_EQ(second.Grid.Spacing, (std::array<double, 3>{ 4, 4, 4 }));
      EXPECT_EQ(second.Grid.Origin, (std::array<double, 3>{ 1.5, 1.5, 0 }));
      ExpectSamples(*second.Source, smaller[1]);
    }
  }
  WritePyramid(path, MakeRamp<std::int16_t>({ 40, 36, 8 }), smaller, {});
  const OpenedVolume few = OpenLevel(path, 1);
  EXPECT_EQ(few.Grid.GetDimensions(), (Index3{ 10, 9, 8 }));
  EXPECT_EQ(few.Grid.Spacing, (std::array<double, 3>{ 4, 4, 1 })) << "slices are not thinned out";
  WritePyramid(path, volume, smaller, {}, false);
  const OpenedVolume whole = OpenLevel(path, 1);
  EXPECT_EQ(whole.Level, 0) << "not all pages have smaller images";
  ExpectSamples(*whole.Source, volume);
}

TEST(TiffSource, DamagedSmallerImagesGiveErrorsOrSamples)
{
  const Folder folder;
  const auto volume = MakeRamp<std::int16_t>({ 8, 8, 4 });
  WritePyramid(folder / "a.tif", volume, { MakeRamp<std::int16_t>({ 4, 4, 2 }) }, {});
  const Bytes whole = ReadBytes(folder / "a.tif");
  int levels = 0;
  int pages = 0;
  int refused = 0;
  for (std::size_t byte = 0; byte < whole.size(); ++byte)
  {
    for (const int change : { 1, 128, 255 })
    {
      Bytes damaged = whole;
      damaged[byte] = static_cast<std::uint8_t>(damaged[byte] ^ change);
      MemoryDisk disk;
      WriteFile(disk, "/data/a.tif", damaged);
      VolumeChoice choice;
      choice.Vertices = 1;
      auto opened = OpenForeignVolume(disk, "/data/a.tif", choice);
      Status status = opened.GetStatus();
      if (opened.IsOk() && opened->Source->GetBox().GetNumberOfVertices() < 10000)
      {
        status = opened->Source->Read(opened->Source->GetBox()).GetStatus();
        levels += status.IsOk() && opened->Level == 1 ? 1 : 0;
        pages += status.IsOk() && opened->Level == 0 ? 1 : 0;
      }
      EXPECT_TRUE(status.IsOk() || status.GetMessage().find("/data/a.tif: ") == 0)
        << status.GetMessage();
      refused += status.IsOk() ? 0 : 1;
    }
  }
  EXPECT_GT(levels, 100);
  EXPECT_GT(pages, 100) << "of a pyramid that cannot be read";
  EXPECT_GT(refused, 100);
}

TEST(TiffSource, ThumbnailsAmongThePagesAreLeftOut)
{
  const Folder folder;
  const auto volume = MakeRamp<std::uint8_t>({ 12, 9, 3 });
  TIFF* tiff = TIFFOpen((folder / "a.tif").c_str(), "w");
  for (const std::int64_t page : { 0, 1, 2 })
  {
    WritePage(tiff, volume, page, {});
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
    SetFormat<std::uint8_t>(tiff, { 4, 3, 1 }, {});
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    for (std::uint32_t row = 0; row < 3; ++row)
    {
      std::vector<std::uint8_t> colors(12, 200);
      ASSERT_EQ(TIFFWriteScanline(tiff, colors.data(), row, 0), 1);
    }
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
  ExpectStack(folder / "a.tif", volume);
}

TEST(TiffSource, ErrorsNameWhatIsNotSupported)
{
  const Folder folder;
  TIFF* tiff = TIFFOpen((folder / "rgb.tif").c_str(), "w");
  SetFormat<std::uint8_t>(tiff, { 4, 4, 1 }, {});
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  Bytes row(12);
  for (std::uint32_t j = 0; j < 4; ++j)
  {
    TIFFWriteScanline(tiff, row.data(), j, 0);
  }
  TIFFClose(tiff);
  ExpectRefused(folder / "rgb.tif", folder / "rgb.tif", "3 samples a pixel");
  tiff = TIFFOpen((folder / "bits.tif").c_str(), "w");
  SetFormat<std::uint8_t>(tiff, { 8, 1, 1 }, {});
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  TIFFWriteScanline(tiff, row.data(), 0, 0);
  TIFFClose(tiff);
  ExpectRefused(folder / "bits.tif", folder / "bits.tif", "1 bits");
  std::ofstream(folder / "text.tif") << "not an image";
  ExpectRefused(folder / "text.tif", folder / "text.tif", "not a TIFF file");
  ExpectRefused(folder / "none.tif", folder / "none.tif", "cannot open");
  ExpectRefused(folder / "none.xyz", folder / "none.xyz", "neither MetaImage");
}

TEST(TiffSource, AFileHasAtMostAMillionPages)
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
    StatusCode::Unsupported, "ImageJ wrote 1048577 images; at most 1048576 pages are supported");
}

TEST(TiffSource, SizesThatWrapAreRefused)
{
  ExpectRefused(MakeTiff(MakeEntries(1u << 31, (1u << 30) + 1, 64, 1), "", Bytes(100)),
    StatusCode::Corrupt, "its width or height is impossible");
}

TEST(TiffSource, AStripThatIsNotThereTakesNoMemory)
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

TEST(TiffSource, OnlyKnownCompressionsAreRead)
{
  const Folder folder;
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

TEST(TiffSource, ReadsSamplesThatJpegCompresses)
{
  if (TIFFIsCODECConfigured(COMPRESSION_JPEG) == 0)
  {
    GTEST_SKIP();
  }
  const Folder folder;
  auto volume = MakeRamp<std::uint8_t>({ 32, 32, 2 });
  std::fill(volume.Samples.begin(), volume.Samples.end(), std::uint8_t{ 77 }); // without a loss
  WriteStack(folder / "a.tif", volume, { "w", COMPRESSION_JPEG, 16 });
  ExpectStack(folder / "a.tif", volume);
}

TEST(TiffSource, DamagedFilesGiveErrorsOrSamples)
{
  const Folder folder;
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
