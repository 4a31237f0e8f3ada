// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/HttpTransfers.h"

#include "Ground/Base/CurlLibrary.h"
#include "Ground/Base/ReadingStop.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <iterator>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

namespace isosurface
{
namespace
{

using Curl = CurlLibrary;
using std::chrono::steady_clock;

constexpr std::size_t MaximumRunning = 32;
constexpr long ConnectionsOfHost = 16;
constexpr long KeptConnections = 64;
constexpr std::uint64_t MaximumRunningBytes = std::uint64_t{ 256 } << 20;
constexpr std::size_t MaximumHeaderBytes = std::size_t{ 1 } << 16;
/// Of answers that tell an error.
constexpr std::uint64_t MaximumErrorBytes = std::uint64_t{ 1 } << 14;
/// A server that gives no ranges sends small objects whole.
constexpr std::uint64_t MaximumWholeBytes = std::uint64_t{ 64 } << 20;
constexpr int MaximumTries = 4;
constexpr int MaximumRedirects = 5;
/// For so long, a host that cannot be reached is not asked again.
constexpr std::chrono::seconds HostPause{ 3 };

using ByteCounter = std::atomic<std::uint64_t>;

/// The counters of CountBytesOf that somebody has.
class ByteCounters
{
public:
  static ByteCounters& Get()
  {
    static ByteCounters& counters =
      *new ByteCounters; // threads that fetch ahead may outlive others
    return counters;
  }
  std::shared_ptr<ByteCounter> Add(const std::string& prefix)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    auto counter = std::make_shared<ByteCounter>(0);
    this->Counters.emplace_back(prefix, counter);
    return counter;
  }
  std::vector<std::shared_ptr<ByteCounter>> Find(const std::string& name)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    std::vector<std::shared_ptr<ByteCounter>> found;
    for (auto one = this->Counters.begin(); one != this->Counters.end();)
    {
      const std::shared_ptr<ByteCounter> counter = one->second.lock();
      const std::string& prefix = one->first;
      if (counter && name.compare(0, prefix.size(), prefix) == 0 &&
        (name.size() == prefix.size() || name[prefix.size()] == '/'))
      {
        found.push_back(counter);
      }
      one = counter ? std::next(one) : this->Counters.erase(one);
    }
    return found;
  }

private:
  std::mutex Mutex;
  std::vector<std::pair<std::string, std::weak_ptr<ByteCounter>>> Counters;
};

/// The seconds without a byte after which a server stalls.
long GetStallSeconds()
{
  const char* const text =
    std::getenv("SCALABLE_ISOSURFACE_STALL"); // NOLINT(concurrency-mt-unsafe)
  const long seconds = text ? std::strtol(text, nullptr, 10) : 0;
  return seconds > 0 ? seconds : 20;
}

/// A request on its way. The thread of the transfers alone uses it until it IsDone.
struct Transfer
{
  HttpRequest Request;
  HttpAnswer Answer;
  std::vector<std::shared_ptr<ByteCounter>> Counters; ///< of the body
  void* Easy = nullptr;
  void* Lines = nullptr;
  std::array<char, 256> ErrorText{}; ///< as long as libcurl's
  std::size_t HeaderBytes = 0;
  std::uint64_t Limit = 0; ///< of the body, known with the first byte of it
  int Code = 0;            ///< of libcurl
  bool IsFlood = false;
  bool IsRefused = false;  ///< whether a private address is not followed
  bool IsUnsigned = false; ///< whether libcurl cannot sign it
  bool IsConnected = false;
  bool IsDone = false;
  std::atomic<bool> IsDropped = false;
};

std::size_t TakeHeader(char* text, std::size_t size, std::size_t count, void* user)
{
  auto& transfer = *static_cast<Transfer*>(user);
  std::string line(text, size * count);
  transfer.HeaderBytes += line.size();
  transfer.IsFlood = transfer.HeaderBytes > MaximumHeaderBytes;
  if (line.compare(0, 5, "HTTP/") == 0)
  {
    transfer.Answer.Headers.clear();
  }
  const std::size_t colon = line.find(':');
  if (colon != std::string::npos)
  {
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(),
      [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    const std::size_t end = line.find_last_not_of(" \t\r\n") + 1;
    transfer.Answer.Headers[name] = begin < end ? line.substr(begin, end - begin) : "";
  }
  return transfer.IsFlood ? 0 : size * count;
}

/// How many bytes of the body are taken.
std::uint64_t FindBodyLimit(const Transfer& transfer)
{
  const long code = transfer.Answer.Code;
  const std::uint64_t wanted = transfer.Request.MaximumBytes;
  return code != 200 && code != 206                  ? MaximumErrorBytes
    : code == 200 && !transfer.Request.Range.empty() ? std::max(wanted, MaximumWholeBytes)
                                                     : wanted;
}

std::size_t TakeBody(const Curl& curl, Transfer& transfer, const char* bytes, std::size_t size)
{
  HttpAnswer& answer = transfer.Answer;
  if (answer.Body.empty())
  {
    static_cast<void>(curl.EasyGetInformation(transfer.Easy, Curl::ResponseCode, &answer.Code));
    transfer.Limit = FindBodyLimit(transfer);
    const std::string length = answer.Find("content-length");
    if (answer.Code == 200 && std::strtoull(length.c_str(), nullptr, 10) > transfer.Limit)
    {
      answer.IsCut = true;
      return 0;
    }
  }
  const std::uint64_t room =
    transfer.Limit - std::min<std::uint64_t>(transfer.Limit, answer.Body.size());
  answer.IsCut = size > room;
  const std::size_t taken = answer.IsCut ? static_cast<std::size_t>(room) : size;
  answer.Body.insert(answer.Body.end(), bytes, bytes + taken);
  for (const std::shared_ptr<ByteCounter>& counter : transfer.Counters)
  {
    *counter += taken;
  }
  return answer.IsCut ? 0 : size;
}

int OpenSocket(void* user, int /*purpose*/, Curl::SocketAddress* address)
{
  auto& transfer = *static_cast<Transfer*>(user);
  if (transfer.Request.IsPublic && IsPrivateAddress(address->Address))
  {
    transfer.IsRefused = true;
    return -1;
  }
  return ::socket(address->Family, address->Type | SOCK_CLOEXEC, address->Protocol);
}

/// The thread of all transfers, and what waits for it.
class TransferThread
{
public:
  explicit TransferThread(const Curl& curl)
    : Library(curl)
    , Multi(curl.MultiInit())
  {
    static_cast<void>(
      curl.MultiSetOption(this->Multi, Curl::MaximumHostConnections, ConnectionsOfHost));
    static_cast<void>(curl.MultiSetOption(this->Multi, Curl::MaximumConnections, KeptConnections));
    std::thread([this] { this->Run(); }).detach();
  }

  /// Waits for the end of a transfer; false if the calling thread is to stop.
  bool Wait(const std::shared_ptr<Transfer>& transfer)
  {
    std::unique_lock<std::mutex> lock(this->Mutex);
    this->Queue.push_back(transfer);
    static_cast<void>(this->Library.MultiWakeUp(this->Multi));
    while (!transfer->IsDone)
    {
      constexpr std::chrono::milliseconds pause{ 100 };
      this->Ended.wait_for(lock, pause);
      if (!transfer->IsDone && ReadingStop::IsWanted())
      {
        transfer->IsDropped = true;
        static_cast<void>(this->Library.MultiWakeUp(this->Multi));
        return false;
      }
    }
    return true;
  }

  /// Ends the thread before what libcurl uses is cleared away at the end of the process.
  void Stop()
  {
    constexpr std::chrono::seconds longest{ 2 };
    std::unique_lock<std::mutex> lock(this->Mutex);
    this->IsStopping = true;
    static_cast<void>(this->Library.MultiWakeUp(this->Multi));
    this->Ended.wait_for(lock, longest, [this] { return this->HasStopped; });
  }

private:
  bool IsToStop()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->HasStopped = this->IsStopping;
    if (this->HasStopped)
    {
      this->Ended.notify_all();
    }
    return this->HasStopped;
  }

  void Run()
  {
    while (!this->IsToStop())
    {
      this->StartWaiting();
      int running = 0;
      static_cast<void>(this->Library.MultiPerform(this->Multi, &running));
      int left = 0;
      while (const Curl::Message* const message = this->Library.MultiRead(this->Multi, &left))
      {
        if (message->Kind == Curl::MessageDone)
        {
          this->Finish(message->Easy, message->Data.Result);
        }
      }
      this->EndDropped();
      constexpr int pause = 1000; // ms
      static_cast<void>(this->Library.MultiPoll(this->Multi, nullptr, 0, pause, nullptr));
    }
  }

  void StartWaiting()
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    while (!this->Queue.empty() && this->Running.size() < MaximumRunning &&
      (this->Running.empty() ||
        this->Bytes + this->Queue.front()->Request.MaximumBytes <= MaximumRunningBytes))
    {
      const std::shared_ptr<Transfer> transfer = this->Queue.front();
      this->Queue.pop_front();
      if (transfer->IsDropped)
      {
        continue;
      }
      transfer->Easy = this->Library.EasyInit();
      this->SetOptions(*transfer);
      this->Bytes += transfer->Request.MaximumBytes;
      static_cast<void>(this->Library.MultiAdd(this->Multi, transfer->Easy));
      this->Running.insert(transfer);
    }
  }

  template <typename Value>
  void Set(Transfer& transfer, Curl::Option option, Value value)
  {
    static_cast<void>(this->Library.EasySetOption(transfer.Easy, option, value));
  }

  void SetOptions(Transfer& transfer)
  {
    const AddressTarget& target = transfer.Request.Target;
    constexpr long connectSeconds = 15;
    this->Set(transfer, Curl::Url, target.Url.c_str());
    this->Set(transfer, Curl::Protocols, Curl::HttpAndHttps);
    this->Set(transfer, Curl::NoSignal, 1L);
    this->Set(transfer, Curl::ErrorBuffer, transfer.ErrorText.data());
    this->Set(transfer, Curl::ConnectTimeout, connectSeconds);
    this->Set(transfer, Curl::LowSpeedLimit, 1L);
    this->Set(transfer, Curl::LowSpeedTime, GetStallSeconds());
    this->Set(transfer, Curl::UserAgent, "scalable-isosurface");
    this->Set(transfer, Curl::HeaderFunction, &TakeHeader);
    this->Set(transfer, Curl::HeaderData, &transfer);
    this->Set(transfer, Curl::WriteFunction, &TransferThread::Write);
    this->Set(transfer, Curl::WriteData, &transfer);
    this->Set(transfer, Curl::OpenSocketFunction, &OpenSocket);
    this->Set(transfer, Curl::OpenSocketData, &transfer);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody sets it meanwhile
    if (const char* const certificates = std::getenv("SSL_CERT_FILE"))
    {
      this->Set(transfer, Curl::Certificates, certificates);
    }
    this->Set(transfer, Curl::PipeWait, target.Url.compare(0, 6, "https:") == 0 ? 1L : 0L);
    if (!transfer.Request.Range.empty())
    {
      this->Set(transfer, Curl::RangeOfBytes, transfer.Request.Range.c_str());
    }
    if (!transfer.Request.Condition.empty())
    {
      transfer.Lines = this->Library.ListAppend(transfer.Lines, transfer.Request.Condition.c_str());
    }
    if (!target.Key.empty())
    {
      const std::string signing = "aws:amz:" + target.Region + ":s3";
      this->Set(transfer, Curl::UserName, target.Key.c_str());
      this->Set(transfer, Curl::Password, target.Secret.c_str());
      if (!target.Token.empty())
      {
        transfer.Lines = this->Library.ListAppend(
          transfer.Lines, ("x-amz-security-token: " + target.Token).c_str());
      }
      if (this->Library.EasySetOption(transfer.Easy, Curl::SignatureV4, signing.c_str()) != 0)
      {
        transfer.IsUnsigned = true;
        this->Set(transfer, Curl::Url, ""); // nothing is sent
      }
    }
    this->Set(transfer, Curl::HttpHeader, transfer.Lines);
  }

  static std::size_t Write(char* bytes, std::size_t size, std::size_t count, void* user);

  void Finish(void* easy, int code)
  {
    const auto found = std::find_if(this->Running.begin(), this->Running.end(),
      [easy](const std::shared_ptr<Transfer>& one) { return one->Easy == easy; });
    const std::shared_ptr<Transfer> transfer = *found;
    HttpAnswer& answer = transfer->Answer;
    transfer->Code = code;
    char* redirect = nullptr;
    char* server = nullptr;
    static_cast<void>(this->Library.EasyGetInformation(easy, Curl::ResponseCode, &answer.Code));
    static_cast<void>(this->Library.EasyGetInformation(easy, Curl::RedirectUrl, &redirect));
    static_cast<void>(this->Library.EasyGetInformation(easy, Curl::PrimaryIp, &server));
    answer.Redirect = redirect ? redirect : "";
    transfer->IsConnected = server && *server;
    answer.IsPrivate = server && IsPrivateAddress(std::string(server));
    transfer->IsRefused = transfer->IsRefused || (transfer->Request.IsPublic && answer.IsPrivate);
    this->End(found);
    const std::lock_guard<std::mutex> lock(this->Mutex);
    transfer->IsDone = true;
    this->Ended.notify_all();
  }

  void EndDropped()
  {
    for (auto one = this->Running.begin(); one != this->Running.end();)
    {
      const auto next = std::next(one);
      if ((*one)->IsDropped)
      {
        this->End(one);
      }
      one = next;
    }
  }

  void End(std::set<std::shared_ptr<Transfer>>::iterator one)
  {
    Transfer& transfer = **one;
    static_cast<void>(this->Library.MultiRemove(this->Multi, transfer.Easy));
    this->Library.EasyCleanup(transfer.Easy);
    this->Library.ListFree(transfer.Lines);
    this->Bytes -= transfer.Request.MaximumBytes;
    this->Running.erase(one);
  }

  const Curl& Library;
  void* Multi;
  std::mutex Mutex; ///< of Queue, of what IsDone, and of these
  bool IsStopping = false;
  bool HasStopped = false;
  std::condition_variable Ended;
  std::deque<std::shared_ptr<Transfer>> Queue;
  std::set<std::shared_ptr<Transfer>> Running; ///< the thread's
  std::uint64_t Bytes = 0;                     ///< that the running ones may have
};

/// The thread of this process. A process that is forked has none of its parent's.
Result<TransferThread*> GetTransferThread()
{
  static std::mutex mutex;
  static TransferThread* thread = nullptr;
  static pid_t owner = 0;
  ISOSURFACE_ASSIGN_OR_RETURN(const auto curl, Curl::Load());
  const std::lock_guard<std::mutex> lock(mutex);
  if (owner != ::getpid())
  {
    // Behind the functions that libcurl's libraries have called at the end, so called before them.
    static_cast<void>(std::atexit(
      []
      {
        if (owner == ::getpid())
        {
          thread->Stop();
        }
      }));
    thread = new TransferThread(*curl); // never destroyed: the process may end while it waits
    owner = ::getpid();
  }
  return thread;
}

std::size_t TransferThread::Write(char* bytes, std::size_t size, std::size_t count, void* user)
{
  const auto curl = Curl::Load();
  return TakeBody(**curl, *static_cast<Transfer*>(user), bytes, size * count);
}

/// Hosts that could not be reached, when, and why.
class LostHosts
{
public:
  static LostHosts& Get()
  {
    static LostHosts& hosts = *new LostHosts; // threads that fetch ahead may outlive others
    return hosts;
  }
  void Add(const std::string& host, const std::string& reason)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Hosts[host] = { steady_clock::now(), reason };
  }
  /// Why a host cannot be reached; "" if it perhaps can.
  std::string Find(const std::string& host)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    const auto found = this->Hosts.find(host);
    return found != this->Hosts.end() && steady_clock::now() - found->second.first < HostPause
      ? found->second.second
      : std::string();
  }

private:
  std::mutex Mutex;
  std::map<std::string, std::pair<steady_clock::time_point, std::string>> Hosts;
};

/// Waits; false if the calling thread is to stop.
bool Pause(std::chrono::milliseconds duration)
{
  const auto end = steady_clock::now() + duration;
  while (steady_clock::now() < end && !ReadingStop::IsWanted())
  {
    constexpr std::chrono::milliseconds step{ 20 };
    std::this_thread::sleep_for(step);
  }
  return !ReadingStop::IsWanted();
}

/// Why a transfer gave no answer; "" if it gave one.
std::string FindFault(const Curl& curl, const Transfer& transfer)
{
  if (transfer.IsUnsigned)
  {
    return std::string("this system's ") + curl.Version() + " signs no requests; 7.75 does";
  }
  if (transfer.IsFlood)
  {
    return "the server sends a header without an end";
  }
  if (transfer.IsRefused)
  {
    return "a public server redirects to a private address, which is not followed";
  }
  if (transfer.Code == 0 || (transfer.Answer.IsCut && transfer.Code == Curl::WriteError))
  {
    return {};
  }
  return transfer.Code == Curl::PartialBody ? "truncated: the connection ended before the data did"
    : transfer.Code == Curl::TimedOut && transfer.Answer.Code == 0 ? "the server does not answer"
    : transfer.Code == Curl::TimedOut                              ? "the server stalls"
    : transfer.ErrorText[0] != '\0' ? std::string(transfer.ErrorText.data())
                                    : std::string(curl.EasyError(transfer.Code));
}

bool IsBusy(long code)
{
  return code == 429 || code == 500 || code == 502 || code == 503 || code == 504;
}

/// One request, perhaps tried several times.
Result<HttpAnswer> FetchOne(const std::string& name, const HttpRequest& request)
{
  const auto fail = [&name](const std::string& reason)
  { return Status(StatusCode::IoError, name + ": cannot be read: " + reason); };
  const auto curl = Curl::Load();
  const auto thread = GetTransferThread();
  if (!thread.IsOk())
  {
    return Status(
      thread.GetStatus().GetCode(), name + ": cannot be read: " + thread.GetStatus().GetMessage());
  }
  const std::string host = FindHost(request.Target.Url);
  if (const std::string lost = LostHosts::Get().Find(host); !lost.empty())
  {
    return fail(lost);
  }
  int stalls = 0;
  for (int tries = 1;; ++tries)
  {
    const auto transfer = std::make_shared<Transfer>();
    transfer->Request = request;
    transfer->Counters = ByteCounters::Get().Find(name);
    if (!(*thread)->Wait(transfer))
    {
      return Status(StatusCode::Aborted, name + ": reading was stopped");
    }
    const std::string fault = FindFault(**curl, *transfer);
    HttpAnswer& answer = transfer->Answer;
    if (fault.empty() && !IsBusy(answer.Code))
    {
      return std::move(answer);
    }
    stalls += transfer->Code == Curl::TimedOut ? 1 : 0;
    const bool isFinal = transfer->IsUnsigned || transfer->IsFlood || transfer->IsRefused ||
      transfer->Code == Curl::UnknownHost || transfer->Code == Curl::UntrustedServer;
    if (tries == MaximumTries || stalls > 1 || isFinal)
    {
      const bool isUntrusted = transfer->Code == Curl::UntrustedServer;
      if ((!transfer->IsConnected || isUntrusted) && !transfer->IsRefused)
      {
        LostHosts::Get().Add(host, fault);
      }
      return fail(!fault.empty() ? fault
                                 : "the server answers " + std::to_string(answer.Code) + ", " +
            std::to_string(tries) + " times");
    }
    constexpr std::chrono::milliseconds shortest{ 100 };
    constexpr long longest = 10; // seconds that a server may ask for
    const std::chrono::milliseconds later = shortest * (1 << (2 * (tries - 1)));
    const long asked = std::strtol(answer.Find("retry-after").c_str(), nullptr, 10);
    const std::chrono::seconds wanted{ asked < 0 ? 0 : asked > longest ? longest : asked };
    if (!Pause(later < wanted ? wanted : later))
    {
      return Status(StatusCode::Aborted, name + ": reading was stopped");
    }
  }
}

} // namespace

std::shared_ptr<const std::atomic<std::uint64_t>> HttpTransfers::CountBytesOf(
  const std::string& prefix)
{
  return ByteCounters::Get().Add(prefix);
}

Result<HttpAnswer> HttpTransfers::Fetch(const std::string& name, HttpRequest request)
{
  const auto refuse = [&name](const std::string& reason)
  { return Status(StatusCode::Unsupported, name + ": cannot be read: " + reason); };
  for (int redirects = 0; redirects <= MaximumRedirects; ++redirects)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto answer, FetchOne(name, request));
    if (answer.Redirect.empty() || answer.Code < 300 || answer.Code > 399)
    {
      return answer;
    }
    const std::string& to = answer.Redirect;
    const bool isSecret = request.Target.Url.compare(0, 6, "https:") == 0;
    if (to.compare(0, 8, "https://") != 0 && (isSecret || to.compare(0, 7, "http://") != 0))
    {
      return refuse("it redirects to " + HideQuery(to) + ", which is not followed");
    }
    if (FindHost(to) != FindHost(request.Target.Url))
    {
      request.IsPublic = request.IsPublic || !answer.IsPrivate;
      request.Target.Key.clear(); // is for the first host alone
    }
    request.Target.Url = to;
  }
  return refuse("its redirections do not end");
}

} // namespace isosurface
