// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SpectraFile.h"

#include "Fixtures/VolumeOnDisk.h"
#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"

#include <limits>

using namespace isosurface;

namespace
{

const std::string SpectraPath = "/data/spectra";
constexpr std::uint64_t Identity = 0x123456789abcdef0;

/// Counts of every kind: flat, falling, alternating between the ends of the range.
WorkloadSpectrum MakeSpectrum(std::int64_t first, std::uint32_t count, std::uint64_t seed)
{
  WorkloadSpectrum spectrum(SpectrumBins{ first, -3, count });
  spectrum.AreaUnit = 0.1 / 3;
  spectrum.VolumeUnit = 1e-300;
  std::mt19937_64 random(seed);
  for (std::size_t bin = 0; bin < count; ++bin)
  {
    spectrum.Triangles[bin] = random();
    spectrum.ActiveCells[bin] = bin / 7;
    spectrum.ActiveBlocks[bin] = 0;
    spectrum.Bytes[bin] = bin % 2 == 0 ? 0 : std::numeric_limits<std::uint64_t>::max();
    spectrum.Area[bin] = 1000000 - bin * bin;
    spectrum.Volume[bin] = random() % 3;
  }
  return spectrum;
}

void ExpectEqual(const Result<WorkloadSpectrum>& read, const WorkloadSpectrum& written)
{
  ASSERT_TRUE(read.IsOk()) << read.GetStatus().GetMessage();
  EXPECT_EQ(read->Bins, written.Bins);
  EXPECT_EQ(read->AreaUnit, written.AreaUnit);
  EXPECT_EQ(read->VolumeUnit, written.VolumeUnit);
  for (std::size_t quantity = 0; quantity < WorkloadSpectrum::NumberOfQuantities; ++quantity)
  {
    EXPECT_EQ(*read->GetQuantities()[quantity], *written.GetQuantities()[quantity]) << quantity;
  }
}

/// Two arrays, three stores.
class SpectraFileOnDisk : public ::testing::Test
{
protected:
  void SetUp() override
  {
    std::vector<SpectraFile::Section> sections;
    for (std::uint64_t index = 0; index < 8; ++index)
    {
      const bool isFirst = index % 2 == 0;
      this->Spectra.push_back(MakeSpectrum(isFirst ? -900 : 5, isFirst ? 2048 : 17, index));
      if (index >= 2)
      {
        sections.push_back(SpectraFile::Pack(this->Spectra.back()));
      }
    }
    const Status status = SpectraFile::Write(
      this->Disk, SpectraPath, Identity, { this->Spectra[0], this->Spectra[1] }, sections);
    ASSERT_TRUE(status.IsOk()) << status.GetMessage();
  }

  /// The first error of opening the file and reading all of it.
  Status ReadAll()
  {
    ISOSURFACE_ASSIGN_OR_RETURN(
      const auto file, SpectraFile::Open(this->Disk, SpectraPath, Identity, 2, 3));
    for (std::size_t array = 0; array < 2; ++array)
    {
      ISOSURFACE_RETURN_IF_ERROR(file->ReadTotal(array).GetStatus());
      for (std::size_t store = 0; store < 3; ++store)
      {
        ISOSURFACE_RETURN_IF_ERROR(file->ReadStore(array, store).GetStatus());
      }
    }
    return Status::Ok();
  }

  MemoryDisk Disk;
  std::vector<WorkloadSpectrum> Spectra;
};

} // namespace

TEST(PackedCounts, RoundTripExactly)
{
  for (const std::vector<std::uint64_t>& counts :
    { std::vector<std::uint64_t>{}, { 0 }, { 1 }, { 0, 0, 0 }, { 5, 5, 5, 6, 6 },
      { std::uint64_t{ 1 } << 63, 0, ~std::uint64_t{ 0 }, 0, 1, 1 } })
  {
    std::vector<std::uint8_t> bytes = { 99 };
    AppendPackedCounts(counts, bytes);
    std::vector<std::uint64_t> read(counts.size(), 7);
    ByteReader reader(bytes.data() + 1, bytes.size() - 1);
    ASSERT_TRUE(ReadPackedCounts(reader, read));
    EXPECT_EQ(read, counts);
    EXPECT_EQ(reader.GetRemaining(), 0u);
    for (std::size_t size = 1; size < bytes.size(); ++size)
    {
      ByteReader truncated(bytes.data() + 1, size - 1);
      EXPECT_FALSE(ReadPackedCounts(truncated, read));
    }
  }
}

TEST(PackedCounts, RefuseNumbersThatDoNotFit)
{
  std::vector<std::uint64_t> read(2);
  for (const std::vector<std::uint8_t>& bytes : { std::vector<std::uint8_t>(10, 255), // 70 bits
         { 0, 2 } }) // three equal counts where there are two
  {
    ByteReader reader(bytes);
    EXPECT_FALSE(ReadPackedCounts(reader, read));
  }
}

TEST_F(SpectraFileOnDisk, HasTheSpectraThatWereWritten)
{
  const auto file = Require(SpectraFile::Open(this->Disk, SpectraPath, Identity, 2, 3));
  for (std::size_t array = 0; array < 2; ++array)
  {
    ExpectEqual(file->ReadTotal(array), this->Spectra[array]);
    for (std::size_t store = 0; store < 3; ++store)
    {
      ExpectEqual(file->ReadStore(array, store), this->Spectra[2 + 2 * store + array]);
    }
  }
}

TEST_F(SpectraFileOnDisk, IsCorruptIfAnyBitIsFlipped)
{
  MemoryDisk::Bytes& bytes = this->Disk.GetFile(SpectraPath);
  for (std::size_t position = 0; position < bytes.size(); position += position < 200 ? 1 : 97)
  {
    bytes[position] ^= 1 << (position % 8);
    const Status status = this->ReadAll();
    EXPECT_TRUE(status.GetCode() == StatusCode::Corrupt ||
      (status.GetCode() == StatusCode::Unsupported && position >= 8 && position < 12))
      << position << status.GetMessage();
    EXPECT_EQ(status.GetMessage().find(SpectraPath + ": "), 0u) << status.GetMessage();
    bytes[position] ^= 1 << (position % 8);
  }
  EXPECT_TRUE(this->ReadAll().IsOk());
}

TEST_F(SpectraFileOnDisk, IsCorruptIfItIsTruncatedOrLonger)
{
  MemoryDisk::Bytes& bytes = this->Disk.GetFile(SpectraPath);
  const MemoryDisk::Bytes intact = bytes;
  for (std::size_t size = 0; size < intact.size(); size += size < 200 ? 1 : 997)
  {
    bytes.assign(intact.begin(), intact.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(this->ReadAll().GetCode(), StatusCode::Corrupt) << size;
  }
  bytes = intact;
  bytes.push_back(0);
  EXPECT_EQ(this->ReadAll().GetCode(), StatusCode::Corrupt);
}

TEST_F(SpectraFileOnDisk, OfANewerVersionIsNotRead)
{
  StoreLittleEndian<std::uint32_t>(this->Disk.GetFile(SpectraPath).data() + 8, 2);
  const Status status = this->ReadAll();
  ExpectError(status, StatusCode::Unsupported, "newer version");
}

TEST_F(SpectraFileOnDisk, MustFitTheHeader)
{
  for (const auto& [arrays, stores] :
    { std::pair<std::size_t, std::size_t>{ 1, 3 }, { 2, 2 }, { 3, 2 }, { 2, 1 << 20 } })
  {
    const auto file = SpectraFile::Open(this->Disk, SpectraPath, Identity, arrays, stores);
    EXPECT_EQ(file.GetStatus().GetCode(), StatusCode::Corrupt) << arrays << ' ' << stores;
  }
  EXPECT_EQ(SpectraFile::Open(this->Disk, "/data/none", Identity, 2, 3).GetStatus().GetCode(),
    StatusCode::NotFound);
}

TEST_F(SpectraFileOnDisk, MustBelongToTheTimeStep)
{
  const Status status = SpectraFile::Open(this->Disk, SpectraPath, Identity + 1, 2, 3).GetStatus();
  EXPECT_EQ(status.GetCode(), StatusCode::Corrupt);
  EXPECT_EQ(status.GetMessage(), SpectraPath + ": has the spectra of another time step or volume");
}
