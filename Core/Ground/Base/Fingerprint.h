// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Fingerprint_h
#define isosurface_Fingerprint_h

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <array>
#include <cstdint>
#include <iterator>
#include <string>

namespace isosurface
{

/// A checksum of several properties, for ranks to compare in one value (CommonValue). It takes no
/// memory, which one rank could lack before all agree.
class Fingerprint
{
public:
  void AddNumber(std::uint64_t number) { this->AddValue(number); }
  void AddReal(double real) { this->AddValue(real); }
  void AddText(const std::string& text)
  {
    this->AddNumber(text.size());
    this->Sum = ComputeChecksum(text.data(), text.size(), this->Sum);
  }
  template <typename Range>
  void AddReals(const Range& reals)
  {
    this->AddNumber(std::size(reals));
    for (const double real : reals)
    {
      this->AddReal(real);
    }
  }

  std::uint64_t Get() const { return this->Sum; }

private:
  template <typename T>
  void AddValue(T value)
  {
    std::array<std::uint8_t, sizeof(T)> bytes;
    StoreLittleEndian(bytes.data(), value);
    this->Sum = ComputeChecksum(bytes.data(), bytes.size(), this->Sum);
  }

  std::uint64_t Sum = 0;
};

} // namespace isosurface

#endif
