// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Coding_h
#define isosurface_Coding_h

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

// How numbers become bytes, in files and in messages between ranks: little-endian, or as varints.
// A big-endian port has this one place to change.
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#  error "ScalableIsosurface reads and writes little-endian files and has no byte swapping yet."
#endif

namespace isosurface
{

/// Reads a little-endian value from sizeof(T) bytes of any alignment.
template <typename T>
T LoadLittleEndian(const void* bytes)
{
  static_assert(std::is_trivially_copyable_v<T>, "only plain values have a byte order");
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Writes a value as sizeof(T) little-endian bytes at any alignment.
template <typename T>
void StoreLittleEndian(void* bytes, T value)
{
  static_assert(std::is_trivially_copyable_v<T>, "only plain values have a byte order");
  std::memcpy(bytes, &value, sizeof(T));
}

template <typename T>
void AppendLittleEndian(std::vector<std::uint8_t>& bytes, T value)
{
  bytes.resize(bytes.size() + sizeof(T));
  StoreLittleEndian(bytes.data() + bytes.size() - sizeof(T), value);
}

/**
 * Appends a number as a varint (unsigned LEB128): groups of 7 bits, the least significant first,
 * one a byte; the top bit is set in all bytes but the last. At most MaximumVarintSize bytes.
 */
inline void AppendVarint(std::vector<std::uint8_t>& bytes, std::uint64_t number)
{
  for (; number > 127; number >>= 7)
  {
    bytes.push_back(static_cast<std::uint8_t>(number | 128));
  }
  bytes.push_back(static_cast<std::uint8_t>(number));
}

/// Appends a signed number as a varint, in zigzag order: 0, -1, 1, -2 ... as 0, 1, 2, 3 ...
inline void AppendSignedVarint(std::vector<std::uint8_t>& bytes, std::int64_t number)
{
  const std::uint64_t sign = number < 0 ? ~std::uint64_t{ 0 } : 0;
  AppendVarint(bytes, (static_cast<std::uint64_t>(number) << 1) ^ sign);
}

/// The bytes of the longest varint, one of 64 bits.
constexpr std::size_t MaximumVarintSize = 10;

/**
 * Reads numbers from bytes one after the other, and never beyond their end. If a read fails (too
 * few bytes are left, or the number does not fit in its type), it returns 0, as do all reads after
 * it, and HasFailed() is true. So a parser may read all fields and check once; but it must compare
 * a size with GetRemaining() before it allocates memory of that size. The bytes must outlive the
 * reader.
 */
class ByteReader
{
public:
  ByteReader(const std::uint8_t* bytes, std::size_t size)
    : Next(bytes)
    , End(bytes + size)
  {
  }
  explicit ByteReader(const std::vector<std::uint8_t>& bytes)
    : ByteReader(bytes.data(), bytes.size())
  {
  }

  /// A little-endian value.
  template <typename T>
  T Read()
  {
    const std::uint8_t* bytes = this->ReadBytes(sizeof(T));
    return bytes ? LoadLittleEndian<T>(bytes) : T{};
  }
  /// As many little-endian values as the array or vector has.
  template <typename Values>
  void ReadAll(Values& values)
  {
    for (auto& value : values)
    {
      value = this->Read<std::decay_t<decltype(value)>>();
    }
  }
  /// A varint that is at most the maximum of the integer type T, which may be signed.
  template <typename T = std::uint64_t>
  T ReadVarint()
  {
    std::uint64_t number = 0;
    for (int shift = 0; shift < 70; shift += 7)
    {
      if (this->Next == this->End)
      {
        break;
      }
      // The analyzer takes the bytes of a vector that is not empty for a null pointer.
      const std::uint64_t byte = *this->Next++; // NOLINT(clang-analyzer-core.NullDereference)
      if (shift == 63 && byte > 1)
      {
        break;
      }
      number |= (byte & 127) << shift;
      if (byte < 128)
      {
        if (number > static_cast<std::uint64_t>(std::numeric_limits<T>::max()))
        {
          break;
        }
        return static_cast<T>(number);
      }
    }
    this->Fail();
    return 0;
  }
  /// A signed varint of any 64 bits.
  std::int64_t ReadSignedVarint()
  {
    const auto number = this->ReadVarint();
    return static_cast<std::int64_t>((number >> 1) ^ (0 - (number & 1)));
  }
  /// The next `size` bytes, in place; nullptr if fewer are left.
  const std::uint8_t* ReadBytes(std::size_t size)
  {
    if (this->Failed || size > this->GetRemaining())
    {
      this->Fail();
      return nullptr;
    }
    const std::uint8_t* bytes = this->Next;
    this->Next += size;
    return bytes;
  }

  /// How many bytes are left; 0 after a failed read.
  std::size_t GetRemaining() const { return static_cast<std::size_t>(this->End - this->Next); }
  bool HasFailed() const { return this->Failed; }

private:
  void Fail()
  {
    this->Failed = true;
    this->Next = this->End;
  }

  const std::uint8_t* Next;
  const std::uint8_t* End;
  bool Failed = false;
};

} // namespace isosurface

#endif
