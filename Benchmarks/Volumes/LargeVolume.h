// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_LargeVolume_h
#define isosurface_LargeVolume_h

#include "Volumes/LatticeSampler.h"

#include "Formats/Plain/RawVolume.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// How a large volume is made from a scan.
struct LargeVolumeSettings
{
  Index3 Dimensions{ 0, 0, 0 };
  ValueType Type = ValueType::UInt16;
  /// How far the noise of maximum wavelength moves a surface (root mean square), in distances
  /// between the scan's samples.
  double Detail = 0.25;
  std::uint64_t Seed = 2009;
};

/**
 * A volume of any size that looks like a scan of higher resolution. The scan is interpolated
 * (cubic, Catmull-Rom). Noise adds detail: octaves with wavelengths of the scan's sample distance,
 * a half, a quarter, ... down to three new samples, and amplitudes proportional to the wavelength
 * (cubic B-splines through hashed numbers). It is multiplied by the scan's local contrast, so
 * surfaces become rough but stay in place, and constant regions stay constant.
 *
 * A sample depends on its position, the scan and the settings only. If the type is that of the
 * scan, the values keep the scan's range. Otherwise the range is scaled to [0, maximum] for
 * integers (but at most [0, 2^24], where the computation is exact) or [0, 1] for floats.
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

  /// The grid, of the same box in space as the scan.
  const GridGeometry& GetGrid() const { return this->Grid; }

  /// Computes the slices [begin, end). `samples` must have room for them.
  void FillSlices(std::int64_t begin, std::int64_t end, int threads, void* samples) const;

  /// Writes `path` (NAME.mhd), and NAME.raw beside it slab by slab. One slab is computed while the
  /// previous one is written.
  Status Write(FileSystem& files, const std::string& path, int threads) const;

private:
  class SliceMaker;

  LargeVolume() = default;
  Status ReadScan(FileSystem& files, const RawVolume& scan);
  void MeasureContrast();
  void AddOctaves(const LargeVolumeSettings& settings);
  void ChooseScale(ValueType scanType);
  std::string MakeHeader(const std::string& rawName) const;

  GridGeometry Grid;
  ValueType Type = ValueType::UInt16;
  float Minimum = 0; ///< of the scan
  float Maximum = 0;
  float Scale = 1; ///< sample = Offset + Scale * scan's value
  float Offset = 0;
  Lattice Scan;
  Lattice Contrast; ///< of the scan around each of its samples, times Detail
  std::vector<Lattice> Octaves;
};

/// The default scan: the head MRI of Debian's package mricron-data (uint8, 181 x 217 x 181
/// samples).
RawVolume FindDebianScan();

} // namespace isosurface

#endif
