// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/DicomBytes.h"
#include "Fixtures/SampleFiles.h"

#include "Formats/Dicom/DicomSlice.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

using namespace isosurface;

namespace
{

/// What a header says of words: bits allocated and stored, the highest of these, and whether it is a sign.
struct WordHeader
{
  std::uint32_t Allocated = 16;
  std::uint32_t Stored = 12;
  std::uint32_t Highest = 11;
  std::uint32_t IsSigned = 1;
};

const std::string PlainSyntax = "1.2.840.10008.1.2.1";

/// An image of 4 columns, without its pixels.
DicomBytes MakeHeader(const std::string& syntax, const WordHeader& header, std::uint32_t rows = 2)
{
  DicomBytes bytes;
  bytes.PutStart(syntax).PutText(0x00280004, "CS", "MONOCHROME2");
  bytes.PutNumber(0x00280010, rows).PutNumber(0x00280011, 4);
  bytes.PutNumber(0x00280100, header.Allocated).PutNumber(0x00280101, header.Stored);
  return bytes.PutNumber(0x00280102, header.Highest).PutNumber(0x00280103, header.IsSigned);
}

DicomBytes Compress(const std::string& syntax, const WordHeader& header, const Bytes& code)
{
  DicomBytes bytes = MakeHeader(syntax, header);
  bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0);
  bytes.PutItem(static_cast<std::uint32_t>(code.size()));
  return bytes.PutRaw(std::string(code.begin(), code.end())).PutEnd(DicomBytes::SequenceEnd);
}

/// The samples of a file, or its error.
struct Decoded
{
  std::vector<std::int64_t> Samples;
  std::string Error;
};

Decoded DecodeNumbers(const DicomBytes& bytes)
{
  const std::string path = testing::TempDir() + "DicomSampleBits-" + std::to_string(::getpid());
  std::ofstream(path, std::ios::binary)
    .write(reinterpret_cast<const char*>(bytes.Get().data()),
      static_cast<std::streamsize>(bytes.Get().size()));
  Decoded decoded;
  const auto slice = DicomSlice::Read(path);
  Bytes samples;
  const Status status = slice.IsOk() ? slice->Decode(samples) : slice.GetStatus();
  std::filesystem::remove(path);
  if (!status.IsOk())
  {
    decoded.Error = status.GetMessage();
    return decoded;
  }
  DispatchValueType(slice->Type,
    [&](auto zero)
    {
      for (std::size_t at = 0; at + sizeof(zero) <= samples.size(); at += sizeof(zero))
      {
        std::memcpy(&zero, samples.data() + at, sizeof(zero));
        decoded.Samples.push_back(static_cast<std::int64_t>(zero));
      }
    });
  return decoded;
}

void ExpectNumbers(const DicomBytes& bytes, const std::vector<std::int64_t>& expected)
{
  const Decoded decoded = DecodeNumbers(bytes);
  EXPECT_EQ(decoded.Error, "");
  EXPECT_EQ(decoded.Samples, expected);
}

void ExpectBitsError(const DicomBytes& bytes, const std::string& reason)
{
  const std::string error = DecodeNumbers(bytes).Error;
  EXPECT_NE(error.find(reason), std::string::npos) << error;
}

// Of CharLS, libjpeg and OpenJPEG, by dcmtk and opj_compress: each has the samples of `Coded` in 4 columns.
const std::vector<std::int64_t> Coded = { -2048, -1, 0, 1, 2047, -1000, 5, 100 };
const std::string JpegLs = "1.2.840.10008.1.2.4.80";
const Bytes JpegLsOf16Bits = { 0xff, 0xd8, 0xff, 0xf7, 0, 11, 16, 0, 2, 0, 4, 1, 1, 0x11, 0, 0xff,
  0xf8, 0, 13, 1, 0xff, 0xff, 0, 0x12, 0, 0x43, 1, 0x14, 0, 0x40, 0xff, 0xda, 0, 8, 1, 1, 0, 0, 0,
  0, 0x0f, 0xfc, 0x3f, 0xec, 0, 0xa0, 4, 7, 0xfe, 0, 0x7c, 0xc8, 0x15, 0x2f, 0x80, 0xff, 0xff,
  0xd9 };
const std::string Jpeg = "1.2.840.10008.1.2.4.70";
const Bytes JpegOf16Bits = { 0xff, 0xd8, 0xff, 0xc3, 0, 11, 0x10, 0, 2, 0, 4, 1, 1, 0x11, 0, 0xff,
  0xc4, 0, 0x19, 0, 0, 2, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 12, 7, 10, 11, 15, 0xff,
  0xda, 0, 8, 1, 1, 0, 1, 0, 0, 0xef, 0, 0x1b, 0xff, 0, 0x92, 0xff, 0, 0xfa, 0x83, 0x17, 0xed, 0x97,
  0xff, 0, 0xff, 0xff, 0xd9 };
const std::string Jpeg2000 = "1.2.840.10008.1.2.4.90";

/// The codestream of JPEG 2000 with such a description of its samples (the highest bit: signed).
Bytes MakeCodestream(std::uint8_t bits, std::uint8_t exponent, const Bytes& packet)
{
  Bytes code = { 0xff, 0x4f, 0xff, 0x51, 0, 0x29, 0, 0, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, bits, 1, 1, 0xff, 0x52, 0, 12, 0, 0, 0,
    1, 0, 0, 4, 4, 0, 1, 0xff, 0x5c, 0, 4, 0x40, exponent, 0xff, 0x90, 0, 10, 0, 0, 0, 0, 0,
    static_cast<std::uint8_t>(14 + packet.size()), 0, 1, 0xff, 0x93 };
  code.insert(code.end(), packet.begin(), packet.end());
  code.insert(code.end(), { 0xff, 0xd9 });
  return code;
}

const Bytes UnsignedOf12Bits = MakeCodestream(11, 0x60,
  { 0xdf, 0xe0, 0x34, 0x12, 0x7f, 0x63, 0xba, 0x7a, 0x74, 0xe2, 0x52, 0x1c, 0xc7, 0xf8, 0x45,
    0xe1 });
const Bytes UnsignedOf13Bits = MakeCodestream(12, 0x68,
  { 0xdf, 0xf8, 0, 0x80, 0x12, 0x7f, 0x64, 0x85, 0x85, 0x1d, 0x2a, 0xbd, 0x2a, 0x51, 0xc9, 0x78,
    0x87, 0xeb, 0xc0, 0x4f });
const Bytes UnsignedOf16Bits = MakeCodestream(15, 0x80,
  { 0xdf, 0xf8, 0x90, 0x90, 0x12, 0x7f, 0x64, 0x7a, 0xb5, 0x30, 0x85, 0xb4, 0xc4, 0x44, 0xb4, 0xa0,
    0xf6, 0x7e, 11, 5, 0xf6, 0x5f });
const Bytes SignedOf12Bits = MakeCodestream(0x80 + 11, 0x60,
  { 0xdf, 0xe0, 0x2c, 7, 0xa5, 0xa6, 0x97, 0x3f, 0x2f, 0xc3, 0x74, 0x61, 0x1b, 0xa2 });

} // namespace

TEST(DicomSampleBits, SamplesAreTheStoredBitsOfTheirWordsWithTheirSign)
{
  for (const WordHeader& header :
    { WordHeader{ 8, 8, 7, 0 }, { 8, 8, 7, 1 }, { 8, 7, 6, 0 }, { 8, 5, 6, 1 }, { 16, 16, 15, 1 },
      { 16, 12, 11, 0 }, { 16, 12, 11, 1 }, { 16, 12, 15, 0 }, { 16, 13, 14, 1 }, { 16, 1, 0, 1 },
      { 32, 32, 31, 1 }, { 32, 24, 23, 1 }, { 32, 20, 30, 0 } })
  {
    SCOPED_TRACE(std::to_string(header.Allocated) + " " + std::to_string(header.Stored) + " " +
      std::to_string(header.Highest) + " " + std::to_string(header.IsSigned));
    const std::uint32_t words[] = { 0xdeadbeef, 0x12345678, 0x0, 0xffffffff };
    DicomBytes bytes = MakeHeader(PlainSyntax, header, 1);
    bytes.PutHead(0x7fe00010, "OW", header.Allocated / 2);
    std::vector<std::int64_t> expected;
    for (const std::uint32_t word : words)
    {
      bytes.Put(word, header.Allocated / 8);
      std::int64_t sample = 0;
      for (std::uint32_t bit = 0; bit < header.Stored; ++bit)
      {
        const std::int64_t weight = std::int64_t{ 1 } << bit;
        const bool isSign = header.IsSigned != 0 && bit + 1 == header.Stored;
        const bool isSet = (word >> (header.Highest + 1 - header.Stored + bit) & 1) != 0;
        sample += isSet ? (isSign ? -weight : weight) : 0;
      }
      expected.push_back(sample);
    }
    ExpectNumbers(bytes, expected);
  }
  ExpectBitsError(MakeHeader(PlainSyntax, { 16, 12, 16, 0 }).PutHead(0x7fe00010, "OW", 0), "bits");
  ExpectBitsError(MakeHeader(PlainSyntax, { 16, 12, 10, 0 }).PutHead(0x7fe00010, "OW", 0), "bits");
  ExpectBitsError(MakeHeader(PlainSyntax, { 16, 17, 16, 0 }).PutHead(0x7fe00010, "OW", 0), "bits");
}

TEST(DicomSampleBits, CompressedSamplesHaveTheirSign)
{
  ExpectNumbers(Compress(JpegLs, {}, JpegLsOf16Bits), Coded);
  ExpectNumbers(Compress(Jpeg, {}, JpegOf16Bits), Coded);
  ExpectNumbers(Compress(Jpeg2000, {}, UnsignedOf12Bits), Coded);
  ExpectNumbers(Compress(Jpeg2000, {}, SignedOf12Bits), Coded);
}

TEST(DicomSampleBits, AStreamIsRightWhereItsHeaderSaysOtherwise)
{
  for (const WordHeader& header :
    { WordHeader{ 16, 12, 11, 1 }, { 16, 13, 12, 1 }, { 16, 16, 15, 1 }, { 32, 32, 31, 1 } })
  {
    SCOPED_TRACE(header.Stored);
    for (const Bytes& code :
      { UnsignedOf12Bits, UnsignedOf13Bits, UnsignedOf16Bits, SignedOf12Bits })
    {
      ExpectNumbers(Compress(Jpeg2000, header, code), Coded);
    }
    ExpectNumbers(Compress(JpegLs, header, JpegLsOf16Bits), Coded);
  }
  // Here the stream has more bits than the header says.
  ExpectNumbers(Compress(Jpeg2000, { 16, 10, 9, 1 }, UnsignedOf13Bits), Coded);
  ExpectBitsError(Compress(Jpeg2000, { 8, 8, 7, 1 }, UnsignedOf12Bits), "samples of 12 bits");
  ExpectBitsError(Compress(Jpeg2000, { 16, 12, 11, 0 }, SignedOf12Bits), "negative samples");
}

TEST(DicomSampleBits, WhatHeaderAndStreamHaveBesideTheSamplesIsNoPartOfThem)
{
  // An overlay, and samples in the high bits.
  DicomBytes bytes;
  std::vector<std::int64_t> lowest;
  std::vector<std::int64_t> highest;
  for (const std::int64_t sample : Coded)
  {
    const std::int64_t low = sample & 0x3ff;
    lowest.push_back(low >= 512 ? low - 1024 : low);
    highest.push_back(sample >> 4);
  }
  bytes = MakeHeader(Jpeg2000, { 16, 10, 9, 1 });
  bytes.PutNumber(0x60000102, 0).PutNumber(0x60020102, 10); // the second overlay is in the words
  bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0);
  bytes.PutItem(static_cast<std::uint32_t>(UnsignedOf16Bits.size()));
  bytes.PutRaw(std::string(UnsignedOf16Bits.begin(), UnsignedOf16Bits.end()));
  ExpectNumbers(bytes.PutEnd(DicomBytes::SequenceEnd), lowest);
  ExpectNumbers(Compress(Jpeg, { 16, 10, 9, 1 }, JpegOf16Bits), lowest);
  ExpectNumbers(Compress(JpegLs, { 16, 12, 15, 1 }, JpegLsOf16Bits), highest);
}
