// SPDX-License-Identifier: BSD-3-Clause
#include "Interface/SurfaceHandle.h"

#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/SampleCopy.h"
#include "Ranks/Query/MemoryField.h"
#include "Surface/Contour/InterpolatedArray.h"
#include "Surface/Pieces/CollectedGrids.h"

#include <algorithm>
#include <mutex>
#include <utility>

using namespace isosurface;

struct si_images
{
  std::mutex Mutex;
  MemoryField Field;
};

namespace isosurface
{
namespace
{

constexpr const char* TheImages = "the images";

/// What a rank has of images, and what is asked of them.
struct TakenImages
{
  si_surface_request Given{};
  TakenRequest Request;
  int Choice = 0; ///< of components, as MemoryQuery has it
  std::vector<si_piece> Pieces;
  MemoryImages Images;
  std::vector<InterpolatedArray> Arrays; ///< attributes of each piece
};

ValueType TypeOf(const si_array& array)
{
  return static_cast<ValueType>(array.type);
}

std::vector<SampleView> ViewArray(const si_piece& piece, std::size_t number, const VertexBox& box)
{
  const si_array& array = piece.arrays[number];
  std::vector<SampleView> views;
  for (int component = 0; component < array.components; ++component)
  {
    const auto* first = static_cast<const std::uint8_t*>(piece.samples[number]) +
      static_cast<std::size_t>(component) * GetValueSize(TypeOf(array));
    views.push_back(MakeSampleView(TypeOf(array), box, first, array.components));
  }
  return views;
}

/// The samples of a piece as vertices of a grid.
MemoryPiece PlacePiece(
  const si_piece& piece, const GridGeometry& own, std::size_t contoured, const GridGeometry& grid)
{
  VertexBox all;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    all.Low[axis] = own.Extent[2 * axis] - grid.Extent[2 * axis];
    all.High[axis] = own.Extent[2 * axis + 1] - grid.Extent[2 * axis] + 1;
  }
  VertexBox inside = all;
  for (std::size_t axis = 0; piece.own && axis < 3; ++axis)
  {
    inside.Low[axis] = all.Low[axis] + piece.own[2 * axis];
    inside.High[axis] = std::min(all.High[axis], all.Low[axis] + piece.own[2 * axis + 1]);
  }
  MemoryPiece made;
  made.Components = ViewArray(piece, contoured, all);
  for (SampleView& view : made.Components)
  {
    view.Box = inside;
  }
  constexpr std::uint8_t anyBit = 0xff;
  made.Hidden = { all, piece.hidden_cells, anyBit, piece.hidden_vertices, anyBit };
  Fingerprint identity;
  identity.AddNumber(reinterpret_cast<std::uintptr_t>(piece.samples[contoured]));
  identity.AddNumber(piece.identity);
  made.Identity = identity.Get();
  return made;
}

/// Whether a piece has the arrays, and the same ones to interpolate as the others.
Status CheckArrays(const si_piece& piece, TakenImages& images)
{
  const si_surface_request& request = images.Given;
  const auto isThere = [&piece](std::size_t number)
  {
    return number < piece.array_count && piece.samples[number] && piece.arrays[number].type >= 0 &&
      piece.arrays[number].type <= SI_FLOAT64 && piece.arrays[number].components > 0;
  };
  const std::size_t* const end = request.attributes + request.attribute_count;
  const bool areThere =
    isThere(request.scalar.array) && std::all_of(request.attributes, end, isThere);
  const int components = areThere ? piece.arrays[request.scalar.array].components : 0;
  if (request.scalar.component < SI_MAGNITUDE || request.scalar.component >= components)
  {
    return { StatusCode::InvalidArgument, "a piece has no such array, or no such component" };
  }
  const int choice =
    request.scalar.component == SI_MAGNITUDE ? components : request.scalar.component;
  std::vector<InterpolatedArray> arrays;
  for (std::size_t number = 0; number < request.attribute_count; ++number)
  {
    const si_array& array = piece.arrays[request.attributes[number]];
    arrays.push_back({ ToText(array.name), {}, { TypeOf(array), array.components } });
  }
  if (images.Pieces.empty())
  {
    images.Arrays = std::move(arrays);
    images.Choice = choice;
    return Status::Ok();
  }
  return arrays == images.Arrays && choice == images.Choice
    ? Status::Ok()
    : Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
}

Status TakePiece(const si_piece* given, TakenImages& images)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto piece, TakeStructure(given, "si_piece"));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto described, TakeGrid(piece.grid));
  ISOSURFACE_RETURN_IF_ERROR(CheckArrays(piece, images));
  const GridGeometry& own = described.Grid;
  MemoryImage image{ own, described.Lines, piece.whole != nullptr, {}, {} };
  if (image.Lines)
  {
    ISOSURFACE_RETURN_IF_ERROR(image.Lines->Check(own.GetDimensions()));
  }
  // What lines there are beyond the pieces is not known.
  for (std::size_t axis = 0; piece.whole && !image.Lines && axis < 3; ++axis)
  {
    std::int64_t& low = image.Grid.Extent[2 * axis];
    std::int64_t& high = image.Grid.Extent[2 * axis + 1];
    low = std::min(low, piece.whole[2 * axis]);
    high = std::max(high, piece.whole[2 * axis + 1]);
  }
  image.Block.assign(piece.block.numbers, piece.block.numbers + piece.block.count);
  image.MakePiece = [piece, own, contoured = images.Given.scalar.array](const GridGeometry& grid)
  { return Result<MemoryPiece>(PlacePiece(piece, own, contoured, grid)); };
  images.Pieces.push_back(piece);
  images.Images.Images.push_back(std::move(image));
  return Status::Ok();
}

Status TakeImages(std::size_t count, const si_piece* const* pieces, const si_surface_request* given,
  Call& call, TakenImages& images)
{
  ISOSURFACE_ASSIGN_OR_RETURN(images.Given, TakeStructure(given, "si_surface_request"));
  ISOSURFACE_ASSIGN_OR_RETURN(images.Request, TakeRequest(images.Given, call));
  for (std::size_t number = 0; number < count; ++number)
  {
    ISOSURFACE_RETURN_IF_ERROR(TakePiece(pieces[number], images));
  }
  images.Images.AreThere = count > 0;
  return Status::Ok();
}

MemoryQuery MakeImageQuery(const TakenImages& images, const CollectedGrids& grids)
{
  const si_surface_request& request = images.Given;
  MemoryQuery query;
  query.Samples = grids;
  query.Component = images.Choice;
  query.Region = images.Request.Surfaces.Where;
  query.Threads = images.Request.Surfaces.Threads;
  query.Request = MakeContourRequest(images.Request.Surfaces);
  query.Request.GlobalIds = true;
  for (const InterpolatedArray& array : images.Arrays)
  {
    query.Request.Attributes.push_back(array.Layout);
  }
  for (std::size_t number = 0; number < query.Samples.Pieces.size(); ++number)
  {
    MemoryPiece& piece = query.Samples.Pieces[number];
    const SampleView& scalars = piece.Components.front();
    for (std::size_t attribute = 0; attribute < request.attribute_count; ++attribute)
    {
      AttributeView view{ ViewArray(
        images.Pieces[grids.Images[number]], request.attributes[attribute], scalars.Available) };
      for (SampleView& component : view.Components)
      {
        component.Box = scalars.Box;
      }
      piece.Attributes.push_back(std::move(view));
    }
  }
  return query;
}

/// Tells the block of each point, if there are several.
void AddBlocks(
  const std::vector<std::int64_t>& firstIds, const CollectedGrids& grids, OwnedSurface& surface)
{
  if (grids.Paths.size() < 2)
  {
    return;
  }
  const std::int64_t* const ids = surface.Owned.GlobalIds.GetData();
  for (std::size_t point = 0; point < surface.point_count; ++point)
  {
    const auto next = std::upper_bound(firstIds.begin(), firstIds.end(), ids[point]);
    const auto grid = static_cast<std::size_t>(next - firstIds.begin() - 1);
    surface.OfPoints.push_back(static_cast<std::int32_t>(grids.Blocks[grid]));
  }
  surface.Paths = grids.Paths;
  for (const std::vector<std::int64_t>& path : surface.Paths)
  {
    surface.Blocks.push_back({ path.size(), path.data() });
  }
  surface.block_count = surface.Blocks.size();
  surface.blocks = surface.Blocks.data();
  surface.block_ids = surface.OfPoints.data();
}

/// Extracts the surface of this rank's pieces. Collective; the error may be this rank's alone.
Status ExtractImages(Communicator& ranks, MemoryField& field, const SurfaceRequest& request,
  ExtractionOutcome& outcome, ChosenIslands& islands)
{
  const Status extracted = field.Extract(ranks, 0, outcome);
  return request.Islands ? ChooseIslands(
                             ranks, extracted, *request.Islands,
                             [&] { return field.MakeQuery(0).MakeIslandGrids(ranks); },
                             request.Threads, outcome.Extracted, islands)
                         : ranks.Agree(extracted);
}

} // namespace
} // namespace isosurface

si_result si_images_create(si_images** images)
{
  return RunCall(TheImages, nullptr,
    [&](Call&) -> Status { return Give(std::make_unique<si_images>(), images); });
}

void si_images_free(si_images* images)
{
  delete images;
}

si_result si_images_extract(si_images* images, size_t count, const si_piece* const* pieces,
  const si_surface_request* request, const si_run* run, si_surface** surface)
{
  return RunCall(TheImages, run,
    [&](Call& call) -> Status
    {
      const std::lock_guard<std::mutex> lock(images->Mutex);
      Communicator& ranks = call.GetRanks();
      TakenImages taken;
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(
        ranks, TheImages, [&] { return TakeImages(count, pieces, request, call, taken); }));
      SurfaceRequest& wanted = taken.Request.Surfaces;
      wanted.Threads = call.ShareThreads();
      const auto grids = CollectedGrids::Collect(
        ranks, [&] { return Result<MemoryImages>(taken.Images); }, wanted.Threads);
      ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(grids.GetStatus()));
      ISOSURFACE_RETURN_IF_ERROR(AttemptOnAll(ranks, TheImages,
        [&]
        {
          images->Field.Ask(MakeImageQuery(taken, *grids), call.GetProgress());
          return Status::Ok();
        }));
      ExtractionOutcome outcome;
      ChosenIslands islands;
      const Status status = ExtractImages(ranks, images->Field, wanted, outcome, islands);
      const std::vector<std::int64_t> firstIds = images->Field.MakeQuery(0).FindFirstIds();
      images->Field.Release();
      ISOSURFACE_RETURN_IF_ERROR(status);
      std::vector<std::string> names;
      for (const InterpolatedArray& array : taken.Arrays)
      {
        names.push_back(array.Name);
      }
      auto made = std::make_unique<OwnedSurface>(std::move(outcome.Extracted), wanted.Normals,
        wanted.GlobalIds, std::move(names), 0, std::move(islands));
      AddBlocks(firstIds, *grids, *made);
      return Give(std::move(made), surface);
    });
}
