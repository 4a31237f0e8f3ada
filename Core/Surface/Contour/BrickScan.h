// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BrickScan_h
#define isosurface_BrickScan_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/HugePages.h"
#include "Ground/Base/Progress.h"
#include "Ground/Base/Status.h"
#include "Ground/Volume/BlockSource.h"
#include "Ground/Volume/Handedness.h"
#include "Surface/Contour/BrickKernel.h"
#include "Surface/Contour/BrickLattice.h"
#include "Surface/Contour/CellVisibility.h"
#include "Surface/Contour/SurfaceExtractor.h"
#include "Surface/Contour/VertexPoints.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * Memory that is allocated from front to back and freed as a whole. Allocations are aligned to 64
 * bytes. For one thread at a time.
 */
class Arena
{
public:
  /// Returns room for up to `count` values. Valid until the next call unless kept by Keep().
  template <typename T>
  T* Reserve(std::size_t count)
  {
    const std::size_t bytes = count * sizeof(T);
    if (this->Chunks.empty() || this->Chunks.back().GetSize() - this->Used < bytes)
    {
      const std::size_t size = this->Chunks.empty()
        ? FirstChunkSize
        : std::min(2 * this->Chunks.back().GetSize(), MaximumChunkSize);
      this->Chunks.emplace_back(std::max(size, bytes + Alignment));
      AdviseHugePages(this->Chunks.back().GetData(), this->Chunks.back().GetSize());
      const auto address = reinterpret_cast<std::uintptr_t>(this->Chunks.back().GetData());
      this->Used = (Alignment - address % Alignment) % Alignment;
    }
    return reinterpret_cast<T*>(this->Chunks.back().GetData() + this->Used);
  }

  /// Keeps the first `count` values of the last reservation.
  template <typename T>
  void Keep(std::size_t count)
  {
    const std::size_t bytes = (count * sizeof(T) + Alignment - 1) / Alignment * Alignment;
    this->Used = std::min(this->Used + bytes, this->Chunks.back().GetSize());
  }

  template <typename T>
  T* Allocate(std::size_t count)
  {
    T* values = this->Reserve<T>(count);
    this->Keep<T>(count);
    return values;
  }

private:
  // The first chunk is small, so that a small surface does not take much memory.
  static constexpr std::size_t FirstChunkSize = std::size_t(1) << 18;
  static constexpr std::size_t MaximumChunkSize = std::size_t(8) << 20;
  static constexpr std::size_t Alignment = 64;

  std::vector<Buffer<std::uint8_t>> Chunks;
  std::size_t Used = 0; ///< bytes of the last chunk
};

/// The results of the first phase for a brick and an isovalue. All null if there is no surface.
struct BrickSurface
{
  const std::uint64_t* Inside = nullptr; ///< a word for each row of vertices, y fastest
  /// A word for each row of vertices: the visible cells from there on; null if all are.
  const std::uint64_t* Visible = nullptr;
  std::uint32_t* Offsets = nullptr; ///< the first point of each row, counted in the brick
  EdgeCode* Codes = nullptr;        ///< the owned points' edges, or vertices
  float* Coordinates = nullptr;     ///< the structured coordinate along each edge
  double* Parameters = nullptr;     ///< the position on each edge; null if points are float32
  float* Normals = nullptr;
  std::uint8_t** Attributes = nullptr; ///< tuples of each attribute
  /// With DropDegenerateTriangles, the points on vertices.
  VertexPoint* VertexPoints = nullptr;
  std::uint32_t NumberOfVertexPoints = 0;
  BrickCounts Counts{ 0, 0, 0 };
  std::int64_t FirstPoint = 0; ///< the number of the first point, before any are dropped

  // Set by the second phase.
  BrickCounts Kept{ 0, 0, 0 }; ///< Counts, without what VertexMerge drops
  std::int64_t FirstKeptPoint = 0;
  std::int64_t FirstCell = 0;
  std::int64_t FirstIndex = 0; ///< into the connectivity
};

/**
 * The first phase of an extraction: visits the samples of each block once, and keeps everything
 * that the second phase (SurfaceAssembler) needs.
 */
class BrickScan
{
public:
  /// The results for the bricks of a lattice.
  struct Surfaces
  {
    /// That of brick b at isovalue n is number n * number of bricks + b.
    std::vector<BrickSurface> OfBricks;
    std::vector<BrickOwnership> Ownerships; ///< of each brick
  };

  /// For use by `threads` threads.
  BrickScan(
    const GridGeometry& geometry, BlockSource& source, const ContourRequest& request, int threads);

  /// Visits every block; the lattice is that of all. Errors: those of Acquire(); InvalidArgument
  /// for invalid samples; Aborted.
  Status Run(const BrickLattice& lattice, const Progress& progress);

  /// Makes room for the results of a lattice.
  void Allocate(const BrickLattice& lattice, Surfaces& parts) const;
  /// Visits one block, number `numberInLattice` of the lattice, and number `block` of the source, as
  /// one of the threads. Errors as those of Run.
  Status ScanBlock(const BrickLattice& lattice, std::size_t numberInLattice, std::size_t block,
    Surfaces& parts, int thread);
  Surfaces& GetAllSurfaces() { return this->AllSurfaces; }
  std::vector<BrickSurface>& GetSurfaces() { return this->AllSurfaces.OfBricks; }
  const std::vector<BrickSurface>& GetSurfaces() const { return this->AllSurfaces.OfBricks; }
  const std::vector<BrickOwnership>& GetOwnerships() const { return this->AllSurfaces.Ownerships; }
  /// Those that turn the corners right in the world.
  CellCases GetCases() const { return GetCellCases(IsLeftHanded(this->Geometry)); }
  /// Whether points are float64.
  bool HasDoublePoints() const { return this->DoublePoints; }
  double GetAcquireSeconds() const;
  /// Whether a part has cells that are not visible: then some points may have no triangles.
  bool HasHiddenCells() const;

private:
  struct Worker
  {
    Arena Memory;
    std::vector<double> Parameters;
    double AcquireSeconds = 0;
  };
  /// A threshold as a value of the samples' type. Does not exist if no value can be inside.
  struct Threshold
  {
    bool Exists = false;
    alignas(8) std::array<std::uint8_t, 8> Value{};
  };

  /// What is not visible of a brick; void for most.
  struct BrickVisibility
  {
    const std::uint64_t* Cells = nullptr;    ///< see BrickSurface::Visible
    const CellVisibility* Samples = nullptr; ///< if some samples in it or around it are not known
  };

  Status CheckSamples(std::size_t block, const BlockSamples& samples) const;
  void ScanBrick(const BrickLattice& lattice, std::size_t number, const BlockSamples& samples,
    Surfaces& parts, Worker& worker);
  BrickSurface ScanIsovalue(std::size_t isovalue, const Brick& brick,
    const BrickOwnership& ownership, const BrickSamples& view, const BlockSamples& samples,
    const BrickVisibility& visibility, Worker& worker);
  void MakePoints(double isovalue, const Brick& brick, const BrickSamples& view,
    const BlockSamples& samples, const CellVisibility* unknown, BrickSurface& part,
    Worker& worker) const;
  void PlacePointsOnLines(double isovalue, const Brick& brick, const BlockSamples& samples,
    const CellVisibility* unknown, double* parameters, BrickSurface& part) const;
  BrickVisibility FindVisibility(
    const CellVisibility& ofBlock, const Brick& brick, Worker& worker) const;
  void CopyAttributes(
    const Index3& low, const BlockSamples& samples, BrickSurface& part, Worker& worker) const;
  void InterpolateAttributes(const Index3& low, const BlockSamples& samples,
    const double* parameters, BrickSurface& part) const;

  const GridGeometry& Geometry;
  BlockSource& Source;
  const ContourRequest& Request;
  const VertexBox KnownSamples;
  const bool DoublePoints;
  const BrickKernels& Kernels;
  std::vector<Threshold> Thresholds;
  std::vector<Worker> Workers;
  Surfaces AllSurfaces;
};

/// The kernel's description of a brick: its place in the grid and, if `samples` is given, its
/// samples.
BrickSamples MakeBrickSamples(
  const GridGeometry& geometry, const VertexBox& brick, const SampleView* samples = nullptr);

} // namespace isosurface

#endif
