// SPDX-License-Identifier: BSD-3-Clause
#include "BlockChecks.h"

#include "vtkBlockedVolumeReader.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkImageData.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace isosurface
{
namespace
{

using Vertex = std::array<int, 3>;

void ForEachVertex(const int extent[6], const std::function<void(const Vertex&)>& visit)
{
  Vertex vertex;
  for (vertex[2] = extent[4]; vertex[2] <= extent[5]; ++vertex[2])
  {
    for (vertex[1] = extent[2]; vertex[1] <= extent[3]; ++vertex[1])
    {
      for (vertex[0] = extent[0]; vertex[0] <= extent[1]; ++vertex[0])
      {
        visit(vertex);
      }
    }
  }
}

void ForEachBlock(const std::vector<vtkPartitionedDataSet*>& pieces,
  const std::function<void(vtkImageData*)>& visit)
{
  for (vtkPartitionedDataSet* piece : pieces)
  {
    for (unsigned int index = 0; index < piece->GetNumberOfPartitions(); ++index)
    {
      visit(vtkImageData::SafeDownCast(piece->GetPartition(index)));
    }
  }
}

} // namespace

testing::AssertionResult BlockChecks::HaveValues(
  const std::vector<vtkPartitionedDataSet*>& pieces, const char* array) const
{
  vtkDataArray* expected = this->Image->GetPointData()->GetArray(array);
  const int* whole = this->Image->GetExtent();
  int wrongValues = 0;
  int wrongPlaces = 0;
  ForEachBlock(pieces,
    [&](vtkImageData* block)
    {
      vtkDataArray* values = block->GetPointData()->GetArray(array);
      if (!values || values->GetNumberOfTuples() != block->GetNumberOfPoints() ||
        values->GetDataTypeSize() != expected->GetDataTypeSize())
      {
        ++wrongValues;
        return;
      }
      ForEachVertex(block->GetExtent(),
        [&](const Vertex& vertex)
        {
          Vertex source = vertex;
          for (int axis = 0; axis < 3 && this->Level > 0; ++axis)
          {
            // Coarse grids are counted from the first vertex.
            source[axis] = whole[2 * axis] + (vertex[axis] << this->Level);
          }
          Vertex here = vertex;
          const vtkIdType id = block->ComputePointId(here.data());
          const vtkIdType sourceId = this->Image->ComputePointId(source.data());
          wrongValues += values->GetComponent(id, 0) != expected->GetComponent(sourceId, 0) ? 1 : 0;
          double place[3];
          double sourcePlace[3];
          block->GetPoint(id, place);
          this->Image->GetPoint(sourceId, sourcePlace);
          for (int axis = 0; axis < 3; ++axis)
          {
            wrongPlaces += std::abs(place[axis] - sourcePlace[axis]) > 1e-9 ? 1 : 0;
          }
        });
    });
  return wrongValues + wrongPlaces == 0 ? testing::AssertionSuccess()
                                        : testing::AssertionFailure()
      << wrongValues << " wrong values, " << wrongPlaces << " wrong places";
}

testing::AssertionResult BlockChecks::HaveEachCellOnce(
  const std::vector<vtkPartitionedDataSet*>& pieces) const
{
  const int* whole = this->Image->GetExtent();
  Vertex first{ 0, 0, 0 };
  Vertex cells;
  for (int axis = 0; axis < 3; ++axis)
  {
    first[axis] = this->Level == 0 ? whole[2 * axis] : 0;
    cells[axis] = (whole[2 * axis + 1] - whole[2 * axis]) >> this->Level;
  }
  std::vector<int> seen(static_cast<std::size_t>(cells[0]) * cells[1] * cells[2]);
  int wrongGhostPoints = 0;
  int outside = 0;
  ForEachBlock(pieces,
    [&](vtkImageData* block)
    {
      vtkUnsignedCharArray* ghostCells = block->GetCellGhostArray();
      vtkUnsignedCharArray* ghostPoints = block->GetPointGhostArray();
      if (!ghostCells != !ghostPoints ||
        (ghostCells && ghostCells->GetNumberOfTuples() != block->GetNumberOfCells()))
      {
        ++outside;
        return;
      }
      std::vector<char> isOwn(static_cast<std::size_t>(block->GetNumberOfPoints()), 0);
      int extent[6];
      block->GetExtent(extent);
      const int cellExtent[6] = { extent[0], extent[1] - 1, extent[2], extent[3] - 1, extent[4],
        extent[5] - 1 };
      ForEachVertex(cellExtent,
        [&](const Vertex& cell)
        {
          Vertex here = cell;
          if (ghostCells && ghostCells->GetValue(block->ComputeCellId(here.data())) != 0)
          {
            return;
          }
          std::size_t number = 0;
          bool isInside = true;
          for (int axis = 2; axis >= 0; --axis)
          {
            const int index = cell[axis] - first[axis];
            isInside = isInside && index >= 0 && index < cells[axis];
            number =
              number * static_cast<std::size_t>(cells[axis]) + static_cast<std::size_t>(index);
          }
          outside += isInside ? 0 : 1;
          if (isInside)
          {
            ++seen[number];
          }
          for (int corner = 0; corner < 8; ++corner)
          {
            Vertex vertex{ cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1),
              cell[2] + (corner >> 2) };
            isOwn[static_cast<std::size_t>(block->ComputePointId(vertex.data()))] = 1;
          }
        });
      const bool hasOwnCells = std::count(isOwn.begin(), isOwn.end(), 1) > 0;
      for (vtkIdType point = 0; ghostPoints && point < block->GetNumberOfPoints(); ++point)
      {
        const bool isGhost =
          (ghostPoints->GetValue(point) & vtkDataSetAttributes::DUPLICATEPOINT) != 0;
        wrongGhostPoints +=
          hasOwnCells && isGhost == (isOwn[static_cast<std::size_t>(point)] != 0) ? 1 : 0;
      }
    });
  const auto once = std::count(seen.begin(), seen.end(), 1);
  const auto never = std::count(seen.begin(), seen.end(), 0);
  return static_cast<std::size_t>(once) == seen.size() && outside == 0 && wrongGhostPoints == 0
    ? testing::AssertionSuccess()
    : testing::AssertionFailure() << "of " << seen.size() << " cells " << once
                                  << " are there once, " << never << " never; " << outside
                                  << " beyond the grid; " << wrongGhostPoints
                                  << " wrong ghost points";
}

vtkSmartPointer<vtkPartitionedDataSet> ReadPiece(
  vtkBlockedVolumeReader* reader, int piece, int pieces)
{
  EXPECT_TRUE(reader->UpdatePiece(piece, pieces, 0));
  auto copy = vtkSmartPointer<vtkPartitionedDataSet>::New();
  copy->ShallowCopy(reader->GetOutput());
  return copy;
}

} // namespace isosurface
