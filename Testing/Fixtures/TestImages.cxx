// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkFloatArray.h"
#include "vtkLogger.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"

#include <cmath>
#include <random>
#include <set>

namespace isosurface
{
namespace
{

// Each contour logs what it cost: thousands of lines that would hide a failure.
class QuietLog : public testing::Environment
{
  void SetUp() override { vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_WARNING); }
};
testing::Environment* const Quiet = testing::AddGlobalTestEnvironment(new QuietLog);

} // namespace

vtkSmartPointer<vtkImageData> MakeImage(const Extent& extent, int type, const Field& field)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(const_cast<int*>(extent.data()));
  image->AllocateScalars(type, 1);
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  samples->SetName("density");
  vtkIdType index = 0;
  for (int k = extent[4]; k <= extent[5]; ++k)
  {
    for (int j = extent[2]; j <= extent[3]; ++j)
    {
      for (int i = extent[0]; i <= extent[1]; ++i)
      {
        samples->SetComponent(index++, 0, field(i, j, k));
      }
    }
  }
  return image;
}

Field MakeWaves(double amplitude)
{
  return [amplitude](int i, int j, int k)
  {
    return amplitude *
      (std::sin(0.41 * i + 0.3) + std::sin(0.53 * j - 0.07 * k) + std::cos(0.47 * k + 0.05 * i)) /
      3.0;
  };
}

Field MakeNoise(int levels, unsigned int seed)
{
  return [levels, engine = std::mt19937(seed)](int, int, int) mutable
  { return static_cast<double>(engine() % static_cast<unsigned int>(levels)); };
}

void AddHeights(vtkImageData* image)
{
  vtkNew<vtkFloatArray> height;
  height->SetName("height");
  for (vtkIdType point = 0; point < image->GetNumberOfPoints(); ++point)
  {
    height->InsertNextValue(static_cast<float>(image->GetPoint(point)[2]));
  }
  image->GetPointData()->AddArray(height);
}

vtkSmartPointer<vtkImageData> CutImage(vtkImageData* image, const Extent& extent, Extent own)
{
  auto part = CutImage(image, extent);
  part->GenerateGhostArray(own.data(), true);
  return part;
}

vtkSmartPointer<vtkImageData> CutImage(vtkImageData* image, const Extent& extent)
{
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  auto part = MakeImage(extent, samples->GetDataType(),
    [&](int i, int j, int k)
    {
      int vertex[3] = { i, j, k };
      return samples->GetComponent(image->ComputePointId(vertex), 0);
    });
  part->SetOrigin(image->GetOrigin());
  part->SetSpacing(image->GetSpacing());
  part->SetDirectionMatrix(image->GetDirectionMatrix());
  return part;
}

MessageKeeper::MessageKeeper(vtkObject* object, unsigned long event)
  : Object(object)
  , Tag(object->AddObserver(event, this, &MessageKeeper::Keep))
{
}

MessageKeeper::~MessageKeeper()
{
  this->Object->RemoveObserver(this->Tag);
}

void MessageKeeper::Keep(vtkObject*, unsigned long, void* text)
{
  this->Messages.emplace_back(static_cast<const char*>(text));
}

ErrorCounter::ErrorCounter(vtkObject* object)
  : MessageKeeper(object, vtkCommand::ErrorEvent)
{
  if (auto* algorithm = vtkAlgorithm::SafeDownCast(object))
  {
    this->OfExecutive =
      std::make_unique<MessageKeeper>(algorithm->GetExecutive(), vtkCommand::ErrorEvent);
  }
}

void ExpectOneError(const MessageKeeper& errors, const std::vector<std::string>& words)
{
  ASSERT_EQ(errors.Messages.size(), 1u) << testing::PrintToString(errors.Messages);
  for (const std::string& word : words)
  {
    EXPECT_NE(errors.Messages.front().find(word), std::string::npos)
      << '"' << word << "\" is not in: " << errors.Messages.front();
  }
}

vtkSmartPointer<vtkStabbingContour> MakeContour(vtkDataObject* input, double isovalue)
{
  auto contour = vtkSmartPointer<vtkStabbingContour>::New();
  contour->SetInputDataObject(input);
  contour->SetValue(0, isovalue);
  return contour;
}

vtkSmartPointer<vtkStabbingContour> MakeContour(vtkAlgorithm* input, double isovalue)
{
  auto contour = vtkSmartPointer<vtkStabbingContour>::New();
  contour->SetInputConnection(input->GetOutputPort());
  contour->SetValue(0, isovalue);
  return contour;
}

void SelectPoints(vtkAlgorithm* algorithm, const char* array)
{
  algorithm->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, array);
}

void SetIsovalues(vtkStabbingContour* contour, const std::vector<double>& isovalues)
{
  contour->SetNumberOfContours(static_cast<int>(isovalues.size()));
  for (std::size_t number = 0; number < isovalues.size(); ++number)
  {
    contour->SetValue(static_cast<int>(number), isovalues[number]);
  }
}

EdgeSurface ToEdges(vtkPolyData* surface, std::int64_t firstId, std::int64_t endId)
{
  EdgeSurface edges;
  edges.Add(surface, firstId, endId);
  return edges;
}

vtkSmartPointer<vtkPolyData> Contour(vtkDataObject* input, const std::vector<double>& isovalues)
{
  vtkNew<vtkStabbingContour> contour;
  const ExpectNoErrors errors(contour);
  contour->SetInputDataObject(input);
  SetIsovalues(contour, isovalues);
  contour->Update();
  return contour->GetOutput();
}

void ExpectNormal(vtkPolyData* surface, const std::array<double, 3>& normal)
{
  ASSERT_GT(surface->GetNumberOfPoints(), 1000);
  ASSERT_NE(surface->GetPointData()->GetNormals(), nullptr);
  for (vtkIdType point = 0; point < surface->GetNumberOfPoints(); ++point)
  {
    const double* found = surface->GetPointData()->GetNormals()->GetTuple(point);
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      ASSERT_NEAR(found[axis], normal[axis], 1e-5) << "of point " << point;
    }
  }
}

void ExpectDistinctIds(vtkPolyData* surface)
{
  vtkDataArray* ids = surface->GetPointData()->GetGlobalIds();
  ASSERT_NE(ids, nullptr);
  std::set<double> distinct;
  for (vtkIdType point = 0; point < ids->GetNumberOfTuples(); ++point)
  {
    distinct.insert(ids->GetTuple1(point));
  }
  EXPECT_EQ(static_cast<vtkIdType>(distinct.size()), surface->GetNumberOfPoints());
}

EdgeSurface ContourToEdges(vtkDataObject* input, double isovalue)
{
  return ToEdges(Contour(input, { isovalue }));
}

testing::AssertionResult IsSurfaceOf(vtkPolyData* surface, vtkImageData* image, double isovalue)
{
  return AreEqual(ToEdges(surface), ContourByFlyingEdges(image, isovalue));
}

} // namespace isosurface
