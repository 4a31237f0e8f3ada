// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/TestBlockSource.h"
#include "Surface/Contour/GridBlockSource.h"
#include "Surface/Contour/SurfaceExtractor.h"

#include <gtest/gtest.h>

#include <new>
#include <random>

using namespace isosurface;

namespace
{

struct SurfaceErrors : testing::Test
{
  std::mt19937 Random{ 60 };
  SampleVolume<float> Volume = MakeRandomVolume<float>(this->Random, { 40, 40, 40 }, 10);
  ContourRequest Request;

  void SetUp() override { this->Request.Isovalues = { 1.5 }; }

  StatusCode Extract(BlockSource& source, int threads = 2, const Progress& progress = {})
  {
    const Result<Surface> surface =
      ExtractSurface(this->Volume.Geometry, source, this->Request, threads, progress);
    this->Message = surface.GetStatus().GetMessage();
    return surface.GetStatus().GetCode();
  }
  std::string Message;
};

// A source whose blocks have wrong lattice coordinates or vertices.
struct DisplacedSource : TestBlockSource<float>
{
  using TestBlockSource<float>::TestBlockSource;
  Index3 LatticeShift{ 0, 0, 0 };
  Index3 VertexShift{ 0, 0, 0 };
  Index3 GetLatticeCoordinates(std::size_t block) const override
  {
    Index3 lattice = TestBlockSource<float>::GetLatticeCoordinates(block);
    for (int axis = 0; block == 1 && axis < 3; ++axis)
    {
      lattice[axis] += this->LatticeShift[axis];
    }
    return lattice;
  }
  VertexBox GetVertices(std::size_t block) const override
  {
    VertexBox vertices = TestBlockSource<float>::GetVertices(block);
    for (int axis = 0; block == 1 && axis < 3; ++axis)
    {
      vertices.Low[axis] += this->VertexShift[axis];
      vertices.High[axis] += this->VertexShift[axis];
    }
    return vertices;
  }
};

// A source that runs out of memory.
struct HungrySource : TestBlockSource<float>
{
  using TestBlockSource<float>::TestBlockSource;
  Result<BlockSamples> Acquire(std::size_t) override { throw std::bad_alloc(); }
};

} // namespace

TEST_F(SurfaceErrors, LackOfMemoryIsAnErrorNotAnException)
{
  HungrySource source(this->Volume, 16);
  for (const int threads : { 1, 2, 7 })
  {
    EXPECT_EQ(this->Extract(source, threads), StatusCode::OutOfMemory);
  }
}

TEST_F(SurfaceErrors, AnErrorOfAcquireIsReturned)
{
  TestBlockSource<float> source(this->Volume, 16);
  source.Failing = 13;
  for (const int threads : { 1, 2, 7 })
  {
    EXPECT_EQ(this->Extract(source, threads), StatusCode::IoError);
    EXPECT_EQ(this->Message, "block.store: no medium");
  }
}

TEST_F(SurfaceErrors, BlocksAfterAnErrorAreNotAcquired)
{
  TestBlockSource<float> source(this->Volume, 16);
  source.Failing = 0;
  EXPECT_EQ(this->Extract(source, 1), StatusCode::IoError);
  EXPECT_EQ(source.Acquired, 1);
}

TEST_F(SurfaceErrors, ProgressCanAbortEitherPhase)
{
  for (const double stopAt : { 0.0, 0.3, 0.6, 0.9 })
  {
    TestBlockSource<float> source(this->Volume, 16);
    EXPECT_EQ(this->Extract(source, 1, [stopAt](double fraction) { return fraction < stopAt; }),
      StatusCode::Aborted);
  }
}

TEST_F(SurfaceErrors, ProgressIncreasesFromZeroToOne)
{
  TestBlockSource<float> source(this->Volume, 16);
  double last = 0;
  EXPECT_EQ(this->Extract(source, 1,
              [&last](double fraction)
              {
                EXPECT_GE(fraction, last);
                EXPECT_LE(fraction, 1.0);
                last = fraction;
                return true;
              }),
    StatusCode::Ok);
  EXPECT_EQ(last, 1.0);
}

TEST_F(SurfaceErrors, NormalsWithoutAGhostLayerAreAnError)
{
  TestBlockSource<float> source(this->Volume, 16, 0);
  EXPECT_EQ(this->Extract(source), StatusCode::Ok);
  this->Request.Normals = true;
  EXPECT_EQ(this->Extract(source), StatusCode::InvalidArgument);
}

TEST_F(SurfaceErrors, ASingleBlockOfTheWholeGridNeedsNoGhostLayer)
{
  this->Request.Normals = true;
  TestBlockSource<float> source(this->Volume, 64, 0);
  EXPECT_EQ(this->Extract(source), StatusCode::Ok);
}

TEST_F(SurfaceErrors, InconsistentBlocksAreAnError)
{
  DisplacedSource twice(this->Volume, 16);
  twice.LatticeShift = { -1, 0, 0 };
  EXPECT_EQ(this->Extract(twice), StatusCode::InvalidArgument);
  DisplacedSource moved(this->Volume, 16);
  moved.VertexShift = { 0, 3, 0 };
  EXPECT_EQ(this->Extract(moved), StatusCode::InvalidArgument);
  DisplacedSource beyond(this->Volume, 16);
  beyond.VertexShift = { 0, 0, -1 };
  EXPECT_EQ(this->Extract(beyond), StatusCode::InvalidArgument);
  TestBlockSource<float> repeated(this->Volume, 16);
  repeated.Blocks.push_back(5);
  EXPECT_EQ(this->Extract(repeated), StatusCode::InvalidArgument);
}

TEST_F(SurfaceErrors, MissingAttributesAreAnError)
{
  TestBlockSource<float> source(this->Volume, 16);
  this->Request.Attributes = { { ValueType::Float32, 1 } };
  EXPECT_EQ(this->Extract(source), StatusCode::InvalidArgument);
  this->Request.Attributes = { { ValueType::Float32, 0 } };
  EXPECT_EQ(this->Extract(source), StatusCode::InvalidArgument);
}

TEST_F(SurfaceErrors, ProgressCanAbortTheComputationOfRanges)
{
  // With one thread: another thread might finish the work before the calling one reports progress.
  const Result<BlockRanges> ranges =
    BlockRanges::Compute(this->Volume.GetView(), 1, [](double) { return false; });
  EXPECT_EQ(ranges.GetStatus().GetCode(), StatusCode::Aborted);
}
