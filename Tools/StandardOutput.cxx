// SPDX-License-Identifier: BSD-3-Clause
#include "StandardOutput.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

namespace isosurface
{

Status FlushStandardOutput()
{
  const std::string reason =
    std::fflush(stdout) != 0 ? std::strerror(errno) : "a part of it was lost";
  return std::ferror(stdout) != 0
    ? Status(StatusCode::IoError, "cannot write to standard output: " + reason)
    : Status::Ok();
}

} // namespace isosurface
