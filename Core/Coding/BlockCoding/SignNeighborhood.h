// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SignNeighborhood_h
#define isosurface_SignNeighborhood_h

#include "Coding/BlockCoding/SignCoder.h"
#include "Coding/TrainedModels/SignNetwork.h"

#include <algorithm>
#include <cstdint>

namespace isosurface
{

/// Collects the decoded signs around a vertex as inputs of the network.
class SignNeighborhood
{
public:
  /// Begins a row. Returns whether GetRow() has changed.
  bool BeginRow(const SignRowPlace& place)
  {
    const int y = place.Y;
    const SignNetworkRow before = this->Row;
    this->Row = { !place.Below, place.Below && !place.Below2, y == 0, y == 1,
      y + 1 == place.SizeY };
    this->LastX = place.SizeX - 1;
    this->YYY = place.Slice.At(std::max(y - 3, -2));
    if (!place.Below)
    {
      this->ZMMM = this->ZPPP = this->ZZMM = this->ZZPP = place.Slice.At(y - 1);
      return before != this->Row;
    }
    const SignSlice& second = place.Below2 ? *place.Below2 : *place.Below;
    this->ZMMM = place.Below->At(std::max(y - 3, -2));
    this->ZPPP = place.Below->At(std::min(y + 3, place.SizeY + 1));
    this->ZZMM = second.At(y - 2);
    this->ZZPP = second.At(std::min(y + 2, place.SizeY + 1));
    return before != this->Row;
  }

  const SignNetworkRow& GetRow() const { return this->Row; }

  /// The inputs at vertex x. left: the sign of vertex x - 1; row: decoded up to x.
  SignNetworkInputs Find(bool left, const SignRow& row, const SignRowsAround& rows, int x) const
  {
    const std::uint32_t flip = left ? 127 : 0;
    const auto seven = [&](const SignRow& at) { return at.GetWideWindow(x) ^ flip; };
    const auto five = [&](const SignRow& at) { return (at.GetWindow(x) ^ flip) & 31; };
    const auto three = [&](const SignRow& at) { return (at.GetWindow(x) ^ flip) >> 1 & 7; };
    using Inputs = SignNetworkInputs;
    Inputs inputs;
    const auto set = [&inputs](Inputs::Pattern pattern, std::uint32_t bits)
    { inputs.Patterns[pattern] = static_cast<std::uint8_t>(bits); };
    set(Inputs::Own,
      ((row.GetWideWindow(x - 1) ^ flip) & 7) | (left ? 8 : 0) | (x == 0 ? 16 : 0) |
        (x == 1 ? 32 : 0) | (x == this->LastX ? 64 : 0));
    set(Inputs::Y, seven(rows.Y));
    set(Inputs::YY, seven(rows.YY));
    set(Inputs::Z, seven(rows.Z));
    set(Inputs::ZM, seven(rows.ZM));
    set(Inputs::ZP, seven(rows.ZP));
    set(Inputs::ZZ, seven(rows.ZZ));
    set(Inputs::YYY, five(this->YYY));
    set(Inputs::ZMM, five(rows.ZMM));
    set(Inputs::ZPP, five(rows.ZPP));
    set(Inputs::ZZM, five(rows.ZZM));
    set(Inputs::ZZP, five(rows.ZZP));
    set(Inputs::ZMMMPPP, three(this->ZMMM) | three(this->ZPPP) << 3);
    set(Inputs::ZZMMPP, three(this->ZZMM) | three(this->ZZPP) << 3);
    return inputs;
  }

private:
  SignNetworkRow Row{};
  int LastX = 0;
  SignRow YYY, ZMMM, ZPPP, ZZMM, ZZPP;
};

} // namespace isosurface

#endif
