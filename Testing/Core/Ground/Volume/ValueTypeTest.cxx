// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/ValueType.h"

#include "Fixtures/SampleVolume.h"

#include <gtest/gtest.h>

#include <vector>

using namespace isosurface;

namespace
{

template <typename... T>
std::vector<ValueType> ListTypes(testing::Types<T...> /*types*/)
{
  return { ValueTypeOf<T>::Value... };
}

} // namespace

TEST(ValueType, EachTypeIsDispatchedAndNamedAndInTheTypedTests)
{
  std::vector<ValueType> types;
  for (std::uint8_t number = 0; GetValueTypeName(static_cast<ValueType>(number)); ++number)
  {
    const auto type = static_cast<ValueType>(number);
    types.push_back(type);
    EXPECT_EQ(FindValueType(GetValueTypeName(type)), type);
    EXPECT_EQ(
      DispatchValueType(type, [](auto zero) { return ValueTypeOf<decltype(zero)>::Value; }), type);
  }
  EXPECT_EQ(ListTypes(AllValueTypes()), types);
  EXPECT_FALSE(FindValueType("Int8").has_value());
}
