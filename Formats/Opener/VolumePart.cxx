// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Opener/VolumePart.h"

#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Ground/Volume/VolumeName.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <utility>

namespace isosurface
{
namespace
{

class PartSource : public BoxSource
{
public:
  PartSource(std::unique_ptr<BoxSource> source, const VertexBox& part)
    : Source(std::move(source))
    , Part(part)
    , Box{ { 0, 0, 0 }, part.GetSize() }
  {
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    return this->Source->GetReadBytes(box.Translate(this->Part.Low));
  }
  std::uint64_t GetHeldBytes() const override { return this->Source->GetHeldBytes(); }
  std::int64_t GetRowsAtOnce() const override { return this->Source->GetRowsAtOnce(); }
  std::optional<Index3> GetChunk() const override { return this->Source->GetChunk(); }
  bool HasCheapRows() const override { return this->Source->HasCheapRows(); }
  bool DecodesInParallel() const override { return this->Source->DecodesInParallel(); }
  void Prefetch(const VertexBox& box) const override
  {
    this->Source->Prefetch(box.Translate(this->Part.Low));
  }
  bool CanReadAhead() const override { return this->Source->CanReadAhead(); }
  std::unique_ptr<BoxSource> Fork() const override
  {
    auto forked = this->Source->Fork();
    return forked ? CutSource(std::move(forked), this->Part) : nullptr;
  }
  Result<BoxSamples> Read(const VertexBox& box) override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto samples, this->Source->Read(box.Translate(this->Part.Low)));
    const Index3& low = this->Part.Low;
    for (SampleView& view : samples.Arrays)
    {
      view.Box = view.Box.Translate({ -low[0], -low[1], -low[2] });
      view.Available = view.Available.Translate({ -low[0], -low[1], -low[2] });
    }
    return samples;
  }

private:
  const std::unique_ptr<BoxSource> Source;
  const VertexBox Part;
  const VertexBox Box;
};

} // namespace

std::optional<VertexBox> TakePart(std::string& within)
{
  const std::size_t begin = within.rfind('[');
  VertexBox part;
  Index3& low = part.Low;
  Index3& high = part.High;
  int end = 0;
  const bool isPart = begin != std::string::npos &&
    std::sscanf(within.c_str() + begin, "[%18ld-%18ld,%18ld-%18ld,%18ld-%18ld]%n", &low[0],
      &high[0], &low[1], &high[1], &low[2], &high[2], &end) == 6 &&
    end > 0 && begin + static_cast<std::size_t>(end) == within.size();
  if (!isPart)
  {
    return std::nullopt;
  }
  for (std::int64_t& last : high)
  {
    ++last;
  }
  within.erase(begin);
  return part;
}

Result<std::string> FindPart(FileSystem& files, const std::string& text, const std::string& axes,
  const GridPlace& place, const std::array<double, 6>& bounds)
{
  VolumeChoice choice;
  choice.Axes = axes;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, OpenForeignVolume(files, text, choice));
  ISOSURFACE_RETURN_IF_ERROR(place.Apply(text, volume.Lines.has_value(), volume.Grid));
  const VertexBox& box = volume.Source->GetBox();
  VertexBox part =
    VertexPlaces(volume.Grid, volume.Lines ? &*volume.Lines : nullptr)
      .FindVerticesAround({ bounds[0], bounds[2], bounds[4] }, { bounds[1], bounds[3], bounds[5] });
  if (part.IsEmpty())
  {
    return Status(StatusCode::InvalidArgument, text + ": the region is beside the volume");
  }
  const auto chunk = volume.Source->GetChunk();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    std::int64_t& low = part.Low[axis];
    std::int64_t& high = part.High[axis];
    if (chunk && !volume.Source->HasCheapRows())
    {
      low -= low % (*chunk)[axis];
      high = std::min(high + (*chunk)[axis] - 1 - (high - 1) % (*chunk)[axis], box.High[axis]);
    }
    // One vertex has no cell.
    high = std::min(std::max(high, low + 2), box.High[axis]);
    low = std::max<std::int64_t>(0, std::min(low, high - 2));
  }
  VolumeName name = VolumeName::Parse(files, text);
  if (part == box)
  {
    return text;
  }
  if (const std::optional<VertexBox> outer = TakePart(name.Within))
  {
    part = part.Translate(outer->Low);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    name.Within += (axis == 0 ? "[" : ",") + std::to_string(part.Low[axis]) + "-" +
      std::to_string(part.High[axis] - 1);
  }
  name.Within += "]";
  return name.GetText();
}

std::unique_ptr<BoxSource> CutSource(std::unique_ptr<BoxSource> source, const VertexBox& part)
{
  return std::make_unique<PartSource>(std::move(source), part);
}

void CutGrid(GridGeometry& grid, std::optional<GridLines>& lines, const VertexBox& part)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::int64_t first = grid.Extent[2 * axis];
    grid.Extent[2 * axis] = first + part.Low[axis];
    grid.Extent[2 * axis + 1] = first + part.High[axis] - 1;
  }
  lines = lines ? std::optional<GridLines>(lines->Cut(part)) : std::nullopt;
}

} // namespace isosurface
