// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomSlice.h"
#include "Formats/Dicom/DicomStack.h"
#include "Formats/Source/AxisUnits.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/FormatFunctions.h"
#include "Formats/Source/TextFields.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Volume/PageBuffer.h"
#include "Ground/Volume/VolumeName.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// What files have of a series.
struct DicomSeries
{
  std::vector<DicomSlice> Slices;
  Status Fault; ///< of the first of its images that cannot be read
  /// "Thorax 5.0 B30f (CT, 120 slices of 512 x 512)"; the UID if no image can be read. Of series that would
  /// have the same one, their numbers and perhaps the ends of their UIDs stand in it.
  std::string Name;
};

using AllSeries = std::map<std::string, DicomSeries>;

constexpr int MaximumFolderDepth = 16;

/// Whether there is a folder; not if the system does not tell.
bool IsFolder(const std::string& path)
{
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

bool IsDirectoryFile(const std::string& path)
{
  return LowerText(std::filesystem::path(path).filename().string()) == "dicomdir";
}

/// Adds the image of a file to its series. False if it has none.
Result<bool> AddImage(const std::string& path, AllSeries& all)
{
  std::string uid;
  auto slice = DicomSlice::Read(path, &uid);
  if (slice.IsOk())
  {
    all[uid].Slices.push_back(std::move(*slice));
    return true;
  }
  if (slice.GetStatus().GetCode() == StatusCode::NotFound)
  {
    return false;
  }
  if (uid.empty())
  {
    return slice.GetStatus();
  }
  Status& fault = all[uid].Fault;
  fault = fault.IsOk() ? slice.GetStatus() : fault;
  return true;
}

/// Adds the images of a folder, or else those of the folders in it.
Status AddFolder(const std::string& folder, const std::vector<std::string>& names, int depth,
  AllSeries& all, PassedOver& over)
{
  std::vector<std::string> folders;
  bool hasImages = false;
  for (const std::string& name : names)
  {
    const std::string path = (std::filesystem::path(folder) / name).string();
    std::error_code error;
    if (IsHiddenName(name))
    {
      over.Add("hidden", path);
    }
    else if (IsFolder(path))
    {
      folders.push_back(path);
    }
    else if (std::filesystem::is_regular_file(path, error))
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto isImage, AddImage(path, all));
      hasImages = hasImages || isImage;
      if (!isImage)
      {
        over.Add("without an image of DICOM", path);
      }
    }
  }
  for (const std::string& inner : folders)
  {
    if (hasImages || depth == 0)
    {
      over.Add(hasImages ? "a folder beside images" : "a folder that is too deep", inner);
      continue;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto within, GetLocalFileSystem().List(inner));
    ISOSURFACE_RETURN_IF_ERROR(AddFolder(inner, within, depth - 1, all, over));
  }
  return Status::Ok();
}

/// `distinction`: 0 of a series that reads like no other, up to 3 of those that do.
std::string MakeName(const std::string& uid, const DicomSeries& series, int distinction)
{
  if (series.Slices.empty())
  {
    return uid;
  }
  const DicomSlice& first = series.Slices[0];
  const std::string& number = first.SeriesNumber;
  const std::size_t count = series.Slices.size();
  const std::size_t end = distinction > 2 ? 0 : uid.size() - std::min<std::size_t>(uid.size(), 8);
  std::string name = (first.Description.empty() ? "no description" : first.Description) + " (" +
    (first.Modality.empty() ? "" : first.Modality + ", ") + std::to_string(count) +
    (count == 1 ? " slice of " : " slices of ") + std::to_string(first.Columns) + " x " +
    std::to_string(first.Rows) + (distinction > 0 && !number.empty() ? ", series " + number : "") +
    (distinction > 1 ? ", UID ..." + uid.substr(end) : "") + ")";
  // Of any character set; a colon is what a name of a volume is split at.
  std::replace_if(
    name.begin(), name.end(), [](char c) { return c < ' ' || c > '~' || c == ':'; }, '_');
  return name;
}

void MakeNames(AllSeries& all)
{
  for (int distinction = 0; distinction <= 3; ++distinction)
  {
    std::map<std::string, int> uses;
    for (const auto& [uid, series] : all)
    {
      ++uses[series.Name];
    }
    for (auto& [uid, series] : all)
    {
      series.Name = distinction == 0 || uses[series.Name] > 1 ? MakeName(uid, series, distinction)
                                                              : series.Name;
    }
  }
}

/**
 * All series of a name, by their UID: of the images in a folder, or else of those in its folders, and so
 * on (the same of the folder of a file DICOMDIR); of those in the folder of another file; or of those
 * that fit a pattern. An image that cannot be read is an error of its series; of all if its header does
 * not tell the series, since a slice of any may be missing. NotFound if there are none.
 */
Result<AllSeries> FindDicomSeries(const std::string& path, PassedOver& over)
{
  FileSystem& files = GetLocalFileSystem();
  AllSeries all;
  const std::string folder = IsFolder(path) ? path : FindFolder(path);
  Result<std::vector<std::string>> names = std::vector<std::string>();
  if (IsPattern(files, path))
  {
    names = FindFittingNames(files, path, &over);
  }
  else
  {
    names = files.List(folder);
  }
  ISOSURFACE_RETURN_IF_ERROR(names.GetStatus());
  const bool isTree = IsFolder(path) || IsDirectoryFile(path);
  PassedOver ofFile; // nobody has asked for the other files
  ISOSURFACE_RETURN_IF_ERROR(AddFolder(folder, *names, isTree ? MaximumFolderDepth : 0, all,
    isTree || IsPattern(files, path) ? over : ofFile));
  if (all.empty())
  {
    const std::string passed = over.GetText();
    return Status(StatusCode::NotFound,
      path + ": cannot be read: there are no images of DICOM" +
        (passed.empty() ? "" : "; " + passed));
  }
  MakeNames(all);
  return all;
}

/// The images of the series that is meant (IsosurfaceDicomFormat).
Result<std::vector<DicomSlice>> ChooseDicomSeries(const VolumeName& name, PassedOver& over)
{
  std::string wanted = name.Within;
  const bool isImage = !IsFolder(name.Path) && !IsDirectoryFile(name.Path) &&
    !IsPattern(GetLocalFileSystem(), name.Path);
  if (isImage)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto slice, DicomSlice::Read(name.Path));
    wanted = slice.Series;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto all, FindDicomSeries(name.Path, over));
  const auto take = [](DicomSeries& series) -> Result<std::vector<DicomSlice>>
  {
    ISOSURFACE_RETURN_IF_ERROR(series.Fault);
    return std::move(series.Slices);
  };
  std::vector<DicomSeries*> fitting;
  Status fault;
  std::string known;
  for (auto& [uid, series] : all)
  {
    if (uid == wanted || series.Name == wanted)
    {
      return take(series);
    }
    const std::vector<DicomSlice>& slices = series.Slices;
    const bool isEnd = uid.size() >= wanted.size() &&
      uid.compare(uid.size() - wanted.size(), wanted.size(), wanted) == 0;
    if (isEnd && slices.empty())
    {
      fault = fault.IsOk() ? series.Fault : fault;
    }
    else if (isEnd)
    {
      fitting.push_back(&series);
    }
    if (!slices.empty())
    {
      known += (known.empty() ? " as in \"" + name.Path + ":" : ", \"") + series.Name + "\"";
    }
  }
  if (fitting.empty())
  {
    ISOSURFACE_RETURN_IF_ERROR(fault);
  }
  if (fitting.size() != 1)
  {
    return Status(
      StatusCode::NotFound, name.GetText() + ": cannot be read: name one of its series," + known);
  }
  return take(*fitting[0]);
}

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

/**
 * A series of DICOM images with a slice a file:
 *
 *     file           the series of this file, in its folder
 *     folder         the only series in the folder or else in its folders; those without a readable image
 *                    do not count; DICOMDIR stands for its folder
 *     pattern        the only series of the files that fit
 *     folder:NAME    the series of this name (MakeName) or instance UID, or of the only UID that ends so
 *
 * DicomStack.h and FindDicomSeries tell which files are taken. The grid is that of the patient: millimetres, x to the left, y to the back, z up. A tilted
 * gantry gives directions that are not at right angles, and is named in LeftOut. Slope and intercept
 * are applied; the type is the smallest integer that has all values if both are whole numbers,
 * otherwise float32.
 *
 * Source: DICOM PS3.3, C.7.6.2 (Image Plane) and C.11.1 (Modality LUT).
 */
extern "C" const FormatFunctions IsosurfaceDicomFormat;
const FormatFunctions IsosurfaceDicomFormat = { OpenDicomVolume, ListDicom };

} // namespace isosurface
