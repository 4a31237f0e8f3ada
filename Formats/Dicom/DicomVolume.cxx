// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomVolume.h"

#include "Formats/Dicom/DicomSeries.h"
#include "Formats/Dicom/DicomStack.h"
#include "Formats/Source/AxisUnits.h"
#include "Ground/Volume/PageBuffer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

namespace isosurface
{
namespace
{

using Slices = std::vector<DicomSlice>;

/// Boxes of the slices' images, decoded one after another.
class DicomSource : public BoxSource
{
public:
  DicomSource(std::shared_ptr<const Slices> slices, ValueType type)
    : Series(std::move(slices))
    , Type(type)
    , Box{ { 0, 0, 0 },
      { this->Series->front().Columns, this->Series->front().Rows,
        static_cast<std::int64_t>(this->Series->size()) } }
    , Pool(std::make_shared<PageBufferPool>())
  {
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    return static_cast<std::uint64_t>(box.GetNumberOfVertices()) * GetValueSize(this->Type);
  }
  /// A compressed image and a copy that GDCM makes, the decoded one and another copy; less of others.
  std::uint64_t GetHeldBytes() const override
  {
    return 6 * static_cast<std::uint64_t>(this->Box.High[0] * this->Box.High[1]) *
      GetValueSize(this->Series->front().Type) +
      this->Series->size() * 1024;
  }
  /// An image.
  std::optional<Index3> GetChunk() const override
  {
    return Index3{ this->Box.High[0], this->Box.High[1], 1 };
  }

  bool DecodesInParallel() const override { return true; }
  std::unique_ptr<BoxSource> Fork() const override
  {
    return std::make_unique<DicomSource>(this->Series, this->Type);
  }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto samples, this->Pool->Take(this->GetReadBytes(box)));
    const Index3 size = box.GetSize();
    const std::int64_t width = this->Box.High[0];
    std::uint8_t* to = samples->GetData();
    for (std::int64_t k = box.Low[2]; k < box.High[2]; ++k)
    {
      const DicomSlice& slice = (*this->Series)[static_cast<std::size_t>(k)];
      ISOSURFACE_RETURN_IF_ERROR(slice.Decode(this->Image));
      for (std::int64_t j = box.Low[1]; j < box.High[1]; ++j)
      {
        const auto first =
          static_cast<std::size_t>(j * width + box.Low[0]) * GetValueSize(slice.Type);
        ScaleSamples(slice.Type, this->Image.data() + first, static_cast<std::size_t>(size[0]),
          slice.Scale, this->Type, to);
        to += static_cast<std::size_t>(size[0]) * GetValueSize(this->Type);
      }
    }
    return MakeBoxSamples(this->Type, box, std::move(samples));
  }

private:
  std::shared_ptr<const Slices> Series;
  ValueType Type;
  VertexBox Box;
  std::vector<std::uint8_t> Image;
  std::shared_ptr<PageBufferPool> Pool;
};

/// The smallest type that has all scaled values.
ValueType FindType(const Slices& slices)
{
  double low = 0;
  double high = 0;
  bool isScaled = false;
  for (const DicomSlice& slice : slices)
  {
    const auto [slope, intercept] = slice.Scale;
    isScaled = isScaled || !slice.Scale.IsIdentity() || slice.Type != slices[0].Type;
    if (slope != std::floor(slope) || intercept != std::floor(intercept))
    {
      return ValueType::Float32;
    }
    const double range = std::ldexp(1.0, slice.ValueBits);
    const double minimum = slice.IsSigned() ? -range / 2 : 0;
    const double ends[] = { slope * minimum + intercept,
      slope * (minimum + range - 1) + intercept };
    low = std::min({ low, ends[0], ends[1] });
    high = std::max({ high, ends[0], ends[1] });
  }
  if (!isScaled)
  {
    return slices[0].Type;
  }
  return low >= -128 && high <= 127              ? ValueType::Int8
    : low >= 0 && high <= 255                    ? ValueType::UInt8
    : low >= -32768 && high <= 32767             ? ValueType::Int16
    : low >= 0 && high <= 65535                  ? ValueType::UInt16
    : low >= -2147483648.0 && high <= 2147483647 ? ValueType::Int32
                                                 : ValueType::Float64;
}

bool IsSame(const Slices& slices, std::string DicomSlice::*text)
{
  return std::all_of(slices.begin(), slices.end(),
    [&](const DicomSlice& slice) { return slice.*text == slices[0].*text; });
}

/// What of the slices is not obeyed, of the first that has some of it.
std::string FindNotes(const Slices& slices)
{
  const auto noted = std::find_if(
    slices.begin(), slices.end(), [](const DicomSlice& slice) { return !slice.Notes.empty(); });
  std::string notes = noted == slices.end() ? "" : noted->Notes;
  if (!IsSame(slices, &DicomSlice::Frame))
  {
    AddNote(
      notes, "its slices have several Frames of Reference, and are placed as if they had one");
  }
  return notes;
}

/// The window of the first slice that has one, as an object of JSON.
std::string FindAttributes(const Slices& slices)
{
  const auto has = std::find_if(
    slices.begin(), slices.end(), [](const DicomSlice& slice) { return slice.WindowWidth > 0; });
  std::array<char, 120> text{};
  if (has != slices.end())
  {
    std::snprintf(text.data(), text.size(), R"({"WindowCenter": %.17g, "WindowWidth": %.17g})",
      has->WindowCenter, has->WindowWidth);
  }
  return text.data();
}

Result<OpenedVolume> OpenDicomVolume(
  FileSystem& /*files*/, const VolumeName& name, const VolumeChoice& choice)
{
  PassedOver over;
  ISOSURFACE_ASSIGN_OR_RETURN(auto slices, ChooseDicomSeries(name, over));
  ISOSURFACE_RETURN_IF_ERROR(SortSlices(slices, over));
  OpenedVolume volume;
  ISOSURFACE_RETURN_IF_ERROR(TakeGrid(slices, volume));
  for (const std::string& text : { FindNotes(slices), over.GetText() })
  {
    volume.LeftOut += (volume.LeftOut.empty() || text.empty() ? "" : "; ") + text;
  }
  const ValueType type = FindType(slices);
  volume.Attributes = choice.WantsAttributes ? FindAttributes(slices) : "";
  const bool hasUnit = IsSame(slices, &DicomSlice::Unit);
  volume.Arrays = { { "DICOM", type, 1, hasUnit ? slices.front().Unit : "" } };
  for (const DicomSlice& slice : slices)
  {
    volume.Files.push_back(slice.Path);
  }
  volume.Source =
    std::make_unique<DicomSource>(std::make_shared<const Slices>(std::move(slices)), type);
  return volume;
}

Result<std::vector<VolumeListing>> ListDicom(FileSystem& /*files*/, const VolumeName& name)
{
  PassedOver over;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto all, FindDicomSeries(name.Path, over));
  std::vector<VolumeListing> list;
  for (const auto& [uid, series] : all)
  {
    if (!series.Fault.IsOk())
    {
      list.push_back({ series.Name, "?", "?", series.Fault.GetMessage() });
      continue;
    }
    const Slices& slices = series.Slices;
    list.push_back({ series.Name,
      std::to_string(slices.size()) + " x " + std::to_string(slices[0].Rows) + " x " +
        std::to_string(slices[0].Columns),
      GetValueTypeName(slices[0].Type),
      "series " + uid + ", transfer syntax " + slices[0].Syntax });
  }
  return list;
}

} // namespace

const FormatFunctions IsosurfaceDicomFormat = { OpenDicomVolume, ListDicom };

} // namespace isosurface
