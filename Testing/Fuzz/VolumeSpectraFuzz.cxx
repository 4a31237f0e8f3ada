// SPDX-License-Identifier: BSD-3-Clause
// Input: a file of spectra. It is read as it is and with correct checksums, for the numbers of
// arrays and stores that it states.
#include "FuzzTarget.h"
#include "SealedBytes.h"

#include "Ground/Base/Checksum.h"
#include "Ground/Base/Coding.h"
#include "Storage/Store/BlockedVolumeHeader.h"
#include "Storage/Store/SpectraFile.h"

#include <algorithm>
#include <string>

using namespace isosurface;

namespace
{

const std::string Path = "/data/.volume.bvol.stores/000001/spectra";

void Use(const WorkloadSpectrum& spectrum)
{
  Require(spectrum.Bins.Count <= SpectrumBins::MaximumCount, "there are not too many bins");
  for (const WorkloadSpectrum::Counts* counts : spectrum.GetQuantities())
  {
    Require(counts->size() == spectrum.Bins.Count, "a spectrum has as many counts as bins");
  }
  for (const double isovalue : { -1e300, -1.0, 0.0, 17.25, 1e300 })
  {
    Require(spectrum.FindBin(isovalue) < std::max(spectrum.Bins.Count, 1u), "a bin is there");
  }
  WorkloadSpectrum sum = spectrum;
  Require(sum.Add(spectrum), "spectra of equal bins can be added");
}

void ReadAndUse(const SealedBytes& file, std::size_t arrays, std::size_t stores)
{
  MemoryDisk disk;
  PutFile(disk, Path, file);
  // A section of few bytes may have many equal counts.
  const MemoryLimit limit(64 * file.size() + std::size_t{ 256 } * 1024 * (arrays + 1));
  TimeStepDescription step;
  step.Folder = "000001";
  step.Stores.resize(stores);
  const auto spectra = VolumeSpectra::Read(disk, "/data/volume.bvol", step, arrays);
  if (!spectra.IsOk())
  {
    Require(spectra.GetStatus().GetMessage().find(Path) == 0, "an error names the file");
    return;
  }
  for (std::size_t array = 0; array < arrays; ++array)
  {
    Use(*(*spectra)->GetTotal(array));
    for (std::size_t store = 0; store < std::min<std::size_t>(stores, 3); ++store)
    {
      const auto spectrum = (*spectra)->GetStore(array, store);
      if (spectrum.IsOk())
      {
        Use(**spectrum);
      }
    }
  }
}

/// With the checksums of what is there of header and sections.
SealedBytes SealSections(SealedBytes bytes, std::size_t arrays, std::size_t stores)
{
  const std::size_t table = 32 + 32 * arrays;
  const std::size_t sections = arrays * (stores + 1);
  const std::size_t header = table + 8 * sections;
  if (bytes.size() < header + 8)
  {
    return bytes;
  }
  TimeStepDescription step;
  step.Stores.resize(stores);
  StoreLittleEndian(bytes.data() + 24, VolumeSpectra::GetIdentity(step));
  StoreLittleEndian(bytes.data() + header, ComputeChecksum(bytes.data(), header));
  std::uint64_t begin = header + 8;
  for (std::size_t section = 0; section < sections; ++section)
  {
    const auto end = LoadLittleEndian<std::uint64_t>(bytes.data() + table + 8 * section);
    if (end > bytes.size() || end < begin || end - begin < 8)
    {
      break;
    }
    StoreLittleEndian(bytes.data() + begin,
      ComputeChecksum(
        bytes.data() + begin + 8, static_cast<std::size_t>(end - begin - 8), section));
    begin = end;
  }
  return bytes;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size)
{
  std::size_t arrays = 1;
  std::size_t stores = 1;
  if (size >= 24)
  {
    // Not more than there is a table for.
    arrays = std::max<std::size_t>(
      1, std::min<std::size_t>(LoadLittleEndian<std::uint32_t>(bytes + 12), size / 48));
    stores = std::max<std::size_t>(1,
      static_cast<std::size_t>(
        std::min<std::uint64_t>(LoadLittleEndian<std::uint64_t>(bytes + 16), size / 8)));
  }
  const SealedBytes file(bytes, bytes + size);
  ReadAndUse(file, arrays, stores);
  ReadAndUse(SealSections(file, arrays, stores), arrays, stores);
  return 0;
}
