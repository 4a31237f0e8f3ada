// SPDX-License-Identifier: BSD-3-Clause
#include "AllocationCounter.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/Require.h"
#include "IntervalSets.h"

#include <atomic>
#include <memory>
#include <thread>

using namespace isosurface;

namespace
{

using TreePointer = std::unique_ptr<ExternalIntervalTree>;

TreePointer MakeTree(MemoryDisk& disk, const IntervalVector& intervals,
  std::uint32_t pageSize = PagedFile::DefaultPageSize, std::size_t cacheBytes = 0)
{
  const Status written = WriteTree(disk, "tree", intervals, TestMemoryLimit, pageSize);
  EXPECT_TRUE(written.IsOk()) << written.GetMessage();
  auto tree = ExternalIntervalTree::Open(disk, "tree", cacheBytes);
  EXPECT_TRUE(tree.IsOk()) << tree.GetStatus().GetMessage();
  return tree.IsOk() ? std::move(*tree) : nullptr;
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
  const TreePointer tree = MakeTree(disk, intervals, pageSize);
  ASSERT_TRUE(tree);
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

TEST(ExternalIntervalTree, StabbingQueryEqualsBruteForce)
{
  // 21 sets x 5,000 = 105,000 queries; in short tests a fifth of these.
  const int divisor = LongTests ? 1 : 5;
  for (const IntervalSet& set : MakeIntervalSets())
  {
    for (const auto& [count, queries] : { std::pair(0, 50), std::pair(1, 150), std::pair(204, 300),
           std::pair(205, 500), std::pair(3000, 3000), std::pair(12000, 1000) })
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(static_cast<std::uint64_t>(count));
      const TreePointer tree = MakeTree(disk, intervals);
      ASSERT_TRUE(tree);
      ASSERT_EQ(tree->GetCount(), intervals.size());
      std::mt19937_64 random(1);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < queries / divisor; ++query)
      {
        const ValueKey key = MakeQueryKey(intervals, random);
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, key, key, statistics, found), "")
          << set.Name << " " << count;
      }
    }
  }
}

TEST(ExternalIntervalTree, OverlapQueryEqualsBruteForce)
{
  for (const IntervalSet& set : MakeIntervalSets())
  {
    for (const auto& [count, queries] :
      { std::pair(0, 50), std::pair(1, 100), std::pair(500, 300), std::pair(9000, 400) })
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(static_cast<std::uint64_t>(count));
      const TreePointer tree = MakeTree(disk, intervals);
      ASSERT_TRUE(tree);
      std::mt19937_64 random(2);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < queries; ++query)
      {
        ValueKey low = MakeQueryKey(intervals, random);
        ValueKey high = query % 3 ? MakeQueryKey(intervals, random) : low + random() % 8;
        if (low > high)
        {
          std::swap(low, high);
        }
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, high, statistics, found), "")
          << set.Name << " " << count;
      }
      ASSERT_EQ(CompareWithBruteForce(*tree, intervals, 0, MaximumKey, statistics, found), "");
      ASSERT_EQ(found, intervals.size());
    }
  }
}

TEST(ExternalIntervalTree, LargerPagesGiveTheSameAnswers)
{
  for (const std::uint32_t pageSize : { 8192u, 16384u })
  {
    for (const IntervalSet& set : MakeIntervalSets())
    {
      MemoryDisk disk;
      const IntervalVector intervals = set.MakeAll(5000);
      const TreePointer tree = MakeTree(disk, intervals, pageSize);
      ASSERT_TRUE(tree);
      std::mt19937_64 random(3);
      PageStatistics statistics;
      std::uint64_t found = 0;
      for (int query = 0; query < 100; ++query)
      {
        const ValueKey low = MakeQueryKey(intervals, random);
        const ValueKey high = std::max(low, MakeQueryKey(intervals, random));
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, low, statistics, found), "");
        ASSERT_EQ(CompareWithBruteForce(*tree, intervals, low, high, statistics, found), "");
      }
    }
  }
}

TEST(ExternalIntervalTree, AnEmptyRangeOverlapsNothing)
{
  MemoryDisk disk;
  const TreePointer tree = MakeTree(disk, { { 5, 9, 0 } });
  ASSERT_TRUE(tree);
  PageStatistics statistics;
  int found = 0;
  ASSERT_TRUE(tree
                ->FindOverlapping(
                  8, 7, [&](const KeyInterval&) { ++found; }, statistics)
                .IsOk());
  EXPECT_EQ(found, 0);
}

TEST(ExternalIntervalTree, PageReadsAndPagesStayWithinTheirBounds)
{
  if (!AllocationCounter::IsCounting())
  {
    GTEST_SKIP() << "takes minutes with sanitizers, which do not change the numbers of pages";
  }
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

TEST(ExternalIntervalTree, PageReadsOfAMillionIntervalsStayWithinTheirBounds)
{
  if (!AllocationCounter::IsCounting())
  {
    GTEST_SKIP() << "takes minutes with sanitizers, which do not change the numbers of pages";
  }
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

TEST(ExternalIntervalTree, TheCacheSavesReadsWithinItsBudget)
{
  MemoryDisk disk;
  const IntervalVector intervals = MakeIntervalSets()[0].MakeAll(20000);
  ASSERT_TRUE(WriteTree(disk, "tree", intervals).IsOk());
  PageStatistics first, second;
  std::uint64_t found = 0;
  auto large = Require(ExternalIntervalTree::Open(disk, "tree", std::size_t(64) << 20));
  EXPECT_EQ(CompareWithBruteForce(*large, intervals, 5, MaximumKey / 2, first, found), "");
  EXPECT_EQ(CompareWithBruteForce(*large, intervals, 5, MaximumKey / 2, second, found), "");
  EXPECT_GT(first.PageReads, 0u);
  EXPECT_EQ(second.PageReads, 0u);
  EXPECT_EQ(second.CacheHits, first.PageReads + first.CacheHits);

  // With room for two pages only, answers remain right, and a long query evicts the pages of a
  // short one.
  auto small = Require(ExternalIntervalTree::Open(disk, "tree", 10000));
  PageStatistics third;
  EXPECT_EQ(CompareWithBruteForce(*small, intervals, 5, MaximumKey / 2, third, found), "");
  EXPECT_EQ(CompareWithBruteForce(*small, intervals, 5, MaximumKey / 2, third, found), "");
  EXPECT_GE(third.PageReads + 4, 2 * first.PageReads);
}

TEST(ExternalIntervalTree, ManyThreadsMayQueryOneTree)
{
  MemoryDisk disk;
  const IntervalVector intervals = MakeIntervalSets()[0].MakeAll(5000);
  const TreePointer tree = MakeTree(disk, intervals, 4096, 40000);
  ASSERT_TRUE(tree);
  std::atomic<int> faults(0);
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    threads.emplace_back(
      [&, seed]
      {
        std::mt19937_64 random(seed);
        PageStatistics statistics;
        std::uint64_t found = 0;
        for (int query = 0; query < 100; ++query)
        {
          const ValueKey key = MakeQueryKey(intervals, random);
          faults += !CompareWithBruteForce(*tree, intervals, key, key, statistics, found).empty();
        }
      });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(faults, 0);
}
