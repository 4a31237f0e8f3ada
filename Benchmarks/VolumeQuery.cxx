// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeQuery.h"

#include "Ranks/Query/StoredBlockSource.h"
#include "Storage/Store/BlockedVolume.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

template <typename T>
T& Demand(Result<T>& result)
{
  if (!result.IsOk())
  {
    std::fprintf(stderr, "%s\n", result.GetStatus().GetMessage().c_str());
    std::exit(EXIT_FAILURE);
  }
  return *result;
}

VolumeQuery Extract(const std::string& path, double isovalue, int rank, int ranks, int threads)
{
  const double start = GetSeconds();
  auto opened = BlockedVolume::Open(path, GetLocalFileSystem(), std::make_shared<BlockCache>(0));
  BlockedVolume& volume = *Demand(opened);
  VolumeQuery query;
  auto plan =
    PlanQuery(volume, { { 0, 0, { isovalue } }, rank, ranks }, 0, query.Statistics);
  StoredBlockSource source(volume, 0, 0, 0, std::move(Demand(plan).Blocks));
  ContourRequest request;
  request.Isovalues = { isovalue };
  request.GlobalIds = true;
  auto surface = ExtractSurface(volume.GetHeader().Grid, source, request, threads);
  query.Triangles = Demand(surface).NumberOfTriangles;
  query.Seconds = GetSeconds() - start;
  query.Statistics.Add(source.GetStatistics());
  return query;
}

} // namespace

void DropFromPageCache(const std::string& folder)
{
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
  {
    const int file = ::open(entry.path().c_str(), O_RDONLY);
    if (entry.is_regular_file() && file >= 0)
    {
      static_cast<void>(::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED));
    }
    ::close(file);
  }
}

double GetSeconds()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

VolumeQuery MeasureQuery(
  const std::string& path, double isovalue, int threads, int repeats, bool cold)
{
  std::vector<VolumeQuery> queries;
  for (int repeat = 0; repeat < repeats; ++repeat)
  {
    if (cold)
    {
      DropFromPageCache(path + ".stores");
    }
    queries.push_back(Extract(path, isovalue, 0, 1, threads));
  }
  std::sort(queries.begin(), queries.end(),
    [](const VolumeQuery& a, const VolumeQuery& b) { return a.Seconds < b.Seconds; });
  return queries[queries.size() / 2];
}

VolumeQuery MeasurePiece(const std::string& path, double isovalue, int rank, int ranks, int threads)
{
  return Extract(path, isovalue, rank, ranks, threads);
}

void RemoveVolume(const std::string& path)
{
  for (const std::string& part : { path, path + ".stores" })
  {
    static_cast<void>(GetLocalFileSystem().RemoveAll(part));
  }
}

} // namespace isosurface
