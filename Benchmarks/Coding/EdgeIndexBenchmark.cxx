// SPDX-License-Identifier: BSD-3-Clause
/**
 * Isosurfaces as edge-index streams, beside Draco in the same run. For a raw volume and isovalues
 * it prints bits a surface vertex and triangles a second (of processor time on one core unless --threads),
 * for encoding and for decoding including the surface, of
 *
 *   ours    lossless, by profile; bounded, at the maximum error that Draco makes; quantized as in
 *           the paper
 *   Draco   compression levels 7 and 10, positions of 11 and 14 bits, connectivity by edgebreaker
 *   errors  with --errors: bounded and smallest at these, in the profile small
 *   peers   with --peers: see SurfacePeers.h
 *
 * and the ratios that Documentation/dev/edge-index.md cites.
 */
#include "SurfacePeers.h"

#include "Fixtures/EdgeIndexStreams.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <CLI/CLI.hpp>
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

using namespace isosurface;

namespace
{

/// The minimum of the seconds that some runs take: of the processor on one thread, so that other
/// programs disturb less; else of the clock.
template <typename Functor>
double Time(int repeats, int threads, const Functor& functor)
{
  const auto now = [threads]
  {
    timespec time{};
    clock_gettime(threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  double minimum = 1e300;
  for (int repeat = 0; repeat < repeats; ++repeat)
  {
    const double start = now();
    functor();
    minimum = std::min(minimum, now() - start);
  }
  return minimum;
}

struct Outcome
{
  double Bytes = 0;
  double EncodeSeconds = 0;
  double DecodeSeconds = 0;
  double MaximumError = 0; ///< in voxels
};

struct Volume
{
  GridGeometry Geometry;
  SampleView View;
  std::vector<char> Bytes;
};

/// The blocks of a volume in memory, of any size.
class VolumeBlocks : public BlockSource
{
public:
  VolumeBlocks(const Volume& volume, int blockSize)
    : Data(volume)
    , Grid(volume.Geometry.GetDimensions(), blockSize)
  {
  }
  std::size_t GetNumberOfBlocks() const override
  {
    return static_cast<std::size_t>(this->Grid.GetNumberOfBlocks());
  }
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    return this->Grid.GetBlockCoordinates(static_cast<std::int64_t>(block));
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    return this->Grid.GetVertices(static_cast<std::int64_t>(block));
  }
  ValueType GetValueType() const override { return this->Data.View.Type; }
  Result<BlockSamples> Acquire(std::size_t block) override
  {
    BlockSamples samples;
    samples.Scalars = this->Data.View;
    samples.Scalars.Box = this->GetVertices(block);
    return samples;
  }

private:
  const Volume& Data;
  BlockGrid Grid;
};

void Print(const char* name, const Outcome& outcome, const Surface& surface)
{
  const auto triangles = static_cast<double>(surface.NumberOfTriangles);
  std::printf("  %-26s %8.3f b/v  %8.2f M/s in %8.2f M/s out", name,
    8 * outcome.Bytes / static_cast<double>(surface.NumberOfPoints),
    triangles / outcome.EncodeSeconds / 1e6, triangles / outcome.DecodeSeconds / 1e6);
  if (outcome.MaximumError > 0)
  {
    std::printf("  maximum error %.5f", outcome.MaximumError);
  }
  std::printf("\n");
  std::fflush(stdout);
}

class Benchmark
{
public:
  Benchmark(const Volume& volume, double isovalue, int blockSize, int repeats, int threads)
    : Data(volume)
    , Isovalue(isovalue)
    , Repeats(repeats)
    , Threads(threads)
    , BlockSize(blockSize)
  {
    this->Request.Isovalues = { isovalue };
    this->Request.GlobalIds = true;
    VolumeBlocks source(volume, blockSize);
    this->Exact = std::move(*ExtractSurface(volume.Geometry, source, this->Request, 1));
  }

  const Surface& GetExact() const { return this->Exact; }

  Outcome MeasureOurs(const EdgeIndexSettings& settings) const
  {
    EdgeIndexHeader header;
    header.Geometry = this->Data.Geometry;
    header.Type = this->Data.View.Type;
    header.Isovalues = { this->Isovalue };
    header.Settings = settings;
    Outcome outcome;
    std::vector<std::uint8_t> bytes;
    outcome.EncodeSeconds = Time(this->Repeats, this->Threads,
      [&]
      {
        VolumeBlocks source(this->Data, this->BlockSize);
        auto encoded = EncodeSurface(header, source, this->Threads);
        if (!encoded.IsOk())
        {
          std::fprintf(stderr, "%s\n", encoded.GetStatus().GetMessage().c_str());
          std::exit(1);
        }
        bytes = std::move(*encoded);
      });
    outcome.Bytes = static_cast<double>(bytes.size());
    ContourRequest plain;
    Surface decoded;
    outcome.DecodeSeconds = Time(this->Repeats, this->Threads,
      [&]
      { decoded = std::move(*DecodeSurface(bytes.data(), bytes.size(), plain, this->Threads)); });
    for (std::size_t n = 0; n < this->Exact.Points.GetSize(); ++n)
    {
      outcome.MaximumError = std::max(outcome.MaximumError,
        std::abs(static_cast<double>(this->Exact.Points[n] - decoded.Points[n])));
    }
    return outcome;
  }

  Outcome MeasureDraco(int level, int bits) const
  {
    Outcome outcome;
    const auto encode = [&](const draco::Mesh& mesh, draco::EncoderBuffer& buffer)
    {
      draco::Encoder encoder;
      encoder.SetSpeedOptions(10 - level, 10 - level);
      encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
      encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
      if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok())
      {
        std::fprintf(stderr, "Draco refuses this mesh\n");
        std::exit(1);
      }
    };
    draco::Mesh mesh;
    this->FillMesh(mesh, false);
    draco::EncoderBuffer buffer;
    outcome.EncodeSeconds = Time(this->Repeats, 1,
      [&]
      {
        buffer.Clear();
        encode(mesh, buffer);
      });
    outcome.Bytes = static_cast<double>(buffer.size());
    outcome.DecodeSeconds = Time(this->Repeats, 1,
      [&]
      {
        draco::DecoderBuffer from;
        from.Init(buffer.data(), buffer.size());
        draco::Decoder decoder;
        const auto decoded = decoder.DecodeMeshFromBuffer(&from);
      });

    // Draco reorders points: encode once more, with their numbers as an attribute.
    draco::Mesh numbered;
    this->FillMesh(numbered, true);
    draco::EncoderBuffer other;
    encode(numbered, other);
    draco::DecoderBuffer from;
    from.Init(other.data(), other.size());
    draco::Decoder decoder;
    const auto decoded = std::move(decoder.DecodeMeshFromBuffer(&from)).value();
    outcome.MaximumError = this->FindMaximumError(*decoded);
    return outcome;
  }

private:
  void FillMesh(draco::Mesh& mesh, bool numbered) const
  {
    const auto points = static_cast<std::uint32_t>(this->Exact.NumberOfPoints);
    mesh.set_num_points(points);
    draco::GeometryAttribute position;
    position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    draco::PointAttribute* positions = mesh.attribute(mesh.AddAttribute(position, true, points));
    draco::PointAttribute* numbers = nullptr;
    if (numbered)
    {
      draco::GeometryAttribute number;
      number.Init(draco::GeometryAttribute::GENERIC, nullptr, 1, draco::DT_UINT32, false, 4, 0);
      numbers = mesh.attribute(mesh.AddAttribute(number, true, points));
    }
    for (std::uint32_t n = 0; n < points; ++n)
    {
      positions->SetAttributeValue(draco::AttributeValueIndex(n), &this->Exact.Points[3 * n]);
      if (numbers)
      {
        numbers->SetAttributeValue(draco::AttributeValueIndex(n), &n);
      }
    }
    for (std::size_t n = 0; n < this->Exact.NumberOfTriangles; ++n)
    {
      draco::Mesh::Face face;
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        face[corner] = static_cast<std::uint32_t>(this->Exact.Connectivity[3 * n + corner]);
      }
      mesh.AddFace(face);
    }
  }

  double FindMaximumError(const draco::Mesh& mesh) const
  {
    const draco::PointAttribute* positions =
      mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    const draco::PointAttribute* numbers =
      mesh.GetNamedAttribute(draco::GeometryAttribute::GENERIC);
    double largest = 0;
    for (std::uint32_t n = 0; n < mesh.num_points(); ++n)
    {
      float point[3];
      std::uint32_t number = 0;
      positions->GetMappedValue(draco::PointIndex(n), point);
      numbers->GetMappedValue(draco::PointIndex(n), &number);
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        const double shift =
          static_cast<double>(point[axis] - this->Exact.Points[3 * std::size_t(number) + axis]);
        square += shift * shift;
      }
      largest = std::max(largest, std::sqrt(square));
    }
    return largest;
  }

  const Volume& Data;
  double Isovalue;
  int Repeats;
  int Threads;
  int BlockSize;
  ContourRequest Request;
  Surface Exact;
};

/// Quantized as in the paper, over the range of the samples.
void PrintQuantized(const Volume& volume, const Benchmark& benchmark)
{
  EdgeIndexSettings settings;
  settings.Mode = EdgeIndexMode::Quantized;
  const std::size_t samples = static_cast<std::size_t>(volume.Geometry.GetNumberOfVertices());
  DispatchValueType(volume.View.Type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T* first = reinterpret_cast<const T*>(volume.Bytes.data());
      const auto range = std::minmax_element(first, first + samples);
      settings.QuantizationMinimum = static_cast<double>(*range.first);
      settings.QuantizationMaximum = static_cast<double>(*range.second);
    });
  for (const int bits : { 8, 12 })
  {
    settings.QuantizationBits = bits;
    Print(("quantized, " + std::to_string(bits) + " bits").c_str(), benchmark.MeasureOurs(settings),
      benchmark.GetExact());
  }
}

void PrintPeers(const Surface& surface)
{
  for (const PeerOutcome& peer : MeasurePeers(surface))
  {
    Outcome outcome;
    outcome.Bytes = static_cast<double>(peer.Bytes);
    outcome.EncodeSeconds = peer.EncodeSeconds;
    outcome.DecodeSeconds = peer.DecodeSeconds;
    Print(peer.Name.c_str(), outcome, surface);
  }
}

/// Bounded and smallest at given maximum errors.
void PrintErrors(const std::vector<double>& errors, const Benchmark& benchmark)
{
  for (const double error : errors)
  {
    std::printf("  maximum error %g\n", error);
    EdgeIndexSettings settings;
    settings.MaximumError = error;
    settings.Mode = EdgeIndexMode::Bounded;
    Print("bounded", benchmark.MeasureOurs(settings), benchmark.GetExact());
    settings.Mode = EdgeIndexMode::Smallest;
    Print("smallest", benchmark.MeasureOurs(settings), benchmark.GetExact());
  }
}

void Run(const Volume& volume, double isovalue, int blockSize, int repeats, int threads, bool draco,
  bool peers, const std::vector<double>& errors)
{
  const Benchmark benchmark(volume, isovalue, blockSize, repeats, threads);
  const Surface& exact = benchmark.GetExact();
  std::printf("isovalue %g: %zu triangles, %zu vertices, blocks of %d\n", isovalue,
    exact.NumberOfTriangles, exact.NumberOfPoints, blockSize);
  if (!errors.empty())
  {
    PrintErrors(errors, benchmark);
    return;
  }
  EdgeIndexSettings settings;
  const Outcome lossless = benchmark.MeasureOurs(settings);
  Print("lossless", lossless, exact);
  settings.Profile = EdgeIndexProfile::Working;
  const Outcome working = benchmark.MeasureOurs(settings);
  Print("lossless, working", working, exact);
  std::printf("  working / small: bytes %.3f\n", working.Bytes / lossless.Bytes);
  if (peers)
  {
    PrintQuantized(volume, benchmark);
    PrintPeers(exact);
  }
  if (!draco)
  {
    return;
  }
  for (const int bits : { 11, 14 })
  {
    const Outcome ten = benchmark.MeasureDraco(10, bits);
    const Outcome seven = benchmark.MeasureDraco(7, bits);
    const std::string name = "Draco " + std::to_string(bits) + " bits";
    Print((name + ", level 10").c_str(), ten, exact);
    Print((name + ", level 7").c_str(), seven, exact);
    settings.Mode = EdgeIndexMode::Smallest;
    settings.MaximumError = std::min(0.5, ten.MaximumError);
    settings.Profile = EdgeIndexProfile::Small;
    const Outcome bounded = benchmark.MeasureOurs(settings);
    Print("smallest, the same error", bounded, exact);
    settings.Mode = EdgeIndexMode::Bounded;
    settings.Profile = EdgeIndexProfile::Working;
    const Outcome boundedWorking = benchmark.MeasureOurs(settings);
    Print("bounded, working, the same", boundedWorking, exact);
    std::printf("  working / Draco: out x %.2f of level 10, x %.2f of level 7;  bounded x %.2f, "
                "x %.2f, bytes %.2f of small's\n",
      ten.DecodeSeconds / working.DecodeSeconds, seven.DecodeSeconds / working.DecodeSeconds,
      ten.DecodeSeconds / boundedWorking.DecodeSeconds,
      seven.DecodeSeconds / boundedWorking.DecodeSeconds, boundedWorking.Bytes / bounded.Bytes);
    std::printf("  Draco / ours: bytes %.2f;  lossless in x %.2f of level 10, out x %.2f\n",
      ten.Bytes / bounded.Bytes, ten.EncodeSeconds / lossless.EncodeSeconds,
      ten.DecodeSeconds / lossless.DecodeSeconds);
  }
}

} // namespace

int main(int argc, char** argv)
{
  std::string file;
  std::vector<int> dimensions;
  std::string type = "uint8";
  std::vector<double> isovalues;
  int blockSize = 64;
  int repeats = 3;
  int threads = 1;
  bool withoutDraco = false;
  bool peers = false;
  std::vector<double> errors;
  CLI::App application("Edge-index streams of isosurfaces, beside Draco");
  application.add_option("file", file, "raw samples, x fastest")->required();
  application.add_option("--dimensions", dimensions, "samples on x, y, z")->expected(3)->required();
  application.add_option("--type", type, "uint8, int16, float32, ...");
  application.add_option("--isovalues", isovalues, "surfaces to encode")->required();
  application.add_option("--block-size", blockSize, "cells along the side of a block");
  application.add_option("--repeats", repeats, "runs, of which the fastest counts");
  application.add_option("--threads", threads, "threads that encode and decode; Draco has one");
  application.add_flag("--without-draco", withoutDraco, "ours only");
  application.add_flag("--peers", peers, "other formats as well, and our quantized mode");
  application.add_option("--errors", errors, "only bounded modes, at these errors in voxels");
  CLI11_PARSE(application, argc, argv);

  const auto valueType = FindValueType(type);
  std::ifstream stream(file, std::ios::binary);
  if (!valueType || !stream)
  {
    std::fprintf(stderr, "%s: cannot be read, or the type is unknown\n", file.c_str());
    return 1;
  }
  Volume volume;
  volume.Geometry.Extent = { 0, dimensions[0] - 1, 0, dimensions[1] - 1, 0, dimensions[2] - 1 };
  volume.Bytes.resize(
    static_cast<std::size_t>(volume.Geometry.GetNumberOfVertices()) * GetValueSize(*valueType));
  stream.read(volume.Bytes.data(), static_cast<std::streamsize>(volume.Bytes.size()));
  if (!stream)
  {
    std::fprintf(stderr, "%s: too short\n", file.c_str());
    return 1;
  }
  volume.View.Type = *valueType;
  volume.View.First = volume.Bytes.data();
  volume.View.Stride = { 1, dimensions[0], std::ptrdiff_t(dimensions[0]) * dimensions[1] };
  volume.View.Box.High = volume.Geometry.GetDimensions();
  volume.View.Available = volume.View.Box;
  for (const double isovalue : isovalues)
  {
    Run(volume, isovalue, blockSize, repeats, threads, !withoutDraco, peers, errors);
  }
  return 0;
}
