// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndexCommands.h"
#include "Coding/Meshes/MeshFile.h"
#include "MeshWriteJob.h"
#include "ProgressDisplay.h"

#include "vtkErrorCode.h"
#include "vtkNew.h"
#include "vtkPolyData.h"
#include "vtkXMLPolyDataWriter.h"

#include "Coding/EdgeIndex/EdgeIndexFile.h"
#include "Coding/EdgeIndex/EdgeIndexWriteJob.h"
#include "Ground/Base/OutputCheck.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/PrintableText.h"
#include "Surface/Islands/IslandKeeping.h"
#include "SurfacePolyData.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace isosurface
{
namespace
{

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
      FormatBytes(bytes).c_str());
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
