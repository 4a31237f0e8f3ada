// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_VisibleRuns_h
#define isosurface_VisibleRuns_h

#include "Surface/Drawing/BoxProjection.h"
#include "Surface/Drawing/DepthPyramid.h"
#include "Surface/Drawing/TriangleMeasure.h"

#include <array>
#include <cstddef>
#include <vector>

namespace isosurface
{

/**
 * Chooses which runs of a surface's triangles an image needs (TriangleMeasure). The caller draws
 * what FindFirst() returns, reads the depths of the image, and draws what FindNext() returns, until
 * that is nothing. Runs that were visible in the image before are drawn first (of a new surface
 * those that would have been), then the other runs that are not behind these. So no run is left out
 * that has a visible triangle.
 *
 * Sources: L. Livnat, C. Hansen, "View dependent isosurface extraction", 1998, for surfaces in
 * blocks; U. Haar, S. Aaltonen, "GPU-driven rendering pipelines", 2015, for what was visible before.
 */
class VisibleRuns
{
public:
  /// Proper triangles [First, Last), counted over the surface.
  struct Range
  {
    std::size_t First = 0;
    std::size_t Last = 0;
  };

  /// Takes a surface, of which no image is known.
  void Take(const TriangleMeasure& measure);
  /// Begins an image.
  void Begin(const BoxProjection& projection);

  /// The triangles to draw first, in their order. `before`: the image before, of any surface.
  std::vector<Range> FindFirst(const DepthPyramid& before);
  /// The triangles to draw next, in their order, and none at the end. `drawn`: the image so far.
  std::vector<Range> FindNext(const DepthPyramid& drawn);
  /// Whether FindNext() has returned all triangles in the image, since FindFirst() had returned too
  /// few.
  bool HasBegunAnew() const { return this->BegunAnew; }

  /// All triangles that have been drawn, in their order; those of runs that may cover a pixel.
  std::vector<Range> FindDrawn();
  std::vector<Range> FindDrawnAt(int x, int y);
  std::size_t CountDrawn() const;

private:
  struct Run
  {
    std::size_t First = 0; ///< proper triangle
    std::size_t Count = 0; ///< of proper triangles
    std::array<float, 6> Bounds{};
    ProjectedBox Box;
    bool IsWaiting = false;  ///< neither drawn nor left out
    bool IsDrawn = false;    ///< in this image
    bool WasVisible = false; ///< in the image before
  };

  template <typename IsMeantT>
  std::size_t Count(const IsMeantT& isMeant) const;
  /// Draws the nearest waiting runs, about `triangles` triangles.
  std::vector<Range> DrawNearest(std::size_t triangles);
  template <typename IsMeantT>
  std::vector<Range> Draw(const IsMeantT& isMeant);

  std::vector<Run> Runs;
  bool BegunAnew = false;
};

} // namespace isosurface

#endif
