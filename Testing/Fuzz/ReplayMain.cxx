// SPDX-License-Identifier: BSD-3-Clause
// Runs a fuzz target on each file given, or in a folder given: what libFuzzer's own main does with
// a corpus, for compilers that do not have it.
#include "FuzzTarget.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace
{

bool Replay(const std::filesystem::path& path)
{
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> text{ std::istreambuf_iterator<char>(file), {} };
  if (!file)
  {
    std::fprintf(stderr, "%s cannot be read\n", path.c_str());
    return false;
  }
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);
  // A copy of its own size, so that a read behind its end is seen.
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  return LLVMFuzzerTestOneInput(bytes.data(), bytes.size()) == 0;
}

} // namespace

int main(int argc, char* argv[])
{
  int replayed = 0;
  for (int argument = 1; argument < argc; ++argument)
  {
    std::vector<std::filesystem::path> paths;
    if (std::filesystem::is_directory(argv[argument]))
    {
      for (const auto& entry : std::filesystem::directory_iterator(argv[argument]))
      {
        paths.push_back(entry.path());
      }
    }
    else
    {
      paths.emplace_back(argv[argument]);
    }
    for (const std::filesystem::path& path : paths)
    {
      if (!Replay(path))
      {
        return 1;
      }
      ++replayed;
    }
  }
  if (replayed == 0)
  {
    std::fprintf(stderr, "Usage: %s <file or folder>...\n", argv[0]);
    return 2;
  }
  std::printf("%d inputs\n", replayed);
  return 0;
}
