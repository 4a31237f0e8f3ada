// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/BrickScan.h"

#include "Ground/Base/FirstFailure.h"
#include "Ground/Base/ParallelFor.h"
#include "Ground/Volume/ValueKey.h"
#include "Surface/Contour/BorderBrick.h"
#include "Surface/Contour/LinePlacement.h"

#include <chrono>
#include <cstring>
#include <string>
#include <type_traits>

namespace isosurface
{
namespace
{

// v0 + t * (v1 - v0), without overflow.
template <typename T>
double InterpolateValue(T v0, T v1, double t)
{
  if constexpr (std::is_floating_point_v<T>)
  {
    return static_cast<double>(v0) + t * static_cast<double>(v1 - v0);
  }
  else
  {
    const double first = static_cast<double>(v0);
    return first + t * (static_cast<double>(v1) - first);
  }
}

template <typename T, typename Out>
void InterpolateComponent(const SampleView& samples, const T* first, const EdgeCode* codes,
  const double* parameters, std::size_t count, Out* out, std::size_t step)
{
  // Axis 3 is the code of a vertex.
  const std::ptrdiff_t along[4] = { samples.Stride[0], samples.Stride[1], samples.Stride[2], 0 };
  for (std::size_t n = 0; n < count; ++n, out += step)
  {
    const EdgeCode code = codes[n];
    const T* from = first;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      from += static_cast<std::ptrdiff_t>(code >> (6 * axis) & 63) * samples.Stride[axis];
    }
    *out = static_cast<Out>(InterpolateValue(*from, from[along[code >> 18]], parameters[n]));
  }
}

/**
 * Interpolates the samples of an attribute linearly along edges of a brick, in double. Writes one
 * tuple after the other, as values of the interpolated type (GetInterpolatedType).
 *
 * codes, parameters: `count` edges, and the position of the point on each edge (0 to 1); low: the
 * brick's first vertex; tuples: room for count * number of components values, aligned for the type.
 */
void InterpolateAttribute(const AttributeView& view, const Index3& low, const EdgeCode* codes,
  const double* parameters, std::size_t count, std::uint8_t* tuples)
{
  const std::size_t components = view.Components.size();
  for (std::size_t component = 0; component < components; ++component)
  {
    const SampleView& samples = view.Components[component];
    DispatchValueType(samples.Type,
      [&](auto zero)
      {
        using T = decltype(zero);
        using Out = std::conditional_t<std::is_same_v<T, double>, double, float>;
        InterpolateComponent(samples, samples.At<T>(low), codes, parameters, count,
          reinterpret_cast<Out*>(tuples) + component, components);
      });
  }
}

/// Copies the tuples of edges. No code may be that of a vertex.
void CopyEdgeTuples(const EdgeTupleView& view, const Index3& low, const EdgeCode* codes,
  std::size_t count, std::uint8_t* tuples)
{
  const Index3 size = view.Box.GetSize();
  const std::size_t width =
    GetValueSize(view.Type) * static_cast<std::size_t>(view.NumberOfComponents);
  for (std::size_t n = 0; n < count; ++n, tuples += width)
  {
    Index3 vertex = low;
    for (unsigned axis = 0; axis < 3; ++axis)
    {
      vertex[axis] += (codes[n] >> (6 * axis) & 63) - view.Box.Low[axis];
    }
    const auto place =
      static_cast<std::size_t>(vertex[0] + size[0] * (vertex[1] + size[1] * vertex[2]));
    std::memcpy(tuples, view.First[codes[n] >> 18] + place * width, width);
  }
}

// The vertices of the grid whose samples are known.
VertexBox FindKnownSamples(const GridGeometry& geometry, const ContourRequest& request)
{
  const VertexBox all{ { 0, 0, 0 }, geometry.GetDimensions() };
  return request.KnownSamples ? all.Intersect(*request.KnownSamples) : all;
}

// As BrickKernels::LocatePoints, for given crossings.
void LocateCrossings(const CrossingView& crossings, const BrickSamples& view, const EdgeCode* codes,
  std::uint32_t count, float* coordinates, double* parameters)
{
  const Index3 size = crossings.Box.GetSize();
  const std::ptrdiff_t stride[3] = { 1, static_cast<std::ptrdiff_t>(size[0]),
    static_cast<std::ptrdiff_t>(size[0] * size[1]) };
  std::ptrdiff_t first = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    first += static_cast<std::ptrdiff_t>(view.Low[axis] - crossings.Box.Low[axis]) * stride[axis];
  }
  for (std::uint32_t n = 0; n < count; ++n)
  {
    const EdgeCode code = codes[n];
    const std::size_t axis = code >> 18;
    std::ptrdiff_t at = first;
    bool isGiven = !crossings.IsOfFaces;
    for (std::size_t across = 0; across < 3; ++across)
    {
      const auto place = static_cast<std::int64_t>(code >> (6 * across) & 63);
      const std::int64_t vertex = view.Low[across] + place;
      at += static_cast<std::ptrdiff_t>(place) * stride[across];
      isGiven = isGiven ||
        (across != axis &&
          (vertex == crossings.Box.Low[across] || vertex == crossings.Box.High[across] - 1));
    }
    if (!isGiven)
    {
      continue;
    }
    const auto t = static_cast<double>(crossings.First[axis][at]);
    if (parameters)
    {
      parameters[n] = t;
    }
    const auto along = static_cast<std::int64_t>(code >> (6 * axis) & 63);
    coordinates[n] = static_cast<float>(
      static_cast<double>(view.Low[axis] + along) + t + static_cast<double>(view.ExtentLow[axis]));
  }
}

Status MakeSamplesError(std::size_t block, const std::string& reason)
{
  return { StatusCode::InvalidArgument,
    "The samples of block " + std::to_string(block) + " " + reason + "." };
}

// Whether an attribute matches its layout and covers a block's vertices.
bool Fits(const AttributeView& view, const AttributeLayout& layout, const VertexBox& vertices)
{
  if (view.EdgeTuples)
  {
    const EdgeTupleView& tuples = *view.EdgeTuples;
    return view.Components.empty() && tuples.First[0] && tuples.First[1] && tuples.First[2] &&
      tuples.Type == GetInterpolatedType(layout.Type) &&
      tuples.NumberOfComponents == layout.NumberOfComponents && tuples.Box.Contains(vertices);
  }
  bool fits = view.Components.size() == static_cast<std::size_t>(layout.NumberOfComponents);
  for (const SampleView& component : view.Components)
  {
    fits = fits && component.First && component.Type == layout.Type &&
      component.Available.Contains(vertices);
  }
  return fits;
}

bool IsCrossed(const std::uint64_t* inside, std::size_t rows, int verticesPerRow)
{
  const std::uint64_t full = (std::uint64_t(1) << verticesPerRow) - 1;
  std::uint64_t any = 0;
  std::uint64_t all = full;
  for (std::size_t row = 0; row < rows; ++row)
  {
    any |= inside[row];
    all &= inside[row];
  }
  return any != 0 && all != full;
}

} // namespace

BrickSamples MakeBrickSamples(
  const GridGeometry& geometry, const VertexBox& brick, const SampleView* samples)
{
  BrickSamples view{};
  const Index3 dimensions = geometry.GetDimensions();
  for (int axis = 0; axis < 3; ++axis)
  {
    view.Size[axis] = static_cast<int>(brick.High[axis] - brick.Low[axis]);
    view.Low[axis] = brick.Low[axis];
    view.Dimensions[axis] = dimensions[axis];
    view.ExtentLow[axis] = geometry.Extent[2 * axis];
    view.Stride[axis] = samples ? samples->Stride[axis] : 0;
  }
  if (samples)
  {
    DispatchValueType(
      samples->Type, [&](auto zero) { view.First = samples->At<decltype(zero)>(brick.Low); });
  }
  return view;
}

BrickScan::BrickScan(
  const GridGeometry& geometry, BlockSource& source, const ContourRequest& request, int threads)
  : Geometry(geometry)
  , Source(source)
  , Request(request)
  , KnownSamples(FindKnownSamples(geometry, request))
  , DoublePoints(isosurface::HasDoublePoints(geometry, request))
  , Kernels(GetBrickKernels())
  , Workers(static_cast<std::size_t>(std::max(1, threads)))
{
  DispatchValueType(source.GetValueType(),
    [&](auto zero)
    {
      for (const double isovalue : request.Isovalues)
      {
        Threshold threshold;
        if (const auto value = FindThreshold<decltype(zero)>(isovalue))
        {
          threshold.Exists = true;
          std::memcpy(threshold.Value.data(), &*value, sizeof(*value));
        }
        this->Thresholds.push_back(threshold);
      }
    });
}

void BrickScan::Allocate(const BrickLattice& lattice, Surfaces& parts) const
{
  const std::size_t bricks = lattice.GetBricks().size();
  parts.OfBricks.resize(bricks * this->Request.Isovalues.size());
  parts.Ownerships.resize(bricks);
}

Status BrickScan::Run(const BrickLattice& lattice, const Progress& progress)
{
  this->Allocate(lattice, this->AllSurfaces);
  std::size_t samples = 0;
  for (const Brick& brick : lattice.GetBricks())
  {
    samples += static_cast<std::size_t>(brick.Vertices.GetNumberOfVertices());
  }
  constexpr std::size_t samplesOfThread = 65536;
  FirstFailure failure;
  const bool finished = ParallelFor(
    this->Source.GetNumberOfBlocks(),
    LimitThreads(static_cast<int>(this->Workers.size()), samples, samplesOfThread),
    [&](std::size_t block, int thread) {
      failure.Run(
        [&] { return this->ScanBlock(lattice, block, block, this->AllSurfaces, thread); });
    },
    progress);
  ISOSURFACE_RETURN_IF_ERROR(failure.Get());
  return finished ? Status::Ok() : Status(StatusCode::Aborted, "The extraction was aborted.");
}

double BrickScan::GetAcquireSeconds() const
{
  double seconds = 0;
  for (const Worker& worker : this->Workers)
  {
    seconds += worker.AcquireSeconds;
  }
  return seconds;
}

bool BrickScan::HasHiddenCells() const
{
  return std::any_of(this->GetSurfaces().begin(), this->GetSurfaces().end(),
    [](const BrickSurface& part) { return part.Visible != nullptr; });
}

Status BrickScan::ScanBlock(const BrickLattice& lattice, std::size_t numberInLattice,
  std::size_t block, Surfaces& parts, int thread)
{
  Worker& worker = this->Workers[static_cast<std::size_t>(thread)];
  const auto start = std::chrono::steady_clock::now();
  const Result<BlockSamples> samples = this->Source.Acquire(block);
  worker.AcquireSeconds +=
    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ISOSURFACE_RETURN_IF_ERROR(samples.GetStatus());
  ISOSURFACE_RETURN_IF_ERROR(this->CheckSamples(block, *samples));
  for (std::size_t brick = lattice.GetFirstBrick(numberInLattice);
       brick < lattice.GetFirstBrick(numberInLattice + 1); ++brick)
  {
    this->ScanBrick(lattice, brick, *samples, parts, worker);
  }
  return Status::Ok();
}

Status BrickScan::CheckSamples(std::size_t block, const BlockSamples& samples) const
{
  const SampleView& scalars = samples.Scalars;
  const VertexBox vertices = this->Source.GetVertices(block);
  if (!scalars.First || scalars.Type != this->Source.GetValueType())
  {
    return MakeSamplesError(block, "are missing or of another type");
  }
  const VertexBox needed = this->Request.Normals ? vertices.AddLayer(this->KnownSamples) : vertices;
  if (!scalars.Available.Contains(needed))
  {
    return MakeSamplesError(
      block, this->Request.Normals ? "lack the layer around it for normals" : "do not cover it");
  }
  if (samples.Crossings && !samples.Crossings->Box.Contains(vertices))
  {
    return MakeSamplesError(block, "have crossings that do not cover it");
  }
  if (samples.Hidden && !samples.Hidden->Box.Contains(scalars.Available))
  {
    return MakeSamplesError(block, "are not covered by the flags that hide some");
  }
  if (samples.Attributes.size() != this->Request.Attributes.size())
  {
    return MakeSamplesError(block, "do not have the requested number of attributes");
  }
  for (std::size_t n = 0; n < samples.Attributes.size(); ++n)
  {
    const AttributeView& view = samples.Attributes[n];
    if (view.EdgeTuples && !this->Request.ClosedSides.IsEmpty())
    {
      return MakeSamplesError(block, "have tuples on edges, with which sides cannot be closed");
    }
    if (!Fits(view, this->Request.Attributes[n], vertices))
    {
      return MakeSamplesError(
        block, "have an attribute " + std::to_string(n) + " that does not match the request");
    }
  }
  return Status::Ok();
}

void BrickScan::ScanBrick(const BrickLattice& lattice, std::size_t number,
  const BlockSamples& samples, Surfaces& parts, Worker& worker)
{
  const std::size_t bricks = lattice.GetBricks().size();
  const Brick& brick = lattice.GetBricks()[number];
  BlockSamples extended;
  if (brick.IsBeyond())
  {
    extended = ExtendBeyond(samples, brick);
  }
  const BlockSamples& own = brick.IsBeyond() ? extended : samples;
  BrickSamples view = MakeBrickSamples(this->Geometry, brick.Vertices, &own.Scalars);
  std::copy(this->KnownSamples.Low.begin(), this->KnownSamples.Low.end(), view.KnownLow);
  std::copy(this->KnownSamples.High.begin(), this->KnownSamples.High.end(), view.KnownHigh);
  parts.Ownerships[number] = lattice.FindNeighborhood(number).ComputeOwnership(view.Size);
  const CellVisibility ofBlock(samples, this->Request.SkipNotANumber);
  const BrickVisibility visibility = this->FindVisibility(ofBlock, brick, worker);
  for (std::size_t isovalue = 0; isovalue < this->Thresholds.size(); ++isovalue)
  {
    if (this->Thresholds[isovalue].Exists)
    {
      parts.OfBricks[isovalue * bricks + number] = this->ScanIsovalue(
        isovalue, brick, parts.Ownerships[number], view, own, visibility, worker);
    }
  }
}

BrickScan::BrickVisibility BrickScan::FindVisibility(
  const CellVisibility& ofBlock, const Brick& brick, Worker& worker) const
{
  BrickVisibility visibility;
  if (!ofBlock.IsLimited())
  {
    return visibility;
  }
  const Index3 size = brick.Vertices.GetSize();
  const auto rows = static_cast<std::size_t>(size[1] * size[2]);
  auto* cells = worker.Memory.Reserve<std::uint64_t>(rows);
  if (ofBlock.FindVisibleCells(brick, cells))
  {
    worker.Memory.Keep<std::uint64_t>(rows);
    visibility.Cells = cells;
  }
  if (this->Request.Normals && !brick.IsBeyond() &&
    ofBlock.HasUnknownSamples(brick, this->KnownSamples))
  {
    visibility.Samples = &ofBlock;
  }
  return visibility;
}

BrickSurface BrickScan::ScanIsovalue(std::size_t isovalue, const Brick& brick,
  const BrickOwnership& ownership, const BrickSamples& view, const BlockSamples& samples,
  const BrickVisibility& visibility, Worker& worker)
{
  BrickSurface part;
  const auto rows = static_cast<std::size_t>(view.Size[1]) * static_cast<std::size_t>(view.Size[2]);
  auto* inside = worker.Memory.Reserve<std::uint64_t>(rows);
  this->Kernels.ClassifyRows(
    samples.Scalars.Type, view, this->Thresholds[isovalue].Value.data(), inside);
  if (brick.IsBeyond())
  {
    SetOuterVertices(brick, this->Request.ClosedSides.AreBeyondInside, inside);
  }
  if (!IsCrossed(inside, rows, view.Size[0]))
  {
    return part;
  }
  worker.Memory.Keep<std::uint64_t>(rows);
  auto* offsets = worker.Memory.Allocate<std::uint32_t>(rows);
  const std::size_t maximumPoints = 3 * rows * static_cast<std::size_t>(view.Size[0]);
  part.Inside = inside;
  part.Offsets = offsets;
  part.Codes = worker.Memory.Reserve<EdgeCode>(maximumPoints + EdgeCodeSlack);
  part.Counts = this->Kernels.NumberRows(view.Size, inside, ownership, offsets, part.Codes);
  worker.Memory.Keep<EdgeCode>(part.Counts.Points);
  if (visibility.Cells)
  {
    part.Visible = visibility.Cells;
    const BrickCounts visible = CountVisible(view.Size, inside, part.Visible);
    part.Counts.Triangles = visible.Triangles;
    part.Counts.Polygons = visible.Polygons;
  }
  this->MakePoints(
    this->Request.Isovalues[isovalue], brick, view, samples, visibility.Samples, part, worker);
  return part;
}

void BrickScan::MakePoints(double isovalue, const Brick& brick, const BrickSamples& view,
  const BlockSamples& samples, const CellVisibility* unknown, BrickSurface& part,
  Worker& worker) const
{
  const std::uint32_t count = part.Counts.Points;
  double* parameters = nullptr;
  if (this->DoublePoints)
  {
    parameters = part.Parameters = worker.Memory.Allocate<double>(count);
  }
  else if (this->Request.Normals || !samples.Attributes.empty() || this->Request.Lines)
  {
    worker.Parameters.resize(std::max<std::size_t>(worker.Parameters.size(), count));
    parameters = worker.Parameters.data();
  }
  part.Coordinates = worker.Memory.Allocate<float>(count);
  if (brick.IsBeyond())
  {
    LocateBorderPoints(brick, view, part.Codes, count, part.Coordinates, parameters);
  }
  else
  {
    if (!samples.Crossings || samples.Crossings->IsOfFaces)
    {
      this->Kernels.LocatePoints(
        samples.Scalars.Type, view, isovalue, part.Codes, count, part.Coordinates, parameters);
    }
    if (samples.Crossings)
    {
      LocateCrossings(*samples.Crossings, view, part.Codes, count, part.Coordinates, parameters);
    }
  }
  if (this->Request.Normals)
  {
    part.Normals = worker.Memory.Allocate<float>(3 * std::size_t(count));
    if (brick.IsBeyond())
    {
      ComputeOutwardNormals(brick, part.Codes, count, part.Normals);
    }
  }
  this->CopyAttributes(brick.Vertices.Low, samples, part, worker);
  if (this->Request.DropDegenerateTriangles && !this->Request.Polygons)
  {
    part.VertexPoints = worker.Memory.Reserve<VertexPoint>(count);
    part.NumberOfVertexPoints = FindVertexPoints(
      view, part.Codes, part.Coordinates, parameters, this->DoublePoints, count, part.VertexPoints);
    worker.Memory.Keep<VertexPoint>(part.NumberOfVertexPoints);
  }
  if (this->Request.Lines)
  {
    this->PlacePointsOnLines(isovalue, brick, samples, unknown, parameters, part);
  }
  if (this->Request.Normals)
  {
    if (!brick.IsBeyond() && !this->Request.Lines)
    {
      this->Kernels.ComputeNormals(
        samples.Scalars.Type, view, part.Codes, parameters, count, part.Normals);
    }
    if (unknown && !this->Request.Lines)
    {
      CorrectNormals(*unknown, samples.Scalars, this->KnownSamples, brick.Vertices.Low, part.Codes,
        parameters, count, part.Normals);
    }
    if (this->Request.ClosedSides.AreBeyondInside && !brick.IsBeyond())
    {
      std::transform(part.Normals, part.Normals + 3 * std::size_t(count), part.Normals,
        [](float value) { return -value; });
    }
    SetNormalsOnSides(this->Request.ClosedSides, this->Geometry.GetDimensions(), brick.Vertices.Low,
      part.VertexPoints, part.NumberOfVertexPoints, part.Normals);
  }
  this->InterpolateAttributes(brick.Vertices.Low, samples, parameters, part);
}

void BrickScan::PlacePointsOnLines(double isovalue, const Brick& brick, const BlockSamples& samples,
  const CellVisibility* unknown, double* parameters, BrickSurface& part) const
{
  const LinedBrick lined{ *this->Request.Lines, brick.Vertices.Low, part.Codes,
    part.Counts.Points };
  if (brick.IsBeyond() || samples.Crossings)
  {
    PlaceOnLines(lined, parameters, part.Coordinates);
  }
  else
  {
    LocateOnLines(lined, samples.Scalars, isovalue, part.Coordinates, parameters);
  }
  if (this->Request.Normals && !brick.IsBeyond())
  {
    ComputeNormalsOnLines(
      lined, samples.Scalars, this->KnownSamples, unknown, parameters, part.Normals);
  }
}

// Allocates all attributes, and copies tuples on edges. Before any points are moved to vertices.
void BrickScan::CopyAttributes(
  const Index3& low, const BlockSamples& samples, BrickSurface& part, Worker& worker) const
{
  if (samples.Attributes.empty())
  {
    return;
  }
  const std::uint32_t count = part.Counts.Points;
  part.Attributes = worker.Memory.Allocate<std::uint8_t*>(samples.Attributes.size());
  for (std::size_t n = 0; n < samples.Attributes.size(); ++n)
  {
    const AttributeLayout& layout = this->Request.Attributes[n];
    part.Attributes[n] = worker.Memory.Allocate<std::uint8_t>(count * GetTupleSize(layout));
    if (const auto& tuples = samples.Attributes[n].EdgeTuples)
    {
      CopyEdgeTuples(*tuples, low, part.Codes, count, part.Attributes[n]);
    }
  }
}

void BrickScan::InterpolateAttributes(const Index3& low, const BlockSamples& samples,
  const double* parameters, BrickSurface& part) const
{
  for (std::size_t n = 0; n < samples.Attributes.size(); ++n)
  {
    if (!samples.Attributes[n].EdgeTuples)
    {
      InterpolateAttribute(
        samples.Attributes[n], low, part.Codes, parameters, part.Counts.Points, part.Attributes[n]);
    }
  }
}

} // namespace isosurface
