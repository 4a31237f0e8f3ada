// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/StoredArray.h"

#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace isosurface
{

std::string JoinNumbers(const StoredArray::Numbers& numbers)
{
  std::string text;
  for (const std::int64_t number : numbers)
  {
    text += (text.empty() ? "" : " x ") + std::to_string(number);
  }
  return text;
}

char ArrayAxes::FindLetter(const std::string& name)
{
  const std::string lower = " " + LowerText(name) + " ";
  const std::pair<char, const char*> known[] = { { 't', " t time " },
    { 'c', " c channel channels " }, { 'z', " z depth height altitude level lev " },
    { 'y', " y lat latitude " }, { 'x', " x lon longitude " } };
  const auto* const found = std::find_if(std::begin(known), std::end(known),
    [&lower](const auto& letter)
    { return lower.size() > 2 && std::string(letter.second).find(lower) != std::string::npos; });
  return found == std::end(known) ? '?' : found->first;
}

std::string ArrayAxes::Guess(const StoredArray::Numbers& shape, const std::string& known,
  const std::string& names, std::string& told)
{
  const std::size_t rank = shape.size();
  if (rank < 3 || rank > 5)
  {
    return {}; // of which Parse() knows what to say
  }
  if (!known.empty() && Parse(known, rank).IsOk())
  {
    return known;
  }
  const std::int64_t last = shape.back();
  const auto others = static_cast<std::ptrdiff_t>(std::min<std::size_t>(rank - 1, 3));
  const std::int64_t least = *std::min_element(shape.end() - 1 - others, shape.end() - 1);
  const bool isColor = last <= 4 && least > 4;
  const bool isNamed = !known.empty() && known.back() != '?';
  const std::string usual = rank == 3    ? "zyx"
    : isNamed || (last != 1 && !isColor) ? (rank == 4 ? "tzyx" : "tczyx")
                                         : (rank == 4 ? "zyxc" : "tzyxc");
  std::string letters;
  for (const char letter : known)
  {
    letters += letters.find(letter) == std::string::npos ? letter : '?';
  }
  letters.resize(rank, '?');
  // An axis that tells nothing has the first letter, in the usual order, that no other has.
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    const bool isFree = letters.find(usual[axis]) == std::string::npos;
    letters[axis] = letters[axis] == '?' && isFree ? usual[axis] : letters[axis];
  }
  for (char& letter : letters)
  {
    const std::size_t free = usual.find_first_not_of(letters);
    letter = letter == '?' && free != std::string::npos ? usual[free] : letter;
  }
  letters = Parse(letters, rank).IsOk() ? letters : usual;
  // Three axes may be a picture in colors.
  const bool isLikely = rank == 3 ? !isColor || least < 16 : letters == "zyxc" && last == 1;
  if (!names.empty() || !isLikely)
  {
    AddNote(told,
      "its axes" + (names.empty() ? ", without names," : ", named " + names + ",") +
        " are taken as " + letters + "; --axes says what they are");
  }
  return letters;
}

Result<ArrayAxes> ArrayAxes::Parse(const std::string& letters, std::size_t rank)
{
  const std::string text = !letters.empty() ? letters
    : rank == 3                             ? "zyx"
    : rank == 4                             ? "tzyx"
                                            : "tczyx";
  if (letters.empty() && (rank < 3 || rank > 5))
  {
    return Status(StatusCode::Unsupported,
      "it has " + std::to_string(rank) +
        " axes; a volume has 3, and with time steps and channels up to 5");
  }
  if (text.size() != rank)
  {
    return Status(StatusCode::InvalidArgument,
      "it has " + std::to_string(rank) + " axes, which \"" + text + "\" does not name");
  }
  ArrayAxes axes;
  for (std::size_t axis = 0; axis < rank; ++axis)
  {
    int* const to = text[axis] == 'x' ? &axes.X
      : text[axis] == 'y'             ? &axes.Y
      : text[axis] == 'z'             ? &axes.Z
      : text[axis] == 't'             ? &axes.Time
      : text[axis] == 'c'             ? &axes.Channel
                                      : nullptr;
    if (!to || *to >= 0)
    {
      return Status(StatusCode::InvalidArgument,
        "its axes cannot be \"" + text + "\": x, y, z, t and c stand there at most once each");
    }
    *to = static_cast<int>(axis);
  }
  if (axes.X < 0 || axes.Y < 0 || axes.Z < 0)
  {
    return Status(StatusCode::InvalidArgument,
      "its axes cannot be \"" + text + "\": a volume has the axes x, y and z");
  }
  return axes;
}

ChunkCacheSize FindChunkCacheSize(const StoredArray::Numbers& shape,
  const StoredArray::Numbers& chunk, std::size_t valueSize, std::uint64_t cacheBytes)
{
  constexpr double mostSlots = 1048573;
  constexpr double mostBytes = 1e15;
  double chunkBytes = static_cast<double>(valueSize);
  double slabChunks = 1;
  for (std::size_t axis = 0; axis < chunk.size(); ++axis)
  {
    const auto size = static_cast<double>(std::max<std::int64_t>(1, chunk[axis]));
    chunkBytes *= size;
    const bool isWithinSlab = axis + 2 >= chunk.size();
    slabChunks *= isWithinSlab ? std::ceil(static_cast<double>(shape[axis]) / size) : 1;
  }
  ChunkCacheSize cache;
  cache.ChunkBytes = chunkBytes;
  const double bytes = std::min(static_cast<double>(cacheBytes), chunkBytes * (slabChunks + 1));
  cache.Bytes = static_cast<std::size_t>(bytes);
  cache.Slots =
    static_cast<std::size_t>(std::min(10 * (std::floor(bytes / chunkBytes) + 1) + 1, mostSlots));
  cache.HeldBytes = cache.Bytes + static_cast<std::uint64_t>(std::min(2 * chunkBytes, mostBytes));
  return cache;
}

} // namespace isosurface
