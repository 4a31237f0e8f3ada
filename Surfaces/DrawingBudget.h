// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DrawingBudget_h
#define isosurface_DrawingBudget_h

#include <chrono>
#include <memory>

namespace isosurface
{

/// The time left to draw the surfaces of an image that is not shown (vtkIsosurfaceMapper::BeginBudget).
class DrawingBudget
{
public:
  explicit DrawingBudget(double seconds);

  /// Of the image that is drawn; null if it has none.
  static DrawingBudget* GetCurrent();
  static void SetCurrent(std::unique_ptr<DrawingBudget> budget);

  double GetSecondsLeft() const;
  /// Whether all surfaces are in the image.
  bool IsFinished() const { return this->Finished; }
  /// Tells that a surface is not whole.
  void SetUnfinished() { this->Finished = false; }

private:
  std::chrono::steady_clock::time_point End;
  bool Finished = true;
};

} // namespace isosurface

#endif
