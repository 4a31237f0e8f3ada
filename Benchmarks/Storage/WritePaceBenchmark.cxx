// SPDX-License-Identifier: BSD-3-Clause
// Seconds to write a blocked volume from a raw file, against `cp` of that file. Both take turns;
// the page cache is empty of the file before each, and nothing waits to be written. Every write
// runs in a process of its own, of which the peak of resident memory is told. Ranks are its
// threads.
#include "Volumes/BenchmarkVolume.h"
#include "Volumes/VolumeQuery.h"

#include "Fixtures/ThreadCommunicator.h"
#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/ParallelFor.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

struct Options
{
  std::string Folder = ".";
  std::string File;
  std::vector<std::int64_t> Dimensions = { 1024, 1024, 1024 };
  std::vector<int> Ranks = { 1, 2 };
  int Threads = 0;
  std::vector<std::string> Codecs = { "none", "lz4", "zstd" };
  std::uint32_t Stores = 8;
  int BlockSize = 32;
  std::uint64_t MemoryMiB = 1024;
  int Repeats = 3;

  double GetMegabytes() const
  {
    return 2e-6 * static_cast<double>(this->Dimensions[0]) *
      static_cast<double>(this->Dimensions[1]) * static_cast<double>(this->Dimensions[2]);
  }
};

/// One way to write, and what it took in each round.
struct Way
{
  int Ranks;
  int Threads;
  std::string Codec;
  std::vector<double> Seconds;
  std::vector<double> Ratios; ///< to cp of the same round
  double Peak = 0;            ///< MiB
};

double Time(const std::function<bool()>& body)
{
  const double begin = GetSeconds();
  if (!body())
  {
    std::fprintf(stderr, "a step failed\n");
    std::exit(1);
  }
  return GetSeconds() - begin;
}

bool MakeFile(const std::string& path, int side)
{
  const auto volume = MakeBenchmarkVolume(side, ChooseThreadCount(1));
  auto file = GetLocalFileSystem().CreateForWriting(path);
  return file.IsOk() && (*file)->Append(volume.data(), volume.size() * 2).IsOk() &&
    (*file)->SyncAndClose().IsOk();
}

/// Makes the next reading of a file come from the disk, which has nothing else to do.
void ForgetPages(const std::string& path)
{
  ::sync();
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file >= 0)
  {
    ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    ::close(file);
  }
}

bool WriteVolume(
  const Options& options, const Way& way, const std::string& from, const std::string& to)
{
  RawVolume raw;
  raw.Grid.Extent = { 0, options.Dimensions[0] - 1, 0, options.Dimensions[1] - 1, 0,
    options.Dimensions[2] - 1 };
  raw.Type = ValueType::UInt16;
  raw.Paths = { from };
  BlockedVolumeSettings settings;
  settings.BlockSize = options.BlockSize;
  settings.NumberOfStores = options.Stores;
  settings.MemoryLimit = options.MemoryMiB << 20;
  settings.Threads = way.Threads;
  settings.Compression.Codec = *FindCodec(way.Codec);
  std::atomic<bool> isDone{ true };
  ThreadCommunicator::Run(way.Ranks,
    [&](Communicator& communicator)
    {
      auto source = raw.Open(GetLocalFileSystem());
      const Status written = source.IsOk()
        ? BlockedVolumeWriter(communicator)
            .Write(to, raw.Grid, { { "density", raw.Type } }, **source, settings)
            .GetStatus()
        : source.GetStatus();
      if (!written.IsOk())
      {
        std::fprintf(stderr, "%s\n", written.GetMessage().c_str());
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

double TimeCopy(const std::string& from, const std::string& to, double& withSync)
{
  ForgetPages(from);
  const double seconds =
    Time([&] { return std::system(("cp '" + from + "' '" + to + "'").c_str()) == 0; });
  withSync = seconds + Time([&] { return std::system(("sync '" + to + "'").c_str()) == 0; });
  static_cast<void>(GetLocalFileSystem().RemoveAll(to));
  return seconds;
}

void TimeWrite(const Options& options, const std::string& from, double copying, Way& way)
{
  const std::string volume = options.Folder + "/write-pace.bvol";
  ForgetPages(from);
  const double seconds = Time(
    [&]
    {
      const double used = RunApart([&] { return WriteVolume(options, way, from, volume); });
      way.Peak = std::max(way.Peak, used);
      return used >= 0;
    });
  way.Seconds.push_back(seconds);
  way.Ratios.push_back(seconds / copying);
  RemoveVolume(volume);
}

void Measure(const Options& options, const std::string& from)
{
  std::vector<Way> ways;
  for (const std::string& codec : options.Codecs)
  {
    for (const int ranks : options.Ranks)
    {
      const int threads = options.Threads > 0 ? options.Threads : ChooseThreadCount(ranks);
      ways.push_back({ ranks, threads, codec, {}, {} });
    }
  }
  std::vector<double> copying;
  std::vector<double> syncing;
  for (int repeat = 0; repeat < options.Repeats; ++repeat)
  {
    for (Way& way : ways)
    {
      double withSync = 0;
      copying.push_back(TimeCopy(from, options.Folder + "/write-pace.copy", withSync));
      syncing.push_back(withSync);
      TimeWrite(options, from, copying.back(), way);
    }
  }
  std::printf("| what | seconds | x cp | MB/s | peak MiB |\n| --- | --- | --- | --- | --- |\n");
  const double cp = TakeMedian(copying);
  const double synced = TakeMedian(syncing);
  std::printf("| cp | %.2f | 1 | %.0f | |\n| cp, then sync of the copy | %.2f | %.2f | %.0f | |\n",
    cp, options.GetMegabytes() / cp, synced, synced / cp, options.GetMegabytes() / synced);
  for (const Way& way : ways)
  {
    const double seconds = TakeMedian(way.Seconds);
    std::printf("| %s, ranks: %d, threads a rank: %d | %.2f | %.2f | %.0f | %.0f |\n",
      way.Codec.c_str(), way.Ranks, way.Threads, seconds, TakeMedian(way.Ratios),
      options.GetMegabytes() / seconds, way.Peak);
  }
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Writes a raw uint16 file as a blocked volume, against cp of the file.");
  app.add_option("--folder", options.Folder, "where the file and the volume are made");
  app.add_option("--file", options.File, "the raw uint16 file; else one is made");
  app.add_option("--dimensions", options.Dimensions, "of the file; equal where one is made")
    ->expected(3);
  app.add_option("--ranks", options.Ranks, "numbers of ranks");
  app.add_option("--threads", options.Threads, "threads a rank; 0: a core each");
  app.add_option("--compression", options.Codecs, "none, lz4, zstd")
    ->check(CLI::IsMember({ "none", "lz4", "zstd" }));
  app.add_option("--stores", options.Stores, "stores");
  app.add_option("--block-size", options.BlockSize, "cells along the side of a block");
  app.add_option("--memory", options.MemoryMiB, "MiB that a rank may take");
  app.add_option("--repeats", options.Repeats, "measurements, of which the median is told");
  CLI11_PARSE(app, argc, argv);
  const bool isMade = options.File.empty();
  const std::string from = isMade ? options.Folder + "/write-pace.raw" : options.File;
  if (isMade && !MakeFile(from, static_cast<int>(options.Dimensions[0])))
  {
    std::fprintf(stderr, "%s cannot be made\n", from.c_str());
    return 1;
  }
  Measure(options, from);
  if (isMade)
  {
    static_cast<void>(GetLocalFileSystem().RemoveAll(from));
  }
  return 0;
}
