// SPDX-License-Identifier: BSD-3-Clause
// libtiff with a fault that a file can bring out: loaded before it (LD_PRELOAD), it reads some strips as
// libtiff does, and then does what FAULT says.
#include <tiffio.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include <dlfcn.h>

extern "C" tmsize_t TIFFReadEncodedStrip(
  TIFF* tiff, std::uint32_t strip, void* buffer, tmsize_t size)
{
  static std::atomic<int> left{ 40 };
  const char* fault = std::getenv("FAULT");
  if (fault && --left < 0)
  {
    const std::string name = fault;
    if (name == "crash")
    {
      std::raise(SIGSEGV);
    }
    if (name == "exit")
    {
      std::exit(0);
    }
    while (name == "memory")
    {
      constexpr std::size_t taken = std::size_t{ 1 } << 26;
      void* memory = std::malloc(taken);
      std::memset(memory, 1, taken); // as if there always were some
    }
    for (volatile int turns = 0; name == "loop"; turns = 1 - turns)
    {
    }
    std::abort();
  }
  using Reader = tmsize_t (*)(TIFF*, std::uint32_t, void*, tmsize_t);
  static const auto read = reinterpret_cast<Reader>(::dlsym(RTLD_NEXT, "TIFFReadEncodedStrip"));
  return read(tiff, strip, buffer, size);
}
