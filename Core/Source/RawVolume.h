// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RawVolume_h
#define isosurface_RawVolume_h

#include "Base/FileSystem.h"
#include "Base/Status.h"
#include "Source/SlabSource.h"
#include "Volume/GridGeometry.h"
#include "Volume/ValueType.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// How the samples of a volume stand in files: one of them with all, or several with an equal
/// number of slices each. x fastest, then y, then z; one component.
struct RawVolume
{
  GridGeometry Grid;
  ValueType Type = ValueType::UInt8;
  std::string ArrayName = "scalars";
  bool IsBigEndian = false;
  bool IsGzip = false;          ///< each file is a gzip or zlib stream
  bool EndsWithSamples = false; ///< they are the last bytes of a file, whatever Offset says
  std::uint64_t Offset = 0;     ///< bytes at the begin of each file that are not looked at
  std::uint64_t Lines = 0;      ///< lines of text behind them; then come the samples or the stream
  std::uint64_t Skip = 0; ///< bytes before the samples, there or in what the stream inflates to
  std::vector<std::string> Paths;

  /// Opens the files (of a series, the first) and checks their sizes. `files` must outlive the
  /// source.
  Result<std::unique_ptr<SlabSource>> Open(FileSystem& files) const;

  /// What is told of a format's own header: .mhd, .mha (MetaImageHeader.h), .nrrd, .nhdr
  /// (NrrdHeader.h), by the path's extension. Unsupported for others.
  static Result<RawVolume> ReadHeader(FileSystem& files, const std::string& path);
  /// Whether ReadHeader() knows the path's extension.
  static bool HasHeader(const std::string& path);

private:
  /// What is to be read of one file: `bytes` bytes of samples, from offset 0 on.
  Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    FileSystem& files, const std::string& path, std::uint64_t bytes) const;
};

} // namespace isosurface

#endif
