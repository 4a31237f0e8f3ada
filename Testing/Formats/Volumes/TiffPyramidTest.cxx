// SPDX-License-Identifier: BSD-3-Clause
#include "TiffOnDisk.h"

using namespace isosurface;

namespace
{

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

} // namespace

TEST(TiffPyramid, SmallerImagesOfPagesAreLevelsOfAPyramid)
{
  const ScratchFolder folder;
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

TEST(TiffPyramid, DamagedSmallerImagesGiveErrorsOrSamples)
{
  const ScratchFolder folder;
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
