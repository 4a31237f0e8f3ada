// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/EdgeIndex/IslandMask.h"

#include "Coding/EdgeIndex/BlockIslands.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/ValueKey.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{
namespace
{

/// Where the points of a block's surface are among the vertices of the block.
class BlockPlaces
{
public:
  BlockPlaces(const EdgeIndexHeader& header, const VertexBox& box)
    : Size(box.GetSize())
  {
    const GridGeometry grid = GetNumberedGrid(header.Geometry, MakeContourRequest(header));
    this->Dimensions = grid.GetDimensions();
    this->EdgeIds =
      3 * grid.GetNumberOfVertices() * static_cast<std::int64_t>(header.Isovalues.size());
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      this->Low[axis] = box.Low[axis] + header.Geometry.Extent[2 * axis] - grid.Extent[2 * axis];
    }
  }

  const Index3& GetSize() const { return this->Size; }

  /// Calls body(vertex) for the vertices within one of a point, but along its edge for the ends alone; and for the
  /// ends alone if asked so.
  template <typename Body>
  void VisitAround(std::int64_t id, bool endsAlone, const Body& body) const
  {
    const bool isVertex = id >= this->EdgeIds;
    const std::int64_t vertices = this->Dimensions[0] * this->Dimensions[1] * this->Dimensions[2];
    const std::int64_t vertex = (isVertex ? id : id / 3) % vertices;
    const Index3 place = { vertex % this->Dimensions[0] - this->Low[0],
      vertex / this->Dimensions[0] % this->Dimensions[1] - this->Low[1],
      vertex / (this->Dimensions[0] * this->Dimensions[1]) - this->Low[2] };
    Index3 begin{};
    Index3 end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const bool isAlong = !isVertex && axis == static_cast<std::size_t>(id % 3);
      const std::int64_t reach = endsAlone ? 0 : 1;
      const std::int64_t first = place[axis] - (isAlong ? 0 : reach);
      const std::int64_t past = place[axis] + 1 + (isAlong ? 1 : reach);
      begin[axis] = first > 0 ? first : 0;
      end[axis] = past < this->Size[axis] ? past : this->Size[axis];
    }
    for (std::int64_t z = begin[2]; z < end[2]; ++z)
    {
      for (std::int64_t y = begin[1]; y < end[1]; ++y)
      {
        for (std::int64_t x = begin[0]; x < end[0]; ++x)
        {
          body(static_cast<std::size_t>(x + this->Size[0] * (y + this->Size[1] * z)));
        }
      }
    }
  }

private:
  Index3 Size;
  Index3 Dimensions{};
  Index3 Low{};
  std::int64_t EdgeIds = 0; ///< of all isovalues
};

/// Changes the sides of enclosed vertices.
template <typename T>
class SideTurning
{
public:
  /// isFixed: by vertex; those that are not to be turned, nor what is connected to them.
  SideTurning(T threshold, const Index3& size, std::vector<std::uint8_t> isFixed, T* values)
    : Threshold(threshold)
    , Steps{ 1, static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[0] * size[1]) }
    , IsFixed(std::move(isFixed))
    , Turns(IsFixed.size(), 0)
    , Values(values)
  {
  }

  /// Turns all vertices that are connected to one on its side, if none of them is fixed.
  void Turn(std::size_t first)
  {
    if (this->IsFixed[first] != 0)
    {
      return;
    }
    const bool side = this->IsInside(first);
    T other = this->Values[first];
    bool isFree = true;
    std::vector<std::size_t> connected = { first };
    this->Turns[first] = ++this->Turned;
    for (std::size_t n = 0; n < connected.size() && isFree; ++n)
    {
      for (const std::size_t step : this->Steps)
      {
        // Not beyond the block, since the vertices of its faces are fixed.
        for (const std::size_t neighbor : { connected[n] - step, connected[n] + step })
        {
          if (this->IsInside(neighbor) != side)
          {
            other = this->Values[neighbor];
          }
          else if (this->Turns[neighbor] != this->Turned)
          {
            isFree = isFree && this->IsFixed[neighbor] == 0;
            this->Turns[neighbor] = this->Turned;
            connected.push_back(neighbor);
          }
        }
      }
    }
    for (const std::size_t vertex : connected)
    {
      this->Values[vertex] = isFree ? other : this->Values[vertex];
      this->IsFixed[vertex] = isFree ? 0 : 1;
    }
  }

private:
  bool IsInside(std::size_t vertex) const { return this->Values[vertex] >= this->Threshold; }

  T Threshold;
  std::size_t Steps[3];
  std::vector<std::uint8_t> IsFixed;
  std::vector<std::uint32_t> Turns; ///< in which a vertex was met last
  std::uint32_t Turned = 0;
  T* Values;
};

/// Of each vertex of a block, whether it lies in one of the block's faces.
std::vector<std::uint8_t> FindFaces(const Index3& size)
{
  std::vector<std::uint8_t> areOnFace;
  for (std::int64_t z = 0; z < size[2]; ++z)
  {
    for (std::int64_t y = 0; y < size[1]; ++y)
    {
      for (std::int64_t x = 0; x < size[0]; ++x)
      {
        areOnFace.push_back(
          x == 0 || y == 0 || z == 0 || x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2]
            ? 1
            : 0);
      }
    }
  }
  return areOnFace;
}

} // namespace

Result<BlockSamples> MaskIslands(
  const EdgeIndexHeader& header, const BlockSamples& samples, std::size_t isovalue)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const Surface surface, ExtractBlockSurface(header, samples, isovalue));
  const VertexBox& box = samples.Scalars.Box;
  const BlockPlaces places(header, box);
  std::vector<std::uint8_t> isFixed = FindFaces(places.GetSize());
  std::vector<std::int64_t> leftOut;
  for (const std::int64_t id : surface.GlobalIds)
  {
    if (!std::binary_search(header.KeptIds->begin(), header.KeptIds->end(), id))
    {
      leftOut.push_back(id);
      continue;
    }
    places.VisitAround(id, false, [&](std::size_t vertex) { isFixed[vertex] = 1; });
  }
  BlockSamples masked;
  const auto bytes = std::make_shared<Buffer<std::uint8_t>>(
    static_cast<std::size_t>(box.GetNumberOfVertices()) * GetValueSize(header.Type));
  CopyBox(samples.Scalars, box, box, bytes->GetData());
  masked.Scalars = MakeSampleView(header.Type, box, bytes->GetData());
  masked.Owner = bytes;
  DispatchValueType(header.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      if (const auto threshold = FindThreshold<T>(header.Isovalues[isovalue]))
      {
        SideTurning<T> turning(
          *threshold, places.GetSize(), std::move(isFixed), reinterpret_cast<T*>(bytes->GetData()));
        for (const std::int64_t id : leftOut)
        {
          places.VisitAround(id, true, [&](std::size_t vertex) { turning.Turn(vertex); });
        }
      }
    });
  return masked;
}

} // namespace isosurface
