// SPDX-License-Identifier: BSD-3-Clause
#include "BlockChecks.h"
#include "EventCounter.h"
#include "FileSizeLimit.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkStabbingContour.h"

#include "vtkDataArray.h"
#include "vtkErrorCode.h"
#include "vtkExecutive.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkInformation.h"
#include "vtkInformationStringKey.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkStringArray.h"
#include "vtkUniformGrid.h"

#include "Ground/Base/FileSystem.h"
#include "Storage/Store/BlockedVolumeHeader.h"

#include <utility>

using namespace isosurface;

namespace
{

// The unit of z in the field data.
std::string GetLengthUnit(vtkDataObject* data)
{
  auto* units =
    vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("PhysicalSizeUnit"));
  return units && units->GetNumberOfValues() == 3 ? units->GetValue(2) : std::string();
}

class BlockedVolumeWriter : public testing::Test
{
protected:
  std::string GetPath() const { return this->Folder.GetPath("volume.bvol"); }

  // Reads the file back and compares an array.
  void ExpectRead(vtkImageData* image, const char* array)
  {
    const auto reader = MakeReader(this->GetPath());
    const auto blocks = ReadPiece(reader, 0, 1);
    EXPECT_TRUE((BlockChecks{ image }.HaveValues({ blocks }, array))) << array;
    EXPECT_TRUE((BlockChecks{ image }.HaveEachCellOnce({ blocks })));
  }

  const ScratchFolder Folder;
};

TEST_F(BlockedVolumeWriter, WritesEveryNumericType)
{
  for (const int type : { VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT,
         VTK_UNSIGNED_SHORT, VTK_INT, VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG,
         VTK_UNSIGNED_LONG_LONG, VTK_ID_TYPE, VTK_FLOAT, VTK_DOUBLE })
  {
    const auto image = MakeImage({ -4, 16, 0, 17, 3, 20 }, type, MakeNoise(100, 1));
    vtkDataArray* samples = image->GetPointData()->GetScalars();
    // The largest that doubles have exactly, and the ends of the smaller types.
    samples->SetComponent(5, 0, std::min(samples->GetDataTypeMax(), 9007199254740992.0));
    samples->SetComponent(6, 0, std::max(samples->GetDataTypeMin(), -9007199254740992.0));
    WriteVolume(image, this->GetPath(), { 16, 2 });
    this->ExpectRead(image, "density");
  }
}

TEST_F(BlockedVolumeWriter, KeepsUnitsAndLeavesOutThoseThatAreNoText)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1));
  vtkDataArray* samples = image->GetPointData()->GetScalars();
  for (const auto& [label, unit] : { std::pair("HU", "HU"), std::pair("\xb5m", "") })
  {
    samples->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), label);
    WriteVolume(image, this->GetPath());
    const auto header = BlockedVolumeHeader::Read(GetLocalFileSystem(), this->GetPath());
    ASSERT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
    EXPECT_EQ(header->Arrays[0].Unit, unit);
  }
}

TEST_F(BlockedVolumeWriter, KeepsTheUnitOfLengthWhichReaderAndSurfaceHandOn)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1));
  vtkNew<vtkStringArray> units;
  units->SetName("PhysicalSizeUnit");
  for (const char* unit : { "micrometer", "\xC2\xB5m", "um" })
  {
    units->InsertNextValue(unit);
  }
  image->GetFieldData()->AddArray(units);
  WriteVolume(image, this->GetPath());
  const auto header = BlockedVolumeHeader::Read(GetLocalFileSystem(), this->GetPath());
  ASSERT_TRUE(header.IsOk()) << header.GetStatus().GetMessage();
  EXPECT_EQ(header->Grid.Unit, LengthUnit::Micrometer);

  const auto reader = MakeReader(this->GetPath());
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  contour->SetValue(0, 0.5);
  contour->Update();
  EXPECT_EQ(GetLengthUnit(contour->GetOutput()), "um");
  const auto alone = MakeReader(this->GetPath());
  alone->Update();
  EXPECT_EQ(GetLengthUnit(alone->GetOutput()->GetPartition(0)), "um");

  // Axes of different units have none together.
  units->SetValue(2, "mm");
  WriteVolume(image, this->GetPath());
  EXPECT_EQ(BlockedVolumeHeader::Read(GetLocalFileSystem(), this->GetPath())->Grid.Unit,
    LengthUnit::Unknown);
}

TEST_F(BlockedVolumeWriter, RefusesWhatIsHidden)
{
  vtkNew<vtkUniformGrid> grid;
  grid->ShallowCopy(MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1)));
  grid->BlankPoint(17);
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ErrorCounter errors(writer);
  writer->SetInputData(grid);
  writer->SetFileName(this->GetPath().c_str());
  writer->Write();
  ExpectOneError(errors, { "hides cells or points" });
}

TEST_F(BlockedVolumeWriter, WritesAllNumericArraysActiveScalarsFirst)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1));
  vtkNew<vtkFloatArray> vectors;
  vectors->SetName("velocity");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(image->GetNumberOfPoints());
  vectors->FillValue(1);
  vtkNew<vtkStringArray> names;
  names->SetName("names");
  names->SetNumberOfValues(image->GetNumberOfPoints());
  const auto other = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_INT, MakeNoise(100, 2));
  other->GetPointData()->GetScalars()->SetName("temperature");
  image->GetPointData()->AddArray(vectors);
  image->GetPointData()->AddArray(names);
  image->GetPointData()->SetScalars(other->GetPointData()->GetScalars());
  image->GetPointData()->AddArray(
    MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1))->GetPointData()->GetScalars());
  WriteVolume(image, this->GetPath());

  const auto reader = MakeReader(this->GetPath());
  reader->UpdateInformation();
  ASSERT_EQ(reader->GetNumberOfPointArrays(), 3);
  EXPECT_STREQ(reader->GetPointArrayName(0), "temperature");
  EXPECT_STREQ(reader->GetPointArrayName(1), "velocity");
  EXPECT_STREQ(reader->GetPointArrayName(2), "density");
  this->ExpectRead(image, "temperature");
  this->ExpectRead(image, "density");
}

TEST_F(BlockedVolumeWriter, WritesGhostSamplesLikeOthers)
{
  const auto image = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_FLOAT, MakeNoise(100, 1));
  const auto part = CutImage(image, { 0, 20, 0, 20, 0, 20 }, { 0, 20, 0, 20, 0, 15 });
  WriteVolume(part, this->GetPath());
  this->ExpectRead(image, "density");
}

TEST_F(BlockedVolumeWriter, TellsProgressThatRises)
{
  const auto image = MakeClosedVolume({ 0, 60, 0, 60, 0, 60 }, VTK_SHORT);
  vtkNew<vtkBlockedVolumeWriter> writer;
  const ProgressKeeper progress(writer);
  writer->SetInputData(image);
  writer->SetFileName(this->GetPath().c_str());
  writer->SetNumberOfStores(3);
  EXPECT_EQ(writer->Write(), 1);
  EXPECT_TRUE(progress.IsRising()) << testing::PrintToString(progress.Shares);
  EXPECT_GT(progress.Shares.size(), 3u);
}

TEST_F(BlockedVolumeWriter, FullDiskLeavesOldFile)
{
  const auto old = MakeImage({ 0, 20, 0, 20, 0, 20 }, VTK_SHORT, MakeNoise(100, 1));
  WriteVolume(old, this->GetPath());
  const std::uint64_t before = ComputeFingerprint(this->GetPath());
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputData(MakeClosedVolume({ 0, 60, 0, 60, 0, 60 }, VTK_FLOAT));
  writer->SetFileName(this->GetPath().c_str());
  // Stops at the header or the small files of the index, or at the blocks.
  for (const rlim_t bytes : { 100, 5000, 100000 })
  {
    const FileSizeLimit limit(bytes);
    const ErrorCounter errors(writer);
    EXPECT_EQ(writer->Write(), 0) << bytes;
    EXPECT_EQ(
      writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::OutOfDiskSpaceError));
    ExpectOneError(errors, { this->GetPath(), "File too large" });
    EXPECT_EQ(ComputeFingerprint(this->GetPath()), before) << bytes;
  }
  this->ExpectRead(old, "density");
  EXPECT_EQ(writer->Write(), 1);
}

} // namespace
