// SPDX-License-Identifier: BSD-3-Clause
// What vtkDistributeIsosurface gives all ranks together is the surface that vtkFlyingEdges3D makes
// of the whole volume, in compact parts of equal work, for any number of ranks.
#include "EventCounter.h"
#include "ParallelVolumes.h"
#include "VolumeDamage.h"

#include "Ground/Base/FileSystem.h"
#include "vtkBlockedVolumeReader.h"
#include "vtkClipPolyData.h"
#include "vtkDataArray.h"
#include "vtkDistributeIsosurface.h"
#include "vtkExecutive.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkMultiProcessController.h"
#include "vtkPassThrough.h"
#include "vtkPlane.h"
#include "vtkPointData.h"
#include "vtkStabbingContour.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <ostream>
#include <set>

using namespace isosurface;

namespace
{

using Distribute = vtkDistributeIsosurface;

const std::vector<double> Isovalues = { 150.0, 60.5 };
const Extent Whole = { 5, 54, -20, 20, -11, 41 };

vtkImageData* GetVolume(int type)
{
  static std::map<int, vtkSmartPointer<vtkImageData>> volumes;
  vtkSmartPointer<vtkImageData>& volume = volumes[type];
  if (!volume)
  {
    volume = MakeClosedVolume(Whole, type);
    TurnObliquely(volume);
  }
  return volume;
}

// A contour, of an image or of a volume in a folder, and the filter behind it.
class DistributedContour
{
public:
  explicit DistributedContour(const std::string& name)
    : Folder("DistributeOnRanks-" + name)
  {
    SetIsovalues(this->Contour, Isovalues);
    this->Filter->SetInputConnection(this->Contour->GetOutputPort());
    this->Filter->SetNormalError(0);
  }

  void UseVolume(vtkImageData* image, const VolumeSettings& settings)
  {
    WriteFromPieces(image, PieceSource::SUB_EXTENTS, this->GetPath(), settings);
    this->Reader->SetFileName(this->GetPath().c_str());
    this->Contour->SetInputConnection(this->Reader->GetOutputPort());
  }
  void UseImage(vtkImageData* image, int layout)
  {
    this->Source->SetImage(image);
    this->Source->SetLayout(layout);
    this->Contour->SetInputConnection(this->Source->GetOutputPort());
  }
  std::string GetPath() const { return this->Folder.GetPath("volume.bvol"); }

  /// This rank's part; collective.
  vtkPolyData* Update()
  {
    EXPECT_EQ(this->UpdateInVain(), std::vector<std::string>());
    return this->Filter->GetOutput();
  }

  /// What is said of errors; collective.
  std::vector<std::string> UpdateInVain()
  {
    const ErrorCounter errors(this->Filter);
    const ErrorCounter contourErrors(this->Contour);
    const ErrorCounter readerErrors(this->Reader);
    this->Filter->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    std::vector<std::string> all = errors.Messages;
    all.insert(all.end(), contourErrors.Messages.begin(), contourErrors.Messages.end());
    all.insert(all.end(), readerErrors.Messages.begin(), readerErrors.Messages.end());
    return all;
  }

  /// The contour's own part, of whatever blocks this rank has; collective.
  vtkPolyData* UpdateContour()
  {
    this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    return this->Contour->GetOutput();
  }

  SharedFolder Folder;
  vtkNew<vtkBlockedVolumeReader> Reader;
  vtkNew<PieceSource> Source;
  vtkNew<vtkStabbingContour> Contour;
  vtkNew<vtkDistributeIsosurface> Filter;
};

// The n-th isosurface of all ranks' parts, on rank 0; collective.
EdgeSurface Gather(vtkPolyData* mine, std::size_t number)
{
  const auto ids = 3 * static_cast<std::int64_t>(GetVolume(VTK_SHORT)->GetNumberOfPoints());
  const auto first = static_cast<std::int64_t>(number);
  return GatherSurface(mine, first * ids, (first + 1) * ids);
}

// Collective.
void ExpectWholeSurface(vtkPolyData* mine, int type)
{
  for (std::size_t number = 0; number < Isovalues.size(); ++number)
  {
    const EdgeSurface all = Gather(mine, number);
    if (GetRank() == 0)
    {
      EXPECT_TRUE(AreEqual(all, ContourByFlyingEdges(GetVolume(type), Isovalues[number])));
      EXPECT_TRUE(IsClosedManifold(all));
    }
  }
}

double GetField(vtkPolyData* surface, const char* name)
{
  vtkDataArray* array = surface->GetFieldData()->GetArray(name);
  return array ? array->GetTuple1(0) : -1;
}

struct DistributeCase
{
  int Type;
  int BlockSize; ///< 0: an image, not a blocked volume
  int Layout;    ///< of the image's pieces
  int Mode;
  int DrawingRanks;
  int RoundBytes;

  std::string GetName() const
  {
    const char* const modes[] = { "", "lossless", "bounded", "smallest" };
    return "type" + std::to_string(this->Type) + "_" + modes[this->Mode] + "_" +
      (this->BlockSize ? "blocks" + std::to_string(this->BlockSize)
                       : "image" + std::to_string(this->Layout)) +
      "_to" + std::to_string(this->DrawingRanks) + "_rounds" + std::to_string(this->RoundBytes);
  }
};

std::ostream& operator<<(std::ostream& stream, const DistributeCase& one)
{
  return stream << one.GetName();
}

class DistributeOnRanks : public testing::TestWithParam<DistributeCase>
{
};

TEST_P(DistributeOnRanks, GivesTheSurfaceOfTheWholeVolume)
{
  const DistributeCase& one = GetParam();
  DistributedContour distributed(one.GetName());
  if (one.BlockSize > 0)
  {
    distributed.UseVolume(
      GetVolume(one.Type), { one.BlockSize, 3, vtkBlockedVolumeWriter::RANDOM });
  }
  else
  {
    distributed.UseImage(GetVolume(one.Type), one.Layout);
  }
  distributed.Filter->SetMode(one.Mode);
  distributed.Filter->SetDrawingRanks(one.DrawingRanks);
  distributed.Filter->SetRoundBytes(one.RoundBytes);
  vtkPolyData* mine = distributed.Update();
  ExpectWholeSurface(mine, one.Type);
  if (GetNumberOfRanks() == 1)
  {
    return;
  }
  EXPECT_EQ(distributed.Contour->GetOutput()->GetNumberOfPoints(), 0)
    << "the contour made the surface as well";
  if (one.DrawingRanks > 0 && GetRank() >= one.DrawingRanks)
  {
    EXPECT_EQ(mine->GetNumberOfPoints(), 0);
  }
  const auto points = static_cast<std::uint64_t>(GetField(mine, "ReceivedPoints"));
  EXPECT_EQ(SumOverRanks(points),
    SumOverRanks(static_cast<std::uint64_t>(GetField(mine, "ExtractedPoints"))));
  EXPECT_EQ(GetField(mine, "Triangles"), static_cast<double>(mine->GetNumberOfPolys()));
  EXPECT_EQ(GetField(mine, "Rank"), GetRank());
  if (one.RoundBytes < 5000)
  {
    EXPECT_GT(GetField(mine, "Rounds"), 1);
  }
}

std::vector<DistributeCase> MakeCases()
{
  return {
    { VTK_SHORT, 16, 0, Distribute::LOSSLESS, 0, 1 << 22 },
    { VTK_UNSIGNED_CHAR, 16, 0, Distribute::LOSSLESS, 2, 1000 },
    { VTK_UNSIGNED_CHAR, 32, 0, Distribute::LOSSLESS, 1, 1 << 14 },
    { VTK_FLOAT, 32, 0, Distribute::LOSSLESS, 3, 1 << 22 },
    { VTK_SHORT, 0, PieceSource::SUB_EXTENTS, Distribute::LOSSLESS, 0, 1 << 22 },
    { VTK_SHORT, 0, PieceSource::FIRST_RANK, Distribute::LOSSLESS, 0, 1 << 22 },
    { VTK_FLOAT, 0, PieceSource::OVERLAPPING, Distribute::LOSSLESS, 0, 1 << 22 },
  };
}

INSTANTIATE_TEST_SUITE_P(Cases, DistributeOnRanks, testing::ValuesIn(MakeCases()),
  [](const auto& one) { return one.param.GetName(); });

// Each point's GlobalId and the bits of its other arrays: of all ranks, on all ranks; collective.
std::set<std::string> ListPointData(vtkPolyData* mine)
{
  std::string text;
  vtkPointData* data = mine->GetPointData();
  vtkDataArray* ids = data->GetGlobalIds();
  for (vtkIdType point = 0; point < mine->GetNumberOfPoints(); ++point)
  {
    text += std::to_string(static_cast<vtkIdType>(ids->GetTuple1(point)));
    for (int n = 0; n < data->GetNumberOfArrays(); ++n)
    {
      vtkDataArray* array = data->GetArray(n);
      text += std::string(" ") + array->GetName();
      for (int component = 0; component < array->GetNumberOfComponents(); ++component)
      {
        const double value = array->GetComponent(point, component);
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof(bits));
        const char* name = array->GetComponentName(component);
        text += std::string(" ") + (name ? name : "") + std::to_string(bits);
      }
    }
    text += '\n';
  }
  std::set<std::string> lines;
  for (const std::string& other : GatherTexts(text))
  {
    for (std::size_t at = 0; at < other.size();)
    {
      const std::size_t end = other.find('\n', at);
      lines.insert(other.substr(at, end - at));
      at = end + 1;
    }
  }
  return lines;
}

TEST(DistributePointData, IsThatOfTheContour)
{
  // The image is on one rank: the others do not know its arrays.
  DistributedContour distributed("PointData");
  const auto image = MakeImage({ 0, 70, 0, 20, 0, 20 }, VTK_SHORT, MakeWaves(200));
  vtkNew<vtkFloatArray> velocity;
  velocity->SetName("velocity");
  velocity->SetNumberOfComponents(2);
  velocity->SetComponentName(0, "u");
  velocity->SetComponentName(1, "v");
  for (vtkIdType point = 0; point < image->GetNumberOfPoints(); ++point)
  {
    velocity->InsertNextTuple2(0.1 * static_cast<double>(point), std::sin(point));
  }
  image->GetPointData()->AddArray(velocity);
  distributed.UseImage(image, PieceSource::FIRST_RANK);
  distributed.Contour->AddInterpolatedArray("velocity");
  vtkNew<vtkStabbingContour> alone;
  alone->SetController(nullptr);
  alone->SetInputData(image);
  alone->SetValue(0, Isovalues[0]);
  alone->SetValue(1, Isovalues[1]);
  alone->AddInterpolatedArray("velocity");
  alone->Update();
  const std::set<std::string> expected = ListPointData(alone->GetOutput());
  vtkPolyData* mine = distributed.Update();
  const std::set<std::string> lines = ListPointData(mine);
  EXPECT_EQ(lines.size(), expected.size());
  EXPECT_TRUE(lines == expected);
  for (const char* name : { "GlobalIds", "density", "Normals", "velocity" })
  {
    EXPECT_TRUE(mine->GetNumberOfPoints() == 0 || mine->GetPointData()->HasArray(name)) << name;
  }
}

TEST(DistributeParts, AreEmptyWithoutASurface)
{
  DistributedContour distributed("Empty");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 2 });
  distributed.Contour->SetNumberOfContours(1);
  distributed.Contour->SetValue(0, 1e6);
  for (const int mode : { Distribute::LOSSLESS, Distribute::BOUNDED })
  {
    distributed.Filter->SetMode(mode);
    EXPECT_EQ(distributed.Update()->GetNumberOfPoints(), 0);
  }
  distributed.Contour->SetNumberOfContours(0);
  EXPECT_EQ(distributed.Update()->GetNumberOfPoints(), 0);
}

TEST(DistributeParts, FollowTheContour)
{
  // Isovalues, levels and options of the contour: the filter sees each change.
  DistributedContour distributed("Follow");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 3 });
  vtkNew<vtkPassThrough> between; // as vtkPVPostFilter is, in ParaView
  between->SetInputConnection(distributed.Contour->GetOutputPort());
  distributed.Filter->SetInputConnection(between->GetOutputPort());
  const auto expectSame = [&]
  {
    const std::set<std::string> lines = ListPointData(distributed.Update());
    EXPECT_TRUE(lines == ListPointData(distributed.UpdateContour()));
    EXPECT_GT(lines.size(), 0u);
    return lines.size();
  };
  expectSame();
  distributed.Contour->SetValue(1, 90);
  expectSame();
  distributed.Contour->SetMaximumIslands(1);
  expectSame();
  distributed.Contour->SetLevel(1);
  const std::size_t largest = expectSame();
  distributed.Contour->SetMaximumIslands(0);
  EXPECT_GT(expectSame(), largest);
  if (GetNumberOfRanks() > 1)
  {
    EXPECT_EQ(GetField(distributed.Filter->GetOutput(), "Level"), 1);
  }
  distributed.Contour->SetComputeNormals(0);
  distributed.Contour->SetComputeScalars(0);
  expectSame();
  distributed.Contour->SetGenerateTriangles(0);
  expectSame();
  distributed.Contour->SetMaximumIslands(1);
  expectSame();
}

TEST(DistributeParts, OfALeftHandedGridAtMapCoordinatesAreThoseOfTheContour)
{
  DistributedContour distributed("Map");
  const auto image = MakeClosedVolume({ 0, 39, 0, 39, 0, 39 }, VTK_SHORT);
  image->SetDirectionMatrix(-1, 0, 0, 0, 1, 0, 0, 0, 1);
  image->SetOrigin(448000, 6000000, -2000);
  image->SetSpacing(0.05, 0.05, 0.05);
  distributed.UseVolume(image, { 16, 3 });
  const auto expectType = [&distributed](int type)
  {
    vtkPolyData* mine = distributed.Update();
    EXPECT_EQ(mine->GetPoints()->GetDataType(), type);
    const EdgeSurface all = GatherSurface(mine);
    vtkPolyData* own = distributed.UpdateContour();
    EXPECT_EQ(own->GetPoints()->GetDataType(), type);
    EXPECT_TRUE(AreEqual(all, GatherSurface(own)));
  };
  expectType(VTK_DOUBLE);
  distributed.Contour->SetOutputPointsPrecision(vtkAlgorithm::SINGLE_PRECISION);
  expectType(VTK_FLOAT);
}

TEST(DistributeBounded, KeepsPointsWithinTheErrorAndTogether)
{
  for (const int mode : { Distribute::BOUNDED, Distribute::SMALLEST })
  {
    DistributedContour distributed("Bounded" + std::to_string(mode));
    distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 3, vtkBlockedVolumeWriter::RANDOM });
    distributed.Filter->SetMode(mode);
    distributed.Filter->SetMaximumError(0.03);
    const EdgeSurface all = Gather(distributed.Update(), 0);
    if (GetRank() != 0)
    {
      continue;
    }
    const EdgeSurface expected = ContourByFlyingEdges(GetVolume(VTK_SHORT), Isovalues[0]);
    EXPECT_EQ(all.Triangles, expected.Triangles);
    EXPECT_TRUE(IsClosedManifold(all));
    double spacing[3];
    GetVolume(VTK_SHORT)->GetSpacing(spacing);
    std::map<std::int64_t, EdgePoint> places;
    for (const EdgePoint& point : expected.Points)
    {
      places[point.Edge] = point;
    }
    double worst = 0; // in edges
    for (const EdgePoint& point : all.Points)
    {
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        float moved = 0;
        float place = 0;
        std::memcpy(&moved, &point.Position[axis], sizeof(float));
        std::memcpy(&place, &places.at(point.Edge).Position[axis], sizeof(float));
        square += std::pow(static_cast<double>(moved) - static_cast<double>(place), 2);
      }
      worst = std::max(worst, std::sqrt(square) / spacing[point.Edge % 3]);
    }
    EXPECT_LE(worst, 0.03 + 1e-4);
    if (mode == Distribute::BOUNDED && GetNumberOfRanks() > 1)
    {
      EXPECT_GT(worst, 0.003) << "nothing was moved";
    }
  }
}

TEST(DistributeErrors, AreToldOnceByEveryRankAndPass)
{
  DistributedContour distributed("Errors");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 7, vtkBlockedVolumeWriter::RANDOM });
  const std::string stores = HidePath(distributed.GetPath() + ".stores");
  const std::string good = distributed.Folder.GetPath("good");
  OnFirstRank(
    [&]
    {
      std::filesystem::copy(stores, good, std::filesystem::copy_options::recursive);
      const std::string blocks = GetFirstStore(distributed.GetPath()) + "/blocks";
      const auto size = static_cast<std::int64_t>(std::filesystem::file_size(blocks));
      for (std::int64_t offset = 1000; offset < size; offset += 1000)
      {
        FlipBit(blocks, offset);
      }
    });
  distributed.Contour->Modified();
  const std::vector<std::string> messages = distributed.UpdateInVain();
  EXPECT_TRUE(IsOneMessageAbout(messages, { "", {}, "blocks", "checksum" }))
    << testing::PrintToString(messages);
  EXPECT_EQ(distributed.Filter->GetOutput()->GetNumberOfPoints(), 0);
  // Another isovalue, which does not cross the damaged block: nothing is there.
  distributed.Contour->SetValue(0, 1e6);
  distributed.Contour->SetValue(1, 1e6);
  EXPECT_EQ(distributed.Update()->GetNumberOfPoints(), 0);

  OnFirstRank(
    [&]
    {
      std::filesystem::remove_all(stores);
      std::filesystem::copy(good, stores, std::filesystem::copy_options::recursive);
    });
  distributed.Contour->SetValue(0, Isovalues[0]);
  distributed.Contour->SetValue(1, Isovalues[1]);
  distributed.Reader->Modified();
  ExpectWholeSurface(distributed.Update(), VTK_SHORT);
}

TEST(DistributeErrors, WhatCannotBeDistributedIsRefusedByEveryRank)
{
  DistributedContour distributed("Refused");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 3 });
  const auto expectRefusal = [&](const char* reason)
  {
    const std::vector<std::string> messages = distributed.UpdateInVain();
    EXPECT_EQ(messages.size(), 1u);
    EXPECT_TRUE(!messages.empty() && messages[0].find(reason) != std::string::npos)
      << testing::PrintToString(messages);
    EXPECT_EQ(distributed.Filter->GetOutput()->GetNumberOfPoints(), 0);
  };
  distributed.Contour->CloseBoundaryOn();
  expectRefusal("turn CloseBoundary of Isosurface off");
  distributed.Contour->CloseBoundaryOff();
  distributed.Contour->DropDegenerateTrianglesOn();
  expectRefusal("turn DropDegenerateTriangles of Isosurface off");
  distributed.Contour->DropDegenerateTrianglesOff();
  distributed.Contour->ComputeIslandIdsOn();
  expectRefusal("turn ComputeIslandIds of Isosurface off");
  distributed.Contour->ComputeIslandIdsOff();

  vtkNew<vtkPlane> plane;
  vtkNew<vtkClipPolyData> clip;
  clip->SetClipFunction(plane);
  clip->SetInputConnection(distributed.Contour->GetOutputPort());
  distributed.Filter->SetInputConnection(clip->GetOutputPort());
  expectRefusal("put Distribute Isosurface right behind it");
  distributed.Filter->SetInputConnection(distributed.Contour->GetOutputPort());

  distributed.Filter->SetMode(Distribute::BOUNDED);
  distributed.Filter->SetMaximumError(-1);
  if (GetNumberOfRanks() > 1)
  {
    expectRefusal("error");
  }
  distributed.Filter->SetMode(Distribute::LOSSLESS);
  ExpectWholeSurface(distributed.Update(), VTK_SHORT);
}

// The contour's own surface is not needed.
TEST(DistributeErrors, AContourThatWasStoppedIsDistributed)
{
  DistributedContour distributed("StoppedContour");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 3 });
  distributed.Contour->SetAbortExecute(1);
  EXPECT_EQ(distributed.UpdateContour()->GetNumberOfPoints(), 0);
  distributed.Contour->SetAbortExecute(0);
  ExpectWholeSurface(distributed.Update(), VTK_SHORT);
}

TEST(DistributeErrors, StoppingOneRankStopsAll)
{
  DistributedContour distributed("Stop");
  distributed.UseVolume(GetVolume(VTK_SHORT), { 16, 3 });
  for (const double share : { 0.0, 0.5 })
  {
    vtkDistributeIsosurface* filter = distributed.Filter;
    filter->Modified();
    {
      const ProgressKeeper stop(filter,
        [filter, share](double done)
        {
          if (GetRank() == GetNumberOfRanks() - 1 && done >= share)
          {
            filter->SetAbortExecute(1);
          }
        });
      distributed.Update();
      distributed.Update(); // again on all ranks, unmodified
    }
    if (GetNumberOfRanks() > 1)
    {
      EXPECT_EQ(
        SumOverRanks(static_cast<std::uint64_t>(filter->GetOutput()->GetNumberOfPoints())), 0u);
    }
    filter->SetAbortExecute(0);
    filter->Modified();
    ExpectWholeSurface(distributed.Update(), VTK_SHORT);
  }
}

} // namespace
