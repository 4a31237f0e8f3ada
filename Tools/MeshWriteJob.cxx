// SPDX-License-Identifier: BSD-3-Clause
#include "MeshWriteJob.h"

#include "Coding/Meshes/SurfaceMeshes.h"
#include "CompressedMesh.h"
#include "Ground/Volume/PointPrecision.h"
#include "Ground/Volume/VertexPlaces.h"
#include "SimplifiedMesh.h"
#include "Surface/Islands/IslandKeeping.h"

#include <algorithm>
#include <cstdio>

namespace isosurface
{
namespace
{

// What a process has before it decodes anything.
constexpr std::uint64_t ProcessBytes = std::uint64_t{ 80 } << 20;
// For each point: its arrays, two triangles, and what making, simplifying and compressing them takes.
constexpr std::uint64_t PointBytes = 100;
constexpr std::uint64_t SimplifiedPointBytes = 420;
constexpr std::uint64_t DoublePointBytes = 40; // more
constexpr std::uint64_t CompressedPointBytes = 220;
// Of so many, the corners of all triangles have numbers of 32 bits.
constexpr std::uint64_t MostPoints = 100'000'000;

bool HasNormalsOf(const EdgeIndexHeader& header)
{
  return std::any_of(header.Attributes.begin(), header.Attributes.end(),
    [](const EdgeIndexAttribute& attribute) { return attribute.IsNormals; });
}

} // namespace

MeshWriteJob::MeshWriteJob(const EdgeIndexFile& file, const Settings& settings)
  : File(file)
  , Chosen(settings)
  , HasNormals(HasNormalsOf(file.GetHeader()) && !settings.IsPreview)
  , Shared(file.GetHeader().Geometry.GetDimensions(),
      file.GetHeader().ClosedSides.IsEmpty() ? 0 : file.GetHeader().Isovalues.size())
{
  const GridGeometry grid =
    settings.IsPreview ? file.GetHeader().MakePreview().Geometry : file.GetHeader().Geometry;
  if (NeedsDoublePoints(grid, nullptr))
  {
    this->Origin = VertexPlaces(grid).FindPoint({ 0, 0, 0 });
  }
}

std::vector<SurfacePortion> MeshWriteJob::FindPieces() const
{
  if (this->Chosen.IsPreview)
  {
    return { { { { 0, 0, 0 }, this->File.GetHeader().Geometry.GetDimensions() }, 1, true } };
  }
  const std::uint64_t bytes = this->Chosen.MemoryMebibytes << 20;
  const std::uint64_t point = this->Chosen.NumberOfTriangles > 0 ? SimplifiedPointBytes
    : this->Chosen.IsCompressed                                  ? CompressedPointBytes
                                                                 : PointBytes;
  return CutSurface(this->File,
    std::min(MostPoints,
      (bytes > ProcessBytes ? bytes - ProcessBytes : 1) /
        (point + (this->Origin ? DoublePointBytes : 0))));
}

Status MeshWriteJob::Write(
  const std::string& path, const std::string& partial, const Progress& progress)
{
  const std::vector<SurfacePortion> pieces = this->FindPieces();
  this->PointsInAll = 0;
  for (const SurfacePortion& piece : pieces)
  {
    this->PointsInAll += piece.NumberOfPoints;
  }
  const EdgeIndexHeader& header = this->File.GetHeader();
  MeshFile::Settings settings;
  settings.Path = path;
  settings.Partial = partial;
  settings.MostMeshes = pieces.size() * header.Isovalues.size();
  settings.HasNormals = this->HasNormals;
  settings.Compression = this->Chosen.IsCompressed ? &MeshoptimizerCompression : nullptr;
  settings.UnitInMetres = this->Chosen.UnitInMetres;
  settings.HasDoublePoints = this->Origin.has_value();
  settings.Origin = this->Origin.value_or(Vector3{});
  // A closed surface has two triangles a point.
  const std::uint64_t kept = this->Chosen.NumberOfTriangles;
  settings.Triangles = kept > 0 ? std::min(kept, 2 * this->PointsInAll) : 2 * this->PointsInAll;
  settings.Points = settings.Triangles / 2;
  const std::string warning =
    DescribeLackOfRoom(GetLocalFileSystem(), path, MeshFile::EstimateBytes(settings));
  if (!warning.empty())
  {
    std::fprintf(stderr, "edgeindex: warning: %s\n", warning.c_str());
  }
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto output, MeshFile::Create(GetLocalFileSystem(), header, settings));
  std::uint64_t done = 0;
  for (const SurfacePortion& piece : pieces)
  {
    const auto all = static_cast<double>(std::max<std::uint64_t>(this->PointsInAll, 1));
    const auto ofPiece = [&](double share)
    {
      return progress(
        (static_cast<double>(done) + share * static_cast<double>(piece.NumberOfPoints)) / all);
    };
    ISOSURFACE_RETURN_IF_ERROR(this->WritePiece(piece, *output, ofPiece));
    done += piece.NumberOfPoints;
  }
  return output->Finish();
}

Status MeshWriteJob::WritePiece(
  const SurfacePortion& piece, MeshFile& output, const Progress& progress)
{
  EdgeIndexSelection selection;
  selection.Preview = this->Chosen.IsPreview;
  selection.Isovalues = this->Chosen.Isovalues;
  if (!this->Chosen.IsPreview)
  {
    selection.Box = piece.Box;
  }
  ContourRequest request;
  request.GlobalIds = true;
  request.Normals = this->HasNormals;
  ISOSURFACE_ASSIGN_OR_RETURN(
    auto surface, this->File.Read(selection, request, this->Chosen.Threads, progress));
  this->NumberOfDroppedTriangles += KeepFiniteTriangles(this->Chosen.Threads, surface);
  this->Shared.Begin(piece);
  // A piece has the share of the triangles that it has of the points.
  const bool isSimplified = this->Chosen.NumberOfTriangles > 0;
  const double aimOfPiece = static_cast<double>(this->Chosen.NumberOfTriangles) *
    static_cast<double>(piece.NumberOfPoints) /
    static_cast<double>(std::max<std::uint64_t>(this->PointsInAll, 1));
  return VisitMeshes(surface, this->Origin, this->HasNormals,
    [&](Mesh& mesh)
    {
      const auto aim =
        static_cast<std::size_t>(aimOfPiece * static_cast<double>(mesh.NumberOfTriangles) /
          static_cast<double>(surface.NumberOfTriangles));
      mesh.Isovalue =
        this->Chosen.Isovalues.empty() ? mesh.Isovalue : this->Chosen.Isovalues[mesh.Isovalue];
      return this->WritePart(mesh, isSimplified ? aim : mesh.NumberOfTriangles, output);
    });
}

Status MeshWriteJob::WritePart(const Mesh& mesh, std::size_t triangles, MeshFile& output)
{
  if (triangles >= mesh.NumberOfTriangles)
  {
    this->NumberOfTriangles += mesh.NumberOfTriangles;
    return output.Append(mesh, this->Shared.Number(mesh));
  }
  const SimplifiedMesh simplified(mesh, triangles);
  const Mesh kept = simplified.Get();
  this->NumberOfTriangles += kept.NumberOfTriangles;
  return kept.NumberOfTriangles == 0 ? Status::Ok()
                                     : output.Append(kept, this->Shared.Number(kept));
}

} // namespace isosurface
