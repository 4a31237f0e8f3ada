// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures/SampleFiles.h"

#include "Formats/Indexing/SourceIndex.h"
#include "Formats/Opener/ForeignVolume.h"

#include <algorithm>

using namespace isosurface;

namespace
{

const Index3 Size = { 6, 5, 4 };

Bytes Join(const std::string& header, const Bytes& samples)
{
  Bytes bytes = MakeBytes(header);
  bytes.insert(bytes.end(), samples.begin(), samples.end());
  return bytes;
}

template <typename T>
RawVolume ExpectVolume(MemoryDisk& disk, const std::string& path, const SampleVolume<T>& volume)
{
  const auto raw = RawVolume::ReadHeader(disk, path);
  EXPECT_TRUE(raw.IsOk()) << raw.GetStatus().GetMessage();
  if (!raw.IsOk())
  {
    return {};
  }
  EXPECT_EQ(raw->Grid.GetDimensions(), volume.GetDimensions());
  EXPECT_EQ(raw->Type, ValueTypeOf<T>::Value);
  const auto source = raw->Open(disk);
  EXPECT_TRUE(source.IsOk()) << source.GetStatus().GetMessage();
  if (source.IsOk())
  {
    ExpectSamples(**source, volume);
  }
  return *raw;
}

void ExpectHeaderRefused(
  const std::string& name, const std::string& text, const std::string& reason)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/" + name, MakeBytes(text));
  const auto raw = RawVolume::ReadHeader(disk, "/data/" + name);
  ASSERT_FALSE(raw.IsOk()) << text;
  const std::string& message = raw.GetStatus().GetMessage();
  EXPECT_EQ(message.find("/data/" + name + ": "), 0u) << message;
  EXPECT_NE(message.find(reason), std::string::npos) << message;
}

const std::string MetaStart = "ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\n";
const std::string NrrdStart = "NRRD0004\n# made by hand\ntype: short\ndimension: 3\n"
                              "sizes: 6 5 4\nendian: little\n";

} // namespace

TEST(MetaImageHeader, ReadsSamplesInAnotherFile)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.raw", MakeBytes(volume, true));
  WriteFile(disk, "/data/a.mhd",
    MakeBytes(MetaStart +
      "BinaryData = True\r\nBinaryDataByteOrderMSB = True\nCompressedData = False\n"
      "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = -1.5 2 3e1\nElementSpacing = 0.5 0.25 2\n"
      "AnatomicalOrientation = RAI\nElementType = MET_SHORT\nElementDataFile = a.raw\n"));
  const RawVolume raw = ExpectVolume(disk, "/data/a.mhd", volume);
  EXPECT_EQ(raw.Grid.Origin, (std::array<double, 3>{ -1.5, 2, 30 }));
  EXPECT_EQ(raw.Grid.Spacing, (std::array<double, 3>{ 0.5, 0.25, 2 }));
  // The x axis points along +y: (0, 1, 0) is the first column.
  EXPECT_EQ(raw.Grid.Direction, (std::array<double, 9>{ 0, -1, 0, 1, 0, 0, 0, 0, 1 }));
}

TEST(MetaImageHeader, ReadsSamplesAfterTheHeaderAndCompressedOnes)
{
  const auto volume = MakeRamp<float>(Size);
  MemoryDisk disk;
  const std::string header = MetaStart + "ElementType = MET_FLOAT\n";
  WriteFile(disk, "/data/a.mha", Join(header + "ElementDataFile = LOCAL\n", MakeBytes(volume)));
  ExpectVolume(disk, "/data/a.mha", volume);
  WriteFile(disk, "/data/b.mha",
    Join(header + "CompressedData = True\nCompressedDataSize = 77\nElementDataFile = LOCAL\n",
      Deflate(MakeBytes(volume), 15)));
  ExpectVolume(disk, "/data/b.mha", volume);
  WriteFile(disk, "/data/c.raw", Join("any header", MakeBytes(volume)));
  WriteFile(disk, "/data/c.mhd", MakeBytes(header + "HeaderSize = -1\nElementDataFile = c.raw\n"));
  ExpectVolume(disk, "/data/c.mhd", volume);
}

TEST(MetaImageHeader, ReadsSeriesOfFiles)
{
  const auto volume = MakeRamp<std::uint8_t>(Size);
  const Bytes samples = MakeBytes(volume);
  MemoryDisk disk;
  std::string list;
  for (int slice = 0; slice < 4; ++slice)
  {
    const auto from = samples.begin() + slice * 30;
    const std::string name = "slice0" + std::to_string(2 * slice + 1) + ".raw";
    WriteFile(disk, "/data/" + name, Bytes(from, from + 30));
    list += name + "\n";
  }
  const std::string header = MetaStart + "ElementType = MET_UCHAR\nElementDataFile = ";
  WriteFile(disk, "/data/a.mhd", MakeBytes(header + "LIST\n" + list));
  WriteFile(disk, "/data/b.mhd", MakeBytes(header + "slice%02d.raw 1 7 2\n"));
  ExpectVolume(disk, "/data/a.mhd", volume);
  ExpectVolume(disk, "/data/b.mhd", volume);
}

TEST(MetaImageHeader, DropsAxesOfOneSampleBeyondTheThird)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.mha",
    Join("NDims = 4\nDimSize = 6 5 4 1\nElementSpacing = 1 2 3 4\nOffset = 5 6 7 8\n"
         "TransformMatrix = 0 1 0 0 1 0 0 0 0 0 1 0 0 0 0 1\nElementType = MET_SHORT\n"
         "ElementDataFile = LOCAL\n",
      MakeBytes(volume)));
  const RawVolume raw = ExpectVolume(disk, "/data/a.mha", volume);
  EXPECT_EQ(raw.Grid.Spacing, (std::array<double, 3>{ 1, 2, 3 }));
  EXPECT_EQ(raw.Grid.Origin, (std::array<double, 3>{ 5, 6, 7 }));
  EXPECT_EQ(raw.Grid.Direction, (std::array<double, 9>{ 0, 1, 0, 1, 0, 0, 0, 0, 1 }));
}

TEST(MetaImageHeader, AFileWithAPercentSignIsNoPattern)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/50%d.raw", MakeBytes(volume));
  const std::string header = MetaStart + "ElementType = MET_SHORT\nElementDataFile = 50%d.raw\n";
  WriteFile(disk, "/data/a.mhd", MakeBytes(header));
  ExpectVolume(disk, "/data/a.mhd", volume);
}

TEST(MetaImageHeader, UnitsAreTakenAndScalesTold)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a.mha",
    Join(MetaStart +
        "DistanceUnits = um\nElementToIntensityFunctionSlope = 2\n"
        "ElementType = MET_SHORT\nElementDataFile = LOCAL\n",
      MakeBytes(MakeRamp<std::int16_t>(Size))));
  const auto opened = Require(OpenForeignVolume(disk, "/data/a.mha"));
  EXPECT_EQ(opened.Grid.Unit, LengthUnit::Micrometer);
  EXPECT_EQ(opened.LeftOut,
    "the samples are not scaled by ElementToIntensityFunctionSlope, 2, and -Offset, 0");
}

TEST(MetaImageHeader, FieldsThatContradictOneAnotherAreRefused)
{
  MemoryDisk disk;
  for (const char* const twice :
    { "Offset = 1 2 3\nOrigin = 4 5 6\n", "ElementSpacing = 1 1 1\nElementSpacing = 2 2 2\n",
      "BinaryDataByteOrderMSB = False\nElementByteOrderMSB = True\n" })
  {
    WriteFile(disk, "/data/a.mha",
      Join(MetaStart + twice + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n",
        MakeBytes(MakeRamp<std::int16_t>(Size))));
    EXPECT_NE(
      OpenForeignVolume(disk, "/data/a.mha").GetStatus().GetMessage().find("is there twice"),
      std::string::npos)
      << twice;
  }
}

TEST(MetaImageHeader, BytesBehindTheSamplesAreTold)
{
  MemoryDisk disk;
  WriteFile(disk, "/data/a.raw", Join("12345", MakeBytes(MakeRamp<std::int16_t>(Size))));
  const std::string header = MetaStart + "ElementType = MET_SHORT\nElementDataFile = a.raw\n";
  WriteFile(disk, "/data/a.mhd", MakeBytes("HeaderSize = 3\n" + header));
  EXPECT_EQ(Require(OpenForeignVolume(disk, "/data/a.mhd")).LeftOut,
    "2 bytes behind the samples are not read");
  WriteFile(disk, "/data/a.mhd", MakeBytes("HeaderSize = 5\n" + header));
  EXPECT_EQ(Require(OpenForeignVolume(disk, "/data/a.mhd")).LeftOut, "");
}

TEST(MetaImageHeader, ErrorsNameWhatIsNotSupported)
{
  const std::string data = "ElementType = MET_SHORT\nElementDataFile = a.raw\n";
  ExpectHeaderRefused("a.mhd", "", "no ElementDataFile");
  ExpectHeaderRefused("a.mhd", "what is this\n", "without \"=\"");
  ExpectHeaderRefused("a.mhd", "NDims = 4\nDimSize = 6 5 4 3\n" + data, "NDims");
  ExpectHeaderRefused("a.mhd", "NDims = 3\nDimSize = 6 5\n" + data, "DimSize");
  ExpectHeaderRefused("a.mhd", "NDims = 3\nDimSize = 6 -5 4\n" + data, "DimSize");
  ExpectHeaderRefused("a.mhd", MetaStart + "ElementSpacing = 1 2\n" + data, "ElementSpacing");
  ExpectHeaderRefused("a.mhd", MetaStart + "ElementNumberOfChannels = 3\n" + data, "channel");
  ExpectHeaderRefused("a.mhd", MetaStart + "BinaryData = False\n" + data, "text");
  ExpectHeaderRefused("a.mhd", MetaStart + "HeaderSize = -7\n" + data, "HeaderSize");
  ExpectHeaderRefused(
    "a.mhd", MetaStart + "HeaderSize = -1\nCompressedData = True\n" + data, "HeaderSize, -1");
  ExpectHeaderRefused(
    "a.mhd", MetaStart + "ElementType = MET_STRING\nElementDataFile = a\n", "string");
  ExpectHeaderRefused(
    "a.mhd", MetaStart + "ElementType = MET_SHORT\nElementDataFile = %s 1 2 3\n", "pattern");
  ExpectHeaderRefused(
    "a.mhd", MetaStart + "ElementType = MET_SHORT\nElementDataFile = %d 2 1 2\n", "pattern");
  ExpectHeaderRefused(
    "a.mhd", MetaStart + "ElementType = MET_SHORT\nElementDataFile =\n", "no file");
  ExpectHeaderRefused("a.tif", "", "the supported headers are .mhd");
}

TEST(NrrdHeader, ReadsRawAndGzipSamplesAfterTheHeader)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.nrrd",
    Join(NrrdStart +
        "space: left-posterior-superior\nspace directions: (0,2,0) (-3,0,0) (0,0,0.5)\n"
        "space origin: (1,2,3.5)\nkinds: domain domain domain\nencoding: raw\nkey:=value\n\n",
      MakeBytes(volume)));
  const RawVolume raw = ExpectVolume(disk, "/data/a.nrrd", volume);
  EXPECT_EQ(raw.Grid.Origin, (std::array<double, 3>{ 1, 2, 3.5 }));
  EXPECT_EQ(raw.Grid.Spacing, (std::array<double, 3>{ 2, 3, 0.5 }));
  EXPECT_EQ(raw.Grid.Direction, (std::array<double, 9>{ 0, -1, 0, 1, 0, 0, 0, 0, 1 }));
  const Bytes skipped = Join("skipped", MakeBytes(volume));
  WriteFile(disk, "/data/b.nrrd",
    Join(NrrdStart + "spacings: 1 nan 2\nencoding: gzip\nbyte skip: 7\n\n", Deflate(skipped)));
  EXPECT_EQ(
    ExpectVolume(disk, "/data/b.nrrd", volume).Grid.Spacing, (std::array<double, 3>{ 1, 1, 2 }));
  WriteFile(disk, "/data/c.nrrd", Join(NrrdStart + "encoding: raw\nbyte skip: -1\n\n", skipped));
  ExpectVolume(disk, "/data/c.nrrd", volume);
}

TEST(NrrdHeader, ReadsSamplesInOtherFiles)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  const Bytes samples = MakeBytes(volume);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.raw", samples);
  WriteFile(disk, "/data/1.raw", Bytes(samples.begin(), samples.begin() + 120));
  WriteFile(disk, "/data/2.raw", Bytes(samples.begin() + 120, samples.end()));
  const std::string header = NrrdStart + "encoding: raw\ndata file: ";
  WriteFile(disk, "/data/a.nhdr", MakeBytes(header + "a.raw\n"));
  WriteFile(disk, "/data/b.nhdr", MakeBytes(header + "LIST\n1.raw\n2.raw\n"));
  WriteFile(disk, "/data/c.nhdr", MakeBytes(header + "%d.raw 1 2 1\n"));
  for (const char* path : { "/data/a.nhdr", "/data/b.nhdr", "/data/c.nhdr" })
  {
    ExpectVolume(disk, path, volume);
  }
}

TEST(NrrdHeader, SkipsLinesAndBytes)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  const Bytes samples = MakeBytes(volume);
  MemoryDisk disk;
  const std::string text = "first line\n\nthird, of any length\n";
  WriteFile(disk, "/data/a.raw", Join(text + "1234", samples));
  const std::string lines = NrrdStart + "line skip: 3\n";
  WriteFile(
    disk, "/data/a.nhdr", MakeBytes(lines + "byte skip: 4\nencoding: raw\ndata file: a.raw\n"));
  ExpectVolume(disk, "/data/a.nhdr", volume);
  WriteFile(
    disk, "/data/b.nhdr", MakeBytes(lines + "byte skip: -1\nencoding: raw\ndata file: a.raw\n"));
  ExpectVolume(disk, "/data/b.nhdr", volume);
  // Lines before the stream, bytes in the uncompressed stream.
  WriteFile(disk, "/data/c.gz", Join(text, Deflate(Join("1234", samples))));
  WriteFile(
    disk, "/data/c.nhdr", MakeBytes(lines + "byte skip: 4\nencoding: gzip\ndata file: c.gz\n"));
  ExpectVolume(disk, "/data/c.nhdr", volume);
  WriteFile(disk, "/data/d.nrrd", Join(lines + "encoding: raw\n\n" + text, samples));
  ExpectVolume(disk, "/data/d.nrrd", volume);
  WriteFile(disk, "/data/short.raw", MakeBytes(std::string("one\ntwo\n")));
  WriteFile(disk, "/data/e.nhdr", MakeBytes(lines + "encoding: raw\ndata file: short.raw\n"));
  const auto raw = Require(RawVolume::ReadHeader(disk, "/data/e.nhdr"));
  EXPECT_EQ(raw.Open(disk).GetStatus().GetCode(), StatusCode::Corrupt);
}

TEST(NrrdHeader, SkipsLinesOfEachCompressedFile)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  const Bytes samples = MakeBytes(volume);
  MemoryDisk disk;
  for (int slab = 0; slab < 2; ++slab)
  {
    const Bytes part(samples.begin() + slab * 120, samples.begin() + (slab + 1) * 120);
    const std::string name = "/data/" + std::to_string(slab);
    WriteFile(
      disk, name + ".raw", Join(std::string(static_cast<std::size_t>(slab) * 9, 'x') + "\n", part));
    WriteFile(disk, name + ".gz", Deflate(part));
  }
  WriteFile(disk, "/data/a.nhdr",
    MakeBytes(NrrdStart + "line skip: 1\nencoding: raw\ndata file: %d.raw 0 1 1\n"));
  ExpectVolume(disk, "/data/a.nhdr", volume);
  WriteFile(
    disk, "/data/b.nhdr", MakeBytes(NrrdStart + "encoding: gzip\ndata file: LIST\n0.gz\n1.gz\n"));
  ExpectVolume(disk, "/data/b.nhdr", volume);
}

TEST(NrrdHeader, DropsAxesOfOneSampleThatAreNotOfSpace)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  const std::string end = "endian: little\nencoding: raw\n\n";
  WriteFile(disk, "/data/a.nrrd",
    Join("NRRD0005\ntype: short\ndimension: 4\nsizes: 1 6 5 4\nkinds: vector domain domain domain\n"
         "space directions: none (2,0,0) (0,3,0) (0,0,4)\nspace origin: (7,8,9)\n" +
        end,
      MakeBytes(volume)));
  const RawVolume raw = ExpectVolume(disk, "/data/a.nrrd", volume);
  EXPECT_EQ(raw.Grid.Spacing, (std::array<double, 3>{ 2, 3, 4 }));
  EXPECT_EQ(raw.Grid.Origin, (std::array<double, 3>{ 7, 8, 9 }));
  WriteFile(disk, "/data/b.nrrd",
    Join("NRRD0005\ntype: short\ndimension: 4\nsizes: 6 5 4 1\nspacings: 2 3 4 nan\n" + end,
      MakeBytes(volume)));
  EXPECT_EQ(
    ExpectVolume(disk, "/data/b.nrrd", volume).Grid.Spacing, (std::array<double, 3>{ 2, 3, 4 }));
  // A single slice in space: z is normal to it.
  const auto slice = MakeRamp<std::int16_t>({ 6, 5, 1 });
  WriteFile(disk, "/data/c.nrrd",
    Join(
      "NRRD0005\ntype: short\ndimension: 2\nsizes: 6 5\nspace directions: (0,2,0) (0,0,3)\n" + end,
      MakeBytes(slice)));
  EXPECT_EQ(ExpectVolume(disk, "/data/c.nrrd", slice).Grid.Direction,
    (std::array<double, 9>{ 0, 0, 1, 1, 0, 0, 0, 1, 0 }));
}

TEST(NrrdHeader, MinimaAndMaximaPlaceAnAxisByItsCenters)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  const auto read = [&](const std::string& fields)
  {
    WriteFile(
      disk, "/data/a.nrrd", Join(NrrdStart + fields + "encoding: raw\n\n", MakeBytes(volume)));
    return ExpectVolume(disk, "/data/a.nrrd", volume).Grid;
  };
  using Three = std::array<double, 3>;
  const std::string range = "axis mins: 0 10 -2\naxismaxs: 12 20 2\n";
  // Of cells, as Teem has it where nothing is said: borders of 6, 5, 4 cells.
  for (const std::string centers :
    { "", "centers: cell cell cell\n", "centerings: ??? none cell\n" })
  {
    const GridGeometry cells = read(range + centers);
    EXPECT_EQ(cells.Spacing, (Three{ 2, 2, 1 })) << centers;
    EXPECT_EQ(cells.Origin, (Three{ 1, 11, -1.5 })) << centers;
  }
  const GridGeometry nodes = read(range + "centers: node node node\n");
  EXPECT_EQ(nodes.Spacing, (Three{ 12.0 / 5, 10.0 / 4, 4.0 / 3 }));
  EXPECT_EQ(nodes.Origin, (Three{ 0, 10, -2 }));
  const GridGeometry spaced =
    read("spacings: 0.5 nan 2\naxis mins: 3 nan 7\ncenters: node cell cell\n");
  EXPECT_EQ(spaced.Spacing, (Three{ 0.5, 1, 2 }));
  EXPECT_EQ(spaced.Origin, (Three{ 3, 0, 8 }));
}

TEST(NrrdHeader, UnitsAreThoseOfTheSpaceOrOfTheAxes)
{
  MemoryDisk disk;
  const auto open = [&](const std::string& fields)
  {
    WriteFile(disk, "/data/a.nrrd",
      Join(NrrdStart + fields + "encoding: raw\n\n", MakeBytes(MakeRamp<std::int16_t>(Size))));
    return Require(OpenForeignVolume(disk, "/data/a.nrrd"));
  };
  const std::string space = "space: LPS\nspace directions: (0,2,0) (3,0,0) (0,0,4)\n";
  EXPECT_EQ(open(space + "space units: \"mm\" \"mm\" \"mm\"\n").Grid.Unit, LengthUnit::Millimeter);
  const auto mixed = open(space + "space units: \"mm\" \"mm\" \"um\"\n");
  EXPECT_EQ(mixed.Grid.Unit, LengthUnit::Unknown);
  EXPECT_EQ(mixed.LeftOut, "the units of its space are not kept: \"mm\" \"mm\" \"um\"");
  // Of axes, lengths in other units are those of the first one.
  const auto axes = open("spacings: 1 2 3\nunits: \"um\" \"nm\" \"mm\"\nsample units: \"HU\"\n");
  EXPECT_EQ(axes.Grid.Unit, LengthUnit::Micrometer);
  EXPECT_EQ(axes.Grid.Spacing, (std::array<double, 3>{ 1, 0.002, 3000 }));
  EXPECT_EQ(axes.Arrays[0].Unit, "HU");
  EXPECT_EQ(open("units: \"mm\" \"mm\" \"s\"\n").LeftOut,
    "units of the axes are not kept: x mm, y mm, z s");
  EXPECT_EQ(open("kinds: domain domain time\nold min: 0\n").LeftOut,
    "its time is the axis z; samples are not brought back to the values before they were quantized "
    "(oldmin 0)");
}

TEST(NrrdHeader, MoreBytesThanTheHeaderTellsAreRefused)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/a.raw", Join("shift", MakeBytes(volume)));
  WriteFile(disk, "/data/a.gz", Deflate(Join("shift", MakeBytes(volume))));
  WriteFile(disk, "/data/a.nhdr", MakeBytes(NrrdStart + "encoding: raw\ndata file: a.raw\n"));
  const Status raw = OpenForeignVolume(disk, "/data/a.nhdr").GetStatus();
  EXPECT_EQ(raw.GetCode(), StatusCode::Corrupt);
  EXPECT_NE(raw.GetMessage().find("/data/a.raw: it has 5 bytes more than"), std::string::npos)
    << raw.GetMessage();
  // In a stream it is seen at its end.
  WriteFile(disk, "/data/b.nhdr", MakeBytes(NrrdStart + "encoding: gzip\ndata file: a.gz\n"));
  const auto packed = Require(OpenForeignVolume(disk, "/data/b.nhdr"));
  const Status read = packed.Source->Read(packed.Source->GetBox()).GetStatus();
  EXPECT_NE(read.GetMessage().find("more than the 240 bytes"), std::string::npos)
    << read.GetMessage();
}

TEST(NrrdHeader, AFileWithAStarInItsNameIsNoPattern)
{
  const auto volume = MakeRamp<std::int16_t>(Size);
  MemoryDisk disk;
  WriteFile(disk, "/data/a*?.nrrd", Join(NrrdStart + "encoding: raw\n\n", MakeBytes(volume)));
  const auto opened = Require(OpenForeignVolume(disk, "/data/a*?.nrrd"));
  ExpectSamples(*opened.Source, volume);
}

TEST(NrrdHeader, ErrorsNameWhatIsNotSupported)
{
  ExpectHeaderRefused("a.nrrd", "", "does not begin with NRRD");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "encoding: ascii\n", "encoding \"ascii\"");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "encoding raw\n", "a line without \":\"");
  ExpectHeaderRefused("a.nrrd", "NRRD0004\ndimension: 4\nsizes: 3 6 5 4\n", "dimension");
  ExpectHeaderRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 6 5\n", "sizes");
  ExpectHeaderRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 6 5 0\n", "sizes");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "kinds: vector domain domain\n", "vector");
  ExpectHeaderRefused(
    "a.nrrd", NrrdStart + "space directions: none (1,0,0) (0,1,0)\n", "direction");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "space directions: (1,0,0) (0,1,0)\n", "directions");
  ExpectHeaderRefused(
    "a.nrrd", NrrdStart + "space directions: (1,0) (0,1,0) (0,0,1)\n", "directions");
  ExpectHeaderRefused(
    "a.nrrd", NrrdStart + "space directions: (1,0,0) (0,1,0) (0,0,1\n", "directions");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "space origin: (1,2)\nencoding: raw\n", "space origin");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "encoding: raw\nline skip: -2\n", "line skip");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "encoding: gzip\nbyte skip: -1\n", "byte skip");
  ExpectHeaderRefused("a.nrrd", NrrdStart + "encoding: raw\nbyte skip: -3\n", "byte skip");
  ExpectHeaderRefused("a.nrrd", "NRRD0004\ntype: block\ndimension: 3\nsizes: 6 5 4\n", "block");
  ExpectHeaderRefused(
    "a.nrrd", "NRRD0004\ntype: int\ndimension: 3\nsizes: 6 5 4\nencoding: raw\n", "endian");
}

// Otherwise ParaView would ask readers of VTK, which show something else.
TEST(VolumeHeaders, DamagedFilesAreOursIfTheirNameOrMarkTells)
{
  MemoryDisk disk;
  Bytes map(1024);
  WriteFile(disk, "/data/other.map", map);
  std::copy_n("MAP ", 4, map.begin() + 208);
  WriteFile(disk, "/data/a.map", map);
  WriteFile(disk, "/data/short.mrc", Bytes(500));
  WriteFile(disk, "/data/a.nii", Bytes(500));
  WriteFile(disk, "/data/a.nhdr", MakeBytes(NrrdStart + "encoding: raw\ndata file: missing.raw\n"));
  for (const std::string name : { "a.map", "short.mrc", "a.nii", "a.nhdr" })
  {
    EXPECT_FALSE(OpenForeignVolume(disk, "/data/" + name).IsOk()) << name;
    EXPECT_TRUE(CanBeIndexed(disk, "/data/" + name)) << name;
  }
  EXPECT_FALSE(CanBeIndexed(disk, "/data/other.map"));
}

TEST(MrcVolume, MoreTimeStepsThanAFileMayHaveAreRefused)
{
  for (const std::int32_t more : { 0, 1 })
  {
    const auto steps = static_cast<std::int32_t>(MaximumTimeSteps) + more;
    Bytes file(1024 + static_cast<std::size_t>(steps));
    const auto put = [&file](std::size_t place, std::int32_t number)
    { std::memcpy(file.data() + place, &number, sizeof(number)); };
    put(0, 1);
    put(4, 1);
    put(8, steps);
    put(36, 1);   // section in a volume
    put(88, 401); // a stack of volumes
    MemoryDisk disk;
    WriteFile(disk, "/data/a.mrc", file);
    const auto volume = OpenForeignVolume(disk, "/data/a.mrc");
    EXPECT_EQ(volume.IsOk(), more == 0) << volume.GetStatus().GetMessage();
    EXPECT_EQ(volume.GetStatus().GetMessage(),
      more == 0 ? "" : "/data/a.mrc: cannot be read: it has too many time steps");
  }
}
