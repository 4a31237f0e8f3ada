// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Sampling/ImagePlan.h"
#include "Fixtures/VolumeOnDisk.h"

#include <cmath>

using namespace isosurface;

namespace
{

constexpr double ManyPoints = 1e9;

/// A volume whose minimum is 7.
SampleVolume<float> MakeHighVolume()
{
  return SampleVolume<float>({ 50, 40, 45 },
    [](auto i, auto j, auto k) { return static_cast<float>(7 + i + 2 * j + 3 * (k % 5)); });
}

SampledBox MakeWholePart(const std::shared_ptr<BlockedVolume>& volume, ImagePlan plan)
{
  SampledBox part;
  part.Box.High = plan.Grid.GetDimensions();
  part.Plan = std::move(plan);
  part.Volume = volume;
  part.Arrays = { 0 };
  part.Threads = 2;
  return part;
}

float ValueAt(const SampledBox& part, std::size_t vertex)
{
  float value = 0;
  std::memcpy(&value, &part.Values.front()[vertex * sizeof(float)], sizeof(float));
  return value;
}

Plane MakePlane(const BlockedVolume& volume, const std::array<double, 3>& normal)
{
  return { VertexPlaces(volume.GetHeader().Grid).FindPoint({ 20, 20, 17 }), normal };
}

} // namespace

TEST(ImagePlan, ASliceThroughVerticesHasTheirSamples)
{
  MemoryDisk disk;
  const auto samples = MakeHighVolume();
  const auto opened = WriteAndOpen(disk, samples, MakeSettings(16, 2));
  auto plan =
    PlanSlice(*opened, MakePlane(*opened, { 0, 0, 1 }), Interpolation::Linear, ManyPoints);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->Level, 0);
  EXPECT_FALSE(plan->HasOutside);
  SampledBox part = MakeWholePart(opened, std::move(*plan));
  LevelsOfVolume levels;
  ASSERT_TRUE(part.Fill(levels, {}).IsOk());
  EXPECT_TRUE(part.IsInside.empty());
  std::size_t wrong = 0;
  VisitVertices(part.Box,
    [&](const Index3& at)
    { wrong += ValueAt(part, part.Box.FindIndex(at)) != samples.At(at[0], at[1], 17); });
  EXPECT_EQ(wrong, 0u);
}

TEST(ImagePlan, BeyondTheVolumeAnObliqueSliceHasTheMinimumOrNaN)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeHighVolume(), MakeSettings(16, 2));
  const auto plan =
    PlanSlice(*opened, MakePlane(*opened, { 1, 2, 3 }), Interpolation::Linear, ManyPoints);
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->HasOutside);
  for (const ValueBeyond beyond : { ValueBeyond::Minimum, ValueBeyond::NotANumber })
  {
    SampledBox part = MakeWholePart(opened, *plan);
    part.Beyond = beyond;
    LevelsOfVolume levels;
    ASSERT_TRUE(part.Fill(levels, {}).IsOk());
    std::size_t outside = 0;
    for (std::size_t vertex = 0; vertex < part.IsInside.size(); ++vertex)
    {
      const float value = ValueAt(part, vertex);
      if (part.IsInside[vertex] != 0)
      {
        EXPECT_GE(value, 7.0F);
        continue;
      }
      ++outside;
      EXPECT_TRUE(beyond == ValueBeyond::Minimum ? value == 7.0F : std::isnan(value));
    }
    EXPECT_GT(outside, 0u);
    EXPECT_LT(outside, part.IsInside.size());
  }
}

TEST(ImagePlan, ABoxIsOfTheFinestLevelThatHasFewEnoughPoints)
{
  MemoryDisk disk;
  const auto samples = MakeHighVolume();
  const auto opened = WriteAndOpen(disk, samples, MakeSettings(16, 2));
  const VertexBox box{ { 5, 6, 7 }, { 30, 31, 33 } };
  int last = -1;
  for (const double most : { ManyPoints, 3000.0, 400.0 })
  {
    auto plan = PlanBox(*opened, box, most);
    ASSERT_TRUE(plan);
    EXPECT_LE(plan->CountPoints(), most);
    EXPECT_GT(plan->Level, last);
    last = plan->Level;
    const std::int64_t step = std::int64_t{ 1 } << plan->Level;
    SampledBox part = MakeWholePart(opened, std::move(*plan));
    LevelsOfVolume levels;
    ASSERT_TRUE(part.Fill(levels, {}).IsOk());
    std::size_t wrong = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      EXPECT_LE((box.Low[axis] / step) * step, box.Low[axis]);
      EXPECT_GE((box.Low[axis] / step + part.Box.High[axis] - 1) * step, box.High[axis] - 1);
    }
    VisitVertices(part.Box,
      [&](const Index3& at)
      {
        Index3 from{};
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          from[axis] = (box.Low[axis] / step + at[axis]) * step;
        }
        wrong += ValueAt(part, part.Box.FindIndex(at)) != samples.At(from[0], from[1], from[2]);
      });
    EXPECT_EQ(wrong, 0u) << "level " << last;
  }
  EXPECT_FALSE(PlanBox(*opened, box, 0.5)) << "no level is as small";
}

TEST(ImagePlan, LevelsAreOpenedOnceUntilTheVolumeIsAnotherOne)
{
  MemoryDisk disk;
  const auto opened = WriteAndOpen(disk, MakeHighVolume(), MakeSettings(16, 2));
  const auto again = OpenVolume(disk);
  LevelsOfVolume levels;
  const auto first = Require(levels.Find(opened, 0, 1));
  EXPECT_EQ(Require(levels.Find(opened, 0, 1)), first);
  EXPECT_NE(Require(levels.Find(opened, 0, 0)), first);
  EXPECT_EQ(&Require(levels.Find(again, 0, 1))->GetVolume(), again.get());
  EXPECT_NE(Require(levels.Find(opened, 0, 1)), first);
}

TEST(ImagePlan, ComponentsOfSeveralArraysAreSampledInTurn)
{
  const ArrayVariables variables({ { "a", ValueType::UInt16, 1 }, { "b", ValueType::Float64, 1 },
    { "c", ValueType::Float32, 3 } });
  char values[2][64] = {};
  std::vector<std::array<std::ptrdiff_t, 3>> calls;
  std::vector<double> told;
  const auto progress = [&](double part)
  {
    told.push_back(part);
    return true;
  };
  const Status status = SampleComponents(variables, { 2, 0 }, { values[0], values[1] }, progress,
    [&](std::size_t variable, void* first, int stride, const Progress& advance)
    {
      calls.push_back(
        { static_cast<std::ptrdiff_t>(variable), static_cast<char*>(first) - values[0], stride });
      return advance(0.5) ? Status::Ok() : Status(StatusCode::Aborted, "stopped");
    });
  EXPECT_TRUE(status.IsOk());
  EXPECT_EQ(calls,
    (std::vector<std::array<std::ptrdiff_t, 3>>{
      { 2, 0, 3 }, { 3, 4, 3 }, { 4, 8, 3 }, { 0, 64, 1 } }));
  EXPECT_EQ(told, (std::vector<double>{ 0.125, 0.375, 0.625, 0.875 }));
}
