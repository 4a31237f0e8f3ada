// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_BytePlanes_h
#define isosurface_BytePlanes_h

#include "Coding/Prediction/SignRows.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/**
 * The code of a block in the profile working: rows of sign bits, and one number for each value or
 * crossing, as planes of bytes. A plane has the same byte of all rows, or of all numbers; each is
 * compressed by itself with zstd, or kept as it is.
 */
class BytePlanes
{
public:
  /// Begins a block to encode. size: its vertices on each axis.
  void Begin(const std::array<int, 3>& size);

  /// Begins a block to decode: reads what Append wrote from the front of `bytes`, and returns how
  /// many bytes that are; 0 if no encoder wrote them.
  std::size_t Begin(
    const std::array<int, 3>& size, const std::uint8_t* bytes, std::size_t numberOfBytes);

  void Append(std::vector<std::uint8_t>& bytes) const;

  // Rows and numbers are taken in the order in which they were added.

  /// Adds the bits of the vertices of a row.
  void AddRow(const SignRow& row)
  {
    const std::uint64_t words[2] = { row.Words[0] >> SignRow::Margin |
        row.Words[1] << (64 - SignRow::Margin),
      row.Words[1] >> SignRow::Margin };
    std::size_t at = this->Row++;
    for (std::size_t byte = 0; byte < this->BytesOfRow; ++byte, at += this->NumberOfRows)
    {
      this->Rows[at] = static_cast<std::uint8_t>(words[byte / 8] >> (byte % 8 * 8));
    }
  }
  /// The bits; those of the margins are 0.
  SignRow TakeRow()
  {
    std::uint64_t words[2] = { 0, 0 };
    std::size_t at = this->Row++;
    for (std::size_t byte = 0; byte < this->BytesOfRow; ++byte, at += this->NumberOfRows)
    {
      words[byte / 8] |= std::uint64_t{ this->Rows[at] } << (byte % 8 * 8);
    }
    const SignRow row = { { words[0] << SignRow::Margin,
      words[0] >> (64 - SignRow::Margin) | words[1] << SignRow::Margin } };
    return row & SignRow::MakeMask(this->SizeX);
  }

  void Add(std::uint64_t number) { this->Numbers.push_back(number); }

  /// The next number. Beyond the last one, and above `maximum`, there are only zeros.
  std::uint64_t Take(std::uint64_t maximum)
  {
    if (this->Taken == this->NumberOfNumbers)
    {
      this->IsBroken = true;
      return 0;
    }
    std::uint64_t number = 0;
    std::size_t at = this->Taken++;
    for (unsigned plane = 0; plane < this->NumberOfPlanes; ++plane, at += this->NumberOfNumbers)
    {
      number |= std::uint64_t{ this->Planes[at] } << (8 * plane);
    }
    this->IsBroken = this->IsBroken || number > maximum;
    return number > maximum ? 0 : number;
  }

  /// Whether all numbers were taken, and no other ones.
  bool IsComplete() const { return !this->IsBroken && this->Taken == this->NumberOfNumbers; }

private:
  void SetSize(const std::array<int, 3>& size);

  int SizeX = 0;
  std::size_t BytesOfRow = 0;
  std::size_t NumberOfRows = 0;
  std::size_t Row = 0;
  std::vector<std::uint8_t> Rows;
  std::vector<std::uint64_t> Numbers; ///< added
  std::vector<std::uint8_t> Planes;   ///< of the numbers to take
  std::size_t NumberOfNumbers = 0;
  unsigned NumberOfPlanes = 0;
  std::size_t Taken = 0;
  bool IsBroken = false;
};

} // namespace isosurface

#endif
