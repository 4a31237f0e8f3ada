// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Hdf5Walk_h
#define isosurface_Hdf5Walk_h

#include "Formats/Hdf5/Hdf5LinkedFiles.h"

#include <cstddef>
#include <functional>
#include <set>
#include <string>

namespace isosurface
{

/**
 * Goes through the groups of a file, by name. Each group is opened from the one around it: the
 * library would look up every path from the start, which takes minutes for thousands of groups in
 * one another. The lock is held.
 */
class Hdf5Walk
{
public:
  static constexpr std::size_t MaximumDepth = 32; ///< of groups in one another
  /// Has a dataset, and its path. An error ends the walk.
  using Visitor = std::function<Status(const Hdf5Handle& dataset, const std::string& path)>;

  /// Visits each dataset once, whatever the cycles, and no other file. What is deeper than
  /// MaximumDepth, or behind the first 10,000 objects, is left out.
  static Status VisitOnce(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit);
  /// Visits each dataset by every path, through all links: as a program does that knows no cycles.
  /// Error: what is refused, of which that program has to be kept away; it begins with a path.
  static Status VisitAll(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit);

private:
  Hdf5Walk(Hdf5LinkedFiles& links, const Visitor& visit, bool isOnce)
    : Links(links)
    , Visit(visit)
    , IsOnce(isOnce)
  {
  }

  static herr_t Enter(hid_t group, const char* name, const H5L_info_t* info, void* walk);
  Status EnterGroup(const Hdf5Handle& group);
  Status EnterObject(hid_t group, const std::string& name, H5L_type_t link);
  Status EnterKind(hid_t group, const std::string& name, H5O_type_t kind);
  Status MakeError(StatusCode code, const std::string& reason) const;

  Hdf5LinkedFiles& Links;
  const Visitor& Visit;
  bool IsOnce;
  std::size_t Objects = 0;
  std::size_t Depth = 0;
  std::string Path;
  std::set<haddr_t> Known; ///< addresses of objects
  Status Outcome = Status::Ok();
};

} // namespace isosurface

#endif
