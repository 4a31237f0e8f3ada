// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HeaderLines_h
#define isosurface_HeaderLines_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/// The lines of a text header, which samples may follow in the same file.
class HeaderLines
{
public:
  static Result<HeaderLines> Open(FileSystem& files, const std::string& path);

  /// The next line, without its line end. Nothing at the end of the file, or after the first MiB.
  std::optional<std::string> TakeLine();
  /// The offset in the file after the last line taken.
  std::uint64_t GetPosition() const { return this->Position; }

  const std::string& GetPath() const { return this->Path; }

  /// An error that names the file.
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Path + ": " + reason);
  }
  /// Resolves a path in the header, which is relative to the header's folder.
  std::string ResolvePath(const std::string& name) const;

private:
  std::string Path;
  std::string Text;
  std::size_t Position = 0;
};

} // namespace isosurface

#endif
