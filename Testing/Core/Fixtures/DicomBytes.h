// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_Testing_DicomBytes_h
#define isosurface_Testing_DicomBytes_h

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/// Writes the elements of a DICOM file one after another.
class DicomBytes
{
public:
  using Bytes = std::vector<std::uint8_t>;
  static constexpr std::uint32_t Undefined = 0xffffffff;
  static constexpr std::uint32_t ItemBegin = 0xfffee000;
  static constexpr std::uint32_t ItemEnd = 0xfffee00d;
  static constexpr std::uint32_t SequenceEnd = 0xfffee0dd;

  bool IsImplicit = false;
  bool IsBigEndian = false;

  const Bytes& Get() const { return this->All; }

  /// Preamble and group 2.
  DicomBytes& PutStart(const std::string& syntax)
  {
    this->All.assign(128, 0);
    this->PutRaw("DICM");
    return this->PutText(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.2")
      .PutText(0x00020010, "UI", syntax);
  }
  /// The kind with a length, of 16 bits unless it is O*, SQ, UN or UT.
  DicomBytes& PutHead(std::uint32_t tag, const std::string& kind, std::uint32_t length)
  {
    this->Put(tag >> 16, 2).Put(tag & 0xffff, 2);
    const bool isDelimiter = tag >> 16 == 0xfffe;
    if (this->IsImplicit || isDelimiter)
    {
      return this->Put(length, 4);
    }
    this->PutRaw(kind);
    const bool isLong = kind[0] == 'O' || kind == "SQ" || kind == "UN" || kind == "UT";
    return isLong ? this->Put(0, 2).Put(length, 4) : this->Put(length, 2);
  }
  DicomBytes& PutItem(std::uint32_t length = Undefined)
  {
    return this->PutHead(ItemBegin, "", length);
  }
  DicomBytes& PutEnd(std::uint32_t tag) { return this->PutHead(tag, "", 0); }
  DicomBytes& PutBytes(std::uint32_t tag, const std::string& kind, const Bytes& bytes)
  {
    this->PutHead(tag, kind, static_cast<std::uint32_t>(bytes.size()));
    return this->PutRaw(std::string(bytes.begin(), bytes.end()));
  }
  DicomBytes& PutText(std::uint32_t tag, const std::string& kind, std::string text)
  {
    text.resize((text.size() + 1) / 2 * 2, kind == "UI" ? '\0' : ' ');
    return this->PutBytes(tag, kind, Bytes(text.begin(), text.end()));
  }
  DicomBytes& PutNumber(std::uint32_t tag, std::uint32_t number)
  {
    return this->PutHead(tag, "US", 2).Put(number, 2);
  }
  DicomBytes& PutRaw(const std::string& text)
  {
    this->All.insert(this->All.end(), text.begin(), text.end());
    return *this;
  }
  /// What says of which size and type an image is, and where it lies.
  DicomBytes& PutImage(std::uint32_t columns, std::uint32_t rows, std::uint32_t bits = 16,
    const std::string& place = "1\\2\\3")
  {
    return this->PutText(0x0008103e, "LO", "head")
      .PutText(0x0020000e, "UI", "1.2.3")
      .PutText(0x00200032, "DS", place)
      .PutText(0x00200037, "DS", "1\\0\\0\\0\\1\\0")
      .PutNumber(0x00280002, 1)
      .PutText(0x00280004, "CS", "MONOCHROME2")
      .PutNumber(0x00280010, rows)
      .PutNumber(0x00280011, columns)
      .PutNumber(0x00280100, bits)
      .PutNumber(0x00280101, bits)
      .PutNumber(0x00280102, bits - 1)
      .PutNumber(0x00280103, 0);
  }
  DicomBytes& Put(std::uint32_t number, std::size_t size)
  {
    for (std::size_t byte = 0; byte < size; ++byte)
    {
      const std::size_t shift = 8 * (this->IsBigEndian ? size - 1 - byte : byte);
      this->All.push_back(static_cast<std::uint8_t>(number >> shift));
    }
    return *this;
  }

private:
  Bytes All;
};

} // namespace isosurface

#endif
