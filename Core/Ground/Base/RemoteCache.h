// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RemoteCache_h
#define isosurface_RemoteCache_h

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Bytes that were fetched of an object.
struct RemotePart
{
  std::string
    Tag; ///< what tells a version of the object from others, a line of HTTP; perhaps empty
  std::uint64_t Size = 0;    ///< of the whole object
  std::int64_t Modified = 0; ///< FileState::Modified
  std::uint64_t Begin = 0;
  std::vector<std::uint8_t> Bytes;
};

/**
 * What was fetched, on disk, in a folder that processes share: $SCALABLE_ISOSURFACE_CACHE, or
 * scalable-isosurface in the user's cache folder. It has at most $SCALABLE_ISOSURFACE_CACHE_BYTES, 4 GiB
 * unless it says otherwise, none if that is 0; what was used last stays. A part is written beside its
 * place and renamed, and has a checksum: a crash leaves none that is half written.
 */
class RemoteCache
{
public:
  /// The folder; "" if the system tells none.
  static std::string FindFolder();

  /// `key`: the URL and which bytes of it.
  static std::optional<RemotePart> Find(const std::string& key);
  /// Errors are those of a cache: it keeps less.
  static void Keep(const std::string& key, const RemotePart& part);
};

} // namespace isosurface

#endif
