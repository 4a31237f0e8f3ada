// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_WithinMemory_h
#define isosurface_WithinMemory_h

#include "Ground/Base/Status.h"

#include <new>
#include <stdexcept>
#include <string>

namespace isosurface
{

/// Runs a step. That there is not enough memory for it is an error like others, so that all ranks
/// can be told: `path`, then `reason`.
template <typename Step>
auto RunWithinMemory(const std::string& path, const char* reason, const Step& step)
  -> decltype(step())
{
  try
  {
    return step();
  }
  catch (const std::bad_alloc&)
  {
    return Status(StatusCode::OutOfMemory, path + reason);
  }
  catch (const std::length_error&) // more than any memory has
  {
    return Status(StatusCode::OutOfMemory, path + reason);
  }
}

} // namespace isosurface

#endif
