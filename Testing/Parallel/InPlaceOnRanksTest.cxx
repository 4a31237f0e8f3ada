// SPDX-License-Identifier: BSD-3-Clause
// A volume in place on any number of ranks: the surface of the whole volume; and a source that one
// rank does not see is one error on all.
#include "ParallelVolumes.h"
#include "VolumeDamage.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkBoundingBox.h"
#include "vtkDataArray.h"
#include "vtkExecutive.h"
#include "vtkFieldData.h"
#include "vtkInPlaceVolumeReader.h"
#include "vtkMultiProcessController.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"
#include "vtkStringArray.h"
#include "vtkVolumeProbe.h"
#include "vtkVolumeRegion.h"
#include "vtkVolumeSlice.h"
#include "vtkZLibDataCompressor.h"

#include "ControllerCommunicator.h"
#include "Formats/Opener/ForeignVolume.h"
#include "Ranks/Query/Refinement.h"
#include "Storage/Store/BlockCache.h"
#include "Storage/Store/SourceRecord.h"
#include "Storage/Writing/BlockedVolumeWriter.h"

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

using namespace isosurface;

namespace
{

constexpr double InPlaceIsovalue = 120.0; // of noise: every block is active

vtkSmartPointer<vtkImageData> MakeNoisyImage()
{
  return MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, 3));
}

/// Writes samples of one byte, raw or as a zlib stream, with a header.
void WriteSource(vtkImageData* image, const std::string& path, bool isStream = false)
{
  const auto* samples = static_cast<const unsigned char*>(image->GetScalarPointer());
  const auto count = static_cast<std::size_t>(image->GetNumberOfPoints());
  std::vector<unsigned char> bytes(samples, samples + count);
  if (isStream)
  {
    const vtkNew<vtkZLibDataCompressor> compressor;
    bytes.resize(compressor->GetMaximumCompressionSpace(count));
    bytes.resize(compressor->Compress(samples, count, bytes.data(), bytes.size()));
  }
  std::ofstream(path + ".raw", std::ios::binary)
    .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const int* size = image->GetDimensions();
  std::ofstream(path) << "ObjectType = Image\nNDims = 3\nDimSize = " << size[0] << " " << size[1]
                      << " " << size[2] << "\n"
                      << "CompressedData = " << (isStream ? "True" : "False") << "\n"
                      << "ElementType = MET_UCHAR\nElementDataFile = "
                      << std::filesystem::path(path).filename().string() << ".raw\n";
}

/// Collective: indexes the source by all ranks. Only a path seen from the volume leads to it.
Status IndexInPlace(const std::string& source, const std::string& path)
{
  FileSystem& files = GetLocalFileSystem();
  ControllerCommunicator ranks(GetRanks());
  ISOSURFACE_ASSIGN_OR_RETURN(auto volume, OpenForeignVolume(files, source));
  BlockedVolumeSettings settings;
  settings.BlockSize = 16;
  settings.NumberOfStores = 3;
  ISOSURFACE_ASSIGN_OR_RETURN(auto record,
    DescribeSource(files, OpenForeignVolume, path, source, {}, volume.Grid, volume.Arrays));
  record.AbsolutePath = "/nowhere";
  settings.InPlace = record;
  return BlockedVolumeWriter(ranks)
    .Write(path, volume.Grid, volume.Arrays, *volume.Source, settings)
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

/// A volume that is larger than a sample, opened as a window does.
class FirstContact : public testing::Test
{
protected:
  explicit FirstContact(bool isStream = false, bool isPlaced = false)
  {
    if (isPlaced)
    {
      this->SetGrid({ 0.5, 0.75, 2 }, { -300, 5, 1000 });
    }
    OnFirstRank([&] { WriteSource(this->Image, this->Folder.GetPath("scan.mhd"), isStream); });
    this->Reader->SetSourceName(this->Folder.GetPath("scan.mhd").c_str());
    this->Reader->AllowCoarse(1);
    this->Update();
    this->Reader->AllowCoarse(0);
  }

  vtkPolyData* Update()
  {
    this->Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    return this->Contour->GetOutput();
  }
  std::uint64_t CountTriangles()
  {
    return SumOverRanks(static_cast<std::uint64_t>(this->Contour->GetOutput()->GetNumberOfPolys()));
  }
  RefinementStage GetIndexStage()
  {
    return Refinement::FromValues(this->Reader->GetRefinement()).Stage;
  }
  RefinementStage GetSurfaceStage()
  {
    return Refinement::FromValues(this->Contour->GetRefinement()).Stage;
  }
  /// Lets the index grow to its end; the stage then.
  RefinementStage Advance()
  {
    do
    {
      this->Reader->AdvanceIndex(5);
    } while (this->GetIndexStage() == RefinementStage::Working);
    return this->GetIndexStage();
  }

  void ExpectExactSurfaceOfAllThatIsIndexed()
  {
    this->Contour->Modified();
    ShowByHand(this->Contour);
    EXPECT_EQ(this->Advance(), RefinementStage::Ready);
    const auto prepare = [&]
    {
      this->Contour->PrepareRefinement(1000);
      return this->GetSurfaceStage();
    };
    EXPECT_EQ(prepare(), RefinementStage::Growing);
    auto stage = RefinementStage::Growing;
    for (int tries = 0; stage == RefinementStage::Growing && tries < 100;
         ++tries) // ranks that share a core take long
    {
      stage = prepare();
    }
    EXPECT_EQ(stage, RefinementStage::Ready);
    this->Contour->Refine();
    ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
    EXPECT_EQ(prepare(), RefinementStage::None) << "all is exact";
    EXPECT_EQ(this->GetIndexStage(), RefinementStage::Ready) << "nobody has taken the index";
  }

  /// Places the file and the image alike.
  void SetGrid(const std::array<double, 3>& spacing, const std::array<double, 3>& origin)
  {
    this->Reader->SetSpacing(spacing[0], spacing[1], spacing[2]);
    this->Reader->SetOrigin(origin[0], origin[1], origin[2]);
    this->Image->SetSpacing(spacing.data());
    this->Image->SetOrigin(origin.data());
  }

  void ExpectSurfaceWithinTheImage()
  {
    this->Contour->AllowCoarse(1);
    this->Reader->AllowCoarse(1);
    vtkPolyData* const mine = this->Update();
    this->Reader->AllowCoarse(0);
    this->Contour->AllowCoarse(0);
    EXPECT_GT(this->CountTriangles(), 0u);
    const vtkBoundingBox box(this->Image->GetBounds());
    EXPECT_TRUE(mine->GetNumberOfPoints() == 0 || box.Contains(vtkBoundingBox(mine->GetBounds())));
  }

  /// In one grid after the other, of which the second is set while the index grows.
  void ExpectSurfacesInTheGridsThatAreSet()
  {
    this->SetGrid({ 2, 0.5, 0.75 }, { -3000, 5, 0 });
    this->Reader->SetLengthUnit("um");
    this->ExpectSurfaceWithinTheImage();
    this->Advance();
    this->Reader->TakeIndex();
    ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
    const std::string index = this->Folder.GetPath("scan.mhd.bvol");
    const auto written = std::filesystem::last_write_time(index);
    this->SetGrid({ 3, 1, 0.25 }, { 0, -5, 0 });
    ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
    vtkDataObject* const output = this->Contour->GetOutputDataObject(0);
    auto* const unit =
      vtkStringArray::SafeDownCast(output->GetFieldData()->GetAbstractArray("PhysicalSizeUnit"));
    EXPECT_EQ(unit ? unit->GetValue(0) : "", "um");
    this->SetGrid({ 1, 1, 1 }, { 0, 0, 0 });
    this->Reader->RemoveSpacing();
    this->Reader->RemoveOrigin();
    ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
    EXPECT_EQ(std::filesystem::last_write_time(index), written) << "nothing is indexed anew";
  }

  void ExpectGrowingSurface()
  {
    this->Contour->Modified();
    this->Contour->AllowCoarse(1);
    this->Update();
    this->Contour->AllowCoarse(0);
    const auto prepare = [&]
    {
      this->Contour->PrepareRefinement(5);
      if (this->GetSurfaceStage() == RefinementStage::Ready)
      {
        this->Contour->Refine();
        this->Update();
      }
    };
    do
    {
      this->Reader->AdvanceIndex(5);
      prepare();
    } while (this->GetIndexStage() == RefinementStage::Working);
    for (int tries = 0; this->GetSurfaceStage() != RefinementStage::None && tries < 10000; ++tries)
    {
      // A surface that has grown rests for twice the time that it took.
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      prepare();
    }
    ExpectSurfaceOf(this->Contour->GetOutput(), this->Image, Isovalue);
    EXPECT_EQ(this->GetIndexStage(), RefinementStage::Ready) << "nobody has taken the index";
  }

  static constexpr double Isovalue = 60.5;
  const SharedFolder Folder{ "FirstContact" };
  const vtkSmartPointer<vtkImageData> Image =
    MakeClosedVolume({ 0, 160, 0, 130, 0, 110 }, VTK_UNSIGNED_CHAR);
  const vtkNew<vtkInPlaceVolumeReader> Reader;
  const vtkSmartPointer<vtkStabbingContour> Contour = MakeContour(this->Reader, Isovalue);
  const ExpectNoErrors ReaderErrors{ this->Reader };
  const ExpectNoErrors ContourErrors{ this->Contour };
};

TEST_F(FirstContact, ShowsASampleUntilAllRanksHaveTheIndex)
{
  const std::uint64_t coarse = this->CountTriangles();
  EXPECT_GT(coarse, 0u);
  EXPECT_STREQ(this->Reader->GetShownText(), "one of 2 x 1 x 1 samples");
  EXPECT_EQ(this->GetIndexStage(), RefinementStage::Working);
  EXPECT_EQ(this->Advance(), RefinementStage::Ready);
  this->Update();
  EXPECT_EQ(this->CountTriangles(), coarse) << "nobody has taken the index";
  this->Reader->TakeIndex();
  ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
  EXPECT_GT(this->CountTriangles(), coarse);
  EXPECT_EQ(this->GetIndexStage(), RefinementStage::None);
}

/// A file that can be read anywhere, or, as a stream, in order alone.
class FirstContactWithFile
  : public FirstContact
  , public testing::WithParamInterface<bool>
{
protected:
  explicit FirstContactWithFile(bool isPlaced = false)
    : FirstContact(GetParam(), isPlaced)
  {
  }
};

/// The same in a grid that is not the file's.
class FirstContactInAnotherGrid : public FirstContactWithFile
{
protected:
  FirstContactInAnotherGrid()
    : FirstContactWithFile(true)
  {
  }
};

TEST_P(FirstContactWithFile, IsExactWhereItIsIndexed)
{
  this->ExpectExactSurfaceOfAllThatIsIndexed();
}

TEST_P(FirstContactWithFile, GrowsWhileItIsIndexed)
{
  this->ExpectGrowingSurface();
}

TEST_P(FirstContactInAnotherGrid, GrowsWhileTheFileIsIndexed)
{
  this->ExpectGrowingSurface();
}

TEST_P(FirstContactInAnotherGrid, FollowsWhenAnotherOneIsSet)
{
  this->ExpectSurfacesInTheGridsThatAreSet();
}

INSTANTIATE_TEST_SUITE_P(Streams, FirstContactWithFile, testing::Bool());
INSTANTIATE_TEST_SUITE_P(Streams, FirstContactInAnotherGrid, testing::Bool());

TEST_F(FirstContact, TheSurfaceGetsNoCoarserWhenTheIndexIsTaken)
{
  const auto update = [&]
  {
    this->Contour->AllowCoarse(1);
    this->Update();
    this->Contour->AllowCoarse(0);
    return this->CountTriangles();
  };
  const auto refine = [&](std::uint64_t least)
  {
    while (!this->Contour->GetFinal())
    {
      this->Contour->Refine();
      const std::uint64_t triangles = update();
      EXPECT_GE(triangles, least);
      least = triangles;
    }
    return least;
  };
  this->Contour->Modified();
  const std::uint64_t coarse = refine(update());
  EXPECT_EQ(this->Advance(), RefinementStage::Ready);
  this->Reader->TakeIndex();
  EXPECT_EQ(update(), coarse) << "the sample stays until there is a finer surface";
  EXPECT_EQ(update(), coarse);
  EXPECT_FALSE(this->Contour->GetFinal());
  refine(coarse + 1);
  ExpectSurfaceOf(this->Contour->GetOutput(), this->Image, Isovalue);

  this->Contour->SetValue(0, Isovalue + 20);
  EXPECT_LT(update(), coarse) << "of another isovalue it does not stay";
}

TEST_F(FirstContact, TheSurfaceOfASampleDoesNotStayInAnotherGrid)
{
  this->Contour->Modified();
  ShowByHand(this->Contour);
  EXPECT_EQ(this->Advance(), RefinementStage::Ready);
  this->SetGrid({ 0.5, 0.5, 0.5 }, { 1000, 0, 0 });
  this->ExpectSurfaceWithinTheImage();
}

TEST(InPlaceOnRanks, AWrongGridIsOneErrorOfAllRanksAndNothingIsWritten)
{
  const SharedFolder folder("WrongGrid");
  const std::string source = folder.GetPath("scan.mhd");
  OnFirstRank([&] { WriteSource(MakeNoisyImage(), source); });
  vtkNew<vtkInPlaceVolumeReader> reader;
  reader->SetSourceName(source.c_str());
  const auto contour = MakeContour(reader, InPlaceIsovalue);
  const auto expect = [&](const std::string& words)
  {
    const ErrorCounter errors(reader);
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    ExpectOneError(errors, { words });
    EXPECT_EQ(contour->GetOutput()->GetNumberOfPolys(), 0);
  };
  reader->SetSpacing(1, 0, 1);
  expect("scan.mhd: Spacing is set to 1, 0, 1: distances are finite and above 0");
  reader->SetSpacing(1, -2, 1);
  expect("Spacing is set to 1, -2, 1");
  reader->SetSpacing(1, std::nan(""), 1);
  expect("Spacing is set to 1, nan, 1");
  reader->RemoveSpacing();
  reader->AddSpacing(2);
  reader->AddSpacing(2);
  expect("Spacing has 2 numbers in place of 3");
  reader->RemoveSpacing();
  reader->SetOrigin(0, 0, std::numeric_limits<double>::infinity());
  expect("Origin is set to 0, 0, inf");
  reader->RemoveOrigin();
  reader->SetLengthUnit("ell");
  expect("LengthUnit: \"ell\" is no unit of length");
  EXPECT_FALSE(std::filesystem::exists(source + ".bvol"));
  reader->SetLengthUnit(nullptr);
  const int last = GetNumberOfRanks() - 1;
  if (last > 0)
  {
    reader->SetSpacing(1, 1, GetRank() == last ? 2 : 1);
    expect("are not the same on all ranks");
  }
  reader->RemoveSpacing();
  const ExpectNoErrors errors(reader);
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectSurfaceOf(contour->GetOutput(), MakeNoisyImage(), InPlaceIsovalue);
}

TEST_F(FirstContact, TheSurfaceOfASampleDoesNotStayForAnotherFile)
{
  const std::string other = this->Folder.GetPath("other.mhd");
  const auto image = MakeClosedVolume({ 0, 120, 0, 90, 0, 80 }, VTK_UNSIGNED_CHAR);
  OnFirstRank([&] { WriteSource(image, other); });
  vtkNew<vtkInPlaceVolumeReader> indexing;
  indexing->SetSourceName(other.c_str());
  indexing->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  const auto show = [&]
  {
    this->Contour->AllowCoarse(1);
    this->Update();
    this->Contour->AllowCoarse(0);
    return this->CountTriangles();
  };
  this->Contour->Modified();
  show();
  while (!this->Contour->GetFinal())
  {
    this->Contour->Refine();
    show();
  }
  const std::uint64_t sampled = this->CountTriangles();
  this->Reader->SetSourceName(other.c_str());
  EXPECT_LT(show(), sampled) << "a coarse surface of the other file";
  this->Contour->Modified();
  ExpectSurfaceOf(this->Update(), image, Isovalue);
}

TEST_F(FirstContact, TheOutputOfTheIndexIsReadBeforeItIsTaken)
{
  const auto update = [&]() -> vtkDataSet*
  {
    this->Reader->AllowCoarse(1);
    this->Reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    this->Reader->AllowCoarse(0);
    auto* output = vtkPartitionedDataSet::SafeDownCast(this->Reader->GetOutputDataObject(0));
    return output->GetPartition(0);
  };
  this->Reader->Modified();
  update();
  EXPECT_STREQ(this->Reader->GetShownText(), "one of 2 x 1 x 1 samples");
  EXPECT_EQ(this->Advance(), RefinementStage::Ready);
  // Nothing can be read any more.
  isosurface::BlockCache::GetProcessCache()->Clear();
  GetRanks()->Barrier();
  OnFirstRank([&] { std::filesystem::remove(this->Folder.GetPath("scan.mhd.raw")); });
  this->Reader->TakeIndex();
  vtkDataSet* const output = update();
  EXPECT_EQ(std::string(this->Reader->GetShownText()).substr(0, 9), "all of it");
  vtkPointData* const whole = this->Image->GetPointData();
  const vtkIdType points = output ? output->GetNumberOfPoints() : 0; // none beyond the last block
  int different = 0;
  for (vtkIdType point = 0; point < points; ++point)
  {
    const vtkIdType same = this->Image->FindPoint(output->GetPoint(point));
    const double value = output->GetPointData()->GetScalars()->GetTuple1(point);
    different += value == whole->GetScalars()->GetTuple1(same) ? 0 : 1;
  }
  EXPECT_GE(SumOverRanks(static_cast<std::uint64_t>(points)),
    static_cast<std::uint64_t>(this->Image->GetNumberOfPoints()));
  EXPECT_EQ(different, 0);
}

TEST_F(FirstContact, ASliceSaysThatItIsOfASampleUntilItIsOfTheIndex)
{
  vtkNew<vtkVolumeSlice> slice;
  slice->SetInputConnection(this->Reader->GetOutputPort());
  slice->SetOrigin(this->Image->GetCenter());
  const ExpectNoErrors errors(slice);
  const auto describe = [&]
  {
    this->Reader->AllowCoarse(1); // as a window does before it updates
    slice->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    this->Reader->AllowCoarse(0);
    return std::string(slice->GetShownText());
  };
  EXPECT_EQ(describe(), "81 x 131 points, one of 2 x 1 x 1 samples");
  EXPECT_EQ(this->Advance(), RefinementStage::Ready);
  this->Reader->TakeIndex();
  EXPECT_EQ(describe(), "161 x 131 points, full resolution");
}

TEST(InPlaceOnRanks, AFileThatCannotBeIndexedIsToldOnceBehindASlice)
{
  const SharedFolder folder("NoIndex");
  const std::string path = folder.GetPath("scan_40x30x20_uint16.raw");
  OnFirstRank([&] { std::ofstream(path) << "too short"; });
  vtkNew<vtkInPlaceVolumeReader> reader;
  reader->SetController(GetRanks());
  reader->SetSourceName(path.c_str());
  vtkNew<vtkVolumeSlice> slice;
  slice->SetController(GetRanks());
  slice->SetInputConnection(reader->GetOutputPort());
  const ErrorCounter ofReader(reader);
  const ErrorCounter ofSlice(slice);
  slice->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectOneError(ofReader, { path, "truncated: has 9 bytes, and its name says 48000" });
  EXPECT_EQ(ofSlice.Messages, std::vector<std::string>());
  EXPECT_EQ(slice->GetOutput()->GetNumberOfPoints(), 0);
}

TEST(InPlaceOnRanks, AFileThatIsRewrittenWhileItIsOpenIsToldByAll)
{
  const SharedFolder folder("Rewritten");
  const std::string source = folder.GetPath("scan.mhd");
  OnFirstRank([&] { WriteSource(MakeNoisyImage(), source); });
  EXPECT_TRUE(IndexInPlace(source, folder.GetPath("volume.bvol")).IsOk());
  vtkNew<vtkBlockedVolumeReader> reader;
  reader->SetController(GetRanks());
  reader->SetFileName(folder.GetPath("volume.bvol").c_str());
  vtkNew<vtkVolumeSlice> slice;
  slice->SetOrigin(0, 0, 20);
  vtkNew<vtkVolumeRegion> region;
  region->SetLength(20, 20, 20);
  vtkNew<vtkVolumeProbe> probe;
  vtkNew<vtkPolyData> points;
  points->SetPoints(vtkNew<vtkPoints>());
  points->GetPoints()->InsertNextPoint(3, 4, 5);
  probe->SetSourceData(points);
  const auto update = [&](auto* filter)
  {
    filter->SetController(GetRanks());
    filter->SetInputConnection(reader->GetOutputPort());
    filter->Modified();
    filter->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  };
  const auto updateAll = [&](const std::vector<std::string>& words)
  {
    const auto expect = [&](auto* filter)
    {
      const ErrorCounter errors(filter);
      update(filter);
      if (words.empty())
      {
        EXPECT_EQ(errors.Messages, std::vector<std::string>());
      }
      else
      {
        ExpectOneError(errors, words);
      }
    };
    expect(slice.Get());
    expect(region.Get());
    expect(probe.Get());
  };
  updateAll({});
  OnFirstRank([&] { std::filesystem::last_write_time(source + ".raw", {}); });
  updateAll({ "scan.mhd", "was changed since", "index it again" });
}

TEST_F(FirstContact, WaitsForTheIndexOnceItMayNotBeCoarse)
{
  this->Reader->SetMemoryLimit(255);
  ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
}

TEST_F(FirstContact, CanBeStoppedAndBegunAnew)
{
  this->Reader->StopIndex();
  EXPECT_EQ(this->Advance(), RefinementStage::Failed);
  this->Reader->SetMemoryLimit(255);
  ExpectSurfaceOf(this->Update(), this->Image, Isovalue);
}

TEST_F(FirstContact, LeavesNothingThatKeepsTheNextReaderFromIndexing)
{
  this->Reader->AdvanceIndex(1);
  OnFirstRank([&] { WriteSource(MakeNoisyImage(), this->Folder.GetPath("other.mhd")); });
  this->Reader->SetSourceName(this->Folder.GetPath("other.mhd").c_str());
  this->Reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  vtkNew<vtkInPlaceVolumeReader> next;
  next->SetSourceName(this->Folder.GetPath("scan.mhd").c_str());
  const auto contour = MakeContour(next, Isovalue);
  const ExpectNoErrors errors(next);
  contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectSurfaceOf(contour->GetOutput(), this->Image, Isovalue);
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
