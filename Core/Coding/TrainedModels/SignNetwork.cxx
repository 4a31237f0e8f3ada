// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/TrainedModels/SignNetwork.h"

#include "Coding/TrainedModels/TrainedTables.h"

#include <algorithm>
#include <memory>

namespace isosurface
{

namespace
{

// Copies the rows of a table, which stand one after the other.
template <typename Table, typename Rows>
void CopyRows(const Table& table, Rows& rows)
{
  static_assert(sizeof(table) == sizeof(rows), "the table has all rows");
  auto next = table.begin();
  for (auto& row : rows)
  {
    std::copy_n(next, row.size(), row.begin());
    next += static_cast<std::ptrdiff_t>(row.size());
  }
}

} // namespace

const SignNetworkWeights& GetTrainedWeights()
{
  static const auto weights = []
  {
    SignNetworkWeights trained;
    CopyRows(SignNetworkFirst, trained.First);
    CopyRows(SignNetworkSecond, trained.Second);
    trained.SecondAdded = SignNetworkSecondAdded;
    trained.Third = SignNetworkThird;
    trained.ThirdAdded = SignNetworkThirdAdded[0];
    return trained;
  }();
  return weights;
}

SignNetwork::SignNetwork(const SignNetworkWeights& weights)
  : Weights(weights)
{
  std::size_t entry = 0;
  std::size_t input = 0;
  for (std::size_t n = 0; n < this->Begins.size(); ++n)
  {
    this->Begins[n] = entry;
    const auto bits = static_cast<std::size_t>(SignNetworkInputs::Bits[n]);
    for (std::size_t pattern = 0; pattern < std::size_t{ 1 } << bits; ++pattern)
    {
      Sums& sums = this->Table[entry++];
      sums.fill(0);
      for (std::size_t bit = 0; bit < bits; ++bit)
      {
        for (std::size_t i = 0; i < Width && (pattern >> bit & 1) != 0; ++i)
        {
          sums[i] = static_cast<std::int16_t>(sums[i] + weights.First[input + bit][i]);
        }
      }
    }
    input += bits;
  }
}

SignNetwork::Sums SignNetwork::MakeRow(const SignNetworkRow& row) const
{
  Sums sums = this->Weights.First[SignNetworkWeights::NumberOfInputs];
  for (std::size_t n = 0; n < row.size(); ++n)
  {
    const std::size_t input = SignNetworkWeights::NumberOfInputs - row.size() + n;
    for (std::size_t i = 0; i < Width && row[n]; ++i)
    {
      sums[i] = static_cast<std::int16_t>(sums[i] + this->Weights.First[input][i]);
    }
  }
  return sums;
}

const SignNetwork& GetSignNetwork()
{
  static const auto network = std::make_unique<const SignNetwork>(GetTrainedWeights());
  return *network;
}

} // namespace isosurface
