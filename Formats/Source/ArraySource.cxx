// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/ArraySource.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace isosurface
{
namespace
{

constexpr std::int64_t MaximumSize = std::int64_t{ 1 } << 31;
constexpr std::int64_t MaximumChannels = 1024;
/// Arrays begin at addresses that suit every type.
constexpr std::uint64_t Alignment = 64;

std::uint64_t CountBytes(const VolumeArray& part, const VertexBox& box)
{
  const std::uint64_t bytes = static_cast<std::uint64_t>(box.GetNumberOfVertices()) *
    static_cast<std::uint64_t>(part.Channels) * GetValueSize(part.Array->GetType());
  return (bytes + Alignment - 1) / Alignment * Alignment;
}

/// Adds the views of a part's samples of the box, one for each component.
void AddViews(const VolumeArray& part, const VertexBox& box, const StoredArray::Numbers& size,
  const std::uint8_t* samples, BoxSamples& slab)
{
  StoredArray::Numbers strides(size.size(), 1);
  for (std::size_t axis = size.size(); --axis > 0;)
  {
    strides[axis - 1] = strides[axis] * size[axis];
  }
  const auto of = [&strides](int axis) { return strides[static_cast<std::size_t>(axis)]; };
  for (std::int64_t channel = 0; channel < part.Channels; ++channel)
  {
    SampleView view;
    view.Type = part.Array->GetType();
    const std::int64_t sample = channel == 0 ? 0 : channel * of(part.Axes.Channel);
    view.First = samples + static_cast<std::size_t>(sample) * GetValueSize(view.Type);
    view.Available = box;
    view.Box = box;
    view.Stride = { of(part.Axes.X), of(part.Axes.Y), of(part.Axes.Z) };
    slab.Arrays.push_back(view);
  }
}

} // namespace

Index3 VolumeArray::GetDimensions() const
{
  const StoredArray::Numbers& shape = this->Array->GetShape();
  return { shape[static_cast<std::size_t>(this->Axes.X)],
    shape[static_cast<std::size_t>(this->Axes.Y)], shape[static_cast<std::size_t>(this->Axes.Z)] };
}

Result<std::vector<VolumeArray>> MakeVolumeArrays(const std::string& name,
  std::shared_ptr<StoredArray> array, const ArrayAxes& axes, std::size_t step,
  const std::vector<std::string>& channels)
{
  const StoredArray::Numbers shape = array->GetShape();
  for (const std::int64_t size : shape)
  {
    if (size < 1 || size > MaximumSize)
    {
      return Status(StatusCode::Unsupported,
        array->GetName() + ": cannot be read: it has " + std::to_string(size) +
          " samples on an axis");
    }
  }
  const std::int64_t steps = axes.Time < 0 ? 1 : shape[static_cast<std::size_t>(axes.Time)];
  if (steps > MaximumTimeSteps)
  {
    return Status(StatusCode::Unsupported,
      array->GetName() + ": cannot be read: it has " + std::to_string(steps) + " time steps");
  }
  if (step >= static_cast<std::uint64_t>(steps))
  {
    return Status(StatusCode::InvalidArgument,
      array->GetName() + ": has " + std::to_string(steps) + " time steps, and none of number " +
        std::to_string(step));
  }
  VolumeArray part;
  part.Name = name;
  part.Array = std::move(array);
  part.Axes = axes;
  part.Step = static_cast<std::int64_t>(step);
  const std::int64_t count = axes.Channel < 0 ? 1 : shape[static_cast<std::size_t>(axes.Channel)];
  if (count > MaximumChannels)
  {
    return Status(StatusCode::Unsupported,
      part.Array->GetName() + ": cannot be read: it has " + std::to_string(count) + " channels");
  }
  const bool isInterleaved = axes.Channel + 1 == static_cast<int>(shape.size());
  if (count == 1 || isInterleaved)
  {
    part.Channels = count;
    return std::vector<VolumeArray>{ part };
  }
  std::vector<VolumeArray> parts;
  for (std::int64_t channel = 0; channel < count; ++channel)
  {
    const auto index = static_cast<std::size_t>(channel);
    part.Name = index < channels.size() ? channels[index] : name + " " + std::to_string(channel);
    part.FirstChannel = channel;
    parts.push_back(part);
  }
  return parts;
}

Status TakeVolumeArrays(
  std::vector<VolumeArray> parts, const std::vector<std::string>& names, OpenedVolume& volume)
{
  std::vector<VolumeArray> chosen;
  for (const std::string& name : names)
  {
    const auto found = std::find_if(
      parts.begin(), parts.end(), [&name](const VolumeArray& part) { return part.Name == name; });
    if (found != parts.end())
    {
      chosen.push_back(*found);
    }
  }
  if (!names.empty() && chosen.size() == names.size())
  {
    parts = std::move(chosen);
  }
  const Index3 size = parts.front().GetDimensions();
  for (int axis = 0; axis < 3; ++axis)
  {
    const auto at = static_cast<std::size_t>(axis);
    volume.Grid.Extent[2 * at + 1] = volume.Grid.Extent[2 * at] + size[at] - 1;
  }
  volume.Arrays.clear();
  for (const VolumeArray& part : parts)
  {
    if (part.GetDimensions() != size)
    {
      return Status(StatusCode::Corrupt,
        part.Array->GetName() + ": has other dimensions than " + parts.front().Array->GetName());
    }
    volume.Arrays.push_back({ part.Name, part.Array->GetType(), static_cast<int>(part.Channels) });
  }
  const VolumeArray& first = parts.front();
  if (first.Axes.Time >= 0 && volume.Times.empty())
  {
    const std::int64_t steps = first.Array->GetShape()[static_cast<std::size_t>(first.Axes.Time)];
    for (std::int64_t step = 0; step < steps; ++step)
    {
      volume.Times.push_back(static_cast<double>(step));
    }
  }
  volume.Source = std::make_unique<ArraySource>(std::move(parts));
  return Status::Ok();
}

ArraySource::ArraySource(std::vector<VolumeArray> parts)
  : Arrays(std::move(parts))
  , Box{ { 0, 0, 0 }, this->Arrays.front().GetDimensions() }
  , Pool(std::make_shared<PageBufferPool>())
{
}

std::uint64_t ArraySource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const VolumeArray& part : this->Arrays)
  {
    bytes += CountBytes(part, box);
  }
  return bytes;
}

std::uint64_t ArraySource::GetHeldBytes() const
{
  std::uint64_t bytes = 0;
  std::set<const StoredArray*> counted;
  for (const VolumeArray& part : this->Arrays)
  {
    bytes += counted.insert(part.Array.get()).second ? part.Array->GetHeldBytes() : 0;
  }
  return bytes;
}

std::int64_t ArraySource::GetRowsAtOnce() const
{
  std::int64_t least = BoxSource::GetRowsAtOnce();
  for (const VolumeArray& part : this->Arrays)
  {
    const StoredArray::Numbers chunk = part.Array->GetChunk();
    const auto of = [&chunk](int axis)
    { return axis < 0 ? 1.0 : static_cast<double>(chunk[static_cast<std::size_t>(axis)]); };
    if (chunk.empty() || of(part.Axes.Z) <= 1)
    {
      continue;
    }
    // The chunks of a row of them, with the other steps and channels that they have.
    const double across = std::ceil(static_cast<double>(this->Box.High[0]) / of(part.Axes.X));
    const double bytes = across * of(part.Axes.X) * of(part.Axes.Y) * of(part.Axes.Z) *
      of(part.Axes.Time) * std::max(of(part.Axes.Channel), static_cast<double>(part.Channels)) *
      static_cast<double>(GetValueSize(part.Array->GetType()));
    const double kept = std::floor(static_cast<double>(part.Array->GetCacheBytes()) / bytes);
    const double layer = std::ceil(static_cast<double>(this->Box.High[1]) / of(part.Axes.Y));
    if (kept < layer)
    {
      const double rows = of(part.Axes.Y) * std::max(1.0, kept);
      least = std::min(least, static_cast<std::int64_t>(std::min(rows, 1e15)));
    }
  }
  return least;
}

std::optional<Index3> ArraySource::GetChunk() const
{
  // Without chunks: whole rows, which follow each other in the file.
  constexpr std::int64_t rows = 32;
  const VolumeArray& part = this->Arrays.front();
  const StoredArray::Numbers chunk = part.Array->GetChunk();
  const std::array<int, 3> axes = { part.Axes.X, part.Axes.Y, part.Axes.Z };
  const int fastest = std::max({ axes[0], axes[1], axes[2] });
  Index3 size = this->Box.GetSize();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t wanted = !chunk.empty() ? chunk[static_cast<std::size_t>(axes[axis])]
      : axes[axis] == fastest                  ? size[axis]
                                               : rows;
    size[axis] = std::clamp<std::int64_t>(wanted, 1, size[axis]);
  }
  return size;
}

bool ArraySource::HasCheapRows() const
{
  return std::all_of(this->Arrays.begin(), this->Arrays.end(),
    [](const VolumeArray& part)
    {
      return part.Array->GetChunk().empty() && part.Axes.Z < part.Axes.Y &&
        part.Axes.Y < part.Axes.X;
    });
}

bool ArraySource::DecodesInParallel() const
{
  // Channels in chunks of their own alone: others are decoded once for all of them.
  std::set<const StoredArray*> arrays;
  return std::all_of(this->Arrays.begin(), this->Arrays.end(),
    [&](const VolumeArray& part)
    { return part.Array->DecodesInParallel() && arrays.insert(part.Array.get()).second; });
}

Result<BoxSamples> ArraySource::Read(const VertexBox& box)
{
  auto samples = this->Pool->Take(this->GetReadBytes(box));
  if (!samples.IsOk())
  {
    return Status(samples.GetStatus().GetCode(),
      this->Arrays.front().Array->GetName() + ": cannot read: " + samples.GetStatus().GetMessage());
  }
  std::uint8_t* to = (*samples)->GetData();
  BoxSamples slab;
  const Index3 boxSize = box.GetSize();
  for (const VolumeArray& part : this->Arrays)
  {
    StoredArray::Numbers low(part.Array->GetShape().size(), 0);
    StoredArray::Numbers size(low.size(), 1);
    const auto set = [&](int axis, std::int64_t first, std::int64_t count)
    {
      if (axis >= 0)
      {
        low[static_cast<std::size_t>(axis)] = first;
        size[static_cast<std::size_t>(axis)] = count;
      }
    };
    set(part.Axes.X, box.Low[0], boxSize[0]);
    set(part.Axes.Y, box.Low[1], boxSize[1]);
    set(part.Axes.Z, box.Low[2], boxSize[2]);
    set(part.Axes.Time, part.Step, 1);
    set(part.Axes.Channel, part.FirstChannel, part.Channels);
    ISOSURFACE_RETURN_IF_ERROR(part.Array->Read(low, size, to));
    AddViews(part, box, size, to, slab);
    to += CountBytes(part, box);
  }
  slab.Owner = std::move(*samples);
  return slab;
}

} // namespace isosurface
