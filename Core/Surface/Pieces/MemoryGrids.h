// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemoryGrids_h
#define isosurface_MemoryGrids_h

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace isosurface
{

/// The samples of a piece of a grid that a rank has in memory, in the coordinates of the grid.
struct MemoryPiece
{
  std::size_t Grid = 0; ///< into MemoryGrids::Grids
  /// Of the contoured array. Box: what the piece contours; Available: all samples.
  std::vector<SampleView> Components;
  Blanking Hidden;
  std::vector<AttributeView> Attributes; ///< to interpolate; the boxes are those of Components
  std::uint64_t Identity = 0;            ///< another one if the array or its samples are others
  std::shared_ptr<const void> Owner;     ///< keeps the samples alive, but not what Hidden refers to

  /// Takes an array to interpolate: its components, which have a sample where Components have one.
  void AddAttribute(AttributeView array)
  {
    for (SampleView& component : array.Components)
    {
      component.Box = this->Components.front().Box;
    }
    this->Attributes.push_back(std::move(array));
  }

  std::uint64_t CountSamples() const
  {
    return static_cast<std::uint64_t>(this->Components.front().Box.GetNumberOfVertices());
  }
};

/// Grids of which the ranks have pieces in memory.
struct MemoryGrids
{
  std::vector<GridGeometry> Grids;             ///< equal on all ranks
  std::vector<std::optional<GridLines>> Lines; ///< of each grid; nothing for a regular one
  std::vector<MemoryPiece> Pieces;             ///< this rank's

  /// Of this rank, without those that pieces do not contour.
  std::uint64_t CountSamples() const
  {
    std::uint64_t samples = 0;
    for (const MemoryPiece& piece : this->Pieces)
    {
      samples += piece.CountSamples();
    }
    return samples;
  }
  /// Tells the samples of this rank from others.
  std::uint64_t ComputeFingerprint() const
  {
    Fingerprint fingerprint;
    for (const MemoryPiece& piece : this->Pieces)
    {
      fingerprint.AddNumber(piece.Identity);
      fingerprint.AddNumber(piece.CountSamples());
    }
    return fingerprint.Get();
  }
};

} // namespace isosurface

#endif
