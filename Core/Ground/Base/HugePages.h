// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_HugePages_h
#define isosurface_HugePages_h

#include <cstddef>

namespace isosurface
{

/**
 * Asks the system to back memory that is about to be filled by huge pages: thousands of page faults
 * would cost more than the writing itself. No effect on small blocks of memory, or where the system
 * has no huge pages.
 */
void AdviseHugePages(void* memory, std::size_t size);

} // namespace isosurface

#endif
