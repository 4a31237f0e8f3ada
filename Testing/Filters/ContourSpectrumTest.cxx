// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkContourSpectrum.h"

#include "vtkCellData.h"
#include "vtkCellDataToPointData.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkMassProperties.h"
#include "vtkNIFTIImageReader.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkTable.h"

#include "Ranks/Query/Refinement.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

using namespace isosurface;

namespace
{

vtkSmartPointer<vtkTable> MakeTable(vtkDataObject* input, const char* array = nullptr)
{
  vtkNew<vtkContourSpectrum> spectrum;
  const ExpectNoErrors errors(spectrum);
  spectrum->SetInputDataObject(input);
  if (array)
  {
    SelectPoints(spectrum, array);
  }
  spectrum->Update();
  return spectrum->GetOutput();
}

std::string Print(vtkTable* table)
{
  std::ostringstream text;
  text.precision(17);
  for (vtkIdType column = 0; column < table->GetNumberOfColumns(); ++column)
  {
    text << table->GetColumnName(column);
    for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
    {
      text << ' ' << table->GetValue(row, column).ToDouble();
    }
    text << '\n';
  }
  return text.str();
}

double GetValue(vtkTable* table, vtkIdType row, const char* column)
{
  return table->GetValueByName(row, column).ToDouble();
}

/// What stock VTK measures of the stock contour.
struct StockMeasures
{
  StockMeasures(vtkImageData* image, double isovalue)
  {
    vtkNew<vtkMassProperties> mass;
    mass->SetInputData(RunFlyingEdges(image, isovalue, false));
    this->Area = mass->GetSurfaceArea();
    this->Volume = mass->GetVolume();
  }
  double Area;
  double Volume;
};

vtkSmartPointer<vtkImageData> MakeBall(int type, double scale)
{
  auto image = MakeImage({ -40, 39, 3, 60, 0, 70 }, type,
    [&](int i, int j, int k)
    { return std::max(0.0, 200 - scale * std::hypot(0.8 * i, j - 30, 0.9 * (k - 35))); });
  image->SetSpacing(0.8, 1, 0.9);
  image->SetOrigin(5, -1000, 3);
  return image;
}

} // namespace

TEST(ContourSpectrum, OfManySamplesIsCountedBesideWhoeverWantsToAnswer)
{
  const auto image = MakeImage({ 0, 70, 0, 33, 0, 64 }, VTK_FLOAT, MakeWaves(30));
  vtkNew<vtkContourSpectrum> spectrum;
  const ExpectNoErrors errors(spectrum);
  spectrum->SetInputDataObject(image);
  spectrum->CountBeside(1000);
  const auto read = [&] { return Refinement::FromValues(spectrum->GetRefinement()); };
  const auto begin = [&]
  {
    spectrum->Update();
    EXPECT_EQ(spectrum->GetOutput()->GetNumberOfRows(), 0);
    EXPECT_EQ(read().Stage, RefinementStage::Working);
  };
  const auto finish = [&]
  {
    for (int tries = 0; read().Stage == RefinementStage::Working && tries < 1000; ++tries)
    {
      spectrum->AdvanceCounting(100);
    }
    EXPECT_EQ(read().Stage, RefinementStage::Ready);
    EXPECT_EQ(read().Share, 1);
    spectrum->TakeCounting();
    spectrum->Update();
    const auto expected = MakeTable(image);
    EXPECT_GT(expected->GetNumberOfRows(), 1000);
    EXPECT_EQ(Print(spectrum->GetOutput()), Print(expected));
    EXPECT_EQ(read().Stage, RefinementStage::None);
  };
  begin();
  finish();
  // What was begun is not that of other samples.
  image->GetPointData()->GetScalars()->SetComponent(5000, 0, 1234);
  image->GetPointData()->GetScalars()->Modified();
  image->Modified();
  begin();
  image->GetPointData()->GetScalars()->SetComponent(5000, 0, -1234);
  image->GetPointData()->GetScalars()->Modified();
  image->Modified();
  begin();
  finish();
  // Few samples are counted at once.
  spectrum->CountBeside(1000000);
  spectrum->Modified();
  spectrum->Update();
  EXPECT_EQ(Print(spectrum->GetOutput()), Print(MakeTable(image)));
}

TEST(ContourSpectrum, CountsTheTrianglesOfFlyingEdges)
{
  const auto noise = MakeImage({ -3, 40, 5, 37, 0, 33 }, VTK_UNSIGNED_CHAR, MakeNoise(200, 4));
  const auto waves = MakeImage({ 0, 70, 0, 33, 0, 64 }, VTK_FLOAT, MakeWaves(30));
  std::mt19937 random(2);
  for (vtkImageData* image : { noise.Get(), waves.Get() })
  {
    const auto table = MakeTable(image);
    EXPECT_STREQ(table->GetColumnName(0), "Isovalue");
    EXPECT_EQ(table->GetNumberOfColumns(), 7);
    ASSERT_GE(table->GetNumberOfRows(), 200);
    for (int test = 0; test < 8; ++test)
    {
      const vtkIdType row = static_cast<vtkIdType>(random()) % table->GetNumberOfRows();
      const double isovalue = GetValue(table, row, "Isovalue");
      EXPECT_EQ(table->GetValueByName(row, "Triangles").ToTypeInt64(),
        RunFlyingEdges(image, isovalue, false)->GetNumberOfPolys())
        << isovalue;
    }
  }
}

TEST(ContourSpectrum, MeasuresAreaAndVolumeAsStockFiltersDo)
{
  for (const auto& ball : { MakeBall(VTK_FLOAT, 6), MakeBall(VTK_SHORT, 6) })
  {
    const auto table = MakeTable(ball);
    for (const double isovalue : { 70.0, 130.0 })
    {
      const vtkIdType row = table->GetNumberOfRows() * static_cast<vtkIdType>(isovalue) / 200;
      const StockMeasures stock(ball, GetValue(table, row, "Isovalue"));
      EXPECT_NEAR(GetValue(table, row, "Area") / stock.Area, 1, 0.03) << isovalue;
      EXPECT_NEAR(GetValue(table, row, "Volume") / stock.Volume, 1, 0.01) << isovalue;
    }
  }
}

TEST(ContourSpectrum, StaysNearTheAreaOfTheTrianglesOfAScan)
{
  if (!std::ifstream(ISOSURFACE_MRI_SCAN).good())
  {
    GTEST_SKIP() << "the package mricron-data is not installed";
  }
  vtkNew<vtkNIFTIImageReader> reader;
  reader->SetFileName(ISOSURFACE_MRI_SCAN);
  reader->Update();
  const auto table = MakeTable(reader->GetOutput());
  ASSERT_EQ(table->GetNumberOfRows(), 255); // a row a value
  const StockMeasures stock(reader->GetOutput(), GetValue(table, 120, "Isovalue"));
  EXPECT_NEAR(GetValue(table, 120, "Area") / stock.Area, 1, 0.08);
}

TEST(ContourSpectrum, OfPiecesIsThatOfTheWhole)
{
  const auto image = MakeImage({ -3, 70, 5, 57, 0, 43 }, VTK_SHORT, MakeWaves(500));
  const auto whole = MakeTable(image);
  vtkNew<vtkPartitionedDataSet> pieces;
  // Cut where no block ends, with and without ghosts.
  pieces->SetPartition(0, CutImage(image, { -3, 18, 5, 57, 0, 43 }));
  pieces->SetPartition(1, CutImage(image, { 16, 70, 5, 28, 0, 43 }, { 18, 70, 5, 26, 0, 43 }));
  pieces->SetPartition(2, CutImage(image, { 18, 70, 26, 57, 0, 43 }));
  const auto cut = MakeTable(pieces);
  ASSERT_EQ(cut->GetNumberOfRows(), whole->GetNumberOfRows());
  for (vtkIdType row = 0; row < whole->GetNumberOfRows(); ++row)
  {
    for (vtkIdType column = 0; column < whole->GetNumberOfColumns(); ++column)
    {
      ASSERT_EQ(cut->GetValue(row, column), whole->GetValue(row, column))
        << row << ' ' << whole->GetColumnName(column);
    }
  }
}

TEST(ContourSpectrum, OfSeveralGridsIsTheirSum)
{
  const auto fine = MakeBall(VTK_SHORT, 6);
  const auto coarse = MakeBall(VTK_SHORT, 6);
  coarse->SetSpacing(1.6, 2, 1.8);
  vtkNew<vtkPartitionedDataSet> both;
  both->SetPartition(0, fine);
  both->SetPartition(1, coarse);
  const auto one = MakeTable(fine);
  const auto sum = MakeTable(both);
  EXPECT_EQ(GetValue(sum, 90, "Triangles"), 2 * GetValue(one, 90, "Triangles"));
  EXPECT_NEAR(GetValue(sum, 90, "Area"), 5 * GetValue(one, 90, "Area"), 1e-6);
  EXPECT_NEAR(GetValue(sum, 90, "Volume"), 9 * GetValue(one, 90, "Volume"), 1e-3);
}

TEST(ContourSpectrum, CountsTheArrayThatIsAskedFor)
{
  const auto image =
    MakeImage({ 0, 10, 0, 10, 0, 10 }, VTK_SHORT, [](int i, int, int) { return i; });
  const auto other =
    MakeImage({ 0, 10, 0, 10, 0, 10 }, VTK_SHORT, [](int, int j, int) { return 50 + 3 * j; });
  other->GetPointData()->GetScalars()->SetName("other");
  image->GetPointData()->AddArray(other->GetPointData()->GetScalars());
  EXPECT_EQ(MakeTable(image)->GetNumberOfRows(), 11);
  const auto table = MakeTable(image, "other");
  EXPECT_EQ(table->GetNumberOfRows(), 31);
  EXPECT_EQ(GetValue(table, 0, "Isovalue"), 50);
  EXPECT_NEAR(GetValue(table, 1, "Area"), 100, 1e-3);
}

TEST(ContourSpectrum, BearsNaNAndInputsOfNoCells)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto holes = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_DOUBLE,
    [&](int i, int j, int k) { return (i * j * k) % 7 == 3 ? nan : i + 0.1 * j; });
  const auto table = MakeTable(holes);
  ASSERT_GT(table->GetNumberOfRows(), 1000);
  for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
  {
    ASSERT_TRUE(std::isfinite(GetValue(table, row, "Area")));
    ASSERT_GE(GetValue(table, row, "Volume"), 0);
    ASSERT_LE(GetValue(table, row, "Volume"), 8000);
  }
  const auto nothing =
    MakeImage({ 0, 5, 0, 5, 0, 5 }, VTK_FLOAT, [&](int, int, int) { return nan; });
  EXPECT_EQ(MakeTable(nothing)->GetNumberOfRows(), 0);
  const auto flat = MakeImage({ 0, 5, 0, 5, 2, 2 }, VTK_FLOAT, MakeWaves());
  const auto ofFlat = MakeTable(flat);
  EXPECT_EQ(GetValue(ofFlat, ofFlat->GetNumberOfRows() / 2, "Triangles"), 0);
  vtkNew<vtkImageData> empty;
  EXPECT_EQ(MakeTable(empty)->GetNumberOfRows(), 0);
}

TEST(ContourSpectrum, TellsWhatItCannotCount)
{
  const auto expectError =
    [](vtkDataObject* input, int association, const char* array, const char* reason)
  {
    vtkNew<vtkContourSpectrum> spectrum;
    const ErrorCounter errors(spectrum);
    spectrum->SetInputDataObject(input);
    spectrum->SetInputArrayToProcess(0, 0, 0, association, array);
    spectrum->Update();
    ExpectOneError(errors, { reason });
    EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 0);
  };
  const auto image = MakeImage({ 0, 5, 0, 5, 0, 5 }, VTK_SHORT, MakeWaves(9));
  expectError(image, vtkDataObject::FIELD_ASSOCIATION_POINTS, "nothing", "no point array");
  vtkNew<vtkFloatArray> ofCells;
  ofCells->SetName("cells");
  ofCells->SetNumberOfValues(image->GetNumberOfCells());
  image->GetCellData()->AddArray(ofCells);
  expectError(image, vtkDataObject::FIELD_ASSOCIATION_POINTS, "cells", "cell arrays \"cells\"");
  vtkNew<vtkPartitionedDataSet> mixed;
  mixed->SetPartition(0, image);
  const auto bytes = MakeImage({ 0, 5, 0, 5, 5, 9 }, VTK_UNSIGNED_CHAR, MakeNoise(9, 1));
  mixed->SetPartition(1, bytes);
  expectError(mixed, vtkDataObject::FIELD_ASSOCIATION_POINTS, "density", "several types");
}

TEST(ContourSpectrum, CellArrayIsMeasuredAsBehindCellDataToPointData)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(21, 20, 19);
  const auto samples = MakeImage({ 0, 19, 0, 18, 0, 17 }, VTK_SHORT, MakeWaves(90));
  image->GetCellData()->SetScalars(samples->GetPointData()->GetScalars());
  vtkNew<vtkCellDataToPointData> convert;
  convert->SetInputData(image);
  convert->Update();
  const auto expected = MakeTable(convert->GetOutput());
  const auto table = MakeTable(image);
  ASSERT_EQ(table->GetNumberOfRows(), expected->GetNumberOfRows());
  EXPECT_GT(table->GetNumberOfRows(), 0);
  for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
  {
    for (const char* quantity : { "Isovalue", "Triangles", "ActiveCells", "Area", "Volume" })
    {
      ASSERT_EQ(GetValue(table, row, quantity), GetValue(expected, row, quantity)) << quantity;
    }
  }
}
