// SPDX-License-Identifier: BSD-3-Clause
// One rank of several that runs out of memory in a filter, a reader or a writer, at each of its larger
// allocations: all ranks tell of one error, none waits, and the next update makes what it should.
#include "SampledVolumes.h"

#include "vtkBlockedVolumeReader.h"
#include "vtkContourSpectrum.h"
#include "vtkDistributeIsosurface.h"
#include "vtkEdgeIndexReader.h"
#include "vtkEdgeIndexWriter.h"
#include "vtkImageData.h"
#include "vtkMultiProcessController.h"
#include "vtkPolyData.h"
#include "vtkStabbingContour.h"
#include "vtkVolumeProbe.h"
#include "vtkVolumeRegion.h"
#include "vtkVolumeSlice.h"

#include "Fixtures/LongTests.h"
#include "Fixtures/MemoryShortage.h"

#include <algorithm>
#include <functional>
#include <ostream>
#include <utility>

using namespace isosurface;

namespace
{

constexpr double FilterIsovalue = 120;

/// A surface, one of which half is dust, with a second array.
vtkSmartPointer<vtkImageData> MakeFilteredImage()
{
  auto image = MakeImage({ 0, 47, 0, 39, 0, 43 }, VTK_UNSIGNED_CHAR,
    [noise = MakeNoise(250, 5)](int i, int j, int k) mutable
    {
      const double value = noise(i, j, k);
      return k > 33 ? value : 2.0 * i + 3.0 * j + k;
    });
  AddHeights(image);
  return image;
}

/// What a deed is done with.
struct Inputs
{
  SharedFolder Folder{ "FilterMemory" };
  vtkSmartPointer<vtkImageData> Image = MakeFilteredImage();
  std::string Volume = this->Folder.GetPath("volume.bvol");
  std::string Surface = this->Folder.GetPath("surface.eix");
  vtkSmartPointer<PieceSource> Source = MakeSource(this->Image, PieceSource::OVERLAPPING);
  vtkSmartPointer<vtkBlockedVolumeReader> Reader = OpenOnRanks(this->Volume);

  Inputs()
  {
    WriteFromPieces(this->Image, PieceSource::EVERYWHERE, this->Volume, { 16, 3 });
    this->Reader->SetCacheSize(0); // what is cached takes no memory
  }

  vtkSmartPointer<vtkStabbingContour> ContourOf(vtkAlgorithm* source) const
  {
    auto contour = MakeContour(source, FilterIsovalue);
    SelectPoints(contour, "density");
    if (source == this->Reader) // pieces of the image have not got it
    {
      contour->AddInterpolatedArray("height");
    }
    return contour;
  }
  vtkSmartPointer<vtkDistributeIsosurface> DistributionOf(vtkAlgorithm* source) const
  {
    auto distribute = vtkSmartPointer<vtkDistributeIsosurface>::New();
    distribute->SetInputConnection(this->ContourOf(source)->GetOutputPort());
    distribute->SetRoundBytes(2000);
    return distribute;
  }
  template <typename Filter>
  vtkSmartPointer<Filter> OfReader() const
  {
    auto filter = vtkSmartPointer<Filter>::New();
    filter->SetInputConnection(this->Reader->GetOutputPort());
    return filter;
  }
};

/// What is done, and an algorithm that does it.
struct FilterDeed
{
  std::string Name;
  std::function<vtkSmartPointer<vtkAlgorithm>(const Inputs&)> Make;
};

std::ostream& operator<<(std::ostream& stream, const FilterDeed& deed)
{
  return stream << deed.Name;
}

vtkSmartPointer<vtkAlgorithm> FindIslandsOf(vtkSmartPointer<vtkStabbingContour> contour)
{
  contour->SetMaximumIslands(20);
  contour->SetIslandPoint(20, 20, 20);
  contour->UseIslandPointOn();
  contour->ComputeIslandIdsOn();
  return contour;
}

vtkSmartPointer<vtkAlgorithm> MakeEdgeIndexReader(const Inputs& inputs)
{
  vtkNew<vtkEdgeIndexWriter> writer;
  writer->SetInputConnection(inputs.ContourOf(inputs.Reader)->GetOutputPort());
  writer->SetFileName(inputs.Surface.c_str());
  EXPECT_EQ(writer->Write(), 1);
  auto reader = vtkSmartPointer<vtkEdgeIndexReader>::New();
  reader->SetFileName(inputs.Surface.c_str());
  return reader;
}

vtkSmartPointer<vtkAlgorithm> MakeIsolines(const Inputs& inputs)
{
  auto slice = inputs.OfReader<vtkVolumeSlice>();
  slice->SetOrigin(20, 20, 20);
  slice->SetNormal(1, 2, 3);
  slice->SetValue(0, FilterIsovalue);
  return slice;
}

vtkSmartPointer<vtkAlgorithm> MakeRegion(const Inputs& inputs)
{
  auto region = inputs.OfReader<vtkVolumeRegion>();
  region->SetPosition(5, 5, 5);
  region->SetLength(30, 30, 30);
  return region;
}

vtkSmartPointer<vtkAlgorithm> MakeProbe(const Inputs& inputs)
{
  auto probe = inputs.OfReader<vtkVolumeProbe>();
  probe->SetSourceConnection(inputs.Source->GetOutputPort());
  return probe;
}

vtkSmartPointer<vtkAlgorithm> MakeCoarseContour(const Inputs& inputs)
{
  const auto contour = inputs.ContourOf(inputs.Source);
  contour->AllowCoarse(1);
  return contour;
}

vtkSmartPointer<vtkAlgorithm> MakeContourWithinBudget(const Inputs& inputs)
{
  const auto contour = inputs.ContourOf(inputs.Reader);
  contour->SetMaximumTriangles(1000000);
  return contour;
}

vtkSmartPointer<vtkAlgorithm> MakeBalancedContour(const Inputs& inputs)
{
  const auto contour = inputs.ContourOf(inputs.Reader);
  contour->DynamicBalanceOn();
  return contour;
}

vtkSmartPointer<vtkAlgorithm> MakeSpectrum(const Inputs& inputs)
{
  auto spectrum = vtkSmartPointer<vtkContourSpectrum>::New();
  spectrum->SetInputConnection(inputs.Source->GetOutputPort());
  SelectPoints(spectrum, "density");
  return spectrum;
}

std::vector<FilterDeed> MakeDeeds()
{
  return {
    { "ContourOfImages", [](const Inputs& in) { return in.ContourOf(in.Source); } },
    { "CoarseContourOfImages", MakeCoarseContour },
    { "IslandsOfImages", [](const Inputs& in) { return FindIslandsOf(in.ContourOf(in.Source)); } },
    { "DistributionOfImages", [](const Inputs& in) { return in.DistributionOf(in.Source); } },
    { "Spectrum", MakeSpectrum },
    { "ContourOfAVolume", [](const Inputs& in) { return in.ContourOf(in.Reader); } },
    { "ContourWithinBudget", MakeContourWithinBudget },
    { "BalancedContour", MakeBalancedContour },
    { "IslandsOfAVolume", [](const Inputs& in) { return FindIslandsOf(in.ContourOf(in.Reader)); } },
    { "DistributionOfAVolume", [](const Inputs& in) { return in.DistributionOf(in.Reader); } },
    { "Samples", [](const Inputs& in) { return in.Reader; } },
    { "SliceWithIsolines", MakeIsolines },
    { "Region", MakeRegion },
    { "Probe", MakeProbe },
    { "EdgeIndexReader", MakeEdgeIndexReader },
  };
}

class FilterMemory : public testing::TestWithParam<FilterDeed>
{
protected:
  FilterMemory()
    : Algorithm(GetParam().Make(this->In))
    , Errors(this->Algorithm)
  {
  }

  void Update()
  {
    this->Algorithm->Modified();
    this->Algorithm->UpdatePiece(GetRank(), GetNumberOfRanks(), 0);
  }

  /// Of what all ranks have made. Collective.
  std::uint64_t GetSize()
  {
    vtkDataObject* output = this->Algorithm->GetOutputDataObject(0);
    return SumOverRanks(
      static_cast<std::uint64_t>(output->GetNumberOfElements(vtkDataObject::CELL) +
        output->GetNumberOfElements(vtkDataObject::ROW)));
  }

  /// One rank lacks an allocation. Returns whether it is asked for. Collective.
  bool Starve(int odd, long allocation, std::uint64_t whole)
  {
    const std::string where =
      "allocation " + std::to_string(allocation) + " of rank " + std::to_string(odd) + ": ";
    bool isAsked = false;
    {
      const MemoryShortage shortage(GetRank() == odd ? allocation : -1);
      this->Update();
      isAsked = GetRank() == odd && MemoryShortage::Count() > allocation;
    }
    const auto messages = std::exchange(this->Errors.Messages, {});
    const std::uint64_t failed = SumOverRanks(messages.empty() ? 0 : 1);
    this->Failures += failed == 0 ? 0 : 1;
    EXPECT_LE(messages.size(), 1U) << where << testing::PrintToString(messages);
    EXPECT_TRUE(failed == 0 || failed == static_cast<std::uint64_t>(GetNumberOfRanks()))
      << where << testing::PrintToString(messages);
    EXPECT_EQ(this->GetSize(), failed == 0 ? whole : 0) << where;
    for (const std::string& message : messages)
    {
      EXPECT_NE(message.find("memory"), std::string::npos) << where << message;
    }
    return SumOverRanks(isAsked ? 1 : 0) != 0;
  }

  /// The same at several of the allocations that it makes. Returns how many these are.
  long StarveOften(int odd, std::uint64_t whole)
  {
    long asked = 0;
    {
      const MemoryShortage none(-1);
      this->Update();
      asked = GetRank() == odd ? MemoryShortage::Count() : 0;
    }
    const auto all = static_cast<long>(SumOverRanks(static_cast<std::uint64_t>(asked)));
    const long step = LongTests ? 1 : std::max(1L, all / 5);
    for (long allocation = 0; this->Starve(odd, allocation, whole); allocation += step)
    {
    }
    return all;
  }

  const Inputs In;
  const vtkSmartPointer<vtkAlgorithm> Algorithm;
  ErrorCounter Errors;
  int Failures = 0; ///< the shortages that were an error
};

} // namespace

TEST_P(FilterMemory, LackOnOneRankIsOneErrorOnAll)
{
  this->Update();
  const std::uint64_t whole = this->GetSize();
  EXPECT_GT(whole, 100U) << testing::PrintToString(this->Errors.Messages);
  const int last = GetNumberOfRanks() - 1;
  const long least = GetNumberOfRanks() > 3 ? 0 : 5; // of many, the last one may have no blocks
  for (const int odd : LongTests ? std::vector<int>{ 0, last } : std::vector<int>{ last })
  {
    const int before = this->Failures;
    // Where ranks share their work as they come, one may have nothing to do.
    long all = 0;
    for (int tries = 0; (this->Failures == before || all <= least) && tries < 20; ++tries)
    {
      all = std::max(all, this->StarveOften(odd, whole));
    }
    EXPECT_GT(all, least) << "the test watches nothing";
    EXPECT_GT(this->Failures, before) << "the test starves nobody";
  }
  this->Update();
  EXPECT_EQ(this->GetSize(), whole);
  EXPECT_EQ(this->Errors.Messages, std::vector<std::string>());
}

INSTANTIATE_TEST_SUITE_P(Deeds, FilterMemory, testing::ValuesIn(MakeDeeds()),
  [](const auto& one) { return one.param.Name; });
