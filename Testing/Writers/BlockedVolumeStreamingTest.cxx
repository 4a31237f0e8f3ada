// SPDX-License-Identifier: BSD-3-Clause
// Volumes that are asked for in slabs are written like those that are in memory as a whole.
#include "EventCounter.h"
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeWriter.h"

#include "Ground/Base/FileSystem.h"
#include "vtkCellDataToPointData.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkImageAlgorithm.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPointDataToCellData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

using namespace isosurface;

namespace
{

constexpr int Whole[6] = { -5, 84, 3, 92, 10, 129 };

/// Makes the part of a volume that it is asked for, and notes what that was.
class SlabMaker : public vtkImageAlgorithm
{
public:
  static SlabMaker* New();
  vtkTypeMacro(SlabMaker, vtkImageAlgorithm);

  int LargestRequest = 0; ///< slices
  int Requests = 0;
  int Missing = 0; ///< slices that are left out of each answer

protected:
  SlabMaker() { this->SetNumberOfInputPorts(0); }

  int RequestInformation(
    vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* information = output->GetInformationObject(0);
    information->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), Whole, 6);
    information->Set(CAN_PRODUCE_SUB_EXTENT(), 1);
    vtkDataObject::SetPointDataActiveScalarInfo(information, VTK_UNSIGNED_SHORT, 1);
    return 1;
  }

  void ExecuteDataWithInformation(vtkDataObject* output, vtkInformation* information) override
  {
    int extent[6];
    information->Get(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), extent);
    ++this->Requests;
    this->LargestRequest = std::max(this->LargestRequest, extent[5] - extent[4] + 1);
    extent[5] = std::max(extent[4], extent[5] - this->Missing);
    auto* image = vtkImageData::SafeDownCast(output);
    image->SetExtent(extent);
    image->AllocateScalars(VTK_UNSIGNED_SHORT, 1);
    image->GetPointData()->GetScalars()->SetName("density");
    auto* to = static_cast<unsigned short*>(image->GetScalarPointer());
    for (int k = extent[4]; k <= extent[5]; ++k)
    {
      for (int j = extent[2]; j <= extent[3]; ++j)
      {
        for (int i = extent[0]; i <= extent[1]; ++i)
        {
          *to++ = static_cast<unsigned short>((i * i + j * j * 3 + k * 40) % 5000);
        }
      }
    }
  }
};
vtkStandardNewMacro(SlabMaker);

/// The contents of all files of a volume, by their names.
std::map<std::string, std::string> ReadFiles(const std::string& path)
{
  std::map<std::string, std::string> contents;
  const auto read = [&](const std::filesystem::path& file, const std::string& name)
  {
    std::ifstream stream(file, std::ios::binary);
    contents[name] =
      std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  };
  read(path, "header");
  for (const auto& entry :
    std::filesystem::recursive_directory_iterator(HidePath(path + ".stores")))
  {
    if (entry.is_regular_file())
    {
      read(
        entry.path(), std::filesystem::relative(entry.path(), HidePath(path + ".stores")).string());
    }
  }
  return contents;
}

class BlockedVolumeStreaming : public testing::Test
{
protected:
  bool Write(vtkAlgorithm* input, const char* name, int memoryLimit, bool withCells = false)
  {
    vtkNew<vtkBlockedVolumeWriter> writer;
    writer->SetInputConnection(input->GetOutputPort());
    writer->SetFileName(this->Folder.GetPath(name).c_str());
    writer->SetController(nullptr);
    writer->SetBlockSize(16);
    writer->SetNumberOfStores(3);
    writer->SetMemoryLimit(memoryLimit);
    writer->SetWriteCellArrays(withCells);
    return writer->Write() == 1 && writer->GetErrorCode() == 0;
  }
  std::map<std::string, std::string> Read(const char* name) const
  {
    return ReadFiles(this->Folder.GetPath(name));
  }

  const ScratchFolder Folder;
};

} // namespace

TEST_F(BlockedVolumeStreaming, AveragesOfCellsAreThoseOfTheWhole)
{
  vtkNew<SlabMaker> points;
  vtkNew<vtkPointDataToCellData> cells;
  cells->SetInputConnection(points->GetOutputPort());
  ASSERT_TRUE(this->Write(cells, "slabs.bvol", 8, true));
  EXPECT_GT(points->Requests, 3);
  ASSERT_TRUE(this->Write(cells, "whole.bvol", 0, true));
  vtkNew<vtkCellDataToPointData> convert;
  convert->SetInputConnection(cells->GetOutputPort());
  convert->Update();
  ASSERT_TRUE(this->Write(convert, "points.bvol", 0));
  EXPECT_TRUE(this->Read("slabs.bvol") == this->Read("points.bvol"));
  EXPECT_TRUE(this->Read("whole.bvol") == this->Read("points.bvol"));
}

TEST_F(BlockedVolumeStreaming, AsksForSlabsWithinTheMemoryLimit)
{
  vtkNew<SlabMaker> whole;
  ASSERT_TRUE(this->Write(whole, "whole.bvol", 0));
  EXPECT_EQ(whole->Requests, 1);
  EXPECT_EQ(whole->LargestRequest, 120);
  vtkNew<SlabMaker> slabs;
  ASSERT_TRUE(this->Write(slabs, "slabs.bvol", 6));
  EXPECT_GT(slabs->Requests, 10);
  EXPECT_LT(slabs->LargestRequest, 60);
  EXPECT_TRUE(this->Read("whole.bvol") == this->Read("slabs.bvol"));
}

TEST_F(BlockedVolumeStreaming, WritesAnInputThatDeliversTheWholeOnly)
{
  vtkNew<SlabMaker> maker;
  maker->Update();
  vtkNew<vtkImageData> image;
  image->ShallowCopy(maker->GetOutput());
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputData(image);
  writer->SetFileName(this->Folder.GetPath("image.bvol").c_str());
  writer->SetController(nullptr);
  writer->SetBlockSize(16);
  writer->SetNumberOfStores(3);
  writer->SetMemoryLimit(6);
  ASSERT_EQ(writer->Write(), 1);
  ASSERT_TRUE(this->Write(maker, "whole.bvol", 0));
  EXPECT_TRUE(this->Read("whole.bvol") == this->Read("image.bvol"));
}

TEST_F(BlockedVolumeStreaming, SaysWhichInputDoesNotDeliverWhatItIsAskedFor)
{
  vtkNew<SlabMaker> maker;
  maker->Missing = 1;
  vtkNew<vtkBlockedVolumeWriter> writer;
  const EventCounter errors(writer, vtkCommand::ErrorEvent);
  writer->SetInputConnection(maker->GetOutputPort());
  writer->SetFileName(this->Folder.GetPath("volume.bvol").c_str());
  writer->SetController(nullptr);
  writer->SetMemoryLimit(6);
  writer->Write();
  EXPECT_NE(writer->GetErrorCode(), 0u);
  EXPECT_EQ(errors.Count, 1);
  EXPECT_FALSE(std::filesystem::exists(this->Folder.GetPath("volume.bvol")));
}
