// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/StoredBoxSource.h"
#include "Fixtures/VolumeOnDisk.h"

#include <algorithm>
#include <random>

using namespace isosurface;

namespace
{

VertexBox MakeRandomBox(const Index3& size, std::mt19937& random)
{
  VertexBox box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    std::uniform_int_distribution<std::int64_t> vertex(0, size[axis] - 1);
    const std::int64_t ends[2] = { vertex(random), vertex(random) };
    box.Low[axis] = std::min(ends[0], ends[1]);
    box.High[axis] = std::max(ends[0], ends[1]) + 1;
  }
  return box;
}

} // namespace

TEST(StoredBoxSource, BoxesHaveTheSamplesThatWereWritten)
{
  std::mt19937 random(3);
  for (const Index3& size :
    { Index3{ 70, 33, 50 }, Index3{ 17, 40, 1 }, Index3{ 33, 65, 17 }, Index3{ 1, 1, 1 } })
  {
    const auto written = MakeVolume<std::int16_t>(size);
    MemoryDisk disk;
    WriteVolumeOk(disk, written, MakeSettings(16, 3));
    const auto source = Require(StoredBoxSource::Make(OpenVolume(disk), 0, { 0 }, 2));
    EXPECT_EQ(source->GetBox(), (VertexBox{ { 0, 0, 0 }, size }));
    for (int repeat = 0; repeat < 20; ++repeat)
    {
      const VertexBox box = repeat == 0 ? source->GetBox() : MakeRandomBox(size, random);
      const auto samples = Require(source->Read(box));
      ASSERT_TRUE(samples.Fits({ ValueType::Int16 }, box));
      ExpectSamples(samples.Arrays[0], samples.Arrays[0].Box, written);
    }
  }
}

TEST(StoredBoxSource, ArraysOfUnlikeTypesBeginWhereTheirValuesMay)
{
  const Index3 size{ 37, 21, 19 };
  const auto bytes = MakeVolume<std::uint8_t>(size);
  const auto doubles = MakeVolume<double>(size);
  const auto shorts = MakeVolume<std::int16_t>(size);
  MemoryDisk disk;
  SerialCommunicator serial;
  const VolumePiece piece{ { { 0, 0, 0 }, size },
    { bytes.GetView(), doubles.GetView(), shorts.GetView() } };
  const auto written = BlockedVolumeWriter(serial, disk)
                         .Write(VolumePath, MakeGeometry(size),
                           { { "bytes", ValueType::UInt8 }, { "doubles", ValueType::Float64 },
                             { "shorts", ValueType::Int16 } },
                           piece, MakeSettings(16, 2));
  ASSERT_TRUE(written.IsOk()) << written.GetStatus().GetMessage();
  const auto source = Require(StoredBoxSource::Make(OpenVolume(disk), 0, { 2, 0, 1 }, 2));
  // Boxes of an odd number of vertices: what follows the bytes would not be aligned by itself.
  const VertexBox odd{ { 1, 2, 3 }, { 4, 7, 18 } };
  for (const VertexBox& box : { source->GetBox(), odd })
  {
    const auto samples = Require(source->Read(box));
    ASSERT_TRUE(samples.Fits({ ValueType::Int16, ValueType::UInt8, ValueType::Float64 }, box));
    for (const SampleView& view : samples.Arrays)
    {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(view.First) % GetValueSize(view.Type), 0u);
    }
    ExpectSamples(samples.Arrays[0], samples.Arrays[0].Box, shorts);
    ExpectSamples(samples.Arrays[1], samples.Arrays[1].Box, bytes);
    ExpectSamples(samples.Arrays[2], samples.Arrays[2].Box, doubles);
  }
}

TEST(StoredBoxSource, AVolumeThatIsWrittenAnewHasTheFilesOfTheFirst)
{
  const auto written = MakeVolume<std::int16_t>({ 70, 33, 50 });
  MemoryDisk first;
  WriteVolumeOk(first, written, MakeSettings(32, 2));
  MemoryDisk other;
  const auto volume = WriteAndOpen(other, written, MakeSettings(16, 5, DistributionMethod::Slab));
  for (const int ranks : { 1, 3 })
  {
    MemoryDisk again;
    ThreadCommunicator::Run(ranks,
      [&](Communicator& communicator)
      {
        auto source = StoredBoxSource::Make(volume, 0, { 0 }, 1);
        ASSERT_TRUE(source.IsOk());
        const auto result = BlockedVolumeWriter(communicator, again)
                              .Write(VolumePath, volume->GetHeader().Grid,
                                volume->GetHeader().Arrays, **source, MakeSettings(32, 2));
        ASSERT_TRUE(result.IsOk()) << result.GetStatus().GetMessage();
      });
    const std::string blocks = GetStoreFolder(again, VolumePath, "000001", 0) + "/blocks";
    EXPECT_EQ(again.GetFile(blocks), first.GetFile(blocks));
  }
}

TEST(StoredBoxSource, TellsOfADamagedBlock)
{
  MemoryDisk disk;
  WriteVolumeOk(disk, MakeVolume<std::uint8_t>({ 40, 40, 40 }), MakeSettings(16, 1));
  disk.GetFile(GetStoreFolder(disk, VolumePath, "000001", 0) + "/blocks")[100] ^= 1;
  const auto source = Require(StoredBoxSource::Make(OpenVolume(disk), 0, { 0 }, 2));
  const auto samples = source->Read(source->GetBox());
  ExpectError(samples.GetStatus(), StatusCode::Corrupt, "blocks");
}
