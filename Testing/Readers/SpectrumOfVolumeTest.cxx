// SPDX-License-Identifier: BSD-3-Clause
// The spectrum that is stored with a volume, through the filter.
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkStabbingContour.h"

#include "Ground/Base/FileSystem.h"
#include "vtkExecutive.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPolyData.h"
#include "vtkTable.h"

using namespace isosurface;

namespace
{

TEST(SpectrumOfVolume, IsWhatItsImageHasAndAQueryCosts)
{
  const auto image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT);
  TurnObliquely(image);
  const ScratchVolume volume(image, { 32, 3 });

  const auto reader = MakeReader(volume.Path);
  vtkNew<vtkContourSpectrum> stored;
  const ExpectNoErrors errors(stored);
  stored->SetInputConnection(reader->GetOutputPort());
  stored->SetStoreQuantity(vtkContourSpectrum::BYTES);
  stored->Update();
  vtkTable* table = stored->GetOutput();
  // No samples were read for it: the reader gives a box.
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), 8);

  vtkNew<vtkContourSpectrum> counted;
  counted->SetInputData(image);
  counted->Update();
  ASSERT_EQ(table->GetNumberOfColumns(), 10);
  ASSERT_EQ(table->GetNumberOfRows(), counted->GetOutput()->GetNumberOfRows());
  for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
  {
    for (const char* name : { "Isovalue", "Triangles", "ActiveCells", "ActiveBlocks" })
    {
      ASSERT_EQ(table->GetValueByName(row, name), counted->GetOutput()->GetValueByName(row, name))
        << name;
    }
    for (const char* name : { "Area", "Volume" })
    {
      const double expected = counted->GetOutput()->GetValueByName(row, name).ToDouble();
      ASSERT_NEAR(table->GetValueByName(row, name).ToDouble(), expected, 1e-4 * expected + 0.1);
    }
    long long bytes = 0;
    for (const char* name : { "Bytes[0]", "Bytes[1]", "Bytes[2]" })
    {
      bytes += table->GetValueByName(row, name).ToTypeInt64();
    }
    ASSERT_EQ(table->GetValueByName(row, "Bytes").ToTypeInt64(), bytes);
  }

  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(reader->GetOutputPort());
  const vtkIdType row = table->GetNumberOfRows() / 2;
  contour->SetValue(0, table->GetValueByName(row, "Isovalue").ToDouble());
  reader->SetCacheSize(0);
  contour->Update();
  EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(),
    table->GetValueByName(row, "Triangles").ToTypeInt64());
  EXPECT_EQ(GetCost(contour->GetOutput(), "ActiveBlocks"),
    table->GetValueByName(row, "ActiveBlocks").ToTypeUInt64());
  EXPECT_EQ(
    GetCost(contour->GetOutput(), "BytesRead"), table->GetValueByName(row, "Bytes").ToTypeUInt64());
  reader->SetCacheSize(256);
}

TEST(SpectrumOfVolume, InAGridThatIsSetIsThatOfAVolumeThere)
{
  const auto image = MakeClosedVolume({ 0, 50, 0, 40, 0, 60 }, VTK_SHORT);
  const auto make = [](vtkBlockedVolumeReader* reader)
  {
    vtkNew<vtkContourSpectrum> spectrum;
    const ExpectNoErrors errors(spectrum);
    spectrum->SetInputConnection(reader->GetOutputPort());
    spectrum->SetStoreQuantity(vtkContourSpectrum::VOLUME);
    spectrum->Update();
    vtkSmartPointer<vtkTable> table = spectrum->GetOutput();
    return table;
  };
  const ScratchFolder folder;
  const std::string path = folder.GetPath("volume.bvol");
  WriteVolume(image, path, { 16, 2 });
  const auto reader = MakeReader(path);
  for (const double z : { 2.5, 0.75 })
  {
    image->SetSpacing(2.5, 2.5, z);
    const std::string placed = folder.GetPath(std::to_string(z) + ".bvol");
    WriteVolume(image, placed, { 16, 2 });
    const auto expected = make(MakeReader(placed));
    reader->SetSpacing(2.5, 2.5, z);
    const auto table = make(reader);
    for (const char* name : { "Triangles", "Area", "Volume", "Volume[0]", "Volume[1]" })
    {
      const bool isKnown = z == 2.5 || std::string(name) != "Area";
      ASSERT_EQ(table->GetColumnByName(name) != nullptr, isKnown) << name;
      for (vtkIdType row = 0; isKnown && row < table->GetNumberOfRows(); ++row)
      {
        ASSERT_DOUBLE_EQ(table->GetValueByName(row, name).ToDouble(),
          expected->GetValueByName(row, name).ToDouble())
          << name;
      }
    }
  }
}

TEST(SpectrumOfVolume, LeavesOtherConsumersTheirSamples)
{
  const ScratchVolume volume(MakeClosedVolume({ 0, 40, 0, 40, 0, 40 }, VTK_SHORT));
  const auto reader = MakeReader(volume.Path);
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(reader->GetOutputPort());
  spectrum->Update();
  reader->Update();
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 1u);
  spectrum->Modified();
  spectrum->Update();
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 7);
}

} // namespace
