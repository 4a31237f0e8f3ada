// SPDX-License-Identifier: BSD-3-Clause
#include "FramePart.h"

#include "Base/Coding.h"

#include <algorithm>
#include <cmath>

namespace isosurface
{
namespace
{

template <typename Value>
void Append(Value value, Message& bytes)
{
  bytes.resize(bytes.size() + sizeof(value));
  StoreLittleEndian(bytes.data() + bytes.size() - sizeof(value), value);
}

/// Takes values from the front of a message; zeros behind its end.
class MessageReader
{
public:
  explicit MessageReader(const Message& bytes)
    : Bytes(bytes)
  {
  }
  template <typename Value>
  Value Take()
  {
    if (this->Bytes.size() - this->Offset < sizeof(Value))
    {
      return Value{};
    }
    const auto value = LoadLittleEndian<Value>(this->Bytes.data() + this->Offset);
    this->Offset += sizeof(Value);
    return value;
  }

private:
  const Message& Bytes;
  std::size_t Offset = 0;
};

// The distance of a part's middle from the display's, as a share of that of the display's corners.
double GetOffset(const Viewport& viewport, const PixelRectangle& display)
{
  const PixelRectangle pixels = viewport.GetPixels(display);
  const double x = pixels.X + 0.5 * pixels.Width - 0.5 * display.Width;
  const double y = pixels.Y + 0.5 * pixels.Height - 0.5 * display.Height;
  return std::hypot(x, y) / (0.5 * std::hypot(display.Width, display.Height));
}

} // namespace

Message FramePart::Pack() const
{
  Message bytes;
  Append(this->Triangles, bytes);
  Append(this->NearDistance, bytes);
  Append(this->FarDistance, bytes);
  Append(this->LastSeconds, bytes);
  Append(this->Budget, bytes);
  Append(std::int32_t{ this->WantsDepths ? 1 : 0 }, bytes);
  Append(static_cast<std::int32_t>(this->Choices.size()), bytes);
  for (const Viewport& choice : this->Choices)
  {
    for (const int value : { choice.Divisor, choice.Blocks.X, choice.Blocks.Y, choice.Blocks.Width,
           choice.Blocks.Height })
    {
      Append(std::int32_t{ value }, bytes);
    }
  }
  return bytes;
}

FramePart FramePart::Unpack(const Message& bytes)
{
  MessageReader reader(bytes);
  FramePart part;
  part.Triangles = reader.Take<std::int64_t>();
  part.NearDistance = reader.Take<double>();
  part.FarDistance = reader.Take<double>();
  part.LastSeconds = reader.Take<double>();
  part.Budget = reader.Take<double>();
  part.WantsDepths = reader.Take<std::int32_t>() != 0;
  const auto count = std::clamp<std::int32_t>(
    reader.Take<std::int32_t>(), 1, static_cast<std::int32_t>(NumberOfResolutions));
  for (std::int32_t choice = 0; choice < count; ++choice)
  {
    Viewport viewport;
    viewport.Divisor = reader.Take<std::int32_t>();
    viewport.Blocks.X = reader.Take<std::int32_t>();
    viewport.Blocks.Y = reader.Take<std::int32_t>();
    viewport.Blocks.Width = reader.Take<std::int32_t>();
    viewport.Blocks.Height = reader.Take<std::int32_t>();
    part.Choices.push_back(viewport);
  }
  return part;
}

std::vector<RankWork> MakeRankWork(
  const std::vector<FramePart>& parts, const PixelRectangle& display)
{
  double nearest = HUGE_VAL;
  double farthest = -HUGE_VAL;
  for (const FramePart& part : parts)
  {
    if (!part.Choices.front().Blocks.IsEmpty())
    {
      nearest = std::min(nearest, part.NearDistance);
      farthest = std::max(farthest, part.FarDistance);
    }
  }
  std::vector<RankWork> work;
  for (const FramePart& part : parts)
  {
    RankWork mine;
    mine.Triangles = part.Triangles;
    for (const Viewport& choice : part.Choices)
    {
      std::size_t resolution = 0;
      while (
        resolution + 1 < NumberOfResolutions && GetResolutionDivisor(resolution) < choice.Divisor)
      {
        ++resolution;
      }
      mine.Samples[resolution] = choice.Blocks.GetArea();
    }
    const double depth =
      farthest > nearest ? (part.NearDistance - nearest) / (farthest - nearest) : 0;
    mine.Importance = GetImportance(GetOffset(part.Choices.front(), display), depth);
    work.push_back(mine);
  }
  return work;
}

} // namespace isosurface
