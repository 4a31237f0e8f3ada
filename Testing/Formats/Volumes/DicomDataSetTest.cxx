// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/DicomBytes.h"
#include "Fixtures/SampleFiles.h"

#include "Formats/Dicom/DicomCompression.h"
#include "Formats/Dicom/DicomDataSet.h"

using namespace isosurface;

namespace
{

const std::string ImplicitLittle = "1.2.840.10008.1.2";
const std::string ExplicitLittle = "1.2.840.10008.1.2.1";
const std::string Deflated = "1.2.840.10008.1.2.1.99";
const std::string ExplicitBig = "1.2.840.10008.1.2.2";
const Bytes Pixels = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12 };

/// A data set of bytes, which live as long.
class OpenDataSet
{
public:
  explicit OpenDataSet(const Bytes& bytes)
  {
    WriteFile(this->Disk, "/data/a.dcm", bytes);
    this->File = std::move(*this->Disk.OpenForReading("/data/a.dcm"));
    this->Tags = std::make_unique<DicomDataSet>(*this->File);
    this->Outcome = this->Tags->ReadHeader();
  }
  DicomDataSet* operator->() { return this->Tags.get(); }

  MemoryDisk Disk;
  std::unique_ptr<RandomAccessFile> File;
  std::unique_ptr<DicomDataSet> Tags;
  Status Outcome;
};

/// The elements of an image, behind those that `before` puts.
DicomBytes MakeImage(const std::string& syntax, DicomBytes before = {})
{
  DicomBytes bytes;
  bytes.PutStart(syntax).PutRaw(std::string(before.Get().begin(), before.Get().end()));
  bytes.IsImplicit = syntax == ImplicitLittle;
  bytes.IsBigEndian = syntax == ExplicitBig;
  return bytes.PutImage(3, 2).PutBytes(0x7fe00010, "OW", Pixels);
}

void ExpectImage(const Bytes& bytes, const std::string& syntax)
{
  OpenDataSet tags(bytes);
  ASSERT_TRUE(tags.Outcome.IsOk()) << tags.Outcome.GetMessage();
  EXPECT_EQ(tags->GetSyntax(), syntax);
  EXPECT_EQ(tags->GetText(0x0008103e), "head");
  EXPECT_EQ(tags->GetNumber(0x00280010, 0), 2);
  EXPECT_EQ(tags->GetNumber(0x00280011, 0), 3);
  EXPECT_EQ(tags->GetNumbers(0x00200032, 3), (std::vector<double>{ 1, 2, 3 }));
  EXPECT_EQ(tags->GetNumbers(0x00200032, 2), std::nullopt);
  EXPECT_EQ(tags->GetNumber(0x00281052, -1), -1);
  Bytes pixels = { 0 };
  const Status status = tags->AppendPixels(Pixels.size(), pixels);
  ASSERT_TRUE(status.IsOk()) << status.GetMessage();
  pixels.erase(pixels.begin());
  EXPECT_EQ(pixels, Pixels);
}

void ExpectRefused(const Bytes& bytes, const std::string& reason)
{
  const OpenDataSet tags(bytes);
  const std::string& message = tags.Outcome.GetMessage();
  EXPECT_EQ(tags.Outcome.GetCode(), StatusCode::Corrupt);
  EXPECT_EQ(message.find("/data/a.dcm: cannot be read: "), 0u) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

DicomBytes PutNested(int levels)
{
  DicomBytes bytes;
  for (int level = 0; level < levels; ++level)
  {
    bytes.PutHead(0x00180001, "SQ", DicomBytes::Undefined).PutItem();
  }
  for (int level = 0; level < levels; ++level)
  {
    bytes.PutEnd(DicomBytes::ItemEnd).PutEnd(DicomBytes::SequenceEnd);
  }
  return bytes;
}

Bytes Slice(const Bytes& bytes, std::size_t begin, std::size_t end)
{
  return { bytes.begin() + static_cast<std::ptrdiff_t>(begin),
    bytes.begin() + static_cast<std::ptrdiff_t>(end) };
}

/// A file whose elements behind group 2 are deflated.
Bytes MakeDeflated()
{
  const Bytes plain = MakeImage(Deflated).Get();
  Bytes bytes = DicomBytes().PutStart(Deflated).Get();
  const Bytes deflated = Deflate(Slice(plain, bytes.size(), plain.size()), -15);
  bytes.insert(bytes.end(), deflated.begin(), deflated.end());
  return bytes;
}

} // namespace

TEST(DicomDataSet, ReadsElementsOfEveryTransferSyntax)
{
  for (const std::string& syntax : { ImplicitLittle, ExplicitLittle, ExplicitBig })
  {
    ExpectImage(MakeImage(syntax).Get(), syntax);
  }
  ExpectImage(MakeDeflated(), Deflated);
}

TEST(DicomDataSet, ReadsFilesWithoutPreambleOrWithAnotherLayoutThanTheySay)
{
  const Bytes whole = MakeImage(ExplicitLittle).Get();
  ExpectImage(Slice(whole, 132, whole.size()), ExplicitLittle);
  const std::size_t start = DicomBytes().PutStart(ExplicitLittle).Get().size();
  ExpectImage(Slice(whole, start, whole.size()), ExplicitLittle);
  const Bytes implicit = MakeImage(ImplicitLittle).Get();
  const std::size_t implicitStart = DicomBytes().PutStart(ImplicitLittle).Get().size();
  ExpectImage(Slice(implicit, implicitStart, implicit.size()), ImplicitLittle);
  DicomBytes wrong;
  wrong.PutStart(ExplicitLittle);
  wrong.IsImplicit = true;
  ExpectImage(wrong.PutImage(3, 2).PutBytes(0x7fe00010, "OW", Pixels).Get(), ExplicitLittle);
  // An implicit element among explicit ones, and a value of unknown kind with a length of 16 bits.
  DicomBytes mixed;
  mixed.PutText(0x00080008, "CS", "ORIGINAL").IsImplicit = true;
  mixed.PutText(0x00081090, "", "maker");
  mixed.IsImplicit = false;
  mixed.PutRaw(std::string("\x09\0\x10\0UN\4\0abcd", 12));
  ExpectImage(MakeImage(ExplicitLittle, mixed).Get(), ExplicitLittle);
}

TEST(DicomDataSet, SkipsSequencesOfEveryKind)
{
  DicomBytes sequences = PutNested(30);
  sequences.PutHead(0x00081140, "SQ", 16).PutItem(8).PutText(0x00080016, "UI", "");
  sequences.PutHead(0x00081150, "SQ", DicomBytes::Undefined);
  sequences.PutItem(10).PutNumber(0x00280010, 77).PutEnd(DicomBytes::SequenceEnd);
  sequences.PutHead(0x00090010, "UN", DicomBytes::Undefined).PutItem();
  sequences.IsImplicit = true; // what is of an unknown kind is implicit
  sequences.PutNumber(0x00280010, 77).PutHead(0x00290010, "", DicomBytes::Undefined);
  sequences.PutItem().PutEnd(DicomBytes::ItemEnd).PutEnd(DicomBytes::SequenceEnd);
  sequences.PutEnd(DicomBytes::ItemEnd).PutEnd(DicomBytes::SequenceEnd);
  sequences.IsImplicit = false;
  sequences.PutHead(0x00090011, "UN", DicomBytes::Undefined).PutItem(); // or not
  sequences.PutNumber(0x00280010, 77).PutEnd(DicomBytes::ItemEnd);
  sequences.PutEnd(DicomBytes::SequenceEnd);
  // An icon, compressed.
  sequences.PutHead(0x00880200, "SQ", DicomBytes::Undefined).PutItem();
  sequences.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0).PutItem(2).PutRaw("ab");
  sequences.PutEnd(DicomBytes::SequenceEnd).PutEnd(DicomBytes::ItemEnd);
  sequences.PutEnd(DicomBytes::SequenceEnd).PutEnd(DicomBytes::SequenceEnd); // one too many
  ExpectImage(MakeImage(ExplicitLittle, sequences).Get(), ExplicitLittle);
}

TEST(DicomDataSet, RefusesLengthsBeyondTheFile)
{
  for (const std::uint32_t length : { 0x1000u, 0x10000000u, 0xfffffffeu })
  {
    DicomBytes bytes;
    ExpectRefused(MakeImage(ExplicitLittle, bytes.PutHead(0x0008103e, "UT", length)).Get(),
      "(0008,103E) has " + std::to_string(length) + " bytes, more than are left");
    ExpectRefused(MakeImage(ExplicitLittle,
                    DicomBytes().PutHead(0x00081140, "SQ", DicomBytes::Undefined).PutItem(length))
                    .Get(),
      "(FFFE,E000) has " + std::to_string(length) + " bytes, more than are left");
  }
  ExpectRefused(
    MakeImage(ExplicitLittle, DicomBytes().PutHead(0x00081140, "OB", DicomBytes::Undefined)).Get(),
    "(0008,1140) is of kind OB and has no length");
}

TEST(DicomDataSet, RefusesSequencesThatAreTooDeep)
{
  ExpectImage(MakeImage(ExplicitLittle, PutNested(32)).Get(), ExplicitLittle);
  for (const int levels : { 33, 5000, 200000 })
  {
    ExpectRefused(MakeImage(ExplicitLittle, PutNested(levels)).Get(), "deeper than 32");
  }
}

TEST(DicomDataSet, JoinsTheFragmentsOfAnImage)
{
  const auto make = [](const std::string& last)
  {
    DicomBytes bytes;
    bytes.PutStart("1.2.840.10008.1.2.4.70").PutImage(3, 2);
    bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(4).PutRaw("tabl");
    return bytes.PutItem(2).PutRaw("ab").PutItem(4).PutRaw(last);
  };
  const auto join = [](const DicomBytes& bytes)
  {
    OpenDataSet tags(bytes.Get());
    EXPECT_TRUE(tags.Outcome.IsOk() && tags->HasFragments());
    Bytes joined;
    const Status status = tags->AppendPixels(12, joined);
    return status.IsOk() ? std::string(joined.begin(), joined.end()) : status.GetMessage();
  };
  EXPECT_EQ(join(make("cdef").PutEnd(DicomBytes::SequenceEnd)), "abcdef");
  EXPECT_EQ(join(make("cdef")), "abcdef");
  EXPECT_EQ(join(make("cde").PutEnd(DicomBytes::SequenceEnd)), "abcde");
  EXPECT_NE(join(make("cde")).find("truncated"), std::string::npos);
  EXPECT_NE(join(make("cdef").PutNumber(0x00280010, 2)).find("damaged"), std::string::npos);
}

TEST(DicomDataSet, EveryTruncationIsAnError)
{
  DicomBytes before = PutNested(2);
  for (const Bytes& whole :
    { MakeImage(ExplicitLittle, before).Get(), MakeImage(ExplicitBig).Get(), MakeDeflated() })
  {
    for (std::size_t size = 0; size < whole.size(); ++size)
    {
      OpenDataSet tags(Slice(whole, 0, size));
      Bytes pixels;
      const Status status =
        tags.Outcome.IsOk() ? tags->AppendPixels(Pixels.size(), pixels) : tags.Outcome;
      // The last bytes of deflate may be the mark of its end.
      EXPECT_TRUE(!status.IsOk() || (pixels == Pixels && size + 8 > whole.size())) << size;
      EXPECT_EQ(status.IsOk() ? 0u : status.GetMessage().find("/data/a.dcm: "), 0u);
    }
  }
}

TEST(DicomDataSet, DamagedFilesGiveErrorsOrValues)
{
  std::mt19937 random(7);
  int refused = 0;
  for (const Bytes& good : { MakeImage(ExplicitLittle, PutNested(3)).Get(), MakeDeflated() })
  {
    for (int turn = 0; turn < 1000; ++turn)
    {
      Bytes bad = good;
      for (int change = 0; change < 1 + turn % 3; ++change)
      {
        bad[128 + random() % (bad.size() - 128)] = static_cast<std::uint8_t>(random());
      }
      OpenDataSet tags(bad);
      Bytes pixels;
      const Status status = tags.Outcome.IsOk() ? tags->AppendPixels(12, pixels) : tags.Outcome;
      EXPECT_LE(pixels.size(), bad.size());
      refused += status.IsOk() ? 0 : 1;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(DicomCompression, RunLengthsOfFewBytesMakeNoLargeImage)
{
  Bytes code(66, 0);
  code[0] = 1;    // segment
  code[4] = 64;   // where it begins
  code[64] = 129; // 128 times
  code[65] = 7;
  Bytes samples;
  EXPECT_TRUE(DecodeRunLengths(code, 128, 1, samples));
  EXPECT_EQ(samples, Bytes(128, 7));
  samples.clear();
  EXPECT_FALSE(DecodeRunLengths(code, std::size_t{ 1 } << 33, 1, samples));
  EXPECT_TRUE(samples.empty()); // and nothing of the size was allocated
}
