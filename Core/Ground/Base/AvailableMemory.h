// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_AvailableMemory_h
#define isosurface_AvailableMemory_h

#include <cstdint>

namespace isosurface
{

/// The bytes that this node can still give to programs without swapping; 0 if the system does not
/// tell (it is not Linux).
std::uint64_t GetAvailableMemory();

} // namespace isosurface

#endif
