// SPDX-License-Identifier: BSD-3-Clause
// A coarse slice, then the exact one, which a thread has read meanwhile.
#include "Ranks/Query/ImageField.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Ranks/Query/FieldRefinement.h"

#include <algorithm>

using namespace isosurface;

namespace
{

SampledBox MakeSlicePart(const std::shared_ptr<BlockedVolume>& volume, double mostPoints)
{
  const Plane plane{ VertexPlaces(volume->GetHeader().Grid).FindPoint({ 20, 20, 20 }),
    { 0, 0, 1 } };
  SampledBox part;
  part.Plan = *PlanSlice(*volume, plane, Interpolation::Linear, mostPoints);
  part.Box.High = part.Plan.Grid.GetDimensions();
  part.Volume = volume;
  part.Arrays = { 0 };
  return part;
}

} // namespace

TEST(ImageField, ACoarseSliceIsFollowedByTheExactOneThatWasRead)
{
  MemoryDisk disk;
  const auto volume =
    WriteAndOpen(disk, MakeVolume<std::uint8_t>({ 60, 50, 40 }), MakeSettings(16, 2));
  SerialCommunicator alone;
  ImageField field;
  FieldRefinement levels([] { return std::uint64_t{ 0 }; });
  RefinementRequest wanted;
  wanted.MayBeCoarse = true;
  wanted.Change = 1;
  const auto show = [&]
  {
    field.Ask(1, MakeSlicePart(volume, 1e9), MakeSlicePart(volume, 400));
    const auto choice = Require(levels.Begin(alone, field, wanted));
    EXPECT_TRUE(field.Fill(choice.Level, {}).IsOk());
    levels.SetShown(true, choice.Level, 0);
    return choice.Level;
  };
  EXPECT_GT(show(), 0);
  EXPECT_FALSE(levels.IsFinal());
  Refinement next = levels.Prepare(alone, 0.01, wanted.Change);
  while (next.Stage == RefinementStage::Working)
  {
    next = levels.Prepare(alone, 0.01, wanted.Change);
  }
  EXPECT_EQ(next.Stage, RefinementStage::Ready);
  EXPECT_TRUE(levels.Refine(wanted.Change));
  EXPECT_EQ(show(), 0);
  EXPECT_TRUE(levels.IsFinal());
  SampledBox exact = MakeSlicePart(volume, 1e9);
  LevelsOfVolume opened;
  ASSERT_TRUE(exact.Fill(opened, {}).IsOk());
  const auto& read = field.GetBox(0).Values.front();
  EXPECT_TRUE(
    std::equal(read.begin(), read.end(), exact.Values.front().begin(), exact.Values.front().end()));
}
