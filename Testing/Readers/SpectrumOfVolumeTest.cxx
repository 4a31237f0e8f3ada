// SPDX-License-Identifier: BSD-3-Clause
// The spectrum that is stored with a volume, through the filter.
#include "ScratchFolder.h"
#include "TestVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkStabbingContour.h"

#include "vtkExecutive.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPolyData.h"
#include "vtkTable.h"

#include <cmath>

namespace isosurface
{
namespace
{

TEST(SpectrumOfVolume, IsWhatItsImageHasAndAQueryCosts)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("volume.bvol");
  const auto image = MakeClosedVolume({ -41, 28, -7, 53, -90, -8 }, VTK_SHORT);
  TurnObliquely(image);
  WriteVolume(image, path, { 32, 3 });

  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName(path.c_str());
  vtkNew<vtkContourSpectrum> stored;
  const ErrorCounter errors(stored);
  stored->SetInputConnection(reader->GetOutputPort());
  stored->SetStoreQuantity(vtkContourSpectrum::BYTES);
  stored->Update();
  EXPECT_EQ(errors.Messages, std::vector<std::string>());
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

TEST(SpectrumOfVolume, LeavesOtherConsumersTheirSamples)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("volume.bvol");
  WriteVolume(MakeClosedVolume({ 0, 40, 0, 40, 0, 40 }, VTK_SHORT), path);
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName(path.c_str());
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(reader->GetOutputPort());
  spectrum->Update();
  reader->Update();
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPartitions(), 1u);
  spectrum->Modified();
  spectrum->Update();
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 7);
}

TEST(SpectrumOfVolume, TellsOfADamagedFile)
{
  const ScratchFolder folder;
  const std::string path = folder.GetPath("volume.bvol");
  WriteVolume(MakeClosedVolume({ 0, 40, 0, 40, 0, 40 }, VTK_SHORT), path);
  const std::string file = path + ".stores/000001/spectra";
  std::string bytes = ReadBytes(file);
  bytes[bytes.size() / 2] ^= 4;
  WriteBytes(file, bytes);
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetFileName(path.c_str());
  vtkNew<vtkContourSpectrum> spectrum;
  const ErrorCounter errors(spectrum);
  const ErrorCounter executiveErrors(spectrum->GetExecutive());
  spectrum->SetInputConnection(reader->GetOutputPort());
  spectrum->SetStoreQuantity(vtkContourSpectrum::AREA);
  spectrum->Update();
  ASSERT_EQ(errors.Messages.size(), 1u);
  EXPECT_NE(errors.Messages[0].find(file), std::string::npos) << errors.Messages[0];
  EXPECT_NE(errors.Messages[0].find("checksum"), std::string::npos) << errors.Messages[0];
  EXPECT_EQ(spectrum->GetOutput()->GetNumberOfColumns(), 0);
}

} // namespace
} // namespace isosurface
