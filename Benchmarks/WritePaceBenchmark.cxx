// SPDX-License-Identifier: BSD-3-Clause
// Seconds to write a blocked volume from a raw file, against `cp` of that file in the same run, the
// page cache empty of the file before each; and the peak of resident memory of every write, which
// runs in a process of its own. Ranks are threads of that process.
#include "BenchmarkVolume.h"

#include "Base/FileSystem.h"
#include "Base/ParallelFor.h"
#include "Source/RawVolume.h"
#include "Store/BlockedVolumeWriter.h"
#include "ThreadCommunicator.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace
{

struct Options
{
  std::string Folder = ".";
  int Side = 1024;
  std::vector<int> Ranks = { 1, 2 };
  std::vector<int> Threads = { 1, 2 };
  std::uint32_t Stores = 8;
  int BlockSize = 32;
  std::uint64_t MemoryMiB = 1024;
  int Repeats = 3;
  bool KeepFile = false;
};

double Time(const std::function<bool()>& body)
{
  const auto begin = std::chrono::steady_clock::now();
  if (!body())
  {
    std::fprintf(stderr, "a step failed\n");
    std::exit(1);
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool MakeFile(const std::string& path, int side)
{
  const auto volume = isosurface::MakeBenchmarkVolume(side, isosurface::ChooseThreadCount(1));
  auto file = isosurface::GetLocalFileSystem().CreateForWriting(path);
  return file.IsOk() && (*file)->Append(volume.data(), volume.size() * 2).IsOk() &&
    (*file)->SyncAndClose().IsOk();
}

/// Makes the next reading of a file come from the disk.
void ForgetPages(const std::string& path)
{
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file >= 0)
  {
    ::fsync(file);
    ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    ::close(file);
  }
}

bool WriteVolume(
  const Options& options, const std::string& from, const std::string& to, int ranks, int threads)
{
  const std::int64_t last = options.Side - 1;
  isosurface::RawVolume raw;
  raw.Grid.Extent = { 0, last, 0, last, 0, last };
  raw.Type = isosurface::ValueType::UInt16;
  raw.Paths = { from };
  isosurface::BlockedVolumeSettings settings;
  settings.BlockSize = options.BlockSize;
  settings.NumberOfStores = options.Stores;
  settings.MemoryLimit = options.MemoryMiB << 20;
  settings.Threads = threads;
  std::atomic<bool> isDone{ true };
  isosurface::ThreadCommunicator::Run(ranks,
    [&](isosurface::Communicator& communicator)
    {
      auto source = raw.Open(isosurface::GetLocalFileSystem());
      const auto written = source.IsOk()
        ? isosurface::BlockedVolumeWriter(communicator)
            .Write(to, raw.Grid, { { "density", raw.Type } }, **source, settings)
        : source.GetStatus();
      if (!written.IsOk())
      {
        std::fprintf(stderr, "%s\n", written.GetStatus().GetMessage().c_str());
        isDone = false;
      }
    });
  return isDone;
}

/// Runs a step in a process of its own; returns its peak of resident memory in MiB.
double RunApart(const std::function<bool()>& body)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    ::_exit(body() ? 0 : 1);
  }
  int state = 1;
  rusage usage = {};
  ::wait4(child, &state, 0, &usage);
  return state == 0 ? static_cast<double>(usage.ru_maxrss) / 1024 : -1;
}

double TakeMedian(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void RemoveVolume(const std::string& path)
{
  for (const std::string& part : { path, path + ".stores" })
  {
    static_cast<void>(isosurface::GetLocalFileSystem().RemoveAll(part));
  }
}

void Measure(const Options& options, const std::string& from)
{
  const std::string copy = from + ".copy";
  const std::string volume = from + ".bvol";
  std::vector<double> copying;
  std::vector<double> syncing;
  for (int repeat = 0; repeat < options.Repeats; ++repeat)
  {
    ForgetPages(from);
    copying.push_back(
      Time([&] { return std::system(("cp '" + from + "' '" + copy + "'").c_str()) == 0; }));
    syncing.push_back(
      copying.back() + Time([&] { return std::system(("sync '" + copy + "'").c_str()) == 0; }));
    static_cast<void>(isosurface::GetLocalFileSystem().RemoveAll(copy));
  }
  const double cp = TakeMedian(copying);
  std::printf(
    "%-28s %7.2f s\n%-28s %7.2f s\n", "cp", cp, "cp, then sync of the copy", TakeMedian(syncing));
  for (const int ranks : options.Ranks)
  {
    for (const int threads : options.Threads)
    {
      std::vector<double> seconds;
      double peak = 0;
      for (int repeat = 0; repeat < options.Repeats; ++repeat)
      {
        ForgetPages(from);
        seconds.push_back(Time(
          [&]
          {
            const double used =
              RunApart([&] { return WriteVolume(options, from, volume, ranks, threads); });
            peak = std::max(peak, used);
            return used >= 0;
          }));
        RemoveVolume(volume);
      }
      const double median = TakeMedian(seconds);
      std::printf("%d ranks of %d threads         %7.2f s = %.2f x cp, %.0f MB/s, peak %.0f MiB\n",
        ranks, threads, median, median / cp,
        2e-6 * options.Side * options.Side * options.Side / median, peak);
      std::fflush(stdout);
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Writes a raw uint16 file as a blocked volume, against cp of the file.");
  app.add_option("--folder", options.Folder, "where the file and the volume are made");
  app.add_option("--side", options.Side, "vertices a side (1024: 2 GB)");
  app.add_option("--ranks", options.Ranks, "numbers of ranks");
  app.add_option("--threads", options.Threads, "numbers of threads a rank");
  app.add_option("--stores", options.Stores, "stores");
  app.add_option("--block-size", options.BlockSize, "cells along the side of a block");
  app.add_option("--memory", options.MemoryMiB, "MiB that a rank may take");
  app.add_option("--repeats", options.Repeats, "measurements, of which the median is told");
  app.add_flag("--keep", options.KeepFile, "keep the file for the next run");
  CLI11_PARSE(app, argc, argv);
  const std::string from = options.Folder + "/write-pace-" + std::to_string(options.Side) + ".raw";
  if (!isosurface::GetLocalFileSystem().Exists(from) && !MakeFile(from, options.Side))
  {
    std::fprintf(stderr, "%s cannot be made\n", from.c_str());
    return 1;
  }
  Measure(options, from);
  if (!options.KeepFile)
  {
    static_cast<void>(isosurface::GetLocalFileSystem().RemoveAll(from));
  }
  return 0;
}
