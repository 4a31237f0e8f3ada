// SPDX-License-Identifier: BSD-3-Clause
/**
 * What compression costs and gains, on volumes that the caller names or on a generated one.
 *
 * Without --surfaces: each codec and some of its levels on the volume's blocks in memory, with one
 * thread. Told are the bytes a voxel that records take in the file (ghost layers, headers and
 * padding included), their ratio to uncompressed ones, and the MB/s of samples encoded and decoded.
 * Decoding ends with samples that can be contoured, which takes time without compression, too.
 *
 * With --surfaces: whole volumes on disk. Told are the seconds to write and the bytes; then, for
 * the isovalues with the maximum of triangles, a quarter and a sixteenth of it, the seconds from
 * opening the file to the surface, with the files in the page cache and without. The fastest of
 * all repeated runs counts.
 */
#include "BenchmarkVolume.h"
#include "VolumeQuery.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkUnsignedShortArray.h"
#include "vtkXMLImageDataReader.h"

#include "ImageSamples.h"
#include "Storage/Record/RecordCodec.h"
#include "Storage/Store/BlockedVolume.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace
{
using namespace isosurface;

struct Options
{
  int BlockSize = 32;
  int Side = 256;
  int Threads = 1;
  int Repeats = 5;
  std::uint64_t MaximumBytes = std::uint64_t{ 1 } << 26;
  bool Surfaces = false;
  std::vector<std::string> Inputs;
  std::string Folder = ".";
};

constexpr std::array<SegmentCodec, 3> Codecs = { SegmentCodec::None, SegmentCodec::Lz4,
  SegmentCodec::Zstd };

/// The uncompressed records of some blocks of a volume.
struct Records
{
  Records(const SampleView& view, const BlockGrid& grid, std::uint64_t maximumBytes)
    : Grid(grid)
    , Type(view.Type)
  {
    // Blocks spread evenly over a volume that is too large to take all.
    const std::int64_t blocks = grid.GetNumberOfBlocks();
    const std::uint64_t all = static_cast<std::uint64_t>(grid.GetDimensions()[0] *
                                grid.GetDimensions()[1] * grid.GetDimensions()[2]) *
      GetValueSize(view.Type);
    const auto step = static_cast<std::int64_t>(1 + all / maximumBytes);
    for (std::int64_t block = 0; block < blocks; block += step)
    {
      this->Add(view, block);
    }
  }

  void Add(const SampleView& view, std::int64_t block)
  {
    const std::size_t size = GetValueSize(this->Type);
    BlockRecordLayout layout(this->Grid, block, { this->Type });
    Buffer<std::uint8_t> record(static_cast<std::size_t>(BlockRecord::AlignUp(layout.Size)));
    const int levels = this->Grid.GetNumberOfLevels();
    for (int level = 0; level < levels; ++level)
    {
      const BlockSegment segment(this->Grid, block, level);
      std::uint8_t* to = record.GetData() + BlockRecord::SegmentHeaderSize +
        layout.Offsets[static_cast<std::size_t>(levels - 1 - level)];
      segment.VisitRows(segment.GetBox(),
        [&](const SegmentRow& row)
        {
          const std::ptrdiff_t offset = (row.I << level) * view.Stride[0] +
            (row.J << level) * view.Stride[1] + (row.K << level) * view.Stride[2];
          CopySamples(to + row.Offset * size, 1,
            static_cast<const std::uint8_t*>(view.First) +
              offset * static_cast<std::ptrdiff_t>(size),
            view.Stride[0] * (row.Step << level), row.Count, size);
        });
    }
    const Index3 own = this->Grid.GetVertices(block).GetSize();
    this->Voxels += static_cast<double>(std::max<std::int64_t>(1, own[0] - 1) *
      std::max<std::int64_t>(1, own[1] - 1) * std::max<std::int64_t>(1, own[2] - 1));
    this->SampleBytes += static_cast<double>(layout.Samples * size);
    this->RecordBytes += static_cast<double>(record.GetSize());
    this->Blocks.push_back(block);
    this->Layouts.push_back(std::move(layout));
    this->Bytes.push_back(std::move(record));
  }

  BlockGrid Grid;
  ValueType Type;
  double Voxels = 0;
  double SampleBytes = 0;
  double RecordBytes = 0; ///< uncompressed
  std::vector<std::int64_t> Blocks;
  std::vector<BlockRecordLayout> Layouts;
  std::vector<Buffer<std::uint8_t>> Bytes;
};

void DecodeAll(const Records& records, const std::vector<BlockRecordLayout>& layouts,
  const std::vector<Buffer<std::uint8_t>>& bytes)
{
  for (std::size_t index = 0; index < records.Blocks.size(); ++index)
  {
    std::vector<const std::uint8_t*> segments;
    for (const std::uint64_t offset : layouts[index].Offsets)
    {
      segments.push_back(bytes[index].GetData() + offset);
    }
    const auto decoded = DecodeLevel(
      records.Grid, records.Blocks[index], 0, 0, records.Type, segments, layouts[index].Lengths);
    if (!decoded.IsOk())
    {
      std::fprintf(stderr, "%s\n", decoded.GetStatus().GetMessage().c_str());
      std::exit(EXIT_FAILURE);
    }
  }
}

void MeasureCodec(const Records& records, const BlockCompression& compression, int repeats)
{
  std::vector<BlockRecordLayout> layouts = records.Layouts;
  std::vector<Buffer<std::uint8_t>> bytes;
  for (const Buffer<std::uint8_t>& record : records.Bytes)
  {
    bytes.emplace_back(record.GetSize());
    std::memcpy(bytes.back().GetData(), record.GetData(), record.GetSize());
  }
  double stored = 0;
  const double start = GetSeconds();
  for (std::size_t index = 0; index < bytes.size(); ++index)
  {
    EncodeRecord(compression, records.Grid, records.Blocks[index], { records.Type }, layouts[index],
      bytes[index]);
    stored += static_cast<double>(BlockRecord::AlignUp(layouts[index].Size));
  }
  const double encoding = GetSeconds() - start;
  double decoding = 1e30;
  for (int repeat = 0; repeat < repeats; ++repeat)
  {
    const double begin = GetSeconds();
    DecodeAll(records, layouts, bytes);
    decoding = std::min(decoding, GetSeconds() - begin);
  }
  std::printf("  %-4s %2d  %6.3f B/voxel  ratio %6.2f  encode %6.0f MB/s  decode %6.0f MB/s\n",
    GetCodecName(compression.Codec), compression.GetEffectiveLevel(), stored / records.Voxels,
    records.RecordBytes / stored, records.SampleBytes / encoding / 1e6,
    records.SampleBytes / decoding / 1e6);
  std::fflush(stdout);
}

void MeasureCodecs(const SampleView& view, const GridGeometry& grid, const Options& options)
{
  const Records records(
    view, BlockGrid(grid.GetDimensions(), options.BlockSize), options.MaximumBytes);
  MeasureCodec(records, {}, options.Repeats);
  const std::pair<SegmentCodec, int> ways[] = { { SegmentCodec::Lz4, 1 }, { SegmentCodec::Lz4, 9 },
    { SegmentCodec::Zstd, 1 }, { SegmentCodec::Zstd, 3 }, { SegmentCodec::Zstd, 9 } };
  for (const auto& way : ways)
  {
    MeasureCodec(records, { way.first, way.second }, options.Repeats);
  }
}

/// The isovalues with the most triangles, a quarter and a sixteenth of them (the next such above).
std::vector<double> ChooseIsovalues(const WorkloadSpectrum& spectrum)
{
  const auto& triangles = spectrum.Triangles;
  const auto most = std::max_element(triangles.begin(), triangles.end());
  std::vector<double> isovalues;
  for (const std::uint64_t divisor : { 1, 4, 16 })
  {
    auto bin = most;
    while (bin + 1 != triangles.end() && *bin > *most / divisor)
    {
      ++bin;
    }
    isovalues.push_back(spectrum.Bins.GetEdge(static_cast<std::size_t>(bin - triangles.begin())));
  }
  return isovalues;
}

std::string WriteCompressed(const SampleView& view, const GridGeometry& grid,
  const BlockCompression& compression, const Options& options)
{
  const std::string path =
    options.Folder + "/compression-benchmark-" + GetCodecName(compression.Codec) + ".bvol";
  BlockedVolumeSettings settings;
  settings.BlockSize = options.BlockSize;
  settings.Threads = options.Threads;
  settings.Compression = compression;
  SerialCommunicator alone;
  double seconds = 1e30;
  std::uint64_t bytes = 0;
  for (int repeat = 0; repeat < options.Repeats; ++repeat)
  {
    const double start = GetSeconds();
    const auto written = BlockedVolumeWriter(alone).Write(
      path, grid, { { "samples", view.Type } }, { view.Box, { view } }, settings);
    if (!written.IsOk())
    {
      std::fprintf(stderr, "%s\n", written.GetStatus().GetMessage().c_str());
      std::exit(EXIT_FAILURE);
    }
    seconds = std::min(seconds, GetSeconds() - start);
    bytes = written->Bytes;
  }
  std::printf("  %-4s written in %.3f s, %.1f MB\n", GetCodecName(compression.Codec), seconds,
    static_cast<double>(bytes) / 1e6);
  return path;
}

void MeasureSurfaces(const SampleView& view, const GridGeometry& grid, const Options& options)
{
  std::vector<std::string> paths;
  for (const SegmentCodec codec : Codecs)
  {
    paths.push_back(WriteCompressed(view, grid, { codec, 0 }, options));
  }
  auto volume = BlockedVolume::Open(paths[0]);
  for (const double isovalue : ChooseIsovalues(**(*volume)->GetSpectrum(0, 0)))
  {
    // The codecs take turns, so that all of them meet the machine's better and worse moments.
    VolumeQuery warm[Codecs.size()];
    VolumeQuery cold[Codecs.size()];
    const auto keepFaster = [](VolumeQuery& best, const VolumeQuery& query)
    { best = best.Triangles == 0 || query.Seconds < best.Seconds ? query : best; };
    for (int repeat = 0; repeat < options.Repeats; ++repeat)
    {
      for (std::size_t way = 0; way < Codecs.size(); ++way)
      {
        keepFaster(cold[way], MeasureQuery(paths[way], isovalue, options.Threads, 1, true));
        keepFaster(warm[way], MeasureQuery(paths[way], isovalue, options.Threads, 1, false));
      }
    }
    std::printf("  isovalue %10.4g: %llu blocks, %zu triangles\n", isovalue,
      static_cast<unsigned long long>(warm[0].Statistics.BlocksRead), warm[0].Triangles);
    for (std::size_t way = 0; way < Codecs.size(); ++way)
    {
      std::printf("    %-4s %8.2f MB read, warm %.4f s, cold %.4f s\n", GetCodecName(Codecs[way]),
        static_cast<double>(warm[way].Statistics.BytesRead) / 1e6, warm[way].Seconds,
        cold[way].Seconds);
    }
    std::fflush(stdout);
  }
  for (const std::string& path : paths)
  {
    static_cast<void>(GetLocalFileSystem().RemoveAll(path));
    static_cast<void>(GetLocalFileSystem().RemoveAll(path + ".stores"));
  }
}

void Measure(const std::string& name, vtkImageData* image, const Options& options)
{
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  scalars = scalars ? scalars : image->GetPointData()->GetArray(0);
  if (!scalars)
  {
    std::fprintf(stderr, "%s: no point array\n", name.c_str());
    return;
  }
  const GridGeometry grid = MakeGridGeometry(image, image->GetExtent());
  const auto samples = MakeImageSamples(grid, image, scalars);
  if (!samples.IsOk())
  {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), samples.GetStatus().GetMessage().c_str());
    return;
  }
  const SampleView& view = samples->Components.front();
  const Index3 size = grid.GetDimensions();
  std::printf("%s: %lld x %lld x %lld %s, blocks of %d\n", name.c_str(),
    static_cast<long long>(size[0]), static_cast<long long>(size[1]),
    static_cast<long long>(size[2]), GetValueTypeName(view.Type), options.BlockSize);
  if (options.Surfaces)
  {
    MeasureSurfaces(view, grid, options);
  }
  else
  {
    MeasureCodecs(view, grid, options);
  }
}

} // namespace

int main(int argc, char** argv)
{
  Options options;
  CLI::App application("What compression costs and gains");
  application.add_option("--volumes", options.Inputs, ".vti files; else a generated volume");
  application.add_option("--side", options.Side, "samples along the generated volume's side");
  application.add_option("--block-size", options.BlockSize, "16, 32 or 64");
  application.add_option("--folder", options.Folder, "where to write blocked volumes");
  application.add_option("--threads", options.Threads, "threads to write and extract with");
  application.add_option("--repeats", options.Repeats, "runs of which the best or median is taken");
  application.add_option("--largest", options.MaximumBytes, "maximum bytes of samples to encode");
  application.add_flag("--surfaces", options.Surfaces, "whole volumes and surfaces, from disk");
  CLI11_PARSE(application, argc, argv);

  for (const std::string& input : options.Inputs)
  {
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(input.c_str());
    reader->Update();
    Measure(std::filesystem::path(input).stem(), reader->GetOutput(), options);
  }
  if (options.Inputs.empty())
  {
    std::vector<std::uint16_t> generated = MakeBenchmarkVolume(options.Side, 2);
    vtkNew<vtkImageData> image;
    image->SetDimensions(options.Side, options.Side, options.Side);
    vtkNew<vtkUnsignedShortArray> scalars;
    scalars->SetName("waves");
    scalars->SetArray(generated.data(), static_cast<vtkIdType>(generated.size()), 1);
    image->GetPointData()->SetScalars(scalars);
    Measure("generated", image, options);
  }
  return EXIT_SUCCESS;
}
