// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Query/BackgroundExtraction.h"
#include "Fixtures/PlainContour.h"
#include "Fixtures/VolumeOnDisk.h"
#include "Ranks/Query/StoredField.h"

#include <chrono>
#include <thread>

using namespace isosurface;

namespace
{

constexpr double Isovalue = 40;

ExtractionTask MakeTask(const std::shared_ptr<BlockedVolume>& volume)
{
  ExtractionTask task;
  task.Volume = volume;
  task.Query.Isovalues = { Isovalue, Isovalue + 20 };
  task.Request = MakePlainRequest(task.Query.Isovalues);
  task.Threads = 2;
  return task;
}

/// A level that is extracted beside the calling thread.
class LevelBeside
{
public:
  LevelBeside(const ExtractionTask& task, int level)
    : Extraction(this->Alone,
        [task, level](Communicator&, const Progress& advance, ExtractionOutcome& outcome)
        {
          ExtractionTask mine = task;
          mine.Advance = advance;
          return ExtractLevel(mine, level, outcome);
        })
  {
  }
  bool Wait(double seconds) { return this->Extraction.GetWork().WaitAlone(seconds); }
  double GetProgress() { return this->Extraction.GetWork().GetProgress(); }
  Status Take(const Progress& advance, ExtractionOutcome& outcome)
  {
    return this->Extraction.Take(this->Alone, advance, outcome);
  }

private:
  SerialCommunicator Alone;
  BackgroundExtraction Extraction;
};

void ExpectSameBits(const Surface& surface, const Surface& expected)
{
  EXPECT_GT(expected.NumberOfTriangles, 1000u);
  ExpectSameSurface(surface, expected);
}

class BackgroundExtractionTest : public testing::Test
{
protected:
  BackgroundExtractionTest()
  {
    WriteVolumeOk(this->Disk, MakeVolume<std::int16_t>({ 90, 85, 80 }), MakeSettings(16, 3));
  }

  Surface ExtractAtOnce(int level)
  {
    ExtractionTask task = MakeTask(OpenVolume(this->Disk));
    task.Threads = 1;
    ExtractionOutcome outcome;
    EXPECT_TRUE(ExtractLevel(task, level, outcome).IsOk());
    return std::move(outcome.Extracted);
  }

  MemoryDisk Disk;
};

} // namespace

TEST_F(BackgroundExtractionTest, GivesTheSurfaceThatIsExtractedAtOnce)
{
  for (int level = 0; level < 2; ++level)
  {
    const auto volume = OpenVolume(this->Disk);
    LevelBeside extraction(MakeTask(volume), level);
    while (!extraction.Wait(0.001))
    {
      EXPECT_GE(extraction.GetProgress(), 0);
    }
    EXPECT_EQ(extraction.GetProgress(), 1);
    ExtractionOutcome outcome;
    outcome.Cost.Reading.TreePagesRead = 1'000'000;
    ASSERT_TRUE(extraction.Take({}, outcome).IsOk());
    ExpectSameBits(outcome.Extracted, this->ExtractAtOnce(level));
    EXPECT_EQ(outcome.Cost.Level, level);
    EXPECT_GT(outcome.Cost.Reading.TreePagesRead, 1'000'000u) << "costs are added";
    EXPECT_GT(outcome.Cost.Reading.ActiveBlocks, 0u);
  }
}

TEST_F(BackgroundExtractionTest, StopsWhenNobodyWantsIt)
{
  const std::uint64_t before = this->Disk.GetReads();
  this->ExtractAtOnce(0);
  const std::uint64_t all = this->Disk.GetReads() - before;
  ASSERT_GT(all, 150u);
  const auto volume = OpenVolume(this->Disk);
  const std::uint64_t opened = this->Disk.GetReads();
  this->Disk.SetBeforeRead([] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); });
  {
    const LevelBeside extraction(MakeTask(volume), 0);
  }
  EXPECT_LT(this->Disk.GetReads() - opened, all / 2);
}

TEST_F(BackgroundExtractionTest, TakingItCanBeAborted)
{
  const auto volume = OpenVolume(this->Disk);
  this->Disk.SetBeforeRead([] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); });
  LevelBeside extraction(MakeTask(volume), 0);
  ExtractionOutcome outcome;
  int calls = 0;
  const Status status = extraction.Take([&](double) { return ++calls < 2; }, outcome);
  EXPECT_EQ(status.GetCode(), StatusCode::Aborted);
  EXPECT_EQ(calls, 2);
}

TEST_F(BackgroundExtractionTest, TellsOfErrorsWhenItIsTaken)
{
  const auto volume = OpenVolume(this->Disk);
  this->Disk.FailFromRead(60); // its own files are open by then
  LevelBeside extraction(MakeTask(volume), 0);
  ExtractionOutcome outcome;
  const Status status = extraction.Take({}, outcome);
  ExpectError(status, StatusCode::IoError, "/data/volume.bvol");
  EXPECT_TRUE(extraction.Wait(0));
}

TEST_F(BackgroundExtractionTest, IsTakenOnlyForItsLevelAndShare)
{
  const auto volume = OpenVolume(this->Disk);
  SerialCommunicator alone;
  StoredField field;
  const auto extract = [&](const ExtractionTask& task, int level)
  {
    field.Ask(task, {});
    ExtractionOutcome outcome;
    EXPECT_TRUE(field.Extract(alone, level, outcome).IsOk());
    return std::move(outcome.Extracted);
  };
  const ExtractionTask whole = MakeTask(volume);
  field.Ask(whole, {});
  EXPECT_TRUE(field.Prepare(alone, 1).IsOk());
  ASSERT_NE(field.GetPrepared(), nullptr);
  ExpectSameBits(extract(whole, 0), this->ExtractAtOnce(0));
  EXPECT_NE(field.GetPrepared(), nullptr) << "it is of another level";

  ExtractionTask half = whole;
  half.Query.Ranks = 2;
  const Surface part = extract(half, 1);
  EXPECT_NE(field.GetPrepared(), nullptr) << "it is of another share";
  ExpectSameBits(extract(whole, 1), this->ExtractAtOnce(1));
  EXPECT_EQ(field.GetPrepared(), nullptr) << "it was handed over";
  EXPECT_LT(part.NumberOfTriangles, this->ExtractAtOnce(1).NumberOfTriangles);
}
