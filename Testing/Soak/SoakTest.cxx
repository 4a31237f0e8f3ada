// SPDX-License-Identifier: BSD-3-Clause
// Random queries over several volumes at once, by consumers that share readers and the block cache,
// while volumes are replaced, readers come and go, and the cache changes its size.
#include "ProcessUse.h"
#include "ScratchFolder.h"
#include "SoakVolume.h"

#include "vtkBlockedVolumeReader.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

using namespace isosurface;

namespace
{

constexpr int Queries = ISOSURFACE_LONG_TESTS ? 1000 : 500;
constexpr rlim_t Descriptors = 64;
constexpr std::size_t PooledFiles = Descriptors / 4; ///< and those that are in use
constexpr int CacheSizes[] = { 1, 3, 64 };           ///< MiB; a volume has from 0.2 to 0.8

class Soak : public testing::Test
{
protected:
  Soak()
  {
    // Files share a quarter of the descriptors that a process may have.
    rlimit descriptors = {};
    getrlimit(RLIMIT_NOFILE, &descriptors);
    descriptors.rlim_cur = Descriptors;
    setrlimit(RLIMIT_NOFILE, &descriptors);
    for (int kind = 0; kind < NumberOfSoakVolumes; ++kind)
    {
      this->Volumes.push_back(std::make_unique<SoakVolume>(
        kind, this->Folder.GetPath("volume" + std::to_string(kind) + ".bvol")));
    }
  }

  int Draw(int end) { return static_cast<int>(this->Random() % static_cast<unsigned int>(end)); }

  void AskAny()
  {
    SoakVolume& volume = *this->Volumes[static_cast<std::size_t>(this->Draw(NumberOfSoakVolumes))];
    const int chance = this->Draw(100);
    if (chance < 2)
    {
      volume.Replace();
    }
    else if (chance < 4)
    {
      volume.Reopen();
    }
    else if (chance < 6)
    {
      vtkNew<vtkBlockedVolumeReader> any;
      any->SetCacheSize(CacheSizes[this->Draw(3)]);
    }
    SoakQuery query;
    query.Consumer = static_cast<std::size_t>(this->Draw(SoakVolume::NumberOfConsumers));
    query.Step = static_cast<std::size_t>(this->Draw(static_cast<int>(volume.GetNumberOfSteps())));
    query.Isovalue = static_cast<std::size_t>(this->Draw(SoakVolume::NumberOfIsovalues));
    query.Level = this->Draw(3);
    volume.Ask(query, this->Random);
  }

  /// Asks until so many queries are done, or a time has passed; returns the maximum use.
  template <typename Goes>
  ProcessUse AskWhile(const Goes& goes)
  {
    ProcessUse maximum;
    for (int query = 0; goes(query) && !this->HasFailure(); ++query)
    {
      this->AskAny();
      ++this->Asked;
      const ProcessUse use = MeasureUse(this->Folder.GetPath(""));
      maximum.Files = std::max(maximum.Files, use.Files);
      maximum.Threads = std::max(maximum.Threads, use.Threads);
      maximum.Mebibytes = std::max(maximum.Mebibytes, use.Mebibytes);
    }
    return maximum;
  }

  const ScratchFolder Folder;
  std::mt19937 Random{ 20261122 };
  int Asked = 0;
  std::vector<std::unique_ptr<SoakVolume>> Volumes;
};

TEST_F(Soak, ManyQueriesGiveTheRightSurfacesWithinWhatTheFirstOnesUsed)
{
  const ProcessUse first = this->AskWhile([](int query) { return query < Queries / 3; });
  const char* seconds = std::getenv("ISOSURFACE_SOAK_SECONDS");
  const auto end =
    std::chrono::steady_clock::now() + std::chrono::seconds(seconds ? std::atoi(seconds) : 0);
  const ProcessUse later = this->AskWhile([&](int query)
    { return query < Queries - Queries / 3 || std::chrono::steady_clock::now() < end; });
  // Beside the calling thread, an extraction may be at work, on all cores.
  const std::size_t workers = std::thread::hardware_concurrency() + 1;
  EXPECT_GT(first.Files, 0u);
  EXPECT_LE(std::max(first.Files, later.Files), PooledFiles + workers);
  EXPECT_LE(later.Threads, first.Threads + workers);
  // The allocator keeps some of what threads that have ended gave back.
  EXPECT_LE(later.Mebibytes, first.Mebibytes + first.Mebibytes / 10 + 32);
  RecordProperty("Queries", this->Asked);
  RecordProperty("Files", static_cast<int>(std::max(first.Files, later.Files)));
  RecordProperty("Threads", static_cast<int>(std::max(first.Threads, later.Threads)));
  RecordProperty("FirstMebibytes", static_cast<int>(first.Mebibytes));
  RecordProperty("LaterMebibytes", static_cast<int>(later.Mebibytes));
}

} // namespace
