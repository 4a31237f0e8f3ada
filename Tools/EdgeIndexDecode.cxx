// SPDX-License-Identifier: BSD-3-Clause
#include "Coding/Meshes/MeshFile.h"
#include "EdgeIndexCommands.h"
#include "ProgressDisplay.h"

#include "vtkErrorCode.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkXMLPolyDataWriter.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Coding/Meshes/SurfaceMeshes.h"
#include "CompressedMesh.h"
#include "Ground/Base/OutputCheck.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/PrintableText.h"
#include "Ground/Base/Progress.h"
#include "Ground/Volume/PointPrecision.h"
#include "Ground/Volume/Vector3.h"
#include "Ground/Volume/VertexPlaces.h"
#include "SharedPoints.h"
#include "SimplifiedMesh.h"
#include "Surface/Islands/IslandKeeping.h"
#include "SurfacePolyData.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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

/// Decodes an edge-index file piece by piece into a file of triangles.
class MeshWriteJob
{
public:
  struct Settings
  {
    std::uint64_t NumberOfTriangles = 0; ///< about the number to simplify to; 0: keep all
    std::uint64_t MemoryMebibytes = 1024;
    int Threads = 1;
    bool IsPreview = false;
    bool IsCompressed = false;
    double UnitInMetres = 0.001;        ///< the unit of the points; of .glb
    std::vector<std::size_t> Isovalues; ///< numbers of those to write; none: all
  };

  /// `file` must outlive the job.
  MeshWriteJob(const EdgeIndexFile& file, const Settings& settings)
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

  /// Writes the file that is to be at `path` at `partial`. Errors: those of EdgeIndexFile::Read() and
  /// MeshFile.
  Status Write(const std::string& path, const std::string& partial, const Progress& progress)
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

  /// From where the float32 points of .stl files count, if float32 does not suffice for places.
  const std::optional<Vector3>& GetOrigin() const { return this->Origin; }
  std::uint64_t GetNumberOfPoints() const { return this->Shared.GetNumberOfPoints(); }
  std::uint64_t GetNumberOfTriangles() const { return this->NumberOfTriangles; }
  /// Those with a point that is not finite.
  std::uint64_t GetNumberOfDroppedTriangles() const { return this->NumberOfDroppedTriangles; }

private:
  std::vector<SurfacePortion> FindPieces() const
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

  Status WritePiece(const SurfacePortion& piece, MeshFile& output, const Progress& progress)
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

  /// Simplifies a mesh to about `triangles`, if it has more, and writes it.
  Status WritePart(const Mesh& mesh, std::size_t triangles, MeshFile& output)
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

  const EdgeIndexFile& File;
  Settings Chosen;
  bool HasNormals;
  std::optional<Vector3> Origin; ///< the first vertex of the grid, if points are float64
  std::uint64_t PointsInAll = 0; ///< as the directory counts them
  SharedPoints Shared;
  std::uint64_t NumberOfTriangles = 0;
  std::uint64_t NumberOfDroppedTriangles = 0;
};

std::string FindEnding(const std::string& path)
{
  const std::size_t dot = path.rfind('.');
  return dot == std::string::npos ? "" : path.substr(dot);
}

/// Brings a file that another library has written to stable storage, and looks at its end.
Status CheckWritten(const std::string& path, const std::string& end)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto written, GetLocalFileSystem().OpenForUpdate(path));
  ISOSURFACE_RETURN_IF_ERROR(written->SyncAndClose());
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, GetLocalFileSystem().OpenForReading(path));
  std::string last(std::min<std::uint64_t>(end.size(), file->GetSize()), ' ');
  ISOSURFACE_RETURN_IF_ERROR(file->Read(file->GetSize() - last.size(), last.size(), &last[0]));
  return last == end ? Status::Ok()
                     : Status(StatusCode::IoError, path + ": was not written to its end");
}

Status WritePolyData(vtkPolyData* surface, const std::string& path)
{
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(surface);
  writer->SetFileName(path.c_str());
  if (writer->Write() == 0 || writer->GetErrorCode() != vtkErrorCode::NoError)
  {
    return { StatusCode::IoError,
      path +
        ": cannot be written: " + vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()) };
  }
  return CheckWritten(path, "</VTKFile>\n");
}

/// Writes to a temporary name first, as writers of edge-index files do, so that an incomplete file is
/// never taken for a complete one.
Status WriteInOneStep(
  const std::string& path, const std::function<Status(const std::string&)>& write)
{
  const std::string partial = GetPartialEdgeIndexPath(path);
  FileSystem& files = GetLocalFileSystem();
  ISOSURFACE_ASSIGN_OR_RETURN(auto lock, LockEdgeIndexFile(files, path));
  Status status = Attempt(path, [&] { return write(partial); });
  if (status.IsOk())
  {
    status = PutEdgeIndexFileInPlace(files, path, lock);
  }
  if (lock)
  {
    static_cast<void>(files.RemoveAll(partial));
  }
  return status;
}

Status CheckOutput(const EdgeIndexOptions& options)
{
  const std::string& path = options.Output;
  const std::string ending = FindEnding(path);
  const bool isMesh = MeshFile::Knows(path);
  if (!path.empty() && !isMesh && ending != ".vtp")
  {
    return { StatusCode::InvalidArgument,
      path + ": its name does not end in .ply, .stl, .glb, .vtp or .obj" };
  }
  if (options.NumberOfTriangles > 0 && !isMesh)
  {
    return { StatusCode::InvalidArgument, "--triangles needs OUT.ply, .stl, .glb or .obj" };
  }
  if (options.IsCompressed && ending != ".glb")
  {
    return { StatusCode::InvalidArgument, "--compress needs OUT.glb" };
  }
  const std::string partial = GetPartialEdgeIndexPath(path);
  for (const std::string& written : { path, partial, partial + ".faces" })
  {
    ISOSURFACE_RETURN_IF_ERROR(CheckIsOther(written, options.Input));
  }
  return Status::Ok();
}

void PrintCounts(
  const EdgeIndexOptions& options, std::uint64_t points, std::uint64_t triangles, double seconds)
{
  if (!options.IsQuiet)
  {
    std::printf("%s: %llu points, %llu triangles, %.2f s\n", options.Input.c_str(),
      static_cast<unsigned long long>(points), static_cast<unsigned long long>(triangles), seconds);
  }
}

Status MakeEmptyError(const EdgeIndexOptions& options)
{
  return { StatusCode::InvalidArgument, options.Input + ": has no triangles to write" };
}

/// What the user should know of a file that was written.
void WarnOfWritten(
  const EdgeIndexOptions& options, std::uint64_t dropped, const std::vector<std::size_t>& isovalues)
{
  const std::string ending = FindEnding(options.Output);
  if (dropped > 0)
  {
    std::fprintf(stderr,
      "edgeindex: warning: %s: %llu triangles with a point that is not a number are left out\n",
      options.Output.c_str(), static_cast<unsigned long long>(dropped));
  }
  if (!options.IsQuiet && isovalues.size() > 1 && (ending == ".stl" || ending == ".ply"))
  {
    std::fprintf(stderr,
      "edgeindex: %s: has the surfaces of %zu isovalues, which %s files cannot tell apart; "
      "--isovalue takes one\n",
      options.Output.c_str(), isovalues.size(), ending.c_str());
  }
}

/// The numbers of the isovalues to decode.
Result<std::vector<std::size_t>> FindIsovalues(
  const EdgeIndexHeader& header, const EdgeIndexOptions& options)
{
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < header.Isovalues.size(); ++n)
  {
    if (!options.Isovalue || header.Isovalues[n] == *options.Isovalue)
    {
      found.push_back(n);
    }
  }
  return found.empty() && options.Isovalue
    ? Result<std::vector<std::size_t>>(Status(StatusCode::InvalidArgument,
        options.Input + ": has no such isovalue as --isovalue; edgeindex info lists them"))
    : found;
}

Result<Surface> ReadSurface(const EdgeIndexFile& file, const EdgeIndexOptions& options,
  const std::vector<std::size_t>& isovalues, int threads)
{
  EdgeIndexSelection selection;
  selection.Isovalues = isovalues;
  selection.Preview = options.IsPreview;
  ContourRequest request;
  request.GlobalIds = true;
  request.Offsets = true;
  for (const EdgeIndexAttribute& attribute : file.GetHeader().Attributes)
  {
    request.Normals = request.Normals || (attribute.IsNormals && !options.IsPreview);
  }
  ProgressDisplay display(file.GetPath(), static_cast<double>(file.GetSize()), !options.IsQuiet);
  return file.Read(selection, request, threads, display.GetProgress());
}

std::vector<InterpolatedArray> ListArrays(const EdgeIndexHeader& header, bool isPreview)
{
  std::vector<InterpolatedArray> arrays;
  for (const EdgeIndexAttribute& attribute : header.Attributes)
  {
    if (!attribute.IsNormals && !isPreview)
    {
      arrays.push_back({ attribute.Name, {}, { attribute.Type, attribute.NumberOfComponents } });
    }
  }
  return arrays;
}

/// Decodes the surface as a whole, and writes it with VTK if there is a file to write.
Status DecodeAtOnce(const EdgeIndexFile& file, const EdgeIndexOptions& options,
  const std::vector<std::size_t>& isovalues, int threads)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto surface, ReadSurface(file, options, isovalues, threads));
  const std::size_t dropped = options.Output.empty() ? 0 : KeepFiniteTriangles(threads, surface);
  PrintCounts(options, surface.NumberOfPoints, surface.NumberOfTriangles, surface.TotalSeconds);
  if (options.Output.empty())
  {
    return Status::Ok();
  }
  if (surface.NumberOfTriangles == 0)
  {
    return MakeEmptyError(options);
  }
  vtkNew<vtkPolyData> polyData;
  MoveToPolyData(
    surface, ListArrays(file.GetHeader(), options.IsPreview), file.GetHeader().Array, polyData);
  ISOSURFACE_RETURN_IF_ERROR(WriteInOneStep(
    options.Output, [&](const std::string& path) { return WritePolyData(polyData, path); }));
  WarnOfWritten(options, dropped, isovalues);
  return Status::Ok();
}

/// Decodes and writes the surface piece by piece.
Status WriteMeshFile(const EdgeIndexFile& file, const EdgeIndexOptions& options,
  const std::vector<std::size_t>& isovalues, int threads)
{
  MeshWriteJob::Settings settings;
  settings.NumberOfTriangles = options.NumberOfTriangles;
  settings.MemoryMebibytes = options.MemoryMebibytes;
  settings.Threads = threads;
  settings.IsPreview = options.IsPreview;
  settings.IsCompressed = options.IsCompressed;
  const LengthUnit unit =
    options.Unit == LengthUnit::Unknown ? file.GetHeader().Geometry.Unit : options.Unit;
  settings.UnitInMetres = GetMeters(unit == LengthUnit::Unknown ? LengthUnit::Millimeter : unit);
  settings.Isovalues = isovalues;
  MeshWriteJob job(file, settings);
  ProgressDisplay display(file.GetPath(), static_cast<double>(file.GetSize()), !options.IsQuiet);
  const auto write = [&](const std::string& partial)
  {
    ISOSURFACE_RETURN_IF_ERROR(job.Write(options.Output, partial, display.GetProgress()));
    return job.GetNumberOfTriangles() == 0 ? MakeEmptyError(options) : Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(WriteInOneStep(options.Output, write));
  PrintCounts(options, job.GetNumberOfPoints(), job.GetNumberOfTriangles(), display.GetSeconds());
  WarnOfWritten(options, job.GetNumberOfDroppedTriangles(), isovalues);
  if (job.GetOrigin() && FindEnding(options.Output) == ".stl")
  {
    std::fprintf(stderr,
      "edgeindex: warning: %s: float32 cannot hold its places in the world: they count from %s\n",
      options.Output.c_str(), ToText(*job.GetOrigin()).c_str());
  }
  return Status::Ok();
}

} // namespace

Status RunEdgeIndexVerify(const EdgeIndexOptions& options)
{
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto file, EdgeIndexFile::Open(GetLocalFileSystem(), options.Input));
  const int threads = options.Threads > 0 ? options.Threads : ChooseThreadCount(1);
  const auto bytes = static_cast<double>(file->GetSize());
  ProgressDisplay display(options.Input, bytes, !options.IsQuiet);
  ISOSURFACE_RETURN_IF_ERROR(file->Verify(threads, display.GetProgress()));
  display.Clear();
  if (!options.IsQuiet)
  {
    std::printf("%s: sound: %zu records, %s\n", options.Input.c_str(), file->GetEntries().size(),
      DescribeBytes(bytes).c_str());
  }
  return Status::Ok();
}

Status RunEdgeIndexDecode(const EdgeIndexOptions& options)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckOutput(options));
  ISOSURFACE_ASSIGN_OR_RETURN(
    const auto file, EdgeIndexFile::Open(GetLocalFileSystem(), options.Input));
  if (!file->IsComplete())
  {
    std::fprintf(stderr, "edgeindex: warning: %s\n", MakePrintable(file->GetMissing()).c_str());
  }
  const int threads = options.Threads > 0 ? options.Threads : ChooseThreadCount(1);
  ISOSURFACE_ASSIGN_OR_RETURN(const auto isovalues, FindIsovalues(file->GetHeader(), options));
  return MeshFile::Knows(options.Output) ? WriteMeshFile(*file, options, isovalues, threads)
                                         : DecodeAtOnce(*file, options, isovalues, threads);
}

} // namespace isosurface
