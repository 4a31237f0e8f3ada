// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/StoredArray.h"

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

Result<ArrayAxes> ArrayAxes::Parse(const std::string& letters, const StoredArray::Numbers& shape)
{
  const std::size_t rank = shape.size();
  const bool hasComponent = letters.empty() && (rank == 4 || rank == 5) && shape.back() == 1;
  return Parse(!hasComponent ? letters : rank == 4 ? "zyxc" : "tzyxc", rank);
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

} // namespace isosurface
