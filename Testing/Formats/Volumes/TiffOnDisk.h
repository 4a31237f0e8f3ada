// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_TiffOnDisk_h
#define isosurface_Testing_TiffOnDisk_h

#include "Fixtures/SampleFiles.h"
#include "Fixtures/ScratchFolder.h"

#include "Formats/Opener/ForeignVolume.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <type_traits>
#include <vector>

namespace isosurface
{

/// How libtiff writes the files of tests.
struct TiffLayout
{
  const char* Mode = "w"; ///< of TIFFOpen: byte order, BigTIFF
  std::uint16_t Compression = COMPRESSION_NONE;
  std::uint32_t RowsPerStrip = 3;
  std::uint32_t Tile = 0; ///< instead of strips
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

inline Bytes ReadBytes(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return Bytes{ std::istreambuf_iterator<char>(file), {} };
}

} // namespace isosurface

#endif
