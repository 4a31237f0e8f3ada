// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/SourceIndex.h"

#include "Formats/Indexing/FetchBudget.h"
#include "Formats/Indexing/SampleCollector.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Opener/VolumePart.h"
#include "Formats/Source/FolderFiles.h"
#include "Formats/Zarr/JsonField.h"
#include "Formats/Zarr/ZarrVolume.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/RemoteCache.h"
#include "Ground/Volume/VolumeName.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/ChunkedSource.h"
#include "Storage/Store/FinishedLayers.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"
#include "Storage/Writing/VolumePlan.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

/// The share of the memory that decoded chunks may take.
constexpr std::uint64_t CacheShare = 4;

std::filesystem::path MakeAbsolute(const std::string& path)
{
  if (IsAddress(path))
  {
    return path;
  }
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::weakly_canonical(path, error);
  return error ? std::filesystem::path(path) : absolute;
}

/// Separates a folder within a Zarr or N5 from the outermost folder of it.
VolumeName FindOutermost(FileSystem& files, const std::filesystem::path& chosen)
{
  std::filesystem::path outermost = chosen;
  while (!IsAddress(chosen.string()) && outermost.has_parent_path() &&
    outermost.parent_path() != outermost && IsZarrFolder(files, outermost.parent_path().string()))
  {
    outermost = outermost.parent_path();
  }
  const std::string within = chosen.lexically_relative(outermost).generic_string();
  return { outermost.string(), within == "." ? "" : within };
}

/// Where the index of an address is, in the user's cache: a folder for each.
std::filesystem::path FindFolderOfAddress(const std::string& address)
{
  return std::filesystem::path(RemoteCache::FindFolder()) / "indexes" /
    FormatChecksum(ComputeChecksum(address.data(), address.size()));
}

/// Whether it is a volume that can be indexed. Images of one slice are left to readers of images.
bool IsWanted(const Result<OpenedVolume>& volume)
{
  if (!volume.IsOk())
  {
    return false;
  }
  const Index3 size = volume->Grid.GetDimensions();
  return *std::min_element(size.begin(), size.end()) > 1;
}

struct OpenedStep
{
  OpenedVolume Volume;
  BlockedVolumeSettings Settings;
};

Result<OpenedStep> OpenStep(
  FileSystem& files, const SourceIndex& index, std::size_t step, std::uint64_t memoryBytes)
{
  VolumeChoice choice;
  choice.Step = step;
  choice.Axes = index.Axes;
  choice.CacheBytes = memoryBytes / CacheShare;
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, OpenForeignVolume(files, index.Source, choice));
  SourceRecord wanted;
  wanted.Axes = index.Axes;
  wanted.Step = step;
  for (const ArrayDescription& array : volume.Arrays)
  {
    wanted.Arrays.push_back(array.Name);
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto record,
    DescribeSource(
      files, OpenForeignVolume, index.Path, index.Source, wanted, volume.Grid, volume.Arrays));
  OpenedStep opened{ std::move(volume), {} };
  // Ranks read different slabs in place. Of a copy each has a part of what is finished, at any time.
  opened.Settings.Distribution =
    record.Chunk ? DistributionMethod::Slab : DistributionMethod::Random;
  opened.Settings.Lines = opened.Volume.Lines;
  opened.Settings.Files = { opened.Volume.Files, record.State };
  // Each query would decode a stream from the front, so its samples are copied.
  (record.Chunk ? opened.Settings.InPlace : opened.Settings.CopyOf) = std::move(record);
  opened.Settings.Compression.Codec = SegmentCodec::Lz4;
  opened.Settings.JournalSeconds = BlockedVolumeSettings::UsualJournalSeconds;
  opened.Settings.MemoryLimit = memoryBytes;
  opened.Settings.Append = step > 0;
  if (step < opened.Volume.Times.size())
  {
    opened.Settings.Time = opened.Volume.Times[step];
  }
  return opened;
}

/// Whether a copy would have the name of the index: of the folder or file "rock" it is "rock.bvol".
bool IsNamedAlike(FileSystem& files, const std::filesystem::path& source)
{
  const bool isFolder = !ListNames(files, source.string()).empty();
  return source.extension().empty() || (isFolder && !IsZarrFolder(files, source.string()));
}

/// WriteSourceIndex() without the budget.
Result<std::string> WriteSteps(Communicator& ranks, FileSystem& files, const SourceIndex& index,
  std::uint64_t memoryBytes, const Progress& progress, SampleCollector* collector,
  FinishedLayers* finished, int threads, const WhenSourceIsOpen& whenOpen);

} // namespace

std::optional<std::array<double, 2>> FindWindow(FileSystem& files, const SourceIndex& index)
{
  VolumeChoice choice;
  choice.Axes = index.Axes;
  choice.WantsAttributes = true;
  const auto volume = OpenForeignVolume(files, index.Source, choice);
  const auto said =
    volume.IsOk() ? nlohmann::json::parse(volume->Attributes, nullptr, false) : nlohmann::json();
  const nlohmann::json& center = FindJson(said, "WindowCenter");
  const nlohmann::json& width = FindJson(said, "WindowWidth");
  if (!center.is_number() || !width.is_number())
  {
    return std::nullopt;
  }
  const double half = width.get<double>() / 2;
  return std::array<double, 2>{ center.get<double>() - half, center.get<double>() + half };
}

SourceIndex SourceIndex::Find(FileSystem& files, const std::string& chosen,
  const std::string& dataset, const std::string& axes, const std::string& folder)
{
  VolumeName name = VolumeName::Parse(files, chosen);
  std::filesystem::path path = MakeAbsolute(name.Path);
  if (IsZarrMetadata(path.filename().string()))
  {
    path = path.parent_path();
  }
  const VolumeName outermost = FindOutermost(files, path);
  name.Path = outermost.Path;
  name.Within = name.Within.empty() ? outermost.Within : name.Within;
  name.Within = dataset.empty() ? name.Within : dataset;
  const std::filesystem::path source(name.Path);
  std::string file = source.filename().string();
  if (const std::size_t begin = name.Within.find_first_not_of('/'); begin != std::string::npos)
  {
    file += '-' + name.Within.substr(begin);
    std::replace(file.begin(), file.end(), '/', '-');
  }
  else if (IsNamedAlike(files, source))
  {
    file += ".index";
  }
  const std::filesystem::path parent = !folder.empty() ? MakeAbsolute(folder)
    : IsAddress(name.Path)                             ? FindFolderOfAddress(name.Path)
                                                       : source.parent_path();
  return { name.GetText(), axes, (parent / (file + ".bvol")).string(), {} };
}

Result<SourceIndex> SourceIndex::FindPartOf(FileSystem& files, const std::string& chosen,
  const std::string& dataset, const std::string& axes, const std::string& folder,
  const GridPlace& place, const std::optional<std::array<double, 6>>& bounds)
{
  SourceIndex index = Find(files, chosen, dataset, axes, folder);
  index.Place = place;
  if (!bounds)
  {
    return index;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto part, FindPart(files, index.Source, axes, place, *bounds));
  index = Find(files, chosen, VolumeName::Parse(files, part).Within, axes, folder);
  index.Place = place;
  return index;
}

bool CanBeIndexed(FileSystem& files, const std::string& chosen)
{
  const SourceIndex index = SourceIndex::Find(files, chosen, "", "", "");
  const VolumeName name = VolumeName::Parse(files, index.Source);
  const VolumeFormat* const format = FindVolumeFormat(files, name);
  // HDF5 and NetCDF of other extensions are mostly meshes, which have readers of their own.
  if (!format || !(format->IsFolder || format->HasExtension(name.Path)))
  {
    return false;
  }
  const auto whole = OpenForeignVolume(files, index.Source);
  if (whole.IsOk())
  {
    return IsWanted(whole);
  }
  // A reader of VTK would show something else of a damaged file, or of one whose samples are missing.
  const bool isPlain = !format->Module && !format->Functions.List;
  if (whole.GetStatus().GetCode() == StatusCode::Corrupt ||
    (whole.GetStatus().GetCode() == StatusCode::NotFound && isPlain))
  {
    // Other files, too, are called .map or .rec.
    return format->Name != "MRC" || FindExtension(name.Path).compare(0, 4, ".mrc") == 0 ||
      format->HasAnyMark(files, name.Path);
  }
  constexpr std::size_t most = 64;
  const std::vector<std::string> names = ListVolumes(files, chosen);
  return std::any_of(names.begin(),
    names.begin() + static_cast<std::ptrdiff_t>(std::min(most, names.size())),
    [&](const std::string& within)
    {
      return within.compare(0, name.Within.size(), name.Within) == 0 &&
        IsWanted(OpenForeignVolume(files, name.Path + ":" + within));
    });
}

std::vector<std::string> ListVolumes(FileSystem& files, const std::string& chosen)
{
  const SourceIndex index = SourceIndex::Find(files, chosen, "", "", "");
  const auto listed = ListForeignVolumes(files, VolumeName::Parse(files, index.Source).Path);
  std::vector<std::string> names;
  for (std::size_t entry = 0; listed.IsOk() && entry < listed->size(); ++entry)
  {
    const std::string& shape = (*listed)[entry].Shape;
    const auto axes = 1 + std::count(shape.begin(), shape.end(), 'x');
    if (axes >= 3 && axes <= 5)
    {
      names.push_back((*listed)[entry].Name);
    }
  }
  return names;
}

bool IsRawSource(FileSystem& files, const std::string& chosen)
{
  const SourceIndex index = SourceIndex::Find(files, chosen, "", "", "");
  const VolumeFormat* const format =
    FindVolumeFormat(files, VolumeName::Parse(files, index.Source));
  return !format || format->Name == "raw";
}

Result<IndexState> FindIndexState(FileSystem& files, const SourceIndex& index)
{
  if (!files.Exists(index.Path))
  {
    return IndexState::Missing;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto volume, BlockedVolume::Open(index.Path, files));
  const BlockedVolumeHeader& header = volume->GetHeader();
  const VolumeName name = VolumeName::Parse(files, index.Source);
  for (const TimeStepDescription& step : header.TimeSteps)
  {
    const std::optional<SourceRecord>& record = step.Source ? step.Source : step.CopyOf;
    const bool isMine = record && record->Within == name.Within && record->Axes == index.Axes &&
      MakeAbsolute(record->FindPath(files, index.Path)) == MakeAbsolute(name.Path);
    if (!isMine)
    {
      return Status(StatusCode::InvalidArgument,
        index.Path + ": is there already and is no index of " + index.Source +
          "; choose another folder for the index");
    }
    if (!CheckSource(files, OpenForeignVolume, index.Path, *record, header.Grid, header.Arrays)
           .IsOk())
    {
      return IndexState::Changed;
    }
  }
  return IndexState::Current;
}

bool CanWriteIndex(FileSystem& files, const SourceIndex& index)
{
  const std::string path = index.Path + ".try"; // another program may be writing the index now
  const bool canWrite =
    files.MakeDirectories(std::filesystem::path(path).parent_path().string()).IsOk() &&
    files.CreateForWriting(path).IsOk();
  return files.RemoveAll(path).IsOk() && canWrite;
}

Result<std::string> WriteSourceIndex(Communicator& ranks, FileSystem& files,
  const SourceIndex& index, std::uint64_t memoryBytes, const Progress& progress,
  SampleCollector* collector, FinishedLayers* finished, int threads,
  const WhenSourceIsOpen& whenOpen)
{
  std::string leftOut;
  const auto write = [&](const Progress& advance) -> Status
  {
    ISOSURFACE_ASSIGN_OR_RETURN(leftOut,
      WriteSteps(
        ranks, files, index, memoryBytes, advance, collector, finished, threads, whenOpen));
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(
    index.Fetching ? index.Fetching->Run(ranks, progress, write) : write(progress));
  return leftOut;
}

namespace
{

Result<std::string> WriteSteps(Communicator& ranks, FileSystem& files, const SourceIndex& index,
  std::uint64_t memoryBytes, const Progress& progress, SampleCollector* collector,
  FinishedLayers* finished, int threads, const WhenSourceIsOpen& whenOpen)
{
  BlockedVolumeWriter writer(ranks, files);
  std::string leftOut;
  std::size_t steps = 1;
  const int threadsOfRank = ranks.ChooseThreads(threads);
  for (std::size_t step = 0; step < steps; ++step)
  {
    auto opened = Attempt(index.Source,
      [&]() -> Result<OpenedStep>
      {
        ISOSURFACE_ASSIGN_OR_RETURN(auto found, OpenStep(files, index, step, memoryBytes));
        if (found.Settings.InPlace)
        {
          OpenedVolume& volume = found.Volume;
          ChunkDecoding decoding = { memoryBytes / CacheShare, threadsOfRank, {} };
          if (finished && step == 0)
          {
            decoding.IsShared = [finished]
            {
              finished->WaitForBoxes();
              return finished->AreShown();
            };
          }
          ISOSURFACE_RETURN_IF_ERROR(
            ChunkedSource::Replace(volume.Source, files, OpenForeignVolume, index.Path,
              index.Source, *found.Settings.InPlace, volume.Grid, volume.Arrays, decoding));
        }
        if (finished && step == 0 && found.Settings.InPlace)
        {
          ISOSURFACE_ASSIGN_OR_RETURN(const auto planned,
            PlanVolume(
              index.Path, found.Volume.Grid, found.Volume.Arrays, found.Settings, std::nullopt, 1));
          finished->Begin(planned);
        }
        if (finished && step == 0)
        {
          found.Settings.WhenFinished = [finished](
                                          const BlockedVolumeHeader& volume, FinishedBlocks blocks)
          { finished->Add(volume, std::move(blocks)); };
        }
        if (collector && step == 0)
        {
          collector->Begin(found.Volume);
          found.Settings.WhenRead = [collector](const BoxSamples& slab, const VertexBox& box)
          { collector->Add(slab, box); };
        }
        return found;
      });
    const std::size_t times = opened.IsOk() ? opened->Volume.Times.size() : 0;
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(opened.GetStatus(),
      { { times, index.Source + ": the ranks see different numbers of time steps" } }));
    steps = std::max<std::size_t>(1, times);
    leftOut = opened->Volume.LeftOut;
    if (index.Fetching)
    {
      const OpenedVolume& volume = opened->Volume;
      index.Fetching->SetSampleBytes(steps *
        static_cast<std::uint64_t>(volume.Grid.GetNumberOfVertices()) *
        SumValueSizes(ArrayVariables(volume.Arrays).GetStoredTypes()));
    }
    if (whenOpen && step == 0)
    {
      ISOSURFACE_RETURN_IF_ERROR(whenOpen(ranks, progress));
    }
    opened->Settings.Publish = step + 1 == steps;
    opened->Settings.Threads = threadsOfRank;
    const Progress tell = [&](double share) {
      return !progress ||
        progress((static_cast<double>(step) + share) / static_cast<double>(steps));
    };
    ISOSURFACE_RETURN_IF_ERROR(writer
                                 .Write(index.Path, opened->Volume.Grid, opened->Volume.Arrays,
                                   *opened->Volume.Source, opened->Settings, tell)
                                 .GetStatus());
  }
  return leftOut;
}

} // namespace

} // namespace isosurface
