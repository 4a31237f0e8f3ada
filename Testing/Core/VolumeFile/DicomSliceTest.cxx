// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/DicomBytes.h"
#include "Fixtures/SampleFiles.h"

#include "VolumeFile/DicomSlice.h"
#include "VolumeFile/VolumeFile.h"

#include <filesystem>
#include <fstream>

#include <sys/resource.h>

using namespace isosurface;

namespace
{

const std::string ExplicitLittle = "1.2.840.10008.1.2.1";
const Bytes Pixels = { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12 };

/// A file that is removed at the end of the test.
class File
{
public:
  explicit File(const Bytes& bytes)
    : Path(testing::TempDir() + "DicomSlice-" +
        testing::UnitTest::GetInstance()->current_test_info()->name() + ".dcm")
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
  bytes.PutStart(ExplicitLittle).PutRaw(std::string(before.Get().begin(), before.Get().end()));
  return bytes.PutImage(3, 2).PutBytes(0x7fe00010, "OW", Pixels);
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
  ExpectSamples(MakeImage(), Pixels);
}

TEST(DicomSlice, AValueOfAKindThatIsNoTextOrNumberIsMissing)
{
  for (const std::string kind : { "OD", "OL", "OV", "SV", "UV", "AT", "OB" })
  {
    DicomBytes bytes;
    bytes.PutStart(ExplicitLittle).PutHead(0x00280010, kind, 8);
    bytes.PutRaw("abcdefgh").PutNumber(0x00280011, 3).PutBytes(0x7fe00010, "OW", Pixels);
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
  ExpectSamples(after, Pixels);
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
  start.PutStart(ExplicitLittle).PutImage(3, 2);
  DicomBytes few = start;
  ExpectRefused(few.PutBytes(0x7fe00010, "OW", { 1, 2, 3, 4 }), "truncated");
  DicomBytes cut = start;
  ExpectRefused(cut.PutHead(0x7fe00010, "OW", 12).PutRaw("abcd"), "truncated");
  DicomBytes more = start;
  Bytes pixels = Pixels;
  pixels.resize(40);
  ExpectSamples(more.PutBytes(0x7fe00010, "OW", pixels), Pixels);
}

TEST(DicomSlice, SamplesWithUnusedBitsAreRead)
{
  const auto make = [](std::uint32_t bits, std::uint32_t stored, std::uint32_t highest)
  {
    DicomBytes bytes;
    bytes.PutStart(ExplicitLittle).PutText(0x00280004, "CS", "MONOCHROME2");
    bytes.PutNumber(0x00280010, 2).PutNumber(0x00280011, 6).PutNumber(0x00280100, bits);
    bytes.PutNumber(0x00280101, stored).PutNumber(0x00280102, highest);
    return bytes.PutBytes(0x7fe00010, "OW", bits == 8 ? Pixels : Bytes(24, 0xff));
  };
  ExpectSamples(make(8, 7, 6), Pixels);
  Bytes samples;
  EXPECT_EQ(FindError(make(16, 12, 11), &samples), "");
  EXPECT_EQ(samples[0] | samples[1] << 8, 0x0fff);
  ExpectRefused(make(16, 12, 15), "not in the lowest bits");
}

TEST(DicomSlice, APathThatTheSystemRefusesIsAnError)
{
  const auto volume =
    VolumeFile::Open(GetLocalFileSystem(), testing::TempDir() + std::string(300, 'n') + ".dcm");
  ASSERT_FALSE(volume.IsOk());
  EXPECT_NE(volume.GetStatus().GetMessage().find("nnn.dcm: "), std::string::npos)
    << volume.GetStatus().GetMessage();
}
