// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5File_h
#define isosurface_Hdf5File_h

#include "Formats/Source/StoredArray.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

class Hdf5Handle;
class Hdf5LinkedFiles;

/// A dataset in an HDF5 file, for a list.
struct Hdf5Dataset
{
  std::string Path;
  StoredArray::Numbers Shape;
  std::string Type;
  std::string Storage;
  bool IsNumeric = false;
  std::string Refusal; ///< why it is not read, with its path; then it has no shape. Often empty
};

/**
 * An HDF5 file, open for reading on the local file system. Objects share the file, which closes
 * with the last one. Errors name the file, the object and the reason, with the library's words.
 * Other files, which it names, are checked before the library opens them (Hdf5LinkedFiles).
 */
class Hdf5File
{
public:
  /// `decodesChunks`: whether arrays decode chunks that are read as a whole beside the library's lock, and
  /// do not keep them, though they have a cache.
  static Result<Hdf5File> Open(const std::string& path, bool decodesChunks = false);
  const std::string& GetPath() const { return this->Path; }

  /// The datasets that the groups hold, by name. Links to other files are not followed. Groups that
  /// are deeper than 32 in one another are left out, and what is behind the first 10,000 objects.
  Result<std::vector<Hdf5Dataset>> FindDatasets() const;
  /// Checks what another program comes upon that opens each object, through all links: regular files,
  /// groups that are at most 32 deep in one another, at most 100,000 objects.
  Status CheckForOthers() const;
  Result<StoredArray::Numbers> FindShape(const std::string& path) const;
  bool Has(const std::string& path) const;
  bool IsDataset(const std::string& path) const;

  /// The attribute's texts; none if there is none, or if it has other values. At most 4096.
  std::vector<std::string> ReadTexts(const std::string& object, const std::string& name) const;
  /// The attribute's text, perhaps of one letter each (Imaris); nothing if it is none.
  std::optional<std::string> ReadText(const std::string& object, const std::string& name) const;
  /// The attribute's numbers; nothing if there is none, or if it has another count.
  std::optional<std::vector<double>> ReadNumbers(
    const std::string& object, const std::string& name, std::size_t count) const;
  /// The numbers of a dataset of one axis, at most `most`. Errors: those of OpenArray(), Corrupt.
  Result<std::vector<double>> ReadList(
    const std::string& path, std::int64_t most, std::size_t axes = 1) const;
  std::vector<std::string> FindAttributes(const std::string& object) const;
  /// All attributes: OpenedVolume::Attributes.
  std::string DescribeAttributes(const std::string& object) const;
  /// The paths of the datasets that give the coordinates of each axis of a dataset (dimension scales);
  /// empty where an axis has none.
  std::vector<std::string> FindScales(const std::string& path) const;
  /// What the numbers of a dataset stand for: DescribeHdf5Names().
  std::string FindNumberNames(const std::string& path) const;
  /// The names in a group, sorted.
  std::vector<std::string> FindNames(const std::string& group) const;

  /**
   * A dataset of integers of 8 to 64 bits or floats of 16 (read as 32), 32 or 64 bits, in either byte
   * order, contiguous, compact or chunked, with the filters that the library has. At most
   * `cacheBytes` keep decoded chunks: as many as a slab of whole chunks has, so that the next slab
   * does not decode those again that it shares with the last one.
   */
  Result<std::shared_ptr<StoredArray>> OpenArray(
    const std::string& path, std::uint64_t cacheBytes) const
  {
    return this->OpenArray(path, cacheBytes, {}, false);
  }
  /// The first samples on each axis alone, `shape` of them, if it is not empty. `isUnsigned`: samples
  /// of int16 are those of uint16.
  Result<std::shared_ptr<StoredArray>> OpenArray(const std::string& path, std::uint64_t cacheBytes,
    const StoredArray::Numbers& shape, bool isUnsigned) const;
  /// The file, and the others that have samples of the arrays that were opened.
  std::vector<std::string> FindFiles() const;

private:
  class Array;
  friend class Array;

  Result<Hdf5Handle> OpenDataset(const std::string& path) const;
  Hdf5Dataset Describe(
    const Hdf5Handle& dataset, const std::string& path, Hdf5LinkedFiles& links) const;
  Status MakeError(StatusCode code, const std::string& object, const std::string& reason) const;

  std::string Path;
  bool DecodesChunks = false;
  std::shared_ptr<Hdf5LinkedFiles> Links;
  std::shared_ptr<Hdf5Handle> File;
};

} // namespace isosurface

#endif
