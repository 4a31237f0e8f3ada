// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TextFields_h
#define isosurface_TextFields_h

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

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
