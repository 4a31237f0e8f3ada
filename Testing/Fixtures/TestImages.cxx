// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkCallbackCommand.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkLogger.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"

#include <cmath>
#include <random>

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

ErrorCounter::ErrorCounter(vtkObject* object)
  : Object(object)
{
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(this);
  command->SetCallback(
    [](vtkObject*, unsigned long, void* self, void* message) {
      static_cast<ErrorCounter*>(self)->Messages.emplace_back(static_cast<const char*>(message));
    });
  this->Tag = object->AddObserver(vtkCommand::ErrorEvent, command);
}

ErrorCounter::~ErrorCounter()
{
  this->Object->RemoveObserver(this->Tag);
}

void ExpectOneError(const ErrorCounter& errors, const std::vector<std::string>& words)
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
  const ErrorCounter errors(contour);
  contour->SetInputDataObject(input);
  SetIsovalues(contour, isovalues);
  contour->Update();
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
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

EdgeSurface ContourToEdges(vtkDataObject* input, double isovalue)
{
  return ToEdges(Contour(input, { isovalue }));
}

} // namespace isosurface
