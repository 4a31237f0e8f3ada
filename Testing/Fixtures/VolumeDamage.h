// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VolumeDamage_h
#define isosurface_VolumeDamage_h

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace isosurface
{

/// One way to spoil a blocked volume of one or more stores, and what has to be said about it.
struct VolumeDamage
{
  std::string Name;
  std::function<void(const std::string& volumePath)> Apply;
  std::string File;       ///< a part of the path that the message must have
  std::string Reason;     ///< a part of the message
  bool IsOfIndex = false; ///< only queries notice it, not who reads all blocks
};
std::ostream& operator<<(std::ostream& stream, const VolumeDamage& damage);

/// Missing, truncated and altered headers, stores, directories, trees and blocks, newer versions.
/// Stores other than the first are left alone.
std::vector<VolumeDamage> MakeDamages();

/**
 * Whether the messages of an algorithm, or of several ones, are a single one that names file and
 * reason.
 */
bool IsOneMessageAbout(const std::vector<std::string>& messages, const VolumeDamage& damage);

} // namespace isosurface

#endif
