// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_IslandChoice_h
#define isosurface_IslandChoice_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Surface/Contour/Surface.h"
#include "Surface/Islands/IslandMeasures.h"
#include "Surface/Islands/SharedPointIds.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// What an error of a shortage of memory says.
constexpr const char* NoMemoryForIslands = "the islands of the isosurface cannot be found";

/// The measure by which islands are large or small.
enum class IslandSize
{
  Triangles, ///< at full resolution: at level l, 4^l times the triangles of the level
  Area,      ///< in the world
  Volume     ///< that the island encloses, in the world
};

/// Which islands are kept; equal on all ranks. An island has the isosurface of one isovalue.
struct IslandRequest
{
  IslandSize Size = IslandSize::Triangles;
  double MinimumSize = 0;           ///< smaller ones are dropped
  std::uint64_t MaximumIslands = 0; ///< of each isovalue keep as many, the largest; 0: all
  /// Of these, keep the one that is nearest to this place alone.
  std::optional<std::array<double, 3>> Place;
  bool Ids = false; ///< fill ChosenIslands::Ids
  int Level = 0;    ///< of the surface
};

/// Where one rank's surface is from.
struct IslandGrids
{
  TriangleBounds Bounds; ///< of all grids; equal on all ranks
  /// A grid each, in the order of their ids. Empty: the surface has no points that another piece has, too,
  /// and one isovalue.
  std::vector<SharedPlanes> Shared;
};

/// How many islands and triangles have sizes from Size to twice as much, before any was dropped.
struct IslandBin
{
  double Size = 0;
  std::uint64_t Islands = 0;
  std::uint64_t Triangles = 0;
};

/// An island as people see it.
struct ListedIsland
{
  std::uint64_t Triangles = 0;
  double Area = 0;
  double Volume = 0;
};

/// The islands of one isovalue, before any was dropped and after.
struct IsovalueIslands
{
  std::uint64_t Islands = 0;
  std::uint64_t Triangles = 0;
  std::uint64_t KeptIslands = 0;
  std::uint64_t KeptTriangles = 0;
};

/// The rows of ChosenIslands::Largest, at most.
constexpr std::size_t MaximumListedIslands = 1000;

/// What was found and kept; equal on all ranks, but for Ids.
struct ChosenIslands
{
  std::uint64_t Islands = 0;
  std::uint64_t Triangles = 0;
  std::uint64_t KeptIslands = 0;
  std::uint64_t KeptTriangles = 0;
  std::vector<IsovalueIslands> OfIsovalues; ///< in the order of the request
  std::vector<ListedIsland> Largest;        ///< of all, the largest first
  std::vector<IslandBin> Bins;              ///< those that are not empty, the smallest first
  /// Of this rank's kept cells: the place of the island among all, by size; 0 is the largest.
  Buffer<std::int64_t> Ids;
};

/**
 * Finds the islands of the surface that all ranks have together, and drops those that are not
 * wanted. Neither islands nor their measures depend on ranks or threads. Islands of the same size
 * are in the order of their lowest global ids. The surface has GlobalIds.
 *
 * Collective. Errors: OutOfMemory, on all ranks. Cost beside the surface: IslandLabels,
 * MeasureIslands, JoinIslands, KeepIslands; 32 bytes for each of the MaximumIslands of each isovalue,
 * and with Ids for each island of all ranks.
 */
Status ChooseIslands(Communicator& ranks, const IslandRequest& request, const IslandGrids& grids,
  int threads, Surface& surface, ChosenIslands& chosen);

/// The same of a surface that was just extracted: all ranks agree on `extracted`, the status of this rank, and
/// on whether `makeGrids` had the memory for the grids.
Status ChooseIslands(Communicator& ranks, const Status& extracted, const IslandRequest& request,
  const std::function<IslandGrids()>& makeGrids, int threads, Surface& surface,
  ChosenIslands& chosen);

/// For people: "3 of 12,408 islands, 98.2 % of the triangles", of several isovalues one after another.
std::string SummariseIslands(const ChosenIslands& islands, const std::vector<double>& isovalues);

} // namespace isosurface

#endif
