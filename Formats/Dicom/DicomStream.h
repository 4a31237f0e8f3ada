// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomStream_h
#define isosurface_DicomStream_h

#include "Ground/Base/FileSystem.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace isosurface
{

/**
 * The bytes of a DICOM file from front to back, of which those behind the first header may be deflated.
 * Memory: some windows of 16 KiB, whatever is skipped.
 *
 * Errors name the file: Corrupt if there are fewer bytes, or damaged ones; those of the file.
 *
 * Source: DICOM PS3.5, A.5 (deflated transfer syntax); RFC 1951.
 */
class DicomStream
{
public:
  /// `file` must outlive the stream.
  explicit DicomStream(const RandomAccessFile& file);
  DicomStream(const DicomStream&) = delete;
  DicomStream& operator=(const DicomStream&) = delete;
  ~DicomStream();

  /// From here on the bytes are deflated. Once.
  void Inflate();
  bool IsDeflated() const { return this->Deflated != nullptr; }

  Status Read(std::size_t size, void* bytes);
  /// Appends bytes. Allocates no more than a MiB more than there is.
  Status Append(std::uint64_t size, std::vector<std::uint8_t>& to);
  /// The next bytes, at most 64, without going on.
  Status Peek(std::size_t size, void* bytes);
  Status Skip(std::uint64_t size);

  /// Whether there may be that many bytes: of a deflated stream, only reading tells.
  bool MayHave(std::uint64_t size) const;

  /// An error that names the file.
  Status MakeError(StatusCode code, const std::string& reason) const;

private:
  class Inflater;

  std::size_t GetHeld() const { return this->Window.size() - this->Begin; }
  /// Adds bytes to the window. False if there are no more.
  Result<bool> Extend();

  const RandomAccessFile& File;
  std::uint64_t Position = 0; ///< in the file, behind what was read of it
  std::vector<std::uint8_t> Window;
  std::size_t Begin = 0; ///< the next byte in the window
  std::unique_ptr<Inflater> Deflated;
};

} // namespace isosurface

#endif
