// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Dicom/DicomDataSet.h"

#include "Formats/Source/TextFields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string_view>

namespace isosurface
{
namespace
{

constexpr std::uint32_t UndefinedLength = 0xffffffff;
constexpr std::size_t MaximumValueSize = 1024;
constexpr int MaximumDepth = 32;

constexpr DicomTag FloatPixelData = 0x7fe00008;
constexpr DicomTag DoublePixelData = 0x7fe00009;
constexpr DicomTag PixelData = 0x7fe00010;
constexpr DicomTag ItemBegin = 0xfffee000;
constexpr DicomTag ItemEnd = 0xfffee00d;
constexpr DicomTag SequenceEnd = 0xfffee0dd;

constexpr std::string_view TextKinds = "AE AS CS DA DS DT IS LO LT PN SH ST TM UC UI UR UT";
constexpr std::string_view NumberKinds = "FD FL SL SS UL US";
constexpr std::string_view ShortKinds =
  "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US";
constexpr std::string_view LongKinds = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";

constexpr const char* ImplicitLittleEndian = "1.2.840.10008.1.2";
constexpr const char* ExplicitLittleEndian = "1.2.840.10008.1.2.1";
constexpr const char* DeflatedLittleEndian = "1.2.840.10008.1.2.1.99";
constexpr const char* ExplicitBigEndian = "1.2.840.10008.1.2.2";

/// The kinds of all elements that are kept.
struct KeptElement
{
  DicomTag Tag;
  const char* Kind;
};
constexpr KeptElement KeptElements[] = { { 0x00020002, "UI" }, { 0x00020010, "UI" },
  { 0x00080008, "CS" }, { 0x00080016, "UI" }, { 0x00080032, "TM" }, { 0x00080033, "TM" },
  { 0x00080060, "CS" }, { 0x0008103e, "LO" }, { 0x00180086, "IS" }, { 0x00180088, "DS" },
  { 0x00181060, "DS" }, { 0x00189087, "FD" }, { 0x0020000e, "UI" }, { 0x00200011, "IS" },
  { 0x00200012, "IS" }, { 0x00200032, "DS" }, { 0x00200037, "DS" }, { 0x00200052, "UI" },
  { 0x00200100, "IS" }, { 0x00280002, "US" }, { 0x00280004, "CS" }, { 0x00280008, "IS" },
  { 0x00280010, "US" }, { 0x00280011, "US" }, { 0x00280030, "DS" }, { 0x00280100, "US" },
  { 0x00280101, "US" }, { 0x00280102, "US" }, { 0x00280103, "US" }, { 0x00280120, "US" },
  { 0x00281050, "DS" }, { 0x00281051, "DS" }, { 0x00281052, "DS" }, { 0x00281053, "DS" },
  { 0x00281054, "LO" }, { 0x00283000, "SQ" }, { 0x00409096, "SQ" }, { 0x00541001, "CS" },
  { 0x3004000e, "DS" }, { 0x60000102, "US" } };

const char* FindKind(DicomTag tag)
{
  const auto* const found = std::find_if(std::begin(KeptElements), std::end(KeptElements),
    [tag](const KeptElement& element) { return element.Tag == tag; });
  return found == std::end(KeptElements) ? nullptr : found->Kind;
}

bool IsOneOf(std::string_view kinds, std::string_view kind)
{
  const std::size_t at = kind.size() == 2 ? kinds.find(kind) : std::string_view::npos;
  return at != std::string_view::npos && at % 3 == 0;
}

template <typename T>
T Load(const void* bytes, bool isBigEndian)
{
  std::array<std::uint8_t, sizeof(T)> ordered;
  std::memcpy(ordered.data(), bytes, sizeof(T));
  if (isBigEndian)
  {
    std::reverse(ordered.begin(), ordered.end());
  }
  T value;
  std::memcpy(&value, ordered.data(), sizeof(T));
  return value;
}

DicomTag LoadTag(const std::uint8_t* bytes, bool isBigEndian)
{
  return DicomTag{ Load<std::uint16_t>(bytes, isBigEndian) } << 16 |
    Load<std::uint16_t>(bytes + 2, isBigEndian);
}

std::string PrintTag(DicomTag tag)
{
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "(%04X,%04X)", tag >> 16, tag & 0xffff);
  return text.data();
}

/// The numbers of a binary value, with backslashes between them.
template <typename T>
std::string PrintNumbers(const std::string& bytes, bool isBigEndian)
{
  std::string text;
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T))
  {
    std::array<char, 40> number{};
    std::snprintf(number.data(), number.size(), "%.17g",
      static_cast<double>(Load<T>(bytes.data() + at, isBigEndian)));
    text += (text.empty() ? "" : "\\") + std::string(number.data());
  }
  return text;
}

std::string PrintNumbers(const std::string& kind, const std::string& bytes, bool isBigEndian)
{
  return kind == "US" ? PrintNumbers<std::uint16_t>(bytes, isBigEndian)
    : kind == "SS"    ? PrintNumbers<std::int16_t>(bytes, isBigEndian)
    : kind == "UL"    ? PrintNumbers<std::uint32_t>(bytes, isBigEndian)
    : kind == "SL"    ? PrintNumbers<std::int32_t>(bytes, isBigEndian)
    : kind == "FL"    ? PrintNumbers<float>(bytes, isBigEndian)
                      : PrintNumbers<double>(bytes, isBigEndian);
}

/// The length that some writers meant. GDCM's collection has their files.
std::uint32_t MendLength(DicomTag tag, std::uint32_t length, const std::string& kind)
{
  const bool isOfSiemens = kind == "UL" && length == 6 && tag >> 16 == 0x0009;
  const bool isOfGE = kind.empty() && length == 13 && tag != 0x00080070 && tag != 0x00080080;
  return isOfSiemens ? 4 : isOfGE ? 10 : length;
}

} // namespace

DicomDataSet::DicomDataSet(const RandomAccessFile& file)
  : Stream(file)
{
}

Status DicomDataSet::MakeError(const std::string& reason) const
{
  return this->Stream.MakeError(
    StatusCode::Corrupt, "its header is truncated or damaged: " + reason);
}

Status DicomDataSet::FindBegin()
{
  std::array<std::uint8_t, 8> bytes{};
  if (this->Stream.MayHave(132 + bytes.size()))
  {
    std::array<std::uint8_t, 132> start{};
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(start.size(), start.data()));
    this->Magic = std::memcmp(start.data() + 128, "DICM", 4) == 0;
  }
  if (this->Magic)
  {
    return this->Stream.Skip(132);
  }
  if (this->Stream.MayHave(bytes.size()))
  {
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(bytes.size(), bytes.data()));
    const DicomTag group = LoadTag(bytes.data(), false) >> 16;
    if (group == 0x0002 || group == 0x0008 || group == 0x0800)
    {
      return Status::Ok();
    }
  }
  return this->Stream.MakeError(StatusCode::NotFound, "it is no file of DICOM");
}

/// Group 2, which is little-endian whatever follows, and explicit if its writer was right.
Status DicomDataSet::ReadSyntax()
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto layout, this->FindLayout(false));
  for (;;)
  {
    std::array<std::uint8_t, 8> bytes{};
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(bytes.size(), bytes.data()));
    if (LoadTag(bytes.data(), false) >> 16 != 0x0002)
    {
      break;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(const auto head, this->ReadHead(layout));
    ISOSURFACE_RETURN_IF_ERROR(this->TakeOrSkip(layout, head));
  }
  this->Syntax = this->GetText(0x00020010);
  if (this->Syntax == DeflatedLittleEndian)
  {
    this->Stream.Inflate();
  }
  return Status::Ok();
}

/// The layout of the next elements. The first of them tells whether they are explicit, because some
/// files say otherwise.
Result<DicomDataSet::Layout> DicomDataSet::FindLayout(bool isBigEndian)
{
  std::array<char, 8> bytes{};
  ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(bytes.size(), bytes.data()));
  const std::string_view kind(bytes.data() + 4, 2);
  return Layout{ isBigEndian, !IsOneOf(ShortKinds, kind) && !IsOneOf(LongKinds, kind) };
}

Status DicomDataSet::ReadHeader()
{
  ISOSURFACE_RETURN_IF_ERROR(this->FindBegin());
  ISOSURFACE_RETURN_IF_ERROR(this->ReadSyntax());
  std::array<std::uint8_t, 8> bytes{};
  ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(bytes.size(), bytes.data()));
  ISOSURFACE_ASSIGN_OR_RETURN(const auto layout,
    this->FindLayout(
      this->Syntax == ExplicitBigEndian || LoadTag(bytes.data(), false) >> 16 == 0x0800));
  this->Main = layout;
  if (this->Syntax.empty())
  {
    this->Syntax = layout.IsImplicit ? ImplicitLittleEndian
      : layout.IsBigEndian           ? ExplicitBigEndian
                                     : ExplicitLittleEndian;
  }
  for (;;)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto head, this->ReadHead(this->Main));
    if (head.Tag == PixelData)
    {
      this->Pixels = std::move(head);
      return Status::Ok();
    }
    if (head.Tag == ItemEnd || head.Tag == SequenceEnd)
    {
      continue; // one too many, behind a sequence of defined length
    }
    if (head.Tag == FloatPixelData || head.Tag == DoublePixelData)
    {
      return this->Stream.MakeError(StatusCode::Unsupported, "its samples are floats");
    }
    if (head.Tag > PixelData)
    {
      return this->MakeError("it has no pixels");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->TakeOrSkip(this->Main, head));
  }
}

Result<DicomDataSet::Head> DicomDataSet::ReadHead(const Layout& layout)
{
  std::array<std::uint8_t, 8> bytes{};
  ISOSURFACE_RETURN_IF_ERROR(this->Stream.Read(bytes.size(), bytes.data()));
  Head head;
  head.Tag = LoadTag(bytes.data(), layout.IsBigEndian);
  head.Length = Load<std::uint32_t>(bytes.data() + 4, layout.IsBigEndian);
  const bool isDelimiter = head.Tag >> 16 == 0xfffe;
  if (!isDelimiter && !layout.IsImplicit)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->ReadExplicit(layout, bytes.data(), head));
  }
  head.Length = isDelimiter ? head.Length : MendLength(head.Tag, head.Length, head.Kind);
  const bool isBound = head.Tag != PixelData && head.Tag != ItemEnd && head.Tag != SequenceEnd &&
    head.Length != UndefinedLength;
  if (isBound && !this->Stream.MayHave(head.Length))
  {
    return this->MakeError(PrintTag(head.Tag) + " has " + std::to_string(head.Length) +
      " bytes, more than are left of the file");
  }
  return head;
}

/// Kind and length of an explicit element.
Status DicomDataSet::ReadExplicit(const Layout& layout, const std::uint8_t* bytes, Head& head)
{
  const std::string kind(bytes + 4, bytes + 6);
  const auto shortLength = Load<std::uint16_t>(bytes + 6, layout.IsBigEndian);
  // Some writers gave values of unknown kind a length of 16 bits.
  const bool isUnknown = kind == "UN";
  const auto isLetter = [](char letter) { return letter >= ' ' && letter <= '~'; };
  const bool isKind = isLetter(kind[0]) && isLetter(kind[1]);
  if ((IsOneOf(LongKinds, kind) && !(isUnknown && shortLength != 0)) ||
    (isKind && head.Tag == PixelData))
  {
    std::array<std::uint8_t, 4> length{};
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Read(length.size(), length.data()));
    head.Kind = kind;
    head.Length = Load<std::uint32_t>(length.data(), layout.IsBigEndian);
    return Status::Ok();
  }
  if (isKind)
  {
    head.Kind = kind;
    head.Length = shortLength;
  } // otherwise it is an implicit element among explicit ones
  return Status::Ok();
}

Status DicomDataSet::TakeOrSkip(const Layout& layout, const Head& head)
{
  const bool isOverlay = head.Tag >> 21 == 0x6000 >> 5;
  const DicomTag tag = isOverlay ? head.Tag & 0xff00ffff : head.Tag;
  const char* const known = FindKind(tag);
  if (known && std::string_view(known) == "SQ")
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto isEmpty, this->IsEmptySequence(layout, head));
    if (!isEmpty)
    {
      this->Elements.emplace(tag, Value{ known, "" });
    }
    return this->Skip(layout, head, 0);
  }
  if (!known || head.Length == UndefinedLength || head.Kind == "SQ")
  {
    return this->Skip(layout, head, 0);
  }
  const std::size_t size = std::min<std::size_t>(head.Length, MaximumValueSize);
  Value value;
  value.Kind = head.Kind.empty() || head.Kind == "UN" ? known : head.Kind;
  value.Bytes.resize(size);
  ISOSURFACE_RETURN_IF_ERROR(this->Stream.Read(size, value.Bytes.data()));
  // Of overlays one that is in the words of the samples counts.
  if (!isOverlay || value.Bytes.find_first_not_of('\0') != std::string::npos)
  {
    this->Elements.emplace(tag, std::move(value));
  }
  return this->Stream.Skip(head.Length - size);
}

Result<bool> DicomDataSet::IsEmptySequence(const Layout& layout, const Head& head)
{
  std::array<std::uint8_t, 4> bytes{};
  if (head.Length != UndefinedLength)
  {
    return head.Length == 0;
  }
  ISOSURFACE_RETURN_IF_ERROR(this->Stream.Peek(bytes.size(), bytes.data()));
  return LoadTag(bytes.data(), layout.IsBigEndian) == SequenceEnd;
}

Status DicomDataSet::Skip(const Layout& layout, const Head& head, int depth)
{
  if (head.Length != UndefinedLength)
  {
    return this->Stream.Skip(head.Length);
  }
  const bool isUnknown = head.Kind == "UN";
  if (!isUnknown && !head.Kind.empty() && head.Kind != "SQ" && head.Tag != PixelData)
  {
    return this->MakeError(PrintTag(head.Tag) + " is of kind " + head.Kind + " and has no length");
  }
  return this->SkipItems(layout, isUnknown, depth + 1);
}

/// A sequence of undefined length. What it is in is of an unknown kind, its elements should be
/// implicit; the first one of each item tells.
Status DicomDataSet::SkipItems(const Layout& layout, bool isUnknown, int depth)
{
  if (depth > MaximumDepth)
  {
    return this->MakeError(
      "it has sequences within sequences, deeper than " + std::to_string(MaximumDepth));
  }
  for (;;)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto item, this->ReadHead(layout));
    if (item.Tag == SequenceEnd)
    {
      return Status::Ok();
    }
    if (item.Tag != ItemBegin)
    {
      return this->MakeError(PrintTag(item.Tag) + " stands where an item of a sequence should");
    }
    if (item.Length != UndefinedLength)
    {
      ISOSURFACE_RETURN_IF_ERROR(this->Stream.Skip(item.Length));
      continue;
    }
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto inner, isUnknown ? this->FindLayout(layout.IsBigEndian) : Result<Layout>(layout));
    ISOSURFACE_RETURN_IF_ERROR(this->SkipItem(inner, depth));
  }
}

Status DicomDataSet::SkipItem(const Layout& layout, int depth)
{
  for (;;)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(const auto head, this->ReadHead(layout));
    if (head.Tag == ItemEnd)
    {
      return Status::Ok();
    }
    if (head.Tag == ItemBegin || head.Tag == SequenceEnd)
    {
      return this->MakeError("an item of a sequence has no end");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Skip(layout, head, depth));
  }
}

std::string DicomDataSet::GetText(DicomTag tag) const
{
  const auto found = this->Elements.find(tag);
  if (found == this->Elements.end())
  {
    return {};
  }
  const auto& [kind, bytes] = found->second;
  if (IsOneOf(NumberKinds, kind))
  {
    return PrintNumbers(kind, bytes, this->Main.IsBigEndian);
  }
  std::string text = IsOneOf(TextKinds, kind) ? bytes : std::string();
  text.erase(std::remove(text.begin(), text.end(), '\0'), text.end());
  return TrimText(text);
}

std::optional<std::vector<double>> DicomDataSet::GetNumbers(DicomTag tag, std::size_t count) const
{
  std::string text = this->GetText(tag);
  std::replace(text.begin(), text.end(), '\\', ' ');
  return ParseDoubles(text, count);
}

double DicomDataSet::GetNumber(DicomTag tag, double otherwise) const
{
  const auto number = this->GetNumbers(tag, 1);
  return number && std::isfinite((*number)[0]) ? (*number)[0] : otherwise;
}

bool DicomDataSet::HasFragments() const
{
  return this->Pixels.Length == UndefinedLength;
}

Status DicomDataSet::AppendPixels(std::uint64_t size, std::vector<std::uint8_t>& to)
{
  if (this->HasFragments())
  {
    return this->JoinFragments(size, to);
  }
  if (this->Pixels.Length < size || !this->Stream.MayHave(size))
  {
    return this->Stream.MakeError(StatusCode::Corrupt,
      "its image is truncated: it should have " + std::to_string(size) + " bytes");
  }
  return this->Stream.Append(size, to);
}

/// One image may have several fragments: they are its bytes one after another.
Status DicomDataSet::JoinFragments(std::uint64_t size, std::vector<std::uint8_t>& to)
{
  const std::size_t begin = to.size();
  for (bool isTable = true; this->Stream.MayHave(1); isTable = false)
  {
    std::array<std::uint8_t, 4> bytes{};
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Read(bytes.size(), bytes.data()));
    const DicomTag tag = LoadTag(bytes.data(), this->Main.IsBigEndian);
    // Some writers gave the last fragment a byte too many, which is the first of the end.
    const bool isLate = tag == 0xddff00e0 && to.size() > begin && to.back() == 0xfe;
    if (tag == SequenceEnd || isLate)
    {
      to.resize(to.size() - (isLate ? 1 : 0));
      return Status::Ok();
    }
    if (tag != ItemBegin || this->Stream.IsDeflated())
    {
      return this->Stream.MakeError(StatusCode::Corrupt, "its image is damaged");
    }
    ISOSURFACE_RETURN_IF_ERROR(this->Stream.Read(bytes.size(), bytes.data()));
    const auto length = Load<std::uint32_t>(bytes.data(), this->Main.IsBigEndian);
    if (!this->Stream.MayHave(length))
    {
      return this->Stream.MakeError(StatusCode::Corrupt, "its image is truncated");
    }
    const std::uint64_t wanted = std::min<std::uint64_t>(length, size - (to.size() - begin));
    ISOSURFACE_RETURN_IF_ERROR(
      isTable ? this->Stream.Skip(length) : this->Stream.Append(wanted, to));
    if (to.size() - begin == size)
    {
      return Status::Ok();
    }
  }
  return Status::Ok(); // without the end of the sequence, but whole
}

} // namespace isosurface
