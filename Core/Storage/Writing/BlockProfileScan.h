// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BlockProfileScan_h
#define isosurface_BlockProfileScan_h

#include "Ground/Base/Communicator.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockGrid.h"
#include "Ground/Volume/SampleView.h"
#include "Storage/Distribution/BlockProfile.h"

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace isosurface
{

/**
 * Computes the profile of every block in one array, on all ranks, from samples that are added in
 * boxes of any shape and order. Infinities count as the type's extreme numbers, NaN is ignored.
 *
 * The cubes of a block begin at multiples of BlockProfile::CubeSize, without the vertices on the
 * faces that the block shares with the next ones. So each vertex is in one cube, and the profiles
 * do not depend on how the volume is cut. A cube that boxes cut is kept, as a span of values, until
 * its last vertex is added; Reduce() joins cubes that ranks cut.
 *
 * Cost: about that of finding the blocks' ranges. Memory: GetBytes().
 */
class BlockProfileScan
{
public:
  BlockProfileScan(const BlockGrid& grid, ValueType type, int threads);

  /// Adds the samples of a box; no vertex may be added twice, on any rank.
  void Add(const SampleView& samples, const VertexBox& box);

  /// Collective. Joins the samples that the ranks have added. Error of all ranks, which names `path`:
  /// OutOfMemory.
  Status Reduce(Communicator& communicator, const std::string& path);

  /// Per block; complete after Reduce().
  const std::vector<BlockProfile>& GetProfiles() const { return this->Profiles; }

  /// The vertices of a block's cubes: the block without its far faces, which belong to the next
  /// blocks.
  VertexBox GetOwnVertices(std::int64_t block) const;

  /// The memory, with messages and the distribution that follows.
  static std::uint64_t GetBytes(const BlockGrid& grid);

private:
  /// The samples of a cube that were added so far.
  struct OpenCube
  {
    std::uint64_t Cube = 0;
    std::int64_t Vertices = 0;
    SampleSpan Span;
  };
  struct ThreadState
  {
    std::vector<SampleSpan> Cubes; ///< of one block
    std::vector<OpenCube> Open;
  };

  VertexBox GetCube(std::uint64_t cube) const;
  template <typename T>
  void AddBlock(
    const SampleView& samples, std::int64_t block, const VertexBox& part, ThreadState& state);
  template <typename T>
  void AddCubeRow(const SampleView& samples, const VertexBox& row, ThreadState& state) const;
  void AddSpan(const VertexBox& part, const SampleSpan& span, ThreadState& state) const;
  void AddOpenCube(const OpenCube& part);
  Message Pack() const;
  void Unpack(const Message& message);

  BlockGrid Grid;
  ValueType Type;
  int Threads;
  Index3 CubesPerAxis;
  std::vector<BlockProfile> Profiles;
  std::unordered_map<std::uint64_t, OpenCube> Open; ///< incomplete cubes, by number
};

} // namespace isosurface

#endif
