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
  MemoryImage image{ own, described.Lines, false, {}, {} };
  if (image.Lines)
  {
    ISOSURFACE_RETURN_IF_ERROR(image.Lines->Check(own.GetDimensions()));
  }
  if (piece.whole)
  {
    image.Declare(piece.whole);
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
  query.Request = images.Request.Surfaces;
  query.Request.GlobalIds = true;
  query.Request.Attributes = GetLayouts(images.Arrays);
  for (std::size_t number = 0; number < query.Samples.Pieces.size(); ++number)
  {
    MemoryPiece& piece = query.Samples.Pieces[number];
    const SampleView scalars = piece.Components.front();
    for (std::size_t attribute = 0; attribute < request.attribute_count; ++attribute)
    {
      piece.AddAttribute({ ViewArray(
        images.Pieces[grids.Images[number]], request.attributes[attribute], scalars.Available) });
    }
  }
  return query;
}

/// Tells the block of each point, if there are several.
void AddBlocks(const MemoryQuery& query, const CollectedGrids& grids, OwnedSurface& surface)
{
  if (grids.Paths.size() < 2)
  {
    return;
  }
  surface.OfPoints = query.FindBlocks(surface.Owned, grids.Blocks);
  surface.Paths = grids.Paths;
  for (const std::vector<std::int64_t>& path : surface.Paths)
  {
    surface.Blocks.push_back({ path.size(), path.data() });
  }
  surface.block_count = surface.Blocks.size();
  surface.blocks = surface.Blocks.data();
  surface.block_ids = surface.OfPoints.data();
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
      const Status extracted = images->Field.Extract(ranks, 0, outcome);
      const Status status = ranks.Agree(ChooseIslands(
        ranks, extracted, wanted.Islands,
        [&] { return images->Field.MakeQuery(0).MakeIslandGrids(ranks); }, wanted.Threads,
        outcome));
      const MemoryQuery query = images->Field.MakeQuery(0);
      images->Field.Release();
      ISOSURFACE_RETURN_IF_ERROR(status);
      std::vector<std::string> names;
      for (const InterpolatedArray& array : taken.Arrays)
      {
        names.push_back(array.Name);
      }
      auto made = std::make_unique<OwnedSurface>(std::move(outcome.Extracted), wanted.Normals,
        wanted.GlobalIds, std::move(names), 0, std::move(outcome.Islands));
      AddBlocks(query, *grids, *made);
      return Give(std::move(made), surface);
    });
}
