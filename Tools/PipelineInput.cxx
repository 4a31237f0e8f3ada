// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Source/FolderFiles.h"
#include "Formats/Source/SliceFiles.h"
#include "Ground/Base/Status.h"
#include "InputVolume.h"

#include "ReaderCrash.h"
#include "Sandbox.h"

#include "vtkAlgorithm.h"
#include "vtkBMPReader.h"
#include "vtkImageData.h"
#include "vtkImageFlip.h"
#include "vtkImageReader2.h"
#include "vtkImageReader2Factory.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLogger.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkOutputWindow.h"
#include "vtkRectilinearGridReader.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"
#include "vtkStructuredPointsReader.h"
#include "vtkXMLImageDataReader.h"
#include "vtkXMLPImageDataReader.h"
#include "vtkXMLPRectilinearGridReader.h"
#include "vtkXMLRectilinearGridReader.h"

#include "ArrayChoice.h"
#include "Formats/Source/TextFields.h"
#include "Ground/Volume/MemorySource.h"
#include "ImageSamples.h"
#include "LocalVolume.h"
#include "PipelineSource.h"
#include "WriterInput.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace
{

/// Keeps VTK's first error, instead of printing it.
class vtkErrorKeeper : public vtkOutputWindow
{
public:
  static vtkErrorKeeper* New();
  vtkTypeMacro(vtkErrorKeeper, vtkOutputWindow);

  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}
  void DisplayErrorText(const char* text) override
  {
    if (this->Error.empty() && text)
    {
      this->Error = text;
    }
  }

  /// VTK's error in one line, without the place in its sources; then nothing.
  std::string TakeError()
  {
    // "ERROR: In file, line 1\nvtkClass (0x1234): what it has to say\n\n"
    std::string text = std::exchange(this->Error, std::string());
    const std::size_t begin = text.find("): ");
    text = begin == std::string::npos ? text : text.substr(begin + 3);
    std::string line;
    for (const std::string& word : isosurface::SplitWords(text))
    {
      line += (line.empty() ? "" : " ") + word;
    }
    return line;
  }

protected:
  vtkErrorKeeper() = default;

private:
  std::string Error;
};
vtkStandardNewMacro(vtkErrorKeeper);

} // namespace

namespace isosurface
{
namespace
{

/**
 * The files of an input that VTK reads: the file itself; the slices of a folder or pattern (SliceFiles);
 * or, of the files of any other pattern, which are time steps, the one of number `step`.
 */
struct PipelineFiles
{
  std::vector<std::string> Paths;
  std::size_t Steps = 1;
  std::string LeftOut; ///< says what was passed over; empty if nothing was

  /// Errors: those of SliceFiles::Find(); InvalidArgument if there is no such step.
  static Result<PipelineFiles> Find(const std::string& input, std::size_t step);
};

Result<PipelineFiles> PipelineFiles::Find(const std::string& path, std::size_t step)
{
  FileSystem& files = GetLocalFileSystem();
  const bool isPattern = IsPattern(files, path);
  std::error_code error;
  if (!isPattern && !std::filesystem::is_directory(path, error))
  {
    return PipelineFiles{ { path }, 1, "" };
  }
  if (!isPattern && ListNames(files, path).empty())
  {
    return Status(StatusCode::NotFound, path + ": cannot be read: the folder is empty");
  }
  PassedOver over;
  const std::vector<std::string> fitting =
    isPattern ? FindFittingNames(files, path, &over) : ListNames(files, path);
  if (!isPattern || fitting.empty() || !SliceFiles::FindKind(fitting).empty())
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto slices, SliceFiles::Find(files, path));
    return PipelineFiles{ std::move(slices.Paths), 1, std::move(slices.LeftOut) };
  }
  std::vector<NumberedName> names(fitting.begin(), fitting.end());
  std::stable_sort(names.begin(), names.end());
  std::vector<std::string> steps;
  for (const NumberedName& name : names)
  {
    if (FindExtension(name.Name) == FindExtension(names.front().Name))
    {
      steps.push_back((std::filesystem::path(FindFolder(path)) / name.Name).string());
    }
    else
    {
      over.Add("of another kind", name.Name);
    }
  }
  if (step >= steps.size())
  {
    return Status(StatusCode::InvalidArgument,
      path + ": has " + std::to_string(steps.size()) + " time steps, and none of number " +
        std::to_string(step));
  }
  const std::string passed = over.GetText();
  return PipelineFiles{ { steps[step] }, steps.size(),
    passed + (passed.empty() ? "" : "; ") + "the " + std::to_string(steps.size()) +
      " files are time steps, numbered from 0" };
}

using Pipeline = vtkStreamingDemandDrivenPipeline;

vtkErrorKeeper* GetErrorKeeper()
{
  auto* keeper = vtkErrorKeeper::SafeDownCast(vtkOutputWindow::GetInstance());
  if (!keeper)
  {
    vtkNew<vtkErrorKeeper> made;
    vtkOutputWindow::SetInstance(made);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
    keeper = made;
  }
  return keeper;
}

Status MakeError(const std::string& path, const std::string& otherwise)
{
  const std::string error = GetErrorKeeper()->TakeError();
  return Status(
    StatusCode::Corrupt, path + ": cannot be read: " + (error.empty() ? otherwise : error));
}

template <typename Reader>
vtkSmartPointer<vtkAlgorithm> MakeReader(const std::string& path)
{
  auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(path.c_str());
  return reader;
}

/// The reader for a name, or null.
vtkSmartPointer<vtkAlgorithm> MakeReaderOf(const std::string& path)
{
  const std::filesystem::path name(path);
  const std::string extension = LowerText(name.extension().string());
  using Maker = vtkSmartPointer<vtkAlgorithm> (*)(const std::string&);
  static const std::map<std::string, Maker> makers = {
    { ".vti", MakeReader<vtkXMLImageDataReader> }, { ".pvti", MakeReader<vtkXMLPImageDataReader> },
    { ".vtr", MakeReader<vtkXMLRectilinearGridReader> },
    { ".pvtr", MakeReader<vtkXMLPRectilinearGridReader> }
  };
  const auto maker = makers.find(extension);
  if (maker != makers.end())
  {
    return maker->second(path);
  }
  if (extension == ".vtk")
  {
    vtkNew<vtkRectilinearGridReader> reader;
    reader->SetFileName(path.c_str());
    return reader->IsFileRectilinearGrid() != 0 ? MakeReader<vtkRectilinearGridReader>(path)
                                                : MakeReader<vtkStructuredPointsReader>(path);
  }
  auto reader = vtkSmartPointer<vtkImageReader2>::Take(
    vtkImageReader2Factory::CreateImageReader2(path.c_str()));
  // VTK's reader of Radiance takes any text that begins with "#".
  if (reader && reader->IsA("vtkHDRReader") && extension != ".pic")
  {
    return nullptr;
  }
  if (reader)
  {
    reader->SetFileName(path.c_str());
  }
  return reader;
}

/// Whether an image has an 8-bit palette that is the grey of its number: then its numbers are samples.
bool HasGreyPalette(vtkBMPReader* reader)
{
  const unsigned char* const colors = reader->GetDepth() == 8 ? reader->GetColors() : nullptr;
  for (int color = 0; colors && color < 256; ++color)
  {
    const unsigned char* const rgb = colors + 3 * static_cast<std::ptrdiff_t>(color);
    if (rgb[0] != color || rgb[1] != color || rgb[2] != color)
    {
      return false;
    }
  }
  return colors != nullptr;
}

std::string DescribeCrash(const std::string& path, vtkAlgorithm* reader)
{
  return "blockvolume: " + path + ": its reader, " + reader->GetClassName() +
    ", crashed; the file is damaged, or it is not what its name says";
}

/// Runs a step of a reader, which may take memory for whatever the file states.
template <typename Step>
Status RunReader(const std::string& path, vtkAlgorithm* reader, Step&& step)
{
  std::optional<ReaderCrash> crash;
  if (!IsInSandbox()) // whose other process tells of it
  {
    crash.emplace(DescribeCrash(path, reader));
  }
  try
  {
    step();
  }
  catch (const std::exception& error)
  {
    return Status(StatusCode::Corrupt,
      path + ": cannot be read by " + reader->GetClassName() + ": " + error.what());
  }
  return Status::Ok();
}

/// A reader of slices, all of one size and type, the first row of each at y 0: VTK's readers have it at the
/// end.
Result<vtkSmartPointer<vtkAlgorithm>> MakeStackReader(const std::vector<std::string>& paths)
{
  auto reader = vtkSmartPointer<vtkImageReader2>::Take(
    vtkImageReader2Factory::CreateImageReader2(paths.front().c_str()));
  if (!reader)
  {
    return MakeError(paths.front(), "it is not what its name says");
  }
  auto* const bitmap = vtkBMPReader::SafeDownCast(reader);
  bool isGrey = bitmap != nullptr;
  std::array<int, 8> first{};
  vtkNew<vtkStringArray> names;
  for (const std::string& path : paths)
  {
    if (reader->CanReadFile(path.c_str()) == 0)
    {
      return MakeError(path, "it is not what its name says");
    }
    reader->SetFileName(path.c_str());
    ISOSURFACE_RETURN_IF_ERROR(RunReader(path, reader, [&] { reader->UpdateInformation(); }));
    std::array<int, 8> form{};
    std::copy_n(reader->GetDataExtent(), 6, form.begin());
    form[6] = reader->GetDataScalarType();
    form[7] = reader->GetNumberOfScalarComponents();
    first = path == paths.front() ? form : first;
    const std::string error = GetErrorKeeper()->TakeError();
    if (!error.empty() || form != first)
    {
      return Status(StatusCode::Corrupt,
        path + ": cannot be read: " +
          (error.empty() ? "its size or type differs from that of " + paths.front() : error));
    }
    isGrey = isGrey && HasGreyPalette(bitmap);
    names->InsertNextValue(path);
  }
  if (isGrey)
  {
    bitmap->SetAllow8BitBMP(1);
  }
  reader->SetFileNames(names);
  auto flip = vtkSmartPointer<vtkImageFlip>::New();
  flip->SetFilteredAxis(1);
  flip->SetInputConnection(reader->GetOutputPort());
  return vtkSmartPointer<vtkAlgorithm>(flip);
}

/// Every reader has at least a slice in memory: one that cannot be there is not asked for.
Status CheckSlice(const std::string& path, const int whole[6], std::uint64_t memory)
{
  double vertices = 1;
  for (int axis = 0; axis < 3; ++axis)
  {
    const double length = static_cast<double>(whole[2 * axis + 1]) - whole[2 * axis] + 1;
    if (length < 1)
    {
      return Status(StatusCode::Corrupt, path + ": cannot be read: it has no image data");
    }
    vertices *= axis < 2 ? length : 1;
  }
  return vertices <= static_cast<double>(memory)
    ? Status::Ok()
    : Status(StatusCode::OutOfMemory,
        path + ": cannot be read: a slice has " +
          std::to_string(static_cast<std::uint64_t>(vertices)) +
          " vertices, which the memory limit has no room for");
}

/// A source that gives VTK's message if the reader fails.
class ReaderSource : public PipelineSource
{
public:
  ReaderSource(vtkAlgorithm* reader, std::string path, const GridGeometry& grid,
    const std::vector<ArrayDescription>& arrays, bool withCells)
    : PipelineSource(
        reader->GetOutputPort(), reader->GetOutputInformation(0), grid, arrays, withCells)
    , Path(std::move(path))
    , Reader(reader)
  {
  }

  Result<BoxSamples> Read(const VertexBox& box) override
  {
    Result<BoxSamples> samples = BoxSamples();
    ISOSURFACE_RETURN_IF_ERROR(
      RunReader(this->Path, this->Reader, [&] { samples = PipelineSource::Read(box); }));
    const std::string error = GetErrorKeeper()->TakeError();
    if (!error.empty() || !samples.IsOk())
    {
      return Status(StatusCode::Corrupt,
        this->Path +
          ": cannot be read: " + (error.empty() ? samples.GetStatus().GetMessage() : error));
    }
    return samples;
  }

private:
  std::string Path;
  vtkAlgorithm* Reader;
};

/// The volume of the whole extent, or its first slice.
Result<WriterInput> Read(
  vtkAlgorithm* reader, const std::string& path, const int whole[6], bool isWhole, bool withCells)
{
  vtkNew<vtkInformationVector> requests;
  requests->SetNumberOfInformationObjects(1);
  vtkInformation* request = requests->GetInformationObject(0);
  request->Set(Pipeline::WHOLE_EXTENT(), whole, 6);
  PipelineSource::AskForFirstSlice(request, withCells);
  request->Remove(Pipeline::WHOLE_EXTENT());
  if (isWhole)
  {
    request->Set(Pipeline::UPDATE_EXTENT(), whole, 6);
  }
  ISOSURFACE_RETURN_IF_ERROR(RunReader(path, reader, [&] { reader->Update(0, requests); }));
  auto input = WriterInput::Take(reader->GetOutputDataObject(0));
  const std::string error = GetErrorKeeper()->TakeError();
  if (!error.empty())
  {
    return MakeError(path, error);
  }
  if (!input.IsOk())
  {
    return Status(
      StatusCode::Corrupt, path + ": cannot be read: " + input.GetStatus().GetMessage());
  }
  if (!input->Image || input->Image->GetNumberOfPoints() == 0)
  {
    return MakeError(path, "it has no image data");
  }
  return input;
}

/// The coordinates of a rectilinear grid of which a slice was read.
Status TakeLines(vtkAlgorithm* reader, const std::string& path, const WriterInput& slice,
  const int whole[6], InputVolume& volume)
{
  if (!slice.Lines)
  {
    return Status::Ok();
  }
  Result<GridLines> lines = GridLines();
  ISOSURFACE_RETURN_IF_ERROR(RunReader(path, reader,
    [&]
    {
      lines = slice.FindWholeLines(reader->GetOutputPort(), reader->GetOutputInformation(0), whole);
    }));
  const std::string error = GetErrorKeeper()->TakeError();
  const Status status =
    lines.IsOk() ? lines->Check(volume.Grid.GetDimensions()) : lines.GetStatus();
  if (!error.empty() || !status.IsOk())
  {
    return Status(StatusCode::Corrupt,
      path + ": cannot be read: " + (error.empty() ? status.GetMessage() : error));
  }
  volume.Lines = std::move(*lines);
  return Status::Ok();
}

/// Keeps the samples of the chosen arrays in memory, and releases all others.
Status TakeWhole(vtkImageData* image, const std::string& path, const int whole[6], bool withCells,
  InputVolume& volume)
{
  auto local = std::make_shared<LocalVolume>();
  local->WithCells = withCells;
  local->Grid = MakeGridGeometry(image, whole);
  const auto isWanted = [&volume](const std::string& name)
  {
    return std::any_of(volume.Arrays.begin(), volume.Arrays.end(),
      [&name](const ArrayDescription& array) { return array.Name == name; });
  };
  const Status status = local->CollectArrays(image, isWanted);
  if (!status.IsOk())
  {
    return Status(status.GetCode(), path + ": " + status.GetMessage());
  }
  const ArrayVariables variables(local->Arrays);
  auto owners = std::make_shared<std::vector<vtkSmartPointer<vtkDataArray>>>();
  VolumePiece piece;
  piece.Box = MakeVertexBox(local->Grid, image->GetExtent());
  for (const ArrayDescription& wanted : volume.Arrays)
  {
    for (std::size_t array = 0; array < local->Arrays.size(); ++array)
    {
      if (local->Arrays[array].Name == wanted.Name)
      {
        const auto first =
          local->Piece.Arrays.begin() + static_cast<std::ptrdiff_t>(variables.GetFirst(array));
        piece.Arrays.insert(piece.Arrays.end(), first, first + variables.GetComponents(array));
        owners->push_back(local->Owners[array]);
        break;
      }
    }
  }
  if (piece.Arrays.size() != ArrayVariables(volume.Arrays).GetNumberOfStored() ||
    piece.Box.GetSize() != local->Grid.GetDimensions())
  {
    return Status(
      StatusCode::Corrupt, path + ": cannot be read: its reader does not give all of it");
  }
  volume.Source = std::make_unique<MemorySource>(piece);
  volume.Owner = std::move(owners);
  return Status::Ok();
}

// Fills in the grid, the arrays and the time that a slice of the input has.
Status DescribeInput(const std::string& path, vtkImageData* slice, int whole[6],
  const std::vector<std::string>& arrays, bool withCells, InputVolume& volume)
{
  LocalVolume local;
  local.WithCells = withCells;
  local.Grid = MakeGridGeometry(slice, whole);
  const auto choice = ArrayChoice::Make(slice, nullptr, withCells);
  const Status status = choice.IsOk()
    ? local.CollectArrays(slice, [&](const std::string& name) { return choice->Has(name); })
    : choice.GetStatus();
  if (!status.IsOk())
  {
    return Status(status.GetCode(), path + ": " + status.GetMessage());
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto chosen, ChooseArrays(path, local.Arrays, arrays));
  volume.Grid = local.Grid;
  volume.Arrays = chosen;
  volume.LeftOut = arrays.empty() ? choice->LeftOut : "";
  volume.Time = FindTime(slice);
  return Status::Ok();
}

} // namespace

Result<InputVolume> OpenPipelineInput(const std::string& input, std::size_t step,
  const std::vector<std::string>& arrays, bool withCells, std::uint64_t wholeBytes)
{
  GetErrorKeeper();
  ISOSURFACE_ASSIGN_OR_RETURN(const auto files, PipelineFiles::Find(input, step));
  const bool isStack = files.Paths.size() > 1;
  const std::string& path = isStack ? input : files.Paths.front();
  if (!isStack && !GetLocalFileSystem().Exists(path))
  {
    return Status(StatusCode::NotFound, path + ": cannot open: No such file or directory");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(auto seen, SourceFiles::Find(GetLocalFileSystem(), files.Paths));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto made,
    isStack ? MakeStackReader(files.Paths)
            : Result<vtkSmartPointer<vtkAlgorithm>>(MakeReaderOf(path)));
  const vtkSmartPointer<vtkAlgorithm>& reader = made;
  if (!reader)
  {
    return Status(StatusCode::Unsupported,
      path + ": no reader knows this kind of file; --dimensions is for samples without a header");
  }
  ISOSURFACE_RETURN_IF_ERROR(RunReader(path, reader, [&] { reader->UpdateInformation(); }));
  vtkInformation* information = reader->GetOutputInformation(0);
  if (!information || !information->Has(Pipeline::WHOLE_EXTENT()))
  {
    return MakeError(path, "it has no image data");
  }
  int whole[6];
  information->Get(Pipeline::WHOLE_EXTENT(), whole);
  ISOSURFACE_RETURN_IF_ERROR(CheckSlice(path, whole, 4 * wholeBytes));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto slice, Read(reader, path, whole, false, withCells));
  InputVolume volume;
  volume.Files = std::move(seen);
  ISOSURFACE_RETURN_IF_ERROR(DescribeInput(path, slice.Image, whole, arrays, withCells, volume));
  ISOSURFACE_RETURN_IF_ERROR(TakeLines(reader, path, slice, whole, volume));
  volume.LeftOut += (volume.LeftOut.empty() || files.LeftOut.empty() ? "" : "; ") + files.LeftOut;
  if (files.Steps > 1)
  {
    volume.Times.resize(files.Steps);
    std::iota(volume.Times.begin(), volume.Times.end(), 0.0);
    volume.Time = static_cast<double>(step);
  }
  auto source = std::make_unique<ReaderSource>(reader, path, volume.Grid, volume.Arrays, withCells);
  const std::uint64_t bytes = source->GetReadBytes(source->GetBox());
  if (bytes > wholeBytes)
  {
    volume.Source = std::move(source);
    volume.Owner = std::make_shared<vtkSmartPointer<vtkAlgorithm>>(reader);
    return volume;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto all, Read(reader, path, whole, true, withCells));
  ISOSURFACE_RETURN_IF_ERROR(TakeWhole(all.Image, path, whole, withCells, volume));
  volume.HeldBytes = bytes;
  return volume;
}

} // namespace isosurface
