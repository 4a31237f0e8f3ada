// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ReaderCrash_h
#define isosurface_ReaderCrash_h

#include <string>

namespace isosurface
{

/**
 * While it lives, a crash of the process (a segmentation fault, an abort) is told as that of a
 * reader of another library, with the file, before the process ends as it would have without. Such
 * readers may trust what a file says; this is what can be done about it in the same process. One at
 * a time.
 */
class ReaderCrash
{
public:
  /// `message`: what to print, a line.
  explicit ReaderCrash(const std::string& message);
  ReaderCrash(const ReaderCrash&) = delete;
  ReaderCrash& operator=(const ReaderCrash&) = delete;
  ~ReaderCrash();
};

} // namespace isosurface

#endif
