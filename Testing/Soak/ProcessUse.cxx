// SPDX-License-Identifier: BSD-3-Clause
#include "ProcessUse.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>

namespace isosurface
{

ProcessUse MeasureUse(const std::string& folder)
{
  namespace fs = std::filesystem;
  ProcessUse use;
  const std::string below = fs::absolute(folder).lexically_normal().string();
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc/self/fd"))
  {
    std::error_code error;
    const std::string path = fs::read_symlink(entry.path(), error).string();
    use.Files += !error && path.compare(0, below.size(), below) == 0 ? 1 : 0;
  }
  const fs::directory_iterator threads("/proc/self/task");
  use.Threads = static_cast<std::size_t>(std::distance(begin(threads), end(threads)));
  std::size_t total = 0;
  std::size_t resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  use.Mebibytes = resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) >> 20;
  return use;
}

} // namespace isosurface
