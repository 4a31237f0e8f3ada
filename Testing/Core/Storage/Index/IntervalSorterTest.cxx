// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalSorter.h"

#include "Fixtures/MemoryDisk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

using namespace isosurface;

namespace
{

using Key = std::tuple<std::uint32_t, ValueKey, ValueKey, std::uint32_t>;

/// The group, then the key of the order; ~ reverses it.
Key MakeKey(const IntervalRecord& record, IntervalSorter::Order order)
{
  return order == IntervalSorter::Order::AscendingMinimum
    ? Key(record.Group, record.Minimum, record.Maximum, record.Payload)
    : Key(record.Group, ~record.Maximum, record.Minimum, record.Payload);
}

} // namespace

TEST(IntervalSorter, GivesAllRecordsInOrderForAnyNumberOfRuns)
{
  for (const auto order :
    { IntervalSorter::Order::AscendingMinimum, IntervalSorter::Order::DescendingMaximum })
  {
    // From no record to several merge passes (8 KiB hold 273 records, a merge takes two runs).
    for (const int count : { 0, 1, 272, 273, 274, 546, 547, 3000, 30000 })
    {
      MemoryDisk disk;
      TemporaryNames names{ disk, "target" };
      std::mt19937_64 random(9);
      std::vector<Key> expected;
      {
        IntervalSorter sorter(names, 8 * 1024, order);
        for (int index = 0; index < count; ++index)
        {
          const IntervalRecord record{ random() % 50, random() % 50,
            static_cast<std::uint32_t>(random() % 3), static_cast<std::uint32_t>(random() % 4) };
          expected.push_back(MakeKey(record, order));
          ASSERT_TRUE(sorter.Add(record).IsOk());
        }
        std::sort(expected.begin(), expected.end());
        ASSERT_TRUE(sorter.Sort().IsOk());
        EXPECT_EQ(sorter.IsInMemory(), count <= 273);
        EXPECT_EQ(sorter.GetCount(), expected.size());
        std::vector<Key> sorted;
        Status status;
        while (const IntervalRecord* record = sorter.Next(status))
        {
          sorted.push_back(MakeKey(*record, order));
        }
        ASSERT_TRUE(status.IsOk());
        ASSERT_EQ(sorted, expected) << count;
      }
      EXPECT_TRUE(disk.GetFiles().empty()) << "a temporary file is left";
    }
  }
}
