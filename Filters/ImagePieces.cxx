// SPDX-License-Identifier: BSD-3-Clause
#include "ImagePieces.h"

#include "PassingFilters.h"
#include "RectilinearGrids.h"

#include "vtkAlgorithm.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataArray.h"
#include "vtkDataSet.h"
#include "vtkExecutive.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationExecutivePortKey.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include "Ground/Base/Coding.h"
#include "Ground/Base/Fingerprint.h"
#include "Ground/Volume/GridUnion.h"
#include "ImageSamples.h"
#include "Surface/Pieces/PieceFields.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

using BlockPath = std::vector<std::int64_t>;

struct Leaf
{
  vtkImageData* Image;
  vtkSmartPointer<vtkImageData> Owner; ///< if the image stands for a rectilinear grid
  vtkDataArray* Array;
  GridGeometry
    Grid; ///< with the extent of this leaf alone, or of what it is declared to be a part of
  std::optional<GridLines> Lines;
  BlockPath Block;
  bool IsDeclared = false; ///< whether it is declared to be a part of that
};

/// Calls visit(data, path) for the leaves of a tree of datasets, until it returns an error. The
/// partitions of a block have one path.
template <typename Visit>
Status VisitLeaves(vtkDataObject* data, BlockPath& path, const Visit& visit)
{
  const auto step = [&](std::int64_t number, vtkDataObject* child)
  {
    path.push_back(number);
    const Status status = VisitLeaves(child, path, visit);
    path.pop_back();
    return status;
  };
  if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < blocks->GetNumberOfBlocks(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(step(n, blocks->GetBlock(n)));
    }
  }
  else if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < collection->GetNumberOfPartitionedDataSets(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(step(n, collection->GetPartitionedDataSet(n)));
    }
  }
  else if (auto* partitions = vtkPartitionedDataSet::SafeDownCast(data))
  {
    for (unsigned int n = 0; n < partitions->GetNumberOfPartitions(); ++n)
    {
      ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(partitions->GetPartitionAsDataObject(n), path, visit));
    }
  }
  else if (auto* composite = vtkCompositeDataSet::SafeDownCast(data))
  {
    const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
    {
      ISOSURFACE_RETURN_IF_ERROR(
        step(iterator->GetCurrentFlatIndex(), iterator->GetCurrentDataObject()));
    }
  }
  else if (data)
  {
    return visit(data, path);
  }
  return Status::Ok();
}

/// The names on the way to a block.
std::string FindBlockName(vtkDataObject* data, const BlockPath& path)
{
  std::string name;
  for (const std::int64_t step : path)
  {
    const auto number = static_cast<unsigned int>(step);
    vtkInformation* info = nullptr;
    if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(data))
    {
      info = blocks->HasMetaData(number) ? blocks->GetMetaData(number) : nullptr;
      data = blocks->GetBlock(number);
    }
    else if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(data))
    {
      info = collection->HasMetaData(number) ? collection->GetMetaData(number) : nullptr;
      data = collection->GetPartitionedDataSet(number);
    }
    const char* own = info ? info->Get(vtkCompositeDataSet::NAME()) : nullptr;
    name += own ? (name.empty() ? "" : "/") + std::string(own) : "";
  }
  return name;
}

Result<std::vector<Leaf>> FindImages(vtkDataObject* input)
{
  std::vector<Leaf> images;
  const auto add = [&images](vtkDataObject* data, const BlockPath& block)
  {
    auto* set = vtkDataSet::SafeDownCast(data);
    auto* lined = vtkRectilinearGrid::SafeDownCast(data);
    auto* image = vtkImageData::SafeDownCast(data);
    if (!image && !lined)
    {
      return Status(StatusCode::InvalidArgument,
        std::string("the input has a ") + data->GetClassName() +
          ", but only image data and rectilinear grids can be contoured here: take Contour, or put "
          "Resample To Image in front");
    }
    if (set->GetNumberOfPoints() == 0)
    {
      return Status::Ok();
    }
    Leaf leaf{ image, nullptr, nullptr, {}, {}, block };
    if (lined)
    {
      leaf.Owner = MakeStructuredImage(lined);
      leaf.Image = leaf.Owner;
      leaf.Lines = MakeGridLines(lined);
      ISOSURFACE_RETURN_IF_ERROR(
        leaf.Lines->Check(MakeGridGeometry(leaf.Image, leaf.Image->GetExtent()).GetDimensions()));
    }
    images.push_back(std::move(leaf));
    return Status::Ok();
  };
  BlockPath path;
  ISOSURFACE_RETURN_IF_ERROR(VisitLeaves(input, path, add));
  return images;
}

Status CollectLeaves(vtkDataObject* input, vtkInformation* inputInfo,
  const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray, std::vector<Leaf>& leaves,
  std::size_t& numberOfImages)
{
  ISOSURFACE_ASSIGN_OR_RETURN(std::vector<Leaf> images, FindImages(input));
  numberOfImages = images.size();
  for (Leaf& leaf : images)
  {
    vtkImageData* image = leaf.Image;
    ISOSURFACE_ASSIGN_OR_RETURN(vtkDataArray * array, findArray(image));
    if (!array)
    {
      continue;
    }
    int extent[6];
    image->GetExtent(extent);
    int whole[6];
    bool hasWhole = FindWholeExtent(image, whole);
    if (image == input && inputInfo->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()))
    {
      inputInfo->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), whole);
      hasWhole = true;
    }
    // What lines there are beyond the pieces is not known.
    if (hasWhole && !leaf.Lines)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        extent[2 * axis] = std::min(extent[2 * axis], whole[2 * axis]);
        extent[2 * axis + 1] = std::max(extent[2 * axis + 1], whole[2 * axis + 1]);
      }
    }
    leaf.IsDeclared = hasWhole;
    leaf.Array = array;
    leaf.Grid = MakeGridGeometry(image, extent);
    leaves.push_back(std::move(leaf));
  }
  return Status::Ok();
}

// The grids of leaves.
void FindLeafGrids(
  const std::vector<Leaf>& leaves, std::vector<GridGeometry>& images, std::vector<LinedGrid>& lined)
{
  for (const Leaf& leaf : leaves)
  {
    if (leaf.Lines)
    {
      lined.push_back({ leaf.Grid, *leaf.Lines });
    }
    else
    {
      images.push_back(leaf.Grid);
    }
  }
}

// What each rank tells of its leaves: whether it has images, and the grids of the leaves.
Message DescribeLeaves(const std::vector<Leaf>& leaves, std::size_t numberOfImages)
{
  std::vector<GridGeometry> grids;
  std::vector<LinedGrid> lined;
  FindLeafGrids(leaves, grids, lined);
  const Message images = PackGrids(grids);
  Message message;
  AppendVarint(message, numberOfImages > 0 ? 1 : 0);
  AppendVarint(message, images.size());
  message.insert(message.end(), images.begin(), images.end());
  const Message others = PackLinedGrids(lined);
  message.insert(message.end(), others.begin(), others.end());
  return message;
}

// The samples of leaves, in the grids of all ranks: images first; one piece a leaf. `told`: what the ranks
// tell of their leaves, of which those of rank `own` are given.
Status AddPieces(vtkInformation* inputInfo, const std::vector<Leaf>& leaves,
  const std::vector<Message>& told, std::size_t own, ImagePieces& pieces)
{
  bool areImages = false;
  std::vector<Message> ofImages;
  std::vector<Message> ofLined;
  for (const Message& message : told)
  {
    ByteReader reader(message);
    areImages = reader.ReadVarint() > 0 || areImages;
    const auto size = static_cast<std::size_t>(reader.ReadVarint());
    const auto begin = message.end() - static_cast<std::ptrdiff_t>(reader.GetRemaining());
    const auto end = begin + static_cast<std::ptrdiff_t>(size);
    ofImages.emplace_back(begin, end);
    ofLined.emplace_back(end, message.end());
  }
  pieces.Grids = UniteGrids(ofImages);
  const std::size_t images = pieces.Grids.size();
  std::vector<std::size_t> linedNumbers;
  pieces.Lines.resize(images);
  for (LinedGrid& grid : UniteLinedGrids(ofLined, own, linedNumbers))
  {
    pieces.Grids.push_back(grid.Grid);
    pieces.Lines.emplace_back(std::move(grid.Lines));
  }
  if (areImages && pieces.Grids.empty())
  {
    return { StatusCode::NotFound, "the input has no such point array" };
  }
  std::size_t next = 0;
  for (const Leaf& leaf : leaves)
  {
    const std::size_t grid =
      leaf.Lines ? images + linedNumbers[next++] : FindGrid(pieces.Grids, leaf.Grid);
    ISOSURFACE_ASSIGN_OR_RETURN(
      auto samples, MakeImageSamples(pieces.Grids[grid], leaf.Image, leaf.Array));
    const vtkMTimeType time = FindImageTime(inputInfo, leaf.Image);
    Fingerprint identity;
    identity.AddNumber(reinterpret_cast<std::uintptr_t>(samples.Array.Get()));
    identity.AddNumber(std::max(time, samples.Array->GetMTime()));
    pieces.Sources.push_back({ leaf.Image, leaf.Owner, time });
    pieces.Pieces.push_back({ grid, std::move(samples.Components), samples.Hidden, {},
      identity.Get(), std::make_shared<vtkSmartPointer<vtkDataArray>>(samples.Array) });
  }
  return Status::Ok();
}

std::vector<FieldPiece> DescribeFieldPieces(
  const std::vector<Leaf>& leaves, const ImagePieces& pieces)
{
  std::vector<FieldPiece> described;
  for (std::size_t number = 0; number < leaves.size(); ++number)
  {
    const MemoryPiece& piece = pieces.Pieces[number];
    int extent[6];
    std::copy_n(leaves[number].Grid.Extent.begin(), 6, extent);
    described.push_back({ piece.Grid, piece.Components, leaves[number].Block,
      MakeVertexBox(pieces.Grids[piece.Grid], extent), leaves[number].IsDeclared,
      !piece.Hidden.IsEmpty() });
  }
  return described;
}

// The samples of a box of a piece, in a grid that begins at a vertex of theirs.
MemoryPiece MovePiece(MemoryPiece piece, const VertexBox& box, const Index3& first)
{
  const Index3 offset = { -first[0], -first[1], -first[2] };
  for (SampleView& view : piece.Components)
  {
    view.Available = view.Available.Translate(offset);
    view.Box = box.Translate(offset);
  }
  piece.Hidden.Box = piece.Hidden.Box.Translate(offset);
  return piece;
}

// Gives each field a grid of its own.
ImagePieces SortByFields(vtkDataObject* input, const ImagePieces& united, const PieceFields& fields)
{
  std::vector<BlockPath> blocks;
  for (const GridField& field : fields.Fields)
  {
    blocks.push_back(field.Block);
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  ImagePieces sorted;
  for (const BlockPath& block : blocks)
  {
    sorted.BlockNames.push_back(FindBlockName(input, block));
  }
  for (const GridField& field : fields.Fields)
  {
    GridGeometry grid = united.Grids[field.Grid];
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      const std::int64_t first = grid.Extent[2 * axis];
      grid.Extent[2 * axis] = first + field.Box.Low[axis];
      grid.Extent[2 * axis + 1] = first + field.Box.High[axis] - 1;
    }
    sorted.Grids.push_back(grid);
    const std::optional<GridLines>& lines = united.Lines[field.Grid];
    sorted.Lines.push_back(lines ? std::make_optional(lines->Cut(field.Box)) : std::nullopt);
    sorted.Blocks.push_back(static_cast<std::size_t>(
      std::lower_bound(blocks.begin(), blocks.end(), field.Block) - blocks.begin()));
  }
  for (std::size_t number = 0; number < united.Pieces.size(); ++number)
  {
    for (const VertexBox& box : fields.Boxes[number])
    {
      const std::size_t field = fields.Numbers[number];
      sorted.Pieces.push_back(MovePiece(united.Pieces[number], box, fields.Fields[field].Box.Low));
      sorted.Pieces.back().Grid = field;
      sorted.Sources.push_back(united.Sources[number]);
    }
  }
  return sorted;
}

// Gives a piece the arrays of these names to interpolate.
Result<std::vector<InterpolatedArray>> AddAttributesTo(MemoryPiece& piece,
  const ImagePieces::Source& source, const std::vector<std::string>& names, CellAverages& averages,
  int threads)
{
  using Owners = std::pair<std::shared_ptr<const void>, std::vector<vtkSmartPointer<vtkDataArray>>>;
  const auto owners = std::make_shared<Owners>();
  owners->first = std::exchange(piece.Owner, owners);
  std::vector<InterpolatedArray> arrays;
  for (const std::string& name : names)
  {
    vtkDataArray* array = source.Image->GetPointData()->GetArray(name.c_str());
    vtkDataArray* cells = source.Image->GetCellData()->GetArray(name.c_str());
    if (!array && cells)
    {
      ISOSURFACE_ASSIGN_OR_RETURN(array, averages.Find(source.Image, source.Time, cells, threads));
    }
    if (!array || array->GetNumberOfTuples() != source.Image->GetNumberOfPoints())
    {
      return Status(StatusCode::NotFound,
        "the input has no numeric point array or cell array \"" + name +
          "\" to interpolate everywhere");
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const ValueType type, GetValueTypeOf(array));
    owners->second.push_back(MakePlainArray(array));
    InterpolatedArray description{ name, {}, { type, array->GetNumberOfComponents() } };
    for (int n = 0; array->HasAComponentName() && n < array->GetNumberOfComponents(); ++n)
    {
      const char* componentName = array->GetComponentName(n);
      description.ComponentNames.emplace_back(componentName ? componentName : "");
    }
    const SampleView& scalars = piece.Components.front();
    AttributeView view{ MakeComponentViews(owners->second.back(), type, scalars.Available) };
    for (SampleView& component : view.Components)
    {
      component.Box = scalars.Box;
    }
    arrays.push_back(std::move(description));
    piece.Attributes.push_back(std::move(view));
  }
  return arrays;
}

} // namespace

vtkMTimeType FindImageTime(vtkInformation* inputInfo, vtkImageData* image)
{
  vtkExecutive* executive = vtkExecutive::PRODUCER()->GetExecutive(inputInfo);
  vtkInformation* original = inputInfo;
  while (executive && FindPassedArrays(executive->GetAlgorithm()) != PassedArrays::None &&
    executive->GetNumberOfInputConnections(0) > 0)
  {
    original = executive->GetInputInformation(0, 0);
    executive = vtkExecutive::PRODUCER()->GetExecutive(original);
  }
  vtkDataObject* data = vtkDataObject::GetData(original);
  if (original == inputInfo || !data)
  {
    return image->GetMTime();
  }
  vtkMTimeType time = data->GetMTime();
  for (vtkDataSet* set : vtkCompositeDataSet::GetDataSets<vtkDataSet>(data))
  {
    time = std::max(time, set->GetMTime());
  }
  return std::min(time, image->GetMTime());
}

Result<ImagePieces> CollectImagePieces(Communicator& ranks, vtkDataObject* input,
  vtkInformation* inputInfo, const std::function<Result<vtkDataArray*>(vtkImageData*)>& findArray,
  int threads)
{
  std::vector<Leaf> leaves;
  const std::string context = "the images of the input cannot be prepared";
  const auto collect = [&](Message& mine) -> Status
  {
    std::size_t numberOfImages = 0;
    ISOSURFACE_RETURN_IF_ERROR(CollectLeaves(input, inputInfo, findArray, leaves, numberOfImages));
    mine = DescribeLeaves(leaves, numberOfImages);
    return Status::Ok();
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto told, GatherFromAll(ranks, context, collect));
  ImagePieces pieces;
  const auto describe = [&]() -> Result<std::vector<FieldPiece>>
  {
    ISOSURFACE_RETURN_IF_ERROR(
      AddPieces(inputInfo, leaves, told, static_cast<std::size_t>(ranks.GetRank()), pieces));
    return DescribeFieldPieces(leaves, pieces);
  };
  ISOSURFACE_ASSIGN_OR_RETURN(const auto fields, PieceFields::Find(ranks, describe, threads));
  const auto sort = [&]
  {
    pieces = SortByFields(input, pieces, fields);
    return Status::Ok();
  };
  ISOSURFACE_RETURN_IF_ERROR(Attempt(context, sort));
  return pieces;
}

Result<std::vector<InterpolatedArray>> AddAttributes(
  ImagePieces& pieces, const std::vector<std::string>& names, CellAverages& averages, int threads)
{
  std::vector<InterpolatedArray> all;
  for (std::size_t number = 0; number < pieces.Pieces.size(); ++number)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto arrays,
      AddAttributesTo(pieces.Pieces[number], pieces.Sources[number], names, averages, threads));
    if (number == 0)
    {
      all = std::move(arrays);
    }
    else if (arrays != all)
    {
      return Status(StatusCode::InvalidArgument,
        "the arrays to interpolate are not of the same types in all images of the input");
    }
  }
  return all;
}

} // namespace isosurface
