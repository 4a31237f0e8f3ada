// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_MemoryFileSystem_h
#define isosurface_MemoryFileSystem_h

#include "Ground/Base/FileSystem.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * Keeps in memory, up to a limit, the files whose paths begin with a given text, or with HidePath() of
 * it; all others are read from another file system, and cannot be written. Several threads may use it.
 * It must outlive its files.
 *
 * Errors are those of FileSystem; DiskFull beyond the limit.
 */
class MemoryFileSystem : public FileSystem
{
public:
  /// `others` must outlive this object.
  MemoryFileSystem(FileSystem& others, std::string prefix, std::uint64_t limitBytes);

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override;
  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override;
  Status Rename(const std::string& from, const std::string& to) override;
  Status MakeDirectories(const std::string& path) override;
  Status RemoveAll(const std::string& path) override;
  bool Exists(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& path) override;
  Result<FileState> FindState(const std::string& path) override;
  Status CheckRegular(const std::string& path, const char* action) override;
  Status SyncDirectory(const std::string& path) override;

private:
  using Content = std::vector<std::uint8_t>;
  class Reader;
  class Writer;

  /// Ok if the path begins with the prefix, hidden or not.
  Status CheckPath(const std::string& path) const;
  /// Null if there is none.
  std::shared_ptr<Content> Find(const std::string& path);

  FileSystem& Others;
  const std::string Prefix;
  const std::uint64_t LimitBytes;
  std::mutex Mutex; ///< guards what follows, and the bytes of all files
  std::map<std::string, std::shared_ptr<Content>> Files;
  std::uint64_t Bytes = 0; ///< of all files
};

} // namespace isosurface

#endif
