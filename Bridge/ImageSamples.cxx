// SPDX-License-Identifier: BSD-3-Clause
#include "ImageSamples.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationStringKey.h"
#include "vtkIntArray.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkStringArray.h"
#include "vtkUniformGrid.h"
#include "vtkUnsignedCharArray.h"

#include "Ground/Volume/SampleCopy.h"

#include <algorithm>

namespace isosurface
{
namespace
{
constexpr const char* WholeExtentName = "BlockedVolumeExtent";

std::string NameOf(vtkDataArray* array)
{
  return std::string("array \"") + (array->GetName() ? array->GetName() : "") + "\"";
}

void StoreText(vtkDataObject* data, const std::string& name, const char* text, int times)
{
  vtkNew<vtkStringArray> array;
  array->SetName(name.c_str());
  for (int number = 0; number < times; ++number)
  {
    array->InsertNextValue(text);
  }
  data->GetFieldData()->AddArray(array);
}
} // namespace

Result<ValueType> GetValueTypeOf(vtkDataArray* array)
{
  const int type = array->GetDataType();
  if (type == VTK_FLOAT)
  {
    return ValueType::Float32;
  }
  if (type == VTK_DOUBLE)
  {
    return ValueType::Float64;
  }
  const auto integer = FindIntegerType(
    static_cast<std::size_t>(array->GetDataTypeSize()), array->GetDataTypeMin() < 0);
  if (type == VTK_BIT || !integer)
  {
    return Status(StatusCode::Unsupported,
      NameOf(array) + " is of type " + array->GetDataTypeAsString() + ", which has no isosurfaces");
  }
  return *integer;
}

vtkSmartPointer<vtkDataArray> MakePlainArray(vtkDataArray* array)
{
  if (array->HasStandardMemoryLayout())
  {
    return array;
  }
  auto plain =
    vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
  plain->DeepCopy(array);
  return plain;
}

std::vector<SampleView> MakeComponentViews(
  vtkDataArray* array, ValueType type, const VertexBox& box)
{
  std::vector<SampleView> views;
  const int components = array->GetNumberOfComponents();
  for (int component = 0; component < components; ++component)
  {
    views.push_back(MakeSampleView(type, box, array->GetVoidPointer(component), components));
  }
  return views;
}

std::string GetUnitOf(vtkDataArray* array)
{
  const char* unit =
    array->HasInformation() ? array->GetInformation()->Get(vtkDataArray::UNITS_LABEL()) : nullptr;
  return unit ? unit : "";
}

int GetVTKType(ValueType type)
{
  switch (type)
  {
    case ValueType::Int8:
      return VTK_SIGNED_CHAR;
    case ValueType::UInt8:
      return VTK_UNSIGNED_CHAR;
    case ValueType::Int16:
      return VTK_SHORT;
    case ValueType::UInt16:
      return VTK_UNSIGNED_SHORT;
    case ValueType::Int32:
      return VTK_INT;
    case ValueType::UInt32:
      return VTK_UNSIGNED_INT;
    case ValueType::Int64:
      return VTK_LONG_LONG;
    case ValueType::UInt64:
      return VTK_UNSIGNED_LONG_LONG;
    case ValueType::Float32:
      return VTK_FLOAT;
    case ValueType::Float64:
      break;
  }
  return VTK_DOUBLE;
}

GridGeometry MakeGridGeometry(vtkImageData* image, const int wholeExtent[6])
{
  GridGeometry grid;
  std::copy(wholeExtent, wholeExtent + 6, grid.Extent.begin());
  image->GetOrigin(grid.Origin.data());
  image->GetSpacing(grid.Spacing.data());
  std::copy_n(image->GetDirectionMatrix()->GetData(), 9, grid.Direction.begin());
  grid.Unit = FindLengthUnitOf(image);
  return grid;
}

void StoreWholeExtent(vtkImageData* image, const int wholeExtent[6])
{
  vtkNew<vtkIntArray> array;
  array->SetName(WholeExtentName);
  array->SetNumberOfComponents(6);
  array->InsertNextTypedTuple(wholeExtent);
  image->GetFieldData()->AddArray(array);
}

bool FindWholeExtent(vtkImageData* image, int wholeExtent[6])
{
  auto* array = vtkIntArray::SafeDownCast(image->GetFieldData()->GetArray(WholeExtentName));
  if (!array || array->GetNumberOfComponents() != 6 || array->GetNumberOfTuples() != 1)
  {
    return false;
  }
  array->GetTypedTuple(0, wholeExtent);
  const int* extent = image->GetExtent();
  for (int axis = 0; axis < 3; ++axis)
  {
    if (wholeExtent[2 * axis] > extent[2 * axis] ||
      wholeExtent[2 * axis + 1] < extent[2 * axis + 1])
    {
      return false;
    }
  }
  return true;
}

void StoreLengthUnit(vtkDataObject* data, LengthUnit unit)
{
  if (unit != LengthUnit::Unknown)
  {
    StoreText(data, LengthUnitName, GetLengthUnitName(unit), 3);
  }
}

void StoreUnit(vtkDataObject* data, const std::string& array, const std::string& unit)
{
  if (!unit.empty())
  {
    StoreText(data, array + UnitEnd, unit.c_str(), 1);
  }
}

void StoreWindow(vtkDataObject* data, const std::string& array, const std::array<double, 2>& window)
{
  vtkNew<vtkDoubleArray> values;
  values->SetName((array + WindowEnd).c_str());
  values->InsertNextValue(window[0]);
  values->InsertNextValue(window[1]);
  data->GetFieldData()->AddArray(values);
}

LengthUnit FindLengthUnitOf(vtkDataObject* data)
{
  auto* array =
    vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray(LengthUnitName));
  const vtkIdType axes = array ? array->GetNumberOfValues() : 0;
  const LengthUnit unit = axes > 0 ? FindLengthUnit(array->GetValue(0)) : LengthUnit::Unknown;
  for (vtkIdType axis = 1; axis < axes; ++axis)
  {
    if (FindLengthUnit(array->GetValue(axis)) != unit)
    {
      return LengthUnit::Unknown;
    }
  }
  return unit;
}

std::optional<double> FindTime(vtkDataObject* data)
{
  vtkInformation* information = data->GetInformation();
  if (information->Has(vtkDataObject::DATA_TIME_STEP()))
  {
    return information->Get(vtkDataObject::DATA_TIME_STEP());
  }
  vtkDataArray* value = data->GetFieldData()->GetArray("TimeValue");
  return value && value->GetNumberOfValues() == 1 ? std::optional<double>(value->GetTuple1(0))
                                                  : std::nullopt;
}

VertexBox MakeVertexBox(const GridGeometry& grid, const int extent[6])
{
  VertexBox box;
  for (int axis = 0; axis < 3; ++axis)
  {
    box.Low[axis] = extent[2 * axis] - grid.Extent[2 * axis];
    box.High[axis] = extent[2 * axis + 1] - grid.Extent[2 * axis] + 1;
  }
  return box;
}

VertexBox FindOwnVertices(const GridGeometry& grid, vtkImageData* image)
{
  const VertexBox all = MakeVertexBox(grid, image->GetExtent());
  vtkUnsignedCharArray* ghosts = image->GetCellGhostArray();
  if (!ghosts || all.IsEmpty())
  {
    return all;
  }
  // The bounding box of the own cells, row by row of cells.
  const Index3 size = all.GetSize();
  Index3 cells;
  for (int axis = 0; axis < 3; ++axis)
  {
    cells[axis] = std::max<std::int64_t>(1, size[axis] - 1);
  }
  Index3 low = cells;
  Index3 high{ -1, -1, -1 };
  const unsigned char* mark = ghosts->GetPointer(0);
  for (std::int64_t k = 0; k < cells[2]; ++k)
  {
    for (std::int64_t j = 0; j < cells[1]; ++j, mark += cells[0])
    {
      auto isOwn = [](unsigned char ghost)
      { return (ghost & vtkDataSetAttributes::DUPLICATECELL) == 0; };
      const auto* first = std::find_if(mark, mark + cells[0], isOwn);
      if (first == mark + cells[0])
      {
        continue;
      }
      std::int64_t last = cells[0] - 1;
      while (!isOwn(mark[last]))
      {
        --last;
      }
      const Index3 rowLow{ first - mark, j, k };
      const Index3 rowHigh{ last, j, k };
      for (int axis = 0; axis < 3; ++axis)
      {
        low[axis] = std::min(low[axis], rowLow[axis]);
        high[axis] = std::max(high[axis], rowHigh[axis]);
      }
    }
  }
  if (high[0] < 0)
  {
    return VertexBox();
  }
  VertexBox own;
  for (int axis = 0; axis < 3; ++axis)
  {
    own.Low[axis] = all.Low[axis] + low[axis];
    own.High[axis] = std::min(all.High[axis], all.Low[axis] + high[axis] + 2);
  }
  return own;
}

Blanking FindBlanking(const GridGeometry& grid, vtkImageData* image)
{
  Blanking hidden;
  hidden.Box = MakeVertexBox(grid, image->GetExtent());
  if (!vtkUniformGrid::SafeDownCast(image) || hidden.Box.IsEmpty())
  {
    return hidden;
  }
  // Flags of another length than the image are not its flags.
  const auto find = [](vtkUnsignedCharArray* flags, vtkIdType count, std::uint8_t bits)
  {
    const unsigned char* first =
      flags && flags->GetNumberOfValues() == count ? flags->GetPointer(0) : nullptr;
    const bool hides = first &&
      std::any_of(first, first + count, [bits](unsigned char flag) { return (flag & bits) != 0; });
    return hides ? first : nullptr;
  };
  hidden.HidesCell = vtkDataSetAttributes::HIDDENCELL | vtkDataSetAttributes::REFINEDCELL;
  hidden.HidesVertex = vtkDataSetAttributes::HIDDENPOINT;
  hidden.Cells = find(image->GetCellGhostArray(), image->GetNumberOfCells(), hidden.HidesCell);
  hidden.Vertices =
    find(image->GetPointGhostArray(), image->GetNumberOfPoints(), hidden.HidesVertex);
  return hidden;
}

Result<ImageSamples> MakeImageSamples(
  const GridGeometry& grid, vtkImageData* image, vtkDataArray* array)
{
  if (array->GetNumberOfTuples() != image->GetNumberOfPoints())
  {
    return Status(StatusCode::InvalidArgument,
      NameOf(array) + " has " + std::to_string(array->GetNumberOfTuples()) + " values for " +
        std::to_string(image->GetNumberOfPoints()) + " points; cell arrays must be converted to " +
        "point arrays first");
  }
  ISOSURFACE_ASSIGN_OR_RETURN(const ValueType type, GetValueTypeOf(array));
  ImageSamples samples;
  samples.Array = MakePlainArray(array);
  samples.Hidden = FindBlanking(grid, image);
  samples.Components =
    MakeComponentViews(samples.Array, type, MakeVertexBox(grid, image->GetExtent()));
  const VertexBox own = FindOwnVertices(grid, image);
  for (SampleView& view : samples.Components)
  {
    view.Box = own;
  }
  return samples;
}

} // namespace isosurface
