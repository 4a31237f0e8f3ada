// SPDX-License-Identifier: BSD-3-Clause
#include "LocalVolume.h"

#include "vtkCellData.h"
#include "vtkImageData.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include "ArrayChoice.h"
#include "CellArrays.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/GridUnion.h"
#include "ImageSamples.h"
#include "Storage/Store/JsonDocument.h"

#include <algorithm>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

Message Describe(const LocalVolume& local)
{
  std::string text;
  auto add = [&text](const auto& values)
  { text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])); };
  add(local.Grid.Extent);
  add(local.Grid.Origin);
  add(local.Grid.Spacing);
  add(local.Grid.Direction);
  add(local.Time);
  text += static_cast<char>(local.Grid.Unit);
  for (const ArrayDescription& array : local.Arrays)
  {
    text += GetValueTypeName(array.Type) + std::string("\n") + std::to_string(array.Components) +
      "\n" + array.Name + '\0' + array.Unit + '\0';
  }
  return Message(text.begin(), text.end());
}

} // namespace

Status LocalVolume::CollectArrays(vtkImageData* image, const Selection& isSelected)
{
  vtkPointData* points = image->GetPointData();
  // The active scalars come first: they decide which store a block goes to.
  std::vector<vtkDataArray*> arrays;
  if (vtkDataArray* scalars = points->GetScalars())
  {
    arrays.push_back(scalars);
  }
  for (int index = 0; index < points->GetNumberOfArrays(); ++index)
  {
    vtkDataArray* array = points->GetArray(index);
    if (array && array != points->GetScalars() && array != image->GetPointGhostArray())
    {
      arrays.push_back(array);
    }
  }
  std::vector<vtkSmartPointer<vtkDataArray>> averages;
  ISOSURFACE_RETURN_IF_ERROR(this->AverageCellArrays(image, isSelected, averages));
  arrays.insert(arrays.end(), averages.begin(), averages.end());
  for (vtkDataArray* array : arrays)
  {
    const std::string name = GetNameOf(array);
    if (!isSelected(name))
    {
      continue;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto type, GetValueTypeOf(array));
    ISOSURFACE_ASSIGN_OR_RETURN(auto samples, MakeImageSamples(this->Grid, image, array));
    // A label is only for people to read: one that no header can have is left out.
    const std::string unit = GetUnitOf(array);
    this->Arrays.push_back(
      { name, type, array->GetNumberOfComponents(), IsUtf8(unit) ? unit : std::string() });
    for (SampleView& view : samples.Components)
    {
      // A writer needs what there is, ghosts included: they are samples like all others.
      view.Box = view.Available;
      this->Piece.Arrays.push_back(view);
    }
    this->Owners.push_back(samples.Array);
  }
  return Status::Ok();
}

Status LocalVolume::AverageCellArrays(vtkImageData* image, const Selection& isSelected,
  std::vector<vtkSmartPointer<vtkDataArray>>& averages) const
{
  vtkCellData* cells = image->GetCellData();
  for (int index = 0; this->WithCells && index < cells->GetNumberOfArrays(); ++index)
  {
    vtkDataArray* array = cells->GetArray(index);
    if (array && array != image->GetCellGhostArray() && isSelected(GetNameOf(array)) &&
      !image->GetPointData()->HasArray(GetNameOf(array).c_str()))
    {
      ISOSURFACE_ASSIGN_OR_RETURN(
        const auto average, AverageToPoints(image, array, ChooseThreadCount(1)));
      averages.push_back(average);
    }
  }
  return Status::Ok();
}

Status LocalVolume::UniteLines(Communicator& ranks)
{
  std::vector<LinedGrid> mine;
  if (this->Lines && !this->Piece.Box.IsEmpty())
  {
    mine.push_back(*this->Lines);
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const auto packed,
    GatherFromAll(ranks, NoMemoryForGrids,
      [&](Message& message)
      {
        message = PackLinedGrids(mine);
        return Status::Ok();
      }));
  std::vector<LinedGrid> grids;
  Status status = Attempt(NoMemoryForGrids,
    [&]
    {
      std::vector<std::size_t> numbers;
      grids = UniteLinedGrids(packed, 0, numbers);
      return Status::Ok();
    });
  if (grids.size() > 1)
  {
    status = { StatusCode::InvalidArgument,
      "the ranks' pieces are of several rectilinear grids, or do not meet" };
  }
  else if (!grids.empty() && !this->Piece.Box.IsEmpty() &&
    (!this->Lines || grids.front().Grid.Extent != this->Grid.Extent))
  {
    status = { StatusCode::InvalidArgument,
      this->Lines ? "the ranks' pieces do not have all coordinates of the rectilinear grid"
                  : "some ranks have a rectilinear grid, and some have image data" };
  }
  ISOSURFACE_RETURN_IF_ERROR(ranks.Agree(status));
  if (!grids.empty())
  {
    this->Lines = std::move(grids.front());
  }
  return Status::Ok();
}

Status LocalVolume::Agree(Communicator& ranks)
{
  ISOSURFACE_RETURN_IF_ERROR(this->UniteLines(ranks));
  const bool hasPart = !this->Piece.Box.IsEmpty();
  const std::vector<Message> all = ranks.AllGather(hasPart ? Describe(*this) : Message());
  const auto first =
    std::find_if(all.begin(), all.end(), [](const Message& text) { return !text.empty(); });
  if (first == all.end())
  {
    return Status(StatusCode::InvalidArgument, "the input is empty");
  }
  for (const Message& text : all)
  {
    if (!text.empty() && text != *first)
    {
      return Status(StatusCode::InvalidArgument,
        "the ranks' pieces differ in whole extent, origin, spacing, direction, time, arrays or "
        "units");
    }
  }
  if (!hasPart)
  {
    const char* from = reinterpret_cast<const char*>(first->data());
    const char* end = from + first->size();
    auto take = [&from](auto& values)
    {
      const std::size_t bytes = values.size() * sizeof(values[0]);
      std::copy(from, from + bytes, reinterpret_cast<char*>(values.data()));
      from += bytes;
    };
    take(this->Grid.Extent);
    take(this->Grid.Origin);
    take(this->Grid.Spacing);
    take(this->Grid.Direction);
    take(this->Time);
    this->Grid.Unit = static_cast<LengthUnit>(*from++);
    this->Arrays.clear();
    while (from != end)
    {
      const char* line = std::find(from, end, '\n');
      const char* name = std::find(line + 1, end, '\n') + 1;
      const char* stop = std::find(name, end, '\0');
      const char* unit = stop + 1;
      this->Arrays.push_back({ std::string(name, stop), *FindValueType(std::string(from, line)),
        std::stoi(std::string(line + 1, name)), unit });
      from = std::find(unit, end, '\0') + 1;
    }
    this->Piece = {};
    const ArrayVariables variables(this->Arrays);
    for (const ValueType type : variables.GetStoredTypes())
    {
      this->Piece.Arrays.emplace_back();
      this->Piece.Arrays.back().Type = type;
    }
  }
  return Status::Ok();
}

} // namespace isosurface
