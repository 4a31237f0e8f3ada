// SPDX-License-Identifier: BSD-3-Clause
// Writes the seeds of the fuzz targets into a folder: WriteFuzzCorpus <folder>. They are files of
// small volumes and trees, as Core writes them, behind the bytes that each target wants first.
// The corpus also holds seeds that fuzzing found, which this does not write.
#include "Fixtures/CodedVolumes.h"
#include "Fixtures/DicomBytes.h"
#include "Fixtures/MemoryDisk.h"

#include "Fixtures/EdgeIndexFileWriter.h"
#include "Ground/Base/Coding.h"
#include "Storage/Index/ExternalIntervalTreeBuilder.h"
#include "Storage/Store/BlockStore.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

using Bytes = std::vector<std::uint8_t>;

const std::string Path = "/data/volume.bvol";
const std::string StoreFolder = HidePath(Path + ".stores") + "/000001/store-00000";

class Corpus
{
public:
  explicit Corpus(std::string folder)
    : Folder(std::move(folder))
  {
  }
  bool IsOk() const { return this->Ok; }
  void Fail() { this->Ok = false; }

  void Add(const std::string& target, const std::string& name, const Bytes& bytes)
  {
    const std::filesystem::path folder = std::filesystem::path(this->Folder) / target;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    std::ofstream file(folder / name, std::ios::binary);
    file.write(
      reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    this->Ok = this->Ok && file.good();
  }

private:
  std::string Folder;
  bool Ok = true;
};

template <typename T>
void Append(Bytes& bytes, T value)
{
  bytes.resize(bytes.size() + sizeof(T));
  StoreLittleEndian(bytes.data() + bytes.size() - sizeof(T), value);
}

void Append(Bytes& bytes, const Bytes& others)
{
  bytes.insert(bytes.end(), others.begin(), others.end());
}

/// The header of a volume on a rectilinear grid, of 5 x 2 x 1 vertices.
void AddRectilinearHeader(Corpus& corpus)
{
  BlockedVolumeHeader header;
  header.Grid.Extent = { -2, 2, 0, 1, 7, 7 };
  header.Grid.Unit = LengthUnit::Millimeter;
  header.Lines = GridLines{ { { { -1.5, 0, 1e-3, 2, 1e6 }, { 0.25, 0.75 }, { 3 } } } };
  header.FrameGrid();
  header.BlockSize = 16;
  header.Arrays = { { "density", ValueType::UInt8 } };
  TimeStepDescription step;
  step.Folder = "000001";
  step.Ranges = { {} };
  step.Stores = { { 1, 4096, 7 } };
  header.TimeSteps = { step };
  const std::string text = header.Format();
  corpus.Add("BlockedVolumeHeader", "rectilinear", Bytes(text.begin(), text.end()));
  // Each block in two of three stores.
  header.Lines.reset();
  header.NumberOfStores = 3;
  header.NumberOfReplicas = 2;
  header.TimeSteps[0].Stores = { { 1, 4096, 7 }, { 0, 0, 8 }, { 0, 0, 9 } };
  const std::string replicated = header.Format();
  corpus.Add("BlockedVolumeHeader", "replicas", Bytes(replicated.begin(), replicated.end()));
}

/// The header of a volume in place.
void AddVolumeInPlace(Corpus& corpus)
{
  const Index3 size = { 40, 20, 17 };
  const SampleVolume<std::int16_t> volume(size, [](auto i, auto j, auto k) { return i + j * k; });
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, size };
  piece.Arrays = { volume.GetView() };
  SourceRecord record;
  record.Path = "../run.h5";
  record.AbsolutePath = "/data/run.h5";
  record.Within = "/entry/data";
  record.Axes = "tzyx";
  record.Arrays = { "data" };
  record.Chunk = { 33, 20, 11 };
  record.State = { 1, 29000, -1 };
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 1;
  settings.Threads = 1;
  settings.InPlace = record;
  MemoryDisk disk;
  SerialCommunicator alone;
  BlockedVolumeWriter writer(alone, disk);
  if (!writer.Write(Path, grid, { { "density", ValueType::Int16 } }, piece, settings).IsOk())
  {
    corpus.Fail();
    return;
  }
  corpus.Add("BlockedVolumeHeader", "in-place", disk.GetFile(Path));
}

/// One volume's files, for the four targets that read them: an array of one component or more, in
/// one time step or more.
template <typename T>
void AddVolume(Corpus& corpus, const std::string& name, const Index3& size, std::uint32_t stores,
  const BlockCompression& compression = {}, int components = 1, int steps = 1)
{
  const SampleVolume<T> volume(size,
    [](auto i, auto j, auto k) {
      return 60 + 40 * std::sin(0.4 * static_cast<double>(i) + 0.3 * static_cast<double>(j * k));
    });
  GridGeometry grid;
  grid.Extent = { 0, size[0] - 1, 0, size[1] - 1, 0, size[2] - 1 };
  VolumePiece piece;
  piece.Box = { { 0, 0, 0 }, size };
  piece.Arrays.assign(static_cast<std::size_t>(components), volume.GetView());
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = stores;
  settings.Append = true;
  settings.Compression = compression;
  settings.Threads = 1;
  MemoryDisk disk;
  SerialCommunicator alone;
  BlockedVolumeWriter writer(alone, disk);
  const ValueType type = ValueTypeOf<T>::Value;
  for (int step = 0; step < steps; ++step)
  {
    settings.Time = step + 0.25;
    if (!writer.Write(Path, grid, { { "density", type, components } }, piece, settings).IsOk())
    {
      corpus.Fail();
      return;
    }
  }
  corpus.Add("BlockedVolumeHeader", name, disk.GetFile(Path));
  // The spectra of components are like those of arrays, and long.
  if (components == 1)
  {
    corpus.Add("VolumeSpectra", name, disk.GetFile(HidePath(Path + ".stores") + "/000001/spectra"));
  }
  const Bytes& directory = disk.GetFile(BlockStore::GetDirectoryPath(StoreFolder));
  const ArrayVariables variables({ { "density", type, components } });
  const Bytes& tree = disk.GetFile(BlockStore::GetTreePath(StoreFolder, variables, 0));
  const Bytes& records = disk.GetFile(StoreRecords::GetPath(StoreFolder));

  Bytes input = { 1 };
  Append(input, std::uint32_t{ 64 });
  Append(input, static_cast<std::uint32_t>(records.size() / 4096));
  Append(input, directory);
  corpus.Add("BlockDirectory", name, input);
  if (stores == 1)
  {
    const bool hasOverviews = BlockGrid(size, settings.BlockSize).GetNumberOfBlocks() > 1;
    input = { static_cast<std::uint8_t>(1 + (components > 1 ? 8 : 0) + (hasOverviews ? 16 : 0)),
      static_cast<std::uint8_t>(size[0] - 1), static_cast<std::uint8_t>(size[1] - 1),
      static_cast<std::uint8_t>(size[2] - 1), static_cast<std::uint8_t>(type),
      static_cast<std::uint8_t>(components > 1 ? components - 2 : 0),
      static_cast<std::uint8_t>(tree.size() / 4096) };
    Append(input, 60.0);
    Append(input, directory);
    Append(input, tree);
    Append(input, records);
    corpus.Add("BlockStore", name, input);
  }
}

/// The file of one tree over make(0), ..., make(count - 1).
template <typename Function>
void AddTree(
  Corpus& corpus, const std::string& name, std::uint8_t flags, std::uint64_t count, Function&& make)
{
  MemoryDisk disk;
  ExternalIntervalTreeBuilder builder(
    disk, "/data/tree", ExternalIntervalTreeBuilder::MinimumMemoryLimit);
  Status status;
  for (std::uint64_t index = 0; index < count && status.IsOk(); ++index)
  {
    KeyInterval interval = make(index);
    interval.Payload = static_cast<std::uint32_t>(index);
    status = builder.Add(interval);
  }
  if (!status.IsOk() || !builder.Finish().IsOk())
  {
    corpus.Fail();
    return;
  }
  Bytes input = { flags };
  Append(input, make(count / 2).Minimum);
  Append(input, make(count / 3).Maximum);
  Append(input, disk.GetFile("/data/tree"));
  corpus.Add("ExternalIntervalTree", name, input);
}

void AddTrees(Corpus& corpus)
{
  const auto nested = [](std::uint64_t i) { return KeyInterval{ i, 1000 - i, 0 }; };
  const auto stairs = [](std::uint64_t i) { return KeyInterval{ i, i + 60, 0 }; };
  const auto points = [](std::uint64_t i) { return KeyInterval{ 3 * i, 3 * i, 0 }; };
  // The golden ratio spreads them over all keys.
  const auto spread = [](std::uint64_t i)
  {
    const std::uint64_t a = i * 0x9e3779b97f4a7c15;
    const std::uint64_t b = (i + 7) * (i + 3) * 0x9e3779b97f4a7c15;
    return KeyInterval{ std::min(a, b), std::max(a, b), 0 };
  };
  // Up to two hundred intervals are one leaf, more are a tree of nodes.
  AddTree(corpus, "unsealed-leaf", 0, 3, nested);
  AddTree(corpus, "leaf", 1, 12, spread);
  AddTree(corpus, "nested", 1, 260, nested);
  AddTree(corpus, "stairs", 3, 260, stairs);
  AddTree(corpus, "points", 1, 260, points);
  AddTree(corpus, "spread", 1, 420, spread);
}

/// A small edge-index file.
template <typename T>
void AddEdgeIndexFile(
  Corpus& corpus, const std::string& name, std::uint8_t flags, EdgeIndexHeader header)
{
  SampleVolume<T> volume({ 20, 9, 7 });
  for (std::size_t n = 0; n < volume.Samples.size(); ++n)
  {
    const auto i = static_cast<double>(n % 20);
    const auto j = static_cast<double>(n / 20 % 9);
    const auto k = static_cast<double>(n / 180);
    volume.Samples[n] = static_cast<T>(60 + 40 * std::sin(0.4 * i + 0.3 * j - 0.5 * k));
  }
  header.Geometry = volume.Geometry;
  header.Type = ValueTypeOf<T>::Value;
  header.Array = "density";
  header.Isovalues.push_back(60.5);
  MemoryDisk disk;
  TestBlockSource<T> source(volume, 16);
  if (header.LacksIslands)
  {
    LeaveOutIslands(header, source, 2);
  }
  if (!WriteEdgeIndexFile(disk, "/data/surface.eix", header, source, 1).IsOk())
  {
    corpus.Fail();
    return;
  }
  Bytes input = { flags };
  Append(input, disk.GetFile("/data/surface.eix"));
  corpus.Add("EdgeIndexFile", name, input);
  const auto stream = EncodeSurface(header, source, 1);
  if (!stream.IsOk())
  {
    corpus.Fail();
    return;
  }
  input = { 1 };
  Append(input, *stream);
  corpus.Add("EdgeIndexDecoder", name, input);
}

void AddEdgeIndexFiles(Corpus& corpus)
{
  EdgeIndexHeader header;
  AddEdgeIndexFile<std::uint8_t>(corpus, "lossless-uint8", 1, header);
  header.Geometry.Unit = LengthUnit::Foot;
  AddEdgeIndexFile<std::uint8_t>(corpus, "unit", 1, header);
  header.Geometry.Unit = LengthUnit::Unknown;
  AddEdgeIndexFile<double>(corpus, "lossless-float64", 1, header);
  header.Settings.Mode = EdgeIndexMode::Bounded;
  header.Settings.Profile = EdgeIndexProfile::Working;
  AddEdgeIndexFile<float>(corpus, "working-bounded", 1, header);
  header.Settings.Mode = EdgeIndexMode::Lossless;
  AddEdgeIndexFile<std::int16_t>(corpus, "working-int16", 1, header);
  header.Attributes = { { "Normals", ValueType::Float32, 3, 0, true } };
  AddEdgeIndexFile<std::uint8_t>(corpus, "normals", 1, header);
  header.Attributes[0].MaximumError = 0.01;
  AddEdgeIndexFile<std::uint8_t>(corpus, "normals-bounded", 1, header);
  header.Attributes.clear();
  header.PreviewLevel = 1;
  AddEdgeIndexFile<std::int16_t>(corpus, "lossless-preview", 3, header);
  header.Settings.Mode = EdgeIndexMode::Bounded;
  AddEdgeIndexFile<float>(corpus, "bounded-preview", 5, header);
  header.Settings.Profile = EdgeIndexProfile::Small;
  header.Isovalues = { 80 };
  AddEdgeIndexFile<float>(corpus, "bounded-two-isovalues", 1, header);
  header.Settings.Mode = EdgeIndexMode::Quantized;
  AddEdgeIndexFile<std::uint16_t>(corpus, "quantized", 1, header);
  header.Settings.Mode = EdgeIndexMode::Smallest;
  AddEdgeIndexFile<std::uint16_t>(corpus, "smallest-rounded", 1, header);
  header.RoundsFaces = false;
  AddEdgeIndexFile<std::uint16_t>(corpus, "smallest", 1, header);
  header.RoundsFaces = true;
  header.LacksIslands = true;
  AddEdgeIndexFile<std::uint16_t>(corpus, "islands", 3, header);
  header.Settings.Mode = EdgeIndexMode::Lossless;
  header.ClosedSides = GridSides::All();
  AddEdgeIndexFile<std::uint8_t>(corpus, "islands-closed", 5, header);
}

/// An image of 3 x 2 samples behind other elements.
void AddDicomImage(Corpus& corpus, const std::string& name, const std::string& syntax,
  const DicomBytes& others = {}, const std::vector<std::string>& fragments = {})
{
  const bool isDeflated = syntax == "1.2.840.10008.1.2.1.99";
  DicomBytes bytes;
  if (!isDeflated)
  {
    bytes.PutStart(syntax);
  }
  bytes.PutRaw(std::string(others.Get().begin(), others.Get().end()));
  bytes.IsImplicit = syntax == "1.2.840.10008.1.2";
  bytes.IsBigEndian = syntax == "1.2.840.10008.1.2.2";
  bytes.PutImage(3, 2);
  if (!fragments.empty())
  {
    bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0);
    for (const std::string& fragment : fragments)
    {
      bytes.PutItem(static_cast<std::uint32_t>(fragment.size())).PutRaw(fragment);
    }
    bytes.PutEnd(DicomBytes::SequenceEnd);
  }
  else
  {
    bytes.PutBytes(0x7fe00010, "OW", Bytes(12, 7));
  }
  Bytes file = { static_cast<std::uint8_t>(isDeflated ? 'Z' : 'D') };
  Append(file, bytes.Get());
  corpus.Add("DicomDataSet", name, file);
}

/// The starts of compressed images, and one of run lengths, of 3 x 2 samples.
void AddCompressedDicomImages(Corpus& corpus)
{
  DicomBytes runs;
  runs.Put(2, 4).Put(64, 4).Put(67, 4).PutRaw(std::string(52, '\0'));
  runs.Put(251, 1).Put(1, 1).Put(128, 1).Put(2, 1).PutRaw("abc").Put(254, 1).Put(7, 1).Put(0, 1);
  const auto toText = [](const DicomBytes& bytes)
  { return std::string(bytes.Get().begin(), bytes.Get().end()); };
  AddDicomImage(corpus, "run-lengths", "1.2.840.10008.1.2.5", {}, { toText(runs) });
  DicomBytes frame;
  frame.Put(0xd8ff, 2).Put(0xe0ff, 2).Put(0x0400, 2).PutRaw("ab").Put(0xc3ff, 2).Put(0x0b00, 2);
  frame.Put(16, 1).Put(0x0200, 2).Put(0x0300, 2).Put(1, 1).PutRaw("abc");
  AddDicomImage(corpus, "jpeg", "1.2.840.10008.1.2.4.70", {}, { toText(frame) });
  DicomBytes boxes;
  boxes.Put(0x0c000000, 4).PutRaw("jP  \r\n\x87\n").Put(0, 4).PutRaw("jp2c");
  boxes.Put(0x51ff4fff, 4).Put(0x2900, 2).Put(0, 2).Put(0x03000000, 4).Put(0x02000000, 4);
  boxes.PutRaw(std::string(24, '\0')).Put(0x0100, 2).Put(15, 1).Put(0x0101, 2);
  AddDicomImage(corpus, "jpeg-2000-in-boxes", "1.2.840.10008.1.2.4.90", {}, { toText(boxes) });
}

void AddDicomImages(Corpus& corpus)
{
  const std::string plain = "1.2.840.10008.1.2.1";
  AddDicomImage(corpus, "explicit", plain);
  AddDicomImage(corpus, "implicit", "1.2.840.10008.1.2");
  AddDicomImage(corpus, "explicit-big-endian", "1.2.840.10008.1.2.2");
  AddDicomImage(corpus, "deflated", "1.2.840.10008.1.2.1.99");
  AddDicomImage(corpus, "fragments", "1.2.840.10008.1.2.4.70", {}, { "abcd", "ef" });
  AddCompressedDicomImages(corpus);
  DicomBytes nested;
  nested.PutHead(0x00081140, "SQ", 18).PutItem(10).PutNumber(0x00280010, 2);
  nested.PutHead(0x00081140, "SQ", DicomBytes::Undefined).PutItem();
  nested.PutHead(0x00081150, "SQ", DicomBytes::Undefined).PutItem(0);
  nested.PutEnd(DicomBytes::SequenceEnd).PutEnd(DicomBytes::ItemEnd);
  AddDicomImage(corpus, "sequences", plain, nested.PutEnd(DicomBytes::SequenceEnd));
  DicomBytes unknown;
  unknown.PutHead(0x00090010, "UN", DicomBytes::Undefined).PutItem().IsImplicit = true;
  unknown.PutNumber(0x00280010, 2).PutEnd(DicomBytes::ItemEnd).PutEnd(DicomBytes::SequenceEnd);
  AddDicomImage(corpus, "unknown-sequence", plain, unknown);
  DicomBytes icon;
  icon.PutHead(0x00880200, "SQ", DicomBytes::Undefined).PutItem();
  icon.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0).PutItem(2).PutRaw("ab");
  icon.PutEnd(DicomBytes::SequenceEnd).PutEnd(DicomBytes::ItemEnd);
  AddDicomImage(corpus, "icon", plain, icon.PutEnd(DicomBytes::SequenceEnd));
  DicomBytes bare;
  bare.PutNumber(0x00080001, 7).PutImage(3, 2).PutBytes(0x7fe00010, "OW", Bytes(12, 7));
  Bytes file = { 'D' };
  Append(file, bare.Get());
  corpus.Add("DicomDataSet", "without-preamble", file);
}

/// A stream of bytes that repeat, other ones in each 64 KiB, and reads of it.
void AddGzipStream(
  Corpus& corpus, const std::string& name, int header, std::size_t size, std::size_t members)
{
  Bytes samples(size);
  for (std::size_t at = 0; at < size; ++at)
  {
    samples[at] = static_cast<std::uint8_t>(at % 3 * 61 + (at >> 16));
  }
  Bytes input;
  const auto appendNumber = [&input](std::size_t number)
  {
    for (int shift = 0; shift < 24; shift += 8)
    {
      input.push_back(static_cast<std::uint8_t>(number >> shift));
    }
  };
  appendNumber(members * size);
  input.push_back(4);
  for (const std::size_t tenth : { 9, 1, 5, 0 })
  {
    appendNumber(members * size * tenth / 10);
    appendNumber(size / 10);
  }
  for (std::size_t member = 0; member < members; ++member)
  {
    z_stream state = {};
    if (::deflateInit2(&state, 9, Z_DEFLATED, header, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    {
      corpus.Fail();
      return;
    }
    Bytes stream(::deflateBound(&state, size));
    state.next_in = samples.data();
    state.avail_in = static_cast<uInt>(size);
    state.next_out = stream.data();
    state.avail_out = static_cast<uInt>(stream.size());
    ::deflate(&state, Z_FINISH);
    stream.resize(state.total_out);
    ::deflateEnd(&state);
    Append(input, stream);
  }
  corpus.Add("GzipFile", name, input);
}

void AddGzipStreams(Corpus& corpus)
{
  AddGzipStream(corpus, "gzip", 15 + 16, 3000, 1);
  AddGzipStream(corpus, "zlib", 15, 3000, 1);
  AddGzipStream(corpus, "members", 15 + 16, 700, 3);
  AddGzipStream(corpus, "places", 15 + 16, 13 << 20, 1);
  AddGzipStream(corpus, "places-of-members", 15 + 16, 5 << 20, 3);
}

/// The journal that is left, and changes of the files beside it.
void AddUnfinishedWrites(Corpus& corpus)
{
  corpus.Add("UnfinishedWrite", "as-left", { 0 });
  for (std::uint8_t file = 0; file < 6; ++file)
  {
    const std::string number = std::to_string(file);
    corpus.Add("UnfinishedWrite", "changed-" + number, { 0, file, 60, 0, 0, 2, 255, 255 });
    const auto cut = static_cast<std::uint8_t>(128 + file);
    corpus.Add("UnfinishedWrite", "truncated-" + number, { 0, cut, 50, 0, 0, 0 });
  }
}

} // namespace

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    std::fprintf(stderr, "Usage: %s <folder>\n", argv[0]);
    return 2;
  }
  Corpus corpus(argv[1]);
  AddRectilinearHeader(corpus);
  AddVolumeInPlace(corpus);
  AddVolume<std::uint8_t>(corpus, "uint8", { 20, 3, 2 }, 1);
  AddVolume<std::int16_t>(corpus, "int16", { 5, 4, 3 }, 1);
  AddVolume<float>(corpus, "float32", { 3, 18, 2 }, 1);
  AddVolume<std::uint64_t>(corpus, "uint64-two-stores", { 2, 2, 20 }, 2);
  AddVolume<std::uint8_t>(corpus, "uint8-lz4", { 20, 9, 5 }, 1, { SegmentCodec::Lz4, 0 });
  AddVolume<std::int16_t>(corpus, "int16-zstd", { 18, 9, 5 }, 1, { SegmentCodec::Zstd, 0 });
  AddVolume<float>(corpus, "float32-zstd", { 9, 18, 5 }, 1, { SegmentCodec::Zstd, 0 });
  AddVolume<float>(corpus, "float32-vectors", { 18, 4, 3 }, 1, {}, 3);
  AddVolume<std::uint8_t>(corpus, "uint8-pairs-lz4", { 9, 8, 7 }, 1, { SegmentCodec::Lz4, 0 }, 2);
  AddVolume<std::int16_t>(corpus, "int16-steps", { 5, 4, 3 }, 2, {}, 1, 3);
  AddTrees(corpus);
  AddEdgeIndexFiles(corpus);
  AddDicomImages(corpus);
  AddGzipStreams(corpus);
  AddUnfinishedWrites(corpus);
  if (!corpus.IsOk())
  {
    std::fprintf(stderr, "%s: the corpus cannot be written\n", argv[1]);
    return 1;
  }
  return 0;
}
