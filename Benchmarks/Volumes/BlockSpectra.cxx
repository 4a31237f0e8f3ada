// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/BlockSpectra.h"

#include <algorithm>
#include <cassert>
#include <functional>

namespace isosurface
{

IsosurfaceLoad StoreLoads::GetTotal(std::size_t bin) const
{
  IsosurfaceLoad total;
  for (const std::vector<IsosurfaceLoad>& store : this->Stores)
  {
    total.Triangles += store[bin].Triangles;
    total.ActiveBlocks += store[bin].ActiveBlocks;
    total.Bytes += store[bin].Bytes;
  }
  return total;
}

IsosurfaceLoad StoreLoads::GetMaximum(std::size_t bin) const
{
  IsosurfaceLoad maximum;
  for (const std::vector<IsosurfaceLoad>& store : this->Stores)
  {
    maximum.Triangles = std::max(maximum.Triangles, store[bin].Triangles);
    maximum.ActiveBlocks = std::max(maximum.ActiveBlocks, store[bin].ActiveBlocks);
    maximum.Bytes = std::max(maximum.Bytes, store[bin].Bytes);
  }
  return maximum;
}

BlockSpectra::BlockSpectra(ValueType type, const SpectrumBins& bins, std::size_t blocks)
  : Type(type)
  , Bins(bins)
  , Blocks(blocks)
{
}

void BlockSpectra::Set(
  std::size_t block, const WorkloadSpectrum& spectrum, const KeyRange& range, std::uint64_t bytes)
{
  assert(spectrum.Bins == this->Bins);
  Block& own = this->Blocks[block];
  own = {};
  own.Bytes = bytes;
  DispatchValueType(this->Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      for (std::uint32_t bin = 0; bin < this->Bins.Count; ++bin)
      {
        const auto threshold = FindThreshold<T>(this->Bins.GetEdge(bin));
        if (threshold && range.Straddles(MakeValueKey(*threshold)))
        {
          own.Begin = own.Triangles.empty() ? bin : own.Begin;
          own.Triangles.push_back(static_cast<std::uint32_t>(spectrum.Triangles[bin]));
        }
      }
    });
}

std::uint64_t BlockSpectra::GetTriangles(std::size_t block, std::size_t bin) const
{
  const Block& own = this->Blocks[block];
  return bin >= own.Begin && bin - own.Begin < own.Triangles.size() ? own.Triangles[bin - own.Begin]
                                                                    : 0;
}

std::uint64_t BlockSpectra::GetMaximumBound(std::size_t bin, std::uint32_t stores) const
{
  std::vector<std::uint64_t> triangles;
  std::uint64_t total = 0;
  for (std::size_t block = 0; block < this->Blocks.size(); ++block)
  {
    const std::uint64_t count = this->GetTriangles(block, bin);
    if (count > 0)
    {
      triangles.push_back(count);
      total += count;
    }
  }
  std::sort(triangles.begin(), triangles.end(), std::greater<>());
  std::vector<std::uint64_t> sums(1, 0); // of the n largest
  for (const std::uint64_t count : triangles)
  {
    sums.push_back(sums.back() + count);
  }
  std::uint64_t bound = (total + stores - 1) / stores;
  for (std::size_t n = 0; n * stores < triangles.size(); ++n)
  {
    const std::size_t end = n * stores + 1;
    bound = std::max(bound, sums[end] - sums[end - (n + 1)]);
  }
  return bound;
}

StoreLoads BlockSpectra::Distribute(
  const std::vector<std::uint32_t>& blockStores, std::uint32_t stores) const
{
  StoreLoads loads;
  loads.Bins = this->Bins;
  loads.Stores.assign(stores, std::vector<IsosurfaceLoad>(this->Bins.Count));
  for (std::size_t block = 0; block < this->Blocks.size(); ++block)
  {
    const Block& own = this->Blocks[block];
    IsosurfaceLoad* load = loads.Stores[blockStores[block]].data() + own.Begin;
    for (const std::uint32_t triangles : own.Triangles)
    {
      load->Triangles += triangles;
      ++load->ActiveBlocks;
      load->Bytes += own.Bytes;
      ++load;
    }
  }
  return loads;
}

} // namespace isosurface
