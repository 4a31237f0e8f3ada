// SPDX-License-Identifier: BSD-3-Clause
// Writes blocked volumes into a folder, each beside the samples that it was made from: NAME.bvol,
// and NAME.array-N.raw with the samples of array N as they lie in memory, x fastest.
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Volume/ValueType.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace isosurface
{
namespace
{

struct SampleArray
{
  ArrayDescription Description;
  std::vector<char> Bytes;
};

using Shape = std::function<double(std::int64_t, std::int64_t, std::int64_t)>;

/// Samples of a shape, from about 0 to 1, stretched over the type; floats have some NaN, infinities
/// and negative zeros, integers both ends of their type.
template <typename T>
SampleArray MakeArray(const std::string& name, const Index3& size, const Shape& shape)
{
  std::mt19937 random(static_cast<std::uint32_t>(sizeof(T)));
  std::vector<T> samples;
  for (std::int64_t k = 0; k < size[2]; ++k)
  {
    for (std::int64_t j = 0; j < size[1]; ++j)
    {
      for (std::int64_t i = 0; i < size[0]; ++i)
      {
        using Limits = std::numeric_limits<T>;
        const double value = shape(i, j, k);
        const auto special = random() % 20000;
        if constexpr (std::is_floating_point_v<T>)
        {
          const T specials[] = { Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(),
            T(-0.0), Limits::denorm_min(), Limits::lowest() };
          samples.push_back(special < 6 ? specials[special] : static_cast<T>(200 * value - 90.1));
        }
        else
        {
          const double scale = std::ldexp(0.9, std::min(Limits::digits, 60));
          const T specials[] = { Limits::min(), Limits::max(), static_cast<T>(Limits::max() - 1) };
          samples.push_back(special < 3
              ? specials[special]
              : static_cast<T>(scale * (Limits::is_signed ? 2 * value - 1 : value)));
        }
      }
    }
  }
  const auto* bytes = reinterpret_cast<const char*>(samples.data());
  return { { name, ValueTypeOf<T>::Value },
    std::vector<char>(bytes, bytes + samples.size() * sizeof(T)) };
}

void WriteBytes(const std::string& path, const std::vector<char>& bytes)
{
  std::ofstream(path, std::ios::binary)
    .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

bool WriteVolume(const std::string& path, const GridGeometry& grid,
  const std::vector<SampleArray>& arrays, const BlockedVolumeSettings& settings)
{
  const Index3 size = grid.GetDimensions();
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, size };
  std::vector<ArrayDescription> descriptions;
  for (const SampleArray& array : arrays)
  {
    const std::string raw = path + ".array-" + std::to_string(descriptions.size()) + ".raw";
    if (!settings.InPlace) // whose source is there
    {
      WriteBytes(raw, array.Bytes);
    }
    descriptions.push_back(array.Description);
    piece.Arrays.push_back({ array.Description.Type, array.Bytes.data(),
      { 1, static_cast<std::ptrdiff_t>(size[0]), static_cast<std::ptrdiff_t>(size[0] * size[1]) },
      piece.Box, piece.Box });
  }
  SerialCommunicator alone;
  const auto written =
    BlockedVolumeWriter(alone).Write(path + ".bvol", grid, descriptions, piece, settings);
  if (!written.IsOk())
  {
    std::fprintf(stderr, "%s\n", written.GetStatus().GetMessage().c_str());
  }
  return written.IsOk();
}

GridGeometry MakeGrid(const Index3& low, const Index3& size)
{
  GridGeometry grid;
  grid.Origin = { -0.1, 1e22, 5.3165205877497296e+16 }; // numbers that are hard to print
  grid.Spacing = { 0.30000000000000004, 1.25e-9, 1 };
  grid.Direction = { 0, -1, 0, 1, 0, 0, 0, 0, 1 };
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    grid.Extent[2 * axis] = low[axis];
    grid.Extent[2 * axis + 1] = low[axis] + size[axis] - 1;
  }
  return grid;
}

double MakeWaves(std::int64_t i, std::int64_t j, std::int64_t k)
{
  return 0.5 +
    0.45 * std::sin(0.11 * static_cast<double>(i)) * std::cos(0.07 * static_cast<double>(j + k));
}

/// Blocks of all sizes of ranges: many intervals of each kind for an interval tree. `i` is 0.
double MakePatches(std::int64_t, std::int64_t j, std::int64_t k)
{
  const std::int64_t patch = (j / 16) * 1000 + k / 16;
  const double centre = std::fmod(static_cast<double>(patch) * 0.618033988749895, 1.0);
  const double width = patch % 3 == 0 ? 0.5 : std::pow(0.5, static_cast<double>(patch % 11));
  const double noise = std::fmod(static_cast<double>(j * 131 + k * 37) * 0.7548776662466927, 1.0);
  return std::clamp(centre + (noise - 0.5) * width, 0.0, 1.0);
}

/// Lines at uneven distances.
GridLines MakeLines(const Index3& size)
{
  GridLines lines;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (std::int64_t n = 0; n < size[axis]; ++n)
    {
      const auto at = static_cast<double>(n);
      lines.Coordinates[axis].push_back(0.3 * at + std::sin(0.2 * at) - 1e-9);
    }
  }
  return lines;
}

/// Types of every kind and size, by all codecs and predictors.
bool WriteCompressed(const std::string& folder)
{
  const Index3 size = { 35, 20, 18 };
  const std::vector<SampleArray> arrays = { MakeArray<std::int8_t>("i8", size, MakeWaves),
    MakeArray<std::uint8_t>("u8", size, MakeWaves), MakeArray<std::int16_t>("i16", size, MakeWaves),
    MakeArray<std::uint32_t>("u32", size, MakeWaves), MakeArray<float>("f32", size, MakeWaves),
    MakeArray<double>("f64", size, MakeWaves) };
  const std::pair<const char*, BlockCompression> ways[] = {
    { "compressed-by-lz4", { SegmentCodec::Lz4, 0 } },
    { "compressed-by-zstd", { SegmentCodec::Zstd, 0 } },
  };
  bool isWritten = true;
  for (const auto& way : ways)
  {
    BlockedVolumeSettings settings;
    settings.BlockSize = 16;
    settings.NumberOfStores = 2;
    settings.Compression = way.second;
    isWritten = isWritten &&
      WriteVolume(folder + "/" + way.first, MakeGrid({ 0, 0, 0 }, size), arrays, settings);
  }
  return isWritten;
}

/// A volume whose samples stay in a MetaImage.
bool WriteInPlace(const std::string& folder)
{
  const Index3 size = { 50, 33, 19 };
  const SampleArray array = MakeArray<float>("density", size, MakeWaves);
  const std::string path = folder + "/in-place";
  WriteBytes(path + ".array-0.raw", array.Bytes);
  std::ofstream(path + ".mhd") << "ObjectType = Image\nNDims = 3\nDimSize = 50 33 19\n"
                               << "ElementType = MET_FLOAT\n"
                               << "ElementDataFile = in-place.array-0.raw\n";
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 2;
  settings.Compression.Codec = SegmentCodec::Lz4;
  const GridGeometry grid = MakeGrid({ 0, 0, 0 }, size);
  const auto record = DescribeSource(GetLocalFileSystem(), OpenForeignVolume, path + ".bvol",
    path + ".mhd", {}, grid, { array.Description });
  if (!record.IsOk())
  {
    std::fprintf(stderr, "%s\n", record.GetStatus().GetMessage().c_str());
    return false;
  }
  settings.InPlace = *record;
  return WriteVolume(path, grid, { array }, settings);
}

bool WriteAll(const std::string& folder)
{
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 3;
  settings.Time = 0.1;
  Index3 size = { 50, 33, 19 };
  const bool everyType = WriteVolume(folder + "/every-type", MakeGrid({ -7, 0, 100 }, size),
    { MakeArray<std::int8_t>("i8", size, MakeWaves), MakeArray<std::uint8_t>("u8", size, MakeWaves),
      MakeArray<std::int16_t>("i16", size, MakeWaves),
      MakeArray<std::uint16_t>("u16", size, MakeWaves),
      MakeArray<std::int32_t>("i32", size, MakeWaves),
      MakeArray<std::uint32_t>("u32", size, MakeWaves),
      MakeArray<std::int64_t>("i64", size, MakeWaves),
      MakeArray<std::uint64_t>("u64", size, MakeWaves),
      MakeArray<float>("a \"name\"\n\x01/\xc3\xa9", size, MakeWaves),
      MakeArray<double>("f64", size, MakeWaves) },
    settings);

  settings.Time.reset();
  settings.BlockSize = 32;
  settings.NumberOfStores = 2;
  settings.Distribution = DistributionMethod::Random;
  settings.RandomSeed = std::numeric_limits<std::uint64_t>::max();
  size = { 97, 66, 65 };
  const bool manyLevels = WriteVolume(folder + "/many-levels", MakeGrid({ 0, 0, 0 }, size),
    { MakeArray<std::int16_t>("density", size, MakeWaves) }, settings);

  settings.BlockSize = 64;
  settings.NumberOfStores = 4;
  settings.Distribution = DistributionMethod::Slab;
  size = { 66, 3, 2 };
  const bool emptyStores = WriteVolume(folder + "/empty-stores", MakeGrid({ 5, -9, 0 }, size),
    { MakeArray<double>("temperature", size, MakeWaves) }, settings);

  settings.BlockSize = 16;
  settings.NumberOfStores = 1;
  settings.Distribution = DistributionMethod::Greedy;
  size = { 1, 2, 105000 }; // many blocks of few samples
  const bool highTree = WriteVolume(folder + "/high-tree", MakeGrid({ 0, 0, 0 }, size),
    { MakeArray<std::uint16_t>("patches", size, MakePatches) }, settings);

  size = { 41, 33, 35 };
  settings.NumberOfStores = 2;
  settings.Lines = MakeLines(size);
  const bool rectilinear = WriteVolume(folder + "/rectilinear", MakeGrid({ -7, 0, 100 }, size),
    { MakeArray<std::int16_t>("density", size, MakeWaves) }, settings);
  return everyType && manyLevels && emptyStores && highTree && rectilinear &&
    WriteCompressed(folder) && WriteInPlace(folder);
}

} // namespace
} // namespace isosurface

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  std::filesystem::remove_all(argv[1]);
  std::filesystem::create_directories(argv[1]);
  return isosurface::WriteAll(argv[1]) ? 0 : 1;
}
