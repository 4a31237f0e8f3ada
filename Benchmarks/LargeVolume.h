// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LargeVolume_h
#define isosurface_LargeVolume_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Source/RawVolume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// What is made of a scan.
struct LargeVolumeSettings
{
  Index3 Dimensions{ 0, 0, 0 };
  ValueType Type = ValueType::UInt16;
  /// How far the longest waves of the detail move a surface (root mean square), in distances of the
  /// scan's samples.
  double Detail = 0.25;
  std::uint64_t Seed = 2009;
};

/**
 * A volume of any size that looks like a scan of higher resolution: a scan is interpolated (cubic,
 * Catmull-Rom), and noise continues its detail below the distance of its samples, an octave after
 * another, of wavelengths of the scan's sample distance, a half, a quarter, ... of it, down to
 * three new samples, with amplitudes in proportion to the wavelength (cubic B-splines through
 * hashed numbers). The noise is modulated by the scan's local contrast, so that surfaces get rough
 * but stay where they are, and what is constant in the scan stays constant.
 *
 * Each sample is a function of its position, the scan and the settings alone: the same on every
 * machine, for any number of threads. Values: if the type is the scan's, those of the scan; else
 * the scan's range, scaled to [0, largest value] for integers (of more than 24 bits: to [0, 2^24],
 * as far as the calculation is exact), to [0, 1] for floats.
 *
 * Memory: 8 bytes a sample of the scan, 64 MiB of slabs, a few rows a thread. Cost: about 5 ns a
 * sample and thread.
 */
class LargeVolume
{
public:
  /// Reads the whole scan.
  static Result<LargeVolume> Open(
    FileSystem& files, const RawVolume& scan, const LargeVolumeSettings& settings);

  /// The grid of the same box in space as the scan's.
  const GridGeometry& GetGrid() const { return this->Grid; }

  /// Computes the slices [begin, end) to `samples`, which has room for them.
  void FillSlices(std::int64_t begin, std::int64_t end, int threads, void* samples) const;

  /// Writes `path` (NAME.mhd) and NAME.raw beside it, slab by slab: while one is written the next
  /// one is computed.
  Status Write(FileSystem& files, const std::string& path, int threads) const;

private:
  /// Numbers on a coarse lattice, to be interpolated to the grid.
  struct Lattice
  {
    Index3 Size{ 0, 0, 0 };
    std::vector<float> Values; ///< empty: hashed numbers in [-1, 1)
    std::uint64_t Seed = 0;
    float Amplitude = 1;
    bool IsInterpolating = false; ///< Catmull-Rom instead of B-spline
  };
  /// For each vertex on one axis of the grid: the first of four lattice points, and their weights.
  struct Taps
  {
    std::vector<std::int32_t> First;
    std::vector<std::array<float, 4>> Weights;
  };
  class SliceSampler;

  LargeVolume() = default;
  Status ReadScan(FileSystem& files, const RawVolume& scan);
  void MeasureContrast();
  void AddOctaves(const LargeVolumeSettings& settings);
  void ChooseScale(ValueType scanType);
  static Taps MakeTaps(std::int64_t points, std::int64_t vertices, bool isInterpolating);

  GridGeometry Grid;
  ValueType Type = ValueType::UInt16;
  float Lowest = 0; ///< of the scan
  float Highest = 0;
  float Scale = 1; ///< sample = Offset + Scale * scan's value
  float Offset = 0;
  Lattice Scan;
  Lattice Contrast; ///< of the scan around each of its samples, times Detail
  std::vector<Lattice> Octaves;
};

/// The scan that is used when none is named: the head MRI of Debian's mricron-data (uint8, 181 x
/// 217 x 181 samples).
RawVolume FindDebianScan();

} // namespace isosurface

#endif
