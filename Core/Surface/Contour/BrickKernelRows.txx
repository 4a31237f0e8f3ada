// SPDX-License-Identifier: BSD-3-Clause
// Inside or outside, the numbering of crossed edges, rows of them. A part of BrickKernel.txx.
#ifndef isosurface_BrickKernelRows_txx
#define isosurface_BrickKernelRows_txx

#include "Surface/Contour/BrickKernelBasics.txx"

#if defined(__SSE2__)
#  include <emmintrin.h>
#endif

namespace isosurface
{
namespace ISOSURFACE_KERNEL
{
namespace
{

// Packs 32 bytes that are 0 or 1 into bits.
inline Word PackFlags(const std::uint8_t* flags)
{
#if defined(__SSE2__)
  const __m128i low = _mm_load_si128(reinterpret_cast<const __m128i*>(flags));
  const __m128i high = _mm_load_si128(reinterpret_cast<const __m128i*>(flags + 16));
  // The shift moves each flag to the top bit of its byte, which movemask gathers.
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(low, 7))) |
    static_cast<Word>(static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(high, 7)))) << 16;
#else
  Word bits = 0;
  for (int n = 0; n < 32; ++n)
  {
    bits |= static_cast<Word>(flags[n]) << n;
  }
  return bits;
#endif
}

template <typename T>
inline Word ClassifyRow(const T* row, std::ptrdiff_t stride, int count, T threshold)
{
  if (stride == 1 && count >= 32)
  {
    alignas(32) std::uint8_t flags[32];
    for (int i = 0; i < 32; ++i)
    {
      flags[i] = row[i] >= threshold;
    }
    Word bits = PackFlags(flags);
    if (count == 33)
    {
      bits |= static_cast<Word>(row[32] >= threshold) << 32;
    }
    return bits;
  }
  Word bits = 0;
  for (int i = 0; i < count; ++i)
  {
    bits |= static_cast<Word>(row[i * stride] >= threshold) << i;
  }
  return bits;
}

void ClassifyRows(ValueType type, const BrickSamples& samples, const void* threshold, Word* inside)
{
  Dispatch(type,
    [&](auto zero)
    {
      using T = decltype(zero);
      const T limit = *static_cast<const T*>(threshold);
      const T* plane = static_cast<const T*>(samples.First);
      const std::ptrdiff_t lastInRow = (samples.Size[0] - 1) * samples.Stride[0];
      for (int k = 0; k < samples.Size[2]; ++k, plane += samples.Stride[2])
      {
        const T* row = plane;
        for (int j = 0; j < samples.Size[1]; ++j, row += samples.Stride[1])
        {
          // The rows of a brick are too short for the prefetching of the processor.
          if (k + 1 < samples.Size[2])
          {
            __builtin_prefetch(row + samples.Stride[2]);
            __builtin_prefetch(row + samples.Stride[2] + lastInRow);
          }
          *inside++ = ClassifyRow(row, samples.Stride[0], samples.Size[0], limit);
        }
      }
    });
}

// Appends a code for each bit. Always writes four codes at a time, which is cheaper than a branch
// for each.
inline EdgeCode* AppendCodes(EdgeCode* codes, Word bits, EdgeCode base)
{
  const int count = CountBits(bits);
  EdgeCode* next = codes;
  for (int left = count;; left -= 4)
  {
    for (int n = 0; n < 4; ++n)
    {
      next[n] = base + static_cast<EdgeCode>(FindFirstBit(bits | Word(1) << 63));
      bits &= bits - 1;
    }
    if (left <= 4)
    {
      return codes + count;
    }
    next += 4;
  }
}

inline unsigned CaseOf(int i, Word row00, Word row10, Word row01, Word row11)
{
  return static_cast<unsigned>(
    (row00 >> i & 3) | (row10 >> i & 3) << 2 | (row01 >> i & 3) << 4 | (row11 >> i & 3) << 6);
}

// The active cells of a row of cells, by their low vertex.
inline Word ActiveCells(Word row00, Word row10, Word row01, Word row11, Word cells)
{
  Word any = row00 | row10 | row01 | row11;
  Word all = row00 & row10 & row01 & row11;
  any |= any >> 1;
  all &= all >> 1;
  return any & ~all & cells;
}

// The sum of the crossed edges of each cell in a row of cells. An edge counts once for each cell.
inline Word CountCorners(Word row00, Word row10, Word row01, Word row11, Word cells)
{
  const auto alongX = [cells](Word row) { return CountBits((row ^ row >> 1) & cells); };
  const auto across = [cells](Word from, Word to)
  {
    const Word crossed = from ^ to;
    return CountBits(crossed & cells) + CountBits(crossed >> 1 & cells);
  };
  const int count = alongX(row00) + alongX(row10) + alongX(row01) + alongX(row11) +
    across(row00, row10) + across(row01, row11) + across(row00, row01) + across(row10, row11);
  return static_cast<Word>(count);
}

BrickCounts NumberRows(const int size[3], const Word* inside, const BrickOwnership& ownership,
  std::uint32_t* offsets, EdgeCode* codes)
{
  const int nx = size[0];
  const int ny = size[1];
  const int nz = size[2];
  const Word cells = MaskBelow(nx - 1);
  EdgeCode* const first = codes;
  Word triangles = 0;
  Word corners = 0; // triangles of a cell = corners of its polygons - 2 * polygons
  for (int k = 0; k < nz; ++k)
  {
    const int zPlace = PlaceOf(k, nz);
    for (int j = 0; j < ny; ++j, ++inside)
    {
      const int yPlace = PlaceOf(j, ny);
      const Word row = *inside;
      const Word rowY = j + 1 < ny ? inside[1] : row;
      const Word rowZ = k + 1 < nz ? inside[ny] : row;
      const Word x = (row ^ row >> 1) & cells;
      const Word y = row ^ rowY;
      const Word z = row ^ rowZ;
      *offsets++ = static_cast<std::uint32_t>(codes - first);
      if ((x | y | z) != 0)
      {
        const EdgeCode base = static_cast<EdgeCode>(j) << 6 | static_cast<EdgeCode>(k) << 12;
        codes = AppendCodes(codes, x & ownership.X[yPlace][zPlace], base);
        codes = AppendCodes(codes, y & ownership.Y[zPlace], base | 1u << 18);
        codes = AppendCodes(codes, z & ownership.Z[yPlace], base | 2u << 18);
      }
      if (j + 1 == ny || k + 1 == nz)
      {
        continue;
      }
      const Word rowYZ = inside[ny + 1];
      Word active = ActiveCells(row, rowY, rowZ, rowYZ, cells);
      if (active == 0)
      {
        continue;
      }
      corners += CountCorners(row, rowY, rowZ, rowYZ, cells);
      for (; active != 0; active &= active - 1)
      {
        triangles += MarchingCubesCases[CaseOf(FindFirstBit(active), row, rowY, rowZ, rowYZ)] >> 60;
      }
    }
  }
  return { static_cast<std::uint32_t>(codes - first), static_cast<std::uint32_t>(triangles),
    static_cast<std::uint32_t>((corners - triangles) / 2) };
}

void FindRows(const NumberedRows& rows, int k, EdgeRow* x, EdgeRow* y, EdgeRow* z)
{
  const int nx = rows.Size[0];
  const int ny = rows.Size[1];
  const int zPlace = PlaceOf(k, rows.Size[2]);
  const Word cells = MaskBelow(nx - 1);
  const Word* inside = rows.Inside + k * ny;
  const std::uint32_t* offsets = rows.Offsets + k * ny;
  const Word* insideZ = k + 1 < rows.Size[2] ? inside + ny : inside;
  for (int j = 0; j < ny; ++j)
  {
    const int yPlace = PlaceOf(j, ny);
    const Word row = inside[j];
    x[j].Bits = (row ^ row >> 1) & cells & rows.Ownership->X[yPlace][zPlace];
    x[j].First = rows.FirstPoint + offsets[j];
    y[j].Bits = (row ^ inside[j + 1 < ny ? j + 1 : j]) & rows.Ownership->Y[zPlace];
    y[j].First = x[j].First + CountBits(x[j].Bits);
    z[j].Bits = (row ^ insideZ[j]) & rows.Ownership->Z[yPlace];
    z[j].First = y[j].First + CountBits(y[j].Bits);
  }
}

} // namespace
} // namespace ISOSURFACE_KERNEL
} // namespace isosurface

#endif
