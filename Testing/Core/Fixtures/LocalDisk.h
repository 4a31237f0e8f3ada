// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_LocalDisk_h
#define isosurface_Testing_LocalDisk_h

#include "Ground/Base/FileSystem.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// What a rank sees of a disk: only the paths that a function lets it reach.
class LocalDisk : public FileSystem
{
public:
  using Reaches = std::function<bool(const std::string& path)>;

  LocalDisk(FileSystem& disk, Reaches reaches)
    : Disk(disk)
    , Reached(std::move(reaches))
  {
  }

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override
  {
    return this->Reached(path) ? this->Disk.OpenForReading(path)
                               : Status(StatusCode::NotFound, path + ": not on this node");
  }
  bool Exists(const std::string& path) override
  {
    return this->Reached(path) && this->Disk.Exists(path);
  }
  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    return this->Disk.CreateForWriting(path);
  }
  Status Rename(const std::string& from, const std::string& to) override
  {
    return this->Disk.Rename(from, to);
  }
  Status MakeDirectories(const std::string& path) override
  {
    return this->Disk.MakeDirectories(path);
  }
  Status RemoveAll(const std::string& path) override { return this->Disk.RemoveAll(path); }
  Result<std::vector<std::string>> List(const std::string& path) override
  {
    return this->Disk.List(path);
  }
  Status SyncDirectory(const std::string& path) override { return this->Disk.SyncDirectory(path); }

private:
  FileSystem& Disk;
  Reaches Reached;
};

} // namespace isosurface

#endif
