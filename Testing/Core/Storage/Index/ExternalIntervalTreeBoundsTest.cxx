// SPDX-License-Identifier: BSD-3-Clause
// What a tree costs: pages, page reads, and the memory to build it.
#include "AllocationCounter.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/Require.h"
#include "IntervalSets.h"

#include <filesystem>

#include <unistd.h>

using namespace isosurface;

namespace
{

/// A folder on the local disk, removed at the end of the test.
class TemporaryFolder
{
public:
  TemporaryFolder()
    : Path(testing::TempDir() + "isosurface-index-" + std::to_string(::getpid()))
  {
    EXPECT_TRUE(GetLocalFileSystem().MakeDirectories(this->Path).IsOk());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(this->Path); }
  const std::string Path;
};

/// Builds a tree of synthetic intervals within the limit; checks memory, leftovers and the tree.
void CheckMemory(std::uint32_t count, std::size_t memoryLimit)
{
  TemporaryFolder folder;
  const std::string path = folder.Path + "/tree";
  const auto make = [](std::uint32_t index)
  {
    // Intervals of any length at any place, a function of the index.
    const auto mix = [](std::uint64_t x)
    {
      x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
      x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
      return x ^ (x >> 31);
    };
    const std::uint64_t first = mix(index + 1), second = mix(first);
    const ValueKey minimum = first >> (second % 40);
    return KeyInterval{ minimum,
      minimum + std::min(MaximumKey - minimum, mix(second) >> (second / 64 % 40)), index };
  };
  AllocationCounter::Reset();
  {
    ExternalIntervalTreeBuilder builder(GetLocalFileSystem(), path, memoryLimit);
    for (std::uint32_t index = 0; index < count; ++index)
    {
      const Status added = builder.Add(make(index));
      ASSERT_TRUE(added.IsOk()) << added.GetMessage();
    }
    const Status finished = builder.Finish();
    ASSERT_TRUE(finished.IsOk()) << finished.GetMessage();
  }
  testing::Test::RecordProperty("PeakBytes", std::to_string(AllocationCounter::GetPeak()));
  EXPECT_LE(AllocationCounter::GetPeak(), memoryLimit);
  EXPECT_EQ((*GetLocalFileSystem().List(folder.Path)).size(), 1u) << "a temporary file is left";

  auto tree = Require(ExternalIntervalTree::Open(GetLocalFileSystem(), path, 0));
  EXPECT_EQ(tree->GetCount(), count);
  std::vector<bool> seen(count, false);
  bool right = true;
  const auto visit = [&](const KeyInterval& interval)
  {
    const KeyInterval expected = make(interval.Payload);
    right = right && interval.Payload < count && !seen[interval.Payload] &&
      interval.Minimum == expected.Minimum && interval.Maximum == expected.Maximum;
    seen[interval.Payload] = true;
  };
  PageStatistics statistics;
  const ValueKey key = make(count / 2).Minimum;
  ASSERT_TRUE(tree->FindStabbed(key, visit, statistics).IsOk());
  EXPECT_TRUE(right);
  for (std::uint32_t index = 0; index < count; ++index)
  {
    const KeyInterval interval = make(index);
    ASSERT_EQ(seen[index], interval.Minimum <= key && key <= interval.Maximum);
  }
}

/// Counts answers from sorted endpoints: the intervals that neither end below nor begin above the
/// query.
class AnswerCounter
{
public:
  explicit AnswerCounter(const IntervalVector& intervals)
  {
    for (const KeyInterval& interval : intervals)
    {
      this->Minima.push_back(interval.Minimum);
      this->Maxima.push_back(interval.Maximum);
    }
    std::sort(this->Minima.begin(), this->Minima.end());
    std::sort(this->Maxima.begin(), this->Maxima.end());
  }
  std::uint64_t Count(ValueKey low, ValueKey high) const
  {
    const auto begun = std::upper_bound(this->Minima.begin(), this->Minima.end(), high);
    const auto ended = std::lower_bound(this->Maxima.begin(), this->Maxima.end(), low);
    return static_cast<std::uint64_t>(
      (begun - this->Minima.begin()) - (ended - this->Maxima.begin()));
  }

private:
  std::vector<ValueKey> Minima, Maxima;
};

/// The maximum costs measured, as fractions of the bounds.
struct Worst
{
  double Stabbing = 0;    // page reads / (7 log_B max(N, B) + 2 T/B)
  double Overlapping = 0; // page reads / (15 log_B max(N, B) + 6 T/B)
  double Pages = 0;       // (pages - 2) B / N
};

void CheckBounds(
  const IntervalSet& set, std::uint64_t count, int queries, std::uint32_t pageSize, Worst& worst)
{
  MemoryDisk disk;
  const IntervalVector intervals = set.MakeAll(count);
  ASSERT_TRUE(WriteTree(disk, "tree", intervals, TestMemoryLimit, pageSize).IsOk());
  const auto tree = Require(ExternalIntervalTree::Open(disk, "tree", 0));
  const AnswerCounter counter(intervals);
  const double n = static_cast<double>(count);
  const double b = tree->GetRecordsPerPage();
  const double s = 2 * std::floor(std::sqrt(b));
  const double logarithm = std::log(std::max(n, b)) / std::log(b);
  double height = 0;
  for (double leaves = b; leaves < n; leaves *= s)
  {
    ++height;
  }
  EXPECT_LE(static_cast<double>(tree->GetPageCount()), 16 * n / b + 2) << set.Name << " " << count;
  if (count > 10 * b)
  {
    worst.Pages = std::max(worst.Pages, static_cast<double>(tree->GetPageCount() - 2) * b / n);
  }

  std::mt19937_64 random(count);
  std::uint64_t found = 0;
  const auto visit = [&found](const KeyInterval&) { ++found; };
  for (int query = 0; query < queries; ++query)
  {
    ValueKey low = MakeQueryKey(intervals, random);
    PageStatistics statistics;
    found = 0;
    ASSERT_TRUE(tree->FindStabbed(low, visit, statistics).IsOk());
    ASSERT_EQ(found, counter.Count(low, low)) << set.Name << " " << count << " at " << low;
    double t = static_cast<double>(found);
    double reads = static_cast<double>(statistics.PageReads);
    ASSERT_LE(reads, 1 + 4 * height + 2 * t / b) << set.Name << " " << count << " at " << low;
    ASSERT_LE(reads, 7 * logarithm + 2 * t / b) << set.Name << " " << count << " at " << low;
    if (found == 0)
    {
      ASSERT_LE(reads, height + 1) << set.Name << " " << count << " at " << low;
    }
    worst.Stabbing = std::max(worst.Stabbing, reads / (7 * logarithm + 2 * t / b));

    ValueKey high = MakeQueryKey(intervals, random);
    if (low > high)
    {
      std::swap(low, high);
    }
    statistics = PageStatistics();
    found = 0;
    ASSERT_TRUE(tree->FindOverlapping(low, high, visit, statistics).IsOk());
    ASSERT_EQ(found, counter.Count(low, high)) << set.Name << " " << count;
    t = static_cast<double>(found);
    reads = static_cast<double>(statistics.PageReads);
    ASSERT_LE(reads, 2 + 9 * height + 6 * t / b) << set.Name << " " << count;
    ASSERT_LE(reads, 15 * logarithm + 6 * t / b) << set.Name << " " << count;
    worst.Overlapping = std::max(worst.Overlapping, reads / (15 * logarithm + 6 * t / b));
    query += static_cast<int>(found / 20000); // fewer queries if the answers are large
  }
}

void Record(const Worst& worst)
{
  testing::Test::RecordProperty("StabbingShareOfBound", std::to_string(worst.Stabbing));
  testing::Test::RecordProperty("OverlappingShareOfBound", std::to_string(worst.Overlapping));
  testing::Test::RecordProperty("PagesPerFullPageOfIntervals", std::to_string(worst.Pages));
}

} // namespace

TEST(ExternalIntervalTreeBounds, PageReadsAndPagesStayWithinTheirBounds)
{
  Worst worst;
  for (const IntervalSet& set : MakeIntervalSets())
  {
    for (const std::uint64_t count : { 0, 1, 2, 203, 204, 205, 408, 409, 1000, 5712, 5713, 30000 })
    {
      CheckBounds(set, count, LongTests ? 200 : 50, 4096, worst);
    }
    CheckBounds(set, 100000, 100, 4096, worst);
    CheckBounds(set, 50000, 50, 16384, worst);
  }
  Record(worst);
}

TEST(ExternalIntervalTreeBounds, PageReadsOfAMillionIntervalsStayWithinTheirBounds)
{
  Worst worst;
  for (const IntervalSet& set : MakeIntervalSets())
  {
    if (set.Name == "AnyToAny" || set.Name == "AllScales" || set.Name == "MostlyBackground")
    {
      CheckBounds(set, 1000003, 200, 4096, worst);
    }
  }
  Record(worst);
}

TEST(ExternalIntervalTreeBounds, AMillionIntervalsAreBuiltWithinFourMebibytes)
{
  CheckMemory(1000000, std::size_t(4) << 20);
}

TEST(ExternalIntervalTreeBounds, TheMinimumMemoryLimitIsKept)
{
  CheckMemory(100000, ExternalIntervalTreeBuilder::MinimumMemoryLimit);
}

// Takes about a minute and 2 GB of disk: run with --gtest_also_run_disabled_tests.
TEST(ExternalIntervalTreeBounds, DISABLED_TenMillionIntervalsAreBuiltWithin32Mebibytes)
{
  CheckMemory(10000000, std::size_t(32) << 20);
}
