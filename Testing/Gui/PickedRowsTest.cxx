// SPDX-License-Identifier: BSD-3-Clause
#include "PickedRows.h"

#include <gtest/gtest.h>

using isosurface::ChooseIsovalues;
using Values = std::vector<double>;

namespace
{

const Values Column = { 0, 10, 20, 30, 40, 50, 60 };

TEST(PickedRows, ARowAloneIsAnIsovalue)
{
  EXPECT_EQ(ChooseIsovalues(Column, { 3 }), Values({ 30 }));
  EXPECT_EQ(ChooseIsovalues(Column, { 5, 0, 2 }), Values({ 0, 20, 50 }));
}

TEST(PickedRows, RowsInARowAreTheEndsOfTheirRange)
{
  EXPECT_EQ(ChooseIsovalues(Column, { 1, 2, 3, 4 }), Values({ 10, 40 }));
  EXPECT_EQ(ChooseIsovalues(Column, { 2, 3 }), Values({ 20, 30 }));
  EXPECT_EQ(ChooseIsovalues(Column, { 6, 4, 0, 5, 2 }), Values({ 0, 20, 40, 60 }));
}

TEST(PickedRows, RowsThatAreTwiceOrNotThereDoNotCount)
{
  EXPECT_EQ(ChooseIsovalues(Column, { 3, 3, 7, 100 }), Values({ 30 }));
  EXPECT_TRUE(ChooseIsovalues(Column, {}).empty());
  EXPECT_TRUE(ChooseIsovalues({}, { 0, 1 }).empty());
}

} // namespace
