// SPDX-License-Identifier: BSD-3-Clause
// Frames of a machine whose speed the chooser does not know, with a simulated clock.
#include "Ranks/Compositing/ResolutionChooser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

using namespace isosurface;

namespace
{

/// A rank's piece of a scene on the display: a square, at a depth.
struct Part
{
  double Side;
  double Offset;
  double Depth;
  std::int64_t Triangles;
};

RankWork MakeWork(const Part& part)
{
  RankWork work;
  work.Triangles = part.Triangles;
  for (std::size_t resolution = 0; resolution < NumberOfResolutions; ++resolution)
  {
    const double side = std::ceil(part.Side / GetResolutionDivisor(resolution));
    work.Samples[resolution] = static_cast<std::int64_t>(side * side);
  }
  work.Importance = GetImportance(part.Offset, part.Depth);
  return work;
}

std::vector<RankWork> MakeScene(double zoom)
{
  return { MakeWork({ 800 * zoom, 0.1, 0.0, 300000 }), MakeWork({ 600 * zoom, 0.4, 0.3, 250000 }),
    MakeWork({ 500 * zoom, 0.8, 0.7, 200000 }), MakeWork({ 300 * zoom, 0.6, 1.0, 320000 }) };
}

/// Ranks draw side by side, then the images are merged.
struct Machine
{
  double SecondsOfFrame = 0.008;
  double SecondsOfTriangle = 4e-8;
  double SecondsOfSample = 3e-8;
  double SecondsOfMerge = 6e-9;
  double Noise = 0.04;
  std::mt19937 Random{ 11 };

  double Draw(const std::vector<RankWork>& work, const std::vector<int>& divisors)
  {
    double slowest = 0;
    double merge = 0;
    for (std::size_t rank = 0; rank < work.size(); ++rank)
    {
      std::size_t resolution = 0;
      while (GetResolutionDivisor(resolution) < divisors[rank])
      {
        ++resolution;
      }
      const auto samples = static_cast<double>(work[rank].Samples[resolution]);
      slowest = std::max(slowest,
        static_cast<double>(work[rank].Triangles) * this->SecondsOfTriangle +
          samples * this->SecondsOfSample);
      merge += samples * this->SecondsOfMerge;
    }
    std::normal_distribution<double> noise(1.0, this->Noise);
    return (this->SecondsOfFrame + slowest + merge) * noise(this->Random);
  }
};

/// The seconds of frames of a scene that zooms.
template <typename Zoom>
std::vector<double> DrawFrames(
  ResolutionChooser& chooser, Machine& machine, double budget, int count, const Zoom& zoom)
{
  std::vector<double> seconds;
  for (int frame = 0; frame < count; ++frame)
  {
    const std::vector<RankWork> work = MakeScene(zoom(frame));
    const std::vector<int> divisors = chooser.Choose(work, budget);
    seconds.push_back(machine.Draw(work, divisors));
    chooser.Learn(work, divisors, seconds.back());
  }
  return seconds;
}

double GetShareWithin(const std::vector<double>& seconds, double maximum)
{
  return static_cast<double>(std::count_if(
           seconds.begin(), seconds.end(), [maximum](double value) { return value <= maximum; })) /
    static_cast<double>(seconds.size());
}

} // namespace

TEST(ResolutionChooser, KeepsTheBudgetAlongACameraPath)
{
  for (const double budget : { 0.03, 0.05, 0.08 })
  {
    for (const double speed : { 0.5, 1.0, 3.0 })
    {
      ResolutionChooser chooser;
      Machine machine;
      machine.SecondsOfSample /= speed;
      machine.SecondsOfMerge /= speed;
      const std::vector<double> seconds = DrawFrames(chooser, machine, budget, 200,
        [](int frame) { return 2.0 + 1.5 * std::sin(0.06 * frame); });
      EXPECT_GE(GetShareWithin(seconds, 1.1 * budget), 0.95) << budget << ", " << speed;
    }
  }
}

// Ranks that share cores with each other, and with other programs.
TEST(ResolutionChooser, KeepsTheBudgetWhereFramesAreHardToPredict)
{
  for (const double noise : { 0.1, 0.15, 0.2 })
  {
    ResolutionChooser chooser;
    Machine machine;
    machine.Noise = noise;
    const double budget = 0.08;
    const auto zoom = [](int frame) { return 2.0 + 1.5 * std::sin(0.06 * frame); };
    const std::vector<double> seconds = DrawFrames(chooser, machine, budget, 400, zoom);
    EXPECT_GE(GetShareWithin(seconds, 1.1 * budget), 0.93) << noise;
    // Not by drawing much less than the time allows.
    EXPECT_GT(std::accumulate(seconds.begin(), seconds.end(), 0.0) / 400, 0.5 * budget) << noise;
  }
}

TEST(ResolutionChooser, UsesTheBudget)
{
  ResolutionChooser chooser;
  Machine machine;
  DrawFrames(chooser, machine, 0.05, 30, [](int) { return 3.0; });
  const std::vector<double> seconds =
    DrawFrames(chooser, machine, 0.05, 30, [](int) { return 3.0; });
  // Halving one more rank's blocks would exceed it; the coarsest resolutions would take 0.022 s.
  const double mean = std::accumulate(seconds.begin(), seconds.end(), 0.0) / 30;
  EXPECT_GT(mean, 0.035);
  EXPECT_LT(mean, 0.055);
}

TEST(ResolutionChooser, SettlesWithinThreeFramesOfAJump)
{
  for (const double to : { 0.6, 1.2, 2.5, 4.0 })
  {
    ResolutionChooser chooser;
    Machine machine;
    const double budget = 0.05;
    DrawFrames(
      chooser, machine, budget, 40, [](int frame) { return 1.5 + 0.5 * std::sin(0.2 * frame); });
    const std::vector<double> after =
      DrawFrames(chooser, machine, budget, 23, [to](int) { return to; });
    const std::vector<double> settled(after.begin() + 3, after.end());
    EXPECT_GE(GetShareWithin(settled, 1.1 * budget), 0.95) << to;
  }
}

TEST(ResolutionChooser, FollowsAMachineThatBecomesSlower)
{
  ResolutionChooser chooser;
  Machine machine;
  const double budget = 0.06;
  DrawFrames(chooser, machine, budget, 60, [](int) { return 2.5; });
  machine.SecondsOfSample *= 2;
  machine.SecondsOfMerge *= 2;
  const std::vector<double> after =
    DrawFrames(chooser, machine, budget, 24, [](int) { return 2.5; });
  const std::vector<double> settled(after.begin() + 4, after.end());
  EXPECT_GE(GetShareWithin(settled, 1.1 * budget), 0.95);
}

TEST(ResolutionChooser, DoesNotFlicker)
{
  ResolutionChooser chooser;
  Machine machine;
  const std::vector<RankWork> work = MakeScene(2.5);
  std::vector<int> last;
  int changes = 0;
  for (int frame = 0; frame < 120; ++frame)
  {
    const std::vector<int> divisors = chooser.Choose(work, 0.05);
    chooser.Learn(work, divisors, machine.Draw(work, divisors));
    changes += frame > 20 && divisors != last ? 1 : 0;
    last = divisors;
  }
  EXPECT_LE(changes, 4);
}

TEST(ResolutionChooser, GivesTheBackgroundLessThanTheFocus)
{
  ResolutionChooser chooser;
  Machine machine;
  machine.SecondsOfSample = 0;
  machine.SecondsOfMerge = 3e-8; // all ranks share one processor
  const std::vector<RankWork> work = { MakeWork({ 1500, 0.0, 0.0, 100000 }),
    MakeWork({ 1500, 0.9, 1.0, 100000 }), MakeWork({ 1500, 0.5, 0.5, 100000 }) };
  std::vector<int> divisors;
  for (int frame = 0; frame < 40; ++frame)
  {
    divisors = chooser.Choose(work, 0.12);
    chooser.Learn(work, divisors, machine.Draw(work, divisors));
  }
  EXPECT_EQ(divisors[0], 1);
  EXPECT_GE(divisors[1], 2);
  EXPECT_LT(divisors[0], divisors[1]);
  EXPECT_LE(divisors[0], divisors[2]);
  EXPECT_LE(divisors[2], divisors[1]);
}

TEST(ResolutionChooser, IsFullWithPlentyOfTimeAndCoarsestWithNone)
{
  ResolutionChooser chooser;
  Machine machine;
  DrawFrames(chooser, machine, 10.0, 10, [](int) { return 2.0; });
  EXPECT_EQ(chooser.Choose(MakeScene(2.0), 10.0), std::vector<int>(4, 1));
  EXPECT_EQ(chooser.Choose(MakeScene(2.0), 1e-9), std::vector<int>(4, 16));
}

TEST(ResolutionChooser, ALongFrameAloneChangesNothing)
{
  ResolutionChooser chooser;
  Machine machine;
  machine.Noise = 0.01;
  const std::vector<RankWork> work = MakeScene(2.5);
  DrawFrames(chooser, machine, 0.06, 60, [](int) { return 2.5; });
  const std::vector<int> before = chooser.Choose(work, 0.06);
  chooser.Learn(work, before, 0.5);
  chooser.Choose(work, 0.06);
  DrawFrames(chooser, machine, 0.06, 12, [](int) { return 2.5; });
  EXPECT_EQ(chooser.Choose(work, 0.06), before);
}

TEST(ResolutionChooser, TakesAnyNumbers)
{
  ResolutionChooser chooser;
  EXPECT_TRUE(chooser.Choose({}, 0.05).empty());
  std::vector<RankWork> work(3);
  EXPECT_EQ(chooser.Choose(work, 0.05).size(), 3U);
  for (const double seconds : { 0.0, -1.0, std::nan(""), HUGE_VAL, 1e9, 1e-9 })
  {
    chooser.Learn(work, { 1, 1, 1 }, seconds);
  }
  chooser.Learn(work, { 1 }, 0.1);
  work[1].Samples.fill(std::int64_t{ 1 } << 40);
  for (const int divisor : chooser.Choose(work, 0.05))
  {
    EXPECT_GE(divisor, 1);
    EXPECT_LE(divisor, 16);
  }
  EXPECT_EQ(chooser.Choose(MakeScene(1), 0.05).size(), 4U);
}

TEST(ResolutionChooser, ImportanceFallsWithDistanceAndDepth)
{
  EXPECT_DOUBLE_EQ(GetImportance(0, 0), 16);
  EXPECT_DOUBLE_EQ(GetImportance(1, 1), 1);
  EXPECT_GT(GetImportance(0.2, 0.5), GetImportance(0.3, 0.5));
  EXPECT_GT(GetImportance(0.5, 0.2), GetImportance(0.5, 0.3));
  EXPECT_DOUBLE_EQ(GetImportance(7, -3), GetImportance(1, 0));
}

TEST(FrameTimeModel, TellsHowMuchLongerThanPredictedFramesTake)
{
  FrameTimeModel model;
  const FrameLoad work{ 100000, 100000, 400000 };
  for (int frame = 0; frame < 100; ++frame)
  {
    model.Learn(work, 0.1);
  }
  EXPECT_NEAR(model.GetHighRatio(), 1, 0.02);
  for (int frame = 0; frame < 40; ++frame)
  {
    // One frame of eight takes longer.
    model.Learn(work, frame % 8 == 0 ? 0.2 : 0.1);
  }
  EXPECT_NEAR(model.GetHighRatio(), 2, 0.1);
}

TEST(FrameTimeModel, LearnsWhatTrianglesAndSamplesCost)
{
  FrameTimeModel model;
  std::mt19937 random(3);
  std::uniform_int_distribution<std::int64_t> triangles(0, 2000000);
  std::uniform_int_distribution<std::int64_t> samples(0, 4000000);
  const auto cost = [](const FrameLoad& work)
  {
    return 0.01 + 2e-8 * static_cast<double>(work.MaximumTriangles) +
      1e-8 * static_cast<double>(work.MaximumSamples) + 5e-9 * static_cast<double>(work.AllSamples);
  };
  for (int frame = 0; frame < 300; ++frame)
  {
    const std::int64_t maximum = samples(random);
    const FrameLoad work{ triangles(random), maximum, 2 * maximum + samples(random) };
    model.Learn(work, cost(work));
  }
  for (int frame = 0; frame < 20; ++frame)
  {
    const std::int64_t maximum = samples(random);
    const FrameLoad work{ triangles(random), maximum, 2 * maximum + samples(random) };
    EXPECT_NEAR(model.Predict(work), cost(work), 0.15 * cost(work));
  }
  EXPECT_LT(model.GetHighRatio(), 1.1);
}
