// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_TestImages_h
#define isosurface_TestImages_h

#include "EdgeSurface.h"

#include "vtkImageData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStabbingContour.h"
#include "vtkType.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

using Extent = std::array<int, 6>; ///< as vtkImageData has it

/// A value for each vertex, by its structured coordinates.
using Field = std::function<double(int, int, int)>;

/// An image with the active scalars "density" of a VTK type.
vtkSmartPointer<vtkImageData> MakeImage(const Extent& extent, int type, const Field& field);

/// A smooth field from about -amplitude to amplitude, with surfaces in every block.
Field MakeWaves(double amplitude = 1.0);

/// Whole numbers from 0 to levels - 1, at random, but the same for the same seed.
Field MakeNoise(int levels, unsigned int seed);

/// Adds the array "height" of an image's points: their z.
void AddHeights(vtkImageData* image);

/// The part of an image that lies in an extent. Its cells outside of `own` are marked as ghosts.
vtkSmartPointer<vtkImageData> CutImage(vtkImageData* image, const Extent& extent, Extent own);
vtkSmartPointer<vtkImageData> CutImage(vtkImageData* image, const Extent& extent);

/// Keeps what an object tells by an event, instead of its being printed.
class MessageKeeper
{
public:
  MessageKeeper(vtkObject* object, unsigned long event);
  ~MessageKeeper();
  MessageKeeper(const MessageKeeper&) = delete;
  MessageKeeper& operator=(const MessageKeeper&) = delete;

  std::vector<std::string> Messages;

private:
  void Keep(vtkObject*, unsigned long, void* text);

  vtkSmartPointer<vtkObject> Object;
  unsigned long Tag;
};

/// Keeps the errors of an object. What the executive of an algorithm adds, that there was an error,
/// is not printed either.
class ErrorCounter : public MessageKeeper
{
public:
  explicit ErrorCounter(vtkObject* object);

private:
  std::unique_ptr<MessageKeeper> OfExecutive;
};

/// Expects, at its end, that an object has reported no errors.
class ExpectNoErrors : public ErrorCounter
{
public:
  using ErrorCounter::ErrorCounter;
  ~ExpectNoErrors() { EXPECT_EQ(this->Messages, std::vector<std::string>()); }
};

/// Expects one message, in which all the words are.
void ExpectOneError(const MessageKeeper& errors, const std::vector<std::string>& words);

/// A contour of a data object, or of what an algorithm gives, with default options.
vtkSmartPointer<vtkStabbingContour> MakeContour(vtkDataObject* input, double isovalue);
vtkSmartPointer<vtkStabbingContour> MakeContour(vtkAlgorithm* input, double isovalue);

/// Lets an algorithm work on a point array.
void SelectPoints(vtkAlgorithm* algorithm, const char* array);

void SetIsovalues(vtkStabbingContour* contour, const std::vector<double>& isovalues);

/// A surface, or those of its triangles that have ids in a range.
EdgeSurface ToEdges(vtkPolyData* surface, std::int64_t firstId = 0, std::int64_t endId = INT64_MAX);

/// The output of a vtkStabbingContour with default options; a test fails if it reports an error.
vtkSmartPointer<vtkPolyData> Contour(vtkDataObject* input, const std::vector<double>& isovalues);

/// Expects this normal, up to 1e-5, at every point of a surface, and more than 1000 points.
void ExpectNormal(vtkPolyData* surface, const std::array<double, 3>& normal);

/// Expects GlobalIds, of which each is there once.
void ExpectDistinctIds(vtkPolyData* surface);

/// The output of Contour() as an EdgeSurface.
EdgeSurface ContourToEdges(vtkDataObject* input, double isovalue);

/// Whether a contour's output is the surface that vtkFlyingEdges3D makes of an image.
testing::AssertionResult IsSurfaceOf(vtkPolyData* surface, vtkImageData* image, double isovalue);

} // namespace isosurface

#endif
