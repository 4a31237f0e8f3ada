// SPDX-License-Identifier: BSD-3-Clause
// The extension module scalable_isosurface._core: Core and Formats as the modules beside it use
// them. _core.pyi has its signatures. Vertices are x, y, z here; the modules turn them into NumPy's
// order.
#include "PythonErrors.h"
#include "SurfaceArrays.h"
#include "VolumeWriting.h"

#include "Formats/Files/SurfaceFile.h"
#include "Formats/Files/SurfaceQueries.h"
#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ground/Base/Communicator.h"
#include "Ground/Base/ParallelFor.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace isosurface
{
namespace
{

int CountThreads(int wanted)
{
  return wanted > 0 ? wanted : ChooseThreadCount(1);
}

//------------------------------------------------------------------------------
// Opening

/// What a name is of: "blocked volume", "edge index" or "source".
std::string FindKind(const std::string& name)
{
  const auto kind = FindFileKind(name);
  ThrowIfError(kind.GetStatus());
  return *kind == FileKind::BlockedVolume ? "blocked volume"
    : *kind == FileKind::Surface          ? "edge index"
                                          : "source";
}

std::shared_ptr<VolumeFile> OpenVolume(
  const std::string& path, const std::string& axes, const std::string& folder, int threads)
{
  return RunWithoutGil(path,
    [&](const Progress&) {
      return VolumeFile::Open(path, { axes, folder, threads });
    });
}

/// Writes the index of a source. Gives what of it is left out.
std::string WriteIndex(const std::string& path, const std::string& axes, const std::string& folder,
  std::uint64_t memoryBytes, int threads)
{
  return RunWithoutGil(path,
    [&](const Progress& progress) -> Result<std::string>
    {
      FileSystem& files = GetLocalFileSystem();
      const SourceIndex index = SourceIndex::Find(files, path, "", axes, folder);
      ISOSURFACE_ASSIGN_OR_RETURN(const auto state, FindIndexState(files, index));
      if (state != IndexState::Current)
      {
        SerialCommunicator alone;
        return WriteSourceIndex(
          alone, files, index, memoryBytes, progress, nullptr, nullptr, threads);
      }
      return std::string();
    });
}

/// The names of what is in a file of another format; none if it has one volume.
std::vector<std::string> ListDatasets(const std::string& path)
{
  const auto listed = RunWithoutGil(path,
    [&](const Progress&) -> Result<std::vector<VolumeListing>>
    {
      auto list = ListForeignVolumes(GetLocalFileSystem(), path);
      return list.GetStatus().GetCode() == StatusCode::Unsupported ? std::vector<VolumeListing>()
                                                                   : std::move(list);
    });
  std::vector<std::string> names;
  for (const VolumeListing& one : listed)
  {
    names.push_back(one.Name);
  }
  return names;
}

/// The attributes of a dataset of another format: an object of JSON, or "".
std::string ReadAttributes(const std::string& path, const std::string& axes)
{
  return RunWithoutGil(path,
    [&](const Progress&) -> Result<std::string>
    {
      VolumeChoice choice;
      choice.Axes = axes;
      choice.WantsAttributes = true;
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto opened, OpenForeignVolume(GetLocalFileSystem(), path, choice));
      return std::move(opened.Attributes);
    });
}

//------------------------------------------------------------------------------
// Volumes

/// Name, type, components and unit.
std::vector<std::tuple<std::string, std::string, int, std::string>> ListArrays(
  const VolumeFile& file)
{
  std::vector<std::tuple<std::string, std::string, int, std::string>> arrays;
  for (const ArrayDescription& array : file.GetArrays())
  {
    arrays.emplace_back(array.Name, GetValueTypeName(array.Type), array.Components, array.Unit);
  }
  return arrays;
}

py::tuple DescribeLevel(const VolumeFile& file, int level)
{
  const LevelDescription description = file.Describe(level);
  const GridGeometry& grid = description.Grid;
  std::array<double, 3> first = grid.Origin;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double place = grid.Spacing[axis] * static_cast<double>(grid.Extent[2 * axis]);
    for (std::size_t row = 0; row < 3; ++row)
    {
      first[row] += grid.Direction[3 * row + axis] * place;
    }
  }
  std::optional<std::array<std::vector<double>, 3>> lines;
  if (description.Lines)
  {
    lines = description.Lines->Coordinates;
  }
  return py::make_tuple(grid.GetDimensions(), grid.Spacing, first, grid.Direction, lines,
    description.Chunk, GetLengthUnitName(grid.Unit));
}

void ReadSamples(VolumeFile& file, py::array& samples, std::size_t array,
  const std::vector<int>& components, std::size_t timeStep, int level, const Index3& low,
  const Index3& high, const Index3& step, int threads)
{
  SampleRequest request;
  request.Array = array;
  request.Components = components;
  request.TimeStep = timeStep;
  request.Level = level;
  request.Box = { low, high };
  request.Step = step;
  request.Threads = CountThreads(threads);
  void* const memory = samples.mutable_data();
  RunWithoutGil(
    file.GetPath(), [&](const Progress& progress) { return file.Read(request, memory, progress); });
}

py::dict MakeSpectrum(
  VolumeFile& file, std::size_t array, int component, std::size_t timeStep, int level)
{
  const auto spectrum = RunWithoutGil(file.GetPath(),
    [&](const Progress& progress) {
      return ReadSpectrum(file, { array, component, timeStep, level }, progress);
    });
  const auto bins = static_cast<py::ssize_t>(spectrum->Bins.Count);
  py::array_t<double> isovalues(bins);
  for (py::ssize_t bin = 0; bin < bins; ++bin)
  {
    isovalues.mutable_data()[bin] = spectrum->Bins.GetEdge(static_cast<std::size_t>(bin));
  }
  const auto copy = [](const WorkloadSpectrum::Counts& counts) -> py::object
  {
    return counts.empty()
      ? py::object(py::none())
      : py::array_t<std::uint64_t>(static_cast<py::ssize_t>(counts.size()), counts.data());
  };
  const auto scale = [](const WorkloadSpectrum::Counts& counts, double unit) -> py::object
  {
    if (counts.empty())
    {
      return py::none();
    }
    py::array_t<double> scaled(static_cast<py::ssize_t>(counts.size()));
    for (std::size_t bin = 0; bin < counts.size(); ++bin)
    {
      scaled.mutable_data()[bin] = static_cast<double>(counts[bin]) * unit;
    }
    return scaled;
  };
  py::dict arrays;
  arrays["isovalues"] = isovalues;
  arrays["triangles"] = copy(spectrum->Triangles);
  arrays["cells"] = copy(spectrum->ActiveCells);
  arrays["blocks"] = copy(spectrum->ActiveBlocks);
  arrays["bytes"] = copy(spectrum->Bytes);
  arrays["area"] = scale(spectrum->Area, spectrum->AreaUnit);
  arrays["volume"] = scale(spectrum->Volume, spectrum->VolumeUnit);
  return arrays;
}

/// The vertices of active blocks: number, axis (z, y, x), ends [low, high).
py::array_t<std::int64_t> MakeActiveBlocks(VolumeFile& file, std::size_t array, int component,
  std::size_t timeStep, int level, const std::vector<double>& isovalues,
  const std::optional<std::array<double, 6>>& bounds)
{
  SurfaceRequest request;
  request.Isovalues = isovalues;
  request.Bounds = bounds;
  std::string warning;
  const ContouredSamples samples{ array, component, timeStep, level };
  const auto boxes = RunWithoutGil(file.GetPath(),
    [&](const Progress& progress)
    { return FindActiveBlocks(file, samples, request, progress, warning); });
  Warn(warning);
  py::array_t<std::int64_t> result({ boxes.size(), std::size_t{ 3 }, std::size_t{ 2 } });
  auto ends = result.mutable_unchecked<3>();
  for (std::size_t box = 0; box < boxes.size(); ++box)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      ends(static_cast<py::ssize_t>(box), static_cast<py::ssize_t>(axis), 0) =
        boxes[box].Low[2 - axis];
      ends(static_cast<py::ssize_t>(box), static_cast<py::ssize_t>(axis), 1) =
        boxes[box].High[2 - axis];
    }
  }
  return result;
}

py::dict MakeIsosurface(VolumeFile& file, std::size_t array, int component, std::size_t timeStep,
  int level, const std::vector<double>& isovalues,
  const std::optional<std::array<double, 6>>& bounds, bool normals,
  const std::vector<std::size_t>& attributes, int precision,
  const std::tuple<bool, bool, bool>& closing,
  const std::optional<std::tuple<int, double, std::uint64_t>>& islands, int threads)
{
  SurfaceRequest request;
  request.Isovalues = isovalues;
  request.Bounds = bounds;
  request.Normals = normals;
  request.Precision = static_cast<PointPrecision>(precision);
  request.Attributes = attributes;
  const auto [isClosed, isBelow, dropsDegenerates] = closing;
  if (isClosed)
  {
    request.ClosedSides = GridSides::All();
    request.ClosedSides.AreBeyondInside = isBelow;
  }
  request.DropDegenerateTriangles = isClosed || dropsDegenerates;
  if (islands)
  {
    request.Islands.emplace();
    request.Islands->Size = static_cast<IslandSize>(std::get<0>(*islands));
    request.Islands->MinimumSize = std::get<1>(*islands);
    request.Islands->MaximumIslands = std::get<2>(*islands);
    request.Islands->Level = level;
  }
  request.Threads = CountThreads(threads);
  std::string warning;
  const ContouredSamples samples{ array, component, timeStep, level };
  auto surface = RunWithoutGil(file.GetPath(),
    [&](const Progress& progress)
    { return ExtractSurface(file, samples, request, progress, warning); });
  Warn(warning);
  std::vector<std::string> names;
  names.reserve(attributes.size());
  for (const std::size_t attribute : attributes)
  {
    names.push_back(file.GetArrays()[attribute].Name);
  }
  return MakeSurfaceArrays(std::move(surface), normals, names);
}

//------------------------------------------------------------------------------
// Edge-index files

std::shared_ptr<SurfaceFile> OpenSurface(const std::string& path)
{
  return RunWithoutGil(path, [&](const Progress&) { return SurfaceFile::Open(path); });
}

py::dict ReadSurface(const SurfaceFile& file, const std::vector<std::size_t>& isovalues,
  bool preview, bool normals, int threads)
{
  auto surface = RunWithoutGil(file.GetPath(),
    [&](const Progress& progress)
    { return file.Read(isovalues, preview, normals, CountThreads(threads), progress); });
  return MakeSurfaceArrays(
    std::move(surface), normals, preview ? std::vector<std::string>() : file.GetAttributes());
}

//------------------------------------------------------------------------------
// Writing

/// The names of all types of samples.
std::vector<std::string> ListValueTypes()
{
  std::vector<std::string> names;
  std::uint8_t number = 0;
  while (const char* name = GetValueTypeName(static_cast<ValueType>(number)))
  {
    names.emplace_back(name);
    ++number;
  }
  return names;
}

VolumeWriting MakeWriting(const std::string& path, const Index3& dimensions,
  const std::array<double, 3>& spacing, const std::array<double, 3>& origin,
  const std::array<double, 9>& direction,
  const std::optional<std::array<std::vector<double>, 3>>& lines, const std::string& unit)
{
  VolumeWriting writing;
  writing.Grid.Unit = FindLengthUnit(unit);
  if (writing.Grid.Unit == LengthUnit::Unknown && !unit.empty())
  {
    throw py::value_error(
      "length_unit: " + unit + " is no unit of length, as m, mm, um, nm or inch");
  }
  writing.Path = path;
  writing.Grid.Origin = origin;
  writing.Grid.Spacing = spacing;
  writing.Grid.Direction = direction;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    writing.Grid.Extent[2 * axis] = 0;
    writing.Grid.Extent[2 * axis + 1] = dimensions[axis] - 1;
  }
  if (lines)
  {
    writing.Settings.Lines = GridLines{ *lines };
  }
  return writing;
}

void SetSettings(VolumeWriting& writing, int blockSize, std::uint32_t stores,
  std::uint32_t replicas, const std::string& codec, int codecLevel, std::optional<double> time,
  bool append, std::uint64_t memoryBytes, int threads)
{
  BlockedVolumeSettings& settings = writing.Settings;
  const auto found = FindCodec(codec);
  settings.Compression = { found.value_or(SegmentCodec::None), codecLevel };
  if (!found || !settings.Compression.IsValid())
  {
    throw py::value_error("compression is not none, lz4, lz4:1 to lz4:12, zstd or zstd:1 to "
                          "zstd:19");
  }
  settings.BlockSize = blockSize;
  settings.NumberOfStores = stores;
  settings.NumberOfReplicas = replicas;
  settings.Time = time;
  settings.Append = append;
  settings.MemoryLimit = memoryBytes;
  settings.Threads = CountThreads(threads);
}

void WriteArrayLikes(const VolumeWriting& writing,
  const std::vector<
    std::vector<std::tuple<std::string, py::object, std::string, int, std::string>>>& steps,
  const std::vector<std::optional<double>>& times, const std::optional<Index3>& chunk)
{
  std::vector<std::vector<ArrayLike>> likes(steps.size());
  std::vector<ArrayDescription> descriptions;
  for (std::size_t step = 0; step < steps.size(); ++step)
  {
    for (const auto& [name, object, type, components, unit] : steps[step])
    {
      likes[step].push_back({ object, FindValueType(type).value(), components });
      if (step == 0)
      {
        descriptions.push_back({ name, likes[step].back().Type, components, unit });
      }
    }
  }
  writing.WriteArrays(descriptions, likes, times, chunk);
}

} // namespace
} // namespace isosurface

PYBIND11_MODULE(_core, module)
{
  using namespace isosurface;
  using namespace pybind11::literals;

  WatchForks();
  module.attr("MAGNITUDE") = Variable::Magnitude;
  module.attr("VALUE_TYPES") = ListValueTypes();
  module.def("find_kind", &FindKind, "name"_a);
  module.def("open_volume", &OpenVolume, "path"_a, "axes"_a, "folder"_a, "threads"_a);
  module.def("open_surface", &OpenSurface, "path"_a);
  module.def("list_datasets", &ListDatasets, "path"_a);
  module.def("read_attributes", &ReadAttributes, "path"_a, "axes"_a);
  module.def("write_index", &WriteIndex, "path"_a, "axes"_a, "folder"_a, "memory"_a, "threads"_a);

  py::class_<VolumeFile, std::shared_ptr<VolumeFile>>(module, "VolumeFile")
    .def_property_readonly("path", [](const VolumeFile& file) { return py::bytes(file.GetPath()); })
    .def_property_readonly("arrays", &ListArrays)
    .def_property_readonly("times", &VolumeFile::GetTimes)
    .def_property_readonly("levels", &VolumeFile::GetNumberOfLevels)
    .def_property_readonly("left_out", &VolumeFile::GetLeftOut)
    .def("describe", &DescribeLevel, "level"_a)
    .def("read", &ReadSamples, "samples"_a, "array"_a, "components"_a, "step"_a, "level"_a, "low"_a,
      "high"_a, "stride"_a, "threads"_a)
    .def("spectrum", &MakeSpectrum, "array"_a, "component"_a, "step"_a, "level"_a)
    .def("active_blocks", &MakeActiveBlocks, "array"_a, "component"_a, "step"_a, "level"_a,
      "isovalues"_a, "bounds"_a)
    .def("isosurface", &MakeIsosurface, "array"_a, "component"_a, "step"_a, "level"_a,
      "isovalues"_a, "bounds"_a, "normals"_a, "attributes"_a, "precision"_a, "closing"_a,
      "islands"_a, "threads"_a);

  py::class_<SurfaceFile, std::shared_ptr<SurfaceFile>>(module, "SurfaceFile")
    .def_property_readonly("missing", &SurfaceFile::GetMissing)
    .def_property_readonly("attributes", &SurfaceFile::GetAttributes)
    .def_property_readonly(
      "isovalues", [](const SurfaceFile& file) { return file.GetHeader().Isovalues; })
    .def_property_readonly("array", [](const SurfaceFile& file) { return file.GetHeader().Array; })
    .def_property_readonly(
      "source", [](const SurfaceFile& file) { return file.GetHeader().Source; })
    .def_property_readonly("time", [](const SurfaceFile& file) { return file.GetHeader().Time; })
    .def_property_readonly("length_unit",
      [](const SurfaceFile& file) { return GetLengthUnitName(file.GetHeader().Geometry.Unit); })
    .def_property_readonly(
      "has_preview", [](const SurfaceFile& file) { return file.GetHeader().PreviewLevel > 0; })
    .def("read", &ReadSurface, "isovalues"_a, "preview"_a, "normals"_a, "threads"_a);

  py::class_<VolumeWriting>(module, "VolumeWriting")
    .def(py::init(&MakeWriting), "path"_a, "dimensions"_a, "spacing"_a, "origin"_a, "direction"_a,
      "lines"_a, "length_unit"_a)
    .def("set", &SetSettings, "block_size"_a, "stores"_a, "replicas"_a, "codec"_a, "codec_level"_a,
      "time"_a, "append"_a, "memory"_a, "threads"_a)
    .def("write_arrays", &WriteArrayLikes, "steps"_a, "times"_a, "chunk"_a)
    .def("write_file", &VolumeWriting::WriteFile, "file"_a, "times"_a);
}
