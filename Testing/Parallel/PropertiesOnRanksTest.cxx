// SPDX-License-Identifier: BSD-3-Clause
// Ranks that have different properties, or ask for different times: one error on all of them in
// place of a mixed surface, nobody waits, and all is well again once they have the same.
#include "ParallelVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkDistributeIsosurface.h"
#include "vtkEdgeIndexReader.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkExecutive.h"
#include "vtkInformation.h"
#include "vtkMultiProcessController.h"
#include "vtkStabbingContour.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <functional>
#include <memory>
#include <ostream>

using namespace isosurface;

namespace
{

constexpr double AgreedIsovalue = 120.0;

/// Of noise, with a second array.
vtkSmartPointer<vtkImageData> MakeTwoArrays(unsigned int seed = 3)
{
  auto image = MakeImage({ 0, 40, 0, 36, 0, 44 }, VTK_UNSIGNED_CHAR, MakeNoise(250, seed));
  AddHeights(image);
  return image;
}

bool IsOdd()
{
  return GetRank() == GetNumberOfRanks() - 1 && GetNumberOfRanks() > 1;
}

/// The errors of some algorithms.
class Listener
{
public:
  void Add(vtkAlgorithm* algorithm)
  {
    this->Counters.push_back(std::make_unique<ErrorCounter>(algorithm));
  }
  /// What was told since the last call.
  std::vector<std::string> Take()
  {
    std::vector<std::string> all;
    for (const auto& counter : this->Counters)
    {
      all.insert(all.end(), counter->Messages.begin(), counter->Messages.end());
      counter->Messages.clear();
    }
    return all;
  }

private:
  std::vector<std::unique_ptr<ErrorCounter>> Counters;
};

/// Each rank has been told once, if there are several, that they differ.
void ExpectDifference(const std::vector<std::string>& messages, const std::string& kind)
{
  if (GetNumberOfRanks() == 1)
  {
    EXPECT_EQ(messages, std::vector<std::string>());
    return;
  }
  EXPECT_TRUE(messages.size() == 1 && messages[0].find(kind) != std::string::npos &&
    messages[0].find("differs from rank 0") != std::string::npos)
    << testing::PrintToString(messages);
}

/// Something of a contour that may differ.
struct ContourProperty
{
  std::string Name;
  std::function<void(vtkStabbingContour*)> Set;
};

std::ostream& operator<<(std::ostream& stream, const ContourProperty& property)
{
  return stream << property.Name;
}

std::vector<ContourProperty> MakeContourProperties()
{
  using Contour = vtkStabbingContour;
  return {
    { "ComputeNormals", [](Contour* contour) { contour->ComputeNormalsOff(); } },
    { "ComputeScalars", [](Contour* contour) { contour->ComputeScalarsOff(); } },
    { "OutputPointsPrecision", [](Contour* contour) { contour->SetOutputPointsPrecision(1); } },
    { "GenerateTriangles", [](Contour* contour) { contour->GenerateTrianglesOff(); } },
    { "Isovalues", [](Contour* contour) { contour->SetValue(1, AgreedIsovalue + 9); } },
    { "Level", [](Contour* contour) { contour->SetLevel(1); } },
    { "TimeBudget", [](Contour* contour) { contour->SetTimeBudget(100); } },
    { "MaximumTriangles", [](Contour* contour) { contour->SetMaximumTriangles(1000000); } },
    { "Progressive", [](Contour* contour) { contour->ProgressiveOn(); } },
    { "CloseBoundary", [](Contour* contour) { contour->CloseBoundaryOn(); } },
    { "Inside", [](Contour* contour) { contour->SetInside(Contour::BELOW); } },
    { "SkipNotANumber", [](Contour* contour) { contour->SkipNotANumberOn(); } },
    { "DynamicBalance", [](Contour* contour) { contour->DynamicBalanceOn(); } },
    { "UseRegion", [](Contour* contour) { contour->UseRegionOn(); } },
    { "DropDegenerateTriangles", [](Contour* contour) { contour->DropDegenerateTrianglesOn(); } },
    { "IslandSize", [](Contour* contour) { contour->SetIslandSize(Contour::AREA); } },
    { "MinimumIslandSize", [](Contour* contour) { contour->SetMinimumIslandSize(9); } },
    { "MaximumIslands", [](Contour* contour) { contour->SetMaximumIslands(9); } },
    { "IslandPoint", [](Contour* contour) { contour->SetIslandPoint(9, 9, 9); } },
    { "UseIslandPoint", [](Contour* contour) { contour->UseIslandPointOn(); } },
    { "ComputeIslandIds", [](Contour* contour) { contour->ComputeIslandIdsOn(); } },
    { "AllowCoarse", [](Contour* contour) { contour->AllowCoarse(1); } },
    { "InterpolatedArray", [](Contour* contour) { contour->AddInterpolatedArray("height"); } },
    { "Array", [](Contour* contour) { SelectPoints(contour, "height"); } },
  };
}

class ContourPropertiesOnRanks : public testing::TestWithParam<ContourProperty>
{
protected:
  static void SetUpTestSuite()
  {
    Image = MakeTwoArrays();
    Volume = std::make_unique<SharedVolume>(
      "PropertiesOnRanks", Image, VolumeSettings{ 16, 3 }, PieceSource::EVERYWHERE);
  }
  static void TearDownTestSuite()
  {
    Volume.reset();
    Image = nullptr;
  }

  /// On one rank alone, then on all. Collective.
  static void ExpectErrorUntilAllHaveIt(vtkAlgorithm* source, vtkStabbingContour* contour)
  {
    contour->SetInputConnection(source->GetOutputPort());
    SelectPoints(contour, "density");
    contour->SetValue(0, AgreedIsovalue);
    Listener listener;
    listener.Add(source);
    listener.Add(contour);
    if (IsOdd())
    {
      GetParam().Set(contour);
    }
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    ExpectDifference(listener.Take(), "properties of the contour filter");
    GetParam().Set(contour);
    contour->Modified();
    contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(listener.Take(), std::vector<std::string>());
  }

  inline static vtkSmartPointer<vtkImageData> Image;
  inline static std::unique_ptr<SharedVolume> Volume;
};

TEST_P(ContourPropertiesOnRanks, OfAContourOfImagesAreAgreedOn)
{
  const auto source = MakeSource(Image, PieceSource::EVERYWHERE);
  vtkNew<vtkStabbingContour> contour;
  ExpectErrorUntilAllHaveIt(source, contour);
}

TEST_P(ContourPropertiesOnRanks, OfAContourOfAVolumeAreAgreedOn)
{
  const ContourPipeline pipeline(Volume->Path);
  ExpectErrorUntilAllHaveIt(pipeline.Reader, pipeline.Contour);
}

INSTANTIATE_TEST_SUITE_P(Properties, ContourPropertiesOnRanks,
  testing::ValuesIn(MakeContourProperties()), [](const auto& one) { return one.param.Name; });

TEST(PropertiesOnRanks, TimesOfImagesAreAgreedOn)
{
  const auto source = MakeSource(MakeTwoArrays());
  const auto contour = MakeContour(source, AgreedIsovalue);
  Listener listener;
  listener.Add(contour);
  contour->UpdateTimeStep(IsOdd() ? 2 : 1, GetRank(), GetNumberOfRanks());
  ExpectDifference(listener.Take(), "time steps");
  contour->Modified();
  contour->UpdateTimeStep(2, GetRank(), GetNumberOfRanks());
  EXPECT_EQ(listener.Take(), std::vector<std::string>());
}

TEST(PropertiesOnRanks, OfADistributedContourAreAgreedOn)
{
  const auto source = MakeSource(MakeTwoArrays());
  const auto contour = MakeContour(source, AgreedIsovalue);
  contour->SetComputeNormals(IsOdd() ? 0 : 1);
  vtkNew<vtkDistributeIsosurface> distribute;
  distribute->SetInputConnection(contour->GetOutputPort());
  Listener listener;
  listener.Add(distribute);
  distribute->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  ExpectDifference(listener.Take(), "properties of the contour filter");
}

TEST(PropertiesOnRanks, OfAnEdgeIndexWriterAreAgreedOn)
{
  const SharedFolder folder("PropertiesOfEdgeIndexWriter");
  const std::string path = folder.GetPath("surface.eix");
  const auto source = MakeSource(MakeTwoArrays(), PieceSource::EVERYWHERE);
  vtkNew<vtkStabbingContour> contour;
  contour->SetInputConnection(source->GetOutputPort());
  SelectPoints(contour, "density");
  contour->AddInterpolatedArray("height");
  contour->SetValue(0, AgreedIsovalue);
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(contour->GetOutputPort());
  Listener listener;
  listener.Add(writer);
  writer->SetFileName((IsOdd() ? folder.GetPath("other.eix") : path).c_str());
  writer->Write();
  ExpectDifference(listener.Take(), "file name");
  writer->SetFileName(path.c_str());
  writer->SetWriteNormals(IsOdd());
  writer->Write();
  ExpectDifference(listener.Take(), "properties of the contour filter");
  writer->SetWriteNormals(false);
  writer->SetWriteArrays(!IsOdd());
  writer->Write();
  ExpectDifference(listener.Take(), "properties of the contour filter");
  writer->SetWriteArrays(true);
  EXPECT_EQ(writer->Write(), 1);
  EXPECT_EQ(listener.Take(), std::vector<std::string>());
}

TEST(PropertiesOnRanks, OfAnEdgeIndexReaderAreAgreedOn)
{
  const SharedFolder folder("PropertiesOfEdgeIndexReader");
  const std::string path = folder.GetPath("surface.eix");
  const auto source = MakeSource(MakeTwoArrays());
  const auto contour = MakeContour(source, AgreedIsovalue);
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(contour->GetOutputPort());
  writer->SetFileName(path.c_str());
  EXPECT_EQ(writer->Write(), 1);
  using Reader = vtkEdgeIndexReader;
  const std::function<void(Reader*, bool)> properties[] = {
    [](Reader* reader, bool on) { reader->SetPreview(on); },
    [](Reader* reader, bool on) { reader->SetUseRegion(on); },
    [](Reader* reader, bool on) { reader->SetRegionPosition(on ? 5 : 0, 0, 0); },
    [](Reader* reader, bool on) { reader->SetRegionLength(on ? 9 : 20, 20, 20); },
    [](Reader* reader, bool on) { reader->SetComputeNormals(on); },
    [](Reader* reader, bool on) { reader->SetComputeScalars(on); },
  };
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  Listener listener;
  listener.Add(reader);
  for (const auto& set : properties)
  {
    set(reader, IsOdd());
    reader->Modified();
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    ExpectDifference(listener.Take(), "properties of the reader");
    set(reader, true);
    reader->Modified();
    reader->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(listener.Take(), std::vector<std::string>());
  }
}

TEST(PropertiesOnRanks, OfASpectrumAreAgreedOn)
{
  const auto source = MakeSource(MakeTwoArrays(), PieceSource::EVERYWHERE);
  vtkNew<vtkContourSpectrum> spectrum;
  spectrum->SetInputConnection(source->GetOutputPort());
  Listener listener;
  listener.Add(spectrum);
  const auto choose = [&](bool other)
  {
    SelectPoints(spectrum, other ? "height" : "density");
    spectrum->Modified();
    spectrum->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  };
  choose(IsOdd());
  ExpectDifference(listener.Take(), "properties of the spectrum filter");
  choose(false);
  EXPECT_EQ(listener.Take(), std::vector<std::string>());
  spectrum->SetComponent(IsOdd() ? 1 : 0);
  choose(false);
  ExpectDifference(listener.Take(), "properties of the spectrum filter");
}

/// A volume of two arrays in two time steps, and a reader.
class VolumePropertiesOnRanks : public testing::Test
{
protected:
  VolumePropertiesOnRanks()
    : Folder(testing::UnitTest::GetInstance()->current_test_info()->name())
    , Path(this->Folder.GetPath("volume.bvol"))
  {
    this->WriteSteps(this->Path, { 0, 40, 0, 36, 0, 44 });
    this->Reader->SetFileName(this->Path.c_str());
    this->Listened.Add(this->Reader);
  }

  void WriteSteps(const std::string& path, const Extent& extent)
  {
    vtkNew<vtkBlockedVolumeWriter> writer;
    writer->SetFileName(path.c_str());
    writer->SetBlockSize(16);
    writer->SetNumberOfStores(3);
    vtkNew<PieceSource> source;
    source->SetLayout(PieceSource::EVERYWHERE);
    writer->SetInputConnection(source->GetOutputPort());
    for (const unsigned int step : { 1U, 2U })
    {
      const double time = step;
      const auto whole = MakeTwoArrays(step);
      vtkSmartPointer<vtkImageData> image = whole;
      if (extent[1] != 40)
      {
        image = CutImage(whole, extent);
      }
      image->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
      source->SetImage(image);
      writer->SetAppendTimeStep(step > 1);
      writer->UpdateInformation();
      writer->GetInputInformation()->Set(
        vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), time);
      writer->Modified();
      EXPECT_EQ(writer->Write(), 1);
    }
  }

  void Update(double time)
  {
    this->Reader->Modified();
    this->Reader->UpdateTimeStep(time, GetRank(), GetNumberOfRanks());
  }

  const SharedFolder Folder;
  const std::string Path;
  vtkNew<vtkBlockedVolumeReader> Reader;
  Listener Listened;
};

TEST_F(VolumePropertiesOnRanks, AreAgreedOn)
{
  this->Update(IsOdd() ? 2 : 1);
  ExpectDifference(this->Listened.Take(), "time steps");
  this->Update(2);
  EXPECT_EQ(this->Listened.Take(), std::vector<std::string>());
  this->Reader->SetMemoryLimit(IsOdd() ? 1 : 256);
  this->Update(2);
  ExpectDifference(this->Listened.Take(), "properties of the reader");
  this->Reader->SetMemoryLimit(256);
  this->Reader->SetPointArrayStatus("height", IsOdd() ? 0 : 1);
  this->Update(2);
  ExpectDifference(this->Listened.Take(), "properties of the reader");
  this->Reader->SetPointArrayStatus("height", 0);
  this->Update(2);
  EXPECT_EQ(this->Listened.Take(), std::vector<std::string>());
}

TEST_F(VolumePropertiesOnRanks, LocalStoresAreAgreedOn)
{
  for (const int balanced : { 0, 1 })
  {
    ContourPipeline pipeline(this->Path);
    pipeline.Contour->SetValue(0, AgreedIsovalue);
    pipeline.Contour->SetDynamicBalance(balanced);
    Listener listener;
    listener.Add(pipeline.Reader);
    listener.Add(pipeline.Contour);
    pipeline.Reader->SetLocalStores(IsOdd());
    pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    ExpectDifference(listener.Take(), "LocalStores");
    pipeline.Reader->SetLocalStores(true);
    pipeline.Reader->Modified();
    pipeline.Contour->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
    EXPECT_EQ(listener.Take(), std::vector<std::string>());
  }
}

// The last rank has no piece of the only block, and reads it all the same.
TEST_F(VolumePropertiesOnRanks, TimesThatAWriterAsksForAreAgreedOn)
{
  const std::string path = this->Folder.GetPath("small.bvol");
  this->WriteSteps(path, { 0, 9, 0, 9, 0, 9 });
  const auto reader = MakeReader(path);
  vtkNew<vtkBlockedVolumeWriter> writer;
  writer->SetInputConnection(reader->GetOutputPort());
  writer->SetFileName(this->Folder.GetPath("copy.bvol").c_str());
  writer->SetBlockSize(16);
  Listener listener;
  listener.Add(reader);
  listener.Add(writer);
  writer->UpdateInformation();
  writer->GetInputInformation()->Set(
    vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP(), IsOdd() ? 2.0 : 1.0);
  writer->Write();
  ExpectDifference(listener.Take(), "time steps");
}

} // namespace
