// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HeaderText_h
#define isosurface_HeaderText_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/Status.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// The lines of a text header, which samples may follow in the same file.
class HeaderText
{
public:
  static Result<HeaderText> Open(FileSystem& files, const std::string& path);

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

  static std::string Trim(const std::string& text);
  static std::string Lower(std::string text);
  static std::vector<std::string> Split(const std::string& text);
  /// The number in a text that contains nothing else.
  static std::optional<double> ParseDouble(const std::string& text);
  static std::optional<std::int64_t> ParseInteger(const std::string& text);
  /// The numbers in a text that contains exactly `count` numbers.
  static std::optional<std::vector<double>> ParseDoubles(
    const std::string& text, std::size_t count);
  /// The names of a series from first to last: a printf pattern with one %d (or %03d, %i, ...).
  /// Nothing if it makes none, more than 2^20, or more than 64 MiB of text.
  static std::optional<std::vector<std::string>> ExpandPattern(
    const std::string& pattern, std::int64_t first, std::int64_t last, std::int64_t step);

private:
  std::string Path;
  std::string Text;
  std::size_t Position = 0;
};

} // namespace isosurface

#endif
