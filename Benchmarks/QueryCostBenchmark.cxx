// SPDX-License-Identifier: BSD-3-Clause
// What isosurfaces cost each of some ranks, one process with one thread each, from opening the file
// to the triangles: a row of CSV for each run, on standard output. Ranks begin together.
#include "VolumeQuery.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

void PrintShare(const std::string& path, double isovalue, int rank, int ranks, bool cold, int turn)
{
  const VolumeQuery query = MeasureShare(path, isovalue, rank, ranks, 1);
  std::printf("%d,%d,%d,%s,%.17g,%llu,%llu,%zu,%.9f,%.9f,%.9f\n", turn, ranks, rank,
    cold ? "cold" : "warm", isovalue,
    static_cast<unsigned long long>(query.Statistics.ActiveBlocks),
    static_cast<unsigned long long>(query.Statistics.BytesRead), query.Triangles, query.Seconds,
    query.Statistics.QuerySeconds, query.Statistics.ReadSeconds);
  std::fflush(stdout);
}

/// All ranks at once, each a process that waits for the others at a pipe.
bool RunRanks(const std::string& path, double isovalue, int ranks, bool cold, int turn)
{
  int gate[2];
  if (::pipe(gate) != 0)
  {
    return false;
  }
  std::vector<pid_t> children;
  for (int rank = 0; rank < ranks; ++rank)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      ::close(gate[1]);
      char nothing = 0;
      static_cast<void>(!::read(gate[0], &nothing, 1)); // until the writing end is closed
      PrintShare(path, isovalue, rank, ranks, cold, turn);
      ::_exit(EXIT_SUCCESS);
    }
    children.push_back(child);
  }
  ::close(gate[0]);
  ::close(gate[1]);
  bool isDone = true;
  for (const pid_t child : children)
  {
    int state = 1;
    isDone = child > 0 && ::waitpid(child, &state, 0) == child && state == 0 && isDone;
  }
  return isDone;
}

} // namespace

int main(int argc, char** argv)
{
  std::string path;
  std::vector<double> isovalues;
  std::vector<int> ranks = { 1, 2 };
  int repeats = 3;
  CLI::App app("What isosurfaces cost each of some ranks.");
  app.add_option("volume", path, ".bvol")->required();
  app.add_option("--isovalues", isovalues, "isovalues")->required();
  app.add_option("--ranks", ranks, "numbers of ranks")->check(CLI::PositiveNumber);
  app.add_option("--repeats", repeats, "runs of each")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);

  std::printf("turn,ranks,rank,cache,isovalue,activeBlocks,bytes,triangles,seconds,querySeconds,"
              "readSeconds\n");
  std::fflush(stdout);
  for (int turn = 0; turn < repeats; ++turn)
  {
    for (const double isovalue : isovalues)
    {
      for (const int count : ranks)
      {
        for (const bool cold : { true, false }) // the cold run leaves the pages for the warm one
        {
          if (cold)
          {
            DropFromPageCache(path + ".stores");
          }
          if (!RunRanks(path, isovalue, count, cold, turn))
          {
            std::fprintf(stderr, "%s: a rank failed\n", path.c_str());
            return EXIT_FAILURE;
          }
        }
      }
    }
  }
  return EXIT_SUCCESS;
}
