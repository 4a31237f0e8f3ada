// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Sharing/BlockClaims.h"

#include <algorithm>
#include <numeric>

namespace isosurface
{
namespace
{

constexpr unsigned BackBits = 32; ///< the number of claimed blocks at the back is above these bits
constexpr std::uint64_t FrontMask = (std::uint64_t{ 1 } << BackBits) - 1;
constexpr std::uint64_t WholeShare = std::uint64_t{ 1 } << 31;

} // namespace

BlockClaims::BlockClaims(SharedCounters& counters, int rank, std::vector<std::size_t> firsts,
  int threads, std::function<void(std::size_t, std::size_t)> announce)
  : Counters(counters)
  , Rank(rank)
  , Firsts(std::move(firsts))
  , Threads(static_cast<std::size_t>(std::max(1, threads)))
  , Announce(std::move(announce))
  , OwnLeft(GetSize(rank))
{
  const auto ranks = static_cast<int>(this->Firsts.size()) - 1;
  for (int step = 1; step < ranks; ++step)
  {
    const int other = (rank + step) % ranks;
    if (this->GetSize(other) > 0)
    {
      this->Others.push_back(other);
    }
  }
}

BlockClaims::Range BlockClaims::FindLeft(int rank, std::uint64_t counter) const
{
  const std::size_t size = this->GetSize(rank);
  const auto front = std::min<std::size_t>(size, counter & FrontMask);
  const auto back = std::min<std::size_t>(size, counter >> BackBits);
  return { front, std::max(front, size - back) };
}

Result<BlockClaims::Range> BlockClaims::ClaimOwn()
{
  constexpr std::size_t part = 16;
  constexpr std::size_t blocksOfThread = 4;
  const std::size_t count =
    std::clamp<std::size_t>(this->OwnLeft / part, 1, blocksOfThread * this->Threads);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto before, this->Counters.Add(this->Rank, count));
  const auto [begin, end] = this->FindLeft(this->Rank, before);
  const Range claimed = { begin, std::min(end, begin + count) };
  this->OwnLeft = end - claimed.second;
  return claimed;
}

Result<BlockClaims::Range> BlockClaims::ClaimOf(int rank, std::size_t left)
{
  constexpr std::size_t blocksOfThread = 32;
  const std::size_t part = 2 * (this->Firsts.size() - 1);
  const std::size_t count = std::clamp<std::size_t>(left / part, 1, blocksOfThread * this->Threads);
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto before, this->Counters.Add(rank, static_cast<std::uint64_t>(count) << BackBits));
  const auto [begin, end] = this->FindLeft(rank, before);
  return Range{ end - std::min(count, end - begin), end };
}

Result<std::pair<int, std::size_t>> BlockClaims::FindMost()
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto counters, this->Counters.Read(this->Others));
  std::pair<int, std::size_t> most = { -1, 0 };
  std::vector<int> others;
  for (std::size_t n = 0; n < this->Others.size(); ++n)
  {
    const auto [begin, end] = this->FindLeft(this->Others[n], counters[n]);
    if (begin < end)
    {
      others.push_back(this->Others[n]);
      most = end - begin > most.second ? std::make_pair(this->Others[n], end - begin) : most;
    }
  }
  this->Others = std::move(others);
  return most;
}

std::vector<std::size_t> BlockClaims::List(int rank, const Range& range) const
{
  std::vector<std::size_t> blocks(range.second - range.first);
  std::iota(
    blocks.begin(), blocks.end(), this->Firsts[static_cast<std::size_t>(rank)] + range.first);
  return blocks;
}

Result<std::vector<std::size_t>> BlockClaims::Take()
{
  if (this->OwnLeft > 0)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto own, this->ClaimOwn());
    if (own.first < own.second)
    {
      return this->List(this->Rank, own);
    }
  }
  while (!this->Others.empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto most, this->FindMost());
    const auto [rank, left] = most;
    if (rank < 0)
    {
      break;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto claimed, this->ClaimOf(rank, left));
    if (claimed.first < claimed.second)
    {
      std::vector<std::size_t> blocks = this->List(rank, claimed);
      if (this->Announce)
      {
        this->Announce(blocks.front(), blocks.back() + 1);
      }
      return blocks;
    }
  }
  return std::vector<std::size_t>();
}

void BlockClaims::Withdraw(SharedCounters& counters, int rank)
{
  // An error of the counter is not worse than the one that this rank has failed with.
  static_cast<void>(counters.Add(rank, WholeShare).IsOk());
}

} // namespace isosurface
