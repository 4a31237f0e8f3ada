// SPDX-License-Identifier: BSD-3-Clause
#ifndef LongTests_h
#define LongTests_h

#include <vector>

/// Whether the long variants of tests are wanted (ISOSURFACE_LONG_TESTS of CMake).
constexpr bool LongTests = ISOSURFACE_LONG_TESTS != 0;

/// How many of so many random volumes are looked at.
constexpr int ChooseTrials(int all)
{
  return LongTests ? all : all / 3;
}

/// The numbers of ranks that a claim about any number is tested with: one rank has nobody to talk to,
/// three are fewer than most volumes have stores, seven more.
inline std::vector<int> GetNumbersOfRanks()
{
  return LongTests ? std::vector<int>{ 1, 2, 3, 4, 7 } : std::vector<int>{ 1, 3, 7 };
}

#endif
