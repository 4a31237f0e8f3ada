// SPDX-License-Identifier: BSD-3-Clause
#include "Contour/SlabBuilder.h"

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

// A coordinate of a shared vertex in the neighbour that lies `step` away on the axis.
int TranslateCoordinate(int coordinate, int step, int neighborSize)
{
  return step == 0 ? coordinate : step > 0 ? 0 : neighborSize - 1;
}

} // namespace

SlabBuilder::SlabBuilder(
  const BrickLattice& lattice, const BrickScan& scan, std::size_t firstPart, std::size_t brick)
  : Lattice(lattice)
  , Scan(scan)
  , FirstPart(firstPart)
  , Neighborhood(lattice.FindNeighborhood(brick))
{
  this->Self = this->GetView({});
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

const SlabBuilder::View& SlabBuilder::GetView(const BrickNeighborhood::Step& step)
{
  View& view =
    this->Views[static_cast<std::size_t>(step.X + 1 + 3 * (step.Y + 1) + 9 * (step.Z + 1))];
  if (!view.Part)
  {
    const std::size_t brick = this->Neighborhood.Get(step);
    view.Part = &this->Scan.GetParts()[this->FirstPart + brick];
    view.Ownership = &this->Scan.GetOwnerships()[brick];
    const Index3 size = this->Lattice.GetBricks()[brick].Vertices.GetSize();
    view.Size = { static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2]) };
  }
  return view;
}

bool SlabBuilder::IsActive(int k) const
{
  const int rows = 2 * this->Self.Size[1];
  const std::uint64_t* inside = this->Self.Part->Inside + k * this->Self.Size[1];
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
  this->FillZ(k);
  for (int plane = 0; plane < 2; ++plane)
  {
    const auto slot = static_cast<std::size_t>((k + plane) % 2);
    this->Slab.Inside[plane] = this->Self.Part->Inside + (k + plane) * this->Self.Size[1];
    this->Slab.X[plane] = this->X[slot].data();
    this->Slab.Y[plane] = this->Y[slot].data();
    for (std::size_t side = 0; side < 2; ++side)
    {
      this->Slab.ColumnY[side][plane] = this->ColumnY[side][slot].data();
    }
  }
  this->Slab.Z = this->Z.data();
  this->Slab.ColumnZ[0] = this->ColumnZ[0].data();
  this->Slab.ColumnZ[1] = this->ColumnZ[1].data();
  return this->Slab;
}

EdgeRow SlabBuilder::FindRow(const View& view, int axis, int j, int k)
{
  const BrickPart& part = *view.Part;
  if (!part.Inside)
  {
    return { 0, 0 }; // a brick without a surface: nothing crosses the shared row
  }
  const int ny = view.Size[1];
  const int row = k * ny + j;
  const int yPlace = PlaceOf(j, ny);
  const int zPlace = PlaceOf(k, view.Size[2]);
  const std::uint64_t inside = part.Inside[row];
  const std::uint64_t x = (inside ^ inside >> 1) & view.Ownership->X[yPlace][zPlace];
  EdgeRow edges{ x, part.FirstPoint + part.Offsets[row] };
  if (axis == 0)
  {
    return edges;
  }
  edges.First += CountBits(x);
  edges.Bits = j + 1 < ny ? (inside ^ part.Inside[row + 1]) & view.Ownership->Y[zPlace] : 0;
  if (axis == 1)
  {
    return edges;
  }
  edges.First += CountBits(edges.Bits);
  edges.Bits =
    k + 1 < view.Size[2] ? (inside ^ part.Inside[row + ny]) & view.Ownership->Z[yPlace] : 0;
  return edges;
}

SlabBuilder::Vertex SlabBuilder::Translate(
  const View& owner, const BrickNeighborhood::Step& step, Vertex vertex) const
{
  return { TranslateCoordinate(vertex.I, step.X, owner.Size[0]),
    TranslateCoordinate(vertex.J, step.Y, owner.Size[1]),
    TranslateCoordinate(vertex.K, step.Z, owner.Size[2]) };
}

// The row of edges between the first and the last column, wherever it is.
EdgeRow SlabBuilder::FindRow(int axis, int j, int k)
{
  const int yPlace = PlaceOf(j, this->Self.Size[1]);
  const int zPlace = PlaceOf(k, this->Self.Size[2]);
  const BrickNeighborhood::Step& step = axis == 0 ? this->Owners[0][yPlace][zPlace]
    : axis == 1                                   ? this->Owners[1][1][zPlace]
                                                  : this->Owners[2][1][yPlace];
  if (step == BrickNeighborhood::Step{})
  {
    return FindRow(this->Self, axis, j, k);
  }
  const View& owner = this->GetView(step);
  const Vertex vertex = this->Translate(owner, step, { 1, j, k });
  return FindRow(owner, axis, vertex.J, vertex.K);
}

// The point on the Y or Z edge from a vertex of the first or last column; anything if uncrossed.
std::int64_t SlabBuilder::FindColumn(int axis, int side, int j, int k)
{
  const int ny = this->Self.Size[1];
  const int i = side == 0 ? 0 : this->Self.Size[0] - 1;
  const std::uint64_t* inside = this->Self.Part->Inside + k * ny + j;
  if (((inside[0] ^ inside[axis == 1 ? 1 : ny]) >> i & 1) == 0)
  {
    return 0;
  }
  const int place = axis == 1 ? PlaceOf(k, this->Self.Size[2]) : PlaceOf(j, ny);
  const BrickNeighborhood::Step& step = this->Owners[axis][side == 0 ? 0 : 2][place];
  const View& owner = this->GetView(step);
  const Vertex vertex = this->Translate(owner, step, { i, j, k });
  const EdgeRow row = FindRow(owner, axis, vertex.J, vertex.K);
  return row.First + CountBits(row.Bits & ((std::uint64_t(1) << vertex.I) - 1));
}

void SlabBuilder::FillPlane(int k)
{
  const auto slot = static_cast<std::size_t>(k % 2);
  if (this->Filled[slot] == k)
  {
    return;
  }
  this->Filled[slot] = k;
  for (int j = 0; j < this->Self.Size[1]; ++j)
  {
    const auto row = static_cast<std::size_t>(j);
    this->X[slot][row] = this->FindRow(0, j, k);
    if (j + 1 < this->Self.Size[1])
    {
      this->Y[slot][row] = this->FindRow(1, j, k);
      this->ColumnY[0][slot][row] = this->FindColumn(1, 0, j, k);
      this->ColumnY[1][slot][row] = this->FindColumn(1, 1, j, k);
    }
  }
}

void SlabBuilder::FillZ(int k)
{
  for (int j = 0; j < this->Self.Size[1]; ++j)
  {
    const auto row = static_cast<std::size_t>(j);
    this->Z[row] = this->FindRow(2, j, k);
    this->ColumnZ[0][row] = this->FindColumn(2, 0, j, k);
    this->ColumnZ[1][row] = this->FindColumn(2, 1, j, k);
  }
}

} // namespace isosurface
