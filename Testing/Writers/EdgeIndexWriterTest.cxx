// SPDX-License-Identifier: BSD-3-Clause
// What is written is the surface of vtkFlyingEdges3D, and of vtkStabbingContour, without making it.
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"
#include "TimeSource.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkClipPolyData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkEdgeIndexReader.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkPassThrough.h"
#include "vtkPlane.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"
#include "vtkTestErrorObserver.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkUniformGrid.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace isosurface
{
namespace
{

constexpr Extent SurfaceGrid{ -3, 66, 0, 40, 5, 53 };

// A contour of an image or volume, and a writer of it.
class EdgeIndexWriter : public testing::Test
{
protected:
  EdgeIndexWriter()
  {
    this->Writer->SetInputConnection(this->Contour->GetOutputPort());
    this->Writer->SetFileName(this->Path.c_str());
    this->SetIsovalues({ 150.0, 60.5 });
  }

  void SetIsovalues(const std::vector<double>& isovalues)
  {
    isosurface::SetIsovalues(this->Contour, isovalues);
  }

  // Puts the image as a blocked volume before the contour.
  void UseVolume(vtkImageData* image, int blockSize = 16)
  {
    VolumeSettings settings;
    settings.BlockSize = blockSize;
    settings.NumberOfStores = 3;
    const std::string path = this->Folder.GetPath("volume.bvol");
    WriteVolume(image, path, settings);
    this->Volume->SetFileName(path.c_str());
    this->Contour->SetInputConnection(this->Volume->GetOutputPort());
  }

  void Write()
  {
    const ExpectNoErrors errors(this->Writer);
    const ExpectNoErrors contourErrors(this->Contour);
    EXPECT_EQ(this->Writer->Write(), 1);
  }

  // Tries to write over another file; what the writer says.
  std::string WriteInVain()
  {
    WriteBytes(this->Path, "before");
    const ErrorCounter errors(this->Writer);
    EXPECT_EQ(this->Writer->Write(), 0);
    EXPECT_EQ(ReadBytes(this->Path), "before");
    EXPECT_FALSE(std::filesystem::exists(this->Path + ".part"));
    EXPECT_EQ(errors.Messages.size(), 1u);
    return errors.Messages.empty() ? "" : errors.Messages.front();
  }

  vtkSmartPointer<vtkPolyData> Read(const std::string& path)
  {
    vtkNew<vtkEdgeIndexReader> reader;
    const ExpectNoErrors errors(reader);
    reader->SetFileName(path.c_str());
    reader->Update();
    return reader->GetOutput();
  }

  // All isovalues' surfaces in one: ids tell them apart.
  static EdgeSurface ToEdges(vtkPolyData* surface)
  {
    EdgeSurface edges = isosurface::ToEdges(surface);
    edges.DropNormals();
    return edges;
  }

  // What the contour extracts of what it has for its input.
  EdgeSurface Extract()
  {
    this->Contour->Update();
    return ToEdges(this->Contour->GetOutput());
  }

  ScratchFolder Folder;
  const std::string Path = Folder.GetPath("surface.eix");
  vtkNew<vtkBlockedVolumeReader> Volume;
  vtkNew<vtkStabbingContour> Contour;
  vtkNew<vtkEdgeIndexWriter> Writer;
};

} // namespace

TEST_F(EdgeIndexWriter, ProfilesOfOlderStatesBecomeTheNearestWithAWarning)
{
  vtkNew<vtkTest::ErrorObserver> observer;
  this->Writer->AddObserver(vtkCommand::WarningEvent, observer);
  for (const auto& [older, now] :
    { std::pair(1, vtkEdgeIndexWriter::WORKING), std::pair(2, vtkEdgeIndexWriter::SMALL) })
  {
    this->Writer->SetProfile(older);
    EXPECT_EQ(this->Writer->GetProfile(), now);
    EXPECT_TRUE(observer->GetWarning());
    observer->Clear();
    this->Writer->SetProfile(now);
    EXPECT_FALSE(observer->GetWarning());
  }
}

TEST_F(EdgeIndexWriter, LevelsRegionsAndComponentsAreThoseOfTheContour)
{
  const auto image = MakeClosedVolume(SurfaceGrid, VTK_SHORT);
  const auto check = [this](const char* what)
  {
    this->Write();
    const EdgeSurface expected = this->Extract();
    EXPECT_GT(expected.Triangles.size(), 100u) << what;
    EXPECT_TRUE(AreEqual(ToEdges(this->Read(this->Path)), expected)) << what;
  };
  const auto checkRegion = [&](const char* what)
  {
    this->Contour->SetUseRegion(true);
    const double bounds[6] = { 10, 30, 10, 20, 20, 60 };
    this->Contour->SetRegionBounds(bounds);
    check(what);
    this->Contour->SetUseRegion(false);
  };
  this->Contour->SetInputData(image);
  check("an image");
  checkRegion("a region of an image");
  this->UseVolume(image);
  check("a volume");
  for (const int islands : { 0, 1 })
  {
    this->Contour->SetMaximumIslands(islands);
    checkRegion("a region of a volume");
    for (const int level : { 1, 2, 0 })
    {
      this->Contour->SetLevel(level);
      check("a level");
    }
  }
  this->Contour->SetMaximumIslands(0);

  vtkNew<vtkImageData> vectors;
  vectors->SetExtent(image->GetExtent());
  vectors->AllocateScalars(VTK_FLOAT, 2);
  vtkDataArray* samples = vectors->GetPointData()->GetScalars();
  samples->SetName("vectors");
  for (vtkIdType n = 0; n < samples->GetNumberOfTuples(); ++n)
  {
    const double value = image->GetPointData()->GetScalars()->GetTuple1(n);
    samples->SetTuple2(n, 100 - value, 2 * value);
  }
  this->Contour->SetInputData(vectors);
  for (const int component : { 0, 1, 2 })
  {
    this->SetIsovalues({ component == 0 ? 10.0 : 120.0 });
    this->Contour->SetComponent(component);
    check("a component, or the magnitude");
  }
}

TEST_F(EdgeIndexWriter, ArraysAndNormalsAreThoseOfTheContour)
{
  const auto image = MakeClosedVolume(SurfaceGrid, VTK_SHORT);
  vtkNew<vtkDoubleArray> depth;
  depth->SetName("depth");
  depth->SetNumberOfComponents(2);
  for (vtkIdType n = 0; n < image->GetNumberOfPoints(); ++n)
  {
    depth->InsertNextTuple2(0.1 * static_cast<double>(n % 70), std::sqrt(static_cast<double>(n)));
  }
  image->GetPointData()->AddArray(depth);
  this->Contour->AddInterpolatedArray("depth");
  this->Writer->SetWriteNormals(true);
  this->Writer->SetNormalError(0);
  for (const bool fromVolume : { false, true })
  {
    if (fromVolume)
    {
      this->UseVolume(image, 32);
    }
    else
    {
      this->Contour->SetInputData(image);
    }
    this->Contour->SetMaximumIslands(fromVolume ? 1 : 0);
    this->Contour->Update();
    std::map<double, vtkIdType> points;
    vtkPointData* exact = this->Contour->GetOutput()->GetPointData();
    for (vtkIdType n = 0; n < this->Contour->GetOutput()->GetNumberOfPoints(); ++n)
    {
      points[exact->GetGlobalIds()->GetTuple1(n)] = n;
    }
    for (const double error : { 0.0, 0.25 })
    {
      this->Writer->SetArrayError(error);
      this->Write();
      const auto read = this->Read(this->Path);
      vtkPointData* data = read->GetPointData();
      EXPECT_EQ(read->GetNumberOfPoints(), static_cast<vtkIdType>(points.size()));
      ASSERT_NE(data->GetNormals(), nullptr);
      ASSERT_NE(data->GetArray("depth"), nullptr);
      EXPECT_EQ(data->GetArray("depth")->GetDataType(), VTK_DOUBLE);
      double worst = 0;
      double worstNormal = 0;
      for (vtkIdType n = 0; n < read->GetNumberOfPoints(); ++n)
      {
        const vtkIdType at = points.at(data->GetGlobalIds()->GetTuple1(n));
        for (int c = 0; c < 3; ++c)
        {
          worstNormal = std::max(worstNormal,
            std::abs(
              data->GetNormals()->GetComponent(n, c) - exact->GetNormals()->GetComponent(at, c)));
        }
        for (int c = 0; c < 2; ++c)
        {
          worst = std::max(worst,
            std::abs(data->GetArray("depth")->GetComponent(n, c) -
              exact->GetArray("depth")->GetComponent(at, c)));
        }
      }
      EXPECT_EQ(worstNormal, 0);
      EXPECT_LE(worst, error);
      EXPECT_EQ(worst > 0, error > 0);
    }
  }
  this->Writer->SetWriteArrays(false);
  this->Write();
  EXPECT_EQ(this->Read(this->Path)->GetPointData()->GetArray("depth"), nullptr);
}

TEST_F(EdgeIndexWriter, WithoutNormalsInTheFileThoseOfTheTrianglesAreTaken)
{
  const auto image = MakeImage(SurfaceGrid, VTK_FLOAT,
    [](int i, int j, int k) {
      return 300 - 4 * std::sqrt((i - 30) * (i - 30) + (j - 20) * (j - 20) + (k - 30) * (k - 30));
    });
  this->Contour->SetInputData(image);
  this->SetIsovalues({ 240.5 });
  this->Contour->Update();
  std::map<double, vtkIdType> points;
  vtkPointData* exact = this->Contour->GetOutput()->GetPointData();
  for (vtkIdType n = 0; n < this->Contour->GetOutput()->GetNumberOfPoints(); ++n)
  {
    points[exact->GetGlobalIds()->GetTuple1(n)] = n;
  }
  this->Write();
  const auto read = this->Read(this->Path);
  vtkPointData* data = read->GetPointData();
  ASSERT_NE(data->GetNormals(), nullptr);
  double worst = 1;
  for (vtkIdType n = 0; n < read->GetNumberOfPoints(); ++n)
  {
    double mine[3];
    double expected[3];
    data->GetNormals()->GetTuple(n, mine);
    exact->GetNormals()->GetTuple(points.at(data->GetGlobalIds()->GetTuple1(n)), expected);
    worst = std::min(worst, mine[0] * expected[0] + mine[1] * expected[1] + mine[2] * expected[2]);
  }
  EXPECT_GT(worst, 0.97) << "the cosine of the largest angle between normals";
}

TEST_F(EdgeIndexWriter, MaximumTrianglesChoosesTheLevel)
{
  this->UseVolume(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  const EdgeSurface full = this->Extract();
  this->Contour->SetMaximumTriangles(static_cast<vtkIdType>(full.Triangles.size() / 2));
  this->Write();
  const auto read = this->Read(this->Path);
  EXPECT_LT(read->GetNumberOfPolys(), static_cast<vtkIdType>(full.Triangles.size() / 2));
  EXPECT_GT(read->GetNumberOfPolys(), static_cast<vtkIdType>(full.Triangles.size() / 20));
}

TEST_F(EdgeIndexWriter, TheContourMakesNothingAndKeepsWhatItHas)
{
  this->UseVolume(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  const EventCounter executions(this->Contour, vtkCommand::StartEvent);
  this->Write();
  EXPECT_EQ(executions.Count, 0);
  this->Contour->Update();
  EXPECT_EQ(executions.Count, 1);
  const vtkIdType triangles = this->Contour->GetOutput()->GetNumberOfPolys();
  EXPECT_GT(triangles, 0);
  this->Write();
  EXPECT_EQ(this->Contour->GetOutput()->GetNumberOfPolys(), triangles);
  this->Contour->Update();
  EXPECT_EQ(executions.Count, 1) << "writing made the contour's output out of date";
}

TEST_F(EdgeIndexWriter, ASurfaceThatWentThroughAFilterIsRefused)
{
  this->Contour->SetInputData(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  vtkNew<vtkPlane> plane;
  vtkNew<vtkClipPolyData> clip;
  clip->SetClipFunction(plane);
  clip->SetInputConnection(this->Contour->GetOutputPort());
  this->Writer->SetInputConnection(clip->GetOutputPort());
  const std::string message = this->WriteInVain();
  EXPECT_NE(message.find("Isosurface"), std::string::npos) << message;
  EXPECT_NE(message.find(".vtp"), std::string::npos) << message;

  vtkNew<vtkPassThrough> unchanged;
  unchanged->SetInputConnection(this->Contour->GetOutputPort());
  this->Writer->SetInputConnection(unchanged->GetOutputPort());
  this->Write();
}

TEST_F(EdgeIndexWriter, OptionsThatTheFileCannotHoldAreNamed)
{
  this->Contour->SetInputData(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  const auto expectRefusal = [this](const char* name)
  {
    const std::string message = this->WriteInVain();
    EXPECT_NE(message.find(name), std::string::npos) << message;
  };
  this->Contour->SetCloseBoundary(true);
  this->Writer->SetWriteNormals(true);
  expectRefusal("CloseBoundary");
  this->Writer->SetWriteNormals(false);
  this->Contour->SetCloseBoundary(false);
  this->Contour->SetDropDegenerateTriangles(true);
  expectRefusal("DropDegenerateTriangles");
  this->Contour->SetDropDegenerateTriangles(false);
  this->Contour->SetComputeIslandIds(true);
  expectRefusal("ComputeIslandIds");
  this->Contour->SetComputeIslandIds(false);
  this->Contour->SetSkipNotANumber(true);
  expectRefusal("SkipNotANumber");
  this->Contour->SetSkipNotANumber(false);
  this->Contour->SetGenerateTriangles(false);
  expectRefusal("GenerateTriangles");
  this->Contour->SetGenerateTriangles(true);
  this->Writer->SetMode(vtkEdgeIndexWriter::BOUNDED);
  this->Writer->SetMaximumError(0);
  expectRefusal("error");
  this->Writer->SetMaximumError(1e-9);
  expectRefusal("lossless");
}

TEST_F(EdgeIndexWriter, HiddenCellsAreRefused)
{
  vtkNew<vtkUniformGrid> grid;
  grid->ShallowCopy(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  grid->BlankCell(17);
  this->Contour->SetInputData(grid);
  const std::string message = this->WriteInVain();
  EXPECT_NE(message.find("hides cells"), std::string::npos) << message;
}

TEST_F(EdgeIndexWriter, ErrorsOfTheInputAreTold)
{
  this->Volume->SetFileName("/no/such/volume.bvol");
  this->Contour->SetInputConnection(this->Volume->GetOutputPort());
  const ErrorCounter readerErrors(this->Volume);
  this->WriteInVain();
  EXPECT_GE(readerErrors.Messages.size(), 1u);
  this->Contour->SetInputData(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  SelectPoints(this->Contour, "none");
  const std::string message = this->WriteInVain();
  EXPECT_NE(message.find("\"none\""), std::string::npos) << message;
}

TEST_F(EdgeIndexWriter, StoppingLeavesTheOldFile)
{
  this->UseVolume(MakeClosedVolume(SurfaceGrid, VTK_UNSIGNED_CHAR));
  WriteBytes(this->Path, "before");
  {
    const ProgressKeeper progress(
      this->Writer, [this](double) { this->Writer->SetAbortExecute(1); });
    EXPECT_EQ(this->Writer->Write(), 0);
  }
  EXPECT_EQ(ReadBytes(this->Path), "before");
  const ProgressKeeper progress(this->Writer);
  this->Write();
  EXPECT_TRUE(progress.IsRising());
}

TEST_F(EdgeIndexWriter, TimeStepsAreASeriesOfFiles)
{
  vtkNew<TimeSource> source;
  const std::vector<double> times = { -1, 0.5, 2 };
  source->SetTimes(times);
  this->Contour->SetInputConnection(source->GetOutputPort());
  this->SetIsovalues({ 12.5 });
  this->Writer->SetWriteAllTimeSteps(true);
  this->Write();
  EXPECT_FALSE(std::filesystem::exists(this->Path));
  for (std::size_t step = 0; step < times.size(); ++step)
  {
    vtkNew<vtkEdgeIndexReader> reader;
    reader->SetFileName(this->Folder.GetPath("surface_" + std::to_string(step) + ".eix").c_str());
    reader->Update();
    vtkInformation* info = reader->GetOutputInformation(0);
    using Pipeline = vtkStreamingDemandDrivenPipeline;
    ASSERT_EQ(info->Length(Pipeline::TIME_STEPS()), 1);
    EXPECT_EQ(info->Get(Pipeline::TIME_STEPS())[0], times[step]);
    EXPECT_EQ(
      reader->GetOutput()->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), times[step]);
    EdgeSurface expected = ContourByFlyingEdges(TimeSource::MakeImageAt(times[step]), 12.5);
    expected.DropNormals();
    EXPECT_TRUE(AreEqual(ToEdges(reader->GetOutput()), expected)) << "at " << times[step];
  }
  this->Writer->SetWriteAllTimeSteps(false);
  this->Contour->UpdateTimeStep(0.5);
  this->Write();
  EXPECT_TRUE(ReadBytes(this->Path) == ReadBytes(this->Folder.GetPath("surface_1.eix")));
}

} // namespace isosurface
