// SPDX-License-Identifier: BSD-3-Clause
// Measures how evenly each distribution spreads isosurfaces over stores: the maximum number of
// triangles, active blocks and bytes of a store, relative to the mean, for all isovalues of the
// spectrum with enough triangles a store. The volume is read once; its blocks are distributed in
// memory.
#include "Volumes/MeasuredVolume.h"
#include "Volumes/VolumeQuery.h"

#include "Ground/Base/ParallelFor.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

struct Options
{
  std::string Volume;
  std::vector<std::uint32_t> Stores = { 8, 32, 96, 1024 };
  std::vector<std::string> Methods = { "slab", "random", "greedy", "balanced" };
  double MinimumTriangles = 1000;
  int BlockSize = 32;
  std::string Scratch = ".";
  std::string Table;
  std::string Curves;
  std::uint32_t CurveStores = 32;
  int Threads = ChooseThreadCount(1);
};

/// The maximum of the stores over their mean, by isovalue.
struct Balance
{
  std::vector<double> Triangles;
  std::vector<double> ActiveBlocks;
  std::vector<double> Bytes;
  std::vector<double> Bound; ///< lower bound of Triangles for any distribution
};

std::FILE* OpenTable(const std::string& path, const char* columns)
{
  std::FILE* file = path.empty() ? nullptr : std::fopen(path.c_str(), "w");
  if (!path.empty() && !file)
  {
    std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
    std::exit(EXIT_FAILURE);
  }
  if (file)
  {
    std::fprintf(file, "%s\n", columns);
  }
  return file;
}

double GetQuantile(std::vector<double> values, double fraction)
{
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1))];
}

Balance Judge(const Options& options, const StoreLoads& loads,
  const std::vector<std::uint64_t>& bounds, const std::string& method, std::FILE* table)
{
  Balance balance;
  const auto stores = static_cast<double>(loads.Stores.size());
  for (std::size_t bin = 0; bin < loads.Bins.Count; ++bin)
  {
    const IsosurfaceLoad total = loads.GetTotal(bin);
    const auto triangles = static_cast<double>(total.Triangles);
    if (triangles < options.MinimumTriangles * stores || total.Triangles == 0)
    {
      continue;
    }
    const IsosurfaceLoad maximum = loads.GetMaximum(bin);
    const auto divideByMean = [&](std::uint64_t load, std::uint64_t sum)
    { return static_cast<double>(load) * stores / static_cast<double>(sum); };
    balance.Triangles.push_back(divideByMean(maximum.Triangles, total.Triangles));
    balance.ActiveBlocks.push_back(divideByMean(maximum.ActiveBlocks, total.ActiveBlocks));
    balance.Bytes.push_back(divideByMean(maximum.Bytes, total.Bytes));
    balance.Bound.push_back(divideByMean(bounds[bin], total.Triangles));
    if (table)
    {
      std::fprintf(table, "%zu,%s,%.17g,%llu,%llu,%llu,%llu,%llu,%llu,%llu\n", loads.Stores.size(),
        method.c_str(), loads.Bins.GetEdge(bin), static_cast<unsigned long long>(total.Triangles),
        static_cast<unsigned long long>(total.ActiveBlocks),
        static_cast<unsigned long long>(total.Bytes),
        static_cast<unsigned long long>(maximum.Triangles),
        static_cast<unsigned long long>(maximum.ActiveBlocks),
        static_cast<unsigned long long>(maximum.Bytes),
        static_cast<unsigned long long>(bounds[bin]));
    }
  }
  return balance;
}

void PrintBalance(std::uint32_t stores, const std::string& method, const Balance& balance)
{
  if (balance.Triangles.empty())
  {
    std::printf("| %u | %s | 0 | | | | | |\n", stores, method.c_str());
    return;
  }
  std::size_t uneven = 0;
  std::size_t unavoidable = 0;
  double excess = 0;
  for (std::size_t n = 0; n < balance.Triangles.size(); ++n)
  {
    uneven += balance.Triangles[n] > 1.1 ? 1 : 0;
    unavoidable += balance.Bound[n] > 1.1 ? 1 : 0;
    excess = std::max(excess, balance.Triangles[n] / balance.Bound[n]);
  }
  std::printf("| %u | %s | %zu | %.3f, %.3f, %.2f | %.3f, %.3f, %.2f | %.3f, %.3f, %.2f | %zu "
              "(%zu) | %.2f |\n",
    stores, method.c_str(), balance.Triangles.size(), GetQuantile(balance.Triangles, 0.5),
    GetQuantile(balance.Triangles, 0.9), GetQuantile(balance.Triangles, 1),
    GetQuantile(balance.ActiveBlocks, 0.5), GetQuantile(balance.ActiveBlocks, 0.9),
    GetQuantile(balance.ActiveBlocks, 1), GetQuantile(balance.Bytes, 0.5),
    GetQuantile(balance.Bytes, 0.9), GetQuantile(balance.Bytes, 1), uneven, unavoidable, excess);
  std::fflush(stdout);
}

void WriteCurves(const StoreLoads& loads, const std::string& method, std::FILE* curves)
{
  for (std::size_t store = 0; store < loads.Stores.size(); ++store)
  {
    for (std::size_t bin = 0; bin < loads.Bins.Count; ++bin)
    {
      const IsosurfaceLoad& load = loads.Stores[store][bin];
      std::fprintf(curves, "%s,%zu,%.17g,%llu,%llu,%llu\n", method.c_str(), store,
        loads.Bins.GetEdge(bin), static_cast<unsigned long long>(load.Triangles),
        static_cast<unsigned long long>(load.ActiveBlocks),
        static_cast<unsigned long long>(load.Bytes));
    }
  }
}

void Compare(const Options& options, const MeasuredVolume& volume)
{
  std::FILE* table = OpenTable(options.Table,
    "stores,distribution,isovalue,triangles,activeBlocks,bytes,greatestTriangles,"
    "greatestActiveBlocks,greatestBytes,leastGreatestTriangles");
  std::FILE* curves =
    OpenTable(options.Curves, "distribution,store,isovalue,triangles,activeBlocks,bytes");
  std::printf("%s: %zu blocks. Maximum over mean of the stores: median, 9th decile, maximum over "
              "all isovalues\n"
              "| stores | distribution | isovalues | triangles | active blocks | bytes | triangles "
              "> 1.10 (unavoidable) | maximum over the bound |\n"
              "|---|---|---|---|---|---|---|---|\n",
    options.Volume.c_str(), volume.Spectra.GetNumberOfBlocks());
  for (const std::uint32_t stores : options.Stores)
  {
    std::vector<std::uint64_t> bounds(volume.Spectra.GetBins().Count);
    ParallelFor(bounds.size(), options.Threads,
      [&](std::size_t bin, int) { bounds[bin] = volume.Spectra.GetMaximumBound(bin, stores); });
    for (const std::string& method : options.Methods)
    {
      const double start = GetSeconds();
      const auto blockStores = volume.Distribute(*FindDistribution(method), stores);
      const double seconds = GetSeconds() - start;
      const StoreLoads loads = volume.Spectra.Distribute(blockStores, stores);
      PrintBalance(stores, method, Judge(options, loads, bounds, method, table));
      std::fprintf(
        stderr, "%u stores, %s: distributed in %.2f s\n", stores, method.c_str(), seconds);
      if (curves && stores == options.CurveStores)
      {
        WriteCurves(loads, method, curves);
      }
    }
  }
  for (std::FILE* file : { table, curves })
  {
    if (file && std::fclose(file) != 0)
    {
      std::fprintf(stderr, "a table cannot be written\n");
      std::exit(EXIT_FAILURE);
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Measures how evenly each distribution spreads isosurfaces over stores.");
  app
    .add_option("volume", options.Volume, ".bvol; or .mhd, .mha, .nrrd, .nhdr, to be written first")
    ->required();
  app.add_option("--stores", options.Stores, "numbers of stores")->check(CLI::PositiveNumber);
  app.add_option("--distributions", options.Methods, "slab, random, greedy, balanced")
    ->check(CLI::IsMember({ "slab", "random", "greedy", "balanced" }));
  app.add_option("--least", options.MinimumTriangles, "minimum triangles a store of an isosurface");
  app.add_option("--block-size", options.BlockSize, "of a volume to be written: 16, 32, 64");
  app.add_option("--scratch", options.Scratch, "folder for a volume to be written");
  app.add_option("--table", options.Table, "CSV file: a row for each isovalue");
  app.add_option("--curves", options.Curves, "CSV file: a row for each store and isovalue");
  app.add_option("--curve-stores", options.CurveStores, "which of --stores goes to --curves");
  app.add_option("--threads", options.Threads, "threads")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);

  const bool isBlocked = std::filesystem::path(options.Volume).extension() == ".bvol";
  const std::string path = isBlocked ? options.Volume : options.Scratch + "/one-store.bvol";
  Status status;
  if (!isBlocked)
  {
    status = WriteVolume(options.Volume, path, options.BlockSize, 1, options.Threads);
  }
  const auto volume =
    status.IsOk() ? MeasuredVolume::Read(path, options.Threads) : Result<MeasuredVolume>(status);
  if (!isBlocked)
  {
    RemoveVolume(path);
  }
  if (!volume.IsOk())
  {
    std::fprintf(stderr, "%s\n", volume.GetStatus().GetMessage().c_str());
    return EXIT_FAILURE;
  }
  Compare(options, *volume);
  return EXIT_SUCCESS;
}
