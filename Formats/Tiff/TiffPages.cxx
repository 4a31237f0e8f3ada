// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Tiff/TiffDescription.h"
#include "Formats/Tiff/TiffFile.h"
#include "Formats/Tiff/TiffHandle.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// The maximum number of smaller images of a page: each is half as wide, or so.
constexpr std::size_t MaximumLevels = 31;
/// The maximum number of pages of a file: each takes memory, and ImageJ's one byte of the file.
constexpr std::size_t MaximumPages = std::size_t{ 1 } << 20;
constexpr std::size_t MaximumFormats = 1000;                       ///< of the pages of a file
constexpr std::size_t MaximumJson = 65536;                         ///< of a description of tifffile
constexpr std::size_t MaximumShapeBytes = std::size_t{ 64 } << 20; ///< of all of them

/// A tag that libtiff does not know.
struct TagOfProgram
{
  std::uint32_t Tag;
  const char* Name;
};
// Of programs that say in words of their own what the pages of a file are.
constexpr TagOfProgram TagsOfPages[] = { { 33629, "MetaMorph" }, { 34361, "FluoView" },
  { 34412, "Zeiss LSM" }, { 43314, "NIH Image" }, { 51123, "Micro-Manager" } };
// Of what places or changes the samples.
constexpr TagOfProgram TagsOfPlaces[] = { { 33550, "GeoTIFF's ModelPixelScale" },
  { 33922, "GeoTIFF's ModelTiepoint" }, { 34264, "GeoTIFF's ModelTransformation" },
  { 42112, "GDAL's metadata (perhaps a scale and an offset of samples)" },
  { 33445, "Molecular Dynamics' coding of samples" } };

} // namespace

bool TiffFile::IsOfAnotherPage() const
{
  const auto type = this->Tiff->Get<std::uint32_t>(TIFFTAG_SUBFILETYPE, 0);
  return (type & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

void TiffFile::AddLevels(TiffPage& page, bool isFirst)
{
  std::uint16_t count = 0;
  const std::uint64_t* directories = nullptr;
  if (::TIFFGetField(this->Tiff->Tiff, TIFFTAG_SUBIFD, &count, &directories) != 1)
  {
    count = 0;
  }
  if (isFirst)
  {
    this->Levels = count <= MaximumLevels ? count : 0;
  }
  if (count != this->Levels)
  {
    this->Levels = 0;
    this->SmallerPages.clear();
  }
  page.FirstLevel = static_cast<std::uint32_t>(this->SmallerPages.size());
  this->SmallerPages.insert(this->SmallerPages.end(), directories, directories + this->Levels);
}

Result<TiffContents> TiffFile::FindPages()
{
  ::TIFF* tiff = this->Tiff->Tiff;
  TiffContents contents;
  int lastNumber = -1;
  std::size_t shapeBytes = 0;
  do
  {
    const bool isFirst = contents.Pages.empty();
    if (contents.Pages.size() == MaximumPages)
    {
      return this->MakeError(StatusCode::Unsupported,
        "at most " + std::to_string(MaximumPages) + " pages are supported");
    }
    TiffPage page;
    page.Directory = ::TIFFCurrentDirOffset(tiff);
    page.IsOfAnother = !isFirst && this->IsOfAnotherPage();
    const auto format = this->ReadFormat();
    if (isFirst)
    {
      ISOSURFACE_RETURN_IF_ERROR(format.GetStatus());
      this->TakeTags(contents);
    }
    if (format.IsOk())
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto scratch, this->FindScratchBytes(*format));
      this->ScratchBytes = std::max(this->ScratchBytes, scratch);
      auto known = std::find(contents.Formats.begin(), contents.Formats.end(), *format);
      if (known == contents.Formats.end() && contents.Formats.size() < MaximumFormats)
      {
        known = contents.Formats.insert(known, *format);
      }
      page.Format =
        known == contents.Formats.end() ? -1 : static_cast<int>(known - contents.Formats.begin());
    }
    std::uint16_t number = 0;
    std::uint16_t count = 0;
    if (!page.IsOfAnother && ::TIFFGetField(tiff, TIFFTAG_PAGENUMBER, &number, &count) == 1)
    {
      if (number < lastNumber && contents.PageNumbers.IsOk())
      {
        contents.PageNumbers = this->MakeError(StatusCode::Unsupported,
          "its page number is " + std::to_string(number) + ", that of the page before is " +
            std::to_string(lastNumber));
      }
      lastNumber = number;
    }
    if (!page.IsOfAnother)
    {
      this->AddLevels(page, isFirst);
    }
    const std::string text = this->FindDescription();
    if (!text.empty() && text.front() == '{' && text.size() <= MaximumJson &&
      text.find("\"shape\"") != std::string::npos)
    {
      contents.Shapes.emplace_back(static_cast<std::int64_t>(contents.Pages.size()), text);
      shapeBytes += text.size();
    }
    if (shapeBytes > MaximumShapeBytes)
    {
      return this->MakeError(StatusCode::Unsupported, "its descriptions are too long");
    }
    contents.Pages.push_back(page);
  } while (::TIFFReadDirectory(tiff) == 1);
  // The last directory ends the loop without an error; so does one that cannot be read, with one.
  if (!this->Tiff->Failure.IsOk() || !this->Tiff->Reason.empty())
  {
    return this->MakeError(StatusCode::Corrupt, "the directory of the next page cannot be read");
  }
  if (contents.Pages.size() == 1)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Expand(contents));
  }
  return contents;
}

std::string TiffFile::FindDescription() const
{
  const char* found = nullptr;
  const bool hasText =
    ::TIFFGetField(this->Tiff->Tiff, TIFFTAG_IMAGEDESCRIPTION, &found) == 1 && found;
  return hasText ? found : "";
}

void TiffFile::TakeTags(TiffContents& contents) const
{
  const TiffHandle& tiff = *this->Tiff;
  contents.Description = this->FindDescription();
  contents.XResolution = tiff.Get<float>(TIFFTAG_XRESOLUTION, 0);
  contents.YResolution = tiff.Get<float>(TIFFTAG_YRESOLUTION, 0);
  contents.ResolutionUnit = tiff.Get<std::uint16_t>(TIFFTAG_RESOLUTIONUNIT, 1);
  const auto note = [&contents](const std::string& text)
  { contents.Notes += (contents.Notes.empty() ? "" : "; ") + text; };
  if (const auto orientation = tiff.Get<std::uint16_t>(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
      orientation != ORIENTATION_TOPLEFT)
  {
    note("its rows are taken from the first one stored on, to the right: its Orientation (" +
      std::to_string(orientation) + ") says that they are shown in another way");
  }
  const auto photometric = tiff.Get<std::uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  if (photometric == PHOTOMETRIC_MINISWHITE)
  {
    note("samples are as stored, although 0 is white (PhotometricInterpretation 0)");
  }
  if (photometric == PHOTOMETRIC_PALETTE)
  {
    note("samples are as stored, without the colours of ImageJ's table");
  }
  if (const std::string text = this->FindNoData(); !text.empty())
  {
    note("missing samples stay the number of GDAL_NODATA, " + text);
  }
  for (const TagOfProgram& known : TagsOfPlaces)
  {
    if (tiff.FindUnknown(known.Tag).second)
    {
      note(std::string(known.Name) + " is not obeyed");
    }
  }
  for (const TagOfProgram& known : TagsOfPages)
  {
    contents.Program = tiff.FindUnknown(known.Tag).second ? known.Name : contents.Program;
  }
  const char* const software = tiff.Get<const char*>(TIFFTAG_SOFTWARE, "");
  if (std::string(software).rfind("SI.", 0) == 0 ||
    contents.Description.find("scanimage.SI.") != std::string::npos ||
    contents.Description.rfind("state.config", 0) == 0 ||
    contents.Description.rfind("frameNumbers = ", 0) == 0)
  {
    contents.Program = "ScanImage";
  }
}

Status TiffFile::Expand(TiffContents& contents)
{
  const TiffPage first = contents.Pages.front();
  const TiffFormat& format = contents.Formats.front();
  const std::int64_t images = TiffDescription::CountImages(contents.Description, format);
  if (images <= 1)
  {
    return Status::Ok();
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(format.Width) *
    static_cast<std::uint64_t>(format.Height * format.Planes) * format.GetPixelBytes();
  const std::uint64_t begin = ::TIFFGetStrileOffset(this->Tiff->Tiff, 0);
  const std::uint64_t size = this->Tiff->File->GetSize();
  if (this->Tiff->Get<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE) != COMPRESSION_NONE ||
    ::TIFFNumberOfStrips(this->Tiff->Tiff) != 1 || format.Planes > 1 || begin == 0 ||
    begin > size || static_cast<std::uint64_t>(images) > (size - begin) / bytes)
  {
    return this->MakeError(StatusCode::Corrupt,
      "truncated: its description speaks of " + std::to_string(images) +
        " images, which are not there");
  }
  if (static_cast<std::uint64_t>(images) > MaximumPages)
  {
    return this->MakeError(StatusCode::Unsupported,
      "its description speaks of " + std::to_string(images) + " images; at most " +
        std::to_string(MaximumPages) + " pages are supported");
  }
  this->Levels = 0;
  for (std::uint64_t image = 1; image < static_cast<std::uint64_t>(images); ++image)
  {
    contents.Pages.push_back(first);
    contents.Pages.back().Shift = image * bytes;
  }
  return Status::Ok();
}

Status TiffFile::MakeErrorOf(const TiffPage& page, StatusCode code, const std::string& reason)
{
  ::TIFFSetSubDirectory(this->Tiff->Tiff, page.Directory);
  return this->MakeError(code, reason);
}

} // namespace isosurface
