// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/LargeVolume.h"

#include "Fixtures/MemoryDisk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace isosurface;

namespace
{

constexpr Index3 ScanSize = { 12, 9, 8 };

/// A smooth bump of int16 samples in a constant surrounding.
std::int16_t GetScanValue(std::int64_t i, std::int64_t j, std::int64_t k)
{
  const auto x = static_cast<double>(i) - 7;
  const auto y = static_cast<double>(j) - 5;
  const auto z = static_cast<double>(k) - 4;
  return static_cast<std::int16_t>(
    std::lround(-100 + std::max(0.0, 900 - 100 * (x * x + y * y + z * z))));
}

RawVolume WriteScan(MemoryDisk& disk)
{
  std::vector<std::int16_t> samples;
  for (std::int64_t k = 0; k < ScanSize[2]; ++k)
  {
    for (std::int64_t j = 0; j < ScanSize[1]; ++j)
    {
      for (std::int64_t i = 0; i < ScanSize[0]; ++i)
      {
        samples.push_back(GetScanValue(i, j, k));
      }
    }
  }
  EXPECT_TRUE(disk.MakeDirectories("/data").IsOk());
  auto file = disk.CreateForWriting("/data/scan.raw");
  EXPECT_TRUE((*file)->Append(samples.data(), 2 * samples.size()).IsOk());
  RawVolume scan;
  scan.Grid.Extent = { 0, ScanSize[0] - 1, 0, ScanSize[1] - 1, 0, ScanSize[2] - 1 };
  scan.Grid.Origin = { -3, 4.5, 0.1 };
  scan.Grid.Spacing = { 1, 2, 0.3 };
  scan.Type = ValueType::Int16;
  scan.Paths = { "/data/scan.raw" };
  return scan;
}

LargeVolumeSettings MakeSettings(std::int64_t fold, ValueType type)
{
  LargeVolumeSettings settings;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    settings.Dimensions[axis] = fold * (ScanSize[axis] - 1) + 1;
  }
  settings.Type = type;
  return settings;
}

template <typename T>
std::vector<T> Fill(const LargeVolume& volume, int threads)
{
  const Index3 size = volume.GetGrid().GetDimensions();
  std::vector<T> samples(static_cast<std::size_t>(size[0] * size[1] * size[2]));
  volume.FillSlices(0, size[2], threads, samples.data());
  return samples;
}

} // namespace

TEST(LargeVolume, WithoutDetailHasTheScansSamplesWhereTheScanHasThem)
{
  MemoryDisk disk;
  LargeVolumeSettings settings = MakeSettings(5, ValueType::Int16);
  settings.Detail = 0;
  const auto volume = LargeVolume::Open(disk, WriteScan(disk), settings);
  ASSERT_TRUE(volume.IsOk());
  const auto samples = Fill<std::int16_t>(*volume, 1);
  const Index3 size = settings.Dimensions;
  for (std::int64_t k = 0; k < ScanSize[2]; ++k)
  {
    for (std::int64_t j = 0; j < ScanSize[1]; ++j)
    {
      for (std::int64_t i = 0; i < ScanSize[0]; ++i)
      {
        ASSERT_EQ(samples[static_cast<std::size_t>(5 * (i + size[0] * (j + size[1] * k)))],
          GetScanValue(i, j, k));
      }
    }
  }
}

TEST(LargeVolume, AddsDetailWhereTheScanHasContrastAndNoneWhereItIsConstant)
{
  MemoryDisk disk;
  const RawVolume scan = WriteScan(disk);
  LargeVolumeSettings settings = MakeSettings(8, ValueType::Int16);
  const auto rough = LargeVolume::Open(disk, scan, settings);
  settings.Detail = 0;
  const auto smooth = LargeVolume::Open(disk, scan, settings);
  ASSERT_TRUE(rough.IsOk() && smooth.IsOk());
  const auto detailed = Fill<std::int16_t>(*rough, 1);
  const auto plain = Fill<std::int16_t>(*smooth, 1);
  // The low corner is three samples of the scan away from the bump.
  EXPECT_EQ(detailed[0], -100);
  EXPECT_EQ(detailed[1], -100);
  double squares = 0;
  int count = 0;
  for (std::size_t sample = 0; sample < plain.size(); ++sample)
  {
    ASSERT_GE(detailed[sample], -100);
    ASSERT_LE(detailed[sample], 800);
    if (plain[sample] > 100 && plain[sample] < 600)
    {
      squares += std::pow(detailed[sample] - plain[sample], 2);
      ++count;
    }
  }
  // The bump's slope is 300 to 600 a sample of the scan; the detail, a quarter of a sample.
  const double deviation = std::sqrt(squares / count);
  EXPECT_GT(deviation, 50);
  EXPECT_LT(deviation, 250);
}

TEST(LargeVolume, IsTheSameForAnyNumberOfThreadsAndSlabs)
{
  MemoryDisk disk;
  const auto volume = LargeVolume::Open(disk, WriteScan(disk), MakeSettings(7, ValueType::Float32));
  ASSERT_TRUE(volume.IsOk());
  const auto expected = Fill<float>(*volume, 1);
  EXPECT_EQ(expected, Fill<float>(*volume, 3));
  const Index3 size = volume->GetGrid().GetDimensions();
  std::vector<float> slices(static_cast<std::size_t>(2 * size[0] * size[1]));
  volume->FillSlices(20, 22, 2, slices.data());
  EXPECT_TRUE(std::equal(slices.begin(), slices.end(), expected.begin() + 20 * size[0] * size[1]));
  EXPECT_GE(*std::min_element(expected.begin(), expected.end()), 0.0F);
  EXPECT_LE(*std::max_element(expected.begin(), expected.end()), 1.0F);
}

TEST(LargeVolume, IsWrittenAsAFileThatReadersKnow)
{
  MemoryDisk disk;
  LargeVolumeSettings settings = MakeSettings(3, ValueType::UInt16);
  settings.Dimensions = { 31, 40, 29 };
  const auto volume = LargeVolume::Open(disk, WriteScan(disk), settings);
  ASSERT_TRUE(volume.IsOk());
  ASSERT_TRUE(volume->Write(disk, "/data/large.mhd", 2).IsOk());
  const auto read = RawVolume::ReadHeader(disk, "/data/large.mhd");
  ASSERT_TRUE(read.IsOk()) << read.GetStatus().GetMessage();
  EXPECT_TRUE(read->Grid == volume->GetGrid());
  EXPECT_EQ(read->Type, ValueType::UInt16);
  // The box in space is the scan's.
  EXPECT_DOUBLE_EQ(read->Grid.Spacing[1] * 39, 2.0 * (ScanSize[1] - 1));
  auto source = read->Open(disk);
  ASSERT_TRUE(source.IsOk()) << source.GetStatus().GetMessage();
  const auto slab = (*source)->Read((*source)->GetBox());
  ASSERT_TRUE(slab.IsOk());
  const auto expected = Fill<std::uint16_t>(*volume, 1);
  EXPECT_EQ(std::memcmp(slab->Arrays[0].First, expected.data(), 2 * expected.size()), 0);
}

TEST(LargeVolume, RefusesWhatHasNoTwoSamplesOnAnAxis)
{
  MemoryDisk disk;
  LargeVolumeSettings settings = MakeSettings(3, ValueType::UInt16);
  settings.Dimensions[1] = 1;
  EXPECT_EQ(LargeVolume::Open(disk, WriteScan(disk), settings).GetStatus().GetCode(),
    StatusCode::InvalidArgument);
}
