// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Base/AvailableMemory.h"

#include <fstream>
#include <new>
#include <optional>
#include <string>

namespace isosurface
{
namespace
{

/// What is called MemAvailable in a file of lines "name: number kB".
std::optional<std::uint64_t> ReadAvailable(const std::string& path)
{
  std::ifstream file(path);
  std::string name;
  std::uint64_t kibibytes = 0;
  std::string unit;
  while (file >> name >> kibibytes)
  {
    if (name == "MemAvailable:")
    {
      return kibibytes << 10;
    }
    std::getline(file, unit);
  }
  return {};
}

} // namespace

std::uint64_t GetAvailableMemory()
{
  try
  {
    return ReadAvailable("/proc/meminfo").value_or(0);
  }
  catch (const std::bad_alloc&)
  {
    return 1; // not even enough to ask
  }
}

} // namespace isosurface
