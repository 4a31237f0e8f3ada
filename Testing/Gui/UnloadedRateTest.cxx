// SPDX-License-Identifier: BSD-3-Clause
#include "UnloadedRate.h"

#include <gtest/gtest.h>

using isosurface::ExtractionWork;
using isosurface::UnloadedRate;

namespace
{

/// Of a million triangles, times a factor.
ExtractionWork MakeWork(double factor = 1)
{
  ExtractionWork work;
  work.Blocks = 2000 * factor;
  work.Triangles = 1e6 * factor;
  return work;
}

/// Seconds of the work on a laptop that does nothing else.
double GetQuietSeconds(double factor = 1)
{
  return 0.04 * factor;
}

TEST(UnloadedRate, ASlowFirstExtractionIsNotBelieved)
{
  UnloadedRate rate;
  rate.Observe(MakeWork(), 20 * GetQuietSeconds());
  EXPECT_LT(rate.Predict(MakeWork()), 3 * GetQuietSeconds());
}

TEST(UnloadedRate, LoadThatComesAndGoesDoesNotShow)
{
  UnloadedRate rate;
  const double loads[] = { 20, 1, 8, 15, 1.1, 9, 30, 7 };
  for (const double load : loads)
  {
    rate.Observe(MakeWork(), load * GetQuietSeconds());
    EXPECT_LT(rate.Predict(MakeWork()), 3 * GetQuietSeconds()) << "after a load of " << load;
    EXPECT_GT(rate.Predict(MakeWork()), GetQuietSeconds() / 3) << "after a load of " << load;
  }
}

TEST(UnloadedRate, AMachineThatIsSlowForGoodIsLearned)
{
  UnloadedRate rate;
  for (int extraction = 0; extraction < 6; ++extraction)
  {
    rate.Observe(MakeWork(), 10 * GetQuietSeconds());
  }
  EXPECT_NEAR(rate.Predict(MakeWork()), 10 * GetQuietSeconds(), 2 * GetQuietSeconds());
  EXPECT_NEAR(rate.Predict(MakeWork(3)), 10 * GetQuietSeconds(3), 3 * GetQuietSeconds(3));
}

TEST(UnloadedRate, AFastMachineIsLearnedAtOnce)
{
  UnloadedRate rate;
  rate.Observe(MakeWork(20), GetQuietSeconds(20) / 4);
  EXPECT_NEAR(rate.Predict(MakeWork(20)), GetQuietSeconds(20) / 4, GetQuietSeconds(20) / 10);
}

} // namespace
