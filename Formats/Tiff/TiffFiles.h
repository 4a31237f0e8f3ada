// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TiffFiles_h
#define isosurface_TiffFiles_h

#include "Formats/Tiff/TiffFile.h"

#include <map>
#include <memory>
#include <string>
#include <utility>

namespace isosurface
{

/// The files of a volume, whose directories are read when they are needed. Not more than 256 stay open.
class TiffFiles
{
public:
  struct ReadFile
  {
    std::unique_ptr<TiffFile> File;
    TiffContents Contents;
  };

  /// `own`: the path of the file whose description tells what the others are.
  TiffFiles(FileSystem& files, std::string own)
    : Files(files)
    , Own(std::move(own))
  {
  }

  FileSystem& GetFileSystem() const { return this->Files; }
  const std::string& GetOwn() const { return this->Own; }
  /// The path of a file that a description names; the own one, if the name is empty.
  std::string FindPath(const std::string& name) const;
  /// The file stays open until the next one is opened, the own one always.
  Result<ReadFile*> Open(const std::string& path);
  /// An error that names the own file, as others of opening.
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Own + ": cannot be read: " + reason);
  }

  /// Leaves out pages that are smaller images or masks of others, like the thumbnails of microscopes.
  /// All others must have the format of the first one, and numbers that do not descend.
  static Status CheckStack(ReadFile& read);

private:
  FileSystem& Files;
  std::string Own;
  std::map<std::string, ReadFile> Read;
};

} // namespace isosurface

#endif
