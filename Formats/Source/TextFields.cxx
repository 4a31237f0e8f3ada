// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <limits>
#include <locale>
#include <sstream>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumSeriesSize = std::int64_t{ 1 } << 20;
/// All names of a series together, in characters.
constexpr std::int64_t MaximumSeriesText = std::int64_t{ 64 } << 20;
constexpr std::size_t MaximumDigits = std::numeric_limits<std::int64_t>::digits10 + 1;

} // namespace

std::string TrimText(const std::string& text)
{
  const char* spaces = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(spaces);
  return begin == std::string::npos ? std::string()
                                    : text.substr(begin, text.find_last_not_of(spaces) - begin + 1);
}

std::string LowerText(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(),
    [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return text;
}

std::vector<std::string> SplitWords(const std::string& text)
{
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;)
  {
    words.push_back(word);
  }
  return words;
}

std::optional<double> ParseDouble(const std::string& text)
{
  // Headers have decimal points in every locale.
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0;
  stream >> value;
  if (stream.fail() || !stream.eof())
  {
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> ParseInteger(const std::string& text)
{
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::int64_t value = 0;
  stream >> value;
  if (stream.fail() || !stream.eof())
  {
    return std::nullopt;
  }
  return value;
}

std::optional<std::vector<double>> ParseDoubles(const std::string& text, std::size_t count)
{
  std::vector<double> values;
  for (const std::string& word : SplitWords(text))
  {
    const auto value = ParseDouble(word);
    if (!value)
    {
      return std::nullopt;
    }
    values.push_back(*value);
  }
  if (values.size() != count)
  {
    return std::nullopt;
  }
  return values;
}

std::optional<std::vector<std::string>> ExpandPattern(const std::string& pattern,
  std::int64_t first, std::int64_t last, std::int64_t step, std::int64_t most)
{
  const std::size_t begin = pattern.find('%');
  const std::size_t end = pattern.find_first_not_of("0123456789", begin + 1);
  if (begin == std::string::npos || end == std::string::npos ||
    std::string("diu").find(pattern[end]) == std::string::npos || end - begin > 3 ||
    pattern.find('%', end) != std::string::npos || step == 0 || first < 0 || last < 0 ||
    (step > 0 ? last < first : last > first) ||
    (last - first) / step >= std::min(most, MaximumSeriesSize))
  {
    return std::nullopt;
  }
  const std::int64_t count = (last - first) / step + 1;
  const std::string width = pattern.substr(begin + 1, end - begin - 1);
  const auto minimumDigits = static_cast<std::size_t>(width.empty() ? 0 : std::atoi(width.c_str()));
  const std::size_t length = pattern.size() + std::max(minimumDigits, MaximumDigits);
  if (static_cast<std::int64_t>(length) > MaximumSeriesText / count)
  {
    return std::nullopt;
  }
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(count));
  for (std::int64_t index = 0; index < count; ++index)
  {
    const std::string digits = std::to_string(first + index * step);
    const std::string padding(
      minimumDigits - std::min(minimumDigits, digits.size()), width[0] == '0' ? '0' : ' ');
    names.push_back(pattern.substr(0, begin) + padding + digits + pattern.substr(end + 1));
  }
  return names;
}

namespace
{

constexpr std::uint64_t MaximumHeaderSize = std::uint64_t{ 1 } << 20;

} // namespace

Result<HeaderLines> HeaderLines::Open(FileSystem& files, const std::string& path)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  HeaderLines header;
  header.Path = path;
  header.Text.resize(static_cast<std::size_t>(std::min(file->GetSize(), MaximumHeaderSize)));
  ISOSURFACE_RETURN_IF_ERROR(file->Read(0, header.Text.size(), header.Text.data()));
  return header;
}

std::optional<std::string> HeaderLines::TakeLine()
{
  const std::size_t end = this->Text.find('\n', this->Position);
  if (this->Position >= this->Text.size())
  {
    return std::nullopt;
  }
  const std::size_t next = end == std::string::npos ? this->Text.size() : end + 1;
  std::string line = this->Text.substr(this->Position, end - this->Position);
  if (!line.empty() && line.back() == '\r')
  {
    line.pop_back();
  }
  this->Position = next;
  return line;
}

std::string HeaderLines::ResolvePath(const std::string& name) const
{
  return FindBeside(this->Path, name);
}

} // namespace isosurface
