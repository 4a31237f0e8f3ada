// SPDX-License-Identifier: BSD-3-Clause
#include "TestImages.h"

#include "vtkDataArray.h"
#include "vtkNIFTIImageReader.h"
#include "vtkNew.h"
#include "vtkPointData.h"

#include <cstdio>
#include <fstream>
#include <memory>

using namespace isosurface;

namespace
{

bool IsReadable(const char* file)
{
  return std::ifstream(file).good();
}

// The CT's raw samples are a member of a compressed tar archive.
vtkSmartPointer<vtkImageData> ReadCranium(const std::string& file)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(256, 256, 108);
  image->SetSpacing(0.957, 0.957, 1.5);
  image->AllocateScalars(VTK_SHORT, 1);
  const std::string command = "tar -xzO -f '" + file + "' --wildcards '*/matrix.dat'";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  const auto size = static_cast<std::size_t>(image->GetNumberOfPoints());
  EXPECT_TRUE(pipe);
  EXPECT_EQ(
    pipe ? std::fread(image->GetScalarPointer(), sizeof(std::int16_t), size, pipe.get()) : 0, size);
  return image;
}

void ExpectEqual(vtkImageData* scan, const std::vector<double>& isovalues)
{
  for (const double isovalue : isovalues)
  {
    const EdgeSurface expected = ContourByFlyingEdges(scan, isovalue);
    EXPECT_GT(expected.Triangles.size(), 10000u) << isovalue;
    EXPECT_TRUE(AreEqual(ContourToEdges(scan, isovalue), expected)) << isovalue;
  }
}

} // namespace

TEST(StabbingContourScans, HeadMRIEqualsFlyingEdges)
{
  if (!IsReadable(ISOSURFACE_MRI_SCAN))
  {
    GTEST_SKIP() << "the package mricron-data is not installed";
  }
  vtkNew<vtkNIFTIImageReader> reader;
  reader->SetFileName(ISOSURFACE_MRI_SCAN);
  reader->Update();
  ExpectEqual(reader->GetOutput(), { 32.0, 80.5, 120.0 });
}

TEST(StabbingContourScans, SkullCTEqualsFlyingEdges)
{
  if (!IsReadable(ISOSURFACE_CT_SCAN))
  {
    GTEST_SKIP() << "the package invesalius-examples is not installed";
  }
  ExpectEqual(ReadCranium(ISOSURFACE_CT_SCAN), { -300.0, 400.5, 1200.0 });
}
