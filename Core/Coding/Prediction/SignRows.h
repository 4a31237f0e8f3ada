// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignRows_h
#define isosurface_SignRows_h

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace isosurface
{

/// The maximum numbers of cells and vertices of a block on each axis.
constexpr int MaximumCodedCells = 64;
constexpr int MaximumCodedVertices = MaximumCodedCells + 1;

/// The signs of a row of vertices, or marks of some of them: vertex x at bit x + 16, with margins
/// so that vertices beside the row can be read, too. Bit n is bit n % 64 of word n / 64. The sign
/// of a vertex is 1 inside, where value >= isovalue, and 0 outside.
struct SignRow
{
  static constexpr int Margin = 16;
  std::array<std::uint64_t, 2> Words{ 0, 0 };

  bool Get(int x) const
  {
    const auto bit = static_cast<unsigned>(x + Margin);
    return (this->Words[bit / 64] >> (bit % 64) & 1) != 0;
  }
  void Set(int x)
  {
    const auto bit = static_cast<unsigned>(x + Margin);
    this->Words[bit / 64] |= std::uint64_t(1) << (bit % 64);
  }
  /// Sets the vertices first .. end - 1.
  void SetRange(int first, int end)
  {
    const SignRow below = MakeMask(first);
    const SignRow all = MakeMask(end);
    this->Words[0] |= all.Words[0] & ~below.Words[0];
    this->Words[1] |= all.Words[1] & ~below.Words[1];
  }
  /// The bits of the vertices x - 2 .. x + 2, lowest first.
  std::uint32_t GetWindow(int x) const { return this->GetBits(x - 2) & 31; }
  /// Bit x of the result is bit x - 1, or x + 1, of the row.
  SignRow ShiftUp() const
  {
    return { { this->Words[0] << 1, this->Words[1] << 1 | this->Words[0] >> 63 } };
  }
  SignRow ShiftDown() const
  {
    return { { this->Words[0] >> 1 | this->Words[1] << 63, this->Words[1] >> 1 } };
  }
  bool IsZero() const { return (this->Words[0] | this->Words[1]) == 0; }

  /// Ones at the vertices 0 .. size - 1. size: 0 to 111.
  static SignRow MakeMask(int size)
  {
    SignRow mask;
    mask.Words[0] = ((std::uint64_t(1) << std::clamp(size, 0, 48)) - 1) << Margin;
    mask.Words[1] = (std::uint64_t(1) << std::clamp(size - 48, 0, 63)) - 1;
    return mask;
  }
  /// Sets the margins to the bit of the vertex next to them.
  void SpreadEnds(int size)
  {
    const SignRow mask = MakeMask(size);
    const bool first = this->Get(0);
    const bool last = this->Get(size - 1);
    const std::uint64_t left = (std::uint64_t(1) << Margin) - 1;
    this->Words[0] =
      (this->Words[0] & mask.Words[0]) | (first ? left : 0) | (last ? ~mask.Words[0] & ~left : 0);
    this->Words[1] = (this->Words[1] & mask.Words[1]) | (last ? ~mask.Words[1] : 0);
  }

  /// The bits of vertex x and at least 24 more, lowest first.
  std::uint32_t GetBits(int x) const
  {
    const auto bit = static_cast<unsigned>(x + Margin);
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    std::uint32_t bytes;
    std::memcpy(&bytes, reinterpret_cast<const char*>(this->Words.data()) + bit / 8, sizeof(bytes));
    return bytes >> (bit % 8);
#else
    const std::uint64_t low = this->Words[bit / 64] >> (bit % 64);
    const std::uint64_t high = bit > 64 ? 0 : this->Words[1] << 1 << (63 - bit % 64);
    return static_cast<std::uint32_t>(low | (bit / 64 == 0 ? high : 0));
#endif
  }
};

inline SignRow operator|(const SignRow& a, const SignRow& b)
{
  return { { a.Words[0] | b.Words[0], a.Words[1] | b.Words[1] } };
}
inline SignRow operator&(const SignRow& a, const SignRow& b)
{
  return { { a.Words[0] & b.Words[0], a.Words[1] & b.Words[1] } };
}
inline SignRow operator^(const SignRow& a, const SignRow& b)
{
  return { { a.Words[0] ^ b.Words[0], a.Words[1] ^ b.Words[1] } };
}
inline SignRow operator~(const SignRow& a)
{
  return { { ~a.Words[0], ~a.Words[1] } };
}

/// Calls functor(x) for each vertex whose bit is set, in ascending order.
template <typename Functor>
inline void VisitBits(const SignRow& row, const Functor& functor)
{
  for (int word = 0; word < 2; ++word)
  {
    for (std::uint64_t bits = row.Words[static_cast<std::size_t>(word)]; bits != 0;
         bits &= bits - 1)
    {
      functor(64 * word + __builtin_ctzll(bits) - SignRow::Margin);
    }
  }
}

/// The signs of the vertices of a slice, with two more rows on either side: row y is stored at y +
/// 2.
struct SignSlice
{
  std::array<SignRow, MaximumCodedVertices + 4> Rows;

  SignRow& At(int y) { return this->Rows[static_cast<std::size_t>(y + 2)]; }
  const SignRow& At(int y) const { return this->Rows[static_cast<std::size_t>(y + 2)]; }
};

/// Marks the crossed edges along an axis (0 to 2) that begin at the vertices of row y of a slice,
/// at their first vertices. `above` is the next slice, null for the last one.
inline SignRow FindCrossedEdges(
  int axis, int y, const SignSlice& slice, const SignSlice* above, int sizeX, int sizeY)
{
  const SignRow& row = slice.At(y);
  if (axis == 0)
  {
    return (row ^ row.ShiftDown()) & SignRow::MakeMask(sizeX - 1);
  }
  if (axis == 1 ? y + 1 >= sizeY : !above)
  {
    return {};
  }
  return (row ^ (axis == 1 ? slice.At(y + 1) : above->At(y))) & SignRow::MakeMask(sizeX);
}

} // namespace isosurface

#endif
