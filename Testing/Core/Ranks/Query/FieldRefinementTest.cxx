// SPDX-License-Identifier: BSD-3-Clause
// Each step of a surface from coarse to final, on ranks that are threads, without a pipeline.
#include "Ranks/Query/FieldRefinement.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Ranks/Query/MemoryField.h"
#include "Ranks/Query/StoredField.h"

using namespace isosurface;

namespace
{

constexpr int RefiningRanks = 3;
constexpr double RefinedIsovalue = 100;

/// Counts the collectives of a rank.
class CountingCommunicator : public Communicator
{
public:
  explicit CountingCommunicator(Communicator& ranks)
    : Ranks(ranks)
  {
  }
  int GetRank() const override { return this->Ranks.GetRank(); }
  int GetSize() const override { return this->Ranks.GetSize(); }
  int GetRanksOnNode() override { return this->Ranks.GetRanksOnNode(); }
  void ReduceMinimum(std::vector<std::uint64_t>& values) override
  {
    ++this->Count;
    this->Ranks.ReduceMinimum(values);
  }
  void ReduceMaximum(std::vector<std::uint64_t>& values) override
  {
    ++this->Count;
    this->Ranks.ReduceMaximum(values);
  }
  void ReduceSum(std::vector<std::uint64_t>& values) override
  {
    ++this->Count;
    this->Ranks.ReduceSum(values);
  }
  std::vector<Message> AllGather(const Message& mine) override
  {
    ++this->Count;
    return this->Ranks.AllGather(mine);
  }
  std::vector<Message> Exchange(std::vector<Message> outgoing) override
  {
    ++this->Count;
    return this->Ranks.Exchange(std::move(outgoing));
  }
  int TakeCount() { return std::exchange(this->Count, 0); }

private:
  Communicator& Ranks;
  int Count = 0;
};

/// What one rank of a window does.
class Window
{
public:
  Window(Communicator& communicator, FileSystem& disk)
    : Counted(communicator)
    , Volume(OpenVolume(disk))
    , Surfaces([this] { return this->FreeMemory; })
  {
    this->Wanted.MayBeCoarse = true;
    this->Wanted.Change = 1;
    this->Query = { { 0, 0, { RefinedIsovalue } }, communicator.GetRank(), communicator.GetSize() };
  }

  Result<FieldRefinement::Choice> Begin()
  {
    if (this->Image)
    {
      this->AskImage();
      return this->Surfaces.Begin(this->Counted, this->InMemory, this->Wanted);
    }
    ExtractionTask task = { this->Volume, this->Query, {}, 1, {} };
    task.Request.Isovalues = this->Query.Isovalues;
    this->Stored.Ask(task, {});
    return this->Surfaces.Begin(this->Counted, this->Stored, this->Wanted);
  }

  /// The triangles of all ranks, and the level.
  std::pair<std::uint64_t, int> Show()
  {
    const auto choice = this->Begin();
    EXPECT_TRUE(choice.IsOk()) << choice.GetStatus().GetMessage();
    ExtractionOutcome outcome;
    const Status status = this->Image
      ? this->InMemory.Extract(this->Counted, choice->Level, outcome)
      : this->Stored.Extract(this->Counted, choice->Level, outcome);
    EXPECT_TRUE(status.IsOk()) << status.GetMessage();
    this->Surfaces.SetShown(status.IsOk(), outcome.Cost.Level, outcome.Extracted.NumberOfTriangles);
    const std::uint64_t triangles = this->Counted.Sum(outcome.Extracted.NumberOfTriangles);
    return { triangles, outcome.Cost.Level };
  }

  Refinement Prepare(double seconds = 0.01)
  {
    return this->Surfaces.Prepare(this->Counted, seconds, this->Wanted.Change);
  }

  /// The stage after the work.
  RefinementStage Finish()
  {
    Refinement next = this->Prepare();
    while (next.Stage == RefinementStage::Working)
    {
      next = this->Prepare();
    }
    return next.Stage;
  }

  CountingCommunicator Counted;
  const SampleVolume<std::uint8_t>* Image =
    nullptr; ///< if given, its surface is shown, of slabs of the ranks
  std::shared_ptr<BlockedVolume> Volume;
  SurfaceQuery Query;
  std::uint64_t ImageIdentity = 1;
  RefinementRequest Wanted;
  std::uint64_t FreeMemory = 0; ///< unknown
  StoredField Stored;
  MemoryField InMemory;
  FieldRefinement Surfaces;

private:
  void AskImage()
  {
    MemoryQuery query;
    const int rank = this->Counted.GetRank();
    const std::int64_t slices = this->Image->GetDimensions()[2] - 1;
    VertexBox slab = { { 0, 0, 0 }, this->Image->GetDimensions() };
    slab.Low[2] = slices * rank / this->Counted.GetSize();
    slab.High[2] = slices * (rank + 1) / this->Counted.GetSize() + 1;
    query.Samples.Grids = { this->Image->Geometry };
    query.Samples.Lines.resize(1);
    query.Samples.Pieces = { { 0, { this->Image->GetView(slab) }, {}, {}, this->ImageIdentity,
      {} } };
    query.Request.Isovalues = this->Query.Isovalues;
    this->InMemory.Ask(std::move(query), {});
  }
};

/// A volume whose surface has so many triangles that the first one is coarse.
class FieldRefinementTest : public testing::Test
{
protected:
  FieldRefinementTest() { WriteVolumeOk(this->Disk, this->Image, MakeSettings(16, RefiningRanks)); }

  std::uint64_t CountExactTriangles()
  {
    const auto volume = OpenVolume(this->Disk);
    ExtractionTask task = { volume, { { 0, 0, { RefinedIsovalue } }, 0, 1 }, {}, 1, {} };
    task.Request.Isovalues = { RefinedIsovalue };
    ExtractionOutcome outcome;
    EXPECT_TRUE(ExtractLevel(task, 0, outcome).IsOk());
    return outcome.Extracted.NumberOfTriangles;
  }

  template <typename Body>
  void OnRanks(const Body& body)
  {
    ThreadCommunicator::Run(RefiningRanks,
      [&](Communicator& communicator)
      {
        Window window(communicator, this->Disk);
        body(window);
      });
  }

  const SampleVolume<std::uint8_t> Image{ { 150, 140, 130 },
    [](auto i, auto j, auto k)
    { return static_cast<std::uint8_t>((i * i + j * j + k * k) / 160 % 200); } };
  MemoryDisk Disk;
};

} // namespace

TEST(Refinement, KeepsEachMemberAsAValueOfAProperty)
{
  const Refinement written = { RefinementStage::Growing, 3, 2, 1, 4, 0.25, 1e9, 2.5e12, 7e3, 61 };
  const Refinement::Values values = written.ToValues();
  EXPECT_EQ(values, (Refinement::Values{ 4, 3, 2, 1, 4, 0.25, 1e9, 2.5e12, 7e3, 61 }));
  EXPECT_EQ(Refinement::FromValues(values.data()).ToValues(), values);
}

TEST_F(FieldRefinementTest, GoesFromACoarseSurfaceToTheFinalOne)
{
  const std::uint64_t exact = this->CountExactTriangles();
  this->OnRanks(
    [&](Window& window)
    {
      const auto [coarse, level] = window.Show();
      EXPECT_GT(level, 0);
      EXPECT_LE(20 * coarse, exact);
      EXPECT_FALSE(window.Surfaces.IsFinal());
      EXPECT_EQ(window.Finish(), RefinementStage::Ready);
      EXPECT_TRUE(window.Surfaces.Refine(1));
      EXPECT_EQ(window.Show(), std::make_pair(exact, 0));
      EXPECT_TRUE(window.Surfaces.IsFinal());
      EXPECT_EQ(window.Prepare().Stage, RefinementStage::None);
      EXPECT_FALSE(window.Surfaces.Refine(1));
    });
}

TEST_F(FieldRefinementTest, OfAnImageGoesTheSameWayTogether)
{
  const std::uint64_t exact = this->CountExactTriangles();
  this->OnRanks(
    [&](Window& window)
    {
      window.Image = &this->Image;
      const auto [coarse, level] = window.Show();
      EXPECT_GT(level, 0);
      EXPECT_GT(coarse, 0U);
      EXPECT_LT(coarse, exact / 4);
      EXPECT_FALSE(window.Surfaces.IsFinal());
      window.Counted.TakeCount();
      EXPECT_TRUE(window.Begin().IsOk());
      EXPECT_EQ(window.Counted.TakeCount(), 1) << "nothing has changed";
      EXPECT_EQ(window.Finish(), RefinementStage::Ready);
      EXPECT_TRUE(window.Surfaces.Refine(1));
      EXPECT_EQ(window.Show(), std::make_pair(exact, 0));
      EXPECT_TRUE(window.Surfaces.IsFinal());
      EXPECT_EQ(window.Prepare().Stage, RefinementStage::None);
      window.ImageIdentity = window.Counted.GetRank() == 1 ? 2 : 1;
      EXPECT_EQ(window.Show(), std::make_pair(coarse, level)) << "a rank has other samples";
      window.Image = nullptr;
      EXPECT_GT(window.Show().second, 0) << "a volume has taken its place";
    });
}

TEST_F(FieldRefinementTest, IsTheSameWithoutPreparation)
{
  const std::uint64_t exact = this->CountExactTriangles();
  this->OnRanks(
    [&](Window& window)
    {
      window.Show();
      EXPECT_TRUE(window.Surfaces.Refine(1));
      EXPECT_EQ(window.Show(), std::make_pair(exact, 0));
    });
}

TEST_F(FieldRefinementTest, ScriptsGetOneLevelAfterTheOther)
{
  this->OnRanks(
    [&](Window& window)
    {
      window.Wanted.MayBeCoarse = false;
      window.Wanted.IsProgressive = true;
      int last = window.Show().second;
      EXPECT_GT(last, 1);
      while (!window.Surfaces.IsFinal())
      {
        EXPECT_TRUE(window.Surfaces.Refine(1));
        const int level = window.Show().second;
        EXPECT_LT(level, last);
        last = level;
      }
      EXPECT_EQ(last, 0);
    });
}

TEST_F(FieldRefinementTest, AChangeOnOneRankBeginsAnewOnAll)
{
  this->OnRanks(
    [&](Window& window)
    {
      const int first = window.Show().second;
      EXPECT_TRUE(window.Surfaces.Refine(1));
      window.Surfaces.KeepChange(2); // Refine itself has made it
      window.Wanted.Change = 2;
      EXPECT_EQ(window.Show().second, 0);
      if (window.Counted.GetRank() == 1)
      {
        window.Wanted.Change = 3;
      }
      EXPECT_EQ(window.Show().second, first);
      EXPECT_FALSE(window.Surfaces.Refine(99)) << "nothing was extracted since that change";
    });
}

TEST_F(FieldRefinementTest, ASurfaceLargerThanTheMemoryOfOneRankWaitsUntilAllAcceptIt)
{
  this->OnRanks(
    [&](Window& window)
    {
      const bool isShort = window.Counted.GetRank() == 2;
      window.FreeMemory = isShort ? 1000 : std::uint64_t{ 1 } << 40;
      const int level = window.Show().second;
      const Refinement next = window.Prepare();
      EXPECT_EQ(next.Stage, RefinementStage::TooLarge);
      EXPECT_EQ(next.FreeBytes, 1000);
      EXPECT_EQ(next.ShownLevel, level);
      EXPECT_EQ(next.NextLevel, 0);
      if (isShort)
      {
        window.Surfaces.AcceptSize();
      }
      EXPECT_EQ(window.Prepare().Stage, RefinementStage::TooLarge);
      window.Surfaces.AcceptSize();
      EXPECT_EQ(window.Finish(), RefinementStage::Ready);
    });
}

TEST_F(FieldRefinementTest, BeginsWithTwoReductionsAndPollsWithOne)
{
  this->OnRanks(
    [&](Window& window)
    {
      EXPECT_TRUE(window.Begin().IsOk());
      EXPECT_EQ(window.Counted.TakeCount(), 2);
      EXPECT_TRUE(window.Begin().IsOk());
      EXPECT_EQ(window.Counted.TakeCount(), 1) << "nothing has changed";
      window.Show();
      window.Finish();
      window.Counted.TakeCount();
      window.Prepare();
      EXPECT_EQ(window.Counted.TakeCount(), 1);
    });
}

TEST_F(FieldRefinementTest, AnErrorOfOneRankIsOneOfAll)
{
  MemoryDisk damaged;
  WriteVolumeOk(
    damaged, MakeVolume<std::uint8_t>({ 150, 140, 130 }, 1), MakeSettings(16, RefiningRanks));
  for (const auto& [path, bytes] : damaged.GetFiles())
  {
    if (path.find("spectra") != std::string::npos)
    {
      bytes->resize(bytes->size() / 2);
    }
  }
  this->OnRanks(
    [&](Window& window)
    {
      const bool isBroken = window.Counted.GetRank() == 1;
      const auto sound = window.Volume;
      if (isBroken)
      {
        window.Volume = OpenVolume(damaged);
      }
      const auto failed = window.Begin();
      EXPECT_EQ(
        failed.GetStatus().GetCode(), isBroken ? StatusCode::Corrupt : StatusCode::RemoteFailure);
      ExpectMessage(failed.GetStatus(), "spectra");
      window.Volume = sound;
      EXPECT_GT(window.Show().second, 0) << "the error has left nothing";
    });
}

TEST_F(FieldRefinementTest, RanksThatSeeDifferentFilesFail)
{
  MemoryDisk other; // with a surface that is small enough to be shown at once
  WriteVolumeOk(other,
    SampleVolume<std::uint8_t>(
      { 150, 140, 130 }, [](auto, auto, auto) { return std::uint8_t{ 0 }; }),
    MakeSettings(16, RefiningRanks));
  this->OnRanks(
    [&](Window& window)
    {
      if (window.Counted.GetRank() == 1)
      {
        window.Volume = OpenVolume(other);
      }
      ExpectMessage(window.Begin().GetStatus(), "the ranks see different files");
    });
}
