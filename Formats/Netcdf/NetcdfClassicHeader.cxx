// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Netcdf/NetcdfClassicHeader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace isosurface
{
namespace
{

constexpr std::uint64_t ShortHeaderSize = std::uint64_t{ 64 } << 10;
constexpr std::uint64_t MaximumHeaderSize = std::uint64_t{ 64 } << 20;

/// To a multiple of 4.
double RoundUp(double bytes)
{
  return 4 * std::ceil(bytes / 4);
}

/// Reads the header from front to back. After its end, everything is 0 and IsComplete() is false.
class ClassicHeader
{
public:
  explicit ClassicHeader(std::vector<std::uint8_t> bytes)
    : Bytes(std::move(bytes))
  {
    this->Version = this->TakeNumber(4) & 0xff;
  }

  bool IsComplete() const { return !this->IsOver; }

  /// The end of the variable's samples in the file; 0 if there is no such variable.
  double FindEnd(const std::string& variable)
  {
    const double records = static_cast<double>(this->TakeSize());
    this->TakeDimensions();
    this->SkipAttributes();
    this->TakeNumber(4); // the tag of the list
    const std::uint64_t count = this->TakeSize();
    double found = 0;
    for (std::uint64_t number = 0; number < count && !this->IsOver; ++number)
    {
      const Variable taken = this->TakeVariable();
      this->RecordBytes += taken.IsRecord ? RoundUp(taken.Bytes) : 0;
      this->RecordVariables += taken.IsRecord ? 1 : 0;
      if (taken.Name == variable)
      {
        found = taken.Begin + taken.Bytes;
        this->FoundRecord = taken.IsRecord;
        this->FoundBytes = taken.Bytes;
      }
    }
    if (found > 0 && this->FoundRecord)
    {
      // A lone variable has its records without gaps.
      const double step = this->RecordVariables == 1 ? this->FoundBytes : this->RecordBytes;
      return records > 0 ? found + step * (records - 1) : 0;
    }
    return found;
  }

private:
  struct Variable
  {
    std::string Name;
    double Begin = 0;
    double Bytes = 0; ///< of a record, if it has records
    bool IsRecord = false;
  };

  std::uint64_t TakeNumber(std::size_t size)
  {
    this->IsOver = this->IsOver || this->Bytes.size() - this->At < size;
    std::uint64_t number = 0;
    for (std::size_t byte = 0; byte < size && !this->IsOver; ++byte)
    {
      number = number << 8 | this->Bytes[this->At++];
    }
    return number;
  }
  std::uint64_t TakeSize() { return this->TakeNumber(this->Version == 5 ? 8 : 4); }
  void Skip(double bytes)
  {
    this->IsOver =
      this->IsOver || RoundUp(bytes) > static_cast<double>(this->Bytes.size() - this->At);
    this->At += this->IsOver ? 0 : static_cast<std::size_t>(RoundUp(bytes));
  }
  std::string TakeName()
  {
    const std::uint64_t size = this->TakeSize();
    const std::size_t begin = this->At;
    this->Skip(static_cast<double>(size));
    return this->IsOver ? std::string()
                        : std::string(this->Bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                            this->Bytes.begin() + static_cast<std::ptrdiff_t>(begin + size));
  }
  static double GetTypeSize(std::uint64_t type)
  {
    switch (type)
    {
      case 3:
      case 8:
        return 2;
      case 4:
      case 5:
      case 9:
        return 4;
      case 6:
      case 10:
      case 11:
        return 8;
      default:
        return 1;
    }
  }
  void TakeDimensions()
  {
    this->TakeNumber(4);
    const std::uint64_t count = this->TakeSize();
    for (std::uint64_t number = 0; number < count && !this->IsOver; ++number)
    {
      this->TakeName();
      this->Dimensions.push_back(this->TakeSize());
    }
  }
  void SkipAttributes()
  {
    this->TakeNumber(4);
    const std::uint64_t count = this->TakeSize();
    for (std::uint64_t number = 0; number < count && !this->IsOver; ++number)
    {
      this->TakeName();
      const double size = GetTypeSize(this->TakeNumber(4));
      this->Skip(size * static_cast<double>(this->TakeSize()));
    }
  }
  Variable TakeVariable()
  {
    Variable variable;
    variable.Name = this->TakeName();
    const std::uint64_t rank = this->TakeSize();
    double samples = 1;
    for (std::uint64_t axis = 0; axis < rank && !this->IsOver; ++axis)
    {
      const std::uint64_t number = this->TakeSize();
      const std::uint64_t size =
        number < this->Dimensions.size() ? this->Dimensions[static_cast<std::size_t>(number)] : 1;
      variable.IsRecord = variable.IsRecord || size == 0;
      samples *= size == 0 ? 1 : static_cast<double>(size);
    }
    this->SkipAttributes();
    variable.Bytes = std::min(samples * GetTypeSize(this->TakeNumber(4)), 0x1p62);
    this->TakeSize(); // its own number of bytes, which large variables do not have
    variable.Begin = static_cast<double>(this->TakeNumber(this->Version == 1 ? 4 : 8));
    return variable;
  }

  std::vector<std::uint8_t> Bytes;
  std::size_t At = 0;
  bool IsOver = false;
  std::uint64_t Version = 0;
  std::vector<std::uint64_t> Dimensions;
  double RecordBytes = 0;
  int RecordVariables = 0;
  bool FoundRecord = false;
  double FoundBytes = 0;
};

} // namespace

Status CheckNetcdfClassicSize(
  FileSystem& files, const std::string& path, const std::string& variable)
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, files.OpenForReading(path));
  const std::uint64_t size = file->GetSize();
  // Most headers are short.
  double end = 0;
  bool isComplete = false;
  for (std::uint64_t most = ShortHeaderSize; !isComplete && most <= MaximumHeaderSize; most *= 32)
  {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min(size, most)));
    ISOSURFACE_RETURN_IF_ERROR(file->Read(0, bytes.size(), bytes.data()));
    if (bytes.size() < 4 || !std::equal(bytes.begin(), bytes.begin() + 3, "CDF"))
    {
      return Status::Ok();
    }
    ClassicHeader header(std::move(bytes));
    end = header.FindEnd(variable);
    isComplete = header.IsComplete();
  }
  if (!isComplete)
  {
    return Status(
      StatusCode::Corrupt, path + ": cannot be read: truncated: its header is not complete");
  }
  if (end > static_cast<double>(size))
  {
    // It may be more than an integer counts.
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.0f", end);
    return Status(StatusCode::Corrupt,
      path + ":" + variable + ": cannot be read: truncated: the file has " + std::to_string(size) +
        " bytes, and the samples end after " + text.data());
  }
  return Status::Ok();
}

} // namespace isosurface
