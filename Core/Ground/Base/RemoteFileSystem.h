// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RemoteFileSystem_h
#define isosurface_RemoteFileSystem_h

#include "Ground/Base/FileSystem.h"
#include "Ground/Base/RemoteCache.h"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace isosurface
{

struct HttpAnswer;
struct HttpRequest;
class RemoteObject;

/**
 * Objects on the web, by their addresses (IsAddress): they are read, and neither written nor listed. Bytes
 * are fetched by ranges (HttpTransfers) and kept in a cache on disk (RemoteCache), whose parts are asked for
 * anew, and sent only if they are others. Errors name address and reason: NotFound (404), IoError (403, a
 * network that fails), Corrupt (truncated, a page of HTML, changed since it was opened), Unsupported (a
 * server without ranges).
 *
 * For a few seconds, what metadata were, or that there are none, is not asked again.
 */
class RemoteFileSystem : public FileSystem
{
public:
  static RemoteFileSystem& Get();

  Result<std::unique_ptr<RandomAccessFile>> OpenForReading(const std::string& path) override;
  Result<std::unique_ptr<RandomAccessFile>> OpenPart(
    const std::string& path, std::int64_t bytes) override;
  void LookFor(const std::vector<std::string>& paths) override;
  /// Whatever fails is told by whoever opens it; but what is denied (403) may be missing.
  bool Exists(const std::string& path) override { return this->FindKnown(path).IsThere; }
  Result<std::vector<std::string>> List(const std::string&) override
  {
    return std::vector<std::string>();
  }
  Result<FileState> FindState(const std::string& path) override;

  Result<std::unique_ptr<WritableFile>> CreateForWriting(const std::string& path) override
  {
    return Refuse(path);
  }
  Status Rename(const std::string&, const std::string& to) override { return Refuse(to); }
  Status MakeDirectories(const std::string& path) override { return Refuse(path); }
  Status RemoveAll(const std::string& path) override { return Refuse(path); }
  Status SyncDirectory(const std::string& path) override { return Refuse(path); }

private:
  using Clock = std::chrono::steady_clock;
  using Opened = Result<std::shared_ptr<RemoteObject>>;
  struct Known
  {
    Clock::time_point Time;
    Opened Outcome;
    bool IsThere = false; ///< or cannot be told
  };

  static Status Refuse(const std::string& path);
  /// The object with its first bytes, or with its last ones. `code`: the server's answer.
  Opened Open(const std::string& path, std::int64_t bytes, long& code);
  Known FindKnown(const std::string& path);
  /// The answer to a request for bytes of an object, of whatever region and with whatever keys it needs.
  Result<HttpAnswer> Ask(const std::string& path, HttpRequest& request);
  bool IsFresh(const std::string& key);

  friend class RemoteObject;
  std::mutex Mutex;
  std::map<std::string, Known> Metadata;
  std::map<std::string, Clock::time_point>
    Checked;                                  ///< parts of the cache that the server has confirmed
  std::map<std::string, std::string> Regions; ///< of buckets
};

} // namespace isosurface

#endif
