// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_ProgressDisplay_h
#define isosurface_ProgressDisplay_h

#include "Ground/Base/Progress.h"

#include <chrono>
#include <string>

namespace isosurface
{

/**
 * Shows the progress of some work on standard error: a bar on a terminal, otherwise a line for
 * every tenth.
 */
class ProgressDisplay
{
public:
  /// `bytes`: of the whole work, to show bytes a second. Shows nothing if not `isShown`.
  ProgressDisplay(std::string name, double bytes, bool isShown);
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;
  /// Erases the bar.
  ~ProgressDisplay();

  /// A function that shows the share that is done, and returns false once a signal asked to stop
  /// (StopSignal.h). It must not outlive this object.
  Progress GetProgress();

  double GetSeconds() const;
  /// Ends the display before something else is printed.
  void Clear();

private:
  void Show(double share);

  std::string Name;
  double Bytes;
  bool IsShown;
  bool IsTerminal;
  bool IsDrawn = false;
  int ToldTenths = 0;
  double LastDrawn = -1;
  std::chrono::steady_clock::time_point Begin = std::chrono::steady_clock::now();
};

} // namespace isosurface

#endif
