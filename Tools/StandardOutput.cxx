// SPDX-License-Identifier: BSD-3-Clause
#include "StandardOutput.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace isosurface
{

void OpenStandardStreams()
{
  // The lowest free number is taken.
  int number = 0;
  do
  {
    number = ::open("/dev/null", O_RDWR);
  } while (number >= 0 && number <= STDERR_FILENO);
  if (number >= 0)
  {
    ::close(number);
  }
}

Status FlushStandardOutput()
{
  const std::string reason =
    std::fflush(stdout) != 0 ? std::strerror(errno) : "a part of it was lost";
  return std::ferror(stdout) != 0
    ? Status(StatusCode::IoError, "cannot write to standard output: " + reason)
    : Status::Ok();
}

} // namespace isosurface
