// SPDX-License-Identifier: BSD-3-Clause
// VTK's own filters behind the reader see every cell once, and all blocks.
#include "BlockChecks.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"

#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkContourFilter.h"
#include "vtkDataSet.h"
#include "vtkDataSetAttributes.h"
#include "vtkIntegrateAttributes.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkThreshold.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"

#include <functional>

using namespace isosurface;

namespace
{

// Integer values, so that sums over cells are exact in any order.
class StockFilters : public testing::Test
{
protected:
  StockFilters()
    : Image(MakeImage({ -5, 60, 0, 40, 7, 50 }, VTK_SHORT, MakeNoise(3000, 2)))
  {
    this->Image->SetSpacing(0.5, 2, 0.25);
    WriteVolume(this->Image, this->Folder.GetPath("volume.bvol"), { 16, 3 });
    this->Reader->SetFileName(this->Folder.GetPath("volume.bvol").c_str());
  }

  const ScratchFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  vtkNew<vtkBlockedVolumeReader> Reader;
};

vtkIdType CountOwnCells(vtkDataObject* data)
{
  vtkIdType cells = 0;
  for (vtkDataSet* dataSet : vtkCompositeDataSet::GetDataSets<vtkDataSet>(data))
  {
    vtkUnsignedCharArray* ghosts = dataSet->GetCellGhostArray();
    for (vtkIdType cell = 0; cell < dataSet->GetNumberOfCells(); ++cell)
    {
      cells += ghosts && (ghosts->GetValue(cell) & vtkDataSetAttributes::DUPLICATECELL) ? 0 : 1;
    }
  }
  return cells;
}

TEST_F(StockFilters, ThresholdSeesEachCellOnce)
{
  auto count = [](vtkAlgorithm* source, vtkDataObject* data)
  {
    vtkNew<vtkThreshold> threshold;
    threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_BETWEEN);
    threshold->SetLowerThreshold(200);
    threshold->SetUpperThreshold(2900);
    SelectPoints(threshold, "density");
    if (source)
    {
      threshold->SetInputConnection(source->GetOutputPort());
    }
    else
    {
      threshold->SetInputDataObject(data);
    }
    threshold->Update();
    return CountOwnCells(threshold->GetOutputDataObject(0));
  };
  const vtkIdType cells = count(this->Reader, nullptr);
  EXPECT_GT(cells, 10000);
  EXPECT_LT(cells, this->Image->GetNumberOfCells());
  EXPECT_EQ(cells, count(nullptr, this->Image));
}

TEST_F(StockFilters, ContourHasEachCellOnce)
{
  auto integrate = [](vtkAlgorithm* contour)
  {
    vtkNew<vtkIntegrateAttributes> filter;
    filter->SetController(nullptr);
    filter->SetInputConnection(contour->GetOutputPort());
    filter->Update();
    return vtkDataSet::SafeDownCast(filter->GetOutputDataObject(0))
      ->GetCellData()
      ->GetArray("Area")
      ->GetTuple1(0);
  };
  vtkNew<vtkContourFilter> contour;
  contour->SetValue(0, 1500.5);
  SelectPoints(contour, "density");
  contour->SetInputConnection(this->Reader->GetOutputPort());
  const double blocks = integrate(contour);
  contour->SetInputData(this->Image);
  const double whole = integrate(contour);
  EXPECT_GT(whole, 1000);
  EXPECT_NEAR(blocks, whole, 1e-5 * whole);
}

TEST_F(StockFilters, IntegralsAreThoseOfTheImage)
{
  auto integrate = [](const std::function<void(vtkIntegrateAttributes*)>& connect)
  {
    vtkNew<vtkIntegrateAttributes> filter;
    filter->SetController(nullptr);
    connect(filter);
    filter->Update();
    auto* sums = vtkDataSet::SafeDownCast(filter->GetOutputDataObject(0));
    return std::make_pair(sums->GetCellData()->GetArray("Volume")->GetTuple1(0),
      sums->GetPointData()->GetArray("density")->GetTuple1(0));
  };
  const auto blocks = integrate([this](vtkIntegrateAttributes* filter)
    { filter->SetInputConnection(this->Reader->GetOutputPort()); });
  const auto whole =
    integrate([this](vtkIntegrateAttributes* filter) { filter->SetInputData(this->Image); });
  EXPECT_DOUBLE_EQ(whole.first, 0.25 * static_cast<double>(this->Image->GetNumberOfCells()));
  EXPECT_NEAR(blocks.first, whole.first, 1e-9 * whole.first);
  EXPECT_NEAR(blocks.second, whole.second, 1e-9 * whole.second);
}

TEST_F(StockFilters, AllLevelsHaveEachCellOnce)
{
  // A grid whose last blocks have but a vertex or two at coarse levels.
  const auto image = MakeImage({ 0, 33, 0, 65, 0, 50 }, VTK_DOUBLE, MakeNoise(99, 2));
  for (int level = 0; level < 3; ++level)
  {
    // Arrays enough to make the finer levels too large for the limit.
    const int arrays[] = { 1, 3, 12 };
    for (int number = image->GetPointData()->GetNumberOfArrays(); number < arrays[level]; ++number)
    {
      vtkSmartPointer<vtkDataArray> copy;
      copy.TakeReference(image->GetPointData()->GetScalars()->NewInstance());
      copy->DeepCopy(image->GetPointData()->GetScalars());
      copy->SetName(("copy" + std::to_string(number)).c_str());
      image->GetPointData()->AddArray(copy);
    }
    const std::string path = this->Folder.GetPath(std::to_string(level) + ".bvol");
    WriteVolume(image, path, { 16, 2 });
    this->Reader->SetFileName(path.c_str());
    this->Reader->SetMemoryLimit(2);
    const auto blocks = ReadPiece(this->Reader, 0, 1);
    EXPECT_EQ(this->Reader->GetLevel(), level);
    EXPECT_TRUE((BlockChecks{ image, level }.HaveEachCellOnce({ blocks })));
    EXPECT_TRUE((BlockChecks{ image, level }.HaveValues({ blocks }, "density")));
  }
}

} // namespace
