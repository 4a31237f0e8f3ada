// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TextFields_h
#define isosurface_TextFields_h

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

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

std::string TrimText(const std::string& text);
std::string LowerText(std::string text);
std::vector<std::string> SplitWords(const std::string& text);
/// The number in a text that contains nothing else.
std::optional<double> ParseDouble(const std::string& text);
std::optional<std::int64_t> ParseInteger(const std::string& text);
/// The numbers in a text that contains exactly `count` numbers.
std::optional<std::vector<double>> ParseDoubles(const std::string& text, std::size_t count);
/// The names of a series from first to last: a printf pattern with one %d (or %03d, %i, ...).
/// Nothing if it makes none, more than `most` or 2^20, or more than 64 MiB of text.
std::optional<std::vector<std::string>> ExpandPattern(const std::string& pattern,
  std::int64_t first, std::int64_t last, std::int64_t step, std::int64_t most);

} // namespace isosurface

#endif
