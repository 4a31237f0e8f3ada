// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffImage.h"

#include "Formats/Source/TextFields.h"
#include "Ground/Volume/LengthUnit.h"

#include <algorithm>

namespace isosurface
{

std::string NormalizeUnit(const std::string& unit)
{
  const std::string text = TrimText(unit);
  const std::string lower = LowerText(text);
  return lower == "pixel" || lower == "pixels" || lower == "reference frame" ? "" : text;
}

bool UniteLengths(std::array<double, 3>& lengths, const std::array<std::string, 3>& units)
{
  if (units[1] == units[0] && units[2] == units[0])
  {
    return true;
  }
  std::array<double, 3> meters = {};
  std::transform(units.begin(), units.end(), meters.begin(),
    [](const std::string& unit) { return GetMeters(FindLengthUnit(unit)); });
  if (std::count(meters.begin(), meters.end(), 0.0) > 0)
  {
    return false;
  }
  for (std::size_t axis = 1; axis < 3; ++axis)
  {
    lengths[axis] *= meters[axis] / meters[0];
  }
  return true;
}

std::int64_t TiffImage::GetNumberOfPlanes() const
{
  return this->Sizes[Slices] * this->Sizes[Channels] * this->Sizes[Frames];
}

std::string TiffImage::DescribeSizes() const
{
  return std::to_string(this->Sizes[Channels]) + " channels, " +
    std::to_string(this->Sizes[Slices]) + " slices and " + std::to_string(this->Sizes[Frames]) +
    " frames";
}

void TiffImage::TakePagesAsSlices()
{
  if (this->Sizes[Slices] > 1 || (this->Sizes[Channels] > 1) == (this->Sizes[Frames] > 1))
  {
    return;
  }
  const Axis other = this->Sizes[Channels] > 1 ? Channels : Frames;
  this->AddNote("its " + std::to_string(this->Sizes[other]) +
    " pages, which its description calls " + (other == Channels ? "channels" : "frames") +
    " of a single slice, are taken as slices");
  this->Sizes[Slices] = this->Sizes[other];
  this->Sizes[other] = 1;
  this->ChannelNames.clear();
  // The place of each page on the only axis of several is its number in any order.
  this->Order = { Slices, Channels, Frames };
}

Status TiffImage::Visit(
  const std::string& name, const Counter& countPages, const Visitor& visit) const
{
  const std::int64_t planes = this->GetNumberOfPlanes();
  std::int64_t visited = 0;
  for (const Run& run : this->Runs)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto found, run.Count < 0 ? countPages(run.File) : Result<std::int64_t>(run.Count));
    const std::int64_t count = found;
    // So what is visited is no more than the image has, whatever the runs say.
    visited += count;
    if (count > planes || visited > planes || run.FirstPlane > planes - count)
    {
      return Status(StatusCode::Corrupt,
        name + ": its description names more pages than an image of " + this->DescribeSizes() +
          " has");
    }
    for (std::int64_t number = 0; number < count; ++number)
    {
      std::array<std::int64_t, 3> place = {};
      std::int64_t rest = run.FirstPlane + number;
      for (const std::size_t axis : this->Order)
      {
        place[axis] = rest % this->Sizes[axis];
        rest /= this->Sizes[axis];
      }
      ISOSURFACE_RETURN_IF_ERROR(visit(place, run.File, run.FirstPage + number));
    }
  }
  return Status::Ok();
}

} // namespace isosurface
