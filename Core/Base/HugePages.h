// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HugePages_h
#define isosurface_HugePages_h

#include <cstddef>

namespace isosurface
{

/**
 * Tells the system that a large piece of memory is about to be filled as a whole, so that it comes
 * in pages of megabytes: first touches by the thousand cost more than what is written. Without
 * effect for small pieces and where the system knows no such advice.
 */
void AdviseHugePages(void* memory, std::size_t size);

} // namespace isosurface

#endif
