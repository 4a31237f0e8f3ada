// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_EnumeratorNames_h
#define isosurface_EnumeratorNames_h

#include <cstdint>
#include <optional>
#include <string>

namespace isosurface
{

/**
 * The enumerator of a name; nothing if there is none. Enumerators are numbered from 0; `getName`
 * returns null for numbers that none has. It is a switch without a default case, so the compiler
 * names an enumerator that it misses.
 */
template <typename Enumeration>
std::optional<Enumeration> FindEnumerator(
  const std::string& name, const char* (*getName)(Enumeration))
{
  for (std::uint8_t number = 0;; ++number)
  {
    const auto enumerator = static_cast<Enumeration>(number);
    const char* const known = getName(enumerator);
    if (!known)
    {
      return std::nullopt;
    }
    if (name == known)
    {
      return enumerator;
    }
  }
}

/// All names with a separator between them.
template <typename Enumeration>
std::string ListEnumerators(const char* (*getName)(Enumeration), const std::string& separator)
{
  std::string names;
  for (std::uint8_t number = 0;; ++number)
  {
    const char* const name = getName(static_cast<Enumeration>(number));
    if (!name)
    {
      return names;
    }
    names += (names.empty() ? "" : separator) + name;
  }
}

} // namespace isosurface

#endif
