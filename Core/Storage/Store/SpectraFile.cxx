// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Store/SpectraFile.h"

#include "Ground/Base/Checksum.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace isosurface
{
namespace
{

constexpr char Magic[] = "ISOSPECT";
constexpr std::uint32_t FormatVersion = 1;
constexpr std::size_t FixedSize = 32;
constexpr std::size_t ArraySize = 32;
constexpr std::size_t ChecksumSize = 8;
constexpr std::int32_t MaximumExponent = 1100;

void AppendBins(std::vector<std::uint8_t>& bytes, const WorkloadSpectrum& spectrum)
{
  AppendLittleEndian(bytes, spectrum.Bins.First);
  AppendLittleEndian(bytes, spectrum.Bins.Exponent);
  AppendLittleEndian(bytes, spectrum.Bins.Count);
  AppendLittleEndian(bytes, spectrum.AreaUnit);
  AppendLittleEndian(bytes, spectrum.VolumeUnit);
}

/// Reads bins and units; false if they are impossible.
bool ReadBins(ByteReader& reader, WorkloadSpectrum& spectrum)
{
  spectrum.Bins.First = reader.Read<std::int64_t>();
  spectrum.Bins.Exponent = reader.Read<std::int32_t>();
  spectrum.Bins.Count = reader.Read<std::uint32_t>();
  spectrum.AreaUnit = reader.Read<double>();
  spectrum.VolumeUnit = reader.Read<double>();
  constexpr std::int64_t limit = std::numeric_limits<std::int64_t>::max();
  const auto isUnit = [](double unit) { return std::isfinite(unit) && unit >= 0; };
  return spectrum.Bins.First <= limit - SpectrumBins::MaximumCount &&
    spectrum.Bins.Exponent >= -MaximumExponent && spectrum.Bins.Exponent <= MaximumExponent &&
    spectrum.Bins.Count <= SpectrumBins::MaximumCount && isUnit(spectrum.AreaUnit) &&
    isUnit(spectrum.VolumeUnit);
}

} // namespace

void AppendPackedCounts(const std::vector<std::uint64_t>& counts, std::vector<std::uint8_t>& bytes)
{
  std::uint64_t before = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    const std::uint64_t difference = counts[index] - before;
    before = counts[index++];
    AppendSignedVarint(bytes, static_cast<std::int64_t>(difference));
    if (difference == 0)
    {
      const std::size_t first = index;
      while (index < counts.size() && counts[index] == before)
      {
        ++index;
      }
      AppendVarint(bytes, index - first);
    }
  }
}

bool ReadPackedCounts(ByteReader& reader, std::vector<std::uint64_t>& counts)
{
  std::uint64_t count = 0;
  for (std::size_t index = 0; index < counts.size();)
  {
    const std::int64_t difference = reader.ReadSignedVarint();
    if (reader.HasFailed())
    {
      return false;
    }
    count += static_cast<std::uint64_t>(difference);
    counts[index++] = count;
    if (difference == 0)
    {
      auto more = reader.ReadVarint();
      if (reader.HasFailed() || more > counts.size() - index)
      {
        return false;
      }
      for (; more > 0; --more)
      {
        counts[index++] = count;
      }
    }
  }
  return true;
}

SpectraFile::Section SpectraFile::Pack(const WorkloadSpectrum& spectrum)
{
  Section section;
  for (const WorkloadSpectrum::Counts* counts : spectrum.GetQuantities())
  {
    AppendPackedCounts(*counts, section);
  }
  return section;
}

Status SpectraFile::Write(FileSystem& files, const std::string& path, std::uint64_t identity,
  const std::vector<WorkloadSpectrum>& totals, const std::vector<Section>& stores)
{
  std::vector<std::uint8_t> header(Magic, Magic + 8);
  AppendLittleEndian(header, FormatVersion);
  AppendLittleEndian(header, static_cast<std::uint32_t>(totals.size()));
  AppendLittleEndian(header, static_cast<std::uint64_t>(stores.size() / totals.size()));
  AppendLittleEndian(header, identity);
  std::vector<Section> packedTotals;
  std::vector<const Section*> sections;
  for (const WorkloadSpectrum& total : totals)
  {
    AppendBins(header, total);
    packedTotals.push_back(Pack(total));
  }
  const std::vector<Section>* const lists[] = { &packedTotals, &stores };
  for (const std::vector<Section>* list : lists)
  {
    for (const Section& section : *list)
    {
      sections.push_back(&section);
    }
  }
  std::uint64_t end = header.size() + sections.size() * sizeof(end) + ChecksumSize;
  for (const Section* section : sections)
  {
    end += ChecksumSize + section->size();
    AppendLittleEndian(header, end);
  }
  AppendLittleEndian(header, ComputeChecksum(header.data(), header.size()));

  ISOSURFACE_ASSIGN_OR_RETURN(auto file, files.CreateForWriting(path));
  ISOSURFACE_RETURN_IF_ERROR(file->Append(header.data(), header.size()));
  for (std::size_t index = 0; index < sections.size(); ++index)
  {
    const Section& section = *sections[index];
    std::uint8_t checksum[ChecksumSize];
    StoreLittleEndian(checksum, ComputeChecksum(section.data(), section.size(), index));
    ISOSURFACE_RETURN_IF_ERROR(file->Append(checksum, sizeof(checksum)));
    ISOSURFACE_RETURN_IF_ERROR(file->Append(section.data(), section.size()));
  }
  return file->SyncAndClose();
}

Result<std::unique_ptr<SpectraFile>> SpectraFile::Open(FileSystem& files, const std::string& path,
  std::uint64_t identity, std::size_t variables, std::size_t stores)
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto opened, files.OpenForReading(path));
  const RandomAccessFile& file = *opened;
  std::unique_ptr<SpectraFile> spectra(new SpectraFile(files, path));
  const auto fail = [&](StatusCode code, const char* reason)
  { return spectra->Fail(code, reason); };
  std::uint8_t fixed[FixedSize];
  ISOSURFACE_RETURN_IF_ERROR(file.Read(0, sizeof(fixed), fixed));
  if (std::memcmp(fixed, Magic, 8) != 0)
  {
    return fail(StatusCode::Corrupt, "is not a file of spectra");
  }
  if (LoadLittleEndian<std::uint32_t>(fixed + 8) > FormatVersion)
  {
    return fail(StatusCode::Unsupported, "was written by a newer version; please update");
  }
  if (LoadLittleEndian<std::uint32_t>(fixed + 8) != FormatVersion ||
    LoadLittleEndian<std::uint32_t>(fixed + 12) != variables ||
    LoadLittleEndian<std::uint64_t>(fixed + 16) != stores)
  {
    return fail(StatusCode::Corrupt, "does not fit the volume's header");
  }
  const std::size_t size = FixedSize + variables * ArraySize +
    (stores + 1) * variables * sizeof(std::uint64_t) + ChecksumSize;
  if (size > file.GetSize())
  {
    return fail(StatusCode::Corrupt, "is truncated");
  }
  std::vector<std::uint8_t> header(size);
  ISOSURFACE_RETURN_IF_ERROR(file.Read(0, size, header.data()));
  spectra->Empty.resize(variables);
  ISOSURFACE_RETURN_IF_ERROR(spectra->ParseHeader(header, file.GetSize()));
  if (LoadLittleEndian<std::uint64_t>(header.data() + 24) != identity)
  {
    return fail(StatusCode::Corrupt, "has the spectra of another time step or volume");
  }
  return spectra;
}

Status SpectraFile::ParseHeader(const std::vector<std::uint8_t>& header, std::uint64_t fileSize)
{
  const std::size_t covered = header.size() - ChecksumSize;
  if (LoadLittleEndian<std::uint64_t>(header.data() + covered) !=
    ComputeChecksum(header.data(), covered))
  {
    return this->Fail(StatusCode::Corrupt, "has a wrong checksum");
  }
  ByteReader reader(header.data() + FixedSize, covered - FixedSize);
  for (WorkloadSpectrum& spectrum : this->Empty)
  {
    if (!ReadBins(reader, spectrum))
    {
      return this->Fail(StatusCode::Corrupt, "has impossible bins");
    }
  }
  this->Ends.push_back(header.size());
  while (reader.GetRemaining() > 0)
  {
    const auto end = reader.Read<std::uint64_t>();
    if (end > fileSize || end < this->Ends.back() || end - this->Ends.back() < ChecksumSize)
    {
      return this->Fail(StatusCode::Corrupt, "is truncated, or has impossible sections");
    }
    this->Ends.push_back(end);
  }
  return this->Ends.back() == fileSize
    ? Status::Ok()
    : this->Fail(StatusCode::Corrupt, "has bytes after its last section");
}

Result<WorkloadSpectrum> SpectraFile::Read(std::size_t variable, std::size_t section) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(const auto file, this->Files.OpenForReading(this->Path));
  const std::uint64_t begin = this->Ends[section];
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(this->Ends[section + 1] - begin));
  ISOSURFACE_RETURN_IF_ERROR(file->Read(begin, bytes.size(), bytes.data()));
  if (LoadLittleEndian<std::uint64_t>(bytes.data()) !=
    ComputeChecksum(bytes.data() + ChecksumSize, bytes.size() - ChecksumSize, section))
  {
    return this->Fail(
      StatusCode::Corrupt, "section " + std::to_string(section) + " has a wrong checksum");
  }
  WorkloadSpectrum spectrum(this->Empty[variable].Bins);
  spectrum.AreaUnit = this->Empty[variable].AreaUnit;
  spectrum.VolumeUnit = this->Empty[variable].VolumeUnit;
  ByteReader reader(bytes.data() + ChecksumSize, bytes.size() - ChecksumSize);
  bool isGood = true;
  for (WorkloadSpectrum::Counts* counts : spectrum.GetQuantities())
  {
    isGood = isGood && ReadPackedCounts(reader, *counts);
  }
  if (!isGood || reader.GetRemaining() != 0)
  {
    return this->Fail(
      StatusCode::Corrupt, "section " + std::to_string(section) + " has impossible counts");
  }
  return spectrum;
}

std::string VolumeSpectra::GetPath(
  FileSystem& files, const std::string& volumePath, const std::string& generation)
{
  return GetStoresFolder(files, volumePath) + "/" + generation + "/spectra";
}

std::uint64_t VolumeSpectra::GetIdentity(const TimeStepDescription& step)
{
  std::vector<std::uint8_t> checksums;
  for (const StoreDescription& store : step.Stores)
  {
    AppendLittleEndian(checksums, store.Checksum);
  }
  return ComputeChecksum(checksums.data(), checksums.size());
}

VolumeSpectra::Spectrum VolumeSpectra::Share(WorkloadSpectrum&& spectrum) const
{
  spectrum.AreaUnit *= this->Scale.Area;
  spectrum.VolumeUnit *= this->Scale.Volume;
  if (this->Scale.Area == 0)
  {
    spectrum.Area.clear();
  }
  return std::make_shared<const WorkloadSpectrum>(std::move(spectrum));
}

Result<std::shared_ptr<const VolumeSpectra>> VolumeSpectra::Read(FileSystem& files,
  const std::string& volumePath, const TimeStepDescription& step, std::size_t variables,
  const GridScale& scale)
{
  auto result = std::make_shared<VolumeSpectra>();
  result->Scale = scale;
  ISOSURFACE_ASSIGN_OR_RETURN(result->File,
    SpectraFile::Open(files, GetPath(files, volumePath, step.Folder), GetIdentity(step), variables,
      step.Stores.size()));
  for (std::size_t variable = 0; variable < variables; ++variable)
  {
    ISOSURFACE_ASSIGN_OR_RETURN(auto total, result->File->ReadTotal(variable));
    result->Totals.push_back(result->Share(std::move(total)));
  }
  return std::shared_ptr<const VolumeSpectra>(std::move(result));
}

Result<VolumeSpectra::Spectrum> VolumeSpectra::GetStore(
  std::size_t variable, std::size_t store) const
{
  ISOSURFACE_ASSIGN_OR_RETURN(auto spectrum, this->File->ReadStore(variable, store));
  return this->Share(std::move(spectrum));
}

} // namespace isosurface
