// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Distribution/BlockBalancer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace isosurface
{
namespace
{

/// Candidates for the isovalues. Most are evenly spaced over the range of all values. Others are
/// the middles of block ranges, in case a few extreme values stretch the range.
constexpr std::size_t EvenCandidates = 1536;
constexpr std::size_t BlockCandidates = 192;

/// The indices [begin, end) of the isovalues v with Low < v <= High.
std::array<std::size_t, 2> FindWithin(const std::vector<double>& isovalues, const SampleSpan& span)
{
  const auto begin = std::upper_bound(isovalues.begin(), isovalues.end(), span.Low);
  const auto end = std::upper_bound(begin, isovalues.end(), span.High);
  return { static_cast<std::size_t>(begin - isovalues.begin()),
    static_cast<std::size_t>(end - isovalues.begin()) };
}

/// sum += load^2 * work, for all stores.
void AddProducts(const float* load, float work, std::size_t stores, float* sum)
{
  for (std::size_t store = 0; store < stores; ++store)
  {
    sum[store] += load[store] * load[store] * work;
  }
}

} // namespace

BlockBalancer::BlockBalancer(const std::vector<BlockProfile>& profiles, std::uint32_t stores)
  : Profiles(profiles)
  , Stores(stores)
{
  this->ChooseIsovalues();
  this->FindMeans();
}

std::vector<double> BlockBalancer::FindCandidates() const
{
  std::vector<double> middles;
  SampleSpan span;
  for (const BlockProfile& profile : this->Profiles)
  {
    if (!profile.IsEmpty())
    {
      span.Add(profile.Span);
      middles.push_back(0.5 * profile.Span.Low + 0.5 * profile.Span.High);
    }
  }
  std::vector<double> candidates;
  if (middles.empty())
  {
    return candidates;
  }
  std::sort(middles.begin(), middles.end());
  for (std::size_t n = 0; n < EvenCandidates; ++n)
  {
    const double fraction = (static_cast<double>(n) + 0.5) / EvenCandidates;
    candidates.push_back((1 - fraction) * span.Low + fraction * span.High);
  }
  for (std::size_t n = 0; n < BlockCandidates; ++n)
  {
    candidates.push_back(middles[n * middles.size() / BlockCandidates]);
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  return candidates;
}

void BlockBalancer::ChooseIsovalues()
{
  const std::vector<double> candidates = this->FindCandidates();
  std::vector<double> cubes(candidates.size(), 0);
  for (const BlockProfile& profile : this->Profiles)
  {
    const auto within = FindWithin(candidates, profile.Span);
    for (std::size_t n = within[0]; n < within[1]; ++n)
    {
      cubes[n] += profile.GetCount(candidates[n]);
    }
  }
  // The eighth root, so that small surfaces, the most difficult to spread, get isovalues as well.
  double sum = 0;
  for (double& weight : cubes)
  {
    weight = weight >= MinimumCubes * this->Stores ? std::sqrt(std::sqrt(std::sqrt(weight))) : 0;
    sum += weight;
  }
  double passed = 0;
  for (std::size_t n = 0; n < candidates.size(); ++n)
  {
    passed += cubes[n];
    const double due = (static_cast<double>(this->Values.size()) + 0.5) * sum / Isovalues;
    if (cubes[n] > 0 && passed >= due)
    {
      this->Values.push_back(candidates[n]);
    }
  }
}

void BlockBalancer::FindMeans()
{
  const std::size_t count = this->Values.size();
  this->MeanCubes.assign(count, 0);
  std::vector<double> active(count, 0);
  for (const BlockProfile& profile : this->Profiles)
  {
    const auto within = FindWithin(this->Values, profile.Span);
    for (std::size_t k = within[0]; k < within[1]; ++k)
    {
      this->MeanCubes[k] += profile.GetCount(this->Values[k]) / static_cast<double>(this->Stores);
      active[k] += 1 / static_cast<double>(this->Stores);
    }
  }
  for (std::size_t k = 0; k < count; ++k)
  {
    // With less than one block a store, the load of a block would be very large.
    this->ActiveLoad.push_back(static_cast<float>(ActiveWeight / std::max(1.0, active[k])));
  }
}

BlockBalancer::Work BlockBalancer::GetWork(std::size_t block) const
{
  const BlockProfile& profile = this->Profiles[block];
  const auto within = FindWithin(this->Values, profile.Span);
  Work work{ within[0], within[1], {} };
  for (std::size_t k = work.Begin; k < work.End; ++k)
  {
    work.Cubes.push_back(
      static_cast<float>(profile.GetCount(this->Values[k]) / this->MeanCubes[k]));
  }
  return work;
}

/// By decreasing sum of normalised work.
std::vector<std::uint32_t> BlockBalancer::SortBlocks() const
{
  std::vector<float> sums;
  sums.reserve(this->Profiles.size());
  for (std::size_t block = 0; block < this->Profiles.size(); ++block)
  {
    const Work work = this->GetWork(block);
    sums.push_back(std::accumulate(work.Cubes.begin(), work.Cubes.end(), 0.0F));
  }
  std::vector<std::uint32_t> blocks(this->Profiles.size());
  std::iota(blocks.begin(), blocks.end(), 0u);
  std::sort(blocks.begin(), blocks.end(),
    [&](std::uint32_t a, std::uint32_t b)
    { return sums[a] > sums[b] || (sums[a] == sums[b] && a < b); });
  return blocks;
}

std::uint32_t BlockBalancer::ChooseStore(const Work& work)
{
  std::fill(this->Sums.begin(), this->Sums.end(), 0.0F);
  for (std::size_t k = work.Begin; k < work.End; ++k)
  {
    const std::size_t row = k * this->Stores;
    AddProducts(&this->CubeLoads[row], work.Cubes[k - work.Begin], this->Stores, this->Sums.data());
    AddProducts(&this->ActiveLoads[row], this->ActiveLoad[k], this->Stores, this->Sums.data());
  }
  std::uint32_t best = 0;
  for (std::uint32_t store = 1; store < this->Stores; ++store)
  {
    if (this->Sums[store] < this->Sums[best] ||
      (this->Sums[store] == this->Sums[best] && this->Numbers[store] < this->Numbers[best]))
    {
      best = store;
    }
  }
  return best;
}

std::vector<std::uint32_t> BlockBalancer::Distribute()
{
  this->CubeLoads.assign(this->Values.size() * this->Stores, 0);
  this->ActiveLoads.assign(this->Values.size() * this->Stores, 0);
  this->Sums.resize(this->Stores);
  this->Numbers.assign(this->Stores, 0);
  std::vector<std::uint32_t> result(this->Profiles.size());
  for (const std::uint32_t block : this->SortBlocks())
  {
    const Work work = this->GetWork(block);
    const std::uint32_t store = this->ChooseStore(work);
    for (std::size_t k = work.Begin; k < work.End; ++k)
    {
      const std::size_t load = k * this->Stores + store;
      this->CubeLoads[load] += work.Cubes[k - work.Begin];
      this->ActiveLoads[load] += this->ActiveLoad[k];
    }
    ++this->Numbers[store];
    result[block] = store;
  }
  return result;
}

} // namespace isosurface
