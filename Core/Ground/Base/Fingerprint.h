// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Fingerprint_h
#define isosurface_Fingerprint_h

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

namespace isosurface
{

/// A checksum of several properties, for ranks to compare in one value (CommonValue).
class Fingerprint
{
public:
  void AddNumber(std::uint64_t number) { AppendLittleEndian(this->Bytes, number); }
  void AddReal(double real) { AppendLittleEndian(this->Bytes, real); }
  void AddText(const std::string& text)
  {
    this->AddNumber(text.size());
    this->Bytes.insert(this->Bytes.end(), text.begin(), text.end());
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

  std::uint64_t Get() const { return ComputeChecksum(this->Bytes.data(), this->Bytes.size()); }

private:
  std::vector<std::uint8_t> Bytes;
};

} // namespace isosurface

#endif
