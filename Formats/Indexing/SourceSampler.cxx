// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/SourceSampler.h"

#include "Formats/Indexing/ReadingOrder.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/SampleCopy.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t Mebibyte = 1 << 20;
/// Enough reads at once to keep a disk busy.
constexpr int MostThreads = 8;
/// What all threads of a rank may have read at once, if a chunk is not larger.
constexpr std::uint64_t ReadBytes = 256 * Mebibyte;
/// Rows that are closer than this in a file are read together.
constexpr std::int64_t CloseBytes = 16384;

/// The samples of all variables on the lattice vertices of a box.
struct Tile
{
  VertexBox Box;
  std::vector<Bytes> Samples;
};

/// Reads the boxes of an order, until the time is over.
class Sampler
{
public:
  Sampler(Communicator& ranks, FileSystem& files, const SourceIndex& index,
    const SampleLimits& limits, const Progress& progress)
    : Ranks(ranks)
    , Files(files)
    , Index(index)
    , Limits(limits)
    , Advance(progress)
  {
    this->Choice.Axes = index.Axes;
    this->Choice.Step = limits.Step;
    this->Choice.CacheBytes = ReadBytes / MostThreads;
    this->Choice.ReadsChunks = true;
    this->Choice.Vertices = limits.Vertices;
  }

  /// Collective.
  Status Read();
  /// Whether there is a sample (SampleLimits::CoarserThan).
  bool HasSample() const { return this->Order != nullptr; }
  /// What this rank has read.
  Message PackTiles() const;
  /// The volume of what all ranks have read.
  Result<SourceSample> MakeVolume(const std::vector<Message>& messages) const;

private:
  using Clock = std::chrono::steady_clock;

  Status Open();
  /// Whether the file has no sample of the kind that is wanted; the same on all ranks, which have opened it.
  bool IsLeftOut() const
  {
    return this->Limits.CoarserThan > 0 && this->Volume.Level >= this->Limits.CoarserThan;
  }
  double GetSeconds() const
  {
    return std::chrono::duration<double>(Clock::now() - this->Begin).count();
  }
  /// Reads this rank's share of the boxes.
  Status ReadBoxes(const std::vector<VertexBox>& boxes);
  /// Another source for a thread.
  Result<std::unique_ptr<BoxSource>> OpenAgain() const;
  Status ReadBox(BoxSource& source, Tile& tile) const;
  /// The parts of a box that are worth reading.
  std::vector<VertexBox> FindReads(const VertexBox& box) const;
  std::size_t FindSampleSize(std::size_t variable) const
  {
    return GetValueSize(this->Volume.Types[variable]);
  }

  std::vector<Tile> UnpackTiles(const std::vector<Message>& messages) const;
  /// The samples of a variable on a lattice.
  Bytes Assemble(
    const std::vector<Tile>& tiles, const Lattice& lattice, std::size_t variable) const;

  Communicator& Ranks;
  FileSystem& Files;
  const SourceIndex& Index;
  const SampleLimits& Limits;
  const Progress& Advance;
  VolumeChoice Choice;
  const Clock::time_point Begin = Clock::now();
  double Opened = 0;                               ///< when it was, in seconds
  double Seconds = 0;                              ///< of reading, of the slowest rank
  std::vector<std::unique_ptr<BoxSource>> Sources; ///< of each thread; the first is open
  SampledVolume Volume;
  std::unique_ptr<ReadingOrder> Order;
  Lattice Complete;        ///< of the tiles of all ranks
  std::vector<Tile> Tiles; ///< of this rank
};

Status Sampler::Open()
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto volume, OpenForeignVolume(this->Files, this->Index.Source, this->Choice));
  this->Volume = SampledVolume(volume, this->Choice.Step);
  const auto threads =
    static_cast<std::uint64_t>(ChooseReadingThreads(this->Index.Source, MostThreads));
  this->Order = ReadingOrder::Choose(
    *volume.Source, this->Limits.Vertices, ChooseReadingThreads(this->Index.Source, 1));
  const VertexBox& box = volume.Source->GetBox();
  const auto chunk = volume.Source->GetChunk();
  const std::uint64_t bytes = std::max<std::uint64_t>(1,
    volume.Source->GetReadBytes(VertexBox{ { 0, 0, 0 }, chunk.value_or(box.High) }.Intersect(box)));
  // A second reader of a stream would read it from the front.
  this->Sources.resize(chunk ? std::clamp<std::uint64_t>(ReadBytes / bytes, 1, threads) : 1);
  this->Sources.front() = std::move(volume.Source);
  return Status::Ok();
}

Result<std::unique_ptr<BoxSource>> Sampler::OpenAgain() const
{
  if (auto forked = this->Sources.front()->Fork())
  {
    return forked;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto volume, OpenForeignVolume(this->Files, this->Index.Source, this->Choice));
  return std::move(volume.Source);
}

Status Sampler::Read()
{
  ISOSURFACE_RETURN_IF_ERROR(
    this->Ranks.Agree(Attempt(this->Index.Source, [this] { return this->Open(); })));
  if (this->Ranks.Any(this->IsLeftOut()))
  {
    this->Order.reset();
    return Status::Ok();
  }
  this->Opened = this->GetSeconds();
  double secondsPerBox = 0;
  for (bool isFirst = true;; isFirst = false)
  {
    std::vector<VertexBox> boxes;
    const Status found = Attempt(this->Index.Source,
      [&]
      {
        boxes = this->Order->FindNext();
        return Status::Ok();
      });
    const double before = this->GetSeconds();
    const double expected = before + secondsPerBox * static_cast<double>(boxes.size());
    const bool isLast = boxes.empty() || (!isFirst && expected > this->Limits.Seconds);
    std::vector<std::uint64_t> ends = { isLast ? 1U : 0U };
    ISOSURFACE_RETURN_IF_ERROR(this->Ranks.ReduceAgreed(found, ends));
    if (ends[0] != 0)
    {
      constexpr double thousand = 1000;
      std::vector<std::uint64_t> passed = { static_cast<std::uint64_t>(
        thousand * (this->GetSeconds() - this->Opened)) };
      this->Ranks.ReduceMaximum(passed);
      this->Seconds = static_cast<double>(passed[0]) / thousand;
      return Status::Ok();
    }
    ISOSURFACE_RETURN_IF_ERROR(
      this->Ranks.Agree(Attempt(this->Index.Source, [&] { return this->ReadBoxes(boxes); })));
    this->Complete = this->Order->GetLattice();
    secondsPerBox = (this->GetSeconds() - before) / static_cast<double>(boxes.size());
  }
}

Status Sampler::ReadBoxes(const std::vector<VertexBox>& boxes)
{
  const auto ranks = static_cast<std::size_t>(this->Ranks.GetSize());
  const auto rank = static_cast<std::size_t>(this->Ranks.GetRank());
  const std::size_t first = this->Tiles.size();
  for (std::size_t box = rank; box < boxes.size(); box += ranks)
  {
    this->Tiles.push_back({ boxes[box], {} });
  }
  FirstFailure failure;
  const bool isDone = ParallelFor(
    this->Tiles.size() - first, static_cast<int>(this->Sources.size()),
    [&](std::size_t tile, int thread)
    {
      failure.Run(
        [&]() -> Status
        {
          std::unique_ptr<BoxSource>& source = this->Sources[static_cast<std::size_t>(thread)];
          if (!source)
          {
            ISOSURFACE_ASSIGN_OR_RETURN(source, this->OpenAgain());
          }
          return this->ReadBox(*source, this->Tiles[first + tile]);
        });
    },
    [this](double)
    {
      return !this->Advance ||
        this->Advance(std::min(1.0, this->GetSeconds() / this->Limits.Seconds));
    });
  return isDone ? failure.Get() : Status(StatusCode::Aborted, "The sample was aborted.");
}

std::vector<VertexBox> Sampler::FindReads(const VertexBox& box) const
{
  const Index3& step = this->Order->GetStep();
  const std::int64_t rowBytes =
    box.GetSize()[0] * static_cast<std::int64_t>(this->FindSampleSize(0));
  if (!this->Order->IsByRows() || step[1] * rowBytes < CloseBytes)
  {
    return { box };
  }
  std::vector<VertexBox> rows;
  VisitRows(Lattice{ box, step }.GetNumbers(),
    [&](const Index3& number, std::int64_t)
    {
      VertexBox row = box;
      row.Low[1] = number[1] * step[1];
      row.High[1] = row.Low[1] + 1;
      row.Low[2] = number[2] * step[2];
      row.High[2] = row.Low[2] + 1;
      rows.push_back(row);
    });
  return rows;
}

Status Sampler::ReadBox(BoxSource& source, Tile& tile) const
{
  const Index3& step = this->Order->GetStep();
  const VertexBox numbers = Lattice{ tile.Box, step }.GetNumbers();
  const auto count = static_cast<std::size_t>(numbers.GetNumberOfVertices());
  for (std::size_t variable = 0; variable < this->Volume.Types.size(); ++variable)
  {
    tile.Samples.emplace_back(count * this->FindSampleSize(variable));
  }
  for (const VertexBox& read : count > 0 ? this->FindReads(tile.Box) : std::vector<VertexBox>())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto slab, source.Read(read));
    if (!slab.Fits(this->Volume.Types, read))
    {
      return Status(StatusCode::Corrupt, this->Index.Source + ": was changed while it was read");
    }
    for (std::size_t variable = 0; variable < this->Volume.Types.size(); ++variable)
    {
      const SampleView& view = slab.Arrays[variable];
      const std::size_t size = this->FindSampleSize(variable);
      VisitRows(Lattice{ read, step }.GetNumbers(),
        [&](const Index3& number, std::int64_t row)
        {
          const Index3 vertex{ number[0] * step[0], number[1] * step[1], number[2] * step[2] };
          CopySamples(tile.Samples[variable].data() + numbers.FindIndex(number) * size, 1,
            view.AtBytes(vertex), view.Stride[0] * step[0], row, size);
        });
    }
  }
  return Status::Ok();
}

Message Sampler::PackTiles() const
{
  Message message;
  for (const Tile& tile : this->Tiles)
  {
    AppendBox(message, tile.Box);
    for (const Bytes& samples : tile.Samples)
    {
      message.insert(message.end(), samples.begin(), samples.end());
    }
  }
  return message;
}

std::vector<Tile> Sampler::UnpackTiles(const std::vector<Message>& messages) const
{
  std::vector<Tile> tiles;
  for (const Message& message : messages)
  {
    ByteReader reader(message);
    while (reader.GetRemaining() > 0)
    {
      Tile tile{ isosurface::ReadBox(reader), {} };
      const VertexBox numbers = Lattice{ tile.Box, this->Order->GetStep() }.GetNumbers();
      for (std::size_t variable = 0; variable < this->Volume.Types.size(); ++variable)
      {
        const std::size_t size =
          static_cast<std::size_t>(numbers.GetNumberOfVertices()) * this->FindSampleSize(variable);
        const std::uint8_t* samples = reader.ReadBytes(size);
        tile.Samples.emplace_back(samples, samples + size);
      }
      tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

Bytes Sampler::Assemble(
  const std::vector<Tile>& tiles, const Lattice& lattice, std::size_t variable) const
{
  const Index3& step = this->Order->GetStep();
  const VertexBox whole = lattice.GetNumbers();
  const std::size_t size = this->FindSampleSize(variable);
  Bytes samples(static_cast<std::size_t>(whole.GetNumberOfVertices()) * size);
  for (const Tile& tile : tiles)
  {
    const VertexBox numbers = Lattice{ tile.Box, step }.GetNumbers();
    const Lattice part{ tile.Box.Intersect(lattice.Box), lattice.Step };
    VisitRows(part.GetNumbers(),
      [&](const Index3& number, std::int64_t row)
      {
        Index3 ofTile;
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          ofTile[axis] = number[axis] * lattice.Step[axis] / step[axis];
        }
        CopySamples(samples.data() + whole.FindIndex(number) * size, 1,
          tile.Samples[variable].data() + numbers.FindIndex(ofTile) * size,
          lattice.Step[0] / step[0], row, size);
      });
  }
  return samples;
}

Result<SourceSample> Sampler::MakeVolume(const std::vector<Message>& messages) const
{
  const std::vector<Tile> tiles = this->UnpackTiles(messages);
  std::vector<Bytes> samples;
  for (std::size_t variable = 0; variable < this->Volume.Types.size(); ++variable)
  {
    samples.push_back(this->Assemble(tiles, this->Complete, variable));
  }
  auto sample = MakeSourceSample(
    this->Files, this->Index, this->Volume, this->Complete, samples, this->Order->GetPart());
  if (sample.IsOk())
  {
    sample->WholeStep = this->Order->GetWholeStep();
    sample->Seconds = this->Seconds;
    const Index3& step = this->Complete.Step;
    sample->IsUnfinished = step[1] > sample->WholeStep[1] || step[2] > sample->WholeStep[2];
  }
  return sample;
}

} // namespace

Result<SourceSample> ReadSourceSample(Communicator& ranks, FileSystem& files,
  const SourceIndex& index, const SampleLimits& limits, const Progress& progress)
{
  const auto read = [&]() -> Result<SourceSample>
  {
    Sampler sampler(ranks, files, index, limits, progress);
    ISOSURFACE_RETURN_IF_ERROR(sampler.Read());
    if (!sampler.HasSample())
    {
      return SourceSample();
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto messages,
      GatherFromAll(ranks, index.Source,
        [&](Message& tiles)
        {
          tiles = sampler.PackTiles();
          return Status::Ok();
        }));
    auto sample = Attempt(index.Source, [&] { return sampler.MakeVolume(messages); });
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(sample.GetStatus()));
    return sample;
  };
  return RunCollective(index.Source, read);
}

} // namespace isosurface
