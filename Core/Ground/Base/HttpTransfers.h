// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HttpTransfers_h
#define isosurface_HttpTransfers_h

#include "Ground/Base/Address.h"
#include "Ground/Base/Status.h"

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace isosurface
{

/// A request for an object, or for bytes of it.
struct HttpRequest
{
  AddressTarget Target;
  std::string Range;              ///< "0-99", or "-20", the last ones; empty: all
  std::uint64_t MaximumBytes = 0; ///< of the body
  std::string Condition;          ///< a line of the header, "If-None-Match: ..."; or empty
  bool IsPublic = false;          ///< whether private addresses are refused
};

/// What a server answers.
struct HttpAnswer
{
  long Code = 0;
  std::map<std::string, std::string> Headers; ///< by their names in lower case
  std::vector<std::uint8_t> Body;
  bool IsCut = false;     ///< whether the body has more bytes than are wanted
  bool IsPrivate = false; ///< whether the server is of this machine or its network
  std::string Redirect;   ///< where the object is instead; or empty

  /// The value of a header; "" if there is none.
  std::string Find(const std::string& name) const
  {
    const auto found = this->Headers.find(name);
    return found == this->Headers.end() ? std::string() : found->second;
  }
};

/**
 * Asks servers by HTTP, in parallel: a bounded number of requests and of bytes, over connections that stay
 * open. Broken connections and the codes 429 and 5xx are tried again, later and later; a server that
 * stalls, once. Redirections are followed a few times, to http and https alone, never from a public
 * server to a private one, nor from https to http.
 */
class HttpTransfers
{
public:
  /// Waits for the answer, which may have any code. Any thread may call it. `name`: the address, for
  /// errors. Errors: IoError, Unsupported; Aborted (ReadingStop).
  static Result<HttpAnswer> Fetch(const std::string& name, HttpRequest request);
  /// Of names that are `prefix`, or are behind it and a slash: the bytes of the bodies that this process fetches from
  /// now on, by any thread.
  static std::shared_ptr<const std::atomic<std::uint64_t>> CountBytesOf(const std::string& prefix);
};

} // namespace isosurface

#endif
