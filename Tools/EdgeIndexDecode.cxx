// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndexCommands.h"
#include "ProgressDisplay.h"

#include "vtkErrorCode.h"
#include "vtkNew.h"
#include "vtkOBJWriter.h"
#include "vtkPLYWriter.h"
#include "vtkPolyData.h"
#include "vtkSTLWriter.h"
#include "vtkXMLPolyDataWriter.h"

#include "Base/ParallelFor.h"
#include "EdgeIndex/EdgeIndexFile.h"
#include "SurfacePolyData.h"

#include <algorithm>
#include <cstdio>
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

template <typename Writer>
Status RunWriter(Writer* writer, vtkPolyData* surface, const std::string& path)
{
  writer->SetInputData(surface);
  writer->SetFileName(path.c_str());
  if (writer->Write() == 0 || writer->GetErrorCode() != vtkErrorCode::NoError)
  {
    return { StatusCode::IoError,
      path +
        ": cannot be written: " + vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()) };
  }
  return Status::Ok();
}

Status WriteTriangles(vtkPolyData* surface, const std::string& ending, const std::string& path)
{
  if (ending == ".ply")
  {
    vtkNew<vtkPLYWriter> writer;
    return RunWriter(writer.Get(), surface, path);
  }
  if (ending == ".stl")
  {
    vtkNew<vtkSTLWriter> writer;
    writer->SetFileTypeToBinary();
    return RunWriter(writer.Get(), surface, path);
  }
  if (ending == ".obj")
  {
    vtkNew<vtkOBJWriter> writer;
    return RunWriter(writer.Get(), surface, path);
  }
  vtkNew<vtkXMLPolyDataWriter> writer;
  return RunWriter(writer.Get(), surface, path);
}

/// Writes to a temporary name first, so that an incomplete file is never taken for a complete one.
Status WriteInOneStep(vtkPolyData* surface, const std::string& path)
{
  // VTK's writers need the extension of the format.
  const std::string ending = FindEnding(path);
  const std::string partial = path.substr(0, path.size() - ending.size()) + ".part" + ending;
  FileSystem& files = GetLocalFileSystem();
  ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(path, "write"));
  ISOSURFACE_RETURN_IF_ERROR(files.CheckRegular(partial, "write"));
  Status status = WriteTriangles(surface, ending, partial);
  if (status.IsOk())
  {
    status = files.Rename(partial, path);
  }
  if (!status.IsOk())
  {
    static_cast<void>(files.RemoveAll(partial));
  }
  return status;
}

Status CheckOutput(const std::string& path)
{
  const std::vector<std::string> endings = { ".ply", ".stl", ".vtp", ".obj" };
  const bool isKnown =
    path.empty() || std::find(endings.begin(), endings.end(), FindEnding(path)) != endings.end();
  return isKnown ? Status::Ok()
                 : Status(StatusCode::InvalidArgument,
                     path + ": its name does not end in .ply, .stl, .vtp or .obj");
}

Result<Surface> ReadSurface(const EdgeIndexFile& file, const EdgeIndexOptions& options, int threads)
{
  EdgeIndexSelection selection;
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

} // namespace

Status RunEdgeIndexVerify(const EdgeIndexOptions& options)
{
  const auto file = EdgeIndexFile::Open(GetLocalFileSystem(), options.Input);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  const int threads = options.Threads > 0 ? options.Threads : ChooseThreadCount(1);
  const auto bytes = static_cast<double>((*file)->GetSize());
  {
    ProgressDisplay display(options.Input, bytes, !options.IsQuiet);
    ISOSURFACE_RETURN_IF_ERROR((*file)->Verify(threads, display.GetProgress()));
  }
  if (!options.IsQuiet)
  {
    std::printf("%s: sound: %zu records, %s\n", options.Input.c_str(), (*file)->GetEntries().size(),
      FormatBytes(bytes).c_str());
  }
  return Status::Ok();
}

Status RunEdgeIndexDecode(const EdgeIndexOptions& options)
{
  ISOSURFACE_RETURN_IF_ERROR(CheckOutput(options.Output));
  const auto file = EdgeIndexFile::Open(GetLocalFileSystem(), options.Input);
  ISOSURFACE_RETURN_IF_ERROR(file.GetStatus());
  if (!(*file)->IsComplete())
  {
    std::fprintf(stderr, "edgeindex: warning: %s\n", (*file)->GetMissing().c_str());
  }
  const int threads = options.Threads > 0 ? options.Threads : ChooseThreadCount(1);
  auto surface = ReadSurface(**file, options, threads);
  ISOSURFACE_RETURN_IF_ERROR(surface.GetStatus());
  if (!options.IsQuiet)
  {
    std::printf("%s: %zu points, %zu triangles, %.2f s\n", options.Input.c_str(),
      surface->NumberOfPoints, surface->NumberOfTriangles, surface->TotalSeconds);
  }
  if (options.Output.empty())
  {
    return Status::Ok();
  }
  if (surface->NumberOfTriangles == 0)
  {
    return { StatusCode::InvalidArgument, options.Input + ": has no triangles to write" };
  }
  vtkNew<vtkPolyData> polyData;
  MoveToPolyData(*surface, ListArrays((*file)->GetHeader(), options.IsPreview),
    (*file)->GetHeader().Array, polyData);
  return WriteInOneStep(polyData, options.Output);
}

} // namespace isosurface
