// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_DicomDataSet_h
#define isosurface_DicomDataSet_h

#include "Formats/Dicom/DicomStream.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace isosurface
{

/// Group and element: 0x00280010 is (0028,0010). Of the groups of overlays (6000 to 601E) it is the first.
using DicomTag = std::uint32_t;

/**
 * What a DICOM file says about its image, and the encoded image:
 *
 *     preamble, "DICM"   128 and 4 bytes; may be missing
 *     group 2            the transfer syntax; may be missing
 *     elements           tag, kind of value (VR) if it is explicit, length, value
 *     (7FE0,0010)        the pixels: samples, or fragments of compressed ones
 *
 * Only the elements that images need are kept, up to 1 KiB of each. All others are skipped: by their
 * length, which must be within the file, or, in sequences of undefined length, element by element, to
 * a depth of 32. So no bytes, however hostile, take more memory than that, or more time than reading
 * the file. The elements may be implicit or explicit, in either byte order, whatever the file says
 * about them, and with the known faults of some writers.
 *
 * Errors name the file. One file, one object.
 *
 * Source: DICOM PS3.5, 7 (the data set) and A (transfer syntaxes), PS3.10, 7 (file format).
 */
class DicomDataSet
{
public:
  /// `file` must outlive the data set.
  explicit DicomDataSet(const RandomAccessFile& file);

  /// Reads all elements before the pixels. NotFound if the file does not begin as DICOM does; Corrupt
  /// if it is damaged, or has no pixels. What was read before an error is there.
  Status ReadHeader();

  /// Whether the file has the signature of DICOM.
  bool HasMagic() const { return this->Magic; }
  /// The UID of the transfer syntax. If the file has none, that of its elements.
  const std::string& GetSyntax() const { return this->Syntax; }

  /// Whether there is such an element; of a sequence, whether it has items.
  bool Has(DicomTag tag) const { return this->Elements.count(tag) > 0; }
  /// The value as text, numbers separated by backslashes; empty if it is none or missing.
  std::string GetText(DicomTag tag) const;
  /// The numbers of a value that has exactly `count` of them.
  std::optional<std::vector<double>> GetNumbers(DicomTag tag, std::size_t count) const;
  double GetNumber(DicomTag tag, double otherwise) const;

  /// The following may be called after ReadHeader(). Whether the pixels are fragments.
  bool HasFragments() const;
  /// Whether the elements, and so pixels that are no fragments, are big-endian.
  bool IsBigEndian() const { return this->Main.IsBigEndian; }
  /// Whether the pixels are big-endian words of 16 bits, whatever their samples have.
  bool HasBigEndianWords() const { return this->Main.IsBigEndian && this->Pixels.Kind != "OB"; }
  /// The number of bytes of pixels that are no fragments.
  std::uint64_t GetPixelSize() const { return this->Pixels.Length; }
  /// Appends that many bytes of pixels that are no fragments, or at most that many of all fragments, but
  /// the first, which is a table. Once.
  Status AppendPixels(std::uint64_t size, std::vector<std::uint8_t>& to);

private:
  /// How elements are encoded.
  struct Layout
  {
    bool IsBigEndian = false;
    bool IsImplicit = false;
  };
  struct Head
  {
    DicomTag Tag = 0;
    std::string Kind; ///< empty if it is not known
    std::uint32_t Length = 0;
  };
  struct Value
  {
    std::string Kind;
    std::string Bytes;
  };

  Status FindBegin();
  Status ReadSyntax();
  Result<Layout> FindLayout(bool isBigEndian);
  Result<Head> ReadHead(const Layout& layout);
  Status ReadExplicit(const Layout& layout, const std::uint8_t* bytes, Head& head);
  Status TakeOrSkip(const Layout& layout, const Head& head);
  Result<bool> IsEmptySequence(const Layout& layout, const Head& head);
  Status Skip(const Layout& layout, const Head& head, int depth);
  Status SkipItems(const Layout& layout, bool isUnknown, int depth);
  Status SkipItem(const Layout& layout, int depth);
  Status JoinFragments(std::uint64_t size, std::vector<std::uint8_t>& to);
  Status MakeError(const std::string& reason) const;

  DicomStream Stream;
  bool Magic = false;
  std::string Syntax;
  Layout Main; ///< of the elements behind group 2
  std::map<DicomTag, Value> Elements;
  Head Pixels;
};

} // namespace isosurface

#endif
