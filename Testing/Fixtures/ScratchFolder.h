// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ScratchFolder_h
#define isosurface_ScratchFolder_h

#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// An empty folder of the running test, below the working directory; removed with what is in it.
class ScratchFolder
{
public:
  /// The folder is named after the test, unless it has a name that several programs agree on.
  ScratchFolder();
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string GetPath(const std::string& name) const { return this->Path + "/" + name; }

private:
  std::string Path;
};

/// Makes a file of some bytes.
void WriteBytes(const std::string& path, const std::string& bytes);
std::string ReadBytes(const std::string& path);

/// Turns one bit of a byte. Negative offsets count from the end.
void FlipBit(const std::string& path, std::int64_t offset, int bit = 0);
/// Keeps the first bytes only.
void Truncate(const std::string& path, std::uint64_t size);

/// The folder of the one store folder of a time step that has been written to a fresh place.
std::string GetFirstStore(const std::string& volumePath, int store = 0);

/// The files of a blocked volume, header first, then sorted: names below the header's folder.
std::vector<std::string> ListVolumeFiles(const std::string& volumePath);

/// A hash of the names and bytes of all files of a blocked volume.
std::uint64_t ComputeFingerprint(const std::string& volumePath);

/// Copies a blocked volume, header and stores.
void CopyVolume(const std::string& from, const std::string& to);

} // namespace isosurface

#endif
