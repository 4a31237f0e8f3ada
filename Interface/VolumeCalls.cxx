// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/VolumeHandle.h"

#include "Formats/Files/SampleQueries.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Spectrum/IsovalueProposal.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

using namespace isosurface;

OwnedGrid::OwnedGrid(LevelDescription description)
  : si_grid{}
  , Owned(std::move(description))
{
  const GridGeometry& grid = this->Owned.Grid;
  this->size = sizeof(si_grid);
  const Index3 vertices = grid.GetDimensions();
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    this->dimensions[axis] = vertices[axis];
    this->spacing[axis] = grid.Spacing[axis];
    this->origin[axis] = grid.Origin[axis];
    this->chunk[axis] = this->Owned.Chunk[axis];
    this->first[axis] = grid.Extent[2 * axis];
    this->zero[axis] = grid.Origin[axis];
    this->lines[axis] = this->Owned.Lines ? this->Owned.Lines->Coordinates[axis].data() : nullptr;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const double place = grid.Spacing[axis] * static_cast<double>(grid.Extent[2 * axis]);
    for (std::size_t row = 0; row < 3; ++row)
    {
      this->origin[row] += grid.Direction[3 * row + axis] * place;
    }
  }
  std::copy(grid.Direction.begin(), grid.Direction.end(), this->direction);
  this->length_unit = GetLengthUnitName(grid.Unit);
}

si_volume::si_volume(std::shared_ptr<VolumeFile> file)
  : File(std::move(file))
  , LeftOut(this->File->GetLeftOut())
{
  for (const ArrayDescription& array : this->File->GetArrays())
  {
    this->Arrays.push_back({ array.Name.c_str(), static_cast<std::int32_t>(array.Type),
      array.Components, array.Unit.c_str() });
  }
  for (const std::optional<double>& time : this->File->GetTimes())
  {
    this->Times.push_back(time.value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  this->Info.size = sizeof(this->Info);
  this->Info.path = this->File->GetPath().c_str();
  this->Info.array_count = this->Arrays.size();
  this->Info.arrays = this->Arrays.data();
  this->Info.step_count = this->Times.size();
  this->Info.times = this->Times.data();
  this->Info.level_count = static_cast<std::size_t>(this->File->GetNumberOfLevels());
  this->Info.left_out = this->LeftOut.c_str();
  this->Grids.resize(this->Info.level_count);
}

Status si_volume::Check(std::size_t array, std::size_t step, std::size_t level) const
{
  const char* const missing = array >= this->Arrays.size() ? "array"
    : step >= this->Times.size()                           ? "time step"
    : level >= this->Info.level_count                      ? "level"
                                                           : nullptr;
  return missing
    ? Status(StatusCode::InvalidArgument, this->File->GetPath() + ": has no such " + missing)
    : Status::Ok();
}

Result<ContouredSamples> si_volume::Find(const si_scalar& scalar) const
{
  ISOSURFACE_RETURN_IF_ERROR(this->Check(scalar.array, scalar.step, scalar.level));
  const bool isThere =
    scalar.component >= SI_MAGNITUDE && scalar.component < this->Arrays[scalar.array].components;
  if (!isThere)
  {
    return Status(StatusCode::InvalidArgument, this->File->GetPath() + ": has no such component");
  }
  return ContouredSamples{ scalar.array, scalar.component, scalar.step,
    static_cast<int>(scalar.level) };
}

namespace isosurface
{

Result<LengthUnit> TakeUnit(const char* name)
{
  const LengthUnit unit = FindLengthUnit(ToText(name));
  if (unit == LengthUnit::Unknown && !ToText(name).empty())
  {
    return Status(StatusCode::InvalidArgument,
      "length_unit: " + ToText(name) + " is no unit of length, as m, mm, um, nm or inch");
  }
  return unit;
}

Result<LevelDescription> TakeGrid(const si_grid* given)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(given, "si_grid"));
  LevelDescription made;
  GridGeometry& grid = made.Grid;
  ISOSURFACE_ASSIGN_OR_RETURN(grid.Unit, TakeUnit(taken.length_unit));
  std::copy(std::begin(taken.direction), std::end(taken.direction), grid.Direction.begin());
  std::copy(std::begin(taken.spacing), std::end(taken.spacing), grid.Spacing.begin());
  std::copy(std::begin(taken.origin), std::end(taken.origin), grid.Origin.begin());
  std::copy(std::begin(taken.chunk), std::end(taken.chunk), made.Chunk.begin());
  const bool isMoved = std::any_of(std::begin(taken.first), std::end(taken.first),
    [](std::int64_t number) { return number != 0; });
  if (isMoved)
  {
    std::copy(std::begin(taken.zero), std::end(taken.zero), grid.Origin.begin());
  }
  const bool isLined = taken.lines[0] && taken.lines[1] && taken.lines[2];
  made.Lines = isLined ? std::optional<GridLines>(GridLines()) : std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    if (taken.dimensions[axis] < 1)
    {
      return Status(StatusCode::InvalidArgument, "si_grid: dimensions are at least 1");
    }
    grid.Extent[2 * axis] = taken.first[axis];
    grid.Extent[2 * axis + 1] = taken.first[axis] + taken.dimensions[axis] - 1;
    if (isLined)
    {
      made.Lines->Coordinates[axis].assign(
        taken.lines[axis], taken.lines[axis] + taken.dimensions[axis]);
    }
  }
  return made;
}

Result<OpeningChoice> TakeOpening(const si_opening* given)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(given, "si_opening"));
  OpeningChoice choice;
  choice.Axes = ToText(taken.axes);
  choice.IndexFolder = ToText(taken.index_folder);
  choice.HasLocalStores = taken.local_stores != 0;
  const auto three = [](const double* numbers)
  {
    return numbers ? std::optional<std::array<double, 3>>({ numbers[0], numbers[1], numbers[2] })
                   : std::nullopt;
  };
  choice.Place.Spacing = three(taken.spacing);
  choice.Place.Origin = three(taken.origin);
  if (taken.region)
  {
    choice.Bounds.emplace();
    std::copy_n(taken.region, choice.Bounds->size(), choice.Bounds->begin());
  }
  if (taken.length_unit)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(choice.Place.Unit, TakeUnit(taken.length_unit));
  }
  return choice;
}

namespace
{

struct OwnedTexts : si_texts
{
  explicit OwnedTexts(std::vector<std::string> owned)
    : si_texts{}
    , Owned(std::move(owned))
  {
    for (const std::string& text : this->Owned)
    {
      this->Pointers.push_back(text.c_str());
    }
    this->size = sizeof(si_texts);
    this->count = this->Pointers.size();
    this->texts = this->Pointers.data();
  }

  const std::vector<std::string> Owned;
  std::vector<const char*> Pointers;
};

struct OwnedSlice : si_slice
{
  explicit OwnedSlice(SampledBox cut)
    : si_slice{}
    , Cut(std::move(cut))
    , Grid({ this->Cut.Plan.Grid, std::nullopt, this->Cut.Plan.Grid.GetDimensions() })
  {
    this->size = sizeof(si_slice);
    this->grid = &this->Grid;
    this->level = static_cast<std::size_t>(this->Cut.Plan.Level);
    this->values = this->Cut.Values.front().GetData();
    this->inside = this->Cut.IsInside.data();
  }

  SampledBox Cut;
  const OwnedGrid Grid;
};

struct OwnedSpectrum : si_spectrum
{
  explicit OwnedSpectrum(std::shared_ptr<const WorkloadSpectrum> spectrum)
    : si_spectrum{}
    , Owned(std::move(spectrum))
    , Area(this->Owned->Scale(this->Owned->Area))
    , Volume(this->Owned->Scale(this->Owned->Volume))
    , Isovalues(this->Owned->Bins.GetEdges())
  {
    const auto give = [](const auto& values) { return values.empty() ? nullptr : values.data(); };
    this->size = sizeof(si_spectrum);
    this->count = this->Isovalues.size();
    this->isovalues = this->Isovalues.data();
    this->triangles = give(this->Owned->Triangles);
    this->cells = give(this->Owned->ActiveCells);
    this->blocks = give(this->Owned->ActiveBlocks);
    this->bytes = give(this->Owned->Bytes);
    this->area = give(this->Area);
    this->volume = give(this->Volume);
  }

  const std::shared_ptr<const WorkloadSpectrum> Owned;
  const std::vector<double> Area;
  const std::vector<double> Volume;
  const std::vector<double> Isovalues;
};

/// What a box asks for; all of it must be in the volume, and have `bytes`.
Result<SampleRequest> TakeBox(si_volume& volume, const si_box* given, std::size_t bytes)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(given, "si_box"));
  ISOSURFACE_RETURN_IF_ERROR(volume.Check(taken.array, taken.step, taken.level));
  const si_array& array = volume.Arrays[taken.array];
  const si_grid& grid = *si_volume_grid(&volume, taken.level);
  SampleRequest request;
  request.Array = taken.array;
  request.TimeStep = taken.step;
  request.Level = static_cast<int>(taken.level);
  std::uint64_t vertices = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    request.Step[axis] = taken.stride[axis] == 0 ? 1 : taken.stride[axis];
    request.Box.Low[axis] = taken.low[axis];
    request.Box.High[axis] = taken.high[axis];
    if (taken.low[axis] < 0 || taken.high[axis] <= taken.low[axis] ||
      taken.high[axis] > grid.dimensions[axis] || request.Step[axis] < 1)
    {
      return Status(
        StatusCode::InvalidArgument, volume.File->GetPath() + ": has no such box, or it is empty");
    }
    vertices *=
      static_cast<std::uint64_t>((taken.high[axis] - taken.low[axis] - 1) / request.Step[axis] + 1);
  }
  request.Components.resize(static_cast<std::size_t>(array.components));
  std::iota(request.Components.begin(), request.Components.end(), 0);
  if (taken.component_count > 0)
  {
    request.Components.assign(taken.components, taken.components + taken.component_count);
  }
  const bool areThere = std::all_of(request.Components.begin(), request.Components.end(),
    [&](int component) { return component >= 0 && component < array.components; });
  const std::uint64_t needed =
    vertices * request.Components.size() * GetValueSize(static_cast<ValueType>(array.type));
  return areThere && needed == bytes
    ? Result<SampleRequest>(std::move(request))
    : Status(StatusCode::InvalidArgument,
        volume.File->GetPath() + ": " +
          (areThere ? "the box has " + std::to_string(needed) + " bytes of samples, and not " +
                std::to_string(bytes)
                    : "has no such component"));
}

/// The array of a scalar, for samples.
Result<SampledArray> TakeSampled(const si_volume& volume, const si_scalar* scalar, Call& call)
{
  const si_scalar first{};
  const si_scalar& taken = scalar ? *scalar : first;
  ISOSURFACE_RETURN_IF_ERROR(volume.Check(taken.array, taken.step, taken.level));
  return SampledArray{ taken.array, taken.step, static_cast<int>(taken.level),
    call.CountThreads() };
}

} // namespace
} // namespace isosurface

const char* si_type_name(int32_t type)
{
  return type >= 0 && type <= SI_FLOAT64 ? GetValueTypeName(static_cast<ValueType>(type)) : nullptr;
}

si_result si_find_kind(const char* name, int32_t* kind)
{
  return RunCall(ToText(name), nullptr,
    [&](Call&) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto found, FindFileKind(ToText(name)));
      *kind = static_cast<int32_t>(found);
      return Status::Ok();
    });
}

void si_texts_free(si_texts* texts)
{
  delete static_cast<OwnedTexts*>(texts);
}

si_result si_list_datasets(const char* name, const si_run* run, si_texts** datasets)
{
  return RunCall(ToText(name), run,
    [&](Call&) -> Status
    {
      const auto listed = ListForeignVolumes(GetLocalFileSystem(), ToText(name));
      std::vector<std::string> names;
      if (listed.IsOk())
      {
        std::transform(listed->begin(), listed->end(), std::back_inserter(names),
          [](const VolumeListing& one) { return one.Name; });
      }
      else if (listed.GetStatus().GetCode() != StatusCode::Unsupported)
      {
        return listed.GetStatus();
      }
      return Give(std::make_unique<OwnedTexts>(std::move(names)), datasets);
    });
}

si_result si_read_attributes(const char* name, const char* axes, const si_run* run, si_texts** json)
{
  return RunCall(ToText(name), run,
    [&](Call&) -> Status
    {
      VolumeChoice choice;
      choice.Axes = ToText(axes);
      choice.WantsAttributes = true;
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto opened, OpenForeignVolume(GetLocalFileSystem(), ToText(name), choice));
      return Give(
        std::make_unique<OwnedTexts>(std::vector<std::string>{ opened.Attributes }), json);
    });
}

si_result si_volume_open(
  const char* name, const si_opening* opening, const si_run* run, si_volume** volume)
{
  return RunCall(ToText(name), run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto choice, TakeOpening(opening));
      choice.Threads = call.GetThreads();
      ISOSURFACE_ASSIGN_OR_RETURN(auto file, VolumeFile::Open(ToText(name), choice));
      return Give(std::make_unique<si_volume>(std::move(file)), volume);
    });
}

void si_volume_close(si_volume* volume)
{
  delete volume;
}

const si_volume_info* si_volume_describe(const si_volume* volume)
{
  return &volume->Info;
}

const si_grid* si_volume_grid(si_volume* volume, size_t level)
{
  return GetOrNull(
    [&]() -> const si_grid*
    {
      if (EndCall(volume->Check(0, 0, level)) != SI_OK)
      {
        return nullptr;
      }
      const std::lock_guard<std::mutex> lock(volume->Mutex);
      std::unique_ptr<OwnedGrid>& grid = volume->Grids[level];
      if (!grid)
      {
        grid = std::make_unique<OwnedGrid>(volume->File->Describe(static_cast<int>(level)));
      }
      return grid.get();
    });
}

si_result si_volume_read(
  si_volume* volume, const si_box* box, void* samples, size_t bytes, const si_run* run)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto request, TakeBox(*volume, box, bytes));
      request.Threads = call.CountThreads();
      return volume->File->Read(request, samples, call.GetProgress());
    });
}

si_result si_volume_range(
  si_volume* volume, const si_scalar* scalar, const si_run* run, double range[2])
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, volume->Find(scalar ? *scalar : si_scalar{}));
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto found, ReadRange(*volume->File, samples, call.GetProgress()));
      std::copy(found.begin(), found.end(), range);
      return Status::Ok();
    });
}

si_result si_volume_probe(si_volume* volume, const si_scalar* scalar, int nearest, size_t count,
  const double* points, void* values, uint8_t* inside, const si_run* run)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto of, TakeSampled(*volume, scalar, call));
      return ProbePoints(*volume->File, of,
        nearest != 0 ? Interpolation::Nearest : Interpolation::Linear, points, count, values,
        inside, call.GetProgress());
    });
}

si_result si_volume_slice(si_volume* volume, const si_scalar* scalar, const double origin[3],
  const double normal[3], double most_points, const si_run* run, si_slice** slice)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto of, TakeSampled(*volume, scalar, call));
      const Plane plane{ { origin[0], origin[1], origin[2] }, { normal[0], normal[1], normal[2] } };
      const double length = std::hypot(normal[0], normal[1], normal[2]);
      if (!(length > 0) || !std::isfinite(length + origin[0] + origin[1] + origin[2]))
      {
        return { StatusCode::InvalidArgument, volume->File->GetPath() + ": this is no plane" };
      }
      ISOSURFACE_ASSIGN_OR_RETURN(auto cut,
        CutPlane(*volume->File, of, plane, most_points > 1 ? most_points : PlaneLattice::Unlimited,
          call.GetProgress()));
      return Give(cut ? std::make_unique<OwnedSlice>(std::move(*cut)) : nullptr, slice);
    });
}

void si_slice_free(si_slice* slice)
{
  delete static_cast<OwnedSlice*>(slice);
}

si_result si_volume_spectrum(
  si_volume* volume, const si_scalar* scalar, const si_run* run, si_spectrum** spectrum)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, volume->Find(scalar ? *scalar : si_scalar{}));
      ISOSURFACE_ASSIGN_OR_RETURN(
        auto found, ReadSpectrum(*volume->File, samples, call.GetProgress()));
      return Give(std::make_unique<OwnedSpectrum>(std::move(found)), spectrum);
    });
}

si_result si_volume_propose(
  si_volume* volume, const si_scalar* scalar, const si_run* run, double* isovalue)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, volume->Find(scalar ? *scalar : si_scalar{}));
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto found, ReadSpectrum(*volume->File, samples, call.GetProgress()));
      *isovalue = ProposeIsovalue(*found).value_or(std::numeric_limits<double>::quiet_NaN());
      return Status::Ok();
    });
}

void si_spectrum_free(si_spectrum* spectrum)
{
  delete static_cast<OwnedSpectrum*>(spectrum);
}
