// SPDX-License-Identifier: BSD-3-Clause
#include "BlockImage.h"

#include "ArrayRanges.h"
#include "ImageSamples.h"
#include "RangedArray.h"
#include "RectilinearGrids.h"
#include "Storage/Sampling/LevelSamples.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationDoubleVectorKey.h"
#include "vtkInformationInformationVectorKey.h"
#include "vtkInformationStringKey.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkRectilinearGrid.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

// Marks what lies outside the block's own vertices; `layer` is 1 for cells, 0 for vertices, so
// that both are counted by their low corner.
vtkSmartPointer<vtkUnsignedCharArray> MakeGhosts(
  const VertexBox& available, const VertexBox& own, int layer, unsigned char mark)
{
  const Index3 size = available.GetSize();
  Index3 count;
  bool flat[3];
  for (int axis = 0; axis < 3; ++axis)
  {
    // An axis of one vertex has one layer of cells, as vtkImageData counts them.
    flat[axis] = size[axis] == 1;
    count[axis] = std::max<std::int64_t>(1, size[axis] - layer);
  }
  const vtkSmartPointer<vtkUnsignedCharArray> ghosts =
    vtkUnsignedCharArray::SafeDownCast(MakeRangedArray(VTK_UNSIGNED_CHAR));
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  AllocateTuples(ghosts, count[0] * count[1] * count[2]);
  auto isOwn = [&](int axis, std::int64_t index)
  {
    const std::int64_t vertex = available.Low[axis] + index;
    return flat[axis] || (vertex >= own.Low[axis] && vertex < own.High[axis] - layer);
  };
  vtkIdType id = 0;
  unsigned char minimum = mark;
  unsigned char maximum = 0;
  for (std::int64_t k = 0; k < count[2]; ++k)
  {
    for (std::int64_t j = 0; j < count[1]; ++j)
    {
      const bool ownRow = isOwn(1, j) && isOwn(2, k);
      for (std::int64_t i = 0; i < count[0]; ++i)
      {
        const unsigned char value = ownRow && isOwn(0, i) ? 0 : mark;
        minimum = std::min(minimum, value);
        maximum = std::max(maximum, value);
        ghosts->SetValue(id++, value);
      }
    }
  }
  // ParaView asks for it after each update, and VTK would look at each value, twice.
  StoreRange(ghosts, minimum, maximum);
  return ghosts;
}

// An image of a level's vertices without arrays yet; it remembers the whole level's extent.
vtkSmartPointer<vtkImageData> MakeLevelImage(
  const BlockedVolume& volume, int level, const VertexBox& vertices)
{
  const GridGeometry geometry = volume.GetHeader().Grid.Coarsen(level);
  vtkSmartPointer<vtkImageData> image = MakeImage(geometry, vertices);
  int wholeExtent[6];
  std::copy(geometry.Extent.begin(), geometry.Extent.end(), wholeExtent);
  StoreWholeExtent(image, wholeExtent);
  return image;
}

// An array for the image's vertices, uninitialised unless there is memory with its values.
vtkSmartPointer<vtkDataArray> MakeArray(
  vtkImageData* image, const ArrayDescription& description, Buffer<std::uint8_t> memory = {})
{
  vtkSmartPointer<vtkDataArray> values = MakeRangedArray(GetVTKType(description.Type));
  values->SetName(description.Name.c_str());
  values->SetNumberOfComponents(description.Components);
  if (memory.IsEmpty())
  {
    AllocateTuples(values, image->GetNumberOfPoints());
  }
  else
  {
    AdoptMemory(values, memory.Release(), image->GetNumberOfPoints() * description.Components);
  }
  if (!description.Unit.empty())
  {
    values->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), description.Unit.c_str());
  }
  return values;
}

// Gives the first vertex the minimum of a component, the last one its maximum.
void FillWithRange(const KeyRange& range, ValueType type, int component, vtkDataArray* values)
{
  DispatchValueType(type,
    [&](auto zero)
    {
      using Value = decltype(zero);
      const Value minimum = range.IsEmpty() ? zero : MakeValueOfKey<Value>(range.Minimum);
      const Value maximum = range.IsEmpty() ? zero : MakeValueOfKey<Value>(range.Maximum);
      auto* samples = static_cast<Value*>(values->GetVoidPointer(component));
      const int components = values->GetNumberOfComponents();
      const vtkIdType last = values->GetNumberOfTuples() - 1;
      for (vtkIdType vertex = 0; vertex <= last; ++vertex)
      {
        // In between: the value nearest to zero, so that magnitudes have about their range.
        samples[vertex * components] = std::clamp(zero, minimum, maximum);
      }
      samples[last * components] = maximum;
      samples[0] = minimum;
    });
}

void AddGhosts(vtkImageData* image, const VertexBox& available, const VertexBox& own)
{
  image->GetPointData()->AddArray(
    MakeGhosts(available, own, 0, vtkDataSetAttributes::DUPLICATEPOINT));
  image->GetCellData()->AddArray(
    MakeGhosts(available, own, 1, vtkDataSetAttributes::DUPLICATECELL));
}

// What the reader gives: the image, or the rectilinear grid of these lines with its arrays.
vtkSmartPointer<vtkDataSet> FinishGrid(
  const vtkSmartPointer<vtkImageData>& image, const GridLines* lines, const VertexBox& vertices)
{
  if (!lines)
  {
    return image;
  }
  return MakeRectilinearGrid(image, lines->Cut(vertices));
}

} // namespace

vtkSmartPointer<vtkImageData> MakeImage(const GridGeometry& geometry, const VertexBox& vertices)
{
  int extent[6];
  for (int axis = 0; axis < 3; ++axis)
  {
    extent[2 * axis] = static_cast<int>(geometry.Extent[2 * axis] + vertices.Low[axis]);
    extent[2 * axis + 1] = static_cast<int>(geometry.Extent[2 * axis] + vertices.High[axis] - 1);
  }
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(extent);
  image->SetOrigin(geometry.Origin.data());
  image->SetSpacing(geometry.Spacing.data());
  image->SetDirectionMatrix(geometry.Direction.data());
  StoreLengthUnit(image, geometry.Unit);
  return image;
}

vtkSmartPointer<vtkDataArray> AddArray(
  vtkImageData* image, const ArrayDescription& description, Buffer<std::uint8_t> memory)
{
  auto values = MakeArray(image, description, std::move(memory));
  image->GetPointData()->AddArray(values);
  if (!image->GetPointData()->GetScalars())
  {
    image->GetPointData()->SetActiveScalars(description.Name.c_str());
  }
  return values;
}

void StoreVolumeRanges(
  const BlockedVolume& volume, std::size_t timeStep, std::size_t array, vtkDataArray* values)
{
  const ArrayDescription& description = volume.GetHeader().Arrays[array];
  const std::vector<KeyRange>& ranges = volume.GetHeader().TimeSteps[timeStep].Ranges;
  std::array<double, 2> range;
  const auto find = [&](int choice)
  {
    const auto variable = volume.GetVariables().FindChoice(array, choice);
    if (!variable || *variable >= ranges.size())
    {
      return false;
    }
    range = ranges[*variable].GetValues(volume.GetVariables()[*variable].Type);
    return std::isfinite(range[0]) && std::isfinite(range[1]);
  };
  vtkNew<vtkInformationVector> components;
  for (int component = 0; component < description.Components; ++component)
  {
    if (!find(component))
    {
      return;
    }
    vtkNew<vtkInformation> information;
    information->Set(vtkDataArray::COMPONENT_RANGE(), range.data(), 2);
    components->Append(information);
  }
  vtkInformation* known = values->GetInformation();
  known->Set(vtkDataArray::PER_COMPONENT(), components);
  known->Set(vtkDataArray::PER_FINITE_COMPONENT(), components);
  if (description.Components > 1 && find(description.Components))
  {
    known->Set(vtkDataArray::L2_NORM_RANGE(), range.data(), 2);
    known->Set(vtkDataArray::L2_NORM_FINITE_RANGE(), range.data(), 2);
  }
}

Result<vtkSmartPointer<vtkDataSet>> ReadSlab(BlockedVolume& volume, const BlockBox& box,
  std::size_t timeStep, const std::vector<std::size_t>& arrays, int level, int threads,
  QueryStatistics& statistics, const Progress& progress)
{
  const StoredLevel stored = volume.FindLevel(level);
  const BlockGrid& grid = *stored.Grid;
  ISOSURFACE_ASSIGN_OR_RETURN(
    std::vector<BlockReference> blocks, volume.ListBlocks(timeStep, statistics, level));
  const auto isOutside = [&](const BlockReference& block)
  { return !box.Contains(grid.GetBlockCoordinates(block.Block)); };
  blocks.erase(std::remove_if(blocks.begin(), blocks.end(), isOutside), blocks.end());

  const VertexBox available = box.GetGhostedVertices(grid, stored.Level);
  vtkSmartPointer<vtkImageData> image = MakeLevelImage(volume, level, available);
  std::vector<void*> values;
  for (const std::size_t array : arrays)
  {
    values.push_back(AddArray(image, volume.GetHeader().Arrays[array])->GetVoidPointer(0));
  }
  ISOSURFACE_RETURN_IF_ERROR(SampleComponents(volume.GetVariables(), arrays, values, progress,
    [&](std::size_t variable, void* first, int stride, const Progress& advance)
    {
      return AssembleBlocks(volume, timeStep, variable, level, box, blocks, threads, first, stride,
        statistics, advance);
    }));
  for (const std::size_t array : arrays)
  {
    StoreVolumeRanges(volume, timeStep, array,
      image->GetPointData()->GetArray(volume.GetHeader().Arrays[array].Name.c_str()));
  }
  // One piece alone has no neighbours, hence no ghosts.
  const VertexBox own = box.GetVertices(grid, stored.Level);
  if (!(own == available))
  {
    AddGhosts(image, available, own);
  }
  return FinishGrid(image, volume.GetLines(level), available);
}

vtkSmartPointer<vtkDataSet> MakeBox(const BlockedVolume& volume, std::size_t timeStep)
{
  const BlockedVolumeHeader& header = volume.GetHeader();
  // The grid whose one cell is the whole volume.
  GridGeometry box = header.Grid;
  VertexBox vertices;
  const Index3 dimensions = header.Grid.GetDimensions();
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int row = 0; row < 3; ++row)
    {
      box.Origin[row] += box.Direction[3 * row + axis] * box.Spacing[axis] *
        static_cast<double>(box.Extent[2 * axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis)
  {
    box.Extent[2 * axis] = 0;
    box.Spacing[axis] *= static_cast<double>(std::max<std::int64_t>(1, dimensions[axis] - 1));
    vertices.High[axis] = dimensions[axis] > 1 ? 2 : 1;
  }
  vtkSmartPointer<vtkImageData> image = MakeImage(box, vertices);
  for (std::size_t array = 0; array < header.Arrays.size(); ++array)
  {
    const ArrayDescription& description = header.Arrays[array];
    auto values = MakeArray(image, description);
    for (int component = 0; component < description.Components; ++component)
    {
      FillWithRange(
        header.TimeSteps[timeStep].Ranges[*volume.GetVariables().Find(array, component)],
        description.Type, component, values);
    }
    image->GetPointData()->AddArray(values);
  }
  if (!header.Arrays.empty())
  {
    image->GetPointData()->SetActiveScalars(header.Arrays[0].Name.c_str());
  }
  if (!header.Lines)
  {
    return image;
  }
  GridLines ends;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    const std::vector<double>& lines = header.Lines->Coordinates[axis];
    ends.Coordinates[axis].push_back(lines.front());
    if (lines.size() > 1)
    {
      ends.Coordinates[axis].push_back(lines.back());
    }
  }
  return MakeRectilinearGrid(image, ends);
}

} // namespace isosurface
