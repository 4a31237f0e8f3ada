// SPDX-License-Identifier: BSD-3-Clause
// One message that names file and reason; none of what cannot be trusted; and all is well again
// once the cause is mended.
#include "BlockChecks.h"
#include "ScratchFolder.h"
#include "SeenText.h"
#include "TestVolumes.h"
#include "VolumeDamage.h"

#include "vtkBlockedVolumeReader.h"

#include "Ground/Base/FileSystem.h"
#include "vtkExecutive.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"
#include "vtkTriangleFilter.h"

#include <filesystem>

using namespace isosurface;

namespace
{

class ReaderErrors : public testing::TestWithParam<VolumeDamage>
{
};

TEST_P(ReaderErrors, NameFileAndReasonOnce)
{
  const auto image = MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
  const ScratchVolume volume(image, { 16, 2 });
  std::filesystem::create_directory(volume.Folder.GetPath("good"));
  CopyVolume(volume.Path, volume.Folder.GetPath("good/volume.bvol"));
  GetParam().Apply(volume.Path);

  const auto reader = MakeReader(volume.Path);
  const ErrorCounter errors(reader);
  reader->UpdateInformation();
  reader->Update();
  if (GetParam().IsOfIndex)
  {
    EXPECT_EQ(errors.Messages, std::vector<std::string>()) << "the index is not needed";
    EXPECT_TRUE((BlockChecks{ image }.HaveEachCellOnce({ reader->GetOutput() })));
    return;
  }
  EXPECT_TRUE(IsOneMessageAbout(errors.Messages, GetParam()))
    << testing::PrintToString(errors.Messages);
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 0u);

  std::filesystem::remove(volume.Path);
  std::filesystem::remove_all(HidePath(volume.Path + ".stores"));
  CopyVolume(volume.Folder.GetPath("good/volume.bvol"), volume.Path);
  reader->Modified();
  const auto blocks = ReadPiece(reader, 0, 1);
  EXPECT_TRUE((BlockChecks{ image }.HaveValues({ blocks }, "density")));
  EXPECT_TRUE((BlockChecks{ image }.HaveEachCellOnce({ blocks })));
}

std::string NameOfDamage(const testing::TestParamInfo<VolumeDamage>& info)
{
  return info.param.Name;
}

INSTANTIATE_TEST_SUITE_P(Damages, ReaderErrors, testing::ValuesIn(MakeDamages()), NameOfDamage);

TEST(ReaderErrorsOfName, AreToldOnce)
{
  const ScratchFolder folder;
  for (const char* name : { static_cast<const char*>(nullptr), "" })
  {
    vtkNew<vtkBlockedVolumeReader> reader;
    const ErrorCounter errors(reader);
    reader->SetFileName(name);
    reader->Update();
    EXPECT_TRUE(IsOneMessageAbout(errors.Messages, { "", {}, "", "No file name is set" }));
  }
  vtkNew<vtkBlockedVolumeReader> reader;
  const ErrorCounter errors(reader);
  const std::string path = folder.GetPath("folder.bvol");
  std::filesystem::create_directory(path);
  reader->SetFileName(path.c_str());
  reader->Update();
  EXPECT_TRUE(IsOneMessageAbout(errors.Messages, { "", {}, "folder.bvol", "" }))
    << testing::PrintToString(errors.Messages);
}

TEST(ReaderErrorText, HasNoWordOfThePipeline)
{
  const ScratchVolume volume(
    MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3)), { 16, 2 });
  Truncate(volume.Path, 500);
  SeenText seen;
  const auto reader = MakeReader(volume.Path);
  reader->Update();
  EXPECT_NE(seen.Get().find("volume.bvol: was cut off, or is not a"), std::string::npos)
    << seen.Get();
  EXPECT_EQ(seen.Get().find("returned failure"), std::string::npos) << seen.Get();
  EXPECT_EQ(seen.Get().find("vtkInformation"), std::string::npos) << seen.Get();
}

TEST(ReaderErrorText, OfAContourHasNoWordOfThePipeline)
{
  const ScratchVolume volume(
    MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3)), { 16, 2 });
  FlipBit(GetFirstStore(volume.Path) + "/blocks", 2000);
  SeenText seen;
  const auto reader = MakeReader(volume.Path);
  const auto contour = MakeContour(reader, 120.0);
  contour->Update();
  EXPECT_NE(seen.Get().find("checksum"), std::string::npos) << seen.Get();
  EXPECT_EQ(seen.Get().find("returned failure"), std::string::npos) << seen.Get();
  // What else the pipeline has to say is told.
  vtkErrorWithObjectMacro(contour->GetExecutive(), "another error");
  EXPECT_NE(seen.Get().find("another error"), std::string::npos) << seen.Get();
}

TEST(ReaderErrorsAfterAReload, LeaveNothingOfBeforeAndAreToldByEachUpdate)
{
  const ScratchVolume volume(
    MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3)), { 16, 2 });
  const std::string kept = volume.Folder.GetPath("kept");
  std::filesystem::copy_file(volume.Path, kept);
  const auto reader = MakeReader(volume.Path);
  const auto contour = MakeContour(reader, 120.0);
  contour->ComputeIslandIdsOn();
  vtkNew<vtkTriangleFilter> behind;
  behind->SetInputConnection(contour->GetOutputPort());
  behind->Update();
  const vtkIdType expected = behind->GetOutput()->GetNumberOfCells();
  EXPECT_GT(expected, 0);
  for (const bool isRemoved : { false, true })
  {
    if (isRemoved)
    {
      std::filesystem::remove(volume.Path);
    }
    else
    {
      Truncate(volume.Path, 500);
    }
    reader->Modified();
    for (const double isovalue : { 120.0, 120.0, 130.0, 120.0 })
    {
      const ErrorCounter errors(reader);
      const ErrorCounter ofContour(contour);
      contour->SetValue(0, isovalue);
      behind->Update();
      EXPECT_EQ(errors.Messages.size(), 1u) << testing::PrintToString(errors.Messages);
      EXPECT_EQ(ofContour.Messages, std::vector<std::string>());
      EXPECT_EQ(contour->GetOutput()->GetNumberOfCells(), 0);
      EXPECT_STREQ(contour->GetIslandSummary(), "");
      EXPECT_EQ(behind->GetOutput()->GetNumberOfCells(), 0);
    }
    std::filesystem::copy_file(
      kept, volume.Path, std::filesystem::copy_options::overwrite_existing);
    reader->Modified();
    const ExpectNoErrors errors(reader);
    behind->Update();
    EXPECT_EQ(behind->GetOutput()->GetNumberOfCells(), expected);
  }
}

TEST(ReaderMemoryLimit, LimitIsAtLeastAMebibyte)
{
  const auto image = MakeImage({ 0, 9, 0, 9, 0, 9 }, VTK_DOUBLE, MakeNoise(250, 3));
  const ScratchVolume volume(image, { 16, 2 });
  const auto reader = MakeReader(volume.Path);
  reader->SetMemoryLimit(-3);
  EXPECT_EQ(reader->GetMemoryLimit(), 1) << "the least there is";
  EXPECT_TRUE((BlockChecks{ image }.HaveEachCellOnce({ ReadPiece(reader, 0, 1) })));
}

} // namespace
