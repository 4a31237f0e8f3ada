// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Files/VolumeFile.h"

#include "Formats/Files/StoredVolume.h"
#include "Formats/Files/SurfaceFile.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Formats/Opener/VolumeFormat.h"
#include "Formats/Opener/VolumePart.h"
#include "Formats/Source/FolderFiles.h"
#include "Ground/Base/AvailableMemory.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/FileSystem.h"
#include "Ground/Base/MemoryFileSystem.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ground/Volume/VertexPlaces.h"
#include "Ground/Volume/VolumeName.h"
#include "Ground/Volume/VolumeOpener.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Store/ChunkedSource.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <system_error>
#include <utility>

namespace isosurface
{
namespace
{

/// A volume in files of another format, without an index: it has one level.
class SourceVolume : public VolumeFile
{
public:
  /// The first time step is opened at once. Errors and cost: OpenForeignVolume, GridPlace::Apply.
  static Result<std::shared_ptr<SourceVolume>> Open(
    const std::string& path, const OpeningChoice& choice);

  const std::string& GetPath() const override { return this->Path; }
  const std::vector<ArrayDescription>& GetArrays() const override { return this->Arrays; }
  const std::vector<std::optional<double>>& GetTimes() const override { return this->Times; }
  int GetNumberOfLevels() const override { return 1; }
  std::string GetLeftOut() const override { return this->LeftOut; }
  LevelDescription Describe(int level) const override;
  /// One thread reads at a time. Memory: 64 MiB, or what the file has to decode at once.
  Status Read(const SampleRequest& request, void* samples, const Progress& progress) override;
  /// Its chunks are decoded by several threads.
  Result<std::unique_ptr<BoxSource>> OpenSource(
    std::size_t timeStep, int threads, std::uint64_t memoryBytes) override;
  SourceFiles GetSourceFiles(std::size_t timeStep) override;
  /// Reads all samples of the time step into blocks in memory, unless they are there. They stay until
  /// those of another time step are read and no caller uses them. OutOfMemory if they take more than a
  /// third of the free memory.
  Result<std::shared_ptr<BlockedVolume>> GetBlocks(
    std::size_t timeStep, const Progress& progress, std::size_t& stepThere) override;
  bool GivesParts() const override { return IsAddress(this->Path); }
  /// Reads the box alone of a volume at an address, all of its chunks at once. The last one stays.
  Result<std::shared_ptr<BlockedVolume>> GetBlocksOf(std::size_t timeStep, const VertexBox& box,
    const Progress& progress, std::size_t& stepThere, Index3& first) override;

private:
  SourceVolume() = default;
  /// Opens the file, which must be as it was when the time step was first opened.
  Result<OpenedVolume> OpenStep(std::size_t timeStep);
  /// Corrupt if the files of a time step that was opened were changed since. Of thousands of files
  /// this is not checked.
  Status CheckUnchanged(std::size_t timeStep);
  /// OpenSource() of a part alone, which is read at once; all, if it is empty.
  Result<std::unique_ptr<BoxSource>> OpenChunks(
    std::size_t timeStep, int threads, std::uint64_t memoryBytes, const VertexBox& part);
  /// That of a time step. ReadMutex is held.
  Result<BoxSource*> FindSource(std::size_t timeStep);
  Result<std::shared_ptr<BlockedVolume>> MakeBlocks(
    std::size_t timeStep, const VertexBox& box, const Progress& progress);

  std::string Path;
  std::string Axes;
  int Threads = 0;
  GridGeometry Grid;
  std::optional<GridLines> Lines;
  std::vector<ArrayDescription> Arrays;
  std::vector<std::optional<double>> Times;
  std::string LeftOut;
  Index3 Chunk{ 1, 1, 1 };

  std::mutex KnownMutex;                    ///< guards Known
  std::map<std::size_t, SourceFiles> Known; ///< of time steps

  std::mutex ReadMutex; ///< guards Source
  std::size_t SourceStep = 0;
  std::unique_ptr<BoxSource> Source; ///< of that time step
  std::mutex BlocksMutex;            ///< guards what follows
  std::map<std::size_t, std::shared_ptr<BlockedVolume>> Blocks;
  struct
  {
    std::size_t Step = 0;
    VertexBox Box;
    std::shared_ptr<BlockedVolume> Volume;
  } Part; ///< of GetBlocksOf
};

/// What a read may take beside its result, if a slice of the file needs no more.
constexpr std::uint64_t ReadBytes = std::uint64_t{ 64 } << 20;
/// Files in memory grow by doubling, and are joined by what is read of them.
constexpr std::uint64_t SharesOfFreeMemory = 3;
/// The share of a writer's memory that decoded chunks may take.
constexpr std::uint64_t CacheShare = 4;

/// The blocks of a source, and the files in memory that have them.
struct BlocksInMemory
{
  BlocksInMemory(const std::string& path)
    : Files(GetLocalFileSystem(), path, std::numeric_limits<std::int64_t>::max())
  {
  }

  MemoryFileSystem Files;
  std::shared_ptr<BlockedVolume> Volume; ///< goes before its files
};

/// The samples of a view's Box at every step-th vertex from `first` on: a view of their numbers.
SampleView TakeEvery(const SampleView& view, const Index3& first, const Index3& step)
{
  SampleView every = view;
  Index3 corner = first;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    every.Box.Low[axis] = (view.Box.Low[axis] - first[axis] + step[axis] - 1) / step[axis];
    every.Box.High[axis] = (view.Box.High[axis] - first[axis] + step[axis] - 1) / step[axis];
    corner[axis] += every.Box.Low[axis] * step[axis];
    every.Stride[axis] *= static_cast<std::ptrdiff_t>(step[axis]);
  }
  every.Available = every.Box;
  if (!every.Box.IsEmpty())
  {
    every.First = view.AtBytes(corner);
  }
  return every;
}

bool HaveSameTypes(const std::vector<ArrayDescription>& a, const std::vector<ArrayDescription>& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
    [](const ArrayDescription& one, const ArrayDescription& other)
    { return one.Type == other.Type && one.Components == other.Components; });
}

/// The end of the slices that are read together from slice `low` on: whole chunks if they are few
/// bytes, a single slice if the next chosen one is in another chunk.
std::int64_t FindEndOfSlab(
  const BoxSource& source, const SampleRequest& request, std::int64_t low, std::int64_t layers)
{
  const std::int64_t step = request.Step[2];
  const std::int64_t high = request.Box.High[2];
  if (step > 1 && step >= layers)
  {
    return low + 1;
  }
  VertexBox slab = request.Box;
  slab.Low[2] = low;
  std::int64_t end = std::min(high, (low / layers + 1) * layers);
  slab.High[2] = end;
  while (end < high && source.GetReadBytes(slab) < ReadBytes)
  {
    end = std::min(high, end + layers);
    slab.High[2] = end;
  }
  while (end > low + 1 && source.GetReadBytes(slab) > ReadBytes)
  {
    end = low + (end - low) / 2;
    slab.High[2] = end;
  }
  return end;
}

Result<std::shared_ptr<SourceVolume>> SourceVolume::Open(
  const std::string& path, const OpeningChoice& choice)
{
  std::shared_ptr<SourceVolume> volume(new SourceVolume);
  volume->Path = path;
  volume->Axes = choice.Axes;
  volume->Threads = choice.Threads;
  ISOSURFACE_ASSIGN_OR_RETURN(auto opened, volume->OpenStep(0));
  volume->Grid = opened.Grid;
  volume->Lines = std::move(opened.Lines);
  ISOSURFACE_RETURN_IF_ERROR(choice.Place.Apply(path, volume->Lines.has_value(), volume->Grid));
  volume->Arrays = std::move(opened.Arrays);
  volume->LeftOut = std::move(opened.LeftOut);
  volume->Times.assign(opened.Times.begin(), opened.Times.end());
  volume->Times.resize(std::max<std::size_t>(1, volume->Times.size()));
  const Index3 dimensions = volume->Grid.GetDimensions();
  const Index3 chunk =
    opened.Source->GetChunk().value_or(Index3{ dimensions[0], dimensions[1], 1 });
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    volume->Chunk[axis] = std::max<std::int64_t>(1, std::min(chunk[axis], dimensions[axis]));
  }
  volume->Source = std::move(opened.Source);
  return volume;
}

LevelDescription SourceVolume::Describe(int) const
{
  return { this->Grid, this->Lines, this->Chunk };
}

Result<OpenedVolume> SourceVolume::OpenStep(std::size_t timeStep)
{
  VolumeChoice choice;
  choice.Step = timeStep;
  choice.Axes = this->Axes;
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto opened, OpenForeignVolume(GetLocalFileSystem(), this->Path, choice));
  const bool isFirst = this->Arrays.empty();
  if (!isFirst &&
    (opened.Grid.GetDimensions() != this->Grid.GetDimensions() ||
      !HaveSameTypes(opened.Arrays, this->Arrays)))
  {
    return Status(StatusCode::Unsupported,
      this->Path + ": time step " + std::to_string(timeStep) +
        " has not the grid and the arrays of the file when it was opened");
  }
  {
    const std::lock_guard<std::mutex> lock(this->KnownMutex);
    const auto known = this->Known.try_emplace(timeStep);
    if (known.second)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        known.first->second, SourceFiles::Find(GetLocalFileSystem(), opened.Files));
      return opened;
    }
  }
  ISOSURFACE_RETURN_IF_ERROR(this->CheckUnchanged(timeStep));
  return opened;
}

SourceFiles SourceVolume::GetSourceFiles(std::size_t timeStep)
{
  const std::lock_guard<std::mutex> lock(this->KnownMutex);
  return this->Known[timeStep];
}

Status SourceVolume::CheckUnchanged(std::size_t timeStep)
{
  const std::lock_guard<std::mutex> lock(this->KnownMutex);
  const auto known = this->Known.find(timeStep);
  if (known == this->Known.end() || known->second.State.Files > SourceRecord::MaximumFilesToCheck)
  {
    return Status::Ok();
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto state, FindStateOfAll(GetLocalFileSystem(), known->second.Paths));
  return state == known->second.State
    ? Status::Ok()
    : Status(StatusCode::Corrupt, this->Path + ": was changed since it was opened; open it again");
}

Result<BoxSource*> SourceVolume::FindSource(std::size_t timeStep)
{
  if (timeStep != this->SourceStep || !this->Source)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto opened, this->OpenStep(timeStep));
    this->Source = std::move(opened.Source);
    this->SourceStep = timeStep;
  }
  return this->Source.get();
}

Status SourceVolume::Read(const SampleRequest& request, void* samples, const Progress& progress)
{
  const std::lock_guard<std::mutex> lock(this->ReadMutex);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckUnchanged(request.TimeStep));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto source, this->FindSource(request.TimeStep));
  const std::size_t first = ArrayVariables(this->Arrays).GetFirst(request.Array);
  const ValueType type = this->Arrays[request.Array].Type;
  const auto stride = static_cast<std::ptrdiff_t>(request.Components.size());
  const std::int64_t step = request.Step[2];
  VertexBox whole;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    whole.High[axis] = (request.Box.GetSize()[axis] + request.Step[axis] - 1) / request.Step[axis];
  }
  VertexBox slab = request.Box;
  while (slab.Low[2] < request.Box.High[2])
  {
    slab.High[2] = FindEndOfSlab(*source, request, slab.Low[2], this->Chunk[2]);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto read, source->Read(slab));
    for (std::size_t number = 0; number < request.Components.size(); ++number)
    {
      SampleView view = read.Arrays[first + static_cast<std::size_t>(request.Components[number])];
      view.Box = slab;
      const SampleView chosen = TakeEvery(view, request.Box.Low, request.Step);
      CopyBox(chosen, chosen.Box, whole, request.FindPlace(samples, number, type), stride);
    }
    // The next chosen slice.
    const std::int64_t taken = (slab.High[2] - request.Box.Low[2] + step - 1) / step;
    slab.Low[2] = request.Box.Low[2] + taken * step;
    if (progress && !progress(static_cast<double>(taken) / static_cast<double>(whole.High[2])))
    {
      return { StatusCode::Aborted, this->Path + ": reading was stopped" };
    }
  }
  return Status::Ok();
}

Result<std::unique_ptr<BoxSource>> SourceVolume::OpenSource(
  std::size_t timeStep, int threads, std::uint64_t memoryBytes)
{
  return this->OpenChunks(timeStep, threads, memoryBytes / CacheShare, {});
}

Result<std::unique_ptr<BoxSource>> SourceVolume::OpenChunks(
  std::size_t timeStep, int threads, std::uint64_t memoryBytes, const VertexBox& part)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto opened, this->OpenStep(timeStep));
  SourceRecord wanted;
  wanted.Axes = this->Axes;
  wanted.Step = timeStep;
  std::transform(opened.Arrays.begin(), opened.Arrays.end(), std::back_inserter(wanted.Arrays),
    [](const ArrayDescription& array) { return array.Name; });
  ISOSURFACE_RETURN_IF_ERROR(ChunkedSource::Replace(opened.Source, GetLocalFileSystem(),
    OpenForeignVolume, this->Path, this->Path, wanted, opened.Grid, opened.Arrays,
    { memoryBytes, SerialCommunicator().ChooseThreads(threads), {}, part }));
  return std::move(opened.Source);
}

Result<std::shared_ptr<BlockedVolume>> SourceVolume::GetBlocks(
  std::size_t timeStep, const Progress& progress, std::size_t& stepThere)
{
  const std::lock_guard<std::mutex> lock(this->BlocksMutex);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckUnchanged(timeStep));
  stepThere = 0;
  if (const auto kept = this->Blocks.find(timeStep); kept != this->Blocks.end())
  {
    return kept->second;
  }
  for (auto other = this->Blocks.begin(); other != this->Blocks.end();)
  {
    const bool isUsed = other->second.use_count() > 1; // it becomes so only under the lock
    other = isUsed ? std::next(other) : this->Blocks.erase(other);
  }
  this->Part = {};
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto made, this->MakeBlocks(timeStep, { {}, this->Grid.GetDimensions() }, progress));
  this->Blocks[timeStep] = made;
  return made;
}

Result<std::shared_ptr<BlockedVolume>> SourceVolume::GetBlocksOf(std::size_t timeStep,
  const VertexBox& box, const Progress& progress, std::size_t& stepThere, Index3& first)
{
  const VertexBox all{ {}, this->Grid.GetDimensions() };
  // All ranks come to the same: what one of them has in memory, or has room for, does not count.
  if (box == all || !this->GivesParts())
  {
    return this->GetBlocks(timeStep, progress, stepThere);
  }
  const std::lock_guard<std::mutex> lock(this->BlocksMutex);
  ISOSURFACE_RETURN_IF_ERROR(this->CheckUnchanged(timeStep));
  const bool isThere = this->Part.Volume && this->Part.Step == timeStep && this->Part.Box == box;
  if (!isThere)
  {
    this->Part = {};
    ISOSURFACE_ASSIGN_OR_RETURN(auto made, this->MakeBlocks(timeStep, box, progress));
    this->Part = { timeStep, box, std::move(made) };
  }
  stepThere = 0;
  first = this->Part.Box.Low;
  return this->Part.Volume;
}

Result<std::shared_ptr<BlockedVolume>> SourceVolume::MakeBlocks(
  std::size_t timeStep, const VertexBox& box, const Progress& progress)
{
  const std::uint64_t bytes = static_cast<std::uint64_t>(box.GetNumberOfVertices()) *
    SumValueSizes(ArrayVariables(this->Arrays).GetStoredTypes());
  const std::uint64_t available = GetAvailableMemory();
  if (available > 0 && bytes > available / SharesOfFreeMemory)
  {
    return Status(StatusCode::OutOfMemory,
      this->Path +
        ": has no index, and is too large to be searched in memory; "
        "make one with scalable_isosurface.index(), or a volume with create()");
  }
  const std::string path = this->Path + ".bvol-in-memory";
  const auto memory = std::make_shared<BlocksInMemory>(path);
  SerialCommunicator alone;
  BlockedVolumeSettings settings;
  settings.NumberOfStores = 1;
  settings.Distribution = DistributionMethod::Slab;
  settings.Time = this->Times[timeStep];
  settings.Threads = this->Threads;
  GridGeometry grid = this->Grid;
  const bool isPart = !(box == VertexBox{ {}, grid.GetDimensions() });
  ISOSURFACE_ASSIGN_OR_RETURN(auto source,
    isPart ? this->OpenChunks(timeStep, this->Threads, available / SharesOfFreeMemory, box)
           : this->OpenSource(timeStep, this->Threads, settings.MemoryLimit));
  settings.Files = this->GetSourceFiles(timeStep);
  settings.Lines = this->Lines;
  CutGrid(grid, settings.Lines, box);
  source = CutSource(std::move(source), box);
  BlockedVolumeWriter writer(alone, memory->Files);
  if (isPart)
  {
    const ReadingStop stop(progress);
    ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, source->Read(source->GetBox()));
    ISOSURFACE_RETURN_IF_ERROR(
      writer
        .Write(path, grid, this->Arrays, { source->GetBox(), samples.Arrays }, settings, progress)
        .GetStatus());
  }
  else
  {
    ISOSURFACE_RETURN_IF_ERROR(
      writer.Write(path, grid, this->Arrays, *source, settings, progress).GetStatus());
  }
  ISOSURFACE_ASSIGN_OR_RETURN(memory->Volume, BlockedVolume::Open(path, memory->Files));
  return std::shared_ptr<BlockedVolume>(memory, memory->Volume.get());
}

/// Gives a volume of one kind as any volume.
template <typename Volume>
Result<std::shared_ptr<VolumeFile>> AsFile(Result<std::shared_ptr<Volume>> opened)
{
  ISOSURFACE_RETURN_IF_ERROR(opened.GetStatus());
  return std::shared_ptr<VolumeFile>(std::move(*opened));
}

} // namespace

VertexBox LevelDescription::FindVerticesAround(
  const std::array<double, 3>& low, const std::array<double, 3>& high) const
{
  const VertexPlaces places(this->Grid, this->Lines ? &*this->Lines : nullptr);
  const Index3 size = this->Grid.GetDimensions();
  VertexBox box = places.FindVerticesAround(low, high);
  box = box.IsEmpty() ? VertexBox{ {}, { 1, 1, 1 } } : box;
  // A plane on one layer of vertices could lie beside it by rounding: it has two, of one chunk.
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (box.High[axis] - box.Low[axis] == 1)
    {
      box.Low[axis] =
        std::max<std::int64_t>(0, std::min(box.Low[axis] & ~std::int64_t{ 1 }, size[axis] - 2));
      box.High[axis] = std::min(box.Low[axis] + 2, size[axis]);
    }
  }
  return box;
}

Result<FileKind> FindFileKind(const std::string& name)
{
  const VolumeName parsed = VolumeName::Parse(GetLocalFileSystem(), name);
  std::error_code error;
  if (IsAddress(parsed.Path))
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckReadable(GetLocalFileSystem(), parsed.Path));
  }
  else if (!std::filesystem::exists(parsed.Path, error) &&
    FindFittingNames(GetLocalFileSystem(), parsed.Path, nullptr).empty())
  {
    return Status(StatusCode::NotFound, name + ": there is no such file or folder");
  }
  if (std::filesystem::path(name).extension() == ".bvol")
  {
    return FileKind::BlockedVolume;
  }
  const VolumeFormat* const format =
    IsAddress(parsed.Path) ? FindVolumeFormat(GetLocalFileSystem(), parsed) : nullptr;
  if (format && format->IsFolder) // what a server says of a folder need not be asked for
  {
    return FileKind::Source;
  }
  return SurfaceFile::CanRead(name) ? FileKind::Surface : FileKind::Source;
}

Result<std::shared_ptr<VolumeFile>> VolumeFile::Open(
  const std::string& name, const OpeningChoice& choice)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto kind, FindFileKind(name));
  if (kind == FileKind::Surface)
  {
    return Status(StatusCode::InvalidArgument, name + ": is a surface, not a volume");
  }
  if (kind == FileKind::BlockedVolume && choice.Bounds)
  {
    return Status(StatusCode::InvalidArgument,
      name +
        ": is a blocked volume, which is opened whole; choose the region of what is read from it");
  }
  if (kind == FileKind::BlockedVolume)
  {
    return AsFile(StoredVolume::Open(name, choice));
  }
  FileSystem& files = GetLocalFileSystem();
  ISOSURFACE_ASSIGN_OR_RETURN(const auto index,
    SourceIndex::FindPartOf(
      files, name, "", choice.Axes, choice.IndexFolder, choice.Place, choice.Bounds));
  const auto state = FindIndexState(files, index);
  return state.IsOk() && *state == IndexState::Current
    ? AsFile(StoredVolume::Open(index.Path, choice))
    : AsFile(SourceVolume::Open(choice.Bounds ? index.Source : name, choice));
}

} // namespace isosurface
