// SPDX-License-Identifier: BSD-3-Clause
// Reader and contour tell how far they are, and stop when they are told to.
#include "BlockChecks.h"
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkExecutive.h"
#include "vtkPartitionedDataSet.h"

using namespace isosurface;

namespace
{

class Progress : public testing::Test
{
protected:
  Progress()
    : Image(MakeImage({ 0, 65, 0, 60, 0, 70 }, VTK_SHORT, MakeNoise(3000, 2)))
  {
    WriteVolume(this->Image, this->Folder.GetPath("volume.bvol"), { 16, 3 });
    this->Reader->SetFileName(this->Folder.GetPath("volume.bvol").c_str());
    this->Contour->SetInputConnection(this->Reader->GetOutputPort());
    this->Contour->SetValue(0, 1500);
  }

  const ScratchFolder Folder;
  const vtkSmartPointer<vtkImageData> Image;
  vtkNew<vtkBlockedVolumeReader> Reader;
  vtkNew<vtkStabbingContour> Contour;
};

// Runs an algorithm that is told to stop once it is beyond a share, without a word of errors.
// Whether it was told in time: the last steps may be those of a thread that tells nothing.
bool StopBeyond(vtkAlgorithm* algorithm, double stop)
{
  bool isTold = false;
  const ExpectNoErrors errors(algorithm);
  const ExpectNoErrors executiveErrors(algorithm->GetExecutive());
  const ProgressKeeper progress(algorithm,
    [&](double share)
    {
      if (share > stop && share < 1)
      {
        isTold = true;
        algorithm->SetAbortExecute(1);
      }
    });
  algorithm->Modified();
  algorithm->Update();
  // Not every version of VTK takes this back by itself.
  algorithm->SetAbortExecute(0);
  return isTold;
}

TEST_F(Progress, OfReaderRisesToOne)
{
  const ProgressKeeper progress(this->Reader);
  this->Reader->Update();
  EXPECT_TRUE(progress.IsRising()) << testing::PrintToString(progress.Shares);
  EXPECT_GT(progress.Shares.size(), 2u) << "not only its begin and end";
}

TEST_F(Progress, OfContourRisesToOne)
{
  const ProgressKeeper progress(this->Contour);
  this->Contour->Update();
  EXPECT_TRUE(progress.IsRising()) << testing::PrintToString(progress.Shares);
  EXPECT_GT(progress.Shares.size(), 2u) << "not only its begin and end";
}

TEST_F(Progress, ReaderStopsWhenToldTo)
{
  for (const double stop : { -1.0, 0.0, 0.4, 0.8 })
  {
    const bool isTold = StopBeyond(this->Reader, stop);
    EXPECT_TRUE(isTold || stop >= 0);
    EXPECT_EQ(this->Reader->GetOutput()->GetNumberOfPartitions() == 0, isTold) << stop;
  }
  this->Reader->Modified();
  EXPECT_TRUE((BlockChecks{ this->Image }.HaveEachCellOnce({ ReadPiece(this->Reader, 0, 1) })));
}

TEST_F(Progress, ContourStopsWhenToldTo)
{
  for (const double stop : { -1.0, 0.0, 0.4, 0.8 })
  {
    const bool isTold = StopBeyond(this->Contour, stop);
    EXPECT_TRUE(isTold || stop >= 0);
    EXPECT_EQ(this->Contour->GetOutput()->GetNumberOfPoints() == 0, isTold) << stop;
  }
  this->Contour->Modified();
  this->Contour->Update();
  EXPECT_TRUE(IsSurfaceOf(this->Contour->GetOutput(), this->Image, 1500));
}

} // namespace
