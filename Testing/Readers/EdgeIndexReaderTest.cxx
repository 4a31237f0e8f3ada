// SPDX-License-Identifier: BSD-3-Clause
// Pieces, regions and previews of edge-index files, and files that are damaged.
#include "ScratchFolder.h"
#include "SeenText.h"
#include "TestVolumes.h"

#include "vtkCellArray.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkEdgeIndexReader.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkIdList.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include <algorithm>
#include <filesystem>
#include <set>

using namespace isosurface;

namespace
{

constexpr Extent Grid{ -3, 140, 0, 90, 5, 113 };

class EdgeIndexReader : public testing::Test
{
protected:
  EdgeIndexReader()
  {
    // A region is a box of the world: straight axes, but neither unit spacing nor origin 0.
    this->Image->SetOrigin(-20, 3, 100);
    this->Image->SetSpacing(0.5, 2, 1);
    const auto contour = MakeContour(this->Image, 60);
    contour->SetValue(1, 120.25);
    vtkNew<vtkEdgeIndexWriter> writer;
    writer->SetInputConnection(contour->GetOutputPort());
    writer->SetFileName(this->Path.c_str());
    writer->SetProfile(vtkEdgeIndexWriter::WORKING);
    EXPECT_EQ(writer->Write(), 1);
    contour->Update();
    this->Whole.Add(contour->GetOutput());
    this->Whole.DropNormals();
    this->Reader->SetFileName(this->Path.c_str());
  }

  EdgeSurface Read(int piece = 0, int pieces = 1)
  {
    const ExpectNoErrors errors(this->Reader);
    this->Reader->UpdatePiece(piece, pieces, 0);
    EdgeSurface surface = ToEdges(this->Reader->GetOutput());
    surface.DropNormals();
    return surface;
  }

  std::string ReadInVain()
  {
    const ErrorCounter errors(this->Reader);
    this->Reader->Modified();
    this->Reader->Update();
    EXPECT_EQ(errors.Messages.size(), 1u);
    EXPECT_EQ(this->Reader->GetOutput()->GetNumberOfPoints(), 0);
    return errors.Messages.empty() ? "" : errors.Messages.front();
  }

  ScratchFolder Folder;
  const std::string Path = Folder.GetPath("surface.eix");
  vtkSmartPointer<vtkImageData> Image = MakeClosedVolume(Grid, VTK_UNSIGNED_CHAR);
  EdgeSurface Whole;
  vtkNew<vtkEdgeIndexReader> Reader;
};

// Whether a triangle's bounds meet a box.
bool Meets(vtkPolyData* surface, vtkIdList* triangle, const double bounds[6])
{
  bool meets = true;
  for (int axis = 0; axis < 3; ++axis)
  {
    double low = 1e300;
    double high = -1e300;
    for (vtkIdType corner = 0; corner < 3; ++corner)
    {
      const double place = surface->GetPoint(triangle->GetId(corner))[axis];
      low = std::min(low, place);
      high = std::max(high, place);
    }
    meets = meets && low <= bounds[2 * axis + 1] && high >= bounds[2 * axis];
  }
  return meets;
}

// The triangles that meet a box, by ids.
std::set<EdgeSurface::Triangle> FindWithin(vtkPolyData* surface, const double bounds[6])
{
  std::set<EdgeSurface::Triangle> triangles;
  vtkDataArray* ids = surface->GetPointData()->GetGlobalIds();
  vtkNew<vtkIdList> points;
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell)
  {
    surface->GetCellPoints(cell, points);
    if (Meets(surface, points, bounds))
    {
      EdgeSurface::Triangle triangle{};
      for (vtkIdType corner = 0; corner < 3; ++corner)
      {
        triangle[static_cast<std::size_t>(corner)] =
          static_cast<std::int64_t>(ids->GetTuple1(points->GetId(corner)));
      }
      triangles.insert(triangle);
    }
  }
  return triangles;
}

} // namespace

TEST_F(EdgeIndexReader, PointsCarryTheirIsovalue)
{
  this->Reader->Update();
  vtkPointData* data = this->Reader->GetOutput()->GetPointData();
  ASSERT_NE(data->GetScalars(), nullptr);
  EXPECT_STREQ(data->GetScalars()->GetName(), "density");
  const auto each = 3 * static_cast<double>(this->Image->GetNumberOfPoints());
  vtkIdType wrong = 0;
  for (vtkIdType n = 0; n < this->Reader->GetOutput()->GetNumberOfPoints(); ++n)
  {
    const bool isFirst = data->GetGlobalIds()->GetTuple1(n) < each;
    wrong += data->GetScalars()->GetTuple1(n) == (isFirst ? 60 : 120.25) ? 0 : 1;
  }
  EXPECT_EQ(wrong, 0);
  this->Reader->SetComputeScalars(false);
  this->Reader->Update();
  EXPECT_EQ(this->Reader->GetOutput()->GetPointData()->GetScalars(), nullptr);
}

TEST_F(EdgeIndexReader, ARegionHasAllTrianglesInTheBoxAndLeavesMostOthersOut)
{
  this->Reader->Update();
  vtkNew<vtkPolyData> whole;
  whole->ShallowCopy(this->Reader->GetOutput());
  this->Reader->SetUseRegion(true);
  const double boxes[4][6] = { { 12, 16, 110, 120, 110, 120 }, { -100, 0, -100, 300, 0, 300 },
    { 10, 10, 100, 100, 150, 180 }, { 1e3, 1e4, 0, 1, 0, 1 } };
  for (const auto& bounds : boxes)
  {
    this->Reader->SetRegionPosition(bounds[0], bounds[2], bounds[4]);
    this->Reader->SetRegionLength(
      bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
    this->Reader->Update();
    vtkPolyData* part = this->Reader->GetOutput();
    EXPECT_EQ(FindWithin(part, bounds), FindWithin(whole, bounds));
    EXPECT_LT(part->GetNumberOfPolys(), whole->GetNumberOfPolys() * 2 / 3);
  }
  EXPECT_EQ(this->Reader->GetOutput()->GetNumberOfPolys(), 0) << "a box beside the grid";
}

TEST_F(EdgeIndexReader, ThePreviewIsCoarseAndInTheSamePlace)
{
  this->Reader->Update();
  double whole[6];
  this->Reader->GetOutput()->GetBounds(whole);
  const vtkIdType triangles = this->Reader->GetOutput()->GetNumberOfPolys();
  this->Reader->SetPreview(true);
  this->Reader->Update();
  double coarse[6];
  this->Reader->GetOutput()->GetBounds(coarse);
  EXPECT_GT(this->Reader->GetOutput()->GetNumberOfPolys(), triangles / 500);
  EXPECT_LT(this->Reader->GetOutput()->GetNumberOfPolys(), triangles / 20);
  const double spacing[3] = { 0.5, 2, 1 };
  for (int side = 0; side < 6; ++side)
  {
    EXPECT_NEAR(coarse[side], whole[side], 12 * spacing[side / 2]) << "side " << side;
  }
}

TEST_F(EdgeIndexReader, AFileThatWasCutOffGivesItsCompleteBlocksAndAWarning)
{
  Truncate(this->Path, std::filesystem::file_size(this->Path) * 2 / 3);
  const MessageKeeper warnings(this->Reader, vtkCommand::WarningEvent);
  const EdgeSurface part = this->Read();
  ExpectOneError(warnings, { "surface.eix", "blocks are complete" });
  EXPECT_GT(part.Triangles.size(), this->Whole.Triangles.size() / 10);
  EXPECT_TRUE(std::includes(this->Whole.Triangles.begin(), this->Whole.Triangles.end(),
    part.Triangles.begin(), part.Triangles.end()));
}

TEST_F(EdgeIndexReader, ErrorsHaveNoWordOfThePipeline)
{
  FlipBit(this->Path, 100);
  SeenText seen;
  this->Reader->Update();
  EXPECT_NE(seen.Get().find("surface.eix: "), std::string::npos) << seen.Get();
  EXPECT_EQ(seen.Get().find("returned failure"), std::string::npos) << seen.Get();
}

TEST_F(EdgeIndexReader, DamageIsAnErrorThatNamesTheFile)
{
  const std::string sound = ReadBytes(this->Path);
  FlipBit(this->Path, 30000);
  EXPECT_NE(this->ReadInVain().find("surface.eix: "), std::string::npos);
  WriteBytes(this->Path, sound);
  FlipBit(this->Path, 100);
  EXPECT_NE(this->ReadInVain().find("checksum"), std::string::npos);
  WriteBytes(this->Path, "");
  EXPECT_NE(this->ReadInVain().find("surface.eix: "), std::string::npos);
  EXPECT_EQ(vtkEdgeIndexReader::CanReadFile(this->Path.c_str()), 0);
  WriteBytes(this->Path, sound);
  EXPECT_EQ(vtkEdgeIndexReader::CanReadFile(this->Path.c_str()), 1);
  this->Reader->Modified();
  EXPECT_TRUE(AreEqual(this->Read(), this->Whole)) << "a file that is sound again";
  this->Reader->SetFileName("/no/such/file.eix");
  EXPECT_NE(this->ReadInVain().find("/no/such/file.eix"), std::string::npos);
}
