// SPDX-License-Identifier: BSD-3-Clause
#include "Volumes/VolumeQuery.h"

#include "Ground/Base/FileSystem.h"
#include "Ranks/Sharing/QueryPlan.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

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

VolumeQuery MeasurePiece(const std::string& path, double isovalue, int rank, int ranks, int threads)
{
  const double start = GetSeconds();
  auto opened = BlockedVolume::Open(path, GetLocalFileSystem(), std::make_shared<BlockCache>(0));
  BlockedVolume& volume = *Demand(opened);
  VolumeQuery query;
  query.OpenSeconds = GetSeconds() - start;
  auto plan = PlanQuery(volume, { { 0, 0, { isovalue } }, rank, ranks }, 0, query.Statistics);
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

void RemoveVolume(const std::string& path)
{
  for (const std::string& part : { path, HidePath(path + ".stores") })
  {
    static_cast<void>(GetLocalFileSystem().RemoveAll(part));
  }
}

} // namespace isosurface
