// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SharedPointIds_h
#define isosurface_SharedPointIds_h

#include "Ground/Volume/GridGeometry.h"
#include "Surface/Contour/Surface.h"
#include "Surface/Islands/IslandLabels.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// The planes of a grid in which other ranks, or other pieces of this rank, may have points with
/// the same global ids: those of the faces of blocks or pieces.
class SharedPlanes
{
public:
  /// `firstId`: added to the ids of ExtractSurface.
  SharedPlanes(const GridGeometry& grid, const ContourRequest& request, std::int64_t firstId = 0);

  /// The vertices with this coordinate on an axis, counted from the grid's first one.
  void Add(std::size_t axis, std::int64_t vertex);
  /// Those that blocks share which begin at the multiples of their size.
  void AddFacesOfBlocks(std::int64_t blockSize);

  std::int64_t GetFirstId() const { return this->FirstId; }
  std::size_t GetNumberOfIsovalues() const { return this->NumberOfIsovalues; }
  /// The number of the isovalue that has the point with a global id.
  std::size_t FindIsovalue(std::int64_t id) const;
  bool IsEmpty() const { return this->Planes == 0; }
  /// Whether the edge or vertex with a global id is in one of the planes. Faster for ids that
  /// follow each other along the x axis.
  class Finder
  {
  public:
    explicit Finder(const SharedPlanes& planes)
      : Shared(planes)
    {
    }
    bool IsInPlane(std::int64_t id);

  private:
    const SharedPlanes& Shared;
    std::int64_t RowBegin = 0; ///< the first vertex of the last row
    std::int64_t RowEnd = 0;
    bool IsRowShared[2] = { false, false }; ///< by its y, by its z
  };

private:
  std::int64_t FirstId;
  Index3 Dimensions;  ///< of the grid that ids number
  std::int64_t Shift; ///< of its first vertex
  std::int64_t NumberOfVertices;
  std::int64_t NumberOfEdgeIds;
  std::size_t NumberOfIsovalues;
  std::size_t Planes = 0;
  std::array<std::vector<std::uint8_t>, 3> AreShared; ///< by axis and coordinate
};

/// A point of one rank that others may have, too.
struct SharedPoint
{
  std::int64_t Id;
  std::uint64_t Island;
};

/// The points of a surface in the planes of its grids, which are in the order of their first ids.
std::vector<SharedPoint> FindSharedPoints(const Surface& surface, const IslandLabels& labels,
  const std::vector<SharedPlanes>& grids, int threads);

} // namespace isosurface

#endif
