// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_Require_h
#define isosurface_Testing_Require_h

#include "Ground/Base/Status.h"

#include <stdexcept>
#include <utility>

namespace isosurface
{

/// The value of a result. An error ends the test, which reports it: GoogleTest catches what is
/// thrown. In a thread that a test starts it ends the program.
template <typename T>
T Require(Result<T> result)
{
  if (!result.IsOk())
  {
    throw std::runtime_error(result.GetStatus().GetMessage());
  }
  return std::move(*result);
}

} // namespace isosurface

#endif
