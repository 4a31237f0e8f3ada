// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Stopwatch_h
#define isosurface_Stopwatch_h

#include <chrono>

namespace isosurface
{

/// Adds the seconds of its lifetime to a sum.
class Stopwatch
{
public:
  explicit Stopwatch(double& sum)
    : Sum(sum)
  {
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch()
  {
    this->Sum +=
      std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
  }

private:
  double& Sum;
  std::chrono::steady_clock::time_point Begin = std::chrono::steady_clock::now();
};

} // namespace isosurface

#endif
