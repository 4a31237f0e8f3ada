// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Contour/SlabBuilder.h"

namespace isosurface
{
namespace
{

int PlaceOf(int index, int size)
{
  return index == 0 ? 0 : index == size - 1 ? 2 : 1;
}

std::int64_t CountBits(std::uint64_t bits)
{
  return __builtin_popcountll(bits);
}

// The coordinate of a shared vertex in the neighbour at `step` on the axis.
int TranslateCoordinate(int coordinate, int step, int neighborSize)
{
  return step == 0 ? coordinate : step > 0 ? 0 : neighborSize - 1;
}

inline std::int32_t* WriteSlab(
  const BrickKernels& kernels, const RowSlab& slab, std::int32_t* next, std::int32_t* end)
{
  return kernels.WriteTriangles32(slab, next, end);
}
inline std::int64_t* WriteSlab(
  const BrickKernels& kernels, const RowSlab& slab, std::int64_t* next, std::int64_t* end)
{
  return kernels.WriteTriangles64(slab, next, end);
}

} // namespace

SlabBuilder::SlabBuilder(
  const BrickLattice& lattice, const BrickScan& scan, std::size_t firstPart, std::size_t brick)
  : Lattice(lattice)
  , Scan(scan)
  , FirstPart(firstPart)
  , Kernels(GetBrickKernels())
  , Visible(scan.GetSurfaces()[firstPart + brick].Visible)
  , Neighborhood(lattice.FindNeighborhood(brick))
{
  this->Self = this->GetRows({});
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int lower = 0; lower < NumberOfPlaces; ++lower)
    {
      for (int upper = 0; upper < NumberOfPlaces; ++upper)
      {
        this->Owners[axis][lower][upper] = this->Neighborhood.FindOwner(axis, lower, upper);
      }
    }
  }
  this->Slab.Size[0] = this->Self.Size[0];
  this->Slab.Size[1] = this->Self.Size[1];
  this->Slab.Cases = scan.GetCases();
  this->Slab.FirstColumnInRow = true;
  for (int axis = 1; axis < 3; ++axis)
  {
    for (int place = 0; place < NumberOfPlaces; ++place)
    {
      this->Slab.FirstColumnInRow =
        this->Slab.FirstColumnInRow && this->Owners[axis][0][place] == this->Owners[axis][1][place];
    }
  }
}

const NumberedRows& SlabBuilder::GetRows(const BrickNeighborhood::Step& step)
{
  NumberedRows& rows = this->Neighbors[BrickNeighborhood::GetIndex(step)];
  if (!rows.Ownership)
  {
    const std::size_t brick = this->Neighborhood.Get(step);
    const BrickSurface& part = this->Scan.GetSurfaces()[this->FirstPart + brick];
    rows.Inside = part.Inside;
    rows.Offsets = part.Offsets;
    rows.Ownership = &this->Scan.GetOwnerships()[brick];
    rows.FirstPoint = part.FirstPoint;
    const Index3 size = this->Lattice.GetBricks()[brick].Vertices.GetSize();
    for (int axis = 0; axis < 3; ++axis)
    {
      rows.Size[axis] = static_cast<int>(size[axis]);
    }
  }
  return rows;
}

bool SlabBuilder::IsActive(int k) const
{
  const int rows = 2 * this->Self.Size[1];
  const std::uint64_t* inside = this->Self.Inside + k * this->Self.Size[1];
  const std::uint64_t full = (std::uint64_t(1) << this->Self.Size[0]) - 1;
  std::uint64_t any = 0;
  std::uint64_t all = full;
  for (int row = 0; row < rows; ++row)
  {
    any |= inside[row];
    all &= inside[row];
  }
  return any != 0 && all != full;
}

const RowSlab& SlabBuilder::Build(int k)
{
  this->FillPlane(k);
  this->FillPlane(k + 1);
  this->FillColumns(2, k, this->ColumnZ[0], this->ColumnZ[1]);
  for (int plane = 0; plane < 2; ++plane)
  {
    const auto slot = static_cast<std::size_t>((k + plane) % 2);
    this->Slab.Inside[plane] = this->Self.Inside + (k + plane) * this->Self.Size[1];
    this->Slab.X[plane] = this->X[slot].data();
    this->Slab.Y[plane] = this->Y[slot].data();
    for (std::size_t side = 0; side < 2; ++side)
    {
      this->Slab.ColumnY[side][plane] = this->ColumnY[side][slot].data();
      this->Slab.ColumnZ[side] = this->ColumnZ[side].data();
    }
  }
  this->Slab.Z = this->Z[static_cast<std::size_t>(k % 2)].data();
  this->Slab.Visible = this->Visible ? this->Visible + k * this->Self.Size[1] : nullptr;
  return this->Slab;
}

template <typename Id>
Id* SlabBuilder::WriteTriangles(Id* next, Id* end)
{
  for (int k = 0; k < this->GetNumberOfSlabs(); ++k)
  {
    if (this->IsActive(k))
    {
      next = WriteSlab(this->Kernels, this->Build(k), next, end);
    }
  }
  return next;
}

template std::int32_t* SlabBuilder::WriteTriangles(std::int32_t* next, std::int32_t* end);
template std::int64_t* SlabBuilder::WriteTriangles(std::int64_t* next, std::int64_t* end);

void SlabBuilder::FillPlane(int k)
{
  const auto slot = static_cast<std::size_t>(k % 2);
  if (this->Filled[slot] != k)
  {
    this->Filled[slot] = k;
    this->Kernels.FindRows(
      this->Self, k, this->X[slot].data(), this->Y[slot].data(), this->Z[slot].data());
    this->FillSharedRows(k);
    this->FillColumns(1, k, this->ColumnY[0][slot], this->ColumnY[1][slot]);
  }
}

// Replaces the rows on faces that other bricks own.
void SlabBuilder::FillSharedRows(int k)
{
  const BrickNeighborhood::Step self;
  const auto slot = static_cast<std::size_t>(k % 2);
  const int ny = this->Self.Size[1];
  const int zPlace = PlaceOf(k, this->Self.Size[2]);
  const BrickNeighborhood::Step& ownerY = this->Owners[1][1][zPlace];
  for (int j = 0; j < ny; j += zPlace == 1 && j == 0 ? ny - 1 : 1)
  {
    const auto row = static_cast<std::size_t>(j);
    const int yPlace = PlaceOf(j, ny);
    const BrickNeighborhood::Step& ownerX = this->Owners[0][yPlace][zPlace];
    const BrickNeighborhood::Step& ownerZ = this->Owners[2][1][yPlace];
    if (!(ownerX == self))
    {
      this->X[slot][row] = this->FindSharedRow(0, ownerX, j, k);
    }
    if (!(ownerY == self) && j + 1 < ny)
    {
      this->Y[slot][row] = this->FindSharedRow(1, ownerY, j, k);
    }
    if (!(ownerZ == self) && k + 1 < this->Self.Size[2])
    {
      this->Z[slot][row] = this->FindSharedRow(2, ownerZ, j, k);
    }
  }
}

// The row of edges from (., j, k), from the brick at `owner`.
EdgeRow SlabBuilder::FindSharedRow(int axis, const BrickNeighborhood::Step& owner, int j, int k)
{
  const NumberedRows& rows = this->GetRows(owner);
  if (!rows.Inside)
  {
    return { 0, 0 }; // the owner has no surface, so no edge of the shared row is crossed
  }
  const int ny = rows.Size[1];
  j = TranslateCoordinate(j, owner.Y, ny);
  k = TranslateCoordinate(k, owner.Z, rows.Size[2]);
  const int row = k * ny + j;
  const int yPlace = PlaceOf(j, ny);
  const int zPlace = PlaceOf(k, rows.Size[2]);
  const std::uint64_t inside = rows.Inside[row];
  EdgeRow edges{ (inside ^ inside >> 1) & rows.Ownership->X[yPlace][zPlace],
    rows.FirstPoint + rows.Offsets[row] };
  if (axis >= 1)
  {
    edges.First += CountBits(edges.Bits);
    edges.Bits = j + 1 < ny ? (inside ^ rows.Inside[row + 1]) & rows.Ownership->Y[zPlace] : 0;
  }
  if (axis == 2)
  {
    edges.First += CountBits(edges.Bits);
    edges.Bits =
      k + 1 < rows.Size[2] ? (inside ^ rows.Inside[row + ny]) & rows.Ownership->Z[yPlace] : 0;
  }
  return edges;
}

// The numbers of the points on Y or Z edges that begin in the first and last column of plane k.
void SlabBuilder::FillColumns(int axis, int k, Column& first, Column& last)
{
  const int ny = this->Self.Size[1];
  const std::uint64_t* from = this->Self.Inside + k * ny;
  const std::uint64_t* to = from + (axis == 1 ? 1 : ny);
  const std::uint64_t lastBit = std::uint64_t(1) << (this->Self.Size[0] - 1);
  for (int j = 0; j < (axis == 1 ? ny - 1 : ny); ++j)
  {
    const std::uint64_t crossed = from[j] ^ to[j];
    if ((crossed & lastBit) != 0)
    {
      last[static_cast<std::size_t>(j)] = this->FindColumnPoint(axis, 1, j, k);
    }
    if ((crossed & 1) != 0 && !this->Slab.FirstColumnInRow)
    {
      first[static_cast<std::size_t>(j)] = this->FindColumnPoint(axis, 0, j, k);
    }
  }
}

std::int64_t SlabBuilder::FindColumnPoint(int axis, int side, int j, int k)
{
  const int place = axis == 1 ? PlaceOf(k, this->Self.Size[2]) : PlaceOf(j, this->Self.Size[1]);
  const BrickNeighborhood::Step& owner = this->Owners[axis][side == 0 ? 0 : 2][place];
  const EdgeRow row = this->FindSharedRow(axis, owner, j, k);
  const int own = side == 0 ? 0 : this->Self.Size[0] - 1;
  const int i = TranslateCoordinate(own, owner.X, this->GetRows(owner).Size[0]);
  return row.First + CountBits(row.Bits & ((std::uint64_t(1) << i) - 1));
}

} // namespace isosurface
