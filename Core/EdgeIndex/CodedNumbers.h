// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_CodedNumbers_h
#define isosurface_CodedNumbers_h

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isosurface
{

/// Appends a number in groups of 7 bits, lowest first, of which all but the last have the top bit
/// set.
inline void AppendNumber(std::vector<std::uint8_t>& bytes, std::uint64_t number)
{
  while (number > 127)
  {
    bytes.push_back(static_cast<std::uint8_t>(number | 128));
    number >>= 7;
  }
  bytes.push_back(static_cast<std::uint8_t>(number));
}

/// Appends a signed number n as 2 n, or -2 n - 1 if negative.
inline void AppendSigned(std::vector<std::uint8_t>& bytes, std::int64_t number)
{
  AppendNumber(
    bytes, (static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63));
}

/// Reads what the functions above wrote: numbers below 2^63. After an error everything is 0.
class NumberReader
{
public:
  NumberReader(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , End(bytes + size)
  {
  }
  std::uint64_t ReadNumber()
  {
    std::uint64_t number = 0;
    for (int shift = 0; shift < 63; shift += 7)
    {
      const std::uint8_t byte = this->ReadByte();
      number |= static_cast<std::uint64_t>(byte & 127) << shift;
      if (byte < 128)
      {
        return number;
      }
    }
    this->Failed = true;
    return 0;
  }
  std::int64_t ReadSigned()
  {
    const std::uint64_t number = this->ReadNumber();
    return static_cast<std::int64_t>((number >> 1) ^ (0 - (number & 1)));
  }
  std::uint8_t ReadByte()
  {
    if (this->Next == this->End)
    {
      this->Failed = true;
      return 0;
    }
    return *this->Next++;
  }
  const std::uint8_t* GetNext() const { return this->Next; }
  std::size_t GetLeft() const { return static_cast<std::size_t>(this->End - this->Next); }
  bool HasFailed() const { return this->Failed; }

private:
  const std::uint8_t* Next;
  const std::uint8_t* End;
  bool Failed = false;
};

} // namespace isosurface

#endif
