// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_FileSizeLimit_h
#define isosurface_FileSizeLimit_h

#include <sys/resource.h>

#include <csignal>

namespace isosurface
{

/// While it lives, files of this process cannot grow beyond some bytes: as on a disk that is full.
class FileSizeLimit
{
public:
  static constexpr rlim_t Unlimited = RLIM_INFINITY;

  explicit FileSizeLimit(rlim_t bytes)
  {
    // Without a handler the process would be killed instead of told.
    this->OldHandler = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &this->Old);
    rlimit limit = this->Old;
    limit.rlim_cur = bytes < this->Old.rlim_max ? bytes : this->Old.rlim_max;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit()
  {
    setrlimit(RLIMIT_FSIZE, &this->Old);
    std::signal(SIGXFSZ, this->OldHandler);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
  rlimit Old{};
  void (*OldHandler)(int) = nullptr;
};

} // namespace isosurface

#endif
