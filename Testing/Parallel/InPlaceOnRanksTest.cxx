// SPDX-License-Identifier: BSD-3-Clause
// A volume in place on any number of ranks: the surface of the whole volume; and a source that one
// rank does not see is one error on all.
#include "ParallelVolumes.h"
#include "VolumeDamage.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkInPlaceVolumeReader.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include "ControllerCommunicator.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <filesystem>
#include <fstream>

using namespace isosurface;

namespace
{

constexpr double InPlaceIsovalue = 120.0; // of noise: every block is active

vtkSmartPointer<vtkImageData> MakeNoisyImage()
{
  return MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
}

/// Writes raw samples with a header.
void WriteSource(vtkImageData* image, const std::string& path)
{
  std::ofstream raw(path + ".raw", std::ios::binary);
  raw.write(static_cast<const char*>(image->GetScalarPointer()),
    static_cast<std::streamsize>(image->GetNumberOfPoints()));
  std::ofstream(path) << "ObjectType = Image\nNDims = 3\nDimSize = 41 37 45\n"
                      << "ElementType = MET_UCHAR\nElementDataFile = "
                      << std::filesystem::path(path).filename().string() << ".raw\n";
}

/// Collective: indexes the source by all ranks. Only a path seen from the volume leads to it.
Status IndexInPlace(const std::string& source, const std::string& path)
{
  FileSystem& files = GetLocalFileSystem();
  ControllerCommunicator ranks(GetRanks());
  auto volume = OpenForeignVolume(files, source);
  ISOSURFACE_RETURN_IF_ERROR(volume.GetStatus());
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 3;
  auto record =
    DescribeSource(files, OpenForeignVolume, path, source, {}, volume->Grid, volume->Arrays);
  ISOSURFACE_RETURN_IF_ERROR(record.GetStatus());
  record->AbsolutePath = "/nowhere";
  settings.InPlace = *record;
  return BlockedVolumeWriter(ranks)
    .Write(path, volume->Grid, volume->Arrays, *volume->Source, settings)
    .GetStatus();
}

TEST(InPlaceOnRanks, SurfaceIsThatOfWholeVolumeAndAMissingSourceIsToldByAll)
{
  const SharedFolder folder("InPlaceOnRanks");
  const std::string path = folder.GetPath("volume.bvol");
  const auto image = MakeNoisyImage();
  OnFirstRank([&] { WriteSource(image, folder.GetPath("scan.mhd")); });
  const Status written = IndexInPlace(folder.GetPath("scan.mhd"), path);
  EXPECT_TRUE(written.IsOk()) << written.GetMessage();
  OnFirstRank(
    [&]
    {
      // The same volume where its source is not beside it.
      std::filesystem::create_directory(folder.GetPath("blind"));
      CopyVolume(path, folder.GetPath("blind/volume.bvol"));
    });

  ContourPipeline pipeline(path);
  vtkPolyData* const mine = pipeline.Update({ InPlaceIsovalue });
  const auto triangles = SumOverRanks(static_cast<std::uint64_t>(mine->GetNumberOfPolys()));
  ExpectSurfaceOf(mine, image, InPlaceIsovalue);

  const ErrorCounter readerErrors(pipeline.Reader);
  ErrorCounter contourErrors(pipeline.Contour);
  for (int failing = 0; failing < GetNumberOfRanks(); ++failing)
  {
    const std::string blind = folder.GetPath("blind/volume.bvol");
    pipeline.Reader->SetFileName((failing == GetRank() ? blind : path).c_str());
    pipeline.Reader->Modified();
    pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_TRUE(
      IsOneMessageAbout(contourErrors.Messages, { "", {}, "blind/scan.mhd", "is missing" }))
      << testing::PrintToString(contourErrors.Messages);
    EXPECT_EQ(pipeline.Contour->GetOutput()->GetNumberOfPolys(), 0);
    contourErrors.Messages.clear();
    GetRanks()->Barrier();
  }
  pipeline.Reader->SetFileName(path.c_str());
  pipeline.Reader->Modified();
  pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_EQ(contourErrors.Messages, std::vector<std::string>());
  EXPECT_EQ(
    SumOverRanks(static_cast<std::uint64_t>(pipeline.Contour->GetOutput()->GetNumberOfPolys())),
    triangles);
}

TEST(InPlaceOnRanks, StopOfOneRankWhileIndexingStopsAllWithoutError)
{
  const SharedFolder folder("InPlaceStop");
  const std::string source = folder.GetPath("scan.mhd");
  OnFirstRank([&] { WriteSource(MakeNoisyImage(), source); });
  vtkNew<vtkInPlaceVolumeReader> reader;
  reader->SetSourceName(source.c_str());
  const auto contour = MakeContour(reader, InPlaceIsovalue);
  const ExpectNoErrors readerErrors(reader);
  const ExpectNoErrors contourErrors(contour);
  reader->SetAbortExecute(GetRank() == 0 ? 1 : 0);
  for (int turn = 0; turn < 2; ++turn)
  {
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPoints(), 0);
  }
  reader->SetAbortExecute(0);
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_GT(
    SumOverRanks(static_cast<std::uint64_t>(contour->GetOutput()->GetNumberOfPoints())), 0u);
}

// A consumer of blocks that was not executed must not keep a later slice from its samples.
TEST(InPlaceOnRanks, OutputOfAReaderThatFailedBeforeIsWhole)
{
  const SharedFolder folder("InPlaceAfterError");
  const std::string source = folder.GetPath("scan.mhd");
  const auto image = MakeNoisyImage();
  vtkNew<vtkInPlaceVolumeReader> reader;
  reader->SetSourceName(source.c_str());
  const auto contour = MakeContour(reader, InPlaceIsovalue);
  {
    const ErrorCounter errors(reader);
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(errors.Messages.size(), 1u);
  }
  OnFirstRank([&] { WriteSource(image, source); });
  reader->Modified();
  const ExpectNoErrors errors(reader);
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_GE(SumOverRanks(static_cast<std::uint64_t>(reader->GetOutput()->GetNumberOfCells())),
    40u * 36 * 44);
}

} // namespace
