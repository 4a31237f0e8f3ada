// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceSample_h
#define isosurface_SourceSample_h

#include "Formats/Indexing/ReadingOrder.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/ArrayVariables.h"
#include "Ground/Volume/GridGeometry.h"
#include "Ground/Volume/GridLines.h"
#include "Ground/Volume/VolumeOpener.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class BlockedVolume;

/// A coarse volume in memory that stands for a file until it is indexed.
struct SourceSample
{
  std::shared_ptr<BlockedVolume> Volume; ///< valid without anything else
  Index3 WholeStep{ 1, 1, 1 };           ///< with which a sample of the whole file is as large
  double Share = 0;                      ///< of the file that its box is
  std::size_t Step = 0;                  ///< the time step that it is of
  int Level = 0;                         ///< OpenedVolume::Level
  bool IsUnfinished = false; ///< whether rows or slices of the sample that was wanted are left out
  std::int64_t Vertices = 0; ///< of the volume
  double Seconds = 0;        ///< that reading took; the same on all ranks
  bool IsWhole = false;      ///< whether it has all samples of the file
  std::string Text;          ///< what it is of the file: "one of 16 x 16 x 16 samples"
};

/// What a sample needs to know of the volume that it is of.
struct SampledVolume
{
  SampledVolume() = default;
  SampledVolume(const OpenedVolume& volume, std::size_t step);

  GridGeometry Grid;
  std::optional<GridLines> Lines;
  std::vector<ArrayDescription> Arrays;
  std::vector<ValueType> Types; ///< of the variables that are stored
  VertexBox Box;
  int Level = 0; ///< OpenedVolume::Level
  std::size_t Step = 0;
  std::optional<double> Time; ///< of the step
};

/**
 * Makes a sample of the samples on a lattice: for each variable those of the lattice's vertices, x
 * fastest. `part` says which part of the volume the lattice is if it is not all: "middle". `files`
 * must outlive the sample. Cost: that of writing a blocked volume to memory.
 */
Result<SourceSample> MakeSourceSample(FileSystem& files, const SourceIndex& index,
  const SampledVolume& of, const Lattice& lattice,
  const std::vector<std::vector<std::uint8_t>>& samples, const std::string& part);

} // namespace isosurface

#endif
