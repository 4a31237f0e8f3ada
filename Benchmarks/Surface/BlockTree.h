// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Benchmarks_BlockTree_h
#define isosurface_Benchmarks_BlockTree_h

#include "Storage/Store/BlockedVolume.h"
#include "Surface/Drawing/DepthPyramid.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace isosurface
{

/// A block at one of its levels, which tells the part of the volume.
struct LevelBlock
{
  int Level = 0;
  BlockReference Block;
  double Distance = 0; ///< from the camera

  std::uint64_t GetKey() const
  {
    return static_cast<std::uint64_t>(this->Level) << 48 |
      static_cast<std::uint64_t>(this->Block.Block);
  }
};

/// What a camera sees, and what the image of it has shown.
struct SeenImage
{
  std::array<double, 16> ModelToClip{}; ///< row by row
  std::array<double, 3> Position{};     ///< of the camera
  double PixelsAtOne = 0;               ///< how many pixels a length of 1 has at a distance of 1
  int Width = 0;
  int Height = 0;
  DepthPyramid Depths; ///< nothing is behind those of an image that is not drawn yet
};

/// The active blocks of all levels of a volume: a block of an overview has the place of 64 of the next
/// finer part. The volume has no direction.
class BlockTree
{
public:
  /// Ends the program with a message if the volume cannot be read.
  BlockTree(BlockedVolume& volume, const std::vector<double>& isovalues);

  /// xmin, xmax, ymin ...
  std::array<double, 6> GetBounds() const;

  /// What an image needs, nearest first, at the levels whose cells are at most so many pixels wide:
  /// neither what is beyond it, nor what is behind the image before.
  std::vector<LevelBlock> Choose(
    const SeenImage& image, const SeenImage& before, double pixels) const;

  /// Goes to the block of the next coarser part; false if there is none.
  bool FindParent(LevelBlock& block) const;

private:
  struct Search;

  std::array<double, 6> FindBounds(std::size_t part, std::int64_t block) const;
  void Descend(Search& search, std::size_t part, std::int64_t block) const;

  BlockedVolume& Volume;
  std::vector<std::vector<std::optional<BlockReference>>> Active; ///< by part and block
};

} // namespace isosurface

#endif
