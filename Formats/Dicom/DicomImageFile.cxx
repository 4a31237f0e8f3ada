// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomImageFile.h"

#include <limits>

namespace isosurface
{
namespace
{

constexpr std::uint32_t NoLength = 0xffffffff;
// Tags, in the order of little-endian bytes.
constexpr std::uint32_t WrittenItemBegin = 0xe000fffe;
constexpr std::uint32_t WrittenSequenceEnd = 0xe0ddfffe;

} // namespace

void DicomImageFile::Put16(std::uint32_t number)
{
  this->Bytes.push_back(static_cast<std::uint8_t>(number));
  this->Bytes.push_back(static_cast<std::uint8_t>(number >> 8));
}

void DicomImageFile::Put32(std::uint32_t number)
{
  this->Put16(number & 0xffff);
  this->Put16(number >> 16);
}

void DicomImageFile::PutHead(DicomTag tag, const char* kind, std::uint32_t length)
{
  this->Put16(tag >> 16);
  this->Put16(tag & 0xffff);
  this->Bytes.insert(this->Bytes.end(), kind, kind + 2);
  if (kind[0] != 'O')
  {
    this->Put16(length);
    return;
  }
  this->Put16(0);
  this->Put32(length);
}

void DicomImageFile::PutText(DicomTag tag, const char* kind, std::string text)
{
  text.resize((text.size() + 1) / 2 * 2, kind[0] == 'U' ? '\0' : ' ');
  this->PutHead(tag, kind, static_cast<std::uint32_t>(text.size()));
  this->Bytes.insert(this->Bytes.end(), text.begin(), text.end());
}

void DicomImageFile::PutNumber(DicomTag tag, std::int64_t number)
{
  this->PutHead(tag, "US", 2);
  this->Put16(static_cast<std::uint32_t>(number));
}

void DicomImageFile::PutHeader()
{
  const char* const storage = "1.2.840.10008.5.1.4.1.1.7"; // of a secondary capture
  const std::string magic = "DICM";
  this->Bytes.assign(128, 0);
  this->Bytes.insert(this->Bytes.end(), magic.begin(), magic.end());
  this->PutText(0x00020002, "UI", storage);
  this->PutText(0x00020003, "UI", "1.2.3");
  this->PutText(0x00020010, "UI", this->Slice.Syntax);
  this->PutText(0x00080016, "UI", storage);
  this->PutNumber(0x00280002, 1);
  this->PutText(0x00280004, "CS", this->Slice.Photometric);
  this->PutNumber(0x00280010, this->Slice.Rows);
  this->PutNumber(0x00280011, this->Slice.Columns);
  this->PutNumber(0x00280100, static_cast<std::int64_t>(8 * this->GetValueBytes()));
  this->PutNumber(0x00280101, this->Form.Bits);
  this->PutNumber(0x00280102, this->Form.Bits - 1);
  this->PutNumber(0x00280103, this->Form.IsSigned ? 1 : 0);
}

/// Sets the length that stands before `begin`: of all bytes from there on.
Status DicomImageFile::PutLength(std::size_t begin)
{
  if (this->Bytes.size() - begin >= NoLength - 1)
  {
    return Status(
      StatusCode::Unsupported, this->Slice.Path + ": cannot be read: its image has 4 GiB or more");
  }
  this->Bytes.resize(this->Bytes.size() + (this->Bytes.size() - begin) % 2);
  const std::uint64_t length = this->Bytes.size() - begin;
  for (std::size_t byte = 0; byte < 4; ++byte)
  {
    this->Bytes[begin - 4 + byte] = static_cast<std::uint8_t>(length >> (8 * byte));
  }
  return Status::Ok();
}

Status DicomImageFile::MakeError(const std::string& reason) const
{
  return Status(
    StatusCode::Corrupt, this->Slice.Path + ": cannot be read: its image is damaged: " + reason);
}

std::size_t DicomImageFile::GetValueBytes() const
{
  return this->Form.Bits <= 8 ? 1 : this->Form.Bits <= 16 ? 2 : 4;
}

Status DicomImageFile::CheckForm(const std::optional<CompressedForm>& form)
{
  if (!form)
  {
    return this->MakeError("it does not begin as JPEG, JPEG-LS or JPEG 2000");
  }
  if (form->Size !=
    std::array<std::uint64_t, 3>{ static_cast<std::uint64_t>(this->Slice.Columns),
      static_cast<std::uint64_t>(this->Slice.Rows), 1 })
  {
    return this->MakeError("it is of another size than its header says");
  }
  this->Form = *form;
  // What was found with the header has decided the type of the volume.
  const int known = this->Slice.Form ? this->Slice.Form->Bits : this->Slice.BitsStored;
  return form->Bits >= 1 && form->Bits <= known
    ? Status::Ok()
    : this->MakeError(
        "its samples have " + std::to_string(form->Bits) + " bits, other than its header says");
}

Status DicomImageFile::TakePixels(DicomDataSet& tags)
{
  std::vector<std::uint8_t> code;
  ISOSURFACE_RETURN_IF_ERROR(tags.AppendPixels(std::numeric_limits<std::uint64_t>::max(), code));
  ISOSURFACE_RETURN_IF_ERROR(this->CheckForm(FindCompressedForm(code.data(), code.size())));
  this->PutHeader();
  this->PutHead(0x7fe00010, "OB", NoLength);
  this->Put32(WrittenItemBegin); // an empty table, then one fragment
  this->Put32(0);
  this->Put32(WrittenItemBegin);
  this->Put32(0);
  const std::size_t begin = this->Bytes.size();
  this->Bytes.insert(this->Bytes.end(), code.begin(), code.end());
  ISOSURFACE_RETURN_IF_ERROR(this->PutLength(begin));
  this->Put32(WrittenSequenceEnd);
  this->Put32(0);
  return Status::Ok();
}

} // namespace isosurface
