// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/SurfaceHandle.h"

#include "Coding/Meshes/SurfaceMeshes.h"
#include "Formats/Files/SurfaceFile.h"

#include <limits>
#include <utility>

using namespace isosurface;

namespace isosurface
{

OwnedSurface::OwnedSurface(Surface surface, bool hasNormals, bool hasGlobalIds,
  std::vector<std::string> names, int chosen, ChosenIslands found)
  : si_surface{}
  , Owned(std::move(surface))
  , Names(std::move(names))
  , Islands(std::move(found.Ids))
{
  Surface& made = this->Owned;
  this->size = sizeof(si_surface);
  this->point_count = made.NumberOfPoints;
  this->triangle_count = made.NumberOfCells;
  this->point_type = made.HasDoublePoints ? SI_FLOAT64 : SI_FLOAT32;
  this->points = made.HasDoublePoints ? static_cast<void*>(made.DoublePoints.GetData())
                                      : static_cast<void*>(made.Points.GetData());
  IndexArray& numbers = made.Connectivity;
  this->corner_type = numbers.Is64Bit ? SI_INT64 : SI_INT32;
  this->corners = numbers.Is64Bit ? static_cast<void*>(numbers.Values64.GetData())
                                  : static_cast<void*>(numbers.Values32.GetData());
  this->normals = hasNormals ? made.Normals.GetData() : nullptr;
  this->global_ids = hasGlobalIds ? made.GlobalIds.GetData() : nullptr;
  for (const SurfacePart& part : made.Parts)
  {
    this->Isovalues.push_back(part.Isovalue);
    this->FirstPoints.push_back(static_cast<std::int64_t>(part.FirstPoint));
    this->FirstTriangles.push_back(static_cast<std::int64_t>(part.FirstCell));
  }
  this->FirstPoints.push_back(static_cast<std::int64_t>(this->point_count));
  this->FirstTriangles.push_back(static_cast<std::int64_t>(this->triangle_count));
  this->part_count = this->Isovalues.size();
  this->isovalues = this->Isovalues.data();
  this->first_points = this->FirstPoints.data();
  this->first_triangles = this->FirstTriangles.data();
  for (std::size_t number = 0; number < made.Attributes.size(); ++number)
  {
    SurfaceAttribute& attribute = made.Attributes[number];
    this->Values.push_back({ this->Names[number].c_str(),
      static_cast<std::int32_t>(GetInterpolatedType(attribute.Layout.Type)),
      attribute.Layout.NumberOfComponents, attribute.Bytes.GetData() });
  }
  this->attribute_count = this->Values.size();
  this->attributes = this->Values.data();
  this->level = static_cast<std::size_t>(chosen);
  const auto give = [](auto& buffer) -> const void*
  { return buffer.IsEmpty() ? nullptr : buffer.GetData(); };
  this->offsets = made.Offsets.Is64Bit ? give(made.Offsets.Values64) : give(made.Offsets.Values32);
  this->island_ids = this->Islands.IsEmpty() ? nullptr : this->Islands.GetData();
  for (const IsovalueIslands& one : found.OfIsovalues)
  {
    this->Counts.push_back({ one.Islands, one.KeptIslands, one.Triangles, one.KeptTriangles });
  }
  this->islands = this->Counts.empty() ? nullptr : this->Counts.data();
}

namespace
{

struct OwnedBoxes : si_boxes
{
  explicit OwnedBoxes(const std::vector<VertexBox>& found)
    : si_boxes{}
  {
    for (const VertexBox& box : found)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        this->Ends.push_back(box.Low[axis]);
        this->Ends.push_back(box.High[axis]);
      }
    }
    this->size = sizeof(si_boxes);
    this->count = found.size();
    this->boxes = this->Ends.data();
  }

  std::vector<std::int64_t> Ends;
};

} // namespace

Result<TakenRequest> TakeRequest(const si_surface_request& taken, Call& call)
{
  TakenRequest made;
  SurfaceRequest& request = made.Surfaces;
  if (taken.isovalue_count == 0 || !taken.isovalues)
  {
    return Status(StatusCode::InvalidArgument, "there is no isovalue");
  }
  const bool areKnown =
    (taken.points == 0 || taken.points == SI_FLOAT32 || taken.points == SI_FLOAT64) &&
    taken.island_size >= SI_BY_TRIANGLES && taken.island_size <= SI_BY_VOLUME;
  if (!areKnown)
  {
    return Status(StatusCode::InvalidArgument,
      "si_surface_request: there is no such type of points, or no such size of islands");
  }
  request.Isovalues.assign(taken.isovalues, taken.isovalues + taken.isovalue_count);
  if (taken.region)
  {
    std::array<double, 6> bounds{};
    std::copy(taken.region, taken.region + bounds.size(), bounds.begin());
    request.Where = Region::FromBounds(bounds);
    request.Bounds = bounds;
  }
  std::vector<HalfSpace> halfSpaces(taken.half_spaces ? taken.half_space_count : 0);
  for (std::size_t number = 0; number < halfSpaces.size(); ++number)
  {
    const double* const numbers = taken.half_spaces + 4 * number;
    std::copy(numbers, numbers + 3, halfSpaces[number].Normal.begin());
    halfSpaces[number].Offset = numbers[3];
  }
  request.Where = request.Where.Intersect(Region(std::move(halfSpaces)));
  MatchVtk(taken.vtk_version, request);
  request.Polygons = taken.polygons != 0;
  request.SkipNotANumber = taken.skip_not_a_number != 0;
  request.Normals = taken.normals != 0;
  request.GlobalIds = taken.global_ids != 0;
  request.Precision = taken.points == SI_FLOAT32 ? PointPrecision::Single
    : taken.points == SI_FLOAT64                 ? PointPrecision::Double
                                                 : PointPrecision::Default;
  request.DropDegenerateTriangles = taken.drop_degenerate_triangles != 0;
  if (taken.closed != 0)
  {
    request.Close(taken.closed < 0);
  }
  if (taken.minimum_island > 0 || taken.maximum_islands > 0 || taken.island_point ||
    taken.island_ids != 0)
  {
    request.Islands.emplace();
    request.Islands->Size = static_cast<IslandSize>(taken.island_size);
    request.Islands->MinimumSize = taken.minimum_island;
    request.Islands->MaximumIslands = taken.maximum_islands;
    request.Islands->Ids = taken.island_ids != 0;
    if (taken.island_point)
    {
      request.Islands->Place.emplace();
      std::copy(taken.island_point, taken.island_point + 3, request.Islands->Place->begin());
    }
  }
  request.Budget = { taken.maximum_seconds, taken.maximum_triangles };
  request.Ranks = &call.GetRanks();
  return made;
}

namespace
{

Result<TakenRequest> TakeRequest(
  const si_volume& volume, const si_surface_request* given, Call& call)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(given, "si_surface_request"));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto samples, volume.Find(taken.scalar));
  ISOSURFACE_ASSIGN_OR_RETURN(auto made, TakeRequest(taken, call));
  made.Samples = samples;
  made.Surfaces.Arrays.assign(taken.attributes, taken.attributes + taken.attribute_count);
  for (const std::size_t array : made.Surfaces.Arrays)
  {
    ISOSURFACE_RETURN_IF_ERROR(volume.Check(array, 0, 0));
    made.Names.emplace_back(volume.Arrays[array].name);
  }
  return made;
}

/// Takes the request, agrees with the other ranks that it makes sense, and runs the work.
template <typename Work>
si_result RunRequest(
  si_volume* volume, const si_surface_request* request, const si_run* run, const Work& work)
{
  return RunOn(volume, run,
    [&](Call& call) -> Status
    {
      auto taken = TakeRequest(*volume, request, call);
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(taken.GetStatus()));
      return work(call, *taken);
    });
}

} // namespace
} // namespace isosurface

struct si_surface_file
{
  explicit si_surface_file(std::shared_ptr<SurfaceFile> opened)
    : File(std::move(opened))
  {
    const EdgeIndexHeader& header = this->File->GetHeader();
    for (const InterpolatedArray& array : this->File->GetArrays())
    {
      this->Attributes.push_back(array.Name);
    }
    for (const std::string& name : this->Attributes)
    {
      this->Names.push_back(name.c_str());
    }
    this->Info.size = sizeof(this->Info);
    this->Info.isovalue_count = header.Isovalues.size();
    this->Info.isovalues = header.Isovalues.data();
    this->Info.array = header.Array.c_str();
    this->Info.source = header.Source.c_str();
    this->Info.time = header.Time.value_or(std::numeric_limits<double>::quiet_NaN());
    this->Info.length_unit = GetLengthUnitName(header.Geometry.Unit);
    this->Info.attribute_count = this->Names.size();
    this->Info.attributes = this->Names.data();
    this->Info.has_preview = header.PreviewLevel > 0 ? 1 : 0;
    this->Info.missing = this->File->GetMissing().c_str();
  }
  si_surface_file(const si_surface_file&) = delete;
  si_surface_file& operator=(const si_surface_file&) = delete;

  const std::shared_ptr<SurfaceFile> File;
  std::vector<std::string> Attributes;
  std::vector<const char*> Names;
  si_surface_file_info Info{};
};

si_result si_volume_estimate(
  si_volume* volume, const si_surface_request* request, const si_run* run, double* triangles)
{
  return RunRequest(volume, request, run,
    [&](Call& call, const TakenRequest& taken) -> Status
    {
      const auto estimated =
        EstimateTriangles(*volume->File, taken.Samples, taken.Surfaces, call.GetProgress());
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(estimated.GetStatus()));
      *triangles = *estimated;
      return Status::Ok();
    });
}

si_result si_volume_find_blocks(
  si_volume* volume, const si_surface_request* request, const si_run* run, si_boxes** boxes)
{
  return RunRequest(volume, request, run,
    [&](Call& call, const TakenRequest& taken) -> Status
    {
      std::string warning;
      const auto found =
        FindActiveBlocks(*volume->File, taken.Samples, taken.Surfaces, call.GetProgress(), warning);
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(found.GetStatus()));
      call.Warn(warning);
      return Give(std::make_unique<OwnedBoxes>(*found), boxes);
    });
}

void si_boxes_free(si_boxes* boxes)
{
  delete static_cast<OwnedBoxes*>(boxes);
}

si_result si_volume_extract(
  si_volume* volume, const si_surface_request* request, const si_run* run, si_surface** surface)
{
  return RunRequest(volume, request, run,
    [&](Call& call, TakenRequest& taken) -> Status
    {
      std::string warning;
      int level = 0;
      ChosenIslands islands;
      taken.Surfaces.Threads = call.ShareThreads();
      ISOSURFACE_ASSIGN_OR_RETURN(auto made,
        ExtractSurface(*volume->File, taken.Samples, taken.Surfaces, call.GetProgress(), warning,
          &level, &islands));
      call.Warn(warning);
      return Give(std::make_unique<OwnedSurface>(std::move(made), taken.Surfaces.Normals,
                    taken.Surfaces.GlobalIds, taken.Names, level, std::move(islands)),
        surface);
    });
}

void si_surface_free(si_surface* surface)
{
  delete static_cast<OwnedSurface*>(surface);
}

si_result si_surface_save(const si_surface* surface, const char* path, const char* name,
  const char* length_unit, const si_run* run)
{
  return RunCall(ToText(path), run,
    [&](Call&) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto unit, TakeUnit(length_unit));
      EdgeIndexHeader header;
      header.Array = ToText(name);
      header.Isovalues.assign(surface->isovalues, surface->isovalues + surface->part_count);
      return SaveSurface(GetLocalFileSystem(), static_cast<const OwnedSurface*>(surface)->Owned,
        surface->normals != nullptr, header,
        GetMeters(unit == LengthUnit::Unknown ? LengthUnit::Millimeter : unit), ToText(path));
    });
}

si_result si_volume_write_surface(si_volume* volume, const si_surface_request* request,
  const char* path, const si_coding* coding, const si_run* run)
{
  return RunRequest(volume, request, run,
    [&](Call& call, const TakenRequest& taken) -> Status
    {
      const auto given = TakeStructure(coding, "si_coding");
      ISOSURFACE_RETURN_IF_ERROR(call.GetRanks().Agree(given.GetStatus()));
      const auto orUsual = [](double number, double usual) { return number > 0 ? number : usual; };
      const bool isMode = given->mode >= SI_LOSSLESS && given->mode <= SI_SMALLEST &&
        (given->profile == 0 || given->profile == 3);
      if (!isMode)
      {
        return { StatusCode::InvalidArgument, "si_coding: there is no such mode, or profile" };
      }
      constexpr double usualNormalError = 0.005;
      BlockCoding coded;
      coded.Settings.Mode = static_cast<EdgeIndexMode>(given->mode);
      coded.Settings.MaximumError = orUsual(given->maximum_error, coded.Settings.MaximumError);
      coded.Settings.Profile = static_cast<EdgeIndexProfile>(given->profile);
      coded.Settings.QuantizationBits =
        given->quantization_bits != 0 ? given->quantization_bits : coded.Settings.QuantizationBits;
      coded.PreviewLevel = given->preview_level;
      coded.ArrayError = given->array_error;
      coded.NormalError =
        given->normal_error < 0 ? 0 : orUsual(given->normal_error, usualNormalError);
      EdgeIndexWriteJob::Settings settings;
      settings.MemoryBytes = given->memory != 0 ? given->memory : settings.MemoryBytes;
      settings.Threads = call.ShareThreads();
      settings.Warn = [&call](const std::string& warning) { call.Warn(warning); };
      return WriteSurface(*volume->File, taken.Samples, taken.Surfaces, ToText(path), coded,
        settings, call.GetProgress());
    });
}

si_result si_surface_file_open(const char* path, const si_run* run, si_surface_file** file)
{
  return RunCall(ToText(path), run,
    [&](Call&) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(auto opened, SurfaceFile::Open(ToText(path)));
      return Give(std::make_unique<si_surface_file>(std::move(opened)), file);
    });
}

void si_surface_file_close(si_surface_file* file)
{
  delete file;
}

const si_surface_file_info* si_surface_file_describe(const si_surface_file* file)
{
  return &file->Info;
}

si_result si_surface_file_read(si_surface_file* file, size_t isovalue_count,
  const size_t* isovalues, int preview, int normals, const si_run* run, si_surface** surface)
{
  return RunCall(file->File->GetPath(), run,
    [&](Call& call) -> Status
    {
      const std::vector<std::size_t> numbers(isovalues, isovalues + isovalue_count);
      const bool areThere = std::all_of(numbers.begin(), numbers.end(),
        [file](std::size_t number) { return number < file->Info.isovalue_count; });
      if (!areThere || (preview != 0 && file->Info.has_preview == 0))
      {
        return { StatusCode::InvalidArgument, file->File->GetPath() + ": has no such surface" };
      }
      EdgeIndexSelection selection;
      selection.Isovalues = numbers;
      selection.Preview = preview != 0;
      ISOSURFACE_ASSIGN_OR_RETURN(auto made,
        file->File->Read(selection, {}, normals != 0, call.CountThreads(), call.GetProgress()));
      return Give(std::make_unique<OwnedSurface>(std::move(made), normals != 0, false,
                    preview != 0 ? std::vector<std::string>() : file->Attributes, 0),
        surface);
    });
}

si_result si_surface_file_read_piece(
  si_surface_file* file, const si_surface_reading* reading, const si_run* run, si_surface** surface)
{
  return RunCall(file->File->GetPath(), run,
    [&](Call& call) -> Status
    {
      ISOSURFACE_ASSIGN_OR_RETURN(const auto taken, TakeStructure(reading, "si_surface_reading"));
      EdgeIndexSelection selection;
      selection.Preview = taken.preview != 0;
      selection.Piece = taken.piece;
      selection.NumberOfPieces = std::max(taken.piece_count, 1);
      const bool isThere = taken.piece >= 0 && taken.piece < selection.NumberOfPieces &&
        (!selection.Preview || file->Info.has_preview != 0);
      if (!isThere)
      {
        return { StatusCode::InvalidArgument, file->File->GetPath() + ": has no such surface" };
      }
      if (taken.region)
      {
        std::array<double, 6> bounds{};
        std::copy(taken.region, taken.region + bounds.size(), bounds.begin());
        selection.Box = file->File->FindVertices(bounds);
      }
      ContourRequest request;
      MatchVtk(taken.vtk_version, request);
      request.GlobalIds = taken.global_ids != 0;
      ISOSURFACE_ASSIGN_OR_RETURN(auto made,
        file->File->Read(
          selection, request, taken.normals != 0, call.CountThreads(), call.GetProgress()));
      return Give(
        std::make_unique<OwnedSurface>(std::move(made), taken.normals != 0, request.GlobalIds,
          selection.Preview ? std::vector<std::string>() : file->Attributes, 0),
        surface);
    });
}
