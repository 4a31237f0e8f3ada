// SPDX-License-Identifier: BSD-3-Clause
#include "SurfacePeers.h"

#include <lzma.h>
#include <zstd.h>

#ifdef ISOSURFACE_PEER_MESHOPTIMIZER
#  include <meshoptimizer.h>
#endif
#ifdef ISOSURFACE_PEER_VTK
#  include <vtkCellArray.h>
#  include <vtkDataCompressor.h>
#  include <vtkFloatArray.h>
#  include <vtkNew.h>
#  include <vtkPointData.h>
#  include <vtkPoints.h>
#  include <vtkPolyData.h>
#  include <vtkTypeInt32Array.h>
#  include <vtkXMLPolyDataReader.h>
#  include <vtkXMLPolyDataWriter.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace isosurface
{
namespace
{

template <typename Functor>
double Time(const Functor& functor)
{
  const auto start = std::chrono::steady_clock::now();
  functor();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void Require(bool holds, const char* peer)
{
  if (!holds)
  {
    std::fprintf(stderr, "%s fails\n", peer);
    std::exit(1);
  }
}

using Bytes = std::vector<unsigned char>;

/// Points as they are in memory, then of each triangle its size and indices.
Bytes MakePly(const Surface& surface)
{
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
    std::to_string(surface.NumberOfPoints) +
    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
    std::to_string(surface.NumberOfTriangles) +
    "\nproperty list uchar int vertex_indices\nend_header\n";
  Bytes bytes(header.begin(), header.end());
  const std::size_t points = 3 * surface.NumberOfPoints * sizeof(float);
  std::size_t at = bytes.size();
  bytes.resize(at + points + 13 * surface.NumberOfTriangles);
  std::memcpy(&bytes[at], &surface.Points[0], points);
  at += points;
  for (std::size_t n = 0; n < surface.NumberOfTriangles; ++n)
  {
    bytes[at] = 3;
    std::int32_t corners[3];
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
      corners[corner] = static_cast<std::int32_t>(surface.Connectivity[3 * n + corner]);
    }
    std::memcpy(&bytes[at + 1], corners, sizeof(corners));
    at += 13;
  }
  return bytes;
}

PeerOutcome MeasureZstd(const Bytes& ply, int level)
{
  PeerOutcome outcome;
  outcome.Name = ".ply, zstd -" + std::to_string(level);
  Bytes packed(ZSTD_compressBound(ply.size()));
  outcome.EncodeSeconds = Time(
    [&] {
      outcome.Bytes = ZSTD_compress(packed.data(), packed.size(), ply.data(), ply.size(), level);
    });
  Bytes unpacked(ply.size());
  outcome.DecodeSeconds =
    Time([&] { ZSTD_decompress(unpacked.data(), unpacked.size(), packed.data(), outcome.Bytes); });
  Require(unpacked == ply, "zstd");
  return outcome;
}

PeerOutcome MeasureXz(const Bytes& ply)
{
  PeerOutcome outcome;
  outcome.Name = ".ply, xz -6";
  Bytes packed(lzma_stream_buffer_bound(ply.size()));
  outcome.EncodeSeconds = Time(
    [&]
    {
      const lzma_ret result = lzma_easy_buffer_encode(6, LZMA_CHECK_CRC64, nullptr, ply.data(),
        ply.size(), packed.data(), &outcome.Bytes, packed.size());
      Require(result == LZMA_OK, "xz");
    });
  Bytes unpacked(ply.size());
  outcome.DecodeSeconds = Time(
    [&]
    {
      std::uint64_t memory = UINT64_MAX;
      std::size_t from = 0;
      std::size_t to = 0;
      const lzma_ret result = lzma_stream_buffer_decode(&memory, 0, nullptr, packed.data(), &from,
        outcome.Bytes, unpacked.data(), &to, unpacked.size());
      Require(result == LZMA_OK, "xz");
    });
  Require(unpacked == ply, "xz");
  return outcome;
}

#ifdef ISOSURFACE_PEER_VTK
void MeasureVtp(const Surface& surface, std::vector<PeerOutcome>& outcomes)
{
  vtkNew<vtkFloatArray> positions;
  positions->SetNumberOfComponents(3);
  positions->SetNumberOfTuples(static_cast<vtkIdType>(surface.NumberOfPoints));
  std::memcpy(
    positions->GetPointer(0), &surface.Points[0], 3 * surface.NumberOfPoints * sizeof(float));
  vtkNew<vtkPoints> points;
  points->SetData(positions);
  vtkNew<vtkTypeInt32Array> offsets;
  vtkNew<vtkTypeInt32Array> connectivity;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(surface.NumberOfTriangles) + 1);
  connectivity->SetNumberOfValues(3 * static_cast<vtkIdType>(surface.NumberOfTriangles));
  for (vtkIdType n = 0; n <= static_cast<vtkIdType>(surface.NumberOfTriangles); ++n)
  {
    offsets->SetValue(n, static_cast<vtkTypeInt32>(3 * n));
  }
  for (vtkIdType n = 0; n < connectivity->GetNumberOfValues(); ++n)
  {
    connectivity->SetValue(
      n, static_cast<vtkTypeInt32>(surface.Connectivity[static_cast<std::size_t>(n)]));
  }
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, connectivity);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  for (const bool lzma : { false, true })
  {
    PeerOutcome outcome;
    outcome.Name = lzma ? ".vtp, LZMA" : ".vtp, zlib";
    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetInputData(data);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetCompressorType(lzma ? vtkXMLWriterBase::LZMA : vtkXMLWriterBase::ZLIB);
    writer->WriteToOutputStringOn();
    outcome.EncodeSeconds = Time([&] { writer->Write(); });
    const std::string bytes = writer->GetOutputString();
    outcome.Bytes = bytes.size();
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->ReadFromInputStringOn();
    reader->SetInputString(bytes);
    outcome.DecodeSeconds = Time([&] { reader->Update(); });
    Require(reader->GetOutput()->GetNumberOfPoints() == data->GetNumberOfPoints(), "vtp");
    outcomes.push_back(outcome);
  }
}
#endif

#ifdef ISOSURFACE_PEER_MESHOPTIMIZER
// Triangles and vertices in meshoptimizer's order, which its codec is made for; the time counts.
template <typename Vertex>
PeerOutcome MeasureMeshoptimizer(
  const char* name, const std::vector<Vertex>& vertices, const std::vector<unsigned>& indices)
{
  PeerOutcome outcome;
  outcome.Name = name;
  Bytes packedIndices(meshopt_encodeIndexBufferBound(indices.size(), vertices.size()));
  Bytes packedVertices(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(Vertex)));
  outcome.EncodeSeconds = Time(
    [&]
    {
      std::vector<unsigned> order(indices.size());
      meshopt_optimizeVertexCache(order.data(), indices.data(), indices.size(), vertices.size());
      std::vector<Vertex> fetched(vertices.size());
      meshopt_optimizeVertexFetch(fetched.data(), order.data(), order.size(), vertices.data(),
        vertices.size(), sizeof(Vertex));
      packedIndices.resize(meshopt_encodeIndexBuffer(
        packedIndices.data(), packedIndices.size(), order.data(), order.size()));
      packedVertices.resize(meshopt_encodeVertexBuffer(packedVertices.data(), packedVertices.size(),
        fetched.data(), fetched.size(), sizeof(Vertex)));
    });
  outcome.Bytes = packedIndices.size() + packedVertices.size();
  std::vector<unsigned> decodedIndices(indices.size());
  std::vector<Vertex> decodedVertices(vertices.size());
  bool good = false;
  outcome.DecodeSeconds = Time(
    [&]
    {
      good = meshopt_decodeIndexBuffer(decodedIndices.data(), indices.size(), sizeof(unsigned),
               packedIndices.data(), packedIndices.size()) == 0 &&
        meshopt_decodeVertexBuffer(decodedVertices.data(), vertices.size(), sizeof(Vertex),
          packedVertices.data(), packedVertices.size()) == 0;
    });
  Require(good, "meshoptimizer");
  return outcome;
}

void MeasureMeshoptimizer(const Surface& surface, std::vector<PeerOutcome>& outcomes)
{
  std::vector<unsigned> indices(3 * surface.NumberOfTriangles);
  for (std::size_t n = 0; n < indices.size(); ++n)
  {
    indices[n] = static_cast<unsigned>(surface.Connectivity[n]);
  }
  struct Exact
  {
    float Position[3];
  };
  struct Rounded
  {
    std::uint16_t Position[4];
  };
  std::vector<Exact> exact(surface.NumberOfPoints);
  std::memcpy(exact.data(), &surface.Points[0], exact.size() * sizeof(Exact));
  outcomes.push_back(MeasureMeshoptimizer("meshoptimizer, float32", exact, indices));
  float least = surface.Points[0];
  float greatest = least;
  for (std::size_t n = 0; n < 3 * surface.NumberOfPoints; ++n)
  {
    least = std::min(least, surface.Points[n]);
    greatest = std::max(greatest, surface.Points[n]);
  }
  std::vector<Rounded> rounded(surface.NumberOfPoints);
  for (std::size_t n = 0; n < 3 * surface.NumberOfPoints; ++n)
  {
    rounded[n / 3].Position[n % 3] = static_cast<std::uint16_t>(
      std::lround((surface.Points[n] - least) / (greatest - least) * 16383));
  }
  outcomes.push_back(MeasureMeshoptimizer("meshoptimizer, 14 bits", rounded, indices));
}
#endif

} // namespace

std::vector<PeerOutcome> MeasurePeers(const Surface& surface)
{
  std::vector<PeerOutcome> outcomes;
  const Bytes ply = MakePly(surface);
  for (const int level : { 3, 19 })
  {
    outcomes.push_back(MeasureZstd(ply, level));
  }
  outcomes.push_back(MeasureXz(ply));
#ifdef ISOSURFACE_PEER_VTK
  MeasureVtp(surface, outcomes);
#endif
#ifdef ISOSURFACE_PEER_MESHOPTIMIZER
  MeasureMeshoptimizer(surface, outcomes);
#endif
  return outcomes;
}

} // namespace isosurface
