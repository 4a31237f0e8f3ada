// SPDX-License-Identifier: BSD-3-Clause
#include "DrawingBudget.h"

#include <utility>

namespace isosurface
{
namespace
{

std::unique_ptr<DrawingBudget> CurrentBudget;

} // namespace

DrawingBudget::DrawingBudget(double seconds)
  : End(std::chrono::steady_clock::now() +
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(seconds)))
{
}

DrawingBudget* DrawingBudget::GetCurrent()
{
  return CurrentBudget.get();
}

void DrawingBudget::SetCurrent(std::unique_ptr<DrawingBudget> budget)
{
  CurrentBudget = std::move(budget);
}

double DrawingBudget::GetSecondsLeft() const
{
  return std::chrono::duration<double>(this->End - std::chrono::steady_clock::now()).count();
}

} // namespace isosurface
