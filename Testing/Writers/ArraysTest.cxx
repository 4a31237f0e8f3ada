// SPDX-License-Identifier: BSD-3-Clause
// Arrays of several components from writer to surface; which arrays are written.
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkCellData.h"
#include "vtkCellDataToPointData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDataArraySelection.h"
#include "vtkFloatArray.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPassThrough.h"
#include "vtkPointData.h"
#include "vtkTestErrorObserver.h"
#include "vtkTrivialProducer.h"

#include <array>
#include <cmath>
#include <map>
#include <vector>

using namespace isosurface;

namespace
{

constexpr Extent Grid{ -3, 34, 2, 22, -35, -15 };

/// An image whose active scalars "velocity" have several components.
vtkSmartPointer<vtkImageData> MakeVectors(int type, int components)
{
  auto image = MakeImage(Grid, type, MakeWaves(100));
  auto vectors = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type));
  vectors->SetName("velocity");
  vectors->SetNumberOfComponents(components);
  vectors->SetNumberOfTuples(image->GetNumberOfPoints());
  const double shift = vtkDataArray::GetDataTypeMin(type) < 0 ? 0 : 110;
  for (int component = 0; component < components; ++component)
  {
    const auto waves = MakeWaves(100.0 / (component + 1));
    vtkIdType point = 0;
    for (int k = Grid[4]; k <= Grid[5]; ++k)
    {
      for (int j = Grid[2]; j <= Grid[3]; ++j)
      {
        for (int i = Grid[0]; i <= Grid[1]; ++i)
        {
          vectors->SetComponent(point++, component, shift + waves(i + 5 * component, j, k));
        }
      }
    }
  }
  image->GetPointData()->SetScalars(vectors);
  return image;
}

class Arrays : public testing::Test
{
protected:
  // Writes an input; the errors and warnings.
  bool Write(vtkImageData* image, std::string& errors, std::string& warnings,
    const std::vector<std::string>& chosen = {})
  {
    vtkNew<vtkBlockedVolumeWriter> writer;
    vtkNew<vtkTest::ErrorObserver> observer;
    writer->AddObserver(vtkCommand::ErrorEvent, observer);
    writer->AddObserver(vtkCommand::WarningEvent, observer);
    writer->SetInputData(image);
    writer->SetFileName(this->Path.c_str());
    writer->SetChooseArraysToWrite(!chosen.empty());
    for (const std::string& name : chosen)
    {
      writer->GetPointDataArraySelection()->EnableArray(name.c_str());
    }
    const bool isWritten = writer->Write() == 1;
    errors = observer->GetError() ? observer->GetErrorMessage() : "";
    warnings = observer->GetWarning() ? observer->GetWarningMessage() : "";
    return isWritten;
  }

  std::vector<std::string> ListArrays()
  {
    const auto reader = MakeReader(this->Path);
    reader->UpdateInformation();
    std::vector<std::string> names;
    for (int index = 0; index < reader->GetNumberOfPointArrays(); ++index)
    {
      names.emplace_back(reader->GetPointArrayName(index));
    }
    return names;
  }

  static void AddArray(vtkDataSetAttributes* attributes, vtkIdType tuples, const char* name)
  {
    vtkNew<vtkFloatArray> array;
    array->SetName(name);
    array->SetNumberOfTuples(tuples);
    array->FillValue(1);
    attributes->AddArray(array);
  }

  const ScratchFolder Folder;
  const std::string Path = this->Folder.GetPath("volume.bvol");
};

} // namespace

TEST_F(Arrays, OfSeveralComponentsAreInterpolatedAsOneArrayOfTuples)
{
  const auto image = MakeVectors(VTK_SHORT, 3);
  WriteVolume(image, this->Path, { 16, 2 });
  const auto reader = MakeReader(this->Path);
  vtkNew<vtkPassThrough> pass;
  pass->SetInputConnection(reader->GetOutputPort());
  vtkNew<vtkTrivialProducer> inMemory;
  inMemory->SetOutput(image);
  std::vector<std::map<vtkIdType, std::array<double, 3>>> found;
  for (vtkAlgorithm* input : std::vector<vtkAlgorithm*>{ inMemory, reader, pass })
  {
    vtkNew<vtkStabbingContour> contour;
    contour->SetInputConnection(input->GetOutputPort());
    SelectPoints(contour, "velocity");
    contour->SetComponent(1);
    contour->SetValue(0, 30.5);
    contour->ComputeScalarsOff();
    contour->AddInterpolatedArray("velocity");
    contour->Update();
    vtkPointData* points = contour->GetOutput()->GetPointData();
    vtkDataArray* vectors = points->GetArray("velocity");
    ASSERT_NE(vectors, nullptr);
    ASSERT_EQ(vectors->GetNumberOfComponents(), 3);
    found.emplace_back();
    for (vtkIdType point = 0; point < vectors->GetNumberOfTuples(); ++point)
    {
      std::array<double, 3>& tuple =
        found.back()[static_cast<vtkIdType>(points->GetGlobalIds()->GetTuple1(point))];
      vectors->GetTuple(point, tuple.data());
      ASSERT_NEAR(tuple[1], 30.5, 1e-5);
    }
  }
  EXPECT_GT(found[0].size(), 100u);
  EXPECT_EQ(found[0], found[1]);
  EXPECT_EQ(found[0], found[2]);
}

TEST_F(Arrays, HaveNoComponentBehindTheMagnitude)
{
  const auto image = MakeVectors(VTK_FLOAT, 3);
  WriteVolume(image, this->Path);
  const auto reader = MakeReader(this->Path);
  for (const bool isInMemory : { true, false })
  {
    vtkNew<vtkStabbingContour> contour;
    const ErrorCounter errors(contour);
    contour->SetInputData(image);
    if (!isInMemory)
    {
      contour->SetInputConnection(reader->GetOutputPort());
    }
    contour->SetComponent(4);
    contour->SetValue(0, 80);
    contour->Update();
    ExpectOneError(errors, { "\"velocity\" has 3 components", "no component 4" });
    contour->SetComponent(3);
    contour->Update();
    EXPECT_EQ(errors.Messages.size(), 1u);
    EXPECT_GT(contour->GetOutput()->GetNumberOfPolys(), 0);
  }
}

TEST_F(Arrays, OfOneComponentAreContouredWhateverComponentIsChosen)
{
  const auto image = MakeImage(Grid, VTK_SHORT, MakeWaves(100));
  WriteVolume(image, this->Path);
  const auto reader = MakeReader(this->Path);
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetComponent(2);
  contour->SetValue(0, 20.5);
  contour->Update();
  EdgeSurface surface = ToEdges(contour->GetOutput());
  EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(image, 20.5)));
}

TEST_F(Arrays, OfCellsAloneAreAnErrorThatTellsWhatToDo)
{
  vtkNew<vtkImageData> image;
  image->SetDimensions(5, 5, 5);
  AddArray(image->GetCellData(), 64, "pressure");
  std::string errors;
  std::string warnings;
  EXPECT_FALSE(this->Write(image, errors, warnings));
  EXPECT_NE(errors.find("\"pressure\""), std::string::npos) << errors;
  EXPECT_NE(errors.find("Cell Data to Point Data"), std::string::npos) << errors;
}

TEST_F(Arrays, OfCellsBesideThoseOfPointsAreWarnedOf)
{
  const auto image = MakeImage(Grid, VTK_SHORT, MakeWaves(100));
  AddArray(image->GetCellData(), image->GetNumberOfCells(), "pressure");
  std::string errors;
  std::string warnings;
  EXPECT_TRUE(this->Write(image, errors, warnings));
  EXPECT_EQ(errors, "");
  EXPECT_NE(warnings.find("\"pressure\""), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("Cell Data to Point Data"), std::string::npos) << warnings;
  EXPECT_EQ(this->ListArrays(), std::vector<std::string>{ "density" });

  // Not if the arrays are chosen, nor of ghosts.
  EXPECT_TRUE(this->Write(image, errors, warnings, { "density" }));
  EXPECT_EQ(warnings, "");
  EXPECT_TRUE(this->Write(CutImage(image, Grid, { -3, 30, 2, 22, -35, -15 }), errors, warnings));
  EXPECT_EQ(warnings, "");
}

TEST_F(Arrays, OfCellsAreAveragedOnRequest)
{
  const auto image = MakeImage(Grid, VTK_SHORT, MakeWaves(100));
  vtkNew<vtkFloatArray> pressure;
  pressure->SetName("pressure");
  for (vtkIdType cell = 0; cell < image->GetNumberOfCells(); ++cell)
  {
    pressure->InsertNextValue(static_cast<float>(std::sin(0.3 * static_cast<double>(cell))));
  }
  image->GetCellData()->AddArray(pressure);
  vtkNew<vtkCellDataToPointData> convert;
  convert->SetInputData(image);
  convert->Update();
  auto* expected = vtkImageData::SafeDownCast(convert->GetOutput());

  vtkNew<vtkBlockedVolumeWriter> writer;
  const ExpectNoErrors errors(writer);
  writer->SetInputData(image);
  writer->SetFileName(this->Path.c_str());
  writer->WriteCellArraysOn();
  EXPECT_EQ(writer->Write(), 1);
  EXPECT_EQ(this->ListArrays(), (std::vector<std::string>{ "density", "pressure" }));
  const auto reader = MakeReader(this->Path);
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  SelectPoints(contour, "pressure");
  contour->SetValue(0, 0.25);
  contour->Update();
  EdgeSurface surface = ToEdges(contour->GetOutput());
  expected->GetPointData()->SetActiveScalars("pressure");
  EXPECT_FALSE(surface.Triangles.empty());
  EXPECT_TRUE(AreEqual(surface, ContourByFlyingEdges(expected, 0.25)));
}

TEST_F(Arrays, AreChosenByName)
{
  const auto image = MakeVectors(VTK_FLOAT, 3);
  AddArray(image->GetPointData(), image->GetNumberOfPoints(), "a");
  AddArray(image->GetPointData(), image->GetNumberOfPoints(), "b");
  AddArray(image->GetCellData(), image->GetNumberOfCells(), "pressure");
  std::string errors;
  std::string warnings;
  EXPECT_TRUE(this->Write(image, errors, warnings, { "b", "velocity" }));
  EXPECT_EQ(errors + warnings, "");
  EXPECT_EQ(this->ListArrays(), (std::vector<std::string>{ "velocity", "b" }));

  EXPECT_FALSE(this->Write(image, errors, warnings, { "b", "pressure" }));
  EXPECT_NE(errors.find("\"pressure\" is a cell array"), std::string::npos) << errors;
  EXPECT_FALSE(this->Write(image, errors, warnings, { "c" }));
  EXPECT_NE(errors.find("no numeric point array \"c\""), std::string::npos) << errors;
  // What was there before is there still.
  EXPECT_EQ(this->ListArrays(), (std::vector<std::string>{ "velocity", "b" }));
}
