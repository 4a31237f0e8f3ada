// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/DicomBytes.h"
#include "Fixtures/SampleFiles.h"

#include "Formats/Dicom/DicomSlice.h"
#include "Formats/Opener/ForeignVolume.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

using namespace isosurface;

namespace
{

const std::string SliceSyntax = "1.2.840.10008.1.2.1";
const Bytes SlicePixels = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12 };

/// A file that is removed at the end of the test.
class File
{
public:
  explicit File(const Bytes& bytes)
    : Path(testing::TempDir() + "DicomSlice-" +
        testing::UnitTest::GetInstance()->current_test_info()->name() + "-" +
        std::to_string(::getpid()) + ".dcm")
  {
    std::ofstream(this->Path, std::ios::binary)
      .write(
        reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  ~File() { std::filesystem::remove(this->Path); }

  const std::string Path;
};

DicomBytes MakeImage(const DicomBytes& before = {})
{
  DicomBytes bytes;
  bytes.PutStart(SliceSyntax).PutRaw(std::string(before.Get().begin(), before.Get().end()));
  return bytes.PutImage(3, 2).PutBytes(0x7fe00010, "OW", SlicePixels);
}

/// The error of reading and decoding a file, or nothing.
std::string FindError(const DicomBytes& bytes, Bytes* samples = nullptr)
{
  const File file(bytes.Get());
  const auto slice = DicomSlice::Read(file.Path);
  Bytes decoded;
  const Status status = slice.IsOk() ? slice->Decode(decoded) : slice.GetStatus();
  EXPECT_EQ(status.IsOk() ? 0u : status.GetMessage().find(file.Path + ": cannot be read: "), 0u)
    << status.GetMessage();
  if (samples)
  {
    *samples = decoded;
  }
  return status.IsOk() ? std::string() : status.GetMessage();
}

void ExpectSamples(const DicomBytes& bytes, const Bytes& expected)
{
  Bytes samples;
  EXPECT_EQ(FindError(bytes, &samples), "");
  EXPECT_EQ(samples, expected);
}

void ExpectRefused(const DicomBytes& bytes, const std::string& reason)
{
  const std::string message = FindError(bytes);
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

} // namespace

TEST(DicomSlice, DecodesAnImage)
{
  ExpectSamples(MakeImage(), SlicePixels);
}

TEST(DicomSlice, AValueOfAKindThatIsNoTextOrNumberIsMissing)
{
  for (const std::string kind : { "OD", "OL", "OV", "SV", "UV", "AT", "OB" })
  {
    DicomBytes bytes;
    bytes.PutStart(SliceSyntax).PutHead(0x00280010, kind, 8);
    bytes.PutRaw("abcdefgh").PutNumber(0x00280011, 3).PutBytes(0x7fe00010, "OW", SlicePixels);
    ExpectRefused(bytes, "");
  }
}

TEST(DicomSlice, DeepSequencesAreAnError)
{
  DicomBytes before;
  for (int level = 0; level < 5000; ++level)
  {
    before.PutHead(0x00180001, "SQ", DicomBytes::Undefined).PutItem();
  }
  ExpectRefused(MakeImage(before), "sequences within sequences");
  // Behind the pixels, too: no library reads them.
  DicomBytes after = MakeImage();
  after.PutRaw(std::string(before.Get().begin(), before.Get().end()));
  ExpectSamples(after, SlicePixels);
}

TEST(DicomSlice, AWrongLengthTakesNoMemory)
{
  const auto findPeak = []
  {
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss; // KiB
  };
  const auto before = findPeak();
  ExpectRefused(MakeImage(DicomBytes().PutHead(0x0008103e, "UT", 0x20000000)), "damaged");
  ExpectRefused(
    MakeImage(DicomBytes().PutHead(0x00081140, "SQ", DicomBytes::Undefined).PutItem(0x20000000)),
    "damaged");
  EXPECT_LT(findPeak() - before, 64 << 10);
}

TEST(DicomSlice, TruncatedPixelsAreAnErrorAndMoreThanNeededAreNot)
{
  DicomBytes start;
  start.PutStart(SliceSyntax).PutImage(3, 2);
  DicomBytes few = start;
  ExpectRefused(few.PutBytes(0x7fe00010, "OW", { 1, 2, 3, 4 }), "truncated");
  DicomBytes cut = start;
  ExpectRefused(cut.PutHead(0x7fe00010, "OW", 12).PutRaw("abcd"), "truncated");
  DicomBytes more = start;
  Bytes pixels = SlicePixels;
  pixels.resize(40);
  ExpectSamples(more.PutBytes(0x7fe00010, "OW", pixels), SlicePixels);
}

TEST(DicomSlice, SamplesOfEitherByteOrderAreRead)
{
  const std::string big = "1.2.840.10008.1.2.2";
  const std::string bigPixels = "1.2.840.113619.5.2"; // of GE: behind a little-endian header
  const Bytes pixels = { 1, 2, 3, 4, 5, 6, 7, 8 };
  const auto expect = [&](const std::string& syntax, const std::string& kind, std::uint32_t bits,
                        std::uint32_t samples, const Bytes& expected)
  {
    DicomBytes bytes;
    bytes.PutStart(syntax);
    bytes.IsBigEndian = syntax == big;
    bytes.IsImplicit = syntax == bigPixels;
    ExpectSamples(bytes.PutImage(samples, 1, bits).PutBytes(0x7fe00010, kind, pixels), expected);
  };
  const Bytes oddPixels = { 1, 2, 3, 4, 5, 6, 7 };
  const Bytes swapped = { 2, 1, 4, 3, 6, 5, 8, 7 };
  const Bytes reversed = { 4, 3, 2, 1, 8, 7, 6, 5 };
  expect(SliceSyntax, "OW", 8, 7, oddPixels);
  expect(SliceSyntax, "OW", 32, 2, pixels);
  expect(bigPixels, "OW", 8, 7, oddPixels);
  expect(bigPixels, "OW", 16, 4, swapped);
  expect(bigPixels, "OW", 32, 2, reversed);
  expect(big, "OB", 8, 7, oddPixels);
  expect(big, "OW", 8, 7, { 2, 1, 4, 3, 6, 5, 8 });
  expect(big, "OW", 16, 4, swapped);
  expect(big, "OW", 32, 2, reversed);
}

TEST(DicomSlice, RunLengthsAreDecodedWithinTheirBounds)
{
  const auto make = [](std::uint32_t segments, std::uint32_t second, const Bytes& runs)
  {
    DicomBytes bytes;
    bytes.PutStart("1.2.840.10008.1.2.5").PutImage(3, 2);
    bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0);
    bytes.PutItem(static_cast<std::uint32_t>(64 + runs.size()));
    bytes.Put(segments, 4).Put(64, 4).Put(second, 4).PutRaw(std::string(52, '\0'));
    bytes.PutRaw(std::string(runs.begin(), runs.end())).PutEnd(DicomBytes::SequenceEnd);
    return bytes;
  };
  // Six times 1; 1, 2, 3 and three times 7: the high bytes and the low ones.
  const Bytes runs = { 251, 1, 128, 2, 1, 2, 3, 254, 7, 0 };
  ExpectSamples(make(2, 67, runs), { 1, 1, 2, 1, 3, 1, 7, 1, 7, 1, 7, 1 });
  for (const std::uint32_t second : { 0u, 63u, 66u, 74u, 75u, 0x7fffffffu, 0xffffffffu })
  {
    ExpectRefused(make(2, second, runs), second == 66 ? "" : "run lengths");
  }
  ExpectRefused(make(1, 0, runs), "run lengths");
  ExpectRefused(make(2, 67, { 251, 1, 0, 9, 1, 2, 3, 4 }), "run lengths");
}

TEST(DicomSlice, ACompressedImageOfAnotherSizeIsAnError)
{
  // The starts of JPEG-LS and of JPEG 2000, for 3 x 2 and for other sizes.
  const std::string lossless = "1.2.840.10008.1.2.4.80";
  const std::string wavelets = "1.2.840.10008.1.2.4.90";
  const auto make = [](const std::string& syntax, const Bytes& code)
  {
    DicomBytes bytes;
    bytes.PutStart(syntax).PutImage(3, 2);
    bytes.PutHead(0x7fe00010, "OB", DicomBytes::Undefined).PutItem(0);
    bytes.PutItem(static_cast<std::uint32_t>(code.size()));
    return bytes.PutRaw(std::string(code.begin(), code.end())).PutEnd(DicomBytes::SequenceEnd);
  };
  const auto join = [](Bytes first, const Bytes& second)
  {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  };
  const Bytes frame = { 0xff, 0xf7, 0, 11, 16, 0, 1, 0, 3, 1, 1, 0x11, 0, 0 };
  ExpectRefused(make(lossless, join({ 0xff, 0xd8 }, frame)), "another size");
  ExpectRefused(
    make(lossless, join({ 0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, 2 }, frame)), "another size");
  ExpectRefused(make(lossless, join({ 0xff, 0xd8, 7 }, frame)), "does not begin as JPEG");
  // Markers without a length, which a decoder skips: to the size behind them, not to the other one.
  for (const std::uint8_t marker : { 0x00, 0x01, 0xd0, 0xd7, 0xd8, 0xd9 })
  {
    ExpectRefused(make(lossless, join({ 0xff, 0xd8, 0xff, marker, 0, 4, 1, 2 }, frame)),
      "does not begin as JPEG");
  }
  ExpectRefused(make(lossless, frame), "does not begin as JPEG");

  Bytes code = { 0xff, 0x4f, 0xff, 0x51, 0, 41, 0, 0, 0, 0, 0xff, 0, 0, 0, 0xff, 0 };
  code.resize(60);
  code[41] = 1;
  const Bytes signature = { 0, 0, 0, 12, 0x6a, 0x50, 0x20, 0x20, 0x0d, 0x0a, 0x87, 0x0a };
  const Bytes box = { 0, 0, 0, 68, 0x6a, 0x70, 0x32, 0x63 };
  const Bytes longBox = { 0, 0, 0, 1, 0x6a, 0x70, 0x32, 0x63, 0, 0, 0, 0, 0, 0, 0, 76 };
  ExpectRefused(make(wavelets, code), "another size");
  ExpectRefused(make(wavelets, join(signature, join(box, code))), "another size");
  ExpectRefused(make(wavelets, join(signature, join(longBox, code))), "another size");
  ExpectRefused(make(wavelets, join(signature, code)), "does not begin as JPEG");
  ExpectRefused(make(wavelets, signature), "does not begin as JPEG");
  // A marker that is skipped comes before the size.
  code.insert(code.begin() + 2, { 0xff, 0x30 });
  ExpectRefused(make(wavelets, code), "does not begin as JPEG");
}

TEST(DicomVolume, IsForkedWithoutItsHeadersBeingReadAgain)
{
  const std::filesystem::path folder =
    testing::TempDir() + "DicomVolume-fork-" + std::to_string(::getpid());
  std::filesystem::create_directory(folder);
  for (const std::string number : { "0", "1" })
  {
    DicomBytes bytes;
    bytes.PutStart(SliceSyntax).PutImage(3, 2, 16, "0\\0\\" + number);
    bytes.PutBytes(0x7fe00010, "OW", SlicePixels);
    std::ofstream(folder / (number + ".dcm"), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.Get().data()),
        static_cast<std::streamsize>(bytes.Get().size()));
  }
  const auto opened = OpenForeignVolume(GetLocalFileSystem(), folder.string());
  ASSERT_TRUE(opened.IsOk()) << opened.GetStatus().GetMessage();
  ASSERT_EQ(opened->Source->GetBox().High, (Index3{ 3, 2, 2 }));
  std::filesystem::remove(folder / "1.dcm"); // a header that is read again is missed now
  const auto forked = opened->Source->Fork();
  ASSERT_NE(forked, nullptr);
  const auto samples = forked->Read({ { 0, 0, 0 }, { 3, 2, 1 } });
  ASSERT_TRUE(samples.IsOk()) << samples.GetStatus().GetMessage();
  EXPECT_EQ(std::memcmp(samples->Arrays.at(0).First, SlicePixels.data(), SlicePixels.size()), 0);
  EXPECT_EQ(forked->Read({ { 0, 0, 1 }, { 3, 2, 2 } }).GetStatus().GetCode(), StatusCode::NotFound);
  std::filesystem::remove_all(folder);
}

namespace
{

/// A folder that is removed at the end of the test.
class SeriesFolder
{
public:
  SeriesFolder()
    : Path(testing::TempDir() + "DicomVolume-series-" + std::to_string(::getpid()))
  {
    std::filesystem::create_directory(this->Path);
  }
  ~SeriesFolder() { std::filesystem::remove_all(this->Path); }

  /// Writes a file of a series, the UID of which has the length of that of DicomBytes.
  void Write(const std::string& name, Bytes bytes, const std::string& series) const
  {
    const std::string uid = "1.2.3";
    const auto at = std::search(bytes.begin(), bytes.end(), uid.begin(), uid.end());
    if (at != bytes.end())
    {
      std::copy(series.begin(), series.end(), at);
    }
    std::ofstream(this->Path / name, std::ios::binary)
      .write(
        reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  std::string FindError(const std::string& within = "") const
  {
    const auto opened = OpenForeignVolume(GetLocalFileSystem(), this->Path.string() + within);
    return opened.IsOk() ? std::string() : opened.GetStatus().GetMessage();
  }

  const std::filesystem::path Path;
};

DicomBytes MakeSlice(
  const std::string& place, std::uint32_t bits = 16, const std::string& syntax = SliceSyntax)
{
  DicomBytes bytes;
  bytes.PutStart(syntax).PutImage(3, 2, bits, "0\\0\\" + place);
  return bytes.PutBytes(0x7fe00010, "OW", SlicePixels);
}

/// The first bytes, up to a tag.
Bytes CutBefore(const Bytes& whole, std::uint32_t tag)
{
  const Bytes head = DicomBytes().Put(tag >> 16, 2).Put(tag & 0xffff, 2).Get();
  return Bytes(whole.begin(), std::search(whole.begin(), whole.end(), head.begin(), head.end()));
}

} // namespace

TEST(DicomVolume, AnUnreadableImageIsAnErrorOfItsSeriesAlone)
{
  const std::vector<std::pair<Bytes, std::string>> bad = {
    { MakeSlice("2", 1).Get(), "its samples have 1 bits" }, // of a segmentation
    { MakeSlice("2", 16, "1.2.840.999").Get(), "its transfer syntax 1.2.840.999" },
    { CutBefore(MakeSlice("2").Get(), 0x00280010), "" },
  };
  for (const auto& [bytes, reason] : bad)
  {
    SCOPED_TRACE(reason);
    const SeriesFolder folder;
    folder.Write("bad.dcm", bytes, "1.2.9");
    const std::string error = folder.FindError();
    const std::string expected = (folder.Path / "bad.dcm").string() + ": cannot be read: ";
    EXPECT_EQ(error.find(expected), 0u) << error;
    EXPECT_NE(error.find(reason), std::string::npos) << error;
    folder.Write("0.dcm", MakeSlice("0").Get(), "1.2.3");
    folder.Write("1.dcm", MakeSlice("1").Get(), "1.2.3");
    for (const std::string within : { "", ":1.2.3", "/0.dcm" })
    {
      EXPECT_EQ(folder.FindError(within), "") << within;
    }
    for (const std::string within : { ":1.2.9", ":.9", "/bad.dcm" })
    {
      EXPECT_EQ(folder.FindError(within), error) << within;
    }
    const auto list = Require(ListForeignVolumes(GetLocalFileSystem(), folder.Path.string()));
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0].Name + ": " + list[0].Shape, "head (2 slices of 3 x 2): 2 x 2 x 3");
    EXPECT_EQ(list[1].Name + ": " + list[1].Storage, "1.2.9: " + error);
    // A slice of the series that is chosen is no less an error than before.
    folder.Write("bad.dcm", bytes, "1.2.3");
    for (const std::string within : { "", ":1.2.3", "/0.dcm" })
    {
      EXPECT_EQ(folder.FindError(within), error) << within;
    }
    // Of two that can be read one is to be named.
    folder.Write("bad.dcm", bytes, "1.2.9");
    folder.Write("0.dcm", MakeSlice("0").Get(), "1.2.4");
    const std::string choice = folder.FindError();
    EXPECT_NE(choice.find("name one of its series"), std::string::npos) << choice;
  }
}

TEST(DicomVolume, AnUnreadableImageWhoseSeriesIsNotKnownIsAnErrorOfAll)
{
  const SeriesFolder folder;
  folder.Write("0.dcm", MakeSlice("0").Get(), "1.2.3");
  folder.Write("bad.dcm", CutBefore(MakeSlice("1").Get(), 0x0020000e), "");
  const std::string error = folder.FindError();
  EXPECT_EQ(error.find((folder.Path / "bad.dcm").string()), 0u) << error;
  EXPECT_EQ(folder.FindError(":1.2.3"), error);
  ExpectMessage(ListForeignVolumes(GetLocalFileSystem(), folder.Path.string()).GetStatus(), error);
}

TEST(DicomSlice, APathThatTheSystemRefusesIsAnError)
{
  const auto volume =
    OpenForeignVolume(GetLocalFileSystem(), testing::TempDir() + std::string(300, 'n') + ".dcm");
  ExpectMessage(volume.GetStatus(), "nnn.dcm: ");
}
