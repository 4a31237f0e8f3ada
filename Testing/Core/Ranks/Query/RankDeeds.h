// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_RankDeeds_h
#define isosurface_Testing_RankDeeds_h

#include "Fixtures/ActiveBlocks.h"
#include "Fixtures/LongTests.h"
#include "Fixtures/TestBlockSource.h"
#include "Fixtures/VolumeOnDisk.h"

#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Ranks/Islands/IslandChoice.h"
#include "Ranks/Query/FieldRefinement.h"
#include "Ranks/Query/StoredField.h"
#include "Ranks/Redistribution/SurfaceExchange.h"
#include "Storage/Spectrum/GridSpectrum.h"
#include "Storage/Store/StoredBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

/// What several ranks do together with a volume that is on a disk. Each rank may see the disk in its
/// own way.
struct RankDeeds
{
  /// Each of so many fails with all its allocations or operations: a minute a number with sanitizers.
  static std::vector<int> GetNumbersOfRanks()
  {
    return LongTests ? std::vector<int>{ 2, 3, 4, 7 } : std::vector<int>{ 3 };
  }

  static constexpr double Isovalue = 30;
  inline static const Index3 Size = { 50, 36, 34 };
  inline static const std::string SurfacePath = "/data/surface.eix";

  /// Writes another volume in place of the one on the disk.
  static Status WriteVolume(Communicator& ranks, FileSystem& disk)
  {
    const VertexBox box = SlabOfEach(ranks.GetRank(), ranks.GetSize(), Size);
    const PieceOfVolume<std::uint8_t> part(GetOther(), box);
    // Balanced shares what the others share, and profiles of blocks as well.
    BlockedVolumeSettings settings = MakeSettings(16, 3, DistributionMethod::Balanced);
    settings.Threads = 1;
    return BlockedVolumeWriter(ranks, disk)
      .Write(VolumePath, MakeGeometry(Size), { { "density", ValueType::UInt8 } },
        VolumePiece{ box, { part.View } }, settings)
      .GetStatus();
  }

  static Status WriteEdgeIndexFile(Communicator& ranks, FileSystem& disk)
  {
    TestBlockSource<std::uint8_t> whole(GetSamples(), 16);
    TestBlockSource<std::uint8_t> source(GetSamples(), 16);
    source.Blocks.clear();
    std::vector<std::int64_t> numbers;
    for (const std::int64_t block : whole.Blocks)
    {
      if (block % ranks.GetSize() == ranks.GetRank())
      {
        source.Blocks.push_back(block);
        numbers.push_back(block);
      }
    }
    EdgeIndexHeader header;
    header.Geometry = GetSamples().Geometry;
    header.Type = ValueType::UInt8;
    header.Isovalues = { Isovalue };
    return EdgeIndexWriteJob(ranks, disk, SurfacePath, header, source, numbers, { 1, 200 })
      .Run()
      .GetStatus();
  }

  static Status ExtractWithinBudget(Communicator& ranks, FileSystem& disk)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto volume, Open(ranks, disk));
    const SurfaceQuery query = MakeQuery(ranks);
    ContourRequest request;
    request.Isovalues = query.Isovalues;
    StoredField field;
    FieldRefinement surfaces([] { return std::uint64_t{ 0 }; });
    RefinementRequest wanted;
    wanted.IsProgressive = true;
    wanted.Change = 1;
    field.Ask({ volume, query, request, 1, {} }, { 100, 1000000 });
    ISOSURFACE_ASSIGN_OR_RETURN(const auto choice, surfaces.Begin(ranks, field, wanted));
    ExtractionOutcome outcome;
    return field.Extract(ranks, choice.Level, outcome);
  }

  static Status Distribute(Communicator& ranks, FileSystem& disk)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto volume, Open(ranks, disk));
    const SurfaceQuery query = MakeQuery(ranks);
    QueryStatistics statistics;
    auto active =
      FindActiveBlocks(*volume, { { 0, 0, query.Isovalues }, query.Rank, query.Ranks }, statistics);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(active.GetStatus()));
    StoredBlockSource source(*volume, 0, 0, 0, std::move(*active));
    EdgeIndexHeader header;
    header.Geometry = volume->GetHeader().Grid;
    header.Type = ValueType::UInt8;
    header.Isovalues = query.Isovalues;
    ContourRequest request;
    request.Isovalues = query.Isovalues;
    SurfaceExchange::Settings settings;
    settings.Threads = 1;
    settings.RoundBytes = 500;
    return SurfaceExchange(ranks, header, request, settings).Run(source).GetStatus();
  }

  /// Of a surface whose blocks are dealt one by one.
  static Status FindIslands(Communicator& ranks, FileSystem&)
  {
    TestBlockSource<std::uint8_t> source(GetSamples(), 16);
    const auto blocks = std::exchange(source.Blocks, {});
    for (const std::int64_t block : blocks)
    {
      if (block % ranks.GetSize() == ranks.GetRank())
      {
        source.Blocks.push_back(block);
      }
    }
    ContourRequest request;
    request.Isovalues = { Isovalue };
    request.GlobalIds = true;
    auto surface = ExtractSurface(GetSamples().Geometry, source, request, 1);
    ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(surface.GetStatus()));
    IslandGrids grids;
    grids.Bounds = TriangleBounds::Of(GetSamples().Geometry, nullptr);
    grids.Shared.emplace_back(GetSamples().Geometry, request);
    grids.Shared.back().AddFacesOfBlocks(16);
    IslandRequest wanted;
    wanted.MaximumIslands = 3;
    wanted.Place = { 20, 20, 20 };
    wanted.Ids = true;
    ChosenIslands chosen;
    return ChooseIslands(ranks, wanted, grids, 1, *surface, chosen);
  }

  /// Of a volume in memory, in slabs.
  static Status CountSpectrum(Communicator& ranks, FileSystem&)
  {
    const VertexBox box = SlabOfEach(ranks.GetRank(), ranks.GetSize(), Size);
    const PieceOfVolume<std::uint8_t> part(GetOther(), box);
    GridSpectrum spectrum(MakeGeometry(Size), ValueType::UInt8, { part.View }, 1);
    ISOSURFACE_RETURN_IF_ERROR(spectrum.FindRanges(ranks));
    const auto bins = SpectrumBins::Choose(ValueType::UInt8, spectrum.GetFiniteRange());
    return spectrum.Count(ranks, bins).GetStatus();
  }

  /// Of the volume on the disk, and of the one in its place.
  static const SampleVolume<std::uint8_t>& GetSamples()
  {
    static const auto samples = MakeVolume<std::uint8_t>(Size, 1);
    return samples;
  }
  static const SampleVolume<std::uint8_t>& GetOther()
  {
    static const auto samples = MakeVolume<std::uint8_t>(Size, 2);
    return samples;
  }

private:
  static SurfaceQuery MakeQuery(const Communicator& ranks)
  {
    return { { 0, 0, { Isovalue } }, ranks.GetRank(), ranks.GetSize() };
  }

  /// As the reader does.
  static Result<std::shared_ptr<BlockedVolume>> Open(Communicator& ranks, FileSystem& disk)
  {
    auto volume =
      BlockedVolume::Open(VolumePath, disk, std::make_shared<BlockCache>(std::uint64_t{ 1 } << 24));
    const std::uint64_t fingerprint = volume.IsOk() ? (*volume)->GetFingerprint() : 0;
    ISOSURFACE_RETURN_IF_ERROR(
      ranks.Agree(volume.GetStatus(), { { fingerprint, VolumePath + " differs" } }));
    return volume;
  }
};

} // namespace isosurface

#endif
