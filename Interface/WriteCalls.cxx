// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/VolumeHandle.h"

#include "Ground/Base/OutputCheck.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <cmath>
#include <utility>

using namespace isosurface;

namespace isosurface
{
namespace
{

/// The samples of a time step that a C program gives.
class CallbackSource : public BoxSource
{
public:
  CallbackSource(const std::vector<ArrayDescription>& arrays, const LevelDescription& grid,
    si_reader reader, void* context, std::size_t step)
    : Arrays(arrays)
    , Box{ { 0, 0, 0 }, grid.Grid.GetDimensions() }
    , Chunk(grid.Chunk)
    , Reader(reader)
  {
    this->Asked.size = sizeof(this->Asked);
    this->Asked.context = context;
    this->Asked.step = step;
  }

  const VertexBox& GetBox() const override { return this->Box; }
  std::uint64_t GetReadBytes(const VertexBox& box) const override
  {
    std::uint64_t bytes = 0;
    for (const ArrayDescription& array : this->Arrays)
    {
      bytes += GetValueSize(array.Type) * static_cast<std::uint64_t>(array.Components);
    }
    // What the program reads, and what it makes of that.
    return 2 * bytes * static_cast<std::uint64_t>(box.GetNumberOfVertices());
  }
  std::optional<Index3> GetChunk() const override
  {
    return this->Chunk[0] > 0 ? std::optional<Index3>(this->Chunk) : std::nullopt;
  }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    const auto owner = std::make_shared<std::vector<Buffer<char>>>();
    BoxSamples samples;
    samples.Owner = owner;
    for (std::size_t number = 0; number < this->Arrays.size(); ++number)
    {
      const ArrayDescription& array = this->Arrays[number];
      const std::size_t tuple =
        GetValueSize(array.Type) * static_cast<std::size_t>(array.Components);
      Buffer<char>& bytes =
        owner->emplace_back(tuple * static_cast<std::size_t>(box.GetNumberOfVertices()));
      this->Asked.array = number;
      std::copy(box.Low.begin(), box.Low.end(), this->Asked.low);
      std::copy(box.High.begin(), box.High.end(), this->Asked.high);
      this->Asked.samples = bytes.GetData();
      this->Asked.bytes = bytes.GetSize();
      if (this->Reader(&this->Asked) != 1)
      {
        return Status(
          StatusCode::IoError, array.Name + ": the program that reads the samples has failed");
      }
      SampleView view;
      view.Type = array.Type;
      view.Box = box;
      view.Available = box;
      const Index3 size = box.GetSize();
      view.Stride = { array.Components, array.Components * size[0],
        array.Components * size[0] * size[1] };
      for (int component = 0; component < array.Components; ++component)
      {
        view.First =
          bytes.GetData() + static_cast<std::size_t>(component) * GetValueSize(array.Type);
        samples.Arrays.push_back(view);
      }
    }
    return samples;
  }

private:
  const std::vector<ArrayDescription>& Arrays;
  const VertexBox Box;
  const Index3 Chunk;
  const si_reader Reader;
  si_reading Asked{};
};

Result<BlockedVolumeSettings> TakeSettings(const si_settings* given, int threads, Call& call)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(given, "si_settings"));
  BlockedVolumeSettings settings;
  const auto codec = FindCodec(taken.codec ? taken.codec : "lz4");
  settings.Compression = { codec.value_or(SegmentCodec::None), taken.codec_level };
  if (!codec || !settings.Compression.IsValid())
  {
    return Status(StatusCode::InvalidArgument,
      "compression is not none, lz4, lz4:1 to lz4:12, zstd or zstd:1 to zstd:19");
  }
  settings.BlockSize = taken.block_size != 0 ? taken.block_size : settings.BlockSize;
  settings.NumberOfStores = taken.stores;
  settings.NumberOfReplicas = taken.replicas;
  settings.Append = taken.append != 0;
  if (taken.distribution < 0 || taken.distribution > static_cast<int>(DistributionMethod::Balanced))
  {
    return Status(StatusCode::InvalidArgument, "si_settings: there is no such distribution");
  }
  settings.Distribution = static_cast<DistributionMethod>(taken.distribution);
  settings.RandomSeed = taken.random_seed;
  settings.MemoryLimit = taken.memory != 0 ? taken.memory : settings.MemoryLimit;
  settings.Threads = threads;
  settings.Warn = [&call](const std::string& warning) { call.Warn(warning); };
  return settings;
}

/// What is written, and how.
struct VolumeWriting
{
  std::string Path;
  LevelDescription Grid;
  std::vector<ArrayDescription> Arrays;
  BlockedVolumeSettings Settings;

  /// Writes time steps, all of which become visible with the last one: of open(step, settings) each, which gives a
  /// source, or an error of this rank.
  template <typename OpenT>
  Status Write(Call& call, const std::vector<double>& times, const OpenT& open)
  {
    Communicator& ranks = call.GetRanks();
    BlockedVolumeWriter writer(ranks);
    this->Settings.Lines = this->Grid.Lines;
    for (std::size_t step = 0; step < times.size(); ++step)
    {
      this->Settings.Time =
        std::isnan(times[step]) ? std::nullopt : std::optional<double>(times[step]);
      this->Settings.Publish = step + 1 == times.size();
      const auto source = Attempt(this->Path, [&] { return open(step, this->Settings); });
      ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(source.GetStatus()));
      ISOSURFACE_RETURN_IF_ERROR(writer
                                   .Write(this->Path, this->Grid.Grid, this->Arrays, **source,
                                     this->Settings, call.GetProgress())
                                   .GetStatus());
      this->Settings.Append = true;
    }
    return Status::Ok();
  }
};

} // namespace
} // namespace isosurface

si_result si_write_volume(const char* path, const si_grid* grid, size_t array_count,
  const si_array* arrays, size_t step_count, const double* times, si_reader reader, void* context,
  const si_settings* settings, const si_run* run)
{
  return RunCall(ToText(path), run,
    [&](Call& call) -> Status
    {
      VolumeWriting writing;
      writing.Path = ToText(path);
      const int threads = call.ShareThreads();
      const auto take = [&]() -> Status
      {
        ISOSURFACE_ASSIGN_OR_RETURN(writing.Grid, TakeGrid(grid));
        ISOSURFACE_ASSIGN_OR_RETURN(writing.Settings, TakeSettings(settings, threads, call));
        for (std::size_t number = 0; number < array_count; ++number)
        {
          const si_array& array = arrays[number];
          if (!si_type_name(array.type) || array.components < 1 || !reader || step_count < 1)
          {
            return { StatusCode::InvalidArgument,
              writing.Path + ": a type, components, time steps or the reader make no sense" };
          }
          writing.Arrays.push_back({ ToText(array.name), static_cast<ValueType>(array.type),
            array.components, ToText(array.unit) });
        }
        return Status::Ok();
      };
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(call.GetRanks(), writing.Path, take));
      std::vector<double> all(step_count, std::nan(""));
      if (times)
      {
        all.assign(times, times + step_count);
      }
      return writing.Write(call, all,
        [&](std::size_t step, BlockedVolumeSettings&)
        {
          return Result<std::unique_ptr<BoxSource>>(
            std::make_unique<CallbackSource>(writing.Arrays, writing.Grid, reader, context, step));
        });
    });
}

si_result si_volume_write(si_volume* volume, const char* path, const si_grid* grid,
  const double* times, const si_settings* settings, const si_run* run)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      VolumeFile& file = *volume->File;
      VolumeWriting writing;
      writing.Path = ToText(path);
      const int threads = call.ShareThreads();
      writing.Arrays = file.GetArrays();
      const auto take = [&]() -> Status
      {
        writing.Grid = file.Describe(0);
        if (grid)
        {
          ISOSURFACE_ASSIGN_OR_RETURN(writing.Grid, TakeGrid(grid));
        }
        ISOSURFACE_ASSIGN_OR_RETURN(writing.Settings, TakeSettings(settings, threads, call));
        return Status::Ok();
      };
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(call.GetRanks(), writing.Path, take));
      std::vector<double> all = volume->Times;
      if (times)
      {
        all.assign(times, times + all.size());
      }
      return writing.Write(call, all,
        [&](std::size_t step, BlockedVolumeSettings& ofStep) -> Result<std::unique_ptr<BoxSource>>
        {
          auto source = file.OpenSource(step, ofStep.Threads, ofStep.MemoryLimit);
          ofStep.Files = file.GetSourceFiles(step);
          for (const std::string& read : ofStep.Files.Paths)
          {
            ISOSURFACE_RETURN_IF_ERROR(CheckIsOther(writing.Path, read));
          }
          return source;
        });
    });
}
