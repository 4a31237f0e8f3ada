// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_FuzzTarget_h
#define isosurface_Testing_FuzzTarget_h

#include <cstddef>
#include <cstdint>

/// What libFuzzer, or the replaying program, calls with each input. Returns 0.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace isosurface
{

/// Ends the program with the claim if it does not hold, which a fuzzer takes for a crash.
void Require(bool holds, const char* claim);

/**
 * Ends the program if, while it lives, more than `limit` bytes are allocated at a time beyond what
 * was allocated before. It sees allocations only where AddressSanitizer tells of them; otherwise it
 * does nothing. One at a time.
 */
class MemoryLimit
{
public:
  explicit MemoryLimit(std::size_t limit);
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit();
};

} // namespace isosurface

#endif
