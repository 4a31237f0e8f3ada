// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignContexts_h
#define isosurface_SignContexts_h

#include "Coding/Prediction/SignRows.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace isosurface
{

/// The decoded rows around the current one: Y is the row before in the slice, Z the same row in the
/// slice before, M and P are one row before and after Z; doubled letters are two rows or slices away.
struct SignRowsAround
{
  SignRow Y, YY, Z, ZM, ZP, ZMM, ZPP, ZZ, ZZM, ZZP;
};

/// Numbers by `own`: the signs of the two vertices before, at x - 2 (bit 0) and x - 1.
using BySignsBefore = std::array<std::uint32_t, 4>;

/// left: if the sign at x - 1 is 1. left2: if that at x - 2 is another one.
constexpr BySignsBefore MakeChanges(std::uint32_t left, std::uint32_t left2)
{
  return { 0, left2, left ^ left2, left };
}

/**
 * The contexts of the signs of eight vertices of a row, found at once in vectors. All signs of a
 * context are relative to that of the left vertex, which is not decoded yet for most of the eight. So
 * they are found for each of the four cases of the two signs before.
 */
class SignContexts
{
public:
  static constexpr int Size = 8;
  static constexpr int NumberOfNeighbors = 12;
  static constexpr int HashBits = 14;
  static constexpr std::size_t NumberOfHashed = 5;

  /// Of one vertex: places in tables.
  struct Indices
  {
    std::array<std::uint32_t, NumberOfHashed> Hashed;
    std::uint32_t Near;  ///< by the 12 nearest neighbours
    std::uint32_t Mixer; ///< below 64
  };

  /// Forgets what was found.
  void Clear() { this->Begin = -Size; }

  bool Has(int x) const { return static_cast<unsigned>(x - this->Begin) < Size; }

  /// Finds the contexts of the vertices x .. x + 7; all of them only if `mixed`.
  void Find(const SignRowsAround& rows, int x, bool mixed)
  {
    this->Begin = x;
    constexpr Vector steps = { 0, 1, 2, 3, 4, 5, 6, 7 };
    // The first five bits of a lane are the signs at x - 2 .. x + 2.
    const Vector y = rows.Y.GetBits(x - 2) >> steps;
    const Vector z = rows.Z.GetBits(x - 2) >> steps;
    const Vector zm = rows.ZM.GetBits(x - 2) >> steps;
    const Vector zp = rows.ZP.GetBits(x - 2) >> steps;
    const Vector near = (y >> 1 & 7) | (z << 2 & 7 << 3) | (zm << 5 & 7 << 6) | (zp << 8 & 7 << 9);
    Store(near, this->Near);
    if (!mixed)
    {
      return;
    }
    const Vector yy = rows.YY.GetBits(x - 2) >> steps;
    const Vector zz = rows.ZZ.GetBits(x - 2) >> steps;
    const Vector zmm = rows.ZMM.GetBits(x - 2) >> steps;
    const Vector zpp = rows.ZPP.GetBits(x - 2) >> steps;
    const Vector zzm = rows.ZZM.GetBits(x - 2) >> steps;
    const Vector zzp = rows.ZZP.GetBits(x - 2) >> steps;
    const Vector core = (y >> 2 & 3) | (z & 3 << 2) | (zp << 2 & 1 << 4);
    // Bit 0 is for the sign at x - 2.
    const Vector out = (yy >> 1 & 1 << 1) | (zz & 1 << 2) | (y << 3 & 1 << 3) | (y & 1 << 4) |
      (z << 5 & 1 << 5) | (z << 2 & 1 << 6);
    const Vector wide = (zmm << 18 & 1 << 20) | (zpp << 19 & 1 << 21) | (yy << 21 & 1 << 22) |
      (yy << 20 & 1 << 23) | (zz << 23 & 1 << 24) | (zz << 22 & 1 << 25);
    const Vector behind =
      (zz << 11 & 7 << 12) | (zzm << 13 & 1 << 15) | (zzp << 14 & 1 << 16) | (yy << 16 & 7 << 17);
    const Vector across = (zmm << 11 & 7 << 12) | (zpp << 14 & 7 << 15) | (yy << 17 & 7 << 18);
    const Vector keys[NumberOfKeys] = { near | out << 12, near | out << 12 | wide | 1u << 30,
      near | behind | 1u << 31, core | out << 5 | across | 3u << 30 };
    for (std::size_t own = 0; own < this->Slots.size(); ++own)
    {
      for (std::size_t n = 0; n < NumberOfKeys; ++n)
      {
        const Vector product = (keys[n] ^ KeyChanges[n][own]) * 0x9E3779B1u;
        Store((product ^ product >> 15) >> 3 & ((1u << HashBits) - 1), this->Slots[own][n]);
      }
    }
    Store(core, this->Core);
    Store(
      out >> 1 | (yy & 31) << 6 | (zz & 31) << 11 | (zmm & 31) << 16 | (zpp & 31) << 21, this->Far);
  }

  std::uint32_t GetNear(int x, std::uint32_t own) const
  {
    return this->Near[this->At(x)] ^ NearChanges[own];
  }
  Indices GetIndices(int x, std::uint32_t own) const
  {
    const std::size_t at = this->At(x);
    const auto& slots = this->Slots[own];
    const std::uint32_t near = this->GetNear(x, own);
    const std::uint32_t mixer = this->Core[at] ^ CoreChanges[own];
    const std::uint32_t far = this->Far[at] ^ FarChanges[own];
    return { { slots[0][at], slots[1][at], Count(near) | Count(far) << 4 | (mixer & 31) << 9,
               slots[2][at], slots[3][at] },
      near, mixer };
  }

private:
  static constexpr std::size_t NumberOfKeys = 4; ///< to be hashed
  // What the signs before change in keys: all signs, and the one at x - 2.
  static constexpr std::uint32_t AllNear = (1u << NumberOfNeighbors) - 1;
  static constexpr std::uint32_t AllOut = 0x7eu;
  static constexpr BySignsBefore NearChanges = MakeChanges(AllNear, 0);
  static constexpr BySignsBefore CoreChanges = MakeChanges(31, 32);
  static constexpr BySignsBefore FarChanges = MakeChanges((1u << 26) - 1, 1u << 26);
  static constexpr std::array<BySignsBefore, NumberOfKeys> KeyChanges = {
    MakeChanges(AllNear | AllOut << 12, 1u << 12),
    MakeChanges(AllNear | AllOut << 12 | 63u << 20, 1u << 12),
    MakeChanges((1u << 20) - 1, 1u << 20),
    MakeChanges(31 | AllOut << 5 | 1023u << 12, 1u << 5),
  };

  using Lanes = std::array<std::uint32_t, Size>;
  using Vector = std::uint32_t __attribute__((vector_size(4 * Size)));

  std::size_t At(int x) const { return static_cast<std::size_t>(x - this->Begin); }

  static std::uint32_t Count(std::uint32_t bits)
  {
    return static_cast<std::uint32_t>(__builtin_popcount(bits));
  }

  static void Store(const Vector& lanes, Lanes& numbers)
  {
    std::memcpy(numbers.data(), &lanes, sizeof(lanes));
  }

  int Begin = -Size;
  alignas(32) Lanes Near;
  alignas(32) Lanes Core;                                           ///< the nearest of all
  alignas(32) Lanes Far;                                            ///< signs that are only counted
  alignas(32) std::array<std::array<Lanes, NumberOfKeys>, 4> Slots; ///< hashed keys, by `own`
};

} // namespace isosurface

#endif
