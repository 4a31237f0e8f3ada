// SPDX-License-Identifier: BSD-3-Clause
// An edge-index file is the same, byte for byte, for any number of ranks that write it, and holds
// the surface that vtkFlyingEdges3D makes of the whole volume, for any number that read it.
#include "ParallelVolumes.h"

#include "vtkEdgeIndexReader.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkMultiProcessController.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <ostream>

using namespace isosurface;

namespace
{

const std::vector<double> FileIsovalues = { 150.0, 60.5 };

struct FileCase
{
  int Type;
  int Layout;    ///< of the image's pieces
  int BlockSize; ///< of the blocked volume between; 0: none, the image itself
  int Mode = vtkEdgeIndexWriter::LOSSLESS;

  std::string GetName() const
  {
    const char* const layouts[] = { "subextents", "firstRank", "overlapping", "everywhere" };
    const char* const modes[] = { "lossless", "bounded", "quantized", "smallest" };
    return "eix_type" + std::to_string(this->Type) + "_" + layouts[this->Layout] + "_" +
      (this->BlockSize ? "blocks" + std::to_string(this->BlockSize) : "image") + "_" +
      modes[this->Mode];
  }
};

std::ostream& operator<<(std::ostream& stream, const FileCase& one)
{
  return stream << one.GetName();
}

vtkImageData* GetFileVolume(int type)
{
  static std::map<int, vtkSmartPointer<vtkImageData>> volumes;
  vtkSmartPointer<vtkImageData>& volume = volumes[type];
  if (!volume)
  {
    volume = MakeClosedVolume({ 5, 74, -30, 30, -11, 71 }, type);
    TurnObliquely(volume);
  }
  return volume;
}

EdgeSurface GetExpected(int type, double isovalue)
{
  EdgeSurface surface = ContourByFlyingEdges(GetFileVolume(type), isovalue);
  surface.DropNormals();
  return surface;
}

void ExpectSuccess(vtkEdgeIndexWriter* writer)
{
  const ExpectNoErrors errors(writer);
  EXPECT_EQ(writer->Write(), 1);
}

class EdgeIndexOnRanks : public testing::TestWithParam<FileCase>
{
protected:
  // Writes the case's surface; collective.
  void WriteFile(const std::string& path)
  {
    const FileCase& one = GetParam();
    vtkNew<vtkEdgeIndexWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetMode(one.Mode);
    writer->SetMemoryLimit(1);
    if (one.BlockSize > 0)
    {
      WriteFromPieces(GetFileVolume(one.Type), one.Layout, path + ".bvol", { one.BlockSize, 3 });
      const ContourPipeline pipeline(path + ".bvol");
      SetIsovalues(pipeline.Contour, FileIsovalues);
      writer->SetInputConnection(pipeline.Contour->GetOutputPort());
      ExpectSuccess(writer);
      EXPECT_EQ(pipeline.Contour->GetOutput()->GetNumberOfPoints(), 0)
        << "the contour made the surface";
      return;
    }
    const auto contour = MakeContour(MakeSource(GetFileVolume(one.Type), one.Layout), 0);
    SetIsovalues(contour, FileIsovalues);
    writer->SetInputConnection(contour->GetOutputPort());
    ExpectSuccess(writer);
  }

  // Leaves the file for runs of more ranks, or compares with what the run of one rank left.
  void CheckBytes(const std::string& path)
  {
    if (GetRank() != 0)
    {
      return;
    }
    const std::string bytes = ReadBytes(path);
    const std::string left = "fingerprints/" + GetParam().GetName();
    if (GetNumberOfRanks() == 1)
    {
      std::filesystem::create_directories("fingerprints");
      WriteBytes(left, bytes);
    }
    EXPECT_TRUE(bytes == ReadBytes(left)) << "the file differs from that which one rank writes";
  }

  // The n-th isosurface that all ranks read.
  EdgeSurface Gather(vtkPolyData* mine, std::size_t number)
  {
    const std::int64_t ids =
      3 * static_cast<std::int64_t>(GetFileVolume(GetParam().Type)->GetNumberOfPoints());
    EdgeSurface part;
    const auto first = static_cast<std::int64_t>(number);
    part.Add(mine, first * ids, (first + 1) * ids);
    part.DropNormals();
    EdgeSurface all = GatherSurfaces(part);
    all.MergeEqualPoints();
    return all;
  }

  void CheckSurface(vtkPolyData* mine)
  {
    for (std::size_t number = 0; number < FileIsovalues.size(); ++number)
    {
      EdgeSurface all = this->Gather(mine, number);
      if (GetRank() != 0)
      {
        continue;
      }
      const EdgeSurface expected = GetExpected(GetParam().Type, FileIsovalues[number]);
      if (GetParam().Mode == vtkEdgeIndexWriter::LOSSLESS)
      {
        EXPECT_TRUE(AreEqual(all, expected)) << "at " << FileIsovalues[number];
        EXPECT_TRUE(IsClosedManifold(all)) << "at " << FileIsovalues[number];
      }
      else
      {
        EXPECT_EQ(all.Triangles, expected.Triangles) << "at " << FileIsovalues[number];
      }
    }
  }
};

std::vector<FileCase> MakeFileCases()
{
  std::vector<FileCase> cases;
  for (const int layout : { 0, 1, 2, 3 })
  {
    cases.push_back({ VTK_SHORT, layout, 0 });
  }
  cases.push_back({ VTK_FLOAT, 0, 0 });
  cases.push_back({ VTK_UNSIGNED_CHAR, 0, 0, vtkEdgeIndexWriter::SMALLEST });
  cases.push_back({ VTK_UNSIGNED_CHAR, 0, 16 });
  cases.push_back({ VTK_SHORT, 0, 32 });
  cases.push_back({ VTK_FLOAT, 0, 64 });
  cases.push_back({ VTK_FLOAT, 0, 32, vtkEdgeIndexWriter::BOUNDED });
  cases.push_back({ VTK_SHORT, 0, 16, vtkEdgeIndexWriter::QUANTIZED });
  return cases;
}

} // namespace

TEST_P(EdgeIndexOnRanks, FileIsTheSameAndHoldsTheWholeSurface)
{
  const SharedFolder folder("EdgeIndexOnRanks-" + GetParam().GetName());
  const std::string path = folder.GetPath("surface.eix");
  this->WriteFile(path);
  this->CheckBytes(path);
  vtkNew<vtkEdgeIndexReader> reader;
  const ExpectNoErrors errors(reader);
  reader->SetFileName(path.c_str());
  EXPECT_TRUE(reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0));
  this->CheckSurface(reader->GetOutput());
  const std::uint64_t all =
    SumOverRanks(static_cast<std::uint64_t>(reader->GetOutput()->GetNumberOfPolys()));
  const auto mine = static_cast<double>(reader->GetOutput()->GetNumberOfPolys());
  if (GetParam().BlockSize == 16)
  {
    EXPECT_LT(mine * GetNumberOfRanks(), 1.5 * static_cast<double>(all))
      << "the ranks' shares are not even";
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, EdgeIndexOnRanks, testing::ValuesIn(MakeFileCases()),
  [](const auto& one) { return one.param.GetName(); });

namespace
{

/// How a contour is set up, of which a file is written.
struct ContourCase
{
  const char* Name;
  std::function<void(vtkStabbingContour*)> SetUp;
  int Mode = vtkEdgeIndexWriter::LOSSLESS;
  vtkSmartPointer<vtkImageData> Image = GetFileVolume(VTK_SHORT);
};

EdgeSurface GatherAll(vtkPolyData* mine)
{
  EdgeSurface part;
  part.Add(mine, 0, std::numeric_limits<std::int64_t>::max());
  part.DropNormals();
  EdgeSurface all = GatherSurfaces(part);
  all.MergeEqualPoints();
  return all;
}

/// Writes a file of an image and one of a volume, which are the same for any number of ranks, and hold the surface of
/// the filter.
void ExpectSurfaceOfFilter(const ContourCase& one)
{
  for (const bool isVolume : { false, true })
  {
    const std::string name = std::string("eix_") + one.Name + (isVolume ? "_volume" : "_image");
    const SharedFolder folder("EdgeIndexOfFilterOnRanks-" + name);
    const std::string path = folder.GetPath("surface.eix");
    WriteFromPieces(one.Image, 0, path + ".bvol", { 16, 3 });
    const ContourPipeline pipeline(path + ".bvol");
    const auto ofImage = MakeContour(MakeSource(one.Image), 0);
    vtkStabbingContour* const contour = isVolume ? pipeline.Contour.Get() : ofImage.Get();
    SetIsovalues(contour, FileIsovalues);
    one.SetUp(contour);
    vtkNew<vtkEdgeIndexWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetMode(one.Mode);
    writer->SetInputConnection(contour->GetOutputPort());
    ExpectSuccess(writer);
    vtkNew<vtkEdgeIndexReader> reader;
    reader->SetFileName(path.c_str());
    EXPECT_TRUE(reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0));
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    const EdgeSurface read = GatherAll(reader->GetOutput());
    const EdgeSurface expected = GatherAll(contour->GetOutput());
    if (GetRank() == 0)
    {
      EXPECT_GT(read.Triangles.size(), 1000u) << name;
      EXPECT_EQ(read.Triangles, expected.Triangles) << name;
      EXPECT_TRUE(one.Mode != vtkEdgeIndexWriter::LOSSLESS || AreEqual(read, expected)) << name;
      const std::string left = "fingerprints/" + name;
      if (GetNumberOfRanks() == 1)
      {
        std::filesystem::create_directories("fingerprints");
        WriteBytes(left, ReadBytes(path));
      }
      EXPECT_TRUE(ReadBytes(path) == ReadBytes(left)) << name;
    }
  }
}

/// Shells within shells, with dust between them.
vtkSmartPointer<vtkImageData> MakeShells()
{
  const auto image = MakeImage({ 5, 64, -30, 30, -11, 41 }, VTK_SHORT,
    [](int i, int j, int k)
    {
      const double r = std::sqrt((i - 34) * (i - 34) + j * j + (k - 15) * (k - 15));
      return 105 + 80 * std::cos(0.5 * r) + ((7 * i + 31 * j + 13 * k) % 211 == 0 ? 90 : 0);
    });
  TurnObliquely(image);
  return image;
}

} // namespace

TEST(EdgeIndexClosedOnRanks, FileIsTheSameAndHoldsTheSurfaceOfTheFilter)
{
  for (const int side : { vtkStabbingContour::ABOVE, vtkStabbingContour::BELOW })
  {
    ExpectSurfaceOfFilter({ side == vtkStabbingContour::ABOVE ? "closed0" : "closed1",
      [side](vtkStabbingContour* contour)
      {
        contour->SetCloseBoundary(1);
        contour->SetInside(side);
      } });
  }
}

TEST(EdgeIndexIslandsOnRanks, FileIsTheSameAndHoldsTheIslandsThatTheFilterKeeps)
{
  const auto shells = MakeShells();
  const auto keepLargest = [](vtkStabbingContour* contour) { contour->SetMaximumIslands(3); };
  const auto dropDust = [](vtkStabbingContour* contour)
  {
    contour->SetIslandSize(vtkStabbingContour::AREA);
    contour->SetMinimumIslandSize(40);
  };
  const auto keepOne = [](vtkStabbingContour* contour)
  {
    // A wall of a cavity, with bodies in it.
    const double place[3] = { 34, 0, 15 };
    contour->SetMinimumIslandSize(3000);
    contour->SetUseIslandPoint(true);
    contour->SetIslandPoint(place[0], place[1], place[2]);
  };
  const auto close = [](vtkStabbingContour* contour)
  {
    contour->SetCloseBoundary(1);
    contour->SetInside(vtkStabbingContour::BELOW);
    contour->SetIslandSize(vtkStabbingContour::VOLUME);
    contour->SetMaximumIslands(2);
  };
  ExpectSurfaceOfFilter({ "islands", keepLargest, vtkEdgeIndexWriter::LOSSLESS, shells });
  ExpectSurfaceOfFilter({ "dust", dropDust, vtkEdgeIndexWriter::SMALLEST, shells });
  ExpectSurfaceOfFilter({ "one", keepOne, vtkEdgeIndexWriter::LOSSLESS, shells });
  // Lossless, whatever is asked for.
  ExpectSurfaceOfFilter({ "closed_islands", close, vtkEdgeIndexWriter::SMALLEST, shells });
}

TEST(EdgeIndexErrorsOnRanks, AStopOfOneRankStopsAllReaders)
{
  const SharedFolder folder("EdgeIndexStopOnRanks");
  const std::string path = folder.GetPath("surface.eix");
  const auto source = MakeSource(GetFileVolume(VTK_SHORT));
  const auto contour = MakeContour(source, 0);
  SetIsovalues(contour, FileIsovalues);
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(contour->GetOutputPort());
  writer->SetFileName(path.c_str());
  ExpectSuccess(writer);
  vtkNew<vtkEdgeIndexReader> reader;
  const ExpectNoErrors errors(reader);
  reader->SetFileName(path.c_str());
  reader->SetAbortExecute(GetRank() == 0 ? 1 : 0);
  for (int turn = 0; turn < 2; ++turn) // the second one unmodified
  {
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), 0);
  }
  reader->SetAbortExecute(0);
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  EXPECT_GT(SumOverRanks(static_cast<std::uint64_t>(reader->GetOutput()->GetNumberOfPoints())), 0u);
}

TEST(EdgeIndexErrorsOnRanks, AreToldByAll)
{
  const SharedFolder folder("EdgeIndexErrorsOnRanks");
  const std::string path = folder.GetPath("surface.eix");
  const auto source = MakeSource(GetFileVolume(VTK_SHORT));
  const auto contour = MakeContour(source, 0);
  SetIsovalues(contour, FileIsovalues);
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(contour->GetOutputPort());
  {
    // A folder that is not there, which rank 0 finds first.
    const ErrorCounter errors(writer);
    writer->SetFileName((folder.GetPath("nowhere") + "/surface.eix").c_str());
    EXPECT_EQ(writer->Write(), 0);
    ExpectOneError(errors, { "nowhere" });
  }
  writer->SetFileName(path.c_str());
  ExpectSuccess(writer);
  {
    // Pieces that do not meet, if they are several.
    source->SetLayout(PieceSource::GAP);
    const std::string before = ReadBytes(path);
    const ErrorCounter errors(writer);
    if (writer->Write() == 0)
    {
      ExpectOneError(errors, { "gaps" });
      GetRanks()->Barrier();
      EXPECT_TRUE(ReadBytes(path) == before);
    }
  }
  GetRanks()->Barrier();
  {
    // No file name on one rank alone.
    const int last = GetNumberOfRanks() - 1;
    writer->SetFileName(GetRank() == last ? "" : path.c_str());
    const ErrorCounter errors(writer);
    EXPECT_EQ(writer->Write(), 0);
    ExpectOneError(errors, { "No file name is set" });
  }
  if (GetNumberOfRanks() > 1)
  {
    // Ranks that see different files under one path.
    const std::string other = folder.GetPath("other.eix");
    source->SetLayout(PieceSource::SUB_EXTENTS);
    contour->SetValue(0, contour->GetValue(0) + 1);
    writer->SetFileName(other.c_str());
    ExpectSuccess(writer);
    vtkNew<vtkEdgeIndexReader> reader;
    const ErrorCounter errors(reader);
    reader->SetFileName((GetRank() == 1 ? other : path).c_str());
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    ExpectOneError(errors, { "different files under this path", "(rank 1 differs" });
    EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), 0);
  }
  OnFirstRank([&] { FlipBit(path, 1200); });
  vtkNew<vtkEdgeIndexReader> reader;
  const ErrorCounter errors(reader);
  reader->SetFileName(path.c_str());
  reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectOneError(errors, { "surface.eix: " });
  EXPECT_EQ(reader->GetOutput()->GetNumberOfPoints(), 0);
}
