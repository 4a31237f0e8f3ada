// SPDX-License-Identifier: BSD-3-Clause
// Measures how evenly a query is spread over stores that have each block once, twice, or three
// times: the maximum number of triangles of a store, relative to the mean, for all isovalues of the
// spectrum with enough active blocks a store; also if a store is lost. It is that of ranks that
// have a store each, and of the stores that ranks read which share the blocks. The volume is read
// once.
#include "MeasuredVolume.h"

#include "Ground/Base/ParallelFor.h"
#include "Ranks/Sharing/ReplicaBalance.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

struct Options
{
  std::string Volume;
  std::vector<std::uint32_t> Stores = { 8, 32, 96 };
  std::vector<std::string> Methods = { "greedy", "balanced" };
  std::uint64_t MinimumBlocks = 30;
  int Threads = ChooseThreadCount(1);
};

/// Blocks of a volume in stores, each of which has replicas.
struct ReplicatedStores
{
  std::uint32_t Stores;
  std::uint32_t Replicas;
  std::optional<std::uint32_t> Lost;
  std::vector<std::vector<std::size_t>> Blocks; ///< per store, by ordinal

  std::vector<ReplicaServer> ListServers(std::uint32_t store) const
  {
    std::vector<ReplicaServer> servers;
    for (std::uint32_t replica = 0; replica < this->Replicas; ++replica)
    {
      const std::uint32_t host = FindHost(store, replica, this->Stores);
      if (host != this->Lost)
      {
        servers.push_back({ host, replica });
      }
    }
    return servers;
  }

  /// The maximum of the hosts' triangles over their mean; nothing of small surfaces.
  std::optional<double> Measure(
    const BlockSpectra& spectra, std::size_t bin, std::uint64_t minimumBlocks) const
  {
    std::vector<std::uint64_t> work(this->Stores, 0);
    std::vector<std::vector<std::uint32_t>> active(this->Stores);
    std::vector<std::vector<ReplicaServer>> servers;
    std::uint64_t sum = 0;
    std::uint64_t activeBlocks = 0;
    for (std::uint32_t store = 0; store < this->Stores; ++store)
    {
      const std::vector<std::size_t>& blocks = this->Blocks[store];
      for (std::uint32_t ordinal = 0; ordinal < blocks.size(); ++ordinal)
      {
        if (const std::uint64_t triangles = spectra.GetTriangles(blocks[ordinal], bin))
        {
          work[store] += triangles;
          active[store].push_back(ordinal);
          ++activeBlocks;
        }
      }
      sum += work[store];
      servers.push_back(this->ListServers(store));
    }
    if (activeBlocks < minimumBlocks * this->Stores || sum == 0)
    {
      return std::nullopt;
    }
    const auto shares =
      BalanceReplicas(work, servers, this->Stores, FindTolerance(activeBlocks, this->Stores));
    std::vector<std::uint64_t> loads(this->Stores, 0);
    for (std::uint32_t store = 0; store < this->Stores; ++store)
    {
      const std::vector<std::uint32_t> owners = ShareBlocks(active[store], shares[store]);
      for (std::size_t index = 0; index < owners.size(); ++index)
      {
        loads[servers[store][owners[index]].Server] +=
          spectra.GetTriangles(this->Blocks[store][active[store][index]], bin);
      }
    }
    const double hosts = this->Lost ? this->Stores - 1 : this->Stores;
    return static_cast<double>(*std::max_element(loads.begin(), loads.end())) * hosts /
      static_cast<double>(sum);
  }
};

double GetQuantile(const std::vector<double>& sorted, double fraction)
{
  return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
}

void Print(const Options& options, const MeasuredVolume& volume, const std::string& method,
  const ReplicatedStores& stores)
{
  std::vector<std::optional<double>> ratios(volume.Spectra.GetBins().Count);
  ParallelFor(ratios.size(), options.Threads,
    [&](std::size_t bin, int)
    { ratios[bin] = stores.Measure(volume.Spectra, bin, options.MinimumBlocks); });
  std::vector<double> found;
  for (const std::optional<double>& ratio : ratios)
  {
    if (ratio)
    {
      found.push_back(*ratio);
    }
  }
  std::sort(found.begin(), found.end());
  if (found.empty())
  {
    return;
  }
  const auto uneven =
    std::count_if(found.begin(), found.end(), [](double ratio) { return ratio > 1.1; });
  std::printf("| %u | %s | %u%s | %zu | %.3f, %.3f, %.2f | %td |\n", stores.Stores, method.c_str(),
    stores.Replicas, stores.Lost ? ", one store lost" : "", found.size(), GetQuantile(found, 0.5),
    GetQuantile(found, 0.9), GetQuantile(found, 1), uneven);
  std::fflush(stdout);
}

void Compare(const Options& options, const MeasuredVolume& volume)
{
  std::printf(
    "%s: %zu blocks. Triangles, maximum over mean of the stores: median, 9th decile, maximum "
    "over all isovalues\n"
    "| stores | distribution | replicas | isovalues | triangles | > 1.10 |\n"
    "|---|---|---|---|---|---|\n",
    options.Volume.c_str(), volume.Spectra.GetNumberOfBlocks());
  for (const std::uint32_t stores : options.Stores)
  {
    for (const std::string& method : options.Methods)
    {
      const auto blockStores = volume.Distribute(*FindDistribution(method), stores);
      ReplicatedStores replicated = { stores, 1, std::nullopt, {} };
      replicated.Blocks.resize(stores);
      for (std::size_t block = 0; block < blockStores.size(); ++block)
      {
        replicated.Blocks[blockStores[block]].push_back(block);
      }
      for (const std::uint32_t replicas : { 1U, 2U, 3U })
      {
        replicated.Replicas = replicas;
        replicated.Lost.reset();
        Print(options, volume, method, replicated);
        if (replicas > 1)
        {
          replicated.Lost = stores / 2;
          Print(options, volume, method, replicated);
        }
      }
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Measures how evenly queries are spread over stores with replicas.");
  app.add_option("volume", options.Volume, ".bvol")->required();
  app.add_option("--stores", options.Stores, "numbers of stores")->check(CLI::Range(3, 4096));
  app.add_option("--distributions", options.Methods, "slab, random, greedy, balanced")
    ->check(CLI::IsMember({ "slab", "random", "greedy", "balanced" }));
  app.add_option(
    "--least", options.MinimumBlocks, "minimum active blocks a store of an isosurface");
  app.add_option("--threads", options.Threads, "threads")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const auto volume = MeasuredVolume::Read(options.Volume, options.Threads);
  if (!volume.IsOk())
  {
    std::fprintf(stderr, "%s\n", volume.GetStatus().GetMessage().c_str());
    return EXIT_FAILURE;
  }
  Compare(options, *volume);
  return EXIT_SUCCESS;
}
