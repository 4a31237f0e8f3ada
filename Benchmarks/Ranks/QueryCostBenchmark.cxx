// SPDX-License-Identifier: BSD-3-Clause Measures the cost of isosurfaces for each of several ranks,
// from opening the file to the triangles. A rank is a process with one thread. Writes a row of CSV
// for each rank and run to standard output. The ranks run together, if the machine has enough
// cores; or in turn, each with the machine for itself, as on a cluster where each rank has its own
// disk.
#include "Volumes/MeasuredVolume.h"
#include "Volumes/VolumeQuery.h"

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/ParallelFor.h"
#include "Storage/Store/BlockedVolume.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

struct Options
{
  std::string Volume;
  std::vector<double> Isovalues;
  std::vector<int> Together;
  std::vector<int> InTurn;
  int Repeats = 3;
  std::uint32_t Stores = 32;
  int BlockSize = 32;
  std::string Scratch = ".";
};

struct Run
{
  std::string Path;
  std::uint32_t Stores = 0;
  int Turn = 0;
  double Isovalue = 0;
  int Ranks = 0;
  bool AreTogether = false;
  bool IsCold = false;
};

void PrintPiece(const Run& run, int rank)
{
  const std::clock_t begin = std::clock();
  const VolumeQuery query = MeasurePiece(run.Path, run.Isovalue, rank, run.Ranks, 1);
  const double cpuSeconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%d,%s,%s,%u,%d,%d,%.17g,%llu,%llu,%zu,%.9f,%.6f,%.6f\n", run.Turn,
    run.AreTogether ? "together" : "in turn", run.IsCold ? "cold" : "warm", run.Stores, run.Ranks,
    rank, run.Isovalue, static_cast<unsigned long long>(query.Statistics.ActiveBlocks),
    static_cast<unsigned long long>(query.Statistics.BytesRead), query.Triangles, query.Seconds,
    cpuSeconds, query.OpenSeconds);
  std::fflush(stdout);
}

bool WaitFor(pid_t child)
{
  int state = 1;
  return child > 0 && ::waitpid(child, &state, 0) == child && state == 0;
}

bool RunRanksInTurn(const Run& run)
{
  for (int rank = 0; rank < run.Ranks; ++rank)
  {
    const pid_t child = ::fork(); // so that a rank does not profit from the memory of another
    if (child == 0)
    {
      PrintPiece(run, rank);
      ::_exit(EXIT_SUCCESS);
    }
    if (!WaitFor(child))
    {
      return false;
    }
  }
  return true;
}

/// The ranks wait at a pipe, so that all start at the same time.
bool RunRanksTogether(const Run& run)
{
  int gate[2];
  if (::pipe(gate) != 0)
  {
    return false;
  }
  std::vector<pid_t> children;
  for (int rank = 0; rank < run.Ranks; ++rank)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      ::close(gate[1]);
      char nothing = 0;
      static_cast<void>(!::read(gate[0], &nothing, 1)); // until the write end is closed
      PrintPiece(run, rank);
      ::_exit(EXIT_SUCCESS);
    }
    children.push_back(child);
  }
  ::close(gate[0]);
  ::close(gate[1]);
  bool isDone = true;
  for (const pid_t child : children)
  {
    isDone = WaitFor(child) && isDone;
  }
  return isDone;
}

bool RunColdAndWarm(Run run)
{
  DropFromPageCache(HidePath(run.Path + ".stores"));
  for (const bool isCold : { true, false }) // the cold run brings the files into the page cache
  {
    run.IsCold = isCold;
    if (!(run.AreTogether ? RunRanksTogether(run) : RunRanksInTurn(run)))
    {
      return false;
    }
  }
  return true;
}

bool RunAll(const Options& options, const std::string& path, std::uint32_t stores)
{
  std::printf("turn,mode,cache,stores,ranks,rank,isovalue,activeBlocks,bytes,triangles,seconds,"
              "cpuSeconds,openSeconds\n");
  std::fflush(stdout); // otherwise children would print it again
  for (int turn = 0; turn < options.Repeats; ++turn)
  {
    for (const double isovalue : options.Isovalues)
    {
      for (const bool areTogether : { true, false })
      {
        for (const int ranks : areTogether ? options.Together : options.InTurn)
        {
          if (!RunColdAndWarm({ path, stores, turn, isovalue, ranks, areTogether }))
          {
            std::fprintf(stderr, "%s: a rank failed\n", path.c_str());
            return false;
          }
        }
      }
    }
  }
  return true;
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App app("Measures the cost of isosurfaces for each of several ranks.");
  app
    .add_option("volume", options.Volume, ".bvol; or .mhd, .mha, .nrrd, .nhdr, to be written first")
    ->required();
  app.add_option("--isovalues", options.Isovalues, "isovalues")->required();
  app.add_option("--together", options.Together, "numbers of ranks that run at once")
    ->check(CLI::PositiveNumber);
  app.add_option("--in-turn", options.InTurn, "numbers of ranks that run one after another")
    ->check(CLI::PositiveNumber);
  app.add_option("--repeats", options.Repeats, "runs of each")->check(CLI::PositiveNumber);
  app.add_option("--stores", options.Stores, "of a volume to be written")
    ->check(CLI::PositiveNumber);
  app.add_option("--block-size", options.BlockSize, "of a volume to be written: 16, 32, 64");
  app.add_option("--scratch", options.Scratch, "folder for a volume to be written");
  CLI11_PARSE(app, argc, argv);

  const bool isBlocked = std::filesystem::path(options.Volume).extension() == ".bvol";
  const std::string path = isBlocked ? options.Volume : options.Scratch + "/stores.bvol";
  Status status;
  if (!isBlocked)
  {
    status =
      WriteVolume(options.Volume, path, options.BlockSize, options.Stores, ChooseThreadCount(1));
  }
  const auto volume =
    status.IsOk() ? BlockedVolume::Open(path) : Result<std::shared_ptr<BlockedVolume>>(status);
  bool isDone = volume.IsOk();
  if (isDone)
  {
    isDone = RunAll(options, path, (*volume)->GetHeader().NumberOfStores);
  }
  else
  {
    std::fprintf(stderr, "%s\n", volume.GetStatus().GetMessage().c_str());
  }
  if (!isBlocked)
  {
    RemoveVolume(path);
  }
  return isDone ? EXIT_SUCCESS : EXIT_FAILURE;
}
