// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/RemoteFileSystem.h"

#include "Ground/Base/Address.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/CurlLibrary.h"
#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/HttpTransfers.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Base/ReadingStop.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

namespace isosurface
{
namespace
{

/// What is fetched with the opening of a file: metadata have fewer bytes, headers begin with fewer.
constexpr std::int64_t FirstBytes = std::int64_t{ 1 } << 16;
/// Files are read in pages of so many bytes, and several at once where they are read on and on.
constexpr std::uint64_t RemotePageBytes = std::uint64_t{ 1 } << 17;
constexpr std::uint64_t MaximumKeptPages = 256;
/// Of one request; more bytes are fetched by several at once.
constexpr std::uint64_t MaximumRequestBytes = std::uint64_t{ 1 } << 22;
constexpr std::size_t MaximumKnown = 1 << 12;
constexpr std::size_t MaximumChecked = 1 << 20;
constexpr std::chrono::seconds KnownTime{ 10 };
constexpr std::chrono::seconds CheckedTime{ 60 };
constexpr int LookingThreads = 16;
constexpr int MaximumPrefetching = 16;
std::atomic<int> PrefetchingThreads = 0;

struct ContentRange
{
  std::uint64_t Begin = 0;
  std::uint64_t End = 0;
  std::uint64_t Size = 0;
};

/// Reads "bytes 0-99/1234"; nothing of other texts.
std::optional<ContentRange> ParseContentRange(const std::string& text)
{
  unsigned long long numbers[3] = {};
  const char* at = text.c_str();
  const char* const marks[] = { "bytes ", "-", "/" };
  for (int number = 0; number < 3; ++number)
  {
    const std::size_t length = std::strlen(marks[number]);
    char* end = nullptr;
    if (std::strncmp(at, marks[number], length) != 0 ||
      !std::isdigit(static_cast<unsigned char>(at[length])))
    {
      return std::nullopt;
    }
    numbers[number] = std::strtoull(at + length, &end, 10);
    at = end;
  }
  const bool isRange = numbers[0] <= numbers[1] && numbers[1] < numbers[2];
  return isRange ? std::optional(ContentRange{ numbers[0], numbers[1] + 1, numbers[2] })
                 : std::nullopt;
}

Status Fail(const std::string& path, StatusCode code, const std::string& reason)
{
  return Status(code, path + ": cannot be read: " + reason);
}

Status MakeRangeError(const std::string& path)
{
  return Fail(path, StatusCode::Unsupported,
    "the server gives no ranges of bytes; download the file, and read the copy");
}

Status MakeWrongError(const std::string& path)
{
  return Fail(path, StatusCode::Corrupt,
    "truncated: the server sends other bytes than those that it was asked for");
}

/// S3's word for an error, <Code>AccessDenied</Code>; "" if there is none.
std::string FindErrorWord(const std::vector<std::uint8_t>& body)
{
  const std::string text(body.begin(), body.end());
  const std::size_t begin = text.find("<Code>");
  std::string word;
  for (std::size_t at = begin + 6; begin != std::string::npos && at < text.size() &&
       word.size() < 40 && std::isalnum(static_cast<unsigned char>(text[at]));
       ++at)
  {
    word += text[at];
  }
  return word;
}

bool IsHtml(const HttpAnswer& answer)
{
  const auto first = std::find_if(
    answer.Body.begin(), answer.Body.end(), [](std::uint8_t byte) { return !std::isspace(byte); });
  return answer.Find("content-type").compare(0, 9, "text/html") == 0 &&
    first != answer.Body.end() && *first == '<';
}

/// What is wrong with an answer; Ok if it has data, or tells that they are as they were.
Status CheckAnswer(const std::string& path, const HttpAnswer& answer)
{
  const std::string word = FindErrorWord(answer.Body);
  const std::string code = std::to_string(answer.Code) + (word.empty() ? "" : ", " + word);
  if (answer.Code == 304)
  {
    return Status::Ok();
  }
  if (answer.Code == 404 || answer.Code == 410)
  {
    return Fail(path, StatusCode::NotFound, "the server has none of this name (" + code + ")");
  }
  if (answer.Code == 401 || answer.Code == 403 || word == "ExpiredToken")
  {
    return Fail(path, StatusCode::IoError,
      "the server denies it (" + code + "): keys are missing, wrong or have expired" +
        (word == "AccessDenied" ? ", or there is no such object in a bucket that must not be listed"
                                : ""));
  }
  if (answer.Code != 200 && answer.Code != 206)
  {
    return Fail(path, StatusCode::IoError, "the server answers " + code);
  }
  const std::string encoding = answer.Find("content-encoding");
  if (!encoding.empty() && encoding != "identity")
  {
    return Fail(path, StatusCode::Unsupported,
      "the server sends it compressed, though nothing asks for that");
  }
  return IsHtml(answer)
    ? Fail(path, StatusCode::Corrupt, "the server sends a page of HTML in place of data")
    : Status::Ok();
}

/// What tells versions apart: a header of an answer, as a condition of later requests has it.
std::string FindTag(const HttpAnswer& answer)
{
  const std::string tag = answer.Find("etag");
  const std::string modified = answer.Find("last-modified");
  return !tag.empty()   ? "If-None-Match: " + tag
    : !modified.empty() ? "If-Modified-Since: " + modified
                        : "";
}

std::int64_t FindModified(const HttpAnswer& answer)
{
  const auto curl = CurlLibrary::Load();
  const std::string modified = answer.Find("last-modified");
  const std::time_t time = curl.IsOk() && !modified.empty()
    ? (*curl)->GetDate(modified.c_str(), nullptr)
    : std::time_t{ -1 };
  const std::string tag = answer.Find("etag");
  constexpr std::int64_t nanoseconds = 1000000000;
  return time >= 0 && time < std::time_t{ 1 } << 33
    ? static_cast<std::int64_t>(time) * nanoseconds
    : static_cast<std::int64_t>(ComputeChecksum(tag.data(), tag.size()) >> 1);
}

std::string MakeRange(std::uint64_t begin, std::uint64_t end)
{
  return std::to_string(begin) + "-" + std::to_string(end - 1);
}

std::string MakeKey(const std::string& path, const std::string& range)
{
  return path + "\n" + range;
}

} // namespace

/// An object of a known size and version, and what is kept of it.
class RemoteObject : public std::enable_shared_from_this<RemoteObject>
{
public:
  RemoteObject(RemoteFileSystem& files, std::string path, RemotePart first, bool isPaged)
    : Files(files)
    , Path(std::move(path))
    , First(std::move(first))
    , IsPaged(isPaged)
  {
  }

  const std::string& GetPath() const { return this->Path; }
  const RemotePart& GetFirst() const { return this->First; }

  Status Read(std::uint64_t offset, std::size_t size, std::uint8_t* bytes)
  {
    if (offset > this->First.Size || size > this->First.Size - offset)
    {
      return Status(StatusCode::Corrupt,
        this->Path + ": truncated: " + std::to_string(size) + " bytes are wanted at offset " +
          std::to_string(offset) + " of " + std::to_string(this->First.Size));
    }
    const std::uint64_t begin = this->First.Begin;
    if (offset >= begin && offset + size <= begin + this->First.Bytes.size())
    {
      const auto at = static_cast<std::ptrdiff_t>(offset - begin);
      std::copy_n(this->First.Bytes.begin() + at, size, bytes);
      return Status::Ok();
    }
    return this->IsPaged ? this->ReadPages(offset, size, bytes)
                         : this->FetchExactly(offset, size, bytes);
  }

  /// Has a few threads fetch these bytes, at most as many as are kept.
  void Prefetch(std::uint64_t offset, std::uint64_t size)
  {
    constexpr std::uint64_t most = MaximumRequestBytes / RemotePageBytes;
    const std::uint64_t last = (this->First.Size + RemotePageBytes - 1) / RemotePageBytes;
    const std::uint64_t begin = offset / RemotePageBytes;
    const std::uint64_t stop = (offset + size + RemotePageBytes - 1) / RemotePageBytes;
    const std::uint64_t end = std::min({ last, stop, begin + MaximumKeptPages / 2 });
    for (std::uint64_t first = begin; this->IsPaged && first < end; first += most)
    {
      const std::uint64_t to = first + most < end ? first + most : end;
      const auto load = [self = this->shared_from_this(), first, to, token = ReadingStop::Share()]
      {
        const ReadingStop follows(token);
        Pages pages;
        static_cast<void>(self->LoadPages(first, to, pages)); // whoever reads tells the error
        --PrefetchingThreads;
      };
      const bool isFree = ++PrefetchingThreads <= MaximumPrefetching;
      const Status begun = isFree ? Attempt("",
                                      [&]
                                      {
                                        std::thread(load).detach();
                                        return Status::Ok();
                                      })
                                  : Status(StatusCode::IoError, "");
      if (!begun.IsOk()) // only a hint
      {
        --PrefetchingThreads;
        return;
      }
    }
  }

private:
  struct Page
  {
    std::timed_mutex Mutex;
    std::vector<std::uint8_t> Bytes; ///< none yet
    std::uint64_t Used = 0;
  };
  using Pages = std::vector<std::shared_ptr<Page>>;

  /// Bytes of the cache, or those that several requests fetch at once.
  Status FetchExactly(std::uint64_t offset, std::uint64_t size, std::uint8_t* bytes)
  {
    if (this->TakeCached(offset, size, bytes))
    {
      return Status::Ok();
    }
    const std::uint64_t count = (size + MaximumRequestBytes - 1) / MaximumRequestBytes;
    FirstFailure failure;
    ParallelFor(static_cast<std::size_t>(count),
      static_cast<int>(std::min<std::uint64_t>(count, LookingThreads)),
      [&](std::size_t number, int)
      {
        const std::uint64_t before = number * MaximumRequestBytes;
        const std::uint64_t part = std::min(MaximumRequestBytes, size - before);
        failure.Run([&] { return this->FetchPart(offset + before, part, bytes + before); });
      });
    ISOSURFACE_RETURN_IF_ERROR(failure.Get());
    this->Keep(offset, size, bytes);
    return Status::Ok();
  }

  bool TakeCached(std::uint64_t offset, std::uint64_t size, std::uint8_t* bytes) const
  {
    const auto cached = RemoteCache::Find(MakeKey(this->Path, MakeRange(offset, offset + size)));
    const bool isMine = cached && cached->Tag == this->First.Tag && cached->Bytes.size() == size;
    if (isMine)
    {
      std::copy(cached->Bytes.begin(), cached->Bytes.end(), bytes);
    }
    return isMine;
  }

  void Keep(std::uint64_t offset, std::uint64_t size, const std::uint8_t* bytes) const
  {
    RemoteCache::Keep(MakeKey(this->Path, MakeRange(offset, offset + size)),
      { this->First.Tag, this->First.Size, this->First.Modified, offset, { bytes, bytes + size } });
  }

  Status FetchPart(std::uint64_t offset, std::uint64_t size, std::uint8_t* bytes)
  {
    HttpRequest request;
    request.Range = MakeRange(offset, offset + size);
    request.MaximumBytes = size;
    ISOSURFACE_ASSIGN_OR_RETURN(const auto answer, this->Files.Ask(this->Path, request));
    ISOSURFACE_RETURN_IF_ERROR(CheckAnswer(this->Path, answer));
    if (answer.Code != 206)
    {
      return MakeRangeError(this->Path);
    }
    const auto range = ParseContentRange(answer.Find("content-range"));
    if (!range || range->Size != this->First.Size || FindTag(answer) != this->First.Tag)
    {
      return Status(
        StatusCode::Corrupt, this->Path + ": was changed since it was opened; open it again");
    }
    if (range->Begin != offset || range->End != offset + size || answer.Body.size() != size)
    {
      return MakeWrongError(this->Path);
    }
    std::copy(answer.Body.begin(), answer.Body.end(), bytes);
    return Status::Ok();
  }

  std::uint64_t CountPageBytes(std::uint64_t number) const
  {
    return std::min(RemotePageBytes, this->First.Size - number * RemotePageBytes);
  }

  /// The pages from `begin` to `end`, locked by the caller in this order.
  Pages TakePages(std::uint64_t begin, std::uint64_t end)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    Pages pages;
    for (std::uint64_t number = begin; number < end; ++number)
    {
      std::shared_ptr<Page>& page = this->Kept[number];
      page = page ? page : std::make_shared<Page>();
      page->Used = ++this->Uses;
      pages.push_back(page);
    }
    while (this->Kept.size() > MaximumKeptPages + pages.size())
    {
      const auto oldest = std::min_element(this->Kept.begin(), this->Kept.end(),
        [](const auto& a, const auto& b) { return a.second->Used < b.second->Used; });
      this->Kept.erase(oldest);
    }
    return pages;
  }

  /// Reads by pages, at most a request's at once. A page that another thread fetches is waited for.
  Status ReadPages(std::uint64_t offset, std::uint64_t size, std::uint8_t* bytes)
  {
    constexpr std::uint64_t most = MaximumRequestBytes / RemotePageBytes;
    this->ReadAhead(offset / RemotePageBytes, (offset + size - 1) / RemotePageBytes + 1);
    if (size > MaximumRequestBytes)
    {
      this->Prefetch(offset + MaximumRequestBytes, size - MaximumRequestBytes);
    }
    while (size > 0)
    {
      const std::uint64_t first = offset / RemotePageBytes;
      const std::uint64_t end = (offset + size - 1) / RemotePageBytes + 1;
      Pages pages;
      const std::uint64_t farthest = first + most;
      ISOSURFACE_RETURN_IF_ERROR(this->LoadPages(first, std::min(end, farthest), pages));
      for (const auto& page : pages)
      {
        const std::uint64_t within = offset % RemotePageBytes;
        const std::uint64_t left = page->Bytes.size() - within;
        const auto part = static_cast<std::size_t>(std::min(size, left));
        bytes = std::copy_n(page->Bytes.begin() + static_cast<std::ptrdiff_t>(within), part, bytes);
        offset += part;
        size -= part;
      }
    }
    return Status::Ok();
  }

  /// Gives pages with their bytes, which stay as they are from then on.
  Status LoadPages(std::uint64_t first, std::uint64_t end, Pages& pages)
  {
    pages = this->TakePages(first, end);
    std::vector<std::unique_lock<std::timed_mutex>> locks;
    for (const auto& page : pages)
    {
      constexpr std::chrono::milliseconds pause{ 100 };
      locks.emplace_back(page->Mutex, std::defer_lock);
      while (!locks.back().try_lock_for(pause))
      {
        if (ReadingStop::IsWanted())
        {
          return Status(StatusCode::Aborted, this->Path + ": reading was stopped");
        }
      }
    }
    return this->FetchMissing(first, pages);
  }

  /// Begins to fetch what follows a read that goes on from the last one: ever more.
  void ReadAhead(std::uint64_t first, std::uint64_t end)
  {
    std::uint64_t from = 0;
    std::uint64_t to = 0;
    {
      const std::lock_guard<std::mutex> lock(this->Mutex);
      const bool goesOn = first == this->LastEnd || first + 1 == this->LastEnd;
      const bool isNew = end > this->LastEnd;
      this->LastEnd = goesOn && !isNew ? this->LastEnd : end;
      this->Ahead = !goesOn ? 0 : isNew ? std::max<std::uint64_t>(1, 2 * this->Ahead) : this->Ahead;
      this->Ahead = std::min(this->Ahead, MaximumKeptPages / 4);
      from = std::max(end, goesOn ? this->EndOfAhead : 0);
      to = end + this->Ahead;
      if (!goesOn || !isNew || from + this->Ahead / 2 > to)
      {
        return;
      }
      this->EndOfAhead = to;
    }
    this->Prefetch(from * RemotePageBytes, (to - from) * RemotePageBytes);
  }

  /// Fetches the pages that have no bytes, those that follow each other by one request.
  Status FetchMissing(std::uint64_t first, const Pages& pages)
  {
    std::vector<std::uint8_t> bytes;
    std::size_t end = 0;
    for (std::size_t begin = 0; begin < pages.size(); begin = end + 1)
    {
      bytes.clear();
      for (end = begin; end < pages.size() && pages[end]->Bytes.empty(); ++end)
      {
        const std::uint64_t count = this->CountPageBytes(first + end);
        pages[end]->Bytes.resize(static_cast<std::size_t>(count));
        if (this->TakeCached((first + end) * RemotePageBytes, count, pages[end]->Bytes.data()))
        {
          break;
        }
        pages[end]->Bytes.clear();
        bytes.resize(bytes.size() + static_cast<std::size_t>(count));
      }
      const std::uint64_t offset = (first + begin) * RemotePageBytes;
      ISOSURFACE_RETURN_IF_ERROR(
        bytes.empty() ? Status::Ok() : this->FetchPart(offset, bytes.size(), bytes.data()));
      for (std::size_t at = begin; at < end; ++at)
      {
        const std::uint64_t count = this->CountPageBytes(first + at);
        const std::uint8_t* const from = bytes.data() + (at - begin) * RemotePageBytes;
        pages[at]->Bytes.assign(from, from + count);
        this->Keep((first + at) * RemotePageBytes, count, from);
      }
    }
    return Status::Ok();
  }

  RemoteFileSystem& Files;
  const std::string Path;
  const RemotePart First;
  const bool IsPaged;
  std::mutex Mutex; ///< of what follows, not of what pages have
  std::map<std::uint64_t, std::shared_ptr<Page>> Kept;
  std::uint64_t Uses = 0;
  std::uint64_t LastEnd = 0;
  std::uint64_t EndOfAhead = 0;
  std::uint64_t Ahead = 0;
};

namespace
{

class RemoteFile : public RandomAccessFile
{
public:
  explicit RemoteFile(std::shared_ptr<RemoteObject> object)
    : Object(std::move(object))
  {
  }

  Status Read(std::uint64_t offset, std::size_t size, void* bytes) const override
  {
    return this->Object->Read(offset, size, static_cast<std::uint8_t*>(bytes));
  }
  void Prefetch(std::uint64_t offset, std::uint64_t size) const override
  {
    this->Object->Prefetch(offset, size);
  }
  std::uint64_t GetSize() const override { return this->Object->GetFirst().Size; }
  const std::string& GetPath() const override { return this->Object->GetPath(); }

private:
  std::shared_ptr<RemoteObject> Object;
};

Result<std::unique_ptr<RandomAccessFile>> MakeFile(
  const Result<std::shared_ptr<RemoteObject>>& object)
{
  ISOSURFACE_RETURN_IF_ERROR(object.GetStatus());
  return std::unique_ptr<RandomAccessFile>(new RemoteFile(*object));
}

/// The part that an answer to the first request has.
Result<RemotePart> TakeFirst(
  const std::string& path, const HttpRequest& request, HttpAnswer& answer)
{
  RemotePart part;
  part.Tag = FindTag(answer);
  part.Modified = FindModified(answer);
  if (answer.Code == 200)
  {
    if (answer.IsCut)
    {
      return MakeRangeError(path);
    }
    part.Size = answer.Body.size();
    part.Bytes = std::move(answer.Body);
    return part;
  }
  const auto range = ParseContentRange(answer.Find("content-range"));
  const std::uint64_t wanted = request.MaximumBytes;
  const bool isLast = request.Range[0] == '-';
  const bool isRight = range && range->End - range->Begin == answer.Body.size() &&
    answer.Body.size() == std::min(wanted, range->Size) &&
    (isLast ? range->End == range->Size : range->Begin == 0);
  if (!isRight)
  {
    return MakeWrongError(path);
  }
  part.Size = range->Size;
  part.Begin = range->Begin;
  part.Bytes = std::move(answer.Body);
  return part;
}

} // namespace

RemoteFileSystem& RemoteFileSystem::Get()
{
  static RemoteFileSystem& files = *new RemoteFileSystem; // as the local one
  return files;
}

Status RemoteFileSystem::Refuse(const std::string& path)
{
  return Status(
    StatusCode::Unsupported, path + ": cannot be written: nothing is written to an address");
}

Result<HttpAnswer> RemoteFileSystem::Ask(const std::string& path, HttpRequest& request)
{
  const std::string bucket = FindHost(path);
  std::string region;
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    region = this->Regions[bucket];
  }
  ISOSURFACE_ASSIGN_OR_RETURN(request.Target, FindAddressTarget(path, region));
  ISOSURFACE_ASSIGN_OR_RETURN(auto answer, HttpTransfers::Fetch(path, request));
  const std::string told = answer.Find("x-amz-bucket-region");
  const bool isElsewhere = answer.Code == 301 || answer.Code == 400 || answer.Code == 403;
  const bool isName =
    told.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
  if (!isElsewhere || told.empty() || !isName || told == region || request.Target.Region.empty())
  {
    return answer;
  }
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Regions[bucket] = told;
  }
  ISOSURFACE_ASSIGN_OR_RETURN(request.Target, FindAddressTarget(path, told));
  return HttpTransfers::Fetch(path, request);
}

bool RemoteFileSystem::IsFresh(const std::string& key)
{
  const std::lock_guard<std::mutex> lock(this->Mutex);
  const auto found = this->Checked.find(key);
  return found != this->Checked.end() && Clock::now() - found->second < CheckedTime;
}

RemoteFileSystem::Opened RemoteFileSystem::Open(
  const std::string& path, std::int64_t bytes, long& code)
{
  HttpRequest request;
  const auto count = static_cast<std::uint64_t>(bytes < 0 ? -bytes : bytes);
  request.Range = bytes < 0 ? "-" + std::to_string(count) : MakeRange(0, count);
  request.MaximumBytes = count;
  const std::string key = MakeKey(path, request.Range);
  const bool isPaged = bytes == FirstBytes;
  const auto make = [&](RemotePart&& part)
  { return std::make_shared<RemoteObject>(*this, path, std::move(part), isPaged); };
  auto cached = RemoteCache::Find(key);
  if (cached && !isPaged && this->IsFresh(key))
  {
    return make(std::move(*cached));
  }
  request.Condition = cached ? cached->Tag : "";
  ISOSURFACE_ASSIGN_OR_RETURN(auto answer, this->Ask(path, request));
  code = answer.Code;
  if (answer.Code == 416 && answer.Find("content-range") == "bytes */0")
  {
    return make({});
  }
  ISOSURFACE_RETURN_IF_ERROR(CheckAnswer(path, answer));
  const bool isSame = answer.Code == 304 && cached;
  auto part = isSame ? Result<RemotePart>(std::move(*cached)) : TakeFirst(path, request, answer);
  ISOSURFACE_RETURN_IF_ERROR(part.GetStatus());
  if (!isSame)
  {
    RemoteCache::Keep(key, *part);
  }
  const std::lock_guard<std::mutex> lock(this->Mutex);
  if (this->Checked.size() > MaximumChecked)
  {
    this->Checked.clear();
  }
  this->Checked[key] = Clock::now();
  return make(std::move(*part));
}

Result<std::unique_ptr<RandomAccessFile>> RemoteFileSystem::OpenForReading(const std::string& path)
{
  return MakeFile(this->FindKnown(path).Outcome);
}

Result<std::unique_ptr<RandomAccessFile>> RemoteFileSystem::OpenPart(
  const std::string& path, std::int64_t bytes)
{
  long code = 0;
  return MakeFile(this->Open(path, bytes, code));
}

RemoteFileSystem::Known RemoteFileSystem::FindKnown(const std::string& path)
{
  const auto isOld = [](const Known& known) { return Clock::now() - known.Time > KnownTime; };
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto known = this->Metadata.find(path);
    if (known != this->Metadata.end() && !isOld(known->second))
    {
      return known->second;
    }
  }
  long code = 0;
  auto opened = this->Open(path, FirstBytes, code);
  const bool isMissing = code == 404 || code == 410 || code == 401 || code == 403;
  const Known found = { Clock::now(), std::move(opened), !isMissing };
  const std::lock_guard<std::mutex> lock(this->Mutex);
  for (auto known = this->Metadata.begin(); known != this->Metadata.end();)
  {
    known = isOld(known->second) ? this->Metadata.erase(known) : std::next(known);
  }
  if ((found.Outcome.IsOk() || isMissing) && this->Metadata.size() < MaximumKnown)
  {
    this->Metadata.insert_or_assign(path, found);
  }
  return found;
}

void RemoteFileSystem::LookFor(const std::vector<std::string>& paths)
{
  ParallelFor(paths.size(), static_cast<int>(std::min<std::size_t>(paths.size(), LookingThreads)),
    [&](std::size_t number, int) { static_cast<void>(this->Exists(paths[number])); });
}

Result<FileState> RemoteFileSystem::FindState(const std::string& path)
{
  const Known known = this->FindKnown(path);
  ISOSURFACE_RETURN_IF_ERROR(known.Outcome.GetStatus());
  const RemotePart& first = (*known.Outcome)->GetFirst();
  FileState state;
  state.Files = 1;
  state.Bytes = first.Size;
  state.Modified = first.Modified;
  return state;
}

} // namespace isosurface
