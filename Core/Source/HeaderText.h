// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HeaderText_h
#define isosurface_HeaderText_h

#include "Base/FileSystem.h"
#include "Base/Status.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The lines of a text header that samples may follow in the same file.
class HeaderText
{
public:
  static Result<HeaderText> Open(FileSystem& files, const std::string& path);

  /// The next line, without its end; nothing at the end of the file, or of the first MiB.
  std::optional<std::string> TakeLine();
  /// Bytes from the begin of the file to behind the last line taken.
  std::uint64_t GetPosition() const { return this->Position; }

  const std::string& GetPath() const { return this->Path; }

  /// An error that names the file.
  Status MakeError(StatusCode code, const std::string& reason) const
  {
    return Status(code, this->Path + ": " + reason);
  }
  /// A path as the header gives it: relative to the header's own folder.
  std::string ResolvePath(const std::string& name) const;

  static std::string Trim(const std::string& text);
  static std::string Lower(std::string text);
  static std::vector<std::string> Split(const std::string& text);
  /// All of the text is this number.
  static std::optional<double> ParseDouble(const std::string& text);
  static std::optional<std::int64_t> ParseInteger(const std::string& text);
  /// The numbers of a text, if it has exactly so many.
  static std::optional<std::vector<double>> ParseDoubles(
    const std::string& text, std::size_t count);
  /// The names of a series: a printf pattern with one %d (or %03d, %i, ...), from first to last.
  static std::optional<std::vector<std::string>> ExpandPattern(
    const std::string& pattern, std::int64_t first, std::int64_t last, std::int64_t step);

private:
  std::string Path;
  std::string Text;
  std::size_t Position = 0;
};

} // namespace isosurface

#endif
