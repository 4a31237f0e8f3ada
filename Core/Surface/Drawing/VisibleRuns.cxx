// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/VisibleRuns.h"

#include <algorithm>

namespace isosurface
{
namespace
{

/// Of what was not drawn first, one in so many of all triangles are drawn between two looks at the
/// depths, or so many. Drawing fewer takes less time than looking.
constexpr std::size_t Portions = 12;
constexpr std::size_t SmallestPortion = 100000;

} // namespace

void VisibleRuns::Take(const TriangleMeasure& measure)
{
  this->Runs.assign(measure.ProperTriangles.size(), {});
  std::size_t first = 0;
  for (std::size_t run = 0; run < this->Runs.size(); ++run)
  {
    this->Runs[run].First = first;
    this->Runs[run].Count = measure.ProperTriangles[run];
    this->Runs[run].Bounds = measure.RunBounds[run];
    first += measure.ProperTriangles[run];
  }
}

void VisibleRuns::Begin(const BoxProjection& projection)
{
  for (Run& run : this->Runs)
  {
    run.Box = projection.Project(run.Bounds);
    run.IsWaiting = !run.Box.IsOutside && run.Count > 0;
    run.IsDrawn = false;
    run.WasVisible = run.WasVisible && run.IsWaiting;
  }
  this->BegunAnew = false;
}

std::vector<VisibleRuns::Range> VisibleRuns::FindFirst(const DepthPyramid& before)
{
  const auto isVisible = [](const Run& run) { return run.WasVisible; };
  if (std::none_of(this->Runs.begin(), this->Runs.end(), isVisible))
  {
    for (Run& run : this->Runs)
    {
      run.WasVisible = run.IsWaiting && !(run.Box.IsKnown && before.IsBehind(run.Box));
    }
  }
  return this->Draw(isVisible);
}

std::vector<VisibleRuns::Range> VisibleRuns::FindNext(const DepthPyramid& drawn)
{
  for (Run& run : this->Runs)
  {
    const bool isHidden = run.Box.IsOutside || (run.Box.IsKnown && drawn.IsBehind(run.Box));
    run.WasVisible = !isHidden && run.Count > 0;
    run.IsWaiting = run.IsWaiting && !isHidden;
  }
  const auto isNeeded = [](const Run& run) { return run.IsWaiting || run.IsDrawn; };
  const std::size_t needed = this->Count(isNeeded);
  // What was visible before tells nothing if it is but a quarter of what may be visible now.
  this->BegunAnew = 4 * this->CountDrawn() < needed;
  return this->BegunAnew ? this->Draw(isNeeded)
                         : this->DrawNearest(std::max(SmallestPortion, needed / Portions));
}

std::vector<VisibleRuns::Range> VisibleRuns::FindDrawn()
{
  return this->Draw([](const Run& run) { return run.IsDrawn; });
}

std::vector<VisibleRuns::Range> VisibleRuns::FindDrawnAt(int x, int y)
{
  return this->Draw(
    [x, y](const Run& run)
    {
      const PixelBox& pixels = run.Box.Pixels;
      return run.IsDrawn &&
        (!run.Box.IsKnown ||
          (pixels.Left <= x && x < pixels.Right && pixels.Bottom <= y && y < pixels.Top));
    });
}

std::vector<VisibleRuns::Range> VisibleRuns::DrawNearest(std::size_t triangles)
{
  std::vector<const Run*> waiting;
  for (const Run& run : this->Runs)
  {
    if (run.IsWaiting)
    {
      waiting.push_back(&run);
    }
  }
  std::sort(waiting.begin(), waiting.end(),
    [](const Run* a, const Run* b) { return a->Box.Depth < b->Box.Depth; });
  float farthest = 0;
  std::size_t count = 0;
  for (auto run = waiting.begin(); run != waiting.end() && count < triangles; ++run)
  {
    farthest = (*run)->Box.Depth;
    count += (*run)->Count;
  }
  return this->Draw(
    [farthest](const Run& run) { return run.IsWaiting && run.Box.Depth <= farthest; });
}

std::size_t VisibleRuns::CountDrawn() const
{
  return this->Count([](const Run& run) { return run.IsDrawn; });
}

template <typename IsMeantT>
std::size_t VisibleRuns::Count(const IsMeantT& isMeant) const
{
  std::size_t triangles = 0;
  for (const Run& run : this->Runs)
  {
    triangles += isMeant(run) ? run.Count : 0;
  }
  return triangles;
}

template <typename IsMeantT>
std::vector<VisibleRuns::Range> VisibleRuns::Draw(const IsMeantT& isMeant)
{
  std::vector<Range> ranges;
  for (Run& run : this->Runs)
  {
    if (isMeant(run))
    {
      run.IsWaiting = false;
      run.IsDrawn = true;
      if (ranges.empty() || ranges.back().Last != run.First)
      {
        ranges.push_back({ run.First, run.First });
      }
      ranges.back().Last = run.First + run.Count;
    }
  }
  return ranges;
}

} // namespace isosurface
