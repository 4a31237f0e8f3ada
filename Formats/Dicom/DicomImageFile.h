// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomImageFile_h
#define isosurface_DicomImageFile_h

#include "Formats/Dicom/DicomCompression.h"
#include "Formats/Dicom/DicomDataSet.h"
#include "Formats/Dicom/DicomSlice.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosurface
{

/**
 * A DICOM file in memory with the compressed image of a slice, and with nothing else: GDCM, which ends
 * the process for many files that are damaged, gets none that we have not written. What is left to it is
 * to decode JPEG, JPEG-LS and JPEG 2000.
 */
class DicomImageFile
{
public:
  explicit DicomImageFile(const DicomSlice& slice)
    : Slice(slice)
  {
  }

  /// Takes the image from the file of the slice, whose header was read. Errors: Corrupt if it begins
  /// as none of them, or is of another size; Unsupported from 4 GiB on, or if its samples have more bits
  /// than those of the slice.
  Status TakePixels(DicomDataSet& tags);
  /// What the image says of itself; its samples are decoded as that.
  const CompressedForm& GetForm() const { return this->Form; }
  /// Of a decoded sample: the fewest of 1, 2 and 4 that have its bits.
  std::size_t GetValueBytes() const;
  /// The file, which begins with its preamble.
  std::vector<std::uint8_t>& GetBytes() { return this->Bytes; }

private:
  Status CheckForm(const std::optional<CompressedForm>& form);
  Status MakeError(const std::string& reason) const;
  void PutHead(DicomTag tag, const char* kind, std::uint32_t length);
  void PutText(DicomTag tag, const char* kind, std::string text);
  void PutNumber(DicomTag tag, std::int64_t number);
  void PutHeader();
  Status PutLength(std::size_t begin);
  void Put16(std::uint32_t number);
  void Put32(std::uint32_t number);

  const DicomSlice& Slice;
  CompressedForm Form;
  std::vector<std::uint8_t> Bytes;
};

} // namespace isosurface

#endif
