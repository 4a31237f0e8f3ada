// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Indexing/FetchBudget.h"

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/HttpTransfers.h"
#include "Ground/Base/PrintableText.h"
#include "Ground/Base/ReadingStop.h"
#include "Ground/Volume/VolumeName.h"

#include <utility>
#include <vector>

namespace isosurface
{
namespace
{

/// What the names of all objects of a source begin with. Headers tell of data beside them.
std::string FindPrefix(const std::string& source)
{
  std::string path = VolumeName::Parse(GetLocalFileSystem(), source).Path;
  const std::size_t slash = path.rfind('/') + 1; // 0 if there is none
  const std::size_t point = path.find('.', slash);
  const std::string extension =
    path.substr(point == std::string::npos ? path.size() : path.rfind('.'));
  const bool isFolder = extension.empty() || extension == ".zarr" || extension == ".n5";
  return isFolder || slash == 0 ? path : path.substr(0, slash - 1);
}

} // namespace

FetchBudget::FetchBudget(std::string source, std::uint64_t bytes)
  : Source(std::move(source))
  , Counter(HttpTransfers::CountBytesOf(FindPrefix(this->Source)))
  , Limit(bytes)
{
}

std::uint64_t FetchBudget::CountMine() const
{
  return this->IsRunning ? *this->Counter - this->Idle : this->Kept.load();
}

bool FetchBudget::IsWithin(int ranks) const
{
  const std::uint64_t limit = this->Limit;
  const auto count = static_cast<std::uint64_t>(ranks);
  return limit == 0 || this->CountMine() < (limit + count - 1) / count;
}

void FetchBudget::Gather(Communicator& ranks)
{
  const std::uint64_t mine = this->CountMine();
  this->OfOthers = ranks.Sum(mine) - mine;
}

std::string FetchBudget::Describe() const
{
  const std::uint64_t fetched = this->CountFetched();
  const std::uint64_t all = this->SampleBytes;
  const std::uint64_t limit = this->Limit;
  return fetched == 0 ? std::string()
                      : DescribeBytes(fetched) + (all > 0 ? " of " + DescribeBytes(all) : "") +
      " fetched" + (limit > 0 ? ", at most " + DescribeBytes(limit) : "");
}

Status FetchBudget::Run(Communicator& ranks, const Progress& progress,
  const std::function<Status(const Progress& advance)>& work)
{
  std::atomic<bool> isSpent = false; // even if the limit has been raised since; any thread may ask
  const Progress isWithin = [this, count = ranks.GetSize(), &isSpent](double)
  {
    const bool isMore = !this->IsWithin(count);
    if (isMore)
    {
      isSpent = true;
    }
    return !isMore;
  };
  const Progress advance = [&](double done)
  {
    this->Done = done;
    return isWithin(done) && (!progress || progress(done));
  };
  const auto end = +[](FetchBudget* budget)
  {
    budget->Kept = budget->CountMine();
    budget->IsRunning = false;
  };
  this->Idle = *this->Counter - this->Kept;
  this->HasEndedWork = false;
  this->IsRunning = true;
  Status status;
  {
    const std::unique_ptr<FetchBudget, decltype(end)> running(this, end);
    const ReadingStop stop(isWithin);
    const bool mayBegin = ranks.All(isWithin(0));
    status = mayBegin ? work(advance)
                      : Status(StatusCode::Aborted, this->Source + ": the budget is spent");
  }
  const StatusCode code = status.GetCode();
  const bool isOther =
    !status.IsOk() && code != StatusCode::Aborted && code != StatusCode::RemoteFailure;
  const bool isStopped = !status.IsOk() && progress && !progress(this->Done);
  std::vector<std::uint64_t> any = { isOther || isStopped ? 1U : 0U,
    !status.IsOk() && isSpent ? 1U : 0U };
  ranks.ReduceMaximum(any);
  this->Gather(ranks);
  this->HasEndedWork = any[0] == 0 && any[1] != 0;
  constexpr double hundred = 100;
  return !this->HasEndedWork
    ? status
    : Status(StatusCode::IoError,
        this->Source + ": the budget of bytes is spent: " + this->Describe() + "; " +
          std::to_string(static_cast<int>(hundred * this->Done)) +
          " % is done: raise the budget, or choose a region");
}

} // namespace isosurface
